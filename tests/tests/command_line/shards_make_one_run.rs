//! Campaigns in shards: `palpate merge` writes files that are byte-identical to those of a single
//! run, or refuses and changes nothing.

use std::collections::BTreeMap;
use std::path::Path;

use palpate_tests::palpate_command::{Desk, binary, palpate, repository};
use palpate_tests::press_run::{SMALL_BLOCK, edited};
use palpate_tissue::shard::{FILE, Heading, Part, Shard, checksum};
use serde_json::{Value, json};

use crate::bad_input_says_what_where_how::refused;

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");

/// Bytes of every file below a folder, by its path relative to that folder.
fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let name = entry.file_name().to_string_lossy().into_owned();
        if entry.path().is_dir() {
            found.extend(files(&entry.path()).into_iter().map(|(below, bytes)| (format!("{name}/{below}"), bytes)));
        } else {
            found.insert(name, std::fs::read(entry.path()).unwrap());
        }
    }
    found
}

/// Runs a command, which must exit with `code`.
#[track_caller]
fn ends(desk: &Desk, code: i32, arguments: &[&str]) {
    let outcome = palpate(SCRATCH, desk.folder(), arguments);
    assert_eq!(outcome.code, Some(code), "{arguments:?}: {outcome:?}");
}

/// Runs shards of a command into `shards`, one process per group of shards.
#[track_caller]
fn shards(desk: &Desk, command: &[&str], groups: &[&[&str]]) {
    for group in groups {
        let options: Vec<&str> = group.iter().flat_map(|shard| ["--shard", shard]).collect();
        ends(desk, 0, &[command, &["--out", "shards"], &options].concat());
    }
}

/// Checks that a single run of a command and the merge of its shards write the same files with the
/// same bytes, and that both exit with `code`. `whole` is the folder, below the single run's, that
/// contains the result to compare.
#[track_caller]
fn are_one(desk: &Desk, code: i32, command: &[&str], groups: &[&[&str]], whole: &str) {
    ends(desk, code, &[command, &["--out", "one"]].concat());
    shards(desk, command, groups);
    ends(desk, code, &["merge", "shards", "--out", "merged"]);
    let (one, merged) = (files(&desk.folder().join("one").join(whole)), files(&desk.folder().join("merged")));
    assert!(one.len() > 1 && one.contains_key("summary.json"), "{:?}", one.keys());
    assert_eq!(one.keys().collect::<Vec<_>>(), merged.keys().collect::<Vec<_>>());
    for (name, bytes) in &one {
        assert!(*bytes == merged[name], "{name} of {command:?} differs");
    }
}

#[test]
fn faults_in_shards_are_one_run_and_what_is_amiss_is_refused() {
    let desk = Desk::default();
    let faults = ["faults", "--runs", "150", "--seed", "7"];
    are_one(&desk, 0, &faults, &[&["3/3"], &["1/3", "2/3"]], "");

    // the merged result is not written into a shard's folder
    let into_shard = ["merge", "shards", "--out", "shards/shard-1-of-3"];
    refused(&desk, &into_shard, &["--out shards/shard-1-of-3: it is the folder of a shard", "choose another folder"]);

    // a missing shard is asked for; nothing is written, and the other shards stay
    let merge = ["merge", "shards", "--out", "again"];
    let of = |n: u8| desk.folder().join(format!("shards/shard-{n}-of-3"));
    let second = std::fs::read(of(2).join(FILE)).unwrap();
    std::fs::remove_dir_all(of(2)).unwrap();
    let rest = files(&desk.folder().join("shards"));
    refused(&desk, &merge, &["1 of 3 shards are missing: --shard 2/3 (as an array: --array=2)"]);
    assert!(rest == files(&desk.folder().join("shards")));

    // a shard with another seed
    ends(&desk, 0, &["faults", "--runs", "150", "--seed", "8", "--shard", "2/3", "--out", "shards"]);
    refused(&desk, &merge, &["shard-2-of-3/shard.jsonl: its seed is 8, not 7", "--shard 2/3 "]);
    // a truncated shard
    std::fs::write(of(2).join(FILE), &second[..second.len() / 2]).unwrap();
    refused(&desk, &merge, &["shard-2-of-3/shard.jsonl is cut short or damaged", "--shard 2/3 "]);
    // a shard that is there twice
    std::fs::write(of(2).join(FILE), &second).unwrap();
    std::fs::create_dir(desk.folder().join("shards/copy")).unwrap();
    std::fs::write(desk.folder().join("shards/copy").join(FILE), &second).unwrap();
    refused(&desk, &merge, &["shard 2/3 is there twice: ", "copy/shard.jsonl and ", "give one"]);
    std::fs::remove_dir_all(desk.folder().join("shards/copy")).unwrap();
    // a shard of another division of the campaign in the same folder
    ends(&desk, 0, &[&faults[..], &["--shard", "1/4", "--out", "shards"]].concat());
    refused(&desk, &merge, &["shard-1-of-4/shard.jsonl: its number of shards is 4, not 3"]);
    std::fs::remove_dir_all(desk.folder().join("shards/shard-1-of-4")).unwrap();
    // none of this changed the other shards
    ends(&desk, 0, &merge);
    assert!(files(&desk.folder().join("one")) == files(&desk.folder().join("again")));
}

#[test]
#[ignore = "long: comparison T1 twice; the tests above and below cover what shards have in common"]
fn measured_tissue_in_shards_is_one_run() {
    are_one(&Desk::default(), 0, &["accept", "T1", "T3"], &[&["2/3"], &["1/3", "3/3"]], "");
}

/// Neither fit nor plan is possible for these scenes; the merged table still equals that of a
/// single run.
#[test]
fn tables_of_scenes_in_shards_are_one_run() {
    let desk = Desk::default();
    std::fs::create_dir(desk.folder().join("scenes")).unwrap();
    let stiffens = edited(SMALL_BLOCK, "nodes = 129", "nodes = 60\nstiffening_b = 3.0");
    desk.put("scenes/a.toml", &stiffens);
    desk.put("scenes/b.toml", "name = 3");
    desk.put("scenes/c.toml", edited(&stiffens, "3500.0", "3.5"));
    are_one(&desk, 1, &["fit", "--scenes", "scenes"], &[&["1/2"], &["2/2"]], "table");
    let table = std::fs::read_to_string(desk.folder().join("merged/fits.csv")).unwrap();
    assert!(table.contains("\na,failed,") && table.contains("tissue.stiffening_b = 3"), "{table}");

    let desk_of_plans = Desk::default();
    let scenes = desk.folder().join("scenes").display().to_string();
    let plan = ["plan", "--scenes", &scenes, "--tolerance-pct", "3", "--board", "m4f-168", "--board", "desktop"];
    are_one(&desk_of_plans, 1, &plan, &[&["1/3", "3/3"], &["2/3"]], "table");
    let table = std::fs::read_to_string(desk_of_plans.folder().join("merged/plans.csv")).unwrap();
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
    ends(&desk, 1, &["fit", "--scenes", "scenes", "--out", "one"]);
    let scenes = desk.folder().join("scenes").display().to_string();
    shards(&desk, &["fit", "--scenes", &scenes], &[&["1/2"], &["2/2"]]);
    ends(&desk, 1, &["merge", "shards", "--out", "merged"]);
    let table = |path: &str| std::fs::read_to_string(desk.folder().join(path)).unwrap();
    let one = table("one/table/fits.csv");
    assert_eq!(one, table("merged/fits.csv"));
    assert!(one.lines().count() == 3 && one.contains("\na,failed,") && one.contains(",gone.msh: cannot read"), "{one}");
}

#[test]
fn what_cannot_be_split_and_what_is_no_shard() {
    let desk = Desk::default();
    desk.put("scene.toml", SMALL_BLOCK);
    refused(&desk, &["fit", "--shard", "1/2"], &["--shard: one scene is fitted in one piece", "--scenes"]);
    let plan = |more: &[&'static str]| [&["plan", "--tolerance-pct", "3"], more].concat();
    refused(&desk, &plan(&["--shard", "1/2"]), &["--shard: one scene is planned in one piece", "--scenes"]);
    refused(&desk, &plan(&["--board", "desktop", "--board", "m7-480"]), &["--board", "give one, or --scenes"]);
    refused(&desk, &plan(&["--scenes", ".", "--board", "desktop", "--board", "desktop"]), &["--board desktop: given twice"]);
    refused(&desk, &["plan", "--tolerance-pct", "0", "--scenes", "."], &["--tolerance-pct 0", "above 0"]);
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
    let of_faults = options(&[("runs", json!(100)), ("seed", json!(1))]);
    let heading = Heading::new("faults", of_faults, BTreeMap::new(), 100, all).unwrap();
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
    shards(&desk, &of_loop, &[&["1/1"]]);
    desk.put("scene.toml", edited(&scene, "hold_s = 0.3", "hold_s = 0.4"));
    refused(&desk, &["merge", "shards"], &["the input of `palpate loop` is no longer that of the shards", "the same files"]);
    desk.put("scene.toml", scene);
    ends(&desk, 0, &["merge", "shards", "--out", "merged"]);
}

/// Every method on two meshes, including the terms; takes less than two minutes. Tick times, and
/// results that follow from them, are those measured in the shards.
#[test]
#[ignore = "long: two charts"]
fn charts_in_shards_are_one_run_but_for_its_times() {
    let desk = Desk::default();
    let chart = ["chart", "--quick", "--terms"];
    ends(&desk, 0, &[&chart[..], &["--out", "one"]].concat());
    shards(&desk, &chart, &[&["1/4", "2/4"], &["4/4"], &["3/4"]]);
    for out in ["merged", "again"] {
        ends(&desk, 0, &["merge", "shards", "--out", out]);
    }
    let [one, merged, again] = ["one", "merged", "again"].map(|out| files(&desk.folder().join(out)));
    assert!(merged == again, "the same shards, merged twice");
    assert_eq!(one.keys().collect::<Vec<_>>(), merged.keys().collect::<Vec<_>>());
    let timed = |name: &str| name.contains("tick_us") || ["chart.csv", "summary.json"].contains(&name);
    let untimed: Vec<&String> = one.keys().filter(|name| !timed(name)).collect();
    assert!(untimed.iter().any(|name| name.ends_with("m4f_cycles_3.5kpa.png")) && one.contains_key("terms.csv"), "{untimed:?}");
    untimed.into_iter().for_each(|name| assert!(one[name] == merged[name], "{name} differs"));

    let text = |files: &BTreeMap<String, Vec<u8>>, name: &str| String::from_utf8(files[name].clone()).unwrap();
    let without_times = |csv: &str| -> Vec<Vec<String>> {
        let mut rows = csv.lines().map(|line| line.split(',').map(str::to_owned).collect::<Vec<_>>());
        let header = rows.next().unwrap();
        let kept = |n: &usize| !["tick_min_us", "tick_median_us", "times_springs"].contains(&&*header[*n]);
        rows.map(|row| (0..row.len()).filter(kept).map(|n| row[n].clone()).collect()).collect()
    };
    let [rows, rows_merged] = [&one, &merged].map(|files| without_times(&text(files, "chart.csv")));
    assert!(rows.len() > 20 && rows == rows_merged);
    let untimed_summary = |files| {
        let mut summary: Value = serde_json::from_str(&text(files, "summary.json")).unwrap();
        let fronts = summary["fronts"].as_array_mut().unwrap();
        fronts.retain(|front| front["cost"] != "tick_us");
        assert!(!fronts.is_empty());
        summary["moving_fronts"].take();
        summary
    };
    assert_eq!(untimed_summary(&one), untimed_summary(&merged));
}

/// Fits of two scenes, and plans for two boards.
#[test]
#[ignore = "long: finite elements of two fits, and two plans"]
fn fits_and_plans_in_shards_are_one_run() {
    let desk = Desk::default();
    std::fs::create_dir(desk.folder().join("scenes")).unwrap();
    desk.put("scenes/small.toml", edited(SMALL_BLOCK, "nodes = 129", "nodes = 60"));
    let block = std::fs::read_to_string(repository().join("host-sim/scenes/block.toml")).unwrap();
    desk.put("scenes/block.toml", edited(&block, "nodes = 410", "nodes = 60"));
    let fit = ["fit", "--scenes", "scenes", "--quick", "--places", "20", "--tolerance-pct=30"];
    are_one(&desk, 0, &fit, &[&["2/2"], &["1/2"]], "table");

    let plans = Desk::default();
    std::fs::create_dir(plans.folder().join("scenes")).unwrap();
    plans.put("scenes/block.toml", block);
    let plan = ["plan", "--scenes", "scenes", "--quick", "--tolerance-pct=5", "--board=m4f-168", "--board=m7-480"];
    are_one(&plans, 0, &plan, &[&["2/2"], &["1/2"]], "table");
}
