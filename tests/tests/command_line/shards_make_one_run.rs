//! Campaigns in shards: `palpate merge` writes files that are byte-identical to those of a single
//! run, or refuses and changes nothing.

use std::collections::BTreeMap;

use palpate_tests::palpate_command::{Desk, binary, repository};
use palpate_tests::press_run::{SMALL_BLOCK, edited};
use palpate_tests::sharded::{are_one, ends, shards};
use palpate_tissue::shard::{Heading, Part, Shard, checksum};
use serde_json::{Value, json};

use crate::bad_input_says_what_where_how::refused;

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");

/// No fit is possible for these scenes; the merged table still equals that of a single run.
#[test]
fn tables_of_scenes_in_shards_are_one_run() {
    let desk = Desk::default();
    std::fs::create_dir(desk.folder().join("scenes")).unwrap();
    let stiffens = edited(SMALL_BLOCK, "nodes = 129", "nodes = 60\nstiffening_b = 3.0");
    desk.put("scenes/a.toml", &stiffens);
    desk.put("scenes/b.toml", "name = 3");
    desk.put("scenes/c.toml", edited(&stiffens, "3500.0", "3.5"));
    are_one(SCRATCH, &desk, 1, &["fit", "--scenes", "scenes"], &[&["1/2"], &["2/2"]], "table");
    let table = std::fs::read_to_string(desk.folder().join("merged/fits.csv")).unwrap();
    assert!(table.contains("\na,,failed,") && table.contains("tissue.stiffening_b = 3"), "{table}");

    let for_boards = Desk::default();
    let scenes = desk.folder().join("scenes").display().to_string();
    let smallest = ["fit", "--smallest", "--scenes", &scenes, "--board", "m4f-168", "--board", "desktop"];
    are_one(SCRATCH, &for_boards, 1, &smallest, &[&["1/3", "3/3"], &["2/3"]], "table");
    let table = std::fs::read_to_string(for_boards.folder().join("merged/fits.csv")).unwrap();
    assert_eq!(table.lines().count(), 7, "{table}");
    assert!(table.contains("\na,m4f-168,failed,") && table.contains("\nc,desktop,failed,"), "{table}");
}

/// A file that does not exist and a scene whose mesh file does not exist each give a row, and the
/// row does not depend on the folder in which the shard ran. A folder is not a scene.
#[test]
#[cfg(unix)]
fn scenes_that_cannot_be_read_are_rows() {
    let desk = Desk::default();
    std::fs::create_dir_all(desk.folder().join("scenes/folder.toml")).unwrap();
    std::os::unix::fs::symlink("nowhere", desk.folder().join("scenes/a.toml")).unwrap();
    let meshed = edited(SMALL_BLOCK, "block_m = [0.08, 0.08, 0.04]", "mesh = \"gone.msh\"\nlength_unit = \"mm\"");
    let meshed = edited(&edited(&meshed, "nodes = 129\n", ""), "position_m = [0.0, 0.0]", "site = [0.0, 0.0, 0.0]");
    desk.put("scenes/b.toml", meshed);
    ends(SCRATCH, &desk, 1, &["fit", "--scenes", "scenes", "--out", "one"]);
    let scenes = desk.folder().join("scenes").display().to_string();
    shards(SCRATCH, &desk, &["fit", "--scenes", &scenes], &[&["1/2"], &["2/2"]]);
    ends(SCRATCH, &desk, 1, &["merge", "shards", "--out", "merged"]);
    let table = |path: &str| std::fs::read_to_string(desk.folder().join(path)).unwrap();
    let one = table("one/table/fits.csv");
    assert_eq!(one, table("merged/fits.csv"));
    assert!(one.lines().count() == 3 && one.contains("\na,,failed,") && one.contains(",gone.msh: cannot read"), "{one}");
}

#[test]
fn what_cannot_be_split_and_what_is_no_shard() {
    let desk = Desk::default();
    desk.put("scene.toml", SMALL_BLOCK);
    refused(&desk, &["fit", "--shard", "1/2"], &["--shard: one scene is fitted in one piece", "--scenes"]);
    refused(&desk, &["fit", "--scenes", ".", "--board", "desktop", "--board", "desktop"], &["--board desktop: given twice"]);
    refused(&desk, &["merge", "absent"], &["absent"]);
    refused(&desk, &["merge", "."], &["there is no shard.jsonl in it", "--shard"]);
}

/// Shards of another program than the one that merges, and of a scene that has changed since.
#[test]
fn shards_are_merged_by_their_program_and_with_their_scene() {
    let desk = Desk::default();
    let options = |pairs: &[(&str, Value)]| pairs.iter().map(|(key, value)| ((*key).to_owned(), value.clone())).collect();
    let put = |heading: &Heading| {
        std::fs::create_dir_all(desk.folder().join("shards")).unwrap();
        desk.put("shards/shard.jsonl", Part::write(heading, &json!([])).unwrap());
    };
    let all = Shard::new(1, 1).unwrap();
    let of_loop = options(&[("scene", json!(1))]);
    let heading = Heading::new("loop", of_loop, BTreeMap::new(), 100, all).unwrap();
    put(&heading);
    // this shard was written by the test, not by the `palpate` that merges
    refused(
        &desk,
        &["merge", "shards"],
        &["the shards are of program", &heading.program, "merge with the program that ran them"],
    );

    let program = checksum(&std::fs::read(binary(SCRATCH)).unwrap());
    put(&Heading { program: program.clone(), version: "0.0.9".into(), ..heading.clone() });
    refused(&desk, &["merge", "shards"], &["the shards are of program 0.0.9", "merge with the program that ran them"]);
    put(&Heading { program: program.clone(), command: "knead".into(), ..heading.clone() });
    refused(&desk, &["merge", "shards"], &["knows no shards of knead", "merge with the one that ran them"]);
    put(&Heading { program, ..heading });
    refused(&desk, &["merge", "shards"], &["shard 1/1", "cannot be read", "run it again"]);

    std::fs::remove_dir_all(desk.folder().join("shards")).unwrap();
    let scene = std::fs::read_to_string(repository().join("host-sim/scenes/coarse-20kpa.toml")).unwrap();
    desk.put("scene.toml", &scene);
    let of_loop = ["loop", "--scene", "scene.toml", "--quick", "--hand", "H1", "--stimulus", "S4"];
    shards(SCRATCH, &desk, &of_loop, &[&["1/1"]]);
    desk.put("scene.toml", edited(&scene, "hold_s = 0.3", "hold_s = 0.4"));
    refused(&desk, &["merge", "shards"], &["the input of `palpate loop` is no longer that of the shards", "the same files"]);
    desk.put("scene.toml", scene);
    ends(SCRATCH, &desk, 0, &["merge", "shards", "--out", "merged"]);
}

/// Fits of two scenes, and the smallest patches for two boards.
#[test]
#[ignore = "long: finite elements of two fits, and two searches"]
fn fits_in_shards_are_one_run() {
    let desk = Desk::default();
    std::fs::create_dir(desk.folder().join("scenes")).unwrap();
    desk.put("scenes/small.toml", edited(SMALL_BLOCK, "nodes = 129", "nodes = 60"));
    let block = std::fs::read_to_string(repository().join("host-sim/scenes/block.toml")).unwrap();
    desk.put("scenes/block.toml", edited(&block, "nodes = 410", "nodes = 60"));
    let fit = ["fit", "--scenes", "scenes", "--quick", "--places", "20", "--tolerance-pct=30"];
    are_one(SCRATCH, &desk, 0, &fit, &[&["2/2"], &["1/2"]], "table");

    let boards = Desk::default();
    std::fs::create_dir(boards.folder().join("scenes")).unwrap();
    boards.put("scenes/block.toml", block);
    let smallest =
        ["fit", "--smallest", "--scenes", "scenes", "--quick", "--tolerance-pct=5", "--board=m4f-168", "--board=m7-480"];
    are_one(SCRATCH, &boards, 0, &smallest, &[&["2/2"], &["1/2"]], "table");
}
