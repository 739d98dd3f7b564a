//! The product's patches in the loop: shipped, calibrated, with the substeps that a session
//! derives.

use palpate::haptic::cycle::Settings;
use palpate::{Params, Vector3};
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_loop::closed_loop::fidelity;
use palpate_loop::closed_loop::hand::{HANDS, Hand};
use palpate_loop::closed_loop::prepared::Prepared;
use palpate_loop::closed_loop::run::{Setup, run};
use palpate_loop::closed_loop::stimulus::Stimulus;
use palpate_loop::closed_loop::surface::with_tissue;
use palpate_tests::bench::Bench;
use palpate_tests::share::Share;

const DEEP_M: f32 = 8e-3;
const DEPTH_M: f64 = 4e-3;

#[test]
fn tissue_is_quiet_in_every_hand() {
    let device = DeviceProfile::load("touch").unwrap();
    let mut share = Share::one_in(2);
    for (youngs_modulus_pa, static_n) in [(3.5e3, 0.140), (20e3, 0.797)] {
        let mut bench = Bench::calibrated(130).with(|p| p.youngs_modulus_pa = youngs_modulus_pa);
        bench.patch.set_depth_limit_m(DEEP_M);
        let derived = fidelity::derive(&bench.patch, &Params { substeps: 1, ..bench.params }, DEPTH_M).unwrap();
        assert!(derived.held, "{derived:?}");
        for hand in HANDS {
            for id in ["S1-0.2", "S2", "S7"] {
                if !share.takes() {
                    continue;
                }
                let settings = Settings::safe(&device.limits(Vector3::zeros()));
                let stimulus = Stimulus::named(id).unwrap();
                let setup = Setup { device: &device, hand, stimulus, settings, depth_m: DEPTH_M, static_n };
                let run = with_tissue(&bench.patch, &derived.params, |tissue| run(&setup, tissue)).unwrap().unwrap();
                let label =
                    format!("{youngs_modulus_pa} Pa, {} {id}: {:?}, {:?}, {:?}", hand.id, run.hold, run.broken, run.fault);
                assert!(run.quiet(), "{label}");
                assert!(run.created_j <= 0.01e-3, "{label}: {} J", run.created_j);
                if id != "S7" {
                    let last = run.rows.last().unwrap().telemetry;
                    assert!((last.applied_n - last.output.force_n).norm() < 1e-3, "static force untouched: {label}");
                    assert!(f64::from(last.applied_n.norm()) > 0.8 * static_n.min(0.5), "{label}");
                }
            }
        }
    }
}

/// Holds on the boundary between two counts: while the reading toggles, the patch is given the
/// mean. Without this the finger pad shakes with 21 mN and the arm with 137 mN.
#[test]
fn holds_above_the_encoders_ceiling_are_quiet() {
    for (name, count_m, youngs_modulus_pa, hand, id) in [
        ("frictionless", 55e-6, 20e3, "H5", "S4"),
        ("touch", 55e-6, 100e3, "H1", "S2"),
        ("touch", 55e-6, 100e3, "H3", "S2"),
        ("touch", 10e-6, 100e3, "H2", "S1-0.2"),
        ("touch", 10e-6, 100e3, "H0", "S9"),
        ("touch", 10e-6, 100e3, "H6", "S9"),
    ] {
        let device = DeviceProfile { count_m, ..DeviceProfile::load(name).unwrap() };
        let bench = Bench::calibrated(130).with(|p| p.youngs_modulus_pa = youngs_modulus_pa);
        let tissue = Prepared::of_patch(bench.patch, &bench.params, f64::from(DEEP_M), &device).unwrap();
        let settings = Settings { limits: device.limit_values(), ..Settings::safe(&device.limits(Vector3::zeros())) };
        let stimulus = Stimulus::named(id).unwrap().short();
        let (depth_m, static_n) = (tissue.depth_m, tissue.static_n);
        let setup = Setup { device: &device, hand: Hand::named(hand).unwrap(), stimulus, settings, depth_m, static_n };
        let run = with_tissue(&tissue.patch, &tissue.params, |tissue| run(&setup, tissue)).unwrap().unwrap();
        let label = format!("{name}, {youngs_modulus_pa} Pa, {hand} {id}: {:?}, {:?}, {:?}", run.hold, run.broken, run.fault);
        assert!(run.quiet() && run.created_j <= 0.01e-3, "{label}: {} J", run.created_j);
    }
}
