//! The device is switched on with the probe inside the tissue. However long the probe stays there,
//! there is no force until it has been outside; then the force ramps in.

use palpate::haptic::cycle::{Command, Settings};
use palpate::haptic::device::{HapticDevice, Sensed, SensorStatus};
use palpate::haptic::mode::Mode;
use palpate::{ClampFlags, Vector3};
use palpate_controller::controller::{Arming, Controller};
use palpate_controller::force_out::ActuatorCommand;
use palpate_controller::patch::{Memory, Patch};
use palpate_controller::port::Port;
use palpate_tests::flash_patch::in_flash;

/// Number of places below the surface.
const PLACES: usize = 1_000;

fn sensed(position_m: Vector3<f32>, sequence: u32) -> Sensed {
    Sensed { position_m, sequence, status: SensorStatus::Good }
}

#[test]
fn no_force_at_any_of_a_thousand_places_inside() {
    let mut memory = Box::new(Memory::RESERVED);
    for n in 0..PLACES {
        let mut patch = Patch::open(in_flash(), &mut memory, None).unwrap();
        let mut controller =
            Controller::build(&Settings::safe(&Port::DESKTOP.limits()), Port::DESKTOP, Arming::ByItself).unwrap();
        // places without a visible pattern: fractional parts of multiples of irrational numbers
        let part = |step: f64| (n as f64 * step).fract() as f32;
        let (x, y, depth) = (part(0.618_034) - 0.5, part(0.414_214) - 0.5, part(0.732_051));
        let place = Vector3::new(0.02 * x, 0.02 * y, -0.5e-3 - 8e-3 * depth);
        for sequence in 0..150 {
            let record = controller.tick(&mut patch, sensed(place, sequence), Command::HEARD, true);
            assert!(record.fault.is_none() && record.mode != Mode::Active, "{place:?}: {:?} {:?}", record.mode, record.fault);
            assert_eq!(record.applied_n, Vector3::zeros(), "{place:?}");
            assert_eq!(controller.drive(), ActuatorCommand::Off, "{place:?}");
            if record.mode == Mode::Arming && sequence > 10 {
                assert!(record.output.limiters.contains(ClampFlags::BURIED), "{place:?}: it is not inside, this proves nothing");
            }
        }
    }
}

#[test]
fn once_outside_the_force_comes_slowly() {
    let mut memory = Box::new(Memory::RESERVED);
    let mut patch = Patch::open(in_flash(), &mut memory, None).unwrap();
    let mut controller = Controller::build(&Settings::safe(&Port::DESKTOP.limits()), Port::DESKTOP, Arming::ByItself).unwrap();
    let mut most_n = 0.0_f32;
    let mut sequence = 0;
    let mut go = |from_m: f32, to_m: f32, ticks: u32| {
        let mut record = None;
        for n in 0..ticks {
            let z = from_m + (to_m - from_m) * (n + 1) as f32 / ticks as f32;
            record = Some(controller.tick(&mut patch, sensed(Vector3::new(0.0, 0.0, z), sequence), Command::HEARD, true));
            sequence += 1;
        }
        record.unwrap()
    };
    go(-4e-3, -4e-3, 100);
    let out = go(-4e-3, 2e-3, 100);
    assert_eq!(out.applied_n, Vector3::zeros(), "on the way out nothing pushes");
    assert_eq!(go(2e-3, 2e-3, 150).mode, Mode::Active);
    // the contact began 150 ticks into a ramp of 500, so the gain keeps that value for this contact
    let touched = go(2e-3, -4e-3, 100);
    most_n = most_n.max(touched.output.force_n.z);
    assert!(touched.applied_n.z > 0.0 && touched.applied_n.z < 0.5 * most_n, "{} of {most_n} N", touched.applied_n.z);
}
