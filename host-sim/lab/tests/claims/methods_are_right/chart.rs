//! The front of the best methods, and the files of `palpate chart`.

use crate::palpate_command::{Desk, palpate};
use palpate_lab::chart::{Reference, Scope, Task, front, front_of_three, measure};
use palpate_lab::methods::{Block, Method};

#[test]
fn the_front_is_what_nothing_beats() {
    // (cost, error): 1 is better than 0 at the same cost, 3 is worse than 2 in both, 4 equals 2, 5
    // is the most accurate, 6 and 7 contain values that are not finite
    let points = [(1.0, 9.0), (1.0, 8.0), (2.0, 4.0), (3.0, 5.0), (2.0, 4.0), (10.0, 1.0), (f64::NAN, 0.1), (0.5, f64::INFINITY)];
    assert_eq!(front(&points), [1, 2, 5]);
    assert!(front(&[]).is_empty());
}

#[test]
fn the_front_of_three_is_what_nothing_matches() {
    // 1 is better than 0 in one of three, 2 is worse than 1 in all, 3 is best in the last, 4 equals
    // 3, 5 is not a number
    let points = [[1.0, 9.0, 2.0], [1.0, 8.0, 2.0], [2.0, 9.0, 3.0], [5.0, 9.0, 1.0], [5.0, 9.0, 1.0], [0.1, 0.1, f64::NAN]];
    assert_eq!(front_of_three(&points), [1, 3]);
    assert!(front_of_three(&[]).is_empty());
}

/// Shorter substeps with lighter masses do not change the held force and remove most of the moving
/// error in stiff tissue. A stiffness without a dynamic reference has no moving error.
#[test]
fn shorter_substeps_take_the_floored_masses_out_of_a_moving_probe() {
    let rows = |youngs_modulus_pa: f64, moving: bool| {
        let block = Block::standard(57, youngs_modulus_pa).unwrap();
        let task = |refinement| Task { method: Method::Palpate, nodes: 57, youngs_modulus_pa, refinement };
        measure(&[task(1), task(2)], &block, &Reference::block(), moving).unwrap()
    };
    let stiff = rows(20_000.0, true);
    let [whole, split] = [0, 1].map(|n| *stiff[n].survived().unwrap());
    assert_eq!(split.substeps, 2 * whole.substeps);
    let [held, held_split] = [whole, split].map(|m| m.accuracy.rms_pct().unwrap());
    assert!((held / held_split - 1.0).abs() < 0.02, "{held} % and {held_split} % held");
    let [moving, moving_split] = [whole, split].map(|m| m.moving_rms_pct().unwrap());
    println!("held {held:.2} and {held_split:.2} %, moving {moving:.2} and {moving_split:.2} %");
    assert!(moving_split < 0.6 * moving, "{moving_split} % beside {moving} %");
    assert!(rows(5000.0, true).iter().all(|r| r.survived().unwrap().moving.is_none()));
    assert!(rows(20_000.0, false).iter().all(|r| r.survived().unwrap().moving.is_none()));
    let splits = |scope: Scope| scope.tasks.iter().map(|t| t.refinement).max();
    assert_eq!((splits(Scope::quick(false)), splits(Scope::quick(true))), (Some(1), Some(4)));
}

/// Cells of a line; none of the chart's texts contains a comma.
fn cells(line: &str) -> Vec<&str> {
    line.split(',').collect()
}

#[test]
fn quick_chart_leaves_what_it_promises() {
    let desk = Desk::default();
    let outcome = palpate(env!("CARGO_TARGET_TMPDIR"), desk.folder(), &["chart", "--quick"]);
    assert_eq!(outcome.code, Some(0), "{}{}", outcome.stdout, outcome.stderr);
    let out = desk.folder().join("out/chart");
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));

    let csv = read("chart.csv");
    let mut lines = csv.lines();
    let header = cells(lines.next().expect("a header"));
    let column = |name: &str| header.iter().position(|h| *h == name).unwrap_or_else(|| panic!("no column {name} in {header:?}"));
    let rows: Vec<Vec<&str>> = lines.map(cells).collect();
    for row in &rows {
        assert_eq!(row.len(), header.len(), "{row:?}");
    }
    let methods: std::collections::BTreeSet<_> = rows.iter().map(|r| r[0]).collect();
    for wanted in [
        "springs",
        "volume-preserved",
        "local-compression",
        "springs-volume-tet",
        "springs-volume-nodal",
        "palpate",
        "corotational",
        "neo-hookean",
        "neo-hookean-nodal",
        "meshless",
        "xpbd",
        "implicit",
        "compliance",
    ] {
        assert!(methods.contains(wanted), "no row of {wanted} in {methods:?}");
        let survived = rows.iter().filter(|r| r[0] == wanted && r[column("survives_8mm")] == "yes");
        for row in survived {
            for name in ["substeps", "tick_min_us", "times_springs", "m4f_cycles_estimate", "force_4mm_n", "force_rms_pct"] {
                let value: f64 = row[column(name)].parse().unwrap_or_else(|e| panic!("{name} of {row:?}: {e}"));
                assert!(value > 0.0, "{name} of {row:?}");
            }
        }
    }

    let summary: serde_json::Value = serde_json::from_str(&read("summary.json")).expect("JSON");
    assert!(summary["provenance"]["machine"]["processor"].as_str().is_some_and(|m| !m.is_empty()));
    assert!(summary["provenance"]["profile"].as_str().is_some_and(|profile| !profile.is_empty()));
    let fronts = read("fronts.csv");
    let fronts: Vec<Vec<&str>> = fronts.lines().skip(1).map(cells).collect();
    assert!(!fronts.is_empty());
    for front in fronts.chunk_by(|a, b| a[..3] == b[..3]) {
        let number = |cell: &str| cell.parse::<f64>().unwrap();
        let falls = front.windows(2).all(|p| number(p[0][6]) <= number(p[1][6]) && number(p[0][7]) > number(p[1][7]));
        assert!(falls, "a front goes down: {front:?}");
    }
    for name in ["force_rms_pct_over_tick_us_3.5kpa", "force_rms_pct_over_m4f_cycles_3.5kpa"] {
        assert!(read(&format!("{name}.svg")).contains("neo-hookean-nodal"), "the legend of {name}");
        let picture = std::fs::read(out.join(format!("{name}.png"))).unwrap_or_else(|e| panic!("{name}.png: {e}"));
        assert!(picture.starts_with(b"\x89PNG"), "{name}.png");
    }
}
