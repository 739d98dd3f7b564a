//! The stored references: each is complete, and a new computation reproduces it.

use palpate_lab::dynamic::truths::Computed;
use palpate_tissue::answer::Answer;
use palpate_tissue::moving::truth::{Site, TRUTHS, Trajectory, Truth};

use crate::dynamic_truth::coarse;
use crate::hanging::assert_within;

#[test]
fn every_table_is_read_and_ends_near_the_static_force() {
    for truth in TRUTHS {
        let table = truth.stored().expect("a table that was written by the example");
        let motion = truth.motion();
        let last = table.rows.last().expect("not empty");
        assert!((last.t_s - motion.duration_s()).abs() <= 0.5 * truth.spacing_s() + 1e-9, "{}", truth.name);
        for row in &table.rows {
            let pose = motion.pose(row.t_s);
            assert!((row.depth_m - pose.depth_m).abs() < 1e-6, "{}: {row:?}", truth.name);
            assert!(row.force_over_e_m2[2] >= 0.0, "{}: {row:?}", truth.name);
        }
        // at the end of the hold, some per cent of the wave caused by the stop remain
        let held_m2 = match truth.site {
            Site::Nodule => read("nodule.json"),
            Site::Centre | Site::Aside | Site::Askew => read("block.json"),
        };
        if let (Trajectory::Ramp { .. }, Some(held_m2)) = (truth.trajectory, held_m2) {
            assert_within(truth.name, last.force_over_e_m2[2], held_m2, 0.05);
        }
    }
}

/// Force over E [m^2] of the shipped static reference for a centred press of 4 mm.
fn read(file: &str) -> Option<f64> {
    let folder = crate::palpate_command::repository().join("host-sim/references");
    let answer = Answer::load(&folder.join(file)).expect("shipped");
    answer.hold([0.0; 3], 0.004).map(|hold| hold.force_over_e_m2)
}

#[test]
fn a_coarse_computation_gives_the_stored_force_again() {
    for name in ["centre-20kpa-200", "centre-3.5kpa-500"] {
        let truth = Truth::named(name).expect("stored");
        let stored = truth.stored().expect("read");
        let history = truth.compute(&coarse(), |_| {}).expect("converges");
        let again = truth.table(&history);
        assert_eq!(again.rows.len(), stored.rows.len());
        let peak_m2 = stored.rows.iter().map(|row| row.force_over_e_m2[2]).fold(0.0, f64::max);
        let off = again.rows.iter().zip(&stored.rows).map(|(a, b)| (a.force_over_e_m2[2] - b.force_over_e_m2[2]).powi(2));
        let rms = (off.sum::<f64>() / stored.rows.len() as f64).sqrt() / peak_m2;
        assert!(rms < 0.02, "{name}: {rms} of the peak off");
    }
}
