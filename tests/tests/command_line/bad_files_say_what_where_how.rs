//! Bad mesh and patch files are refused in one line that says what is wrong, where, and how to fix
//! it.

use palpate_tests::cube_mesh::cube;
use palpate_tests::palpate_command::{Desk, palpate};
use palpate_tests::press_run::{SMALL_BLOCK, edited};

use crate::bad_input_says_what_where_how::{refused, refused_scene};

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");
const BLOCK: &str = "block_m = [0.08, 0.08, 0.04]";
const NODES: &str = "nodes = 129";
const PLACE: &str = "position_m = [0.0, 0.0]";
const HOLDS: &str = "holds_m = [0.001, 0.002, 0.004]";
const POISSON: &str = "poisson_ratio = 0.45";
/// Two tets that share a face.
const TWO_TETS: &str =
    "$NOD\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 1 1 1\n$ENDNOD\n$ELM\n2\n1 4 1 1 4 1 2 3 4\n17 4 1 1 4 2 3 4 5\n$ENDELM\n";

/// The scene of the small block with a mesh file in place of the block.
pub(crate) fn mesh_scene(unit: &str, site: &str) -> String {
    let scene = edited(SMALL_BLOCK, BLOCK, &format!("mesh = \"a.msh\"\nlength_unit = {unit}"));
    edited(&edited(&scene, NODES, ""), PLACE, &format!("site = {site}"))
}

#[test]
fn every_defect_of_a_mesh_with_its_line_on_check_and_on_press() {
    let last = "17 4 1 1 4 2 3 4 5";
    let parts = TWO_TETS
        .replace("$NOD\n5", "$NOD\n9")
        .replace("5 1 1 1\n", "5 1 1 1\n6 2 1 1\n7 1 2 1\n8 1 1 2\n9 2 2 2\n")
        .replace("$ELM\n2", "$ELM\n3")
        .replace("$ENDELM", "30 4 1 1 4 6 7 8 9\n$ENDELM");
    for (text, says) in [
        (edited(TWO_TETS, last, "17 4 1 1 4 2 3 4 999"), ["a.msh:12", "tet 17 names node 999", "fix the element"]),
        (edited(TWO_TETS, last, "17 4 1 1 4 2 3 4 4"), ["a.msh:12", "names node 4 twice", "remove"]),
        (edited(TWO_TETS, "5 1 1 1\n", "5 0 0 0\n"), ["a.msh:7", "node 5 is exactly where node 1", "merge"]),
        (edited(TWO_TETS, "5 1 1 1\n", "5 0.25 0.5 0.25\n"), ["a.msh:12", "tet 17 is flat", "slivers"]),
        (edited(TWO_TETS, "5 1 1 1\n", "5 -1 -1 -1\n"), ["a.msh:12", "overlap", "untangle"]),
        (edited(TWO_TETS, "5 1 1 1\n", "5 1 1 nan\n"), ["a.msh:7", "not a finite number", "re-export"]),
        (edited(TWO_TETS, "5 1 1 1\n", "5 1 1 x\n"), ["a.msh:7", "`x`", "fix the line"]),
        (TWO_TETS.replace("17 4 1 1 4 2 3 4 5\n$ENDELM\n", ""), ["a.msh", "announces 2", "re-export"]),
        (TWO_TETS.replace(" 1\n", " 120\n"), ["a.msh", "outside 1 mm to 2 m", "length_unit"]),
        (parts, ["a.msh:17", "2 parts that share no face", "keep one"]),
        (String::new(), ["a.msh", "empty", "re-export"]),
        ("any cube\n".into(), ["a.msh", "unknown mesh format", "export as"]),
        ("solid cube\n".into(), ["a.msh", "no triangles", "triangulated"]),
    ] {
        let desk = Desk::default();
        desk.put("a.msh", text);
        refused_scene(&desk, &mesh_scene("1.0", "[0.0, 0.0, 0.0]"), &says);
        refused(&desk, &["mesh", "check", "a.msh"], &says);
    }
}

#[test]
fn a_mesh_of_more_nodes_than_a_tick_holds_is_cut_by_a_fit() {
    let desk = Desk::default();
    desk.put("a.msh", cube(41, 0.1));
    let outcome = palpate(SCRATCH, desk.folder(), &["mesh", "check", "a.msh"]);
    assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
    let scene = mesh_scene("\"m\"", "[0.05, 0.05, 0.1]");
    refused_scene(&desk, &scene, &["tissue.mesh", "has 68921 nodes, more than the 65535 of a tick", "palpate fit --scene"]);
}

#[test]
fn a_mesh_in_the_wrong_unit_or_pressed_elsewhere() {
    let desk = Desk::default();
    refused_scene(&desk, &mesh_scene("\"m\"", "[0.0, 0.0, 0.0]"), &["a.msh", "cannot read", "check the path"]);
    desk.put("a.msh", TWO_TETS);
    for (unit, says) in [
        ("\"ft\"", [":4: ", "length_unit", "\"ft\" is not \"m\", \"cm\", \"mm\", \"um\" or a number of metres"]),
        ("0.0", [":4: ", "length_unit", "above zero"]),
        ("nan", [":4: ", "length_unit", "above zero"]),
        ("true", [":4: ", "length_unit", "a number of metres"]),
        ("50", ["a.msh", "50000 mm", "\"m\" would make it 1000 mm"]),
        ("1e-4", ["a.msh", "0.1 mm", "\"m\" would make it 1000 mm"]),
    ] {
        refused_scene(&desk, &mesh_scene(unit, "[0.0, 0.0, 0.0]"), &says);
    }
    refused_scene(&desk, &mesh_scene("0.05", "[nan, 0.0, 0.0]"), &["probe.site", "not finite", "metres"]);
    refused_scene(&desk, &mesh_scene("0.05", "[73.0, 0.0, 0.0]"), &["probe.site", "further from the mesh", "metres"]);
    for unit in ["0", "nan", "-1"] {
        refused(&desk, &["mesh", "check", "a.msh", &format!("--unit-m={unit}")], &["--unit", "above zero and finite"]);
    }
    refused(&desk, &["mesh", "check", "."], &["not a regular file", "give the path"]);
    refused(&desk, &["mesh", "check", "b.msh"], &["b.msh", "cannot read", "check the path"]);
}

#[test]
fn a_patch_file_that_is_not_what_the_scene_says() {
    let desk = Desk::default();
    let scene = format!("{SMALL_BLOCK}[solver]\npatch = \"a.patch\"\n");
    refused_scene(&desk, &scene, &["a.patch", "cannot read", "check the path"]);

    desk.put("scene.toml", SMALL_BLOCK);
    let pack = ["pack", "--scene", "scene.toml", "--board", "desktop", "--out", "packed"];
    assert_eq!(palpate(SCRATCH, desk.folder(), &pack).code, Some(0));
    let sound = std::fs::read(desk.folder().join("packed/small-desktop.patch")).unwrap();
    let changed = |at: usize| {
        let mut bytes = sound.clone();
        bytes[at] ^= 1;
        bytes
    };
    for (bytes, says) in [
        (Vec::new(), "not a patch file"),
        (sound[..15].to_vec(), "not a patch file"),
        (changed(0), "not a patch file"),
        // the version is wrong
        (changed(8), "not a patch file of this version"),
        // an error in the header, the body, or the checksum itself
        (changed(60), "checksum"),
        (changed(sound.len() / 2), "checksum"),
        (changed(sound.len() - 1), "checksum"),
        (changed(12), "checksum"),
        (sound[..sound.len() / 2].to_vec(), "checksum"),
        (sound[..sound.len() - 3].to_vec(), "checksum"),
        ([sound.as_slice(), &[0; 4]].concat(), "checksum"),
    ] {
        desk.put("a.patch", bytes);
        refused_scene(&desk, &scene, &["a.patch", says, "pack it again"]);
    }

    desk.put("a.patch", &sound);
    for (from, to, key) in [
        (POISSON, "poisson_ratio = 0.4", "tissue.poisson_ratio = 0.4"),
        (BLOCK, "block_m = [0.08, 0.08, 0.05]", "tissue.block_m[2] = 0.05"),
        (PLACE, "position_m = [0.0, 0.01]", "probe.position_m = [0, 0.01]"),
        (HOLDS, "holds_m = [0.001, 0.012]", "drive.holds_m[1] = 0.012"),
    ] {
        refused_scene(&desk, &edited(&scene, from, to), &["scene.toml", key, "a.patch"]);
    }
    desk.put("scene.toml", scene);
    let outcome = palpate(SCRATCH, desk.folder(), &["press", "--scene", "scene.toml", "--out", "out"]);
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""));
}
