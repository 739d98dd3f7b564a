//! Devices that are set up wrongly, in every hand: a wrong unit is noticed before any force, a
//! wrong sign of the pressed axis at the first touches if the hand yields, and no correct device is
//! mistaken for a wrong one.
//!
//! `cargo test -p palpate-loop --release --test mistaken_devices -- --ignored --nocapture`
//! prints the table of SAFETY.md.

use std::sync::LazyLock;

use palpate::haptic::cycle::Settings;
use palpate::{Fault, Params, Vector3};
use palpate_loop::closed_loop::campaign::LightPatch;
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_loop::closed_loop::hand::{HANDS, Hand};
use palpate_loop::closed_loop::mistakes::{FirstTouches, MISTAKES, Mistake, first_touches};
use palpate_loop::closed_loop::run::Setup;
use palpate_loop::closed_loop::stimulus::Stimulus;
use palpate_loop::closed_loop::surface::{Wall, with_tissue};

/// Depth at which a press rests [m], unless the force there exceeds this share of the limit (1).
const DEPTH_M: f64 = 4e-3;
const FORCE_SHARE: f64 = 0.85;

static LIGHT: LazyLock<LightPatch> = LazyLock::new(|| LightPatch::load().unwrap());

/// Surface that is touched.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Target {
    /// A wall of this stiffness, with its normal along z [N/m].
    Wall(f64),
    /// A wall of this stiffness, with its normal parallel to no axis [N/m].
    Leaning(f64),
    /// The shipped patch of 130 nodes with this Young's modulus, with its normal along z [Pa].
    Tissue(f64),
}

fn touch(name: &str, hand: Hand, stimulus: Stimulus, mistake: Mistake, target: Target) -> FirstTouches {
    let device = DeviceProfile::load(name).unwrap();
    let settings = Settings { limits: device.limit_values(), ..Settings::safe(&device.limits(Vector3::zeros())) };
    let most_n = FORCE_SHARE * device.force_limit_n;
    let setup = |depth_m: f64, static_n: f64| Setup { device: &device, hand, stimulus, settings, depth_m, static_n };
    match target {
        Target::Wall(n_per_m) | Target::Leaning(n_per_m) => {
            let leans = matches!(target, Target::Leaning(_));
            let normal = if leans { Vector3::new(0.48, 0.6, 0.64) } else { Vector3::z() };
            let depth_m = DEPTH_M.min(most_n / n_per_m);
            let mut wall = Wall::new(n_per_m, device.force_limit_n, normal);
            first_touches(&setup(depth_m, n_per_m * depth_m), mistake, &mut wall, |_| ()).unwrap()
        }
        Target::Tissue(youngs_modulus_pa) => {
            let light = &*LIGHT;
            let static_n = light.static_n * youngs_modulus_pa / f64::from(light.params.youngs_modulus_pa);
            let share = (most_n / static_n).min(1.0);
            let params = Params { youngs_modulus_pa: youngs_modulus_pa as f32, ..light.params };
            // the force of a sphere grows with the depth to the power of 3/2
            let setup = setup(DEPTH_M * share.powf(2.0 / 3.0), static_n * share);
            with_tissue(&light.patch, &params, |tissue| first_touches(&setup, mistake, tissue, |_| ()).unwrap()).unwrap()
        }
    }
}

/// Runs every hand with these stimuli and each mistake.
fn all(devices: &[&str], stimuli: &[&str], targets: &[Target]) -> Vec<(Mistake, Vec<(Hand, FirstTouches)>)> {
    let of = |mistake| {
        let mut runs = Vec::new();
        for device in devices {
            for stimulus in stimuli.iter().filter_map(|id| Stimulus::named(id)) {
                for target in targets {
                    runs.extend(HANDS.map(|hand| (hand, touch(device, hand, stimulus, mistake, *target))));
                }
            }
        }
        (mistake, runs)
    };
    std::thread::scope(|scope| {
        let rows: Vec<_> = MISTAKES.map(|mistake| scope.spawn(move || of(mistake))).into_iter().collect();
        rows.into_iter().map(|row| row.join().unwrap()).collect()
    })
}

fn share(runs: &[(Hand, FirstTouches)], counts: impl Fn(&Hand, &FirstTouches) -> bool) -> f64 {
    runs.iter().filter(|(hand, touched)| counts(hand, touched)).count() as f64 / runs.len() as f64
}

#[test]
fn a_wrong_unit_is_told_before_any_force_a_wrong_sign_at_the_first_touches_and_nothing_else_trips() {
    let table = all(&["touch"], &["S1-0.05", "S1-0.2"], &[Target::Tissue(20e3), Target::Wall(1500.0)]);
    for (mistake, runs) in table {
        let faulted = share(&runs, |_, touched| touched.fault.is_some());
        if mistake.unit != 1.0 {
            let unit = |fault| matches!(fault, Some(Fault::UnitMismatch | Fault::OutOfWorkspace));
            assert!(runs.iter().all(|(_, t)| unit(t.fault) && t.peak_n == 0.0), "{}: {runs:?}", mistake.name);
        } else if mistake.sign[2] > 0.0 {
            // no force acts along x and y: the mistake can neither be noticed nor felt
            assert_eq!(faulted, 0.0, "{}: {runs:?}", mistake.name);
        } else {
            let ended = share(&runs, |_, touched| touched.ended_ticks.is_some());
            let by_sign = share(&runs, |_, touched| touched.fault == Some(Fault::WrongSign));
            assert!(ended >= 0.7 && faulted >= 0.7 && by_sign >= 0.5, "{}: {ended} {faulted} {by_sign}", mistake.name);
            // a released handle and a light hand are never left with the wrong force
            let light = |hand: &Hand| matches!(hand.id, "H0" | "H5");
            assert!(runs.iter().all(|(hand, t)| !light(hand) || t.ended_ticks.is_some()), "{}: {runs:?}", mistake.name);
        }
    }
}

#[test]
#[ignore = "minutes; prints the table of SAFETY.md"]
fn table_of_mistakes() {
    let (devices, stimuli) = (["touch", "omega3", "falcon"], ["S1-0.05", "S1-0.2", "S1-0.5", "S2"]);
    let targets = [Target::Tissue(3.5e3), Target::Tissue(20e3), Target::Wall(1500.0), Target::Leaning(1500.0)];
    for target in targets {
        println!("{target:?}: mistake, runs, noticed, by fault, ended ms median, largest N median, way mm median");
        for (mistake, runs) in all(&devices, &stimuli, &[target]) {
            let ended: Vec<&FirstTouches> = runs.iter().map(|(_, t)| t).filter(|t| t.ended_ticks.is_some()).collect();
            let median = |number: &dyn Fn(&FirstTouches) -> f64| {
                let mut all: Vec<f64> = ended.iter().map(|t| number(t)).collect();
                all.sort_by(f64::total_cmp);
                all.get(all.len() / 2).copied().unwrap_or(f64::NAN)
            };
            let by = Fault::ALL.into_iter().filter_map(|fault| {
                let count = runs.iter().filter(|(_, t)| t.fault == Some(fault)).count();
                (count > 0).then(|| format!("{}:{count}", fault as u8))
            });
            println!(
                "{} | {} | {} | {} | {:.0} | {:.2} | {:.1}",
                mistake.name,
                runs.len(),
                ended.len(),
                by.collect::<Vec<_>>().join(" "),
                median(&|t| f64::from(t.ended_ticks.unwrap_or(0))),
                median(&|t| f64::from(t.peak_n)),
                median(&|t| t.way_m * 1e3)
            );
        }
    }
}
