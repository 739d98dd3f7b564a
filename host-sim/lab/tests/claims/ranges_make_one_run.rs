//! Studies in ranges of cases: `palpate merge` writes files that are byte-identical to those of a
//! single run, or refuses and changes nothing.

use std::collections::BTreeMap;

use palpate_sim::command::campaign::rows::FILE;

use crate::case_ranges::{are_one, ends, files, ranges};
use crate::palpate_command::{Desk, refused};

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");

#[test]
fn faults_in_ranges_are_one_run_and_what_is_amiss_is_refused() {
    let desk = Desk::default();
    let faults = ["faults", "--runs", "150", "--seed", "7"];
    are_one(SCRATCH, &desk, 0, &faults, &["100..999", "0..50", "50..100"], "");
    // missing cases are asked for; nothing is written, and the other rows stay
    let merge = ["merge", "ranges", "--out", "again"];
    let second = desk.folder().join("ranges/cases-50-100");
    let rows = std::fs::read(second.join(FILE)).unwrap();
    std::fs::remove_dir_all(&second).unwrap();
    let rest = files(&desk.folder().join("ranges"));
    refused(SCRATCH, &desk, &merge, &["of 150 cases some are missing: run the command again with --cases 50..100"]);
    assert!(rest == files(&desk.folder().join("ranges")));

    // rows of another seed, then a truncated file
    ends(SCRATCH, &desk, 0, &["faults", "--runs", "150", "--seed", "8", "--cases", "50..100", "--out", "ranges"]);
    let line = "its command line is faults --runs 150 --seed 8, not faults --runs 150 --seed 7";
    refused(SCRATCH, &desk, &merge, &["cases-50-100/rows.csv: ", line]);
    let other = std::fs::read(second.join(FILE)).unwrap();
    std::fs::write(second.join(FILE), &other[..other.len() / 2]).unwrap();
    refused(SCRATCH, &desk, &merge, &["cases-50-100/rows.csv: cut short or damaged"]);

    // only the missing range is run again, and the rest is found
    for cases in ["50..100", "0..50"] {
        ends(SCRATCH, &desk, 0, &[&faults[..], &["--cases", cases, "--out", "ranges"]].concat());
    }
    assert!(rows == std::fs::read(second.join(FILE)).unwrap());
    rest.iter().for_each(|(name, bytes)| assert!(*bytes == files(&desk.folder().join("ranges"))[name], "{name}"));
    ends(SCRATCH, &desk, 0, &merge);
    assert!(files(&desk.folder().join("one")) == files(&desk.folder().join("again")));
}

#[test]
#[ignore = "long: comparison T1 twice; the tests above and below cover what ranges have in common"]
fn measured_tissue_in_ranges_is_one_run() {
    are_one(SCRATCH, &Desk::default(), 0, &["accept", "T1", "T3"], &["0..1", "1..2"], "");
}

/// Every method on two meshes; takes less than two minutes. Tick times, and
/// results that follow from them, are those measured in the ranges.
#[test]
#[ignore = "long: two charts"]
fn charts_in_ranges_are_one_run_but_for_its_times() {
    let desk = Desk::default();
    let chart = ["chart", "--quick"];
    ends(SCRATCH, &desk, 0, &[&chart[..], &["--out", "one"]].concat());
    ranges(SCRATCH, &desk, &chart, &["0..9", "20..999", "9..20"]);
    for out in ["merged", "again"] {
        ends(SCRATCH, &desk, 0, &["merge", "ranges", "--out", out]);
    }
    let [one, merged, again] = ["one", "merged", "again"].map(|out| files(&desk.folder().join(out)));
    assert!(merged == again, "the same rows, merged twice");
    assert_eq!(one.keys().collect::<Vec<_>>(), merged.keys().collect::<Vec<_>>());
    let timed = |name: &str| name.contains("tick_us") || ["chart.csv", "fronts.csv", "summary.json", "report.md"].contains(&name);
    let untimed: Vec<&String> = one.keys().filter(|name| !timed(name)).collect();
    assert!(untimed.iter().any(|name| name.ends_with("m4f_cycles_3.5kpa.png")), "{untimed:?}");
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
