//! Studies in shards: `palpate merge` writes files that are byte-identical to those of a single
//! run, or refuses and changes nothing.

use std::collections::BTreeMap;

use palpate_tissue::shard::FILE;

use crate::palpate_command::{Desk, refused};
use crate::sharded::{are_one, ends, files, shards};

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");

#[test]
fn faults_in_shards_are_one_run_and_what_is_amiss_is_refused() {
    let desk = Desk::default();
    let faults = ["faults", "--runs", "150", "--seed", "7"];
    are_one(SCRATCH, &desk, 0, &faults, &[&["3/3"], &["1/3", "2/3"]], "");

    // the merged result is not written into a shard's folder
    let into_shard = ["merge", "shards", "--out", "shards/shard-1-of-3"];
    refused(SCRATCH, &desk, &into_shard, &["--out shards/shard-1-of-3: it is the folder of a shard", "choose another folder"]);

    // a missing shard is asked for; nothing is written, and the other shards stay
    let merge = ["merge", "shards", "--out", "again"];
    let of = |n: u8| desk.folder().join(format!("shards/shard-{n}-of-3"));
    let second = std::fs::read(of(2).join(FILE)).unwrap();
    std::fs::remove_dir_all(of(2)).unwrap();
    let rest = files(&desk.folder().join("shards"));
    refused(SCRATCH, &desk, &merge, &["1 of 3 shards are missing: --shard 2/3 (as an array: --array=2)"]);
    assert!(rest == files(&desk.folder().join("shards")));

    // a shard with another seed
    ends(SCRATCH, &desk, 0, &["faults", "--runs", "150", "--seed", "8", "--shard", "2/3", "--out", "shards"]);
    refused(SCRATCH, &desk, &merge, &["shard-2-of-3/shard.jsonl: its seed is 8, not 7", "--shard 2/3 "]);
    // a truncated shard
    std::fs::write(of(2).join(FILE), &second[..second.len() / 2]).unwrap();
    refused(SCRATCH, &desk, &merge, &["shard-2-of-3/shard.jsonl is cut short or damaged", "--shard 2/3 "]);
    // a shard that is there twice
    std::fs::write(of(2).join(FILE), &second).unwrap();
    std::fs::create_dir(desk.folder().join("shards/copy")).unwrap();
    std::fs::write(desk.folder().join("shards/copy").join(FILE), &second).unwrap();
    refused(SCRATCH, &desk, &merge, &["shard 2/3 is there twice: ", "copy/shard.jsonl and ", "give one"]);
    std::fs::remove_dir_all(desk.folder().join("shards/copy")).unwrap();
    // a shard of another division of the campaign in the same folder
    ends(SCRATCH, &desk, 0, &[&faults[..], &["--shard", "1/4", "--out", "shards"]].concat());
    refused(SCRATCH, &desk, &merge, &["shard-1-of-4/shard.jsonl: its number of shards is 4, not 3"]);
    std::fs::remove_dir_all(desk.folder().join("shards/shard-1-of-4")).unwrap();
    // none of this changed the other shards
    ends(SCRATCH, &desk, 0, &merge);
    assert!(files(&desk.folder().join("one")) == files(&desk.folder().join("again")));
}

#[test]
#[ignore = "long: comparison T1 twice; the tests above and below cover what shards have in common"]
fn measured_tissue_in_shards_is_one_run() {
    are_one(SCRATCH, &Desk::default(), 0, &["accept", "T1", "T3"], &[&["2/3"], &["1/3", "3/3"]], "");
}

/// Every method on two meshes, including the terms; takes less than two minutes. Tick times, and
/// results that follow from them, are those measured in the shards.
#[test]
#[ignore = "long: two charts"]
fn charts_in_shards_are_one_run_but_for_its_times() {
    let desk = Desk::default();
    let chart = ["chart", "--quick", "--terms"];
    ends(SCRATCH, &desk, 0, &[&chart[..], &["--out", "one"]].concat());
    shards(SCRATCH, &desk, &chart, &[&["1/4", "2/4"], &["4/4"], &["3/4"]]);
    for out in ["merged", "again"] {
        ends(SCRATCH, &desk, 0, &["merge", "shards", "--out", out]);
    }
    let [one, merged, again] = ["one", "merged", "again"].map(|out| files(&desk.folder().join(out)));
    assert!(merged == again, "the same shards, merged twice");
    assert_eq!(one.keys().collect::<Vec<_>>(), merged.keys().collect::<Vec<_>>());
    let timed = |name: &str| name.contains("tick_us") || ["chart.csv", "fronts.csv", "summary.json", "report.md"].contains(&name);
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
    let untimed = |files| {
        let fronts = text(files, "fronts.csv");
        let untimed: Vec<String> = fronts.lines().filter(|row| row.contains("m4f_cycles")).map(str::to_owned).collect();
        assert!(!untimed.is_empty());
        untimed
    };
    assert_eq!(untimed(&one), untimed(&merged));
}
