//! Equation (14) of paper 004, and its agreement with Table 1.

use palpate_lab::score::statistics::permutation_test;
use palpate_lab::score::table_1::{Check, PRINTED, marks_for};
use palpate_lab::score::{PAPER_WEIGHTS, value};

#[test]
fn values_by_hand() {
    // 0.4 * 0.45 + 0.5 * 0.35 + 0.6 * 0.20 and 0.9 * 0.45 + 0.8 * 0.35 + 1.0 * 0.20
    let values = [[4.0, 5.0, 6.0], [9.0, 8.0, 10.0]].map(|marks| value(marks, PAPER_WEIGHTS));
    assert!((values[0] - 0.475).abs() < 1e-12 && (values[1] - 0.885).abs() < 1e-12);
    assert_eq!(value([10.0; 3], PAPER_WEIGHTS), 1.0);
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
        assert_eq!(marks_for(printed, PAPER_WEIGHTS), ways, "{printed}");
    }
    // the test can fail: 190 and 199 of 200 are not such sums
    assert_eq!(marks_for(0.95, PAPER_WEIGHTS), 0);
    assert_eq!(marks_for(0.995, PAPER_WEIGHTS), 0);
    // other weights do not give the table
    assert!(PRINTED.iter().flatten().any(|v| marks_for(*v, [0.5, 0.3, 0.2]) == 0));
}

#[test]
fn the_table_has_the_shape_the_paper_claims() {
    let check = Check::run();
    assert!(check.claims().iter().all(|(_, holds)| *holds), "{check:?}");
    // column sums of the printed table
    for (mean, sum) in check.means.iter().zip([4.815, 4.240, 9.385, 7.835]) {
        assert!((mean - sum / 10.0).abs() < 1e-9, "{:?}", check.means);
    }
    let column = |n: usize| PRINTED.map(|row| row[n]);
    let test = permutation_test(&column(2), &column(3)).unwrap();
    assert_eq!((test.deals, test.exact), (184_756, true));
    assert_eq!(check.after.1, test.p);
}
