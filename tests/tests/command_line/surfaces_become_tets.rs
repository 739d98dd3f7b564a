//! A user turns a surface file into tets with one command.

use palpate_tests::palpate_command::{Desk, Outcome, palpate};
use palpate_tests::press_run::{SMALL_BLOCK, edited};
use palpate_tests::surface_text::ball;

use crate::bad_input_says_what_where_how::{refused, refused_scene};

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");
const BLOCK: &str = "block_m = [0.08, 0.08, 0.04]";

fn run(desk: &Desk, arguments: &[&str]) -> Outcome {
    let outcome = palpate(SCRATCH, desk.folder(), arguments);
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""), "{outcome:?}");
    outcome
}

/// The scene of the small block with a ball's surface in place of the block.
fn scene(source: &str) -> String {
    let scene = edited(&edited(SMALL_BLOCK, BLOCK, source), "nodes = 129\n", "");
    edited(&scene, "position_m = [0.0, 0.0]", "site = [0.0, 0.0, 0.03]")
}

#[test]
fn a_ball_is_checked_filled_and_pressed() {
    let desk = Desk::default();
    desk.put("ball.stl", ball(3.0, 3).binary_stl());
    let checked = run(&desk, &["mesh", "check", "ball.stl", "--unit", "cm"]).stdout;
    assert!(checked.contains("512 triangles, 258 vertices, closed; 60.00 x 60.00 x 60.00 mm"), "{checked}");
    let filled = run(&desk, &["mesh", "tets", "ball.stl", "--unit-m", "cm", "--element-m", "0.006", "--out", "tets"]).stdout;
    assert!(filled.contains("supports") && filled.contains("mesh = \"ball.msh\", length_unit = \"m\""), "{filled}");
    let tets = |name: &str| {
        let said = run(&desk, &["mesh", "check", name]).stdout;
        said.lines().nth(2).unwrap().to_owned()
    };
    assert_eq!(tets("tets/ball.msh"), tets("tets/ball.vtu"));
    assert!(filled.contains(tets("tets/ball.vtu").trim().split(';').next().unwrap()), "{filled}");

    desk.put("scene.toml", scene("mesh = \"ball.stl\"\nlength_unit = \"cm\"\nnodes = 300"));
    let pressed = run(&desk, &["press", "--scene", "scene.toml", "--out", "out", "--vtu"]).stdout;
    let vtu = std::fs::read_to_string(desk.folder().join("out/press_0.vtu")).unwrap();
    let array = vtu.split("Name=\"fixed\"").nth(1).unwrap().split('>').nth(1).unwrap();
    let shown = array.split_whitespace().filter(|word| *word == "1").count();
    assert!(shown > 10 && pressed.contains(&format!("supports  {shown} nodes, where the surface faces")), "{shown}: {pressed}");
    let json = std::fs::read_to_string(desk.folder().join("out/summary.json")).unwrap();
    let summary: serde_json::Value = serde_json::from_str(&json).unwrap();
    let (tets_cm3, surface_cm3) = (&summary["report"]["volume_cm3"], &summary["report"]["surface_cm3"]);
    let off = tets_cm3.as_f64().unwrap() / surface_cm3.as_f64().unwrap() - 1.0;
    assert!((-0.08..0.0).contains(&off), "{off}");
    assert_eq!(summary["report"]["anchors"].as_u64(), Some(shown as u64));
    // the file that the press wrote is accepted as a mesh
    assert!(tets("out/press_0.vtu").contains("tets"));
}

#[test]
fn a_surface_that_cannot_be_filled_or_pressed() {
    let desk = Desk::default();
    desk.put("ball.obj", ball(30.0, 2).obj());
    let tets = |more: &[&str], says: &[&str]| refused(&desk, &[&["mesh", "tets", "ball.obj"], more].concat(), says);
    tets(&[], &["--unit"]);
    tets(&["--unit", "ft"], &["\"ft\" is not \"m\", \"cm\", \"mm\", \"um\""]);
    tets(&["--unit", "m"], &["60000 x 60000 x 60000 mm", "\"mm\" would make it 60 mm"]);
    tets(&["--unit", "mm", "--element-m", "0.0005"], &["about", "nodes, at most 65535", "above 0.0"]);
    tets(&["--unit", "mm", "--element-m", "0.045"], &["elements of 45.00 mm", "smaller --element"]);
    tets(&["--unit", "mm", "--element-m", "4"], &["smaller than the surface", "metres"]);
    desk.put("box.msh", palpate_tests::cube_mesh::cube(3, 0.05));
    refused(&desk, &["mesh", "tets", "box.msh", "--unit", "m"], &["box.msh", "has tets already"]);

    let source = "mesh = \"ball.obj\"\nlength_unit = \"mm\"";
    refused_scene(&desk, &edited(&scene(source), "0.03]", "0.06]"), &["probe.site", "from the surface", "site = [0.0"]);
    refused_scene(&desk, &scene(&format!("{source}\nnodes = 20")), &["tissue.nodes = 20", "100 to 5000"]);
    let nodule = |z: &str| {
        let table = format!("[[tissue.inclusion]]\ncenter_m = [0.0, 0.0, {z}]\nradius_m = 0.005\nstiffness_ratio = 9.0\n[probe]");
        edited(&scene(source), "[probe]", &table)
    };
    refused_scene(&desk, &nodule("20.0"), &["tissue.inclusion[0].center_m", "fills no tet", "z -0.0", "metres"]);
    let whole = edited(&nodule("0.0"), "radius_m = 0.005", "radius_m = 5.0");
    refused_scene(&desk, &whole, &["tissue.inclusion[0].radius_m = 5", "the whole tissue", "5 mm is 0.005"]);
}

#[test]
fn a_nodule_outside_the_block_is_refused_and_one_inside_counted() {
    let nodule = |at: &str| {
        let table = format!("[[tissue.inclusion]]\ncenter_m = {at}\nradius_m = 0.006\nstiffness_ratio = 9.0\n[probe]");
        edited(SMALL_BLOCK, "[probe]", &table)
    };
    let desk = Desk::default();
    for at in ["[0.0, 0.0, 0.012]", "[0.0, 0.0, -12.0]", "[0.05, 0.0, -0.01]", "[0.0, -0.0461, -0.01]"] {
        refused_scene(&desk, &nodule(at), &["tissue.inclusion[0].center_m", "outside the block", "metres", "0 (top)"]);
    }
    let whole = edited(&nodule("[0.0, 0.0, -0.012]"), "radius_m = 0.006", "radius_m = 6.0");
    refused_scene(&desk, &whole, &["tissue.inclusion[0].radius_m = 6", "the whole tissue", "6 mm is 0.006"]);
    desk.put("scene.toml", nodule("[0.0, 0.0, -0.012]"));
    let said = run(&desk, &["press", "--scene", "scene.toml", "--out", "out"]).stdout;
    let line = said.lines().find(|line| line.trim_start().starts_with("inclusion 1 is in ")).expect("a line on the nodule");
    let held: f64 = line.split(" tets: ").nth(1).unwrap().split(' ').next().unwrap().parse().unwrap();
    // 4/3 pi (6 mm)^3, counted by sample points in the tets
    assert!((held / 0.905 - 1.0).abs() < 0.1, "{line}");
}

#[test]
fn likely_wrong_units_are_warned_of_in_the_verdict() {
    for (from, to, says) in [
        ("youngs_modulus_pa = 3500.0", "youngs_modulus_pa = 3.5", ["3.5 Pa", "3.5 kPa is 3500"]),
        ("radius_m = 0.008", "radius_m = 0.014", ["28.0 mm wide", "80.0 mm"]),
    ] {
        let desk = Desk::default();
        desk.put("scene.toml", edited(SMALL_BLOCK, from, to));
        let outcome = palpate(SCRATCH, desk.folder(), &["press", "--scene", "scene.toml", "--out", "out"]);
        let verdict = outcome.stdout.lines().next().unwrap_or_default();
        assert!(verdict.starts_with("warning: ") && says.iter().all(|words| verdict.contains(words)), "{outcome:?}");
    }
}
