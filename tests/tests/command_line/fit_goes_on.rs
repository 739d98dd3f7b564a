//! `palpate fit` from a scene to a press: killed and restarted, refused, and the report of a press
//! on the patch.

use std::process::{Command, Stdio};
use std::time::Duration;

use palpate_tests::cube_mesh::cube;
use palpate_tests::palpate_command::{Desk, binary, palpate, repository};
use palpate_tests::press_run::{SMALL_BLOCK, edited};
use serde_json::Value;

use crate::bad_input_says_what_where_how::refused;

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");
const FIT: [&str; 9] = ["fit", "--scene", "scene.toml", "--out", "out", "--quick", "--places", "20", "--tolerance-pct=30"];

/// Scene of the small block with a coarse mesh and some edits.
fn scene(edits: &[(&str, &str)]) -> String {
    let coarse = edited(SMALL_BLOCK, "nodes = 129", "nodes = 60");
    edits.iter().fold(coarse, |text, (from, to)| edited(&text, from, to))
}

fn json(desk: &Desk, file: &str) -> Value {
    serde_json::from_slice(&std::fs::read(desk.folder().join(file)).unwrap()).unwrap()
}

fn press_notes(desk: &Desk) -> usize {
    let notes = std::fs::read_dir(desk.folder().join(".out.notes")).into_iter().flatten().flatten();
    notes.filter(|entry| entry.file_name().to_string_lossy().starts_with("press-")).count()
}

#[test]
fn a_fit_that_was_killed_goes_on_and_its_patch_is_pressed() {
    let desk = Desk::default();
    desk.put("scene.toml", scene(&[]));
    let mut command = Command::new(binary(SCRATCH));
    command.args(FIT).current_dir(desk.folder()).stdout(Stdio::null()).stderr(Stdio::null());
    let mut run = command.spawn().expect("palpate was built");
    while press_notes(&desk) < 3 {
        assert!(run.try_wait().unwrap().is_none(), "it ended before it noted a press");
        std::thread::sleep(Duration::from_millis(2));
    }
    run.kill().expect("SIGKILL");
    run.wait().expect("it ended");
    let noted = press_notes(&desk);
    assert!(!desk.folder().join("out").exists());

    let again = palpate(SCRATCH, desk.folder(), &FIT);
    assert_eq!(again.code, Some(0), "{again:?}");
    let summary = json(&desk, "out/summary.json");
    assert!(summary["reused_presses"].as_u64().unwrap() >= noted as u64, "{noted} noted, {}", summary["reused_presses"]);
    // beside the results is a folder with the solved glued discs, which another fit of the scene
    // reuses
    let listing: Vec<String> = [".solved", "out", "scene.toml"].map(String::from).into();
    assert_eq!((desk.listing(), summary["reused_fit"].as_bool()), (listing, Some(false)));
    let patch = std::fs::read(desk.folder().join("out/small-60.patch")).unwrap();

    // all results are reused, and the patch equals that of an uninterrupted run
    let third = palpate(SCRATCH, desk.folder(), &FIT);
    assert_eq!(third.code, Some(0), "{third:?}");
    let summary = json(&desk, "out/summary.json");
    assert_eq!((summary["reused_presses"].as_u64(), summary["reused_fit"].as_bool()), (Some(14), Some(true)));
    assert!(patch == std::fs::read(desk.folder().join("out/small-60.patch")).unwrap());
    // tissue that stiffens is fitted without its exponent, which a press adds
    desk.put("scene.toml", scene(&[("nodes = 60", "nodes = 60\nstiffening_b = 3.0")]));
    let stiffens = palpate(SCRATCH, desk.folder(), &FIT);
    assert_eq!(stiffens.code, Some(0), "{stiffens:?}");
    assert!(stiffens.stdout.contains("note: tissue.stiffening_b = 3 is left out of the fit"), "{stiffens:?}");
    assert!(patch == std::fs::read(desk.folder().join("out/small-60.patch")).unwrap());
    desk.put("scene.toml", scene(&[]));
    let (calibrated, before) = (&summary["calibrated"], &summary["uncalibrated"]);
    let rms = |verdict: &Value| verdict["unseen_rms_pct"].as_f64().unwrap();
    assert!(rms(calibrated) < rms(before), "{} % after, {} % before", rms(calibrated), rms(before));
    // a fit without the glued discs has larger errors for them than an unfitted patch
    let glued = |verdict: &Value| verdict["glued"]["rms_pct"].as_f64().unwrap();
    assert!(glued(calibrated) < 0.8 * glued(before), "{} % after, {} % before", glued(calibrated), glued(before));
    let surfaces = calibrated["surfaces"].as_array().unwrap();
    let depth_mm: Vec<f64> = surfaces.iter().map(|s| s["depth_mm"].as_f64().unwrap()).collect();
    assert!(depth_mm.len() == 5 && depth_mm.is_sorted(), "{depth_mm:?}");
    // much less than the depth of the dent itself
    assert!(surfaces.iter().all(|s| s["mean_mm"].as_f64().unwrap() < 0.1 * s["depth_mm"].as_f64().unwrap()), "{surfaces:?}");

    // a press reports the conditions of the fit; for another tip it reports that there was no such
    // fit
    let press = |scene: &str| {
        desk.put("press.toml", format!("{scene}[solver]\npatch = \"out/small-60.patch\"\n"));
        let outcome = palpate(SCRATCH, desk.folder(), &["press", "--scene", "press.toml", "--out", "press"]);
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        (outcome.stdout, json(&desk, "press/summary.json"))
    };
    let (said, summary) = press(&scene(&[]));
    assert!(said.contains("calibrated to finite elements over 20 places of this scene"), "{said}");
    assert_eq!((summary["model"]["standing"].as_str(), summary["calibrated"].as_bool()), (Some("calibrated"), Some(true)));
    let judged = &summary["model"]["record"]["judged"];
    assert!(judged["rms_pct"].as_f64().unwrap() >= rms(calibrated));
    assert_eq!(judged["glued"]["rms_pct"].as_f64(), Some(glued(calibrated)));
    assert!(said.contains("; glued discs ") && said.contains("; the surface "), "{said}");
    let (said, summary) = press(&scene(&[("radius_m = 0.008", "radius_m = 0.007")]));
    assert!(said.contains("calibrated for another tip (hemisphere R 8 mm)"), "{said}");
    assert_eq!(summary["calibrated"].as_bool(), Some(false));
    // a record of an earlier form opens; one that cannot be read is refused, since without it the
    // patch would press as one that was never fitted
    let record = json(&desk, "out/small-60.patch.json");
    let mut earlier = record.clone();
    earlier["judged"]["lost_places"] = 3.into();
    desk.put("out/small-60.patch.json", earlier.to_string());
    assert_eq!(press(&scene(&[])).1["calibrated"].as_bool(), Some(true));
    desk.put("out/small-60.patch.json", record.to_string().replace("fitted_places", "places"));
    let refused = palpate(SCRATCH, desk.folder(), &["press", "--scene", "press.toml", "--out", "press"]);
    assert!(refused.code == Some(2) && refused.stderr.contains("(.patch.json) cannot be read (unknown field"), "{refused:?}");
    std::fs::remove_file(desk.folder().join("out/small-60.patch.json")).unwrap();
    let (said, summary) = press(&scene(&[]));
    assert!(said.contains("its record (.patch.json) is not beside it") && summary["calibrated"] == false, "{said}");
}

/// With inclusions the fit's second stage takes as long as its first.
#[test]
#[ignore = "long: finite elements with inclusions and without"]
fn inclusions_are_fitted_by_what_they_add_and_belong_to_the_patch() {
    let desk = Desk::default();
    let ball = |x: &str, z: &str| {
        format!("[[tissue.inclusion]]\ncenter_m = [{x}, 0.0, {z}]\nradius_m = 0.006\nstiffness_ratio = 10.0\n[probe]")
    };
    desk.put("scene.toml", scene(&[("[probe]", &ball("0.002", "-0.011"))]));
    let first = palpate(SCRATCH, desk.folder(), &FIT);
    assert_eq!(first.code, Some(0), "{first:?}");
    assert!(first.stdout.contains("force that the inclusions add, at 12 places unknown to the fit"), "{}", first.stdout);
    let of_first = json(&desk, "out/summary.json");
    let rms = |which: &str| of_first["bump"][which]["rms_pct"].as_f64().unwrap();
    // errors relative to the highest bump, against finite elements at places that no fit used
    assert!(rms("fitted") < 0.6 * rms("scaled_in"), "{} after, {} before", rms("fitted"), rms("scaled_in"));
    assert!(desk.folder().join("out/bump.png").exists());

    // the results of both stages are reused
    let again = palpate(SCRATCH, desk.folder(), &FIT);
    assert_eq!(again.code, Some(0), "{again:?}");
    let of_again = json(&desk, "out/summary.json");
    assert_eq!(of_again["reused_fit"].as_bool(), Some(true));
    assert_eq!(of_again["bump"], of_first["bump"]);

    let press = |edits: &[(&str, &str)]| {
        desk.put("press.toml", format!("{}[solver]\npatch = \"out/small-60.patch\"\n", scene(edits)));
        palpate(SCRATCH, desk.folder(), &["press", "--scene", "press.toml", "--out", "press"])
    };
    let own = press(&[("[probe]", &ball("0.002", "-0.011"))]);
    assert_eq!(own.code, Some(0), "{own:?}");
    assert!(own.stdout.contains("of this scene") && own.stdout.contains("the force that its inclusions add"), "{}", own.stdout);
    // the inclusions are not applied twice: the press is as stiff as the evaluated patch
    let hold = json(&desk, "press/summary.json")["holds"][2]["force_n"].as_f64().unwrap();
    let wanted = of_first["record"]["judged"]["worst_pct"].as_f64().unwrap().abs();
    let answer = json(&desk, "out/answer.json");
    let centred = answer["holds"].as_array().unwrap().iter().find(|h| h["depth_m"] == 0.004).unwrap();
    let elements = 3500.0 * centred["force_over_e_m2"].as_f64().unwrap();
    assert!((100.0 * (hold / elements - 1.0)).abs() < wanted + 1.0, "{hold} {elements} {wanted}");
    for edits in [&[("[probe]", &*ball("0.004", "-0.011"))][..], &[]] {
        let other = press(edits);
        let says = ["tissue.inclusion", "is not what", "0.006 m, 10 times"];
        assert!(other.code == Some(2) && says.iter().all(|part| other.stderr.contains(part)), "{other:?}");
    }

    let hardly = edited(&ball("0.0", "-0.02"), "stiffness_ratio = 10.0", "stiffness_ratio = 1.01");
    desk.put("scene.toml", scene(&[("[probe]", &hardly)]));
    let outcome = palpate(SCRATCH, desk.folder(), &FIT);
    let says = ["tissue.inclusion", "adds at most 0.", "leave it out"];
    assert!(outcome.code == Some(2) && says.iter().all(|part| outcome.stderr.contains(part)), "{outcome:?}");
}

/// The finite elements of a whole organ take a minute.
#[test]
#[ignore = "long: finite elements of a whole organ"]
fn a_piece_of_an_organ_is_fitted_and_pressed_from_its_own_scene() {
    let desk = Desk::default();
    let organ = std::fs::read_to_string(repository().join("host-sim/scenes/organ-liver.toml")).unwrap();
    desk.put("scene.toml", organ.clone());
    let fit =
        ["fit", "--scene", "scene.toml", "--out", "out", "--quick", "--nodes", "60", "--places", "80", "--tolerance-pct=30"];
    let first = palpate(SCRATCH, desk.folder(), &fit);
    assert_eq!(first.code, Some(0), "{first:?}");
    let of_first = json(&desk, "out/summary.json");
    let rms = |verdict: &str| of_first[verdict]["unseen_rms_pct"].as_f64().unwrap();
    assert!(rms("calibrated") < rms("uncalibrated"), "{} {}", rms("calibrated"), rms("uncalibrated"));
    let nodes = of_first["nodes"].as_u64().unwrap();
    assert!((45..=75).contains(&nodes), "{nodes}");

    // nothing is solved a second time
    let again = palpate(SCRATCH, desk.folder(), &fit);
    assert_eq!(again.code, Some(0), "{again:?}");
    let of_again = json(&desk, "out/summary.json");
    assert_eq!((of_again["reused_presses"].as_u64(), of_again["reused_fit"].as_bool()), (Some(14), Some(true)));
    assert_eq!(of_again["calibrated"], of_first["calibrated"]);

    let patch = format!("out/organ-liver-{nodes}.patch");
    let press = |from: &str, to: &str| {
        desk.put("press.toml", format!("{}\n[solver]\npatch = \"{patch}\"\n", edited(&organ, from, to)));
        palpate(SCRATCH, desk.folder(), &["press", "--scene", "press.toml", "--out", "press"])
    };
    let own = press("liver", "liver");
    assert_eq!(own.code, Some(0), "{own:?}");
    assert!(own.stdout.contains("calibrated to finite elements over 80 places of this scene"), "{}", own.stdout);
    let elsewhere = press("0.0, 0.044, 0.046", "0.01, 0.044, 0.046");
    assert!(elsewhere.code == Some(2) && elsewhere.stderr.contains("probe.site"), "{elsewhere:?}");
    let of_another = press("organ = \"liver\"", "organ = \"gallbladder\"");
    assert!(of_another.code == Some(2) && of_another.stderr.contains("tissue.organ"), "{of_another:?}");
}

#[test]
fn scenes_that_no_fit_can_be_made_of() {
    let desk = Desk::default();
    let fit = |edits: &[(&str, &str)], says: &[&str]| {
        desk.put("scene.toml", scene(edits));
        refused(&desk, &FIT, &[&["scene.toml: "], says].concat());
    };
    fit(&[("poisson_ratio = 0.45", "poisson_ratio = 0.5")], &["poisson_ratio", "0.5", "outside"]);
    fit(&[("poisson_ratio = 0.45", "poisson_ratio = 0.498")], &["tissue.poisson_ratio = 0.498", "at most that"]);
    fit(&[("radius_m = 0.008", "radius_m = 0.03")], &["probe.radius_m = 0.03", "third of the block", "0.0133 m"]);
    fit(&[("3500.0", "3.5")], &["tissue.youngs_modulus_pa = 3.5", "give pascals", "3.5 kPa is 3500"]);
    fit(&[("0.004]", "0.025]")], &["drive.holds_m[2] = 0.025", "half the block is thick", "press less deep"]);
    fit(&[("3500.0", "3.5e6")], &["drive.holds_m[0] = 0.001", "the guard lets 12 N through"]);
    fit(&[("position_m = [0.0, 0.0]", "position_m = [0.01, 0.0]")], &["probe.position_m", "leave it out"]);
    fit(&[("nodes = 60", "nodes = 60\ngravity_m_per_s2 = [0.0, 0.0, -9.8]")], &["tissue.gravity_m_per_s2", "leave it out"]);
    desk.put("scene.toml", scene(&[]));
    let with = |option: &'static str| ["fit", "--scene", "scene.toml", "--out", "out", option];
    refused(&desk, &with("--places=3"), &["--places 3", "20 to 2000"]);
    refused(&desk, &with("--tolerance-pct=0"), &["--tolerance-pct 0", "above 0"]);
    refused(&desk, &with("--points=10"), &["--points 10", "4, 9 or 16"]);
    refused(&desk, &with("--nodes=7"), &["nodes", "7"]);
    refused(&desk, &with("--radius-m=0.005"), &["a patch of 0.005 m", "give a radius"]);
    let organ = |option: &'static str| ["fit", "--scene", "organ-liver", "--out", "out", option];
    refused(&desk, &organ("--radius-m=0.005"), &["organ-liver: a patch of 0.005 m", "give a radius"]);
    refused(&desk, &organ("--nodes=3"), &["--nodes 3", "at the nearest", "--radius"]);
    // a mesh file determines its number of nodes, while a piece cut out of it has the number
    // requested
    desk.put("box.msh", cube(10, 0.08));
    let mesh = edited(SMALL_BLOCK, "block_m = [0.08, 0.08, 0.04]", "mesh = \"box.msh\"\nlength_unit = \"m\"");
    let mesh = edited(&edited(&mesh, "nodes = 129\n", ""), "position_m = [0.0, 0.0]", "site = [0.04, 0.04, 0.08]");
    desk.put("scene.toml", mesh);
    refused(&desk, &with("--nodes=3"), &["--nodes 3", "at the nearest", "--radius"]);
}

/// The shipped patches have records of their fits; for a scene without a patch of its own, the
/// error of a trial is reported.
#[test]
fn a_press_never_claims_a_fit_that_was_for_another_scene() {
    let desk = Desk::default();
    let press = |scene: &str| {
        desk.put("press.toml", scene);
        let outcome = palpate(SCRATCH, desk.folder(), &["press", "--scene", "press.toml", "--out", "press"]);
        assert_eq!(outcome.code, Some(0), "{outcome:?}");
        (outcome.stdout, json(&desk, "press/summary.json")["model"].clone())
    };
    let shipped = edited(SMALL_BLOCK, "nodes = 129", "nodes = 130");
    let (said, model) = press(&shipped);
    assert!(said.contains("over 300 places of this scene") && model["standing"] == "calibrated", "{said}{model}");
    let nodule = "[[tissue.inclusion]]\ncenter_m = [0.0, 0.0, -0.012]\nradius_m = 0.006\nstiffness_ratio = 10.0\n[probe]";
    let (said, model) = press(&edited(&shipped, "[probe]", nodule));
    assert!(said.contains("calibrated without its inclusions"), "{said}");
    assert_eq!(model["standing"], "calibrated-for-another");
    let (said, model) = press(&edited(&shipped, "poisson_ratio = 0.45", "poisson_ratio = 0.3"));
    assert!(said.contains("uncalibrated") && said.contains("trial nu") && said.contains("palpate fit"), "{said}");
    assert_eq!(model["standing"], "uncalibrated");
    let path = repository().join("host-sim/patches/block-130.patch");
    let other = edited(&shipped, "radius_m = 0.008", "radius_m = 0.005");
    let (said, model) = press(&format!("{other}[solver]\npatch = \"{}\"\n", path.display()));
    assert!(said.contains("calibrated for another tip (hemisphere R 8 mm): at most"), "{said}");
    assert_eq!(model["standing"], "calibrated-for-another");
}
