//! Campaigns in ranges of cases: `palpate merge` writes files that are byte-identical to those of a
//! single run, or refuses and changes nothing.

use palpate_tests::case_ranges::are_one;
use palpate_tests::palpate_command::{Desk, repository};
use palpate_tests::press_run::{SMALL_BLOCK, edited};

use crate::bad_input_says_what_where_how::refused;

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");

/// No fit is possible for these scenes; the merged table still equals that of a single run.
#[test]
fn tables_of_scenes_in_ranges_are_one_run() {
    let desk = Desk::default();
    std::fs::create_dir(desk.folder().join("scenes")).unwrap();
    let heavy = edited(SMALL_BLOCK, "nodes = 129", "nodes = 60\ngravity_m_per_s2 = [0.0, 0.0, -9.8]");
    desk.put("scenes/a.toml", &heavy);
    desk.put("scenes/b.toml", "name = 3");
    desk.put("scenes/c.toml", edited(&heavy.replace("-9.8", "0.0"), "3500.0", "3.5"));
    are_one(SCRATCH, &desk, 1, &["fit", "--scenes", "scenes"], &["0..1", "1..9"], "table");
    let table = std::fs::read_to_string(desk.folder().join("merged/fits.csv")).unwrap();
    assert!(table.contains("\na,,failed,") && table.contains("tissue.gravity_m_per_s2 is not zero"), "{table}");

    let for_boards = Desk::default();
    let scenes = desk.folder().join("scenes").display().to_string();
    let smallest = ["fit", "--smallest", "--scenes", &scenes, "--board", "m4f-168", "--board", "desktop"];
    are_one(SCRATCH, &for_boards, 1, &smallest, &["4..6", "0..2", "2..4"], "table");
    let table = std::fs::read_to_string(for_boards.folder().join("merged/fits.csv")).unwrap();
    assert_eq!(table.lines().count(), 7, "{table}");
    assert!(table.contains("\na,m4f-168,failed,") && table.contains("\nc,desktop,failed,"), "{table}");
}

/// A file that does not exist and a scene whose mesh file does not exist each give a row, which
/// does not name the folder. A folder is not a scene.
#[test]
#[cfg(unix)]
fn scenes_that_cannot_be_read_are_rows() {
    let desk = Desk::default();
    std::fs::create_dir_all(desk.folder().join("scenes/folder.toml")).unwrap();
    std::os::unix::fs::symlink("nowhere", desk.folder().join("scenes/a.toml")).unwrap();
    let meshed = edited(SMALL_BLOCK, "block_m = [0.08, 0.08, 0.04]", "mesh = \"gone.msh\"\nlength_unit = \"mm\"");
    let meshed = edited(&edited(&meshed, "nodes = 129\n", ""), "position_m = [0.0, 0.0]", "site = [0.0, 0.0, 0.0]");
    desk.put("scenes/b.toml", meshed);
    let scenes = desk.folder().join("scenes").display().to_string();
    are_one(SCRATCH, &desk, 1, &["fit", "--scenes", &scenes], &["0..1", "1..2"], "table");
    let table = std::fs::read_to_string(desk.folder().join("merged/fits.csv")).unwrap();
    assert!(table.lines().count() == 3 && table.contains("\na,,failed,") && table.contains(",gone.msh: cannot read"), "{table}");
}

#[test]
fn ranges_that_cannot_be_run_or_merged_are_refused() {
    let desk = Desk::default();
    for (command, says) in [
        ("fit --cases 0..1", &["--cases: one scene is fitted in one piece", "--scenes"][..]),
        ("fit --scenes . --board desktop --board desktop", &["--board desktop: given twice"]),
        ("loop --cases 2..1", &["--cases", "give A..B with A below B, such as 0..100"]),
        (
            "loop --wall 300 --hand H1 --stimulus S4 --cases 1..2",
            &["--cases 1..2: there are 1 cases: give a range that begins below 1"],
        ),
        ("loop --shard 1/2", &["`--shard` is gone: use --cases A..B, which runs the cases from number A up to B - 1"]),
        ("merge absent", &["absent"]),
        ("merge .", &["there is no rows.csv in it", "--cases"]),
    ] {
        refused(&desk, &command.split(' ').collect::<Vec<_>>(), says);
    }
}

/// Rows of another program than the one that merges, and of a scene that has changed since.
#[test]
fn rows_are_merged_by_their_program_and_with_their_scene() {
    let desk = Desk::default();
    let scene = std::fs::read_to_string(repository().join("host-sim/scenes/coarse-20kpa.toml")).unwrap();
    // the device renders this contact as it is, so that nothing is noted
    let scene = edited(&scene, "20000.0", "18000.0");
    desk.put("scene.toml", &scene);
    let of_loop = ["loop", "--scene", "scene.toml", "--quick", "--hand", "H1", "--stimulus", "S4"];
    are_one(SCRATCH, &desk, 0, &of_loop, &["0..1"], "");
    refused(
        &desk,
        &["merge", "ranges", "--out", "ranges/cases-0-1"],
        &["--out ranges/cases-0-1: it has rows", "choose another folder"],
    );
    desk.put("scene.toml", edited(&scene, "hold_s = 0.3", "hold_s = 0.4"));
    refused(&desk, &["merge", "ranges"], &["the input has changed since the cases ran", "the same files"]);
}

/// Fits of two scenes, and the smallest patches for two boards.
#[test]
#[ignore = "long: finite elements of two fits, and two searches"]
fn fits_in_ranges_are_one_run() {
    let desk = Desk::default();
    std::fs::create_dir(desk.folder().join("scenes")).unwrap();
    desk.put("scenes/small.toml", edited(SMALL_BLOCK, "nodes = 129", "nodes = 60"));
    let block = std::fs::read_to_string(repository().join("host-sim/scenes/block.toml")).unwrap();
    desk.put("scenes/block.toml", edited(&block, "nodes = 410", "nodes = 60"));
    let fit = ["fit", "--scenes", "scenes", "--quick", "--places", "20", "--tolerance-pct=30"];
    are_one(SCRATCH, &desk, 0, &fit, &["1..2", "0..1"], "table");

    let boards = Desk::default();
    std::fs::create_dir(boards.folder().join("scenes")).unwrap();
    boards.put("scenes/block.toml", block);
    let smallest =
        ["fit", "--smallest", "--scenes", "scenes", "--quick", "--tolerance-pct=5", "--board=m4f-168", "--board=m7-480"];
    are_one(SCRATCH, &boards, 0, &smallest, &["1..2", "0..1"], "table");
}
