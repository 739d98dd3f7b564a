//! A paddle whose encoder or motor has a wrong sign or scale, held by a hand that presses it slowly
//! into the tissue: tests that the loop's own checks detect the error at the first touch.

use palpate::Fault;
use palpate::haptic::cycle::{Ask, Command};
use palpate::haptic::device::SensorStatus;
use palpate::haptic::mode::Mode;
use palpate_controller::controller::{Arming, Controller};
use palpate_controller::patch::{Memory, Patch};
use palpate_controller::probe_in::{EncoderCounts, JointReading, Reading};
use palpate_sim::port::device_file;
use palpate_tests::flash_patch::in_flash;
use palpate_tests::palpate_command::repository;

const SUBSTEPS: u32 = 10;
/// Mass of the lever, reduced to its tip [kg].
const MASS_KG: f64 = 0.08;
/// Grip of a hand on the lever: stiffness [N/m] and damping [N s/m].
#[derive(Clone, Copy, Debug)]
struct Grip(f64, f64);

const FIRM: Grip = Grip(300.0, 4.0);
const LOOSE: Grip = Grip(30.0, 0.5);
const LIGHT: Grip = Grip(10.0, 0.3);
/// Ticks in the home pose, on the way to 3 mm above the tissue, waiting there until armed, and
/// pressing to 4 mm depth.
const STILL: u32 = 10;
const APPROACH: u32 = 500;
const ARMED: u32 = 1_500;
const PRESS: u32 = 500;
const TICKS: u32 = STILL + APPROACH + ARMED + PRESS + 1_500;

/// Factors on encoder and motor that the profile does not contain.
#[derive(Clone, Copy, Debug)]
struct Wrong {
    encoder: f64,
    motor: f64,
}

#[derive(Debug)]
struct Met {
    fault: Option<Fault>,
    /// Time from the first force to the fault [ms].
    lasted_ms: Option<u32>,
    /// Largest force of the motor at the tip [N].
    largest_n: f64,
    /// Largest distance of the tip from the hand's target after the first force [m].
    thrown_m: f64,
    mode: Mode,
}

fn pressed(wrong: Wrong, Grip(hand_n_per_m, hand_n_s_per_m): Grip) -> Met {
    let file = repository().join("firmware/controller/devices/paddle.toml");
    let profile = device_file::load(file.to_str().unwrap()).unwrap().1;
    let mechanism = profile.mechanism.unwrap();
    let (arm_m, home) = (f64::from(mechanism.dimensions[0]), f64::from(mechanism.home_rad[0]));
    let (settings, port) = profile.split();
    let mut controller = Controller::build(&settings, port, Arming::OnRequest).unwrap();
    let mut memory = Box::new(Memory::RESERVED);
    let mut patch = Patch::open(in_flash(), &mut memory, None).unwrap();
    let home_m = arm_m * home.sin();
    // with a mirrored encoder, contact occurs on the other side of the home pose
    let side = if wrong.encoder < 0.0 { -1.0 } else { 1.0 };
    let wanted_m = |tick: u32| {
        let share = |from: u32, ticks: u32| f64::from(tick.saturating_sub(from)).min(f64::from(ticks)) / f64::from(ticks);
        let down = (home_m - 3e-3) * share(STILL, APPROACH) + 7e-3 * share(STILL + APPROACH + ARMED, PRESS);
        home_m - side * down
    };
    let (mut q, mut w) = (home, 0.0);
    let mut met = Met { fault: None, lasted_ms: None, largest_n: 0.0, thrown_m: 0.0, mode: Mode::Boot };
    let mut felt = None;
    for tick in 0..TICKS {
        let counts = (wrong.encoder * (q - home) / f64::from(mechanism.rad_per_count[0])).round() as i32;
        let counts = [counts, 0, 0].map(EncoderCounts);
        let reading = Reading::Joints(JointReading { counts, sequence: tick + 1, status: SensorStatus::Good });
        if tick == STILL - 1 {
            assert!(controller.show_home(&reading));
        }
        let asked = (controller.mode() == Mode::Idle && tick == STILL + APPROACH).then_some(Ask::Arm);
        let record = controller.tick(&mut patch, reading, Command { asked, ..Command::HEARD }, true);
        patch.settle(controller.in_contact());
        let share = f64::from(controller.outputs().codes[0].0) / 32_767.0;
        let torque_n_m = wrong.motor * share * f64::from(mechanism.full_scale_n_m[0]);
        if torque_n_m != 0.0 {
            felt.get_or_insert(tick);
            met.largest_n = met.largest_n.max(torque_n_m.abs() / arm_m);
        }
        if felt.is_some() {
            met.thrown_m = met.thrown_m.max((arm_m * q.sin() - wanted_m(tick)).abs());
        }
        if let (None, Some(fault)) = (met.fault, record.fault) {
            (met.fault, met.lasted_ms) = (Some(fault), felt.map(|from| tick - from));
        }
        assert!(met.fault.is_none() || torque_n_m == 0.0, "no force beside a fault");
        for _ in 0..SUBSTEPS {
            let dt = 1e-3 / f64::from(SUBSTEPS);
            let hand_n = hand_n_per_m * (wanted_m(tick) - arm_m * q.sin()) - hand_n_s_per_m * arm_m * q.cos() * w;
            w += dt * (torque_n_m + hand_n * arm_m * q.cos()) / (MASS_KG * arm_m * arm_m);
            q += dt * w;
        }
    }
    met.mode = controller.mode();
    println!("{wrong:?} at {hand_n_per_m} N/m: {met:?}");
    met
}

const RIGHT: Wrong = Wrong { encoder: 1.0, motor: 1.0 };

#[test]
fn a_right_device_is_felt_without_a_fault() {
    let met = pressed(RIGHT, FIRM);
    assert_eq!((met.fault, met.mode), (None, Mode::Active));
    assert!(met.largest_n > 0.1, "{met:?}");
}

/// Largest force of a wrong sign on soft tissue that no check detects, where 3 N are allowed [N].
/// The motor pulls the hand in, which to the loop looks like a hand that presses.
const UNSEEN_N: f64 = 0.5;

/// On soft tissue a loose hand is slowly pulled in by some 30 mm. A loop that trusts its motor
/// signs sees neither a runaway nor created energy in this.
#[test]
fn a_motor_or_an_encoder_the_wrong_way_round_is_a_fault_or_a_small_force() {
    for wrong in [Wrong { motor: -1.0, ..RIGHT }, Wrong { encoder: -1.0, ..RIGHT }] {
        for grip in [FIRM, LOOSE, LIGHT] {
            let met = pressed(wrong, grip);
            assert!(met.fault.is_some() || met.largest_n < UNSEEN_N, "{grip:?}: {met:?}");
        }
    }
}

#[test]
fn an_encoder_of_another_scale_gives_no_force() {
    for grip in [FIRM, LOOSE, LIGHT] {
        let tenfold = pressed(Wrong { encoder: 10.0, ..RIGHT }, grip);
        assert_eq!((tenfold.fault, tenfold.largest_n), (Some(Fault::OutOfWorkspace), 0.0), "{grip:?}");
        // throughout, the tip is sensed far above the tissue
        assert_eq!(pressed(Wrong { encoder: 0.1, ..RIGHT }, grip).largest_n, 0.0, "{grip:?}");
    }
}
