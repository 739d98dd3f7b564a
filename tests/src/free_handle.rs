//! A handle with motors and encoders, wired as a [`Mistake`] says, which the user of a test moves,
//! lets go or holds.

use std::collections::VecDeque;

use crate::mistakes::Mistake;
use nalgebra::Vector3;
use palpate::haptic::device::HapticDevice;
use palpate_controller::force_out::{DacCode, Outputs};
use palpate_controller::probe_in::EncoderCounts;
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_loop::closed_loop::hand::{Aim, HANDS};
use palpate_loop::closed_loop::plant::Plant;

/// Ticks of a motion by hand.
const MOTION_TICKS: u32 = 400;

/// Action of the user.
#[derive(Clone, Debug)]
enum User {
    /// Nothing: the motors move the handle.
    Away,
    /// Holds it with a hand that yields.
    Holds,
    /// Moves it along this path, one place per tick, and holds it still at its end.
    Moves(VecDeque<Vector3<f64>>),
}

/// The handle in the middle of its workspace, held still at first.
#[derive(Clone, Debug)]
pub struct FreeHandle {
    plant: Plant,
    mistake: Mistake,
    user: User,
    /// Whether the enable line is on.
    driven: bool,
    /// Largest force of a motor since the start [N].
    largest_n: f32,
}

impl FreeHandle {
    /// Creates a handle with the mass, the friction, the delay and the lag of a device.
    pub fn new(device: &DeviceProfile, mistake: Mistake) -> Self {
        let plant = Plant::new(device, HANDS[1], Vector3::zeros(), Vector3::z(), Vector3::zeros());
        Self { plant, mistake, user: User::Moves(VecDeque::new()), driven: false, largest_n: 0.0 }
    }

    /// Begins a straight motion to a place [m], which starts and ends slowly.
    pub fn move_to(&mut self, to_m: Vector3<f64>) {
        let from_m = self.plant.at_m();
        let share = |tick: u32| 0.5 - 0.5 * (std::f64::consts::PI * f64::from(tick) / f64::from(MOTION_TICKS)).cos();
        self.user = User::Moves((1..=MOTION_TICKS).map(|tick| from_m + (to_m - from_m) * share(tick)).collect());
    }

    /// Begins a motion from the present place [m].
    pub fn move_by(&mut self, way_m: Vector3<f64>) {
        self.move_to(self.plant.at_m() + way_m);
    }

    /// Takes the hand off the handle.
    pub fn let_go(&mut self) {
        self.user = User::Away;
    }

    /// Holds the handle where it is, with a hand that yields.
    pub fn hold(&mut self) {
        self.user = User::Holds;
    }

    /// Whether a motion by hand goes on.
    pub fn moves(&self) -> bool {
        matches!(&self.user, User::Moves(path) if !path.is_empty())
    }

    /// Whether the board has its outputs on.
    pub fn driven(&self) -> bool {
        self.driven
    }

    /// Largest force of a motor since the start [N].
    pub fn largest_n(&self) -> f32 {
        self.largest_n
    }

    /// Runs one tick under the levels of the pins; returns the counts of the encoders after it.
    pub fn tick(&mut self, pins: Outputs) -> [i32; 3] {
        self.driven = pins.enabled;
        if pins.enabled {
            let commands_n = pins.codes.map(|code| f32::from(code.0) / f32::from(i16::MAX) * DacCode::FULL_SCALE_N);
            self.largest_n = commands_n.into_iter().fold(self.largest_n, |most, n| most.max(n.abs()));
            self.plant.actuate(self.mistake.force_n(commands_n));
        } else {
            self.plant.release();
        }
        let let_go = !matches!(self.user, User::Holds);
        let zero = Vector3::zeros();
        match &mut self.user {
            User::Moves(path) => {
                let at_m = path.pop_front().unwrap_or(self.plant.at_m());
                self.plant.put(at_m);
            }
            User::Away | User::Holds => {
                self.plant.step(&Aim { at_m: zero, velocity_m_per_s: zero, push_n: zero, let_go, steady: true }, false);
            }
        }
        let per_m = f64::from(self.mistake.unit) / f64::from(EncoderCounts::LENGTH_M);
        let (at_m, sign) = (self.plant.at_m(), self.mistake.read_sign);
        self.mistake.reads.map(|axis| (at_m[axis] * f64::from(sign[axis]) * per_m).floor() as i32)
    }
}
