//! The loop is closed around the unchanged images that are flashed: levels of the pins become a
//! force, the force and an emulated hand move a handle, and the handle's encoders are counted. The
//! handle then rests where hand and tissue are in balance, and the pins show the force that the
//! tissue has at the handle's true place. With any swapped axis, wrong sign or wrong scale they do
//! not.

use std::path::Path;

use nalgebra::Vector3;
use palpate::ProbePose;
use palpate::haptic::cycle::Renderer;
use palpate::haptic::device::HapticDevice;
use palpate_controller::config::{Profile, WireOrder};
use palpate_controller::force_out::DacCode;
use palpate_controller::link::ToBoard;
use palpate_controller::link::message::HostAsk;
use palpate_controller::patch::{Memory, Patch};
use palpate_controller::probe_in::EncoderCounts;
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_loop::closed_loop::hand::{Aim, HANDS};
use palpate_loop::closed_loop::plant::Plant;
use palpate_tests::mistakes::Mistake;
use palpate_tests::register_model::{Flashed, Period, Row, lock_step};
use serde_json::json;

/// Periods in which the host stores the profile or declares the home pose, and requests the force.
const SET_UP_AT: usize = 10;
const ARM_AT: usize = 120;
/// Period in which the hand leaves the home pose, and duration of the motion.
const LEAVES_AT: usize = 60;
const LEAVING_TICKS: usize = 30;
/// Period in which the hand begins to press, once the force is ramped in, and the duration of the
/// press and of the hold.
const PRESS_AT: usize = 700;
const PRESS_TICKS: usize = 150;
const HOLD_TICKS: usize = 250;
/// Last ticks of the hold over which force and place are averaged.
const MEAN_TICKS: usize = 50;
/// Places of the hand before the press, and at its end [m].
const ABOVE_M: Vector3<f64> = Vector3::new(0.0, 0.0, 0.6e-3);
const PRESSED_M: Vector3<f64> = Vector3::new(3e-3, -1.5e-3, -5e-3);

const STRAIGHT: Mistake =
    Mistake { name: "straight", reads: [0, 1, 2], drives: [0, 1, 2], read_sign: [1.0; 3], drive_sign: [1.0; 3], unit: 1.0 };
/// No axis on its own wires, and both signs.
const IN_TURN: Mistake = Mistake {
    name: "in turn",
    reads: [2, 0, 1],
    drives: [1, 2, 0],
    read_sign: [1.0, -1.0, -1.0],
    drive_sign: [-1.0, 1.0, -1.0],
    unit: 2.0,
};

/// A handle with the wiring that it has, in a hand.
struct Handle {
    plant: Plant,
    wiring: Mistake,
    period_steps: f64,
    /// Places [m] and forces of the motors [N] so far.
    places_m: Vec<Vector3<f64>>,
    forces_n: Vec<Vector3<f64>>,
}

impl Handle {
    fn new(wiring: Mistake, period_steps: f64) -> Self {
        let device = DeviceProfile::load("touch").unwrap();
        let plant = Plant::new(&device, HANDS[2], Vector3::zeros(), Vector3::z(), Vector3::zeros());
        Self { plant, wiring, period_steps, places_m: Vec::new(), forces_n: Vec::new() }
    }

    /// Moves for a period under the levels of the pins. A direction pin is high toward the negative
    /// side.
    fn step(&mut self, row: &Row, aim_m: Vector3<f64>) {
        let on = row.enable && row.main_output;
        let wires_n = std::array::from_fn(|wire| {
            let share = if on { row.steps[wire] as f64 / self.period_steps } else { 0.0 };
            (if row.reverse[wire] { -share } else { share }) as f32 * DacCode::FULL_SCALE_N
        });
        let force_n = self.wiring.force_n(wires_n);
        self.plant.actuate(force_n);
        let zero = Vector3::zeros();
        self.plant.step(&Aim { at_m: aim_m, velocity_m_per_s: zero, push_n: zero, let_go: false, steady: true }, on);
        self.places_m.push(self.plant.at_m());
        self.forces_n.push(force_n.cast());
    }

    fn counts(&self) -> [i32; 3] {
        let (at_m, per_m) = (self.plant.at_m(), f64::from(self.wiring.unit) / f64::from(EncoderCounts::LENGTH_M));
        let wiring = &self.wiring;
        std::array::from_fn(|wire| {
            let axis = wiring.reads[wire];
            (at_m[axis] * f64::from(wiring.read_sign[axis]) * per_m).round() as i32
        })
    }
}

/// Presses with a handle that is wired otherwise than the board assumes. Returns the force of the
/// motors and that of the tissue at the same place [N]; `None` if the model is not available.
fn pressed(board: Flashed, assumed: &Mistake, really: &Mistake) -> Option<[Vector3<f64>; 2]> {
    let period_steps = if board == Flashed::Pico2 { 7_500.0 } else { 9_000.0 };
    let mut handle = Handle::new(*really, period_steps);
    let wired = assumed.wiring();
    let profile = Profile {
        wiring: WireOrder {
            encoder: wired.sensor,
            ratio: wired.per_unit,
            motor: wired.motor,
            motor_sign: wired.motor_sign.map(|sign| sign as i8),
        },
        ..Profile::desktop()
    };
    let mut period = 0_usize;
    let more = if *assumed == STRAIGHT { json!({}) } else { json!({"events": [{"at": SET_UP_AT, "how": "restart"}]}) };
    lock_step(Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap(), board, &more, |row| {
        let share = |from: usize, ticks: usize| (period.saturating_sub(from) as f64 / ticks as f64).min(1.0);
        let above_m = ABOVE_M * share(LEAVES_AT, LEAVING_TICKS);
        handle.step(row, above_m + (PRESSED_M - above_m) * share(PRESS_AT, PRESS_TICKS));
        let says = match period {
            SET_UP_AT if *assumed == STRAIGHT => Some(ToBoard::Home),
            SET_UP_AT => Some(ToBoard::Store(profile)),
            ARM_AT => Some(ToBoard::Ask(HostAsk::Arm)),
            _ if period.is_multiple_of(5) => Some(ToBoard::Heartbeat),
            _ => None,
        };
        period += 1;
        (period < PRESS_AT + PRESS_TICKS + HOLD_TICKS).then(|| Period { counts: handle.counts(), says, late: 0 })
    })?;
    let mut memory = Box::new(Memory::RESERVED);
    let mut patch = Patch::open(board.patch(), &mut memory, None).unwrap();
    let tissue_n: Vec<Vector3<f64>> =
        handle.places_m.iter().map(|at_m| patch.render(ProbePose { tip_m: at_m.cast() }).force_n.cast()).collect();
    let mean =
        |forces_n: &[Vector3<f64>]| forces_n[forces_n.len() - MEAN_TICKS..].iter().sum::<Vector3<f64>>() / MEAN_TICKS as f64;
    Some([mean(&handle.forces_n), mean(&tissue_n)])
}

/// Whether the motors give the tissue's force, within a few steps of the pulses and three percent.
fn agree([motors_n, tissue_n]: [Vector3<f64>; 2]) -> bool {
    (motors_n - tissue_n).norm() < 4e-3 + 0.03 * tissue_n.norm()
}

#[test]
fn the_motors_give_the_force_of_the_tissue_where_the_handle_is() {
    // a swap with the axis of the press is noticed, which is on another wire in the other wiring
    let cases = [Flashed::F446, Flashed::Pico2].map(|board| [(board, STRAIGHT), (board, IN_TURN)]);
    for (board, wiring) in cases.into_iter().flatten() {
        let Some(forces_n) = pressed(board, &wiring, &wiring) else { return };
        let [motors_n, tissue_n] = forces_n.map(|force_n| force_n * 1e3);
        println!("{board:?}, {}: motors {motors_n:.1?} mN, tissue {tissue_n:.1?} mN", wiring.name);
        assert!(tissue_n.z > 100.0, "{board:?}: pressed");
        assert!(agree(forces_n), "{board:?}");
    }
}

#[test]
fn swapped_axes_wrong_signs_and_scales_are_noticed() {
    let mistakes = [
        (STRAIGHT, Mistake { name: "second and third motor swapped", drives: [0, 2, 1], ..STRAIGHT }),
        (STRAIGHT, Mistake { name: "first and third encoder swapped", reads: [2, 1, 0], ..STRAIGHT }),
        (STRAIGHT, Mistake { name: "motor mirrored", drive_sign: [1.0, 1.0, -1.0], ..STRAIGHT }),
        (STRAIGHT, Mistake { name: "a tenth more counts", unit: 1.1, ..STRAIGHT }),
        (IN_TURN, Mistake { name: "first and second encoder swapped", reads: [0, 2, 1], ..IN_TURN }),
        (IN_TURN, Mistake { name: "first and second motor swapped", drives: [2, 1, 0], ..IN_TURN }),
        (IN_TURN, Mistake { name: "encoder mirrored", read_sign: [1.0, -1.0, 1.0], ..IN_TURN }),
    ];
    for (assumed, really) in mistakes {
        let Some(forces_n) = pressed(Flashed::F446, &assumed, &really) else { return };
        let [motors_n, tissue_n] = forces_n.map(|force_n| force_n * 1e3);
        println!("{}: motors {motors_n:.1?} mN, tissue {tissue_n:.1?} mN", really.name);
        assert!(!agree(forces_n), "{}", really.name);
    }
}
