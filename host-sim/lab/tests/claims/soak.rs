//! Normal use with all hands in turn, on a loop that is never restarted: no fault occurs, the
//! tissue returns to rest, and no number becomes denormal.
//!
//! An hour: the long form, or `palpate faults --soak-s 3600`.

use palpate_lab::faults::campaign::{Ground, LightPatch};
use palpate_lab::faults::soak::soak;
use palpate_loop::closed_loop::device::DeviceProfile;

fn use_for(seconds: f64) {
    let device = DeviceProfile::load("touch").unwrap();
    let light = LightPatch::load().unwrap();
    let soak = soak(&Ground::new(&device, &light), seconds, |_| ()).unwrap();
    assert!(soak.ticks as f64 >= 1e3 * seconds && soak.peak_n > 1.0, "{soak:?}");
    assert!(soak.trips.is_empty() && soak.broken.is_empty(), "{soak:?}");
    assert!(soak.drift_m <= 1e-6, "{} m", soak.drift_m);
    assert_eq!(soak.denormals, 0);
}

#[test]
fn fifteen_seconds_of_normal_use_trip_nothing_and_leave_nothing() {
    use_for(15.0);
}

#[test]
#[ignore = "an hour of use"]
fn an_hour_of_normal_use_trips_nothing_and_leaves_nothing() {
    use_for(3600.0);
}
