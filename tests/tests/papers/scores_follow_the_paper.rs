//! `palpate score`: equation (14) of paper 004, its agreement with Table 1, and the errors for a
//! bad file of marks.

use std::fs;

use palpate_lab::score::statistics::permutation_test;
use palpate_lab::score::table_1::{Check, PRINTED, marks_for};
use palpate_lab::score::{Analysis, Weights, evaluate, parse};
use palpate_tests::palpate_command::{Desk, palpate, repository};

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");
const GOOD: &str = "group,phase,intern,chief,associate,attending\n1,before,A,4,5,6\n1,after,A,9,8,10\n";

#[test]
fn values_by_hand() {
    let values = evaluate(&parse("x", GOOD.as_bytes()).unwrap(), &Weights::PAPER);
    // 0.4 * 0.45 + 0.5 * 0.35 + 0.6 * 0.20 and 0.9 * 0.45 + 0.8 * 0.35 + 1.0 * 0.20
    assert!((values[0].value - 0.475).abs() < 1e-12 && (values[1].value - 0.885).abs() < 1e-12);
    let change = &Analysis::of(&values).changes[0].spread;
    assert!(change.count == 1 && (change.mean - 0.41).abs() < 1e-12);
    assert_eq!(Weights::PAPER.value([10.0; 3]), 1.0);
}

#[test]
fn columns_are_found_by_name_and_labels_may_be_quoted() {
    let moved = "\u{feff}attending,associate,chief,intern,phase,group\n# a remark\n6,5,4,\"A, B\",before,1\n";
    let marks = parse("x", moved.as_bytes()).unwrap();
    assert_eq!((marks[0].marks, marks[0].intern.as_str()), ([4.0, 5.0, 6.0], "A, B"));
}

/// In whole numbers: 200 y = 9 a + 7 b + 4 c.
#[test]
fn every_printed_value_is_one_that_whole_marks_give() {
    for printed in PRINTED.into_iter().flatten() {
        let parts = (printed * 200.0).round() as u32;
        assert!((f64::from(parts) / 200.0 - printed).abs() < 1e-9, "{printed}");
        let all = (0..1331).map(|n| (n / 121, n / 11 % 11, n % 11));
        let ways = all.filter(|(a, b, c)| 9 * a + 7 * b + 4 * c == parts).count();
        assert!(ways > 0, "{printed}");
        assert_eq!(marks_for(printed, &Weights::PAPER).0, ways, "{printed}");
    }
    // the test can fail: 190 and 199 of 200 are not such sums
    assert_eq!(marks_for(0.95, &Weights::PAPER), (0, None));
    assert_eq!(marks_for(0.995, &Weights::PAPER), (0, None));
    // other weights do not give the table
    let equal = Weights::new([0.5, 0.3, 0.2]).unwrap();
    assert!(PRINTED.iter().flatten().any(|v| marks_for(*v, &equal).0 == 0));
}

#[test]
fn the_table_has_the_shape_the_paper_claims() {
    let check = Check::run(&Weights::PAPER);
    assert!(check.claims().iter().all(|(_, holds)| *holds), "{check:?}");
    let means: Vec<f64> = check.columns.iter().map(|c| c.spread.mean).collect();
    // column sums of the printed table
    for (mean, sum) in means.iter().zip([4.815, 4.240, 9.385, 7.835]) {
        assert!((mean - sum / 10.0).abs() < 1e-9, "{means:?}");
    }
    let column = |n: usize| PRINTED.map(|row| row[n]);
    let (a, b) = (column(2), column(3));
    let test = permutation_test(&a, &b).unwrap();
    assert_eq!((test.deals, test.exact), (184_756, true));
    assert_eq!(check.after.1, test.p);
}

#[test]
fn the_command_writes_and_says_what_it_found() {
    let desk = Desk::default();
    let example = repository().join("host-sim/examples/scores.csv");
    let outcome = palpate(SCRATCH, desk.folder(), &["score", example.to_str().unwrap(), "--out", "out"]);
    assert_eq!((outcome.code, outcome.stderr.as_str()), (Some(0), ""), "{outcome:?}");
    assert!(outcome.stdout.contains("permutation test"), "{outcome:?}");
    for name in ["summary.json", "scores.csv", "scores.svg", "scores.png"] {
        assert!(desk.folder().join("out").join(name).is_file(), "{name}");
    }
    let rows = fs::read_to_string(desk.folder().join("out/scores.csv")).unwrap();
    assert_eq!(rows.lines().next(), Some("group,phase,intern,value"));
    assert_eq!(rows.lines().count(), parse("x", &fs::read(example).unwrap()).unwrap().len() + 1);
    let summary: serde_json::Value = serde_json::from_slice(&fs::read(desk.folder().join("out/summary.json")).unwrap()).unwrap();
    assert_eq!(summary["contrasts"].as_array().map(Vec::len), Some(3));

    let outcome = palpate(SCRATCH, desk.folder(), &["score", "--table-1", "--out", "table"]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert_eq!(outcome.stdout.matches("10 of 10").count(), 4, "{outcome:?}");
}

#[test]
fn bad_input_is_refused_in_one_line_and_writes_nothing() {
    let desk = Desk::default();
    let refused = |arguments: &[&str], says: &[&str]| {
        let before = desk.listing();
        let outcome = palpate(SCRATCH, desk.folder(), arguments);
        assert_eq!((outcome.code, outcome.stdout.as_str()), (Some(2), ""), "{outcome:?}");
        assert_eq!(outcome.stderr.lines().count(), 1, "{outcome:?}");
        assert!(says.iter().all(|words| outcome.stderr.contains(words)), "{says:?}: {outcome:?}");
        assert_eq!(desk.listing(), before, "{outcome:?}");
    };
    let score = ["score", "marks.csv", "--out", "out"];
    refused(&score, &["marks.csv", "check the path"]);
    let header = "group,phase,intern,chief,associate,attending\n";
    for (content, says) in [
        ("", &["marks.csv: the file is empty", "write the header"][..]),
        (header, &["no row below the header"]),
        ("group,phase,intern,chief,associate\n1,before,A,1,2\n", &["marks.csv:1", "\"attending\" is missing"]),
        ("group,phase,intern,chief,associate,attending,age\n", &["marks.csv:1", "\"age\" is unknown"]),
        ("group,phase,intern,chief,associate,attending,chief\n", &["\"chief\" is there twice"]),
    ] {
        desk.put("marks.csv", content);
        refused(&score, says);
    }
    for (from, to, says) in [
        ("9,8,10", "9,8,11", &["marks.csv:3", "attending is \"11\"", "0 to 10"][..]),
        ("4,5,6", "-0.5,5,6", &["marks.csv:2", "chief is \"-0.5\"", "0 to 10"]),
        ("4,5,6", "4,good,6", &["marks.csv:2", "associate is \"good\"", "not a number"]),
        ("4,5,6", "4,,6", &["marks.csv:2", "associate is \"\"", "not a number"]),
        ("4,5,6", "4,NaN,6", &["marks.csv:2", "associate is \"NaN\"", "0 to 10"]),
        ("4,5,6", "4,5", &["marks.csv:2", "5 cells where the header has 6"]),
        ("1,before,A", "1,during,A", &["marks.csv:2", "phase is \"during\"", "before or after"]),
        ("1,before,A", ",before,A", &["marks.csv:2", "group is \"\"", "name"]),
        ("1,after,A", "1,before,A", &["marks.csv:3", "intern \"A\"", "twice", "line 2", "keep one"]),
    ] {
        desk.put("marks.csv", GOOD.replace(from, to));
        refused(&score, says);
    }
    desk.put("marks.csv", [GOOD.as_bytes(), b"\xff,after,B,1,2,3\n"].concat());
    refused(&score, &["marks.csv:4", "not UTF-8"]);
    desk.put("marks.csv", GOOD);
    for (weights, says) in [
        ("0.5,0.3,0.1", &["sum to 0.9", "three shares above zero"][..]),
        ("1.2,-0.1,-0.1", &["above zero"]),
        ("0.5,0.5", &["not three numbers"]),
        ("a,b,c", &["not three numbers"]),
        ("NaN,0.5,0.5", &["three shares above zero"]),
    ] {
        refused(&["score", "marks.csv", "--weights", weights, "--out", "out"], says);
    }
}
