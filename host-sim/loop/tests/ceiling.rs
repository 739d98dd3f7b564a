//! On a desktop a contact that is stiffer than the device renders is weakened, and the session says
//! so.

use std::path::Path;

use palpate::haptic::mode::Mode;
use palpate::{ClampFlags, Vector3};
use palpate_loop::closed_loop::device::{DeviceProfile, PROFILES};
use palpate_loop::haptic_session::{HapticSession, Input};
use palpate_tissue::session::calibrated;

/// Holds the tip 2 mm deep in the block of 3.5 kPa, or another modulus [Pa], on the default device
/// with this stiffness ceiling [N/m].
fn held(ceiling_n_per_m: f32, youngs_modulus_pa: f32) -> HapticSession {
    let own = "stiffness_ceiling_n_per_m = 400.0";
    assert!(PROFILES[0].1.contains(own));
    let profile = PROFILES[0].1.replace(own, &format!("stiffness_ceiling_n_per_m = {ceiling_n_per_m:.1}"));
    let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("ceiling-{ceiling_n_per_m}-{youngs_modulus_pa}.toml"));
    std::fs::write(&path, profile).unwrap();
    let device = path.to_str().unwrap();
    assert!(DeviceProfile::load(device).is_ok());
    let mut session = HapticSession::of_patch_bytes(calibrated::bytes(130).unwrap(), device).unwrap();
    session.set_modulus(youngs_modulus_pa).unwrap();
    session.arm().unwrap();
    let site_m = session.tissue().patch().site_m();
    let mut at = |z_m: f32| {
        session.tick(&Input::at(site_m + Vector3::z() * z_m));
    };
    (0..1_200).for_each(|_| at(2e-3));
    (0..=400_u16).for_each(|n| at(2e-3 - 1e-5 * f32::from(n)));
    (0..400).for_each(|_| at(-2e-3));
    assert_eq!(session.mode(), Mode::Active);
    session
}

/// Force that the hand feels [N], and whether the record says that it is scaled.
fn felt(session: &HapticSession) -> (f32, bool) {
    let told = session.telemetry().unwrap();
    (told.applied_n.norm(), told.limiters.contains(ClampFlags::GAIN))
}

#[test]
fn every_force_is_scaled_by_the_ceiling_over_the_stiffness_and_the_session_says_so() {
    let session = held(400.0, 3.5e3);
    let stiffness_n_per_m = session.tissue().contact_n_per_m();
    // the depth limit is the patch's own, 8 mm
    assert!((60.0..75.0).contains(&stiffness_n_per_m), "{stiffness_n_per_m} N/m");
    let (force_n, scaled) = felt(&session);
    let asked_n = session.telemetry().unwrap().output.force_n.norm();
    assert!((force_n / asked_n - 1.0).abs() < 2e-3 && !scaled, "{force_n} of {asked_n} N");
    assert_eq!(session.ceiling_note(), None);

    for (ceiling_n_per_m, youngs_modulus_pa) in [(30.0, 3.5e3), (60.0, 7e3), (20.0, 1.75e3)] {
        let session = held(ceiling_n_per_m, youngs_modulus_pa);
        let stiffer = stiffness_n_per_m * youngs_modulus_pa / 3.5e3;
        let (weakened_n, scaled) = felt(&session);
        let (whole_n, _) = felt(&held(400.0, youngs_modulus_pa));
        let share = weakened_n / whole_n;
        assert!((share * stiffer / ceiling_n_per_m - 1.0).abs() < 5e-3 && scaled, "{ceiling_n_per_m}: {share}");
        let note = session.ceiling_note().unwrap();
        assert!(note.contains(&format!("renders {ceiling_n_per_m:.0} N/m")), "{note}");
    }
}
