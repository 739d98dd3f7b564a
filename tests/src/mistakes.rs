//! Devices that are set up wrongly: sensors or motors of swapped axes, with wrong signs, or
//! readings in another unit. [`commissioned`] runs the commissioning on such a device, with the
//! steps of its user: a hand moves the handle along each axis, and lets it go.

use palpate::Vector3;
use palpate::haptic::commission::{Commissioned, Commissioning, Plan, Stage, Trouble, Wiring};
use palpate::haptic::device::HapticDevice;

use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_loop::closed_loop::hand::{Aim, HANDS, Hand};
use palpate_loop::closed_loop::plant::Plant;
use palpate_tissue::scene::TICK_S;

/// A mistake in the set-up of a device, as the wiring that it really has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mistake {
    /// Name in tables.
    pub name: &'static str,
    /// Axis that each wire of the encoders reads, and that each wire of the motors drives.
    pub reads: [usize; 3],
    /// Axis that each wire of the motors drives.
    pub drives: [usize; 3],
    /// Sign of the reading along each axis (1).
    pub read_sign: [f32; 3],
    /// Sign of the force along each axis (1).
    pub drive_sign: [f32; 3],
    /// Metres read per metre moved (1).
    pub unit: f32,
}

const RIGHT: Mistake =
    Mistake { name: "none", reads: [0, 1, 2], drives: [0, 1, 2], read_sign: [1.0; 3], drive_sign: [1.0; 3], unit: 1.0 };

const fn mirrored(name: &'static str, drive_sign: [f32; 3]) -> Mistake {
    Mistake { name, drive_sign, ..RIGHT }
}

const fn both(name: &'static str, sign: [f32; 3]) -> Mistake {
    Mistake { name, read_sign: sign, drive_sign: sign, ..RIGHT }
}

const fn swapped(name: &'static str, reads: [usize; 3], drives: [usize; 3]) -> Mistake {
    Mistake { name, reads, drives, ..RIGHT }
}

const fn unit(name: &'static str, unit: f32) -> Mistake {
    Mistake { name, unit, ..RIGHT }
}

/// All mistakes that are tried; the first entry is a device without one.
pub const MISTAKES: [Mistake; 20] = [
    RIGHT,
    mirrored("x mirrored", [-1.0, 1.0, 1.0]),
    mirrored("y mirrored", [1.0, -1.0, 1.0]),
    mirrored("z mirrored", [1.0, 1.0, -1.0]),
    mirrored("x and z mirrored", [-1.0, 1.0, -1.0]),
    mirrored("all mirrored", [-1.0; 3]),
    both("x mirrored, encoder and motor", [-1.0, 1.0, 1.0]),
    both("z mirrored, encoder and motor", [1.0, 1.0, -1.0]),
    both("all mirrored, encoders and motors", [-1.0; 3]),
    swapped("x and y swapped, encoders and motors", [1, 0, 2], [1, 0, 2]),
    swapped("y and z swapped, motors", [0, 1, 2], [0, 2, 1]),
    swapped("x and z swapped, encoders", [2, 1, 0], [0, 1, 2]),
    swapped("all in turn", [1, 2, 0], [2, 0, 1]),
    unit("unit x 10", 10.0),
    unit("unit / 10", 0.1),
    unit("unit x 1000", 1e3),
    unit("unit / 1000", 1e-3),
    unit("inches", 1e3 / 25.4),
    unit("millimetres for inches", 25.4),
    Mistake {
        name: "everything at once",
        reads: [2, 0, 1],
        drives: [1, 0, 2],
        read_sign: [-1.0, 1.0, -1.0],
        drive_sign: [-1.0, -1.0, 1.0],
        unit: 10.0,
    },
];

impl Mistake {
    /// The wiring that a commissioning has to find.
    pub fn wiring(&self) -> Wiring {
        let mut wiring = Wiring::STRAIGHT;
        for (wire, axis) in self.reads.into_iter().enumerate() {
            wiring.sensor[axis] = wire as u8;
            wiring.per_unit[axis] = self.read_sign[axis] / self.unit;
        }
        for (wire, axis) in self.drives.into_iter().enumerate() {
            wiring.motor[axis] = wire as u8;
            wiring.motor_sign[axis] = self.drive_sign[axis];
        }
        wiring
    }

    /// Values on the encoders' wires for a position [m].
    pub fn readings(&self, at_m: Vector3<f32>) -> [f32; 3] {
        self.reads.map(|axis| at_m[axis] * self.read_sign[axis] * self.unit)
    }

    /// Force [N] for the commands on the motors' wires.
    pub fn force_n(&self, commands: [f32; 3]) -> Vector3<f32> {
        let mut force_n = Vector3::zeros();
        for (axis, command) in self.drives.into_iter().zip(commands) {
            force_n[axis] = command * self.drive_sign[axis];
        }
        force_n
    }
}

/// Behaviour of the user's hand while the motors drive the handle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum HandsOff {
    /// Nothing: the handle is free.
    Free,
    /// It holds the handle where it is.
    Held(Hand),
    /// It moves the handle at this speed along x [m/s].
    Moved(f64),
}

/// Distance of the motions by hand [m].
pub const DISTANCE_M: f32 = 0.05;
/// Duration of a motion by hand [ticks].
const MOVE_TICKS: u32 = 1_000;
/// Longest commissioning that is followed [ticks].
const MOST_TICKS: u32 = 300_000;

/// Runs the whole commissioning of a device with a mistake. `error` is the relative error of the
/// distances by which the hand moves the handle (1).
pub fn commissioned(device: &DeviceProfile, mistake: &Mistake, hand: HandsOff, error: f64) -> Result<Commissioned, Trouble> {
    let grip = if let HandsOff::Held(hand) = hand { hand } else { HANDS[0] };
    let mut plant = Plant::new(device, grip, Vector3::zeros(), Vector3::z(), Vector3::zeros());
    let plan = Plan {
        axes: if device.axes == 1 { [false, false, true] } else { [true; 3] },
        distance_m: DISTANCE_M,
        force_limit_n: device.force_limit_n as f32,
        stated_m_per_unit: [1.0; 3],
        tick_s: TICK_S as f32,
    };
    let mut commissioning = Commissioning::new(plan);
    // ticks since the stage began
    let mut since = 0_u32;
    for _ in 0..MOST_TICKS {
        let stage = commissioning.stage();
        let share = f64::from(since.min(MOVE_TICKS)) / f64::from(MOVE_TICKS);
        match stage {
            Stage::Done => return commissioning.result().copied().ok_or(Trouble::Unclear),
            Stage::Stopped(trouble) => return Err(trouble),
            // a hand moves the handle, beginning off the centre
            Stage::Start(axis) => plant.put(unit_of(axis) * -0.02 + Vector3::repeat(1.3e-4)),
            Stage::Move(axis) => {
                plant.put(unit_of(axis) * (-0.02 + f64::from(DISTANCE_M) * (1.0 + error) * share) + Vector3::repeat(2.1e-4));
            }
            Stage::LetGo => plant.put(Vector3::new(0.7e-4, -1.1e-4, 0.4e-4)),
            Stage::Drive(_) => {}
        }
        let reading = mistake.readings(plant.sense().position_m);
        let forces_n = commissioning.tick(reading, stage.asks() && since > MOVE_TICKS);
        since = if commissioning.stage() == stage { since + 1 } else { 0 };
        assert!(forces_n.iter().all(|n| n.abs() <= 0.5), "{forces_n:?}");
        if matches!(stage, Stage::Drive(_)) {
            plant.actuate(mistake.force_n(forces_n));
            let free = Aim {
                at_m: Vector3::zeros(),
                velocity_m_per_s: Vector3::zeros(),
                push_n: Vector3::zeros(),
                let_go: !matches!(hand, HandsOff::Held(_)),
                steady: true,
            };
            plant.step(&free, false);
            if let HandsOff::Moved(m_per_s) = hand {
                plant.put(plant.at_m() + Vector3::x() * (m_per_s * TICK_S));
            }
        }
    }
    Err(Trouble::Interrupted)
}

fn unit_of(axis: u8) -> Vector3<f64> {
    let mut unit = Vector3::zeros();
    unit[usize::from(axis)] = 1.0;
    unit
}
