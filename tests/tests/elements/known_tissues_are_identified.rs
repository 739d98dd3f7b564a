//! `identify` finds constants that are known, and says where it cannot.

use palpate_fit::identify::axial::Cylinder;
use palpate_fit::identify::elastic::{Elastic, FINENESS, Setup, depths_m};
use palpate_fit::identify::fit::Quantity;
use palpate_fit::identify::model::Tissue;
use palpate_fit::identify::record::{Record, Table};
use palpate_fit::identify::study::{Identified, Plan, identify, identify_within};
use palpate_tests::indentation::{Indentation, Tally};
use palpate_tests::palpate_command::repository;
use serde_json::Value;

const PHANTOM: &str = include_str!("../../../host-sim/book/src/guide/phantom.csv");

fn records(text: &str) -> Vec<Record> {
    let table = Table::read("made up", text).unwrap();
    table.tests.into_iter().map(|(name, rows)| Record::of(&name, &rows, 0.01).unwrap()).collect()
}

fn identified(made: &Indentation, text: &str, leave_out: usize) -> Identified {
    let plan =
        Plan { ball_m: made.setup.ball_m, block_m: made.setup.block_m, poisson_ratio: made.setup.poisson_ratio, leave_out };
    identify(&plan, &records(text)).unwrap()
}

#[test]
fn the_phantom_of_the_guide_is_identified() {
    let made = Indentation::phantom();
    let found = identified(&made, PHANTOM, 1);
    let of = |of: Quantity| found.of(of).unwrap();
    let known = [(Quantity::Modulus, 12e3, 0.05 * 12e3), (Quantity::Exponent, 0.3, 0.2 * 0.3), (Quantity::Share(0), 0.2, 0.05)];
    for (quantity, truth, most) in known {
        let e = of(quantity);
        println!("{quantity:?}: {} in {:?}, made with {truth}", e.value, e.interval);
        assert!((e.value - truth).abs() < most, "{e:?}, made with {truth}");
        assert!(e.told(), "{e:?}");
    }
    assert_eq!(found.tissue.terms.len(), 1);
    let segments = &found.tests[0].segments;
    let named: Vec<(&str, bool)> = segments.iter().map(|(name, _, fitted)| (*name, *fitted)).collect();
    assert_eq!(named, [("press", true), ("hold", true), ("rest of the hold", false), ("retreat", false)]);
    // noise of 1 % of the peak
    assert!(segments.iter().all(|(_, pct, _)| (0.7..1.5).contains(pct)), "{segments:?}");
    let [measured_m, ours_m] = found.tests[0].lift_off_m.unwrap();
    assert!((measured_m - ours_m).abs() < 0.3e-3, "{measured_m} {ours_m}");
}

/// The model of the test is in two dimensions; the stored forces are of finite elements in three.
#[test]
fn the_model_of_the_test_agrees_with_finite_elements_in_three_dimensions() {
    let file: Value = serde_json::from_str(include_str!("../../data/stiffening_reference.json")).unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    let list = |value: &Value| -> Vec<f64> { value.as_array().unwrap().iter().map(number).collect() };
    let setup = Setup { ball_m: 8e-3, block_m: [0.08, 0.08, 0.04], poisson_ratio: 0.45 };
    let mut compared = 0;
    for press in file["press"].as_array().unwrap().iter().filter(|press| number(&press["x_m"]) == 0.0) {
        let (b, depth_m, force_m2) = (number(&press["b"]), list(&press["depth_m"]), list(&press["force_m2"]));
        let deepest_m = depth_m.iter().copied().fold(0.0, f64::max);
        let curve = Elastic::solve_with(&setup, deepest_m, &[b], FINENESS).unwrap().at(b);
        for (depth_m, force_m2) in depth_m.iter().zip(&force_m2) {
            let off = curve.force_m2(*depth_m) / force_m2 - 1.0;
            println!("b = {b}, {:.1} mm: {:+.2} %", depth_m * 1e3, 100.0 * off);
            assert!(off.abs() < 0.015, "b = {b}, {depth_m} m: {off}");
            compared += 1;
        }
    }
    assert!(compared >= 15, "{compared}");
}

/// Exponents between the solved ones, on a press of half the slab's thickness.
#[test]
fn between_the_solved_exponents_the_force_is_that_of_elements() {
    let setup = Setup { ball_m: 6e-3, block_m: [0.1, 0.1, 6e-3], poisson_ratio: 0.45 };
    let deepest_m = 3e-3;
    let between = Elastic::solve(&setup, deepest_m).unwrap();
    for b in [0.2, 2.3, 12.0] {
        let solved = Elastic::solve_with(&setup, deepest_m, &[b], FINENESS).unwrap().at(b);
        for share in [0.2, 0.5, 1.0] {
            let off = between.at(b).force_m2(share * deepest_m) / solved.force_m2(share * deepest_m) - 1.0;
            println!("b = {b}, {share} of the depth: {:+.2} %", 100.0 * off);
            assert!(off.abs() < 0.01, "b = {b}, {share} of the depth: {off}");
        }
    }
}

/// Finer elements at one exponent take off the errors of the other elements and of what lies
/// between the exponents.
#[test]
fn at_the_exponent_that_is_found_the_force_is_that_of_finer_elements() {
    let setup = Setup { ball_m: 7.35e-3, block_m: [0.1, 0.1, 7.94e-3], poisson_ratio: 0.45 };
    let (deepest_m, b) = (3.57e-3, 3.9);
    let finest = Elastic::solve_with(&setup, deepest_m, &[b], 0.07).unwrap().at(b);
    let coarse = Elastic::solve(&setup, deepest_m).unwrap();
    let finer = coarse.clone().finer_at(&setup, b).unwrap();
    let [before, after] = [coarse, finer].map(|elastic| {
        let off = |n: i32| {
            (elastic.at(b).force_m2(0.1 * f64::from(n) * deepest_m) / finest.force_m2(0.1 * f64::from(n) * deepest_m) - 1.0).abs()
        };
        (2..=10).map(off).fold(0.0, f64::max)
    });
    println!("{:.3} % before, {:.3} % after", 100.0 * before, 100.0 * after);
    assert!(after < 0.0015 && after < 0.75 * before, "{before} {after}");
}

#[test]
fn a_shallow_short_press_tells_no_exponent_and_says_so() {
    let made = Indentation { depth_m: 0.8e-3, durations_s: [0.3, 1.0, 0.0, 0.0], noise: 0.02, ..Indentation::phantom() };
    let found = identified(&made, &made.csv(), 0);
    assert!(!found.of(Quantity::Exponent).unwrap().told());
    assert!(!found.of(Quantity::Relaxed).unwrap().told(), "nothing is held");
    let said = found.unsaid.join("\n");
    assert!(said.contains("the exponent b lies between") && said.contains("hold for ten seconds"), "{said}");
}

/// First contact is hard to see where tissue stiffens, so that a left-out test finds its own.
#[test]
fn a_left_out_test_of_stiffening_tissue_is_predicted() {
    let phantom = Indentation::phantom();
    let tissue = Tissue { youngs_modulus_pa: 4.5e3, stiffening_b: 6.0, ..phantom.tissue.clone() };
    let made = Indentation { tissue, ..phantom };
    let records: Vec<Record> = made.repeated(2).iter().map(|rows| Record::of("made up", rows, 0.01).unwrap()).collect();
    let plan = Plan { ball_m: made.setup.ball_m, block_m: made.setup.block_m, poisson_ratio: 0.45, leave_out: 1 };
    let found = identify(&plan, &records).unwrap();
    let left_out = &found.tests[1].segments;
    println!("{left_out:?}");
    // noise of 1 % of the peak
    assert!(left_out.iter().take(2).all(|(_, pct, fitted)| !fitted && *pct < 1.3), "{left_out:?}");
}

#[test]
fn tissue_without_stiffening_is_told_to_have_none() {
    for (seed, depth_m) in [(1, 1e-3), (2, 3e-3)] {
        let phantom = Indentation::phantom();
        let tissue = Tissue { stiffening_b: 0.0, ..phantom.tissue.clone() };
        let made = Indentation { tissue, seed, depth_m, ..phantom };
        let found = identified(&made, &made.csv(), 0);
        println!("{} {:?} {:?}", found.exponent_gain, found.tissue, found.plain);
        assert!(!found.stiffens && found.plain.0.terms.len() == 1, "{} {:?}", found.exponent_gain, found.plain);
        assert!((found.plain.0.youngs_modulus_pa / 12e3 - 1.0).abs() < 0.05, "{:?}", found.plain);
    }
}

fn within(made: &Indentation, range_m: [f64; 2]) -> Result<Identified, String> {
    let plan = Plan { ball_m: made.setup.ball_m, block_m: made.setup.block_m, poisson_ratio: 0.45, leave_out: 0 };
    identify_within(&plan, range_m, &records(&made.csv()))
}

/// Modulus and exponent of such tissue trade off along a narrow valley. With steps of the
/// derivatives a hundred times as long, a fit ended on its slope, near an end of the interval.
#[test]
fn a_fit_of_strongly_stiffening_tissue_reaches_its_minimum() {
    let phantom = Indentation::phantom();
    let tissue = Tissue { stiffening_b: 6.0, ..phantom.tissue.clone() };
    let made = Indentation { tissue, rate_hz: 200.0, noise: 0.003, ..phantom };
    let found = identified(&made, &made.csv(), 0);
    let e = found.of(Quantity::Modulus).unwrap();
    let [low, high] = e.interval;
    let place = (e.value - low) / (high - low);
    println!("{:.0} in {:.0?}, at {place:.2} of it", e.value, e.interval);
    assert!(low < 12e3 && 12e3 < high && (0.35..0.65).contains(&place), "{e:?}");
}

/// A slab that is much thicker than the contact does not show its thickness.
#[test]
fn a_thickness_that_is_not_told_is_refused() {
    let thick = Setup { ball_m: 4e-3, block_m: [0.1, 0.1, 30e-3], poisson_ratio: 0.45 };
    let made = Indentation { setup: thick, depth_m: 2e-3, durations_s: [0.5, 1.0, 3.0, 0.0], ..Indentation::phantom() };
    let why = within(&made, [15e-3, 40e-3]).unwrap_err();
    assert!(why.contains("only the combination of thickness, modulus and exponent") && why.contains("--thickness"), "{why}");
}

/// The best thickness of a range that ends before the true one is no thickness that was found, and
/// what a range leaves open is said with the intervals that the range gives.
#[test]
#[ignore = "a minute of finite elements: ten thicknesses"]
fn a_range_of_thicknesses_says_no_more_than_it_may() {
    let thick = Setup { ball_m: 4e-3, block_m: [0.16, 0.16, 40e-3], poisson_ratio: 0.45 };
    let tissue = Tissue { stiffening_b: 0.0, ..Indentation::phantom().tissue };
    let made = Indentation { setup: thick, tissue, depth_m: 3.2e-3, noise: 0.003, rate_hz: 200.0, ..Indentation::phantom() };
    let why = within(&made, [5e-3, 14e-3]).unwrap_err();
    assert!(why.contains("at the end of the range"), "{why}");
    let found = within(&Indentation::phantom(), [9e-3, 12e-3]).unwrap();
    let b = found.of(Quantity::Exponent).unwrap();
    let said = found.unsaid.join("\n");
    assert!(!b.told() && said.contains(&format!("the exponent b lies between {:.2} and", b.interval[0])), "{b:?}: {said}");
}

/// A thin slab under a deep press without much noise shows its thickness. One 90 % interval in ten
/// misses it, so that two of three have to contain it.
#[test]
#[ignore = "two minutes of finite elements: some ten thicknesses of four presses"]
fn a_thickness_is_found() {
    let thin = Setup { ball_m: 6e-3, block_m: [0.05, 0.05, 6e-3], poisson_ratio: 0.45 };
    let inside = |noise: f64, range_m: [f64; 2], seed: u64| {
        let made = Indentation { setup: thin, depth_m: 2.8e-3, noise, seed, ..Indentation::phantom() };
        let found = within(&made, range_m).unwrap();
        let [low_m, high_m] = found.thickness_m;
        let modulus = found.of(Quantity::Modulus).unwrap();
        println!("noise {noise}: {} in {:?}, {modulus:?}", found.block_m[2], found.thickness_m);
        assert!(high_m < 1.5 * low_m, "{:?}", found.thickness_m);
        low_m <= 6e-3 && 6e-3 <= high_m && modulus.interval[0] <= 12e3 && 12e3 <= modulus.interval[1]
    };
    let quiet: Vec<bool> = (52..55).map(|seed| inside(0.001, [4.5e-3, 9e-3], seed)).collect();
    assert!(quiet.iter().filter(|inside| **inside).count() >= 2, "{quiet:?}");
    assert!(inside(0.01, [5e-3, 7e-3], 52), "the thickness is known before");
}

#[test]
fn the_shipped_phantom_is_the_one_that_is_made() {
    let made = records(&Indentation::phantom().csv()).remove(0);
    let shipped = records(PHANTOM).remove(0);
    let off = made.force_n.iter().zip(&shipped.force_n).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(made.force_n.len() == shipped.force_n.len() && off < 2e-5, "{off}: run rewrite_the_phantom");
}

/// A press is recorded from the surface on, and with a hold of half an hour. The modulus stays, and
/// a zero that the rows do not show is named.
#[test]
fn the_way_in_which_a_test_is_recorded_does_not_change_the_modulus() {
    let made = Indentation { durations_s: [0.5, 2.0, 10.0, 0.0], ..Indentation::phantom() };
    let rows = made.rows();
    let last = rows[rows.len() - 1];
    let held = (1..90_000).map(|n| [last[0] + f64::from(n) * 0.02, last[1], last[2]]);
    let long: Vec<[f64; 3]> = rows.iter().copied().chain(held).collect();
    let from_surface: Vec<[f64; 3]> = rows.iter().copied().filter(|row| row[1] > 1e-3).collect();
    for (name, rows, in_air) in [("long hold", long, true), ("from the surface", from_surface, false)] {
        let plan = Plan { ball_m: made.setup.ball_m, block_m: made.setup.block_m, poisson_ratio: 0.45, leave_out: 0 };
        let found = identify(&plan, &[Record::of(name, &rows, 0.01).unwrap()]).unwrap();
        let e = found.of(Quantity::Modulus).unwrap();
        println!("{name}: E {:.0} in {:.0?}, told {}, {:?}", e.value, e.interval, e.told(), found.tissue.terms);
        assert!((e.value / 12e3 - 1.0).abs() < 0.05, "{name}: {e:?}");
        assert_eq!(found.trusts_zero, !in_air, "{name}");
    }
}

/// Noise may place the first guess of contact at the first rows of one test in three. With a range
/// that ended just after it, all three were fitted 0.28 mm too early, and a modulus 37 % too low
/// was told.
#[test]
fn a_first_guess_of_contact_that_is_too_early_is_left() {
    let made = Indentation::drawn(92);
    let record = |rows: Vec<[f64; 3]>| Record::of("made up", &rows, made.setup.block_m[2]).unwrap();
    let records: Vec<Record> = made.repeated(3).into_iter().map(record).collect();
    assert!(!records.iter().all(|record| record.starts_before), "no guess is too early");
    let plan = Plan { ball_m: made.setup.ball_m, block_m: made.setup.block_m, poisson_ratio: 0.45, leave_out: 0 };
    let found = identify(&plan, &records).unwrap();
    let (e, truth) = (found.of(Quantity::Modulus).unwrap(), made.tissue.youngs_modulus_pa);
    println!("{:.0} in {:.0?}, made with {truth:.0}", e.value, e.interval);
    assert!((e.value / truth - 1.0).abs() < 0.05 && e.interval[0] < truth && truth < e.interval[1], "{e:?}");
    assert!(!found.trusts_zero, "all three come down to the surface");
}

/// Presses whose equilibrium was once not found: the energy of the first was too noisy for the line
/// search, and the second needs depths between those that are asked for.
#[test]
fn presses_find_their_equilibrium() {
    let large_m: f64 = 0.130_731_259_795_419_66;
    for (ball_m, side_m, height_m, stiffening_b, deepest_m) in [
        (0.003_819_671_787_693_569_4, large_m, 0.032_682_814_948_854_916, 1.353_215, 0.002_869_367_862_734_536),
        (0.002_398_655_158_155_878_6, 0.1, 0.005_761_096_211_887_519, 0.0, 0.002_596_7),
    ] {
        let radius_m = (side_m * side_m / std::f64::consts::PI).sqrt();
        let cylinder = Cylinder { ball_m, radius_m, height_m, poisson_ratio: 0.45, stiffening_b, fineness: FINENESS };
        let depths_m = depths_m(deepest_m);
        assert_eq!(cylinder.forces_m2(&depths_m).len(), depths_m.len(), "{cylinder:?}");
    }
}

/// Elements of one size for all depths were 3 % off at the smallest one.
#[test]
fn elements_are_as_good_at_small_depths_as_at_large_ones() {
    let cylinder = |fineness: f64| Cylinder {
        ball_m: 9.49e-3,
        radius_m: 0.056,
        height_m: 5.99e-3,
        poisson_ratio: 0.45,
        stiffening_b: 5.34,
        fineness,
    };
    let depths_m = depths_m(2.75e-3);
    let [coarse, fine] = [FINENESS, 0.1].map(|fineness| cylinder(fineness).forces_m2(&depths_m));
    for ((depth_m, coarse), fine) in depths_m.iter().zip(&coarse).zip(&fine) {
        let off = coarse / fine - 1.0;
        println!("{:.3} mm: {:+.3} %", depth_m * 1e3, 100.0 * off);
        assert!(off.abs() < 0.003, "{depth_m} m: {off}");
    }
    assert_eq!((coarse.len(), fine.len()), (depths_m.len(), depths_m.len()));
}

/// Where first contact is guessed too early, elements are asked for more depth than they have.
#[test]
fn elements_go_as_deep_as_they_can() {
    let setup = Setup { ball_m: 4e-3, block_m: [0.05, 0.05, 0.01], poisson_ratio: 0.45 };
    let elastic = Elastic::solve(&setup, 9e-3).unwrap();
    println!("{:.2} mm", elastic.deepest_m() * 1e3);
    assert!((4e-3..9e-3).contains(&elastic.deepest_m()), "{}", elastic.deepest_m());
}

/// Such a press is not taken for a shallower one whose first contact is later.
#[test]
fn a_press_deeper_than_the_elements_go_is_refused() {
    let phantom = Indentation::phantom();
    let made = Indentation { setup: Setup { block_m: [0.08, 0.08, 0.02], ..phantom.setup }, ..phantom };
    // the law of small depth
    let deep = made.rows().into_iter().map(|[t, d, f]| [t, 2.0 * d, f * 2.0_f64.powf(1.5)]).collect::<Vec<_>>();
    let record = Record::of("deep", &deep, made.setup.block_m[2]).unwrap();
    let plan = Plan { ball_m: made.setup.ball_m, block_m: made.setup.block_m, poisson_ratio: 0.45, leave_out: 0 };
    let error = identify(&plan, &[record]).unwrap_err();
    assert!(error.contains("the tip goes") && error.contains("press no deeper"), "{error}");
}

/// Counts of modulus, exponent and shares over drawn cases of three tests each, as the guide
/// advises, with this many rows per second.
fn counted(rate_hz: f64, cases: u64) -> [Tally; 3] {
    let mut tallies = [Tally::default(); 3];
    for case in 0..cases {
        let made = Indentation { rate_hz, ..Indentation::drawn(case) };
        let record = |rows: Vec<[f64; 3]>| Record::of("made up", &rows, made.setup.block_m[2]).unwrap();
        let records: Vec<Record> = made.repeated(3).into_iter().map(record).collect();
        let Indentation { setup, tissue, .. } = &made;
        let plan = Plan { ball_m: setup.ball_m, block_m: setup.block_m, poisson_ratio: setup.poisson_ratio, leave_out: 0 };
        let found = identify(&plan, &records).unwrap();
        let mut of = |n: usize, quantity: Quantity, truth: f64, most: f64| {
            let e = found.of(quantity).unwrap();
            println!("{case}: {quantity:?} {:.4} in {:.4?}, made with {truth:.4}; told {}", e.value, e.interval, e.told());
            tallies[n].add(truth, e.value, e.interval, most, e.told());
        };
        of(0, Quantity::Modulus, tissue.youngs_modulus_pa, 0.05 * tissue.youngs_modulus_pa);
        of(1, Quantity::Exponent, tissue.stiffening_b, 0.2 * tissue.stiffening_b);
        // another number of terms has other shares
        for (k, (share, _)) in tissue.terms.iter().enumerate().filter(|_| found.tissue.terms.len() == tissue.terms.len()) {
            of(2, Quantity::Share(k), *share, 0.05);
        }
    }
    for (name, tally) in ["modulus", "exponent", "shares"].into_iter().zip(&tallies) {
        println!("{name}: {tally}");
    }
    tallies
}

/// At 60 rows per second four moduli in five are within the target.
#[test]
#[ignore = "finite elements for twenty minutes: 200 tests with known constants"]
fn made_up_tissues_are_identified() {
    for tally in counted(60.0, 200) {
        let [inside, told_right] = [tally.inside(), tally.told_right()];
        assert!((0.85..=0.95).contains(&inside) && told_right >= 0.9, "{tally}");
    }
}

/// Noise differs from row to row, so the many rows of a test machine make up for it.
#[test]
#[ignore = "finite elements for an hour: 200 tests with known constants and many rows"]
fn the_rows_of_a_test_machine_tell_the_modulus() {
    for tally in counted(1000.0, 200) {
        let right = tally.right() >= 0.95 && tally.told_right() >= 0.95;
        assert!((0.85..=0.95).contains(&tally.inside()) && right, "{tally}");
    }
}

#[test]
#[ignore = "writes the data set of the guide"]
fn rewrite_the_phantom() {
    std::fs::write(repository().join("host-sim/book/src/guide/phantom.csv"), Indentation::phantom().csv()).unwrap();
}
