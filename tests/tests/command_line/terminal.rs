//! Output on a terminal and in a pipe: the verdict comes first and last; failures only; scenes to
//! start from; changed keys; completions.

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use palpate_tests::palpate_command::{Desk, Outcome, binary, palpate, repository};
use palpate_tests::press_run::{SMALL_BLOCK, edited, press, press_at, small_block};

use crate::bad_input_says_what_where_how::refused;

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");

fn run(desk: &Desk, code: i32, arguments: &[&str]) -> Outcome {
    let outcome = palpate(SCRATCH, desk.folder(), arguments);
    assert_eq!(outcome.code, Some(code), "{arguments:?}: {outcome:?}");
    outcome
}

#[test]
fn a_reader_that_goes_ends_neither_the_run_nor_its_result() {
    let desk = Desk::default();
    desk.put("scene.toml", SMALL_BLOCK);
    // the output is read to its end, up to its first line, or not at all
    for lines in [usize::MAX, 1, 0] {
        let mut child = Command::new(binary(SCRATCH))
            .args(["press", "--scene", "scene.toml", "--out", "out"])
            .current_dir(desk.folder())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let mut reader = BufReader::new(child.stdout.take().unwrap());
        let _read: Vec<String> = std::io::Read::by_ref(&mut reader).lines().take(lines).map_while(Result::ok).collect();
        drop(reader);
        let ended = child.wait_with_output().unwrap();
        assert_eq!((ended.status.code(), String::from_utf8_lossy(&ended.stderr).as_ref()), (Some(0), ""), "{lines} lines");
        assert!(desk.folder().join("out/summary.json").is_file());
        std::fs::remove_dir_all(desk.folder().join("out")).unwrap();
    }
}

#[cfg(unix)]
#[test]
fn a_full_disk_under_the_output_is_one_line_and_the_result_is_there() {
    let desk = Desk::default();
    desk.put("scene.toml", SMALL_BLOCK);
    let mut press = Command::new(binary(SCRATCH));
    press.args(["press", "--scene", "scene.toml", "--out", "out"]).current_dir(desk.folder());
    let full = std::fs::File::options().write(true).open("/dev/full").unwrap();
    let ended = press.stdout(full).output().unwrap();
    let why = String::from_utf8_lossy(&ended.stderr);
    assert!(ended.status.code() == Some(2) && why.lines().count() == 1 && why.contains("free some space"), "{why}");
    assert!(desk.folder().join("out/summary.json").is_file());
}

#[test]
fn the_verdict_is_the_first_and_the_last_line() {
    let desk = Desk::default();
    desk.put("scene.toml", SMALL_BLOCK);
    let said = run(&desk, 0, &["press", "--scene", "scene.toml"]).stdout;
    let (first, last) = (said.lines().next().unwrap(), said.lines().next_back().unwrap());
    assert!(first == last && first.starts_with("ok: ") && first.contains("slowest tick"), "{said}");

    // slips of a unit: tissue of 3.5 Pa, which has not come to rest when its force is read, and of
    // 1.06 kg/m^3
    for (set, says) in [
        ("tissue.youngs_modulus_pa=3.5", ["take pascals", " % off finite elements"]),
        ("tissue.density_kg_per_m3=1.06", ["takes kilograms per cubic metre", "1.06 g/cm^3 is 1060"]),
    ] {
        let slip = run(&desk, 0, &["press", "--set", set, "--out", "slip"]).stdout;
        let (first, last) = (slip.lines().next().unwrap(), slip.lines().next_back().unwrap());
        assert!(first == last && first.starts_with("warning: ") && says.iter().all(|says| first.contains(says)), "{slip}");
    }
    let heavy = run(&desk, 0, &["loop", "--quick", "--hand", "H1", "--stimulus", "S2", "--set", "tissue.density_kg_per_m3=1.06"]);
    assert!(heavy.stdout.starts_with("warning: "), "{heavy:?}");

    // half of the force can be held: the check fails, and both streams say so
    let force = edited(
        SMALL_BLOCK,
        "kind = \"depth\"\nholds_m = [0.001, 0.002, 0.004]\nramp_m_per_s = 0.04\nhold_s = 0.3",
        "kind = \"force\"\nholds_n = [3.0]\nramp_m_per_s = 0.04\nhold_s = 0.01",
    );
    desk.put("hasty.toml", force);
    let outcome = run(&desk, 1, &["press", "--scene", "hasty.toml", "--out", "hasty"]);
    let (first, last) = (outcome.stdout.lines().next().unwrap(), outcome.stdout.lines().next_back().unwrap());
    assert!(first == last && first.starts_with("failed: "), "{outcome:?}");
    let why = first.strip_prefix("failed: ").unwrap();
    assert_eq!(outcome.stderr.trim_end(), format!("palpate: check failed: {why}"));

    let said = run(&desk, 0, &["loop", "--quick", "--hand", "H1", "--stimulus", "S2"]).stdout;
    let (first, last) = (said.lines().next().unwrap(), said.lines().next_back().unwrap());
    assert!(first == last && first.starts_with("ok: "), "{said}");
}

#[test]
fn rows_that_passed_are_printed_when_they_are_asked_for() {
    let desk = Desk::default();
    let one = ["loop", "--wall", "400", "--quick", "--hand", "H1", "--stimulus", "S9"];
    let all = run(&desk, 0, &[&one[..], &["--all"]].concat()).stdout;
    assert!(all.contains("S9 random motion") && all.contains("H1 light fingertip"), "{all}");
}

#[test]
fn a_scene_is_printed_to_start_from() {
    let desk = Desk::default();
    let list = run(&desk, 0, &["scene"]).stdout;
    assert!(["block", "nodule", "organ-liver"].iter().all(|name| list.lines().any(|line| line.starts_with(name))), "{list}");
    let printed = run(&desk, 0, &["scene", "nodule"]).stdout;
    let file = std::fs::read_to_string(repository().join("host-sim/scenes/nodule.toml")).unwrap();
    assert_eq!(printed, file);
    let changed = run(&desk, 0, &["scene", "block", "--set", "tissue.nodes=60", "--set", "name=mine"]).stdout;
    desk.put("mine.toml", &changed);
    let again = run(&desk, 0, &["scene", "mine.toml"]).stdout;
    assert!(again == changed && changed.contains("nodes = 60") && changed.contains("name = \"mine\""), "{changed}");
    refused(&desk, &["scene", "nodul"], &["no scene \"nodul\"", "did you mean \"nodule\"?"]);
}

#[test]
fn a_changed_key_acts_and_a_mistyped_one_names_the_nearest() {
    let as_file = press(SCRATCH, &edited(SMALL_BLOCK, "3500.0", "7000.0"));
    let as_set = press_at(SCRATCH, Desk::default(), SMALL_BLOCK, &["--set", "tissue.youngs_modulus_pa=7000"]);
    assert_eq!(as_file.forces_n(), as_set.forces_n());
    assert_ne!(as_file.forces_n(), small_block(SCRATCH).forces_n());

    let desk = Desk::default();
    desk.put("scene.toml", SMALL_BLOCK);
    for command in [&["press"][..], &["fit"], &["pack"], &["loop", "--quick"], &["fit", "--smallest", "--board", "m4f-168"]] {
        let set = ["--scene", "scene.toml", "--set", "tissue.youngs_modulus=7000"];
        refused(&desk, &[command, &set].concat(), &["--set tissue.youngs_modulus=7000", "did you mean \"youngs_modulus_pa\"?"]);
    }
    refused(&desk, &["press", "--set", "tissue.nodes"], &["KEY=VALUE"]);
}

#[test]
fn shells_get_completions() {
    let desk = Desk::default();
    for shell in ["bash", "zsh", "fish", "elvish", "powershell"] {
        let script = run(&desk, 0, &["completions", shell]).stdout;
        assert!(["press", "stability", "tolerance-pct"].iter().all(|word| script.contains(word)), "{shell}");
    }
    let script = run(&desk, 0, &["completions", "bash"]).stdout;
    desk.put("palpate.bash", script);
    let read = Command::new("bash").args(["-n", "palpate.bash"]).current_dir(desk.folder()).status();
    assert!(read.map_or(true, |status| status.success()), "bash cannot read it");
}

#[test]
fn lengths_take_units() {
    let desk = Desk::default();
    let depth_mm = |given: &str| {
        let loop_of = ["loop", "--quick", "--hand", "H1", "--stimulus", "S2", "--depth", given];
        let _said = run(&desk, 0, &loop_of);
        let text = std::fs::read_to_string(desk.folder().join("out/loop/summary.json")).unwrap();
        serde_json::from_str::<serde_json::Value>(&text).unwrap()["depth_mm"].as_f64().unwrap()
    };
    assert!(
        (depth_mm("2mm") - 2.0).abs() < 1e-9 && (depth_mm("0.2cm") - 2.0).abs() < 1e-9 && (depth_mm("0.002") - 2.0).abs() < 1e-9
    );
    refused(&desk, &["loop", "--depth", "2 inches"], &["2 inches", "16mm"]);
    refused(&desk, &["loop", "--depth", "4"], &["--depth: 4000 mm is outside 0.25 to 4.00 mm (hands press no deeper)", "3mm"]);
}
