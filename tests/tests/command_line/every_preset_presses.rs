//! Every preset presses and shows its effect: stiffness scales the force, a nodule can be felt, an
//! organ responds, the force in beef falls during a hold, pig liver stiffens.

use palpate_tests::palpate_command::repository;
use palpate_tests::press_run::{PressRun, edited, press, press_preset};

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");

/// Checks that forces are finite and rise with depth, that no tet is inverted, and that the surface
/// is back at rest afterwards.
#[track_caller]
fn sound(run: &PressRun) {
    let holds = run.holds();
    assert_eq!(holds.iter().map(|h| h.target).collect::<Vec<_>>(), [0.001, 0.002, 0.004]);
    assert!(holds.iter().all(|h| h.force_n.is_finite() && h.depth_m.is_finite() && h.min_j > 0.0), "{holds:?}");
    let forces = run.forces_n();
    assert!(forces[0] > 0.0 && forces.is_sorted_by(|a, b| a < b), "{forces:?}");
    assert!(run.number("/residual_m") < 0.05e-3, "{} m left", run.number("/residual_m"));
    assert!(run.summary["fault"].is_null());
    println!("{}: {forces:.4?} N, {} m left", run.summary["scene"], run.number("/residual_m"));
}

#[test]
fn block_presses_and_20_kpa_is_as_much_stiffer_as_its_modulus() {
    let (soft, firm) = (press_preset(SCRATCH, "block"), press_preset(SCRATCH, "block-20kpa"));
    sound(&soft);
    sound(&firm);
    for (soft, firm) in soft.forces_n().into_iter().zip(firm.forces_n()) {
        // statics is linear in E; the motion that remains after a hold of 0.3 s is far below 1 %
        let ratio = firm / soft / (20_000.0 / 3_500.0);
        assert!((ratio - 1.0).abs() < 0.01, "{ratio}");
    }
}

#[test]
fn moving_errors_on_the_page_are_those_that_press_writes() {
    let page = std::fs::read_to_string(repository().join("host-sim/book/src/results/accuracy.md")).unwrap();
    let block = std::fs::read_to_string(repository().join("host-sim/scenes/block.toml")).unwrap();
    for nodes in [130, 410, 1020] {
        let run = press(SCRATCH, &edited(&block, "nodes = 410", &format!("nodes = {nodes}")));
        let rms_pct = |n: usize| run.number(&format!("/moving/{n}/rms_pct"));
        assert_eq!([0, 2, 3].map(|n| run.number(&format!("/moving/{n}/speed_mm_per_s"))), [40.0, 200.0, 500.0]);
        let cell = format!("{:.1} / {:.1} / {:.1} %", rms_pct(0), rms_pct(2), rms_pct(3));
        let named = format!("{nodes} nodes");
        assert!(page.lines().any(|line| line.contains(&named) && line.contains(&cell)), "{named}: {cell}");
    }
}

#[test]
fn nodule_is_felt_at_every_depth() {
    let nodule = press_preset(SCRATCH, "nodule");
    sound(&nodule);
    let text = std::fs::read_to_string(repository().join("host-sim/scenes/nodule.toml")).unwrap();
    let (from, to) = (text.find("[[tissue.inclusion]]").unwrap(), text.find("[probe]").unwrap());
    let plain = press(SCRATCH, &format!("{}{}", &text[..from], &text[to..]));
    sound(&plain);
    assert_eq!(plain.summary["nodes"], nodule.summary["nodes"]);
    assert_eq!(plain.summary["tets"], nodule.summary["tets"]);
    let felt: Vec<f64> = nodule.forces_n().iter().zip(plain.forces_n()).map(|(with, without)| with / without).collect();
    println!("with over without nodule: {felt:.4?}");
    // fingers distinguish forces that differ by 7 %
    assert!(felt.iter().all(|ratio| *ratio > 1.07), "{felt:?}");
    let extra_n: Vec<f64> = nodule.forces_n().iter().zip(plain.forces_n()).map(|(with, without)| with - without).collect();
    assert!(extra_n.is_sorted_by(|a, b| a < b), "{extra_n:?}");
}

#[test]
fn organs_of_our_own_press_and_are_as_large_as_their_files_say() {
    for (name, size_mm) in
        [("abdomen", [300.0, 260.0, 210.0]), ("foot", [250.0, 95.0, 70.0]), ("organ-liver", [169.0, 262.0, 75.0])]
    {
        let organ = press_preset(SCRATCH, name);
        sound(&organ);
        for (axis, size_mm) in size_mm.into_iter().enumerate() {
            let ratio = organ.summary["report"]["size_mm"][axis].as_f64().unwrap() / size_mm;
            assert!((0.9..1.05).contains(&ratio), "{name}: axis {axis}: {ratio}");
        }
        // about the default number of nodes
        assert!((organ.number("/nodes") / 600.0 - 1.0).abs() < 0.15, "{name}");
    }
}

#[test]
fn beef_fades_in_a_hold_and_pig_liver_stiffens() {
    let (beef, liver) = (press_preset(SCRATCH, "beef"), press_preset(SCRATCH, "pig-liver"));
    for run in [&beef, &liver] {
        assert!(run.summary["fault"].is_null());
        assert!(run.holds().iter().all(|h| h.force_n > 0.0 && h.min_j > 0.0), "{:?}", run.holds());
    }
    // the same block at the same modulus, elastic
    let elastic = press_preset(SCRATCH, "block-20kpa");
    let left = beef.forces_n()[1] / elastic.forces_n()[2];
    println!("beef: {left:.3} of the elastic force left at 4 mm; pig liver: {:.4?} N", liver.forces_n());
    // a share of 0.15 remains for good, and another 0.16 decays with a time constant of 4.5 s
    assert!((0.15..0.35).contains(&left), "{left}");
    let forces_n = liver.forces_n();
    let exponent = (forces_n[2] / forces_n[1]).ln() / 1.5_f64.ln();
    assert!(exponent > 2.5, "{exponent}");
}
