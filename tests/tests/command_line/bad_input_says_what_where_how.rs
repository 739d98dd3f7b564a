//! Any error in the input gives exit code 2 and one line that names the item and the remedy;
//! nothing else is printed, and nothing is written.

use palpate_tests::cube_mesh::cube;
use std::process::Command;

use palpate_tests::palpate_command::{Desk, binary, palpate};
use palpate_tests::press_run::{SMALL_BLOCK, edited};

use crate::bad_files_say_what_where_how::mesh_scene;

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");
const BLOCK: &str = "block_m = [0.08, 0.08, 0.04]";
const NODES: &str = "nodes = 129";
const PLACE: &str = "position_m = [0.0, 0.0]";
const HOLDS: &str = "holds_m = [0.001, 0.002, 0.004]";
const POISSON: &str = "poisson_ratio = 0.45";

/// Runs a command that must be refused with one line that contains all of `says`.
#[track_caller]
pub(crate) fn refused(desk: &Desk, arguments: &[&str], says: &[&str]) {
    palpate_tests::palpate_command::refused(SCRATCH, desk, arguments, says);
}

/// Presses a scene that must be refused.
#[track_caller]
pub(crate) fn refused_scene(desk: &Desk, scene: &str, says: &[&str]) {
    desk.put("scene.toml", scene);
    refused(desk, &["press", "--scene", "scene.toml", "--out", "out"], says);
}

/// Presses the small block with one edit, which must be refused with a position in the scene file.
#[track_caller]
pub(crate) fn refused_edit(from: &str, to: &str, says: &[&str]) {
    refused_scene(&Desk::default(), &edited(SMALL_BLOCK, from, to), &[&["scene.toml:"], says].concat());
}

#[test]
fn the_small_block_itself_is_accepted() {
    let desk = Desk::default();
    desk.put("scene.toml", SMALL_BLOCK);
    let outcome = palpate(SCRATCH, desk.folder(), &["press", "--scene", "scene.toml", "--out", "out"]);
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""));
}

/// Packs the default block at another modulus for a device; the folder stays empty if it is
/// refused.
fn packed_for(desk: &Desk, changes: &[&str]) -> palpate_tests::palpate_command::Outcome {
    let fixed = ["pack", "--board", "m7-480", "--nodes", "100", "--device", "touch", "--out", "out"];
    let changes = changes.iter().flat_map(|change| ["--set", *change]);
    palpate(SCRATCH, desk.folder(), &fixed.into_iter().chain(changes).collect::<Vec<_>>())
}

#[test]
fn a_contact_that_the_device_does_not_render_is_not_packed_and_the_remedies_are_accepted() {
    let desk = Desk::default();
    let before = desk.listing();
    let stiff = packed_for(&desk, &["tissue.youngs_modulus_pa=28000"]);
    assert_eq!((stiff.code, stiff.stdout.as_str(), stiff.stderr.lines().count()), (Some(2), "", 1), "{stiff:?}");
    assert!(stiff.stderr.contains("renders 400 N/m") && stiff.stderr.contains("nothing is written"), "{stiff:?}");
    assert_eq!(desk.listing(), before);
    let number = |before: &str, after: &str| {
        let (_, rest) = stiff.stderr.split_once(before).unwrap();
        rest.split_once(after).unwrap().0.parse::<f64>().unwrap()
    };
    let softer = format!("tissue.youngs_modulus_pa={}", 1e3 * number("take at most ", " kPa"));
    let hold_m = 1e-3 * number("depth limit of at most ", " mm") / 1.25;
    let shallower = format!("drive.holds_m=[{hold_m}]");
    for remedy in [&[softer.as_str()][..], &["tissue.youngs_modulus_pa=28000", shallower.as_str()]] {
        let outcome = packed_for(&desk, remedy);
        assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""), "{remedy:?}: {outcome:?}");
    }
}

#[test]
fn a_scene_that_is_not_there() {
    let desk = Desk::default();
    let press = |scene, says: &[&str]| refused(&desk, &["press", "--scene", scene, "--out", "out"], says);
    press("blok", &["\"blok\"", "did you mean \"block\"", "nodule", ".toml"]);
    press("nodul", &["did you mean \"nodule\""]);
    press("xyz", &["no scene \"xyz\": presets: block, "]);
    press("nowhere.toml", &["nowhere.toml", "No such file", "check the path", "block-20kpa"]);
    std::fs::create_dir(desk.folder().join("folder.toml")).unwrap();
    press("folder.toml", &["folder.toml", "directory", "check the path"]);
    press(".", &["directory"]);
    desk.put("binary.toml", [0xff, 0xfe, 0]);
    press("binary.toml", &["binary.toml", "UTF-8"]);
    desk.put("empty.toml", "");
    press("empty.toml", &["empty.toml:1", "\"name\" is missing", "add it"]);
}

#[test]
fn an_unknown_key_with_its_line_and_the_nearest_known_one() {
    for (from, to, line, near) in [
        ("name =", "naem =", 1, "name"),
        ("[tissue]", "[tisue]", 2, "tissue"),
        ("youngs_modulus_pa", "youngs_modulus_kpa", 4, "youngs_modulus_pa"),
        (POISSON, "poissons_ratio = 0.45", 5, "poisson_ratio"),
        (NODES, "node = 129", 7, "nodes"),
        ("radius_m", "radius_mm", 10, "radius_m"),
        ("ramp_m_per_s", "ramp_mm_per_s", 15, "ramp_m_per_s"),
        ("hold_s =", "hold_ms =", 16, "hold_s"),
    ] {
        let wrong = to.trim_matches(['[', ']']).split(' ').next().unwrap();
        let says = [format!("scene.toml:{line}: "), format!("\"{wrong}\""), format!("did you mean \"{near}\"?")];
        refused_edit(from, to, &says.each_ref().map(String::as_str));
    }
    let inclusion = "[[tissue.inclusion]]\ncentre_m = [0.0, 0.0, -0.012]\nradius_m = 0.006\nstiffness_ratio = 10.0\n[probe]";
    refused_edit("[probe]", inclusion, &["scene.toml:9: ", "\"centre_m\"", "did you mean \"center_m\"?"]);
    refused_edit("[probe]", "[solver]\nmetod = \"palpate\"\n[probe]", &["scene.toml:9: ", "\"metod\"", "\"method\"?"]);
}

#[test]
fn an_unknown_word_with_its_line_and_the_nearest_known_one() {
    refused_edit("\"hemisphere\"", "\"hemispher\"", &[":9: ", "\"hemispher\"", "did you mean \"hemisphere\"?"]);
    refused_edit("\"depth\"", "\"dept\"", &[":13: ", "\"dept\"", "did you mean \"depth\"?"]);
    refused_edit("[probe]", "[solver]\nmethod = \"palpat\"\n[probe]", &[":9: ", "\"palpat\"", "did you mean \"palpate\"?"]);
    refused_edit(
        "[probe]",
        "[solver]\nmethod = \"xpbd\"\n[probe]",
        &[":9: ", "\"xpbd\"", "neo-hookean", "palpate chart", "\"springs\""],
    );
    // a word unlike any: all words
    refused_edit("\"hemisphere\"", "\"ball\"", &[":9: ", "\"ball\"", "give one of hemisphere, sphere, flat"]);
    // a key that belongs to another kind of drive
    refused_edit("\"depth\"", "\"force\"", &[":14: ", "\"holds_m\"", "did you mean \"holds_n\"?"]);
    refused_edit("hold_s = 0.3", "hold_s = 0.3\ntrace = \"t.csv\"", &[":17: ", "\"trace\""]);
}

#[test]
fn a_missing_key_by_name_and_table() {
    for (line, key, table) in [
        ("name = \"small\"", "name", "the file"),
        ("youngs_modulus_pa = 3500.0", "youngs_modulus_pa", "[tissue]"),
        (POISSON, "poisson_ratio", "[tissue]"),
        ("density_kg_per_m3 = 1060.0", "density_kg_per_m3", "[tissue]"),
        ("shape = \"hemisphere\"", "shape", "[probe]"),
        ("radius_m = 0.008", "radius_m", "[probe]"),
        ("kind = \"depth\"", "kind", "[drive]"),
        (HOLDS, "holds_m", "[drive]"),
        ("ramp_m_per_s = 0.04", "ramp_m_per_s", "[drive]"),
        ("hold_s = 0.3", "hold_s", "[drive]"),
    ] {
        refused_edit(line, "", &[&format!("\"{key}\" is missing in {table}"), "add it"]);
    }
    refused_edit(BLOCK, "", &["neither block_m nor mesh", "give one"]);
    refused_edit(&SMALL_BLOCK[SMALL_BLOCK.find("[drive]").unwrap()..], "", &["\"drive\" is missing"]);
}

#[test]
fn a_long_tip_with_its_keys_and_its_direction() {
    let capsule = "shape = \"capsule\"\nlength_m = 0.01\nalong = [1.0, 0.0, 0.0]";
    let ellipsoid = "shape = \"ellipsoid\"\nsemi_axes_m = [0.01, 0.006, 0.006]\nalong = [0.0, 1.0, 0.0]";
    let round = "shape = \"hemisphere\"";
    for (from, key) in [("length_m = 0.01", "length_m"), ("along = [1.0, 0.0, 0.0]", "along")] {
        refused_edit(round, &edited(capsule, from, ""), &[":8: ", &format!("\"{key}\" is missing in [probe]"), "add it"]);
    }
    for (tip, key) in [(format!("{round}\nlength_m = 0.01"), "length_m"), (format!("{round}\nalong = [1.0, 0.0, 0.0]"), "along")]
    {
        refused_edit(round, &tip, &[":8: ", &format!("probe.{key} belongs to a capsule"), "remove it"]);
    }
    refused_edit(round, ellipsoid, &[":8: ", "probe.radius_m", "remove it"]);
    for (tip, without) in [(capsule, NODES), (ellipsoid, "radius_m = 0.008")] {
        for (direction, says) in [
            ("[0.0, 0.0, 0.0]", ["no direction", "[1.0, 0.0, 0.0]"]),
            ("[nan, 0.0, 1.0]", ["no direction", "[1.0, 0.0, 0.0]"]),
            ("[0.0, 0.1, 1.0]", ["out of the block's top", "[1.0, 0.0, 0.0]"]),
        ] {
            let along = tip.lines().last().unwrap();
            let scene = edited(&edited(SMALL_BLOCK, round, &edited(tip, along, &format!("along = {direction}"))), without, "");
            refused_scene(&Desk::default(), &scene, &[&["scene.toml:", "probe.along"], &says[..]].concat());
        }
    }
    for (from, to, key, says) in [
        ("length_m = 0.01", "length_m = -0.01", "probe.length_m", "0 .. 1"),
        ("length_m = 0.01", "length_m = nan", "probe.length_m", "0 .. 1"),
    ] {
        refused_edit(round, &edited(capsule, from, to), &[key, says]);
    }
    let scene = edited(&edited(SMALL_BLOCK, round, &edited(ellipsoid, "0.01,", "0.1,")), "radius_m = 0.008", "");
    refused_scene(&Desk::default(), &scene, &["probe.semi_axes_m[0]", "0.0015 .. 0.024"]);
}

#[test]
fn a_value_of_the_wrong_type_with_key_and_line() {
    for (from, to, says) in [
        ("3500.0", "\"soft\"", [":4: ", "youngs_modulus_pa", "expected a number"]),
        ("0.008", "[0.008]", [":10: ", "radius_m", "expected a number"]),
        ("= 129", "= 12.5", [":7: ", "nodes", "whole number"]),
        ("= 129", "= -5", [":7: ", "nodes", "whole number"]),
        ("= 129", "= 1e9", [":7: ", "nodes", "whole number"]),
        (BLOCK, "block_m = [0.08, 0.08]", [":3: ", "block_m is a list of length 2", "give 3 entries"]),
        (BLOCK, "block_m = [0.08, 0.08, 0.04, 0.0]", [":3: ", "block_m is a list of length 4", "give 3 entries"]),
        (PLACE, "position_m = [0.0]", [":11: ", "position_m is a list of length 1", "give 2 entries"]),
        (PLACE, "tilt_deg = [0, 15, 0, 99]", [":11: ", "tilt_deg is a list of length 4", "give 3 entries"]),
        (HOLDS, "holds_m = 0.001", [":14: ", "holds_m", "a list"]),
        ("= 0.3", "= \"long\"", [":16: ", "hold_s", "expected a number"]),
        ("3500.0", "= 3500.0", [":4: ", "youngs_modulus_pa", "extra `=`"]),
        (NODES, "nodes = 129\nnodes = 130", [":8: ", "nodes", "duplicate key"]),
        ("\"small\"", "\"small", [":1: ", "name", "string"]),
    ] {
        refused_edit(from, to, &says);
    }
}

#[test]
fn a_number_out_of_range_by_key_value_and_range() {
    let tried = |from: &str, key: &str, values: &[&str], says: &[&str]| {
        for value in values {
            let leaf = key.rsplit('.').next().unwrap();
            refused_edit(from, &format!("{leaf} = {value}"), &[&[key], says].concat());
        }
    };
    tried(POISSON, "tissue.poisson_ratio", &["0.5", "0.6", "0.24", "-0.3", "nan", "0.49999"], &["0.25 .. 0.4999"]);
    tried(
        "youngs_modulus_pa = 3500.0",
        "tissue.youngs_modulus_pa",
        &["0.0", "-3500.0", "nan", "inf", "1e300"],
        &["outside 1 .."],
    );
    tried("density_kg_per_m3 = 1060.0", "tissue.density_kg_per_m3", &["0.0", "-1.0", "nan"], &["outside 1 .. 30000"]);
    tried("radius_m = 0.008", "probe.radius_m", &["0.0", "-0.008", "nan", "inf", "8.0"], &["above zero and at most 1"]);
    tried(NODES, "tissue.nodes", &["0", "3", "29", "5001", "1000000000"], &["from 30 to 5000"]);
    tried("hold_s = 0.3", "drive.hold_s", &["0.0", "-1.0", "nan", "1e9"], &["from 0.001 to 60"]);
    tried("ramp_m_per_s = 0.04", "drive.ramp_m_per_s", &["0.0", "-1.0", "nan", "40.0"], &["at most 1"]);
    refused_edit("0.04\n", "1e-9\n", &["drive", "4000001 s", "at most 1000", "ramp faster"]);
    for side in ["0.0", "-0.04", "nan", "inf", "1e-9", "1e6"] {
        refused_edit("0.08, 0.04]", &format!("0.08, {side}]"), &["tissue.block_m[2]", "from 0.001 to 2", "metres"]);
    }
    refused_edit("0.08, 0.04]", "1.9, 0.04]", &["tissue.block_m", "ratio", "at most 20", "thicker"]);
    refused_edit(NODES, "nodes = 129\ngravity_m_per_s2 = [0.0, 0.0, nan]", &["tissue.gravity_m_per_s2[2]", "-100 .. 100"]);
    refused_edit(NODES, "nodes = 129\nnode_damping_per_s = -1.0", &["tissue.node_damping_per_s", "outside 0 .."]);
    refused_edit(PLACE, "position_m = [0.0, 0.041]", &["probe.position_m[1] = 0.041", "outside", "-0.04 .. 0.04"]);
    refused_edit(PLACE, "position_m = [nan, 0.0]", &["probe.position_m[0]", "-0.04 .. 0.04"]);
    for name in ["", "../small", "two\\nlines"] {
        refused_edit("\"small\"", &format!("\"{name}\""), &["name", "without slashes"]);
    }
}

#[test]
fn an_inclusion_without_size_or_stiffness() {
    let ball = |center: &str, radius: &str, ratio: &str, says: &[&str]| {
        let table = format!(
            "[[tissue.inclusion]]\ncenter_m = [0.0, 0.0, {center}]\nradius_m = {radius}\nstiffness_ratio = {ratio}\n[probe]"
        );
        refused_edit("[probe]", &table, says);
    };
    for radius in ["0.0", "-0.006", "nan", "inf"] {
        ball("-0.012", radius, "10.0", &["tissue.inclusion[0].radius_m", "above zero and finite"]);
    }
    for ratio in ["0.0", "-1.0", "nan", "inf"] {
        ball("-0.012", "0.006", ratio, &["tissue.inclusion[0].stiffness_ratio", "above zero and finite"]);
    }
    ball("nan", "0.006", "10.0", &["tissue.inclusion[0].center_m", "not finite", "metres"]);
}

#[test]
fn holds_that_cannot_be() {
    for (holds, says) in [
        ("[]", ["drive.holds_m", "is empty", "give at least one"]),
        ("[-0.001]", ["drive.holds_m[0]", "= -0.001", "above zero"]),
        ("[0.001, 0.0]", ["drive.holds_m[1]", "= 0 ", "above zero"]),
        ("[nan]", ["drive.holds_m[0]", "NaN", "above zero and finite"]),
        ("[inf]", ["drive.holds_m[0]", "inf", "above zero and finite"]),
        ("[0.001, 4.0]", ["drive.holds_m[1]", "deeper than the tissue is thick (0.0400 m)", "less deep"]),
    ] {
        refused_edit(HOLDS, &format!("holds_m = {holds}"), &says);
    }
    let force = edited(SMALL_BLOCK, "\"depth\"", "\"force\"");
    for (holds, says) in [
        ("[]", ["drive.holds_n", "is empty"]),
        ("[-1.0]", ["drive.holds_n[0] = -1", "above zero"]),
        ("[0.1, 100.0]", ["drive.holds_n[1] = 100", "at most 12"]),
    ] {
        refused_scene(&Desk::default(), &edited(&force, HOLDS, &format!("holds_n = {holds}")), &says);
    }
}

#[test]
fn keys_that_contradict_each_other() {
    refused_edit(BLOCK, &format!("{BLOCK}\nmesh = \"a.msh\""), &["both block_m and mesh", "keep one"]);
    refused_edit(BLOCK, &format!("{BLOCK}\nlength_unit = \"mm\""), &["tissue.length_unit", "remove it"]);
    refused_edit(BLOCK, &format!("{BLOCK}\nup = \"y\""), &["tissue.up", "remove it"]);
    refused_edit(PLACE, "site = [0.0, 0.0, 0.0]", &["probe.site", "position_m", "use that"]);
    let mesh = edited(SMALL_BLOCK, BLOCK, "mesh = \"a.msh\"");
    let desk = Desk::default();
    refused_scene(&desk, &mesh, &["tissue.length_unit", "is missing", "\"mm\""]);
    let mesh = edited(&mesh, "\"a.msh\"", "\"a.msh\"\nlength_unit = \"mm\"");
    refused_scene(&desk, &mesh, &["tissue.nodes", "remove it"]);
    let mesh = edited(&mesh, NODES, "");
    refused_scene(&desk, &mesh, &["probe.position_m", "site = [x, y, z]"]);
    refused_scene(&desk, &edited(&mesh, PLACE, ""), &["probe.site", "is missing", "site = [x, y, z]"]);
    let packed = edited(&mesh, PLACE, "site = [0.0, 0.0, 0.0]\n[solver]\npatch = \"a.patch\"");
    refused_scene(&desk, &packed, &["a.patch", "No such file"]);
    let block = palpate_tests::palpate_command::repository().join("host-sim/patches/block-130.patch");
    let packed = edited(&packed, "a.patch", &block.display().to_string());
    refused_scene(&desk, &packed, &["tissue.mesh", "a.msh", "is not there"]);
    desk.put("a.msh", "any");
    refused_scene(&desk, &packed, &["solver.patch", "has no record", "which organ", "remove"]);
}

#[test]
fn an_organ_that_is_none_or_is_pressed_elsewhere() {
    let desk = Desk::default();
    let organ = |source: &str, place: &str| edited(&edited(&edited(SMALL_BLOCK, BLOCK, source), NODES, ""), PLACE, place);
    let foot = |more: &str| organ(&format!("organ = \"foot\"\n{more}"), "site = [-0.075, 0.0, 0.031]");
    let region = |name: &str, e: &str| format!("region = [{{ name = \"{name}\", youngs_modulus_pa = {e} }}]");
    refused_scene(
        &desk,
        &organ("organ = \"spleen\"", "site = [0.0, 0.0, 0.0]"),
        &["tissue.organ", "`spleen`", "liver, gallbladder, abdomen, foot"],
    );
    refused_scene(&desk, &organ("organ = \"foot\"", ""), &["probe.site", "is missing", "site = [x, y, z]"]);
    refused_scene(&desk, &organ("organ = \"foot\"", PLACE), &["probe.position_m", "site = [x, y, z]"]);
    refused_scene(
        &desk,
        &organ("organ = \"foot\"", "site = [-0.075, 0.0, 0.06]"),
        &["probe.site", "mm from the surface", "site = [-0.076"],
    );
    refused_scene(&desk, &foot("length_unit = \"mm\""), &["tissue.length_unit", "remove it"]);
    refused_scene(&desk, &foot("nodes = 7"), &["tissue.nodes = 7", "from 100 to 5000"]);
    refused_scene(&desk, &foot("mesh = \"a.msh\""), &["both mesh and organ", "keep one"]);
    refused_scene(&desk, &foot(BLOCK), &["both block_m and organ", "keep one"]);
    refused_scene(&desk, &foot(&region("fat", "1e4")), &["tissue.region[0].name", "\"fat\"", "skin, fat pad, deep tissue"]);
    refused_scene(&desk, &foot(&region("skin", "0.0")), &["tissue.region[0].youngs_modulus_pa = 0", "1 .."]);
    let twice = region("skin", "1e4").replace(']', ", { name = \"skin\", youngs_modulus_pa = 2e4 }]");
    refused_scene(&desk, &foot(&twice), &["tissue.region[1].name", "there twice", "remove one"]);
    refused_edit(BLOCK, &format!("{BLOCK}\n{}", region("skin", "1e4")), &["tissue.region", "belongs to an organ"]);
    // a patch of a whole block does not belong to an organ
    let block = palpate_tests::palpate_command::repository().join("host-sim/patches/block-130.patch");
    let patch = format!("{}[solver]\npatch = \"{}\"\n", foot(""), block.display());
    refused_scene(&desk, &patch, &["solver.patch", "block-130.patch has no record", "which organ", "remove"]);
}

#[test]
fn a_trace_that_cannot_be_repeated() {
    let scene = format!("{}[drive]\nkind = \"trace\"\ntrace = \"t.csv\"\n", SMALL_BLOCK.split("[drive]").next().unwrap());
    let desk = Desk::default();
    refused_scene(&desk, &scene, &["t.csv", "No such file", "check the path"]);
    for (text, says) in [
        ("", ["t.csv:1", "no column probe_x_m", "use a trace.csv"]),
        ("t_s,probe_x_m,probe_y_m\n0,0,0\n", ["t.csv:1", "no column probe_z_m", "use a trace.csv"]),
        ("t_s;probe_x_m\n0;0\n", ["t.csv:1", "separated by semicolons", "save it with commas"]),
        ("probe_x_m,probe_y_m,probe_z_m\n", ["t.csv:1", "no rows", "record a run"]),
        ("probe_x_m,probe_y_m,probe_z_m\n0,0,0\n0,0,zero\n", ["t.csv:3", "\"zero\" is not a number", "use a trace.csv"]),
        (
            "t_s,probe_x_m,probe_y_m,probe_z_m\n0,0,0,0\n0.001,0,0,0\n0.004,0,0,0\n",
            ["t.csv:4", "leaves a gap", "every millisecond"],
        ),
        ("t_s,probe_x_m,probe_y_m,probe_z_m\n0,0,0,0\n0.001,0,0,0\n0.001,0,0,0\n", ["t.csv:4", "goes back", "every millisecond"]),
        ("probe_x_m,probe_y_m,probe_z_m\n0,0\n", ["t.csv:2", "is not a number", "use a trace.csv"]),
        ("probe_x_m,probe_y_m,probe_z_m\n0,0,nan\n", ["t.csv:2", "\"nan\" is not a number", "use a trace.csv"]),
        ("probe_x_m,probe_y_m,probe_z_m\n0,1e99,0\n", ["t.csv:2", "\"1e99\" is not a number", "use a trace.csv"]),
    ] {
        desk.put("t.csv", text);
        refused_scene(&desk, &scene, &says);
    }
}

#[test]
fn an_output_folder_with_a_file_in_the_way() {
    let desk = Desk::default();
    desk.put("scene.toml", SMALL_BLOCK);
    desk.put("taken", "mine");
    for out in ["taken", "taken/below"] {
        refused(&desk, &["press", "--scene", "scene.toml", "--out", out], &[out, "cannot write", "--out"]);
        refused(&desk, &["pack", "--scene", "scene.toml", "--out", out], &[out, "cannot write", "--out"]);
    }
    assert_eq!(std::fs::read(desk.folder().join("taken")).unwrap(), b"mine");
}

#[test]
fn a_failed_command_leaves_an_earlier_run_as_it_was() {
    let desk = Desk::default();
    std::fs::create_dir(desk.folder().join("out")).unwrap();
    desk.put("out/summary.json", "of an earlier run");
    refused_scene(&desk, &edited(SMALL_BLOCK, "0.008", "0.0"), &["probe.radius_m"]);
    let left: Vec<_> = std::fs::read_dir(desk.folder().join("out")).unwrap().flatten().map(|e| e.file_name()).collect();
    assert_eq!(left, ["summary.json"]);
    assert_eq!(std::fs::read_to_string(desk.folder().join("out/summary.json")).unwrap(), "of an earlier run");
}

#[test]
fn a_model_too_large_for_its_millisecond_with_the_numbers() {
    let desk = Desk::default();
    desk.put("a.msh", cube(32, 1.0));
    let scene = mesh_scene("0.093", "[0.0465, 0.0465, 0.093]");
    refused_scene(&desk, &scene, &["32768 nodes", "one substep a tick", "of the 1000 us", "fewer nodes"]);

    desk.put("scene.toml", SMALL_BLOCK);
    let pack = ["pack", "--scene", "scene.toml", "--nodes", "1000", "--out", "out"];
    refused(&desk, &pack, &["1000 nodes", "cycles a tick", "109200 fit on m4f-168", "fewer nodes"]);
}

#[test]
fn boards_and_options_that_do_not_fit() {
    let desk = Desk::default();
    refused(&desk, &["pack", "--board", "m4f"], &["no board \"m4f\"", "desktop, m4f-168, m7-480"]);
    for option in ["--image", "--patch"] {
        refused(&desk, &["emulate", option, "nope.file"], &["nope.file", "No such file", "check the path"]);
    }
    refused(&desk, &["pack", "--nodes", "3"], &["nodes = 3", "from 30 to 5000"]);
    refused(&desk, &["pack", "--scene", "organ-liver", "--nodes", "99"], &["--nodes", "shape of its own", "leave it out"]);
}

#[test]
fn a_patch_for_a_board_that_cannot_be() {
    let desk = Desk::default();
    let pack = |radius, element| ["fit", "--board", "m4f-168", "--radius-m", radius, "--element-m", element];
    for radius in ["-1", "0.004", "0.05", "nan"] {
        refused(&desk, &pack(radius, "0.005"), &["give a radius of 0.0100 to 0.0320 m"]);
    }
    refused(&desk, &pack("0.017", "nan"), &["elements of NaN m", "above zero"]);
    for tolerance in ["0", "-3", "nan", "inf", "101"] {
        refused(&desk, &["fit", "--tolerance-pct", tolerance], &["--tolerance-pct", "above 0", "at most 100"]);
    }
    let smallest = |more: &[&'static str]| [&["fit", "--smallest", "--board", "m4f-168"], more].concat();
    let unknowable = smallest(&["--tolerance-pct", "0.2"]);
    refused(&desk, &unknowable, &["--tolerance-pct 0.2", "reference itself", "take 0.3 or more"]);
    refused(&desk, &["fit", "--smallest", "--board", "m4"], &["no board \"m4\"", "desktop, m4f-168, m7-480"]);
    refused(&desk, &["fit", "--board", "desktop", "--board", "m7-480"], &["--board", "give one, or --scenes"]);
    refused(&desk, &smallest(&["--scene", "blok"]), &["did you mean \"block\""]);
    let plan = smallest(&["--scene", "scene.toml"]);
    desk.put("scene.toml", edited(SMALL_BLOCK, NODES, "nodes = 129\ngravity_m_per_s2 = [0.0, 0.0, -9.81]"));
    refused(&desk, &plan, &["tissue.gravity_m_per_s2", "a fit has no weight"]);
    desk.put("scene.toml", edited(SMALL_BLOCK, "[0.08, 0.08, 0.04]", "[0.01, 0.01, 0.006]"));
    refused(&desk, &plan, &["scene.toml", "patch radius", "use at most"]);
}

#[cfg(unix)]
#[test]
fn a_path_that_is_not_utf_8_gets_one_line() {
    let path = <std::ffi::OsStr as std::os::unix::ffi::OsStrExt>::from_bytes(b"caf\xe9.toml");
    let ended = Command::new(binary(SCRATCH)).args(["press", "--scene"]).arg(path).output().unwrap();
    let why = String::from_utf8_lossy(&ended.stderr);
    assert!(ended.status.code() == Some(2) && why.lines().count() == 1 && why.contains("UTF-8: rename the file"), "{why}");
}

#[test]
fn a_path_with_a_line_end_stays_one_line() {
    refused(&Desk::default(), &["press", "--scene", "no\nwhere.toml"], &["where.toml", "check the path"]);
}
