//! Commissioning on a mock board: wrong wiring is found from the encoders' counts and the
//! converters' codes alone, and whatever interrupts it turns the outputs off.

use palpate::Fault;
use palpate::haptic::commission::{Commissioned, Stage, Trouble};
use palpate::haptic::cycle::{Ask, Command};
use palpate::haptic::device::SensorStatus;
use palpate::haptic::mode::Mode;
use palpate_controller::commission::Setup;
use palpate_controller::controller::Arming;
use palpate_controller::device::Device;
use palpate_controller::force_out::DacCode;
use palpate_controller::haptic_loop::HapticLoop;
use palpate_controller::link::message::HostAsk;
use palpate_controller::link::{FromBoard, Record, Refusal, ToBoard};
use palpate_controller::port::Port;
use palpate_controller::probe_in::{EncoderCounts, JointReading, Reading};

use super::mechanisms::paddle;
use super::mock::{Mock, Slab, haptic_loop_on};
use super::served::{answers, decoded};

const DISTANCE_M: f32 = 0.04;
/// Ticks of a motion by hand.
const MOTION: u32 = 800;
/// Mass [kg] and friction [N] of every axis of the emulated device, and its lever [m] on a joint.
const MASS_KG: f64 = 0.08;
const FRICTION_N: f64 = 0.06;

/// A device behind the pins, as it is really wired.
struct Wired {
    m_per_count: [f64; 3],
    encoder: [usize; 3],
    n_per_code: [f64; 3],
    motor: [usize; 3],
    at_m: [f64; 3],
    m_per_s: [f64; 3],
    /// Counts of every encoder in the middle.
    middle: i32,
    /// Force that the amplifiers still have to receive: a delay of one tick.
    late_n: [f64; 3],
}

impl Wired {
    fn counts(&self) -> [EncoderCounts; 3] {
        self.encoder
            .map(|axis| EncoderCounts(self.middle.wrapping_add((self.at_m[axis] / self.m_per_count[axis]).floor() as i32)))
    }

    /// A millisecond under the codes of the pins.
    fn drive(&mut self, codes: [DacCode; 3]) {
        let force_n = std::mem::take(&mut self.late_n);
        for (axis, code) in self.motor.into_iter().zip(codes) {
            self.late_n[axis] = f64::from(code.0) * self.n_per_code[axis];
        }
        for _ in 0..20 {
            for (axis, force_n) in force_n.iter().enumerate() {
                let speed = self.m_per_s[axis] + force_n / MASS_KG * 5e-5;
                let slower = (speed.abs() - FRICTION_N / MASS_KG * 5e-5).max(0.0);
                self.m_per_s[axis] = speed.signum() * slower;
                self.at_m[axis] += self.m_per_s[axis] * 5e-5;
            }
        }
    }
}

/// Loop, device and user.
struct Rig {
    haptic: HapticLoop<Mock>,
    device: Wired,
    status: SensorStatus,
    tick: u32,
    since: u32,
    from_m: [f64; 3],
}

impl Rig {
    fn begin(device: Wired, setup: &Setup) -> Self {
        let haptic = haptic_loop_on(Port::DESKTOP.with_operator_switch(true), Arming::OnRequest);
        let mut rig = Self { haptic, device, status: SensorStatus::Good, tick: 0, since: 0, from_m: [0.0; 3] };
        for _ in 0..10 {
            rig.run(Command::HEARD);
        }
        assert_eq!(rig.haptic.controller.mode(), Mode::Idle);
        let reading = rig.reading();
        rig.haptic.commission(setup, reading);
        // what the encoders count from is not known: it wraps, and single precision does not hold
        // it
        rig.device.middle = i32::MAX - 1_000;
        rig
    }

    fn reading(&self) -> Reading {
        Reading::Joints(JointReading { counts: self.device.counts(), sequence: self.tick, status: self.status })
    }

    fn run(&mut self, command: Command) -> Record {
        self.tick += 1;
        self.haptic.board.period = self.tick;
        let reading = self.reading();
        let record = self.haptic.tick(&mut Slab, reading, command, Some(self.tick));
        let pins = self.haptic.board.pins;
        if pins.enabled {
            self.device.drive(pins.codes);
            for (axis, code) in self.device.motor.into_iter().zip(pins.codes) {
                assert!((f64::from(code.0) * self.device.n_per_code[axis]).abs() <= 0.501, "{pins:?}");
            }
        }
        record
    }

    fn stage(&mut self) -> Stage {
        self.haptic.bench().unwrap().told().0.stage().unwrap()
    }

    /// A tick with what the user does in it.
    fn step(&mut self, command: Command) -> Stage {
        let stage = self.stage();
        if let Stage::Move(axis) = stage {
            let axis = usize::from(axis);
            let share = f64::from(self.since.min(MOTION)) / f64::from(MOTION);
            self.device.at_m[axis] = self.from_m[axis] + f64::from(DISTANCE_M) * share;
        } else {
            self.from_m = self.device.at_m;
        }
        if stage.asks() && self.since > MOTION {
            self.haptic.bench().unwrap().confirm();
        }
        self.run(command);
        let driven = matches!(self.stage(), Stage::Drive(_));
        assert!(driven || !self.haptic.board.pins.enabled, "the outputs are on in {:?}", self.stage());
        self.since = if self.stage() == stage { self.since + 1 } else { 0 };
        self.stage()
    }

    fn until(&mut self, wanted: impl Fn(Stage) -> bool) -> Stage {
        for _ in 0..200_000 {
            let stage = self.step(Command::HEARD);
            if wanted(stage) || stage.ended() {
                return stage;
            }
        }
        self.stage()
    }
}

fn axes(encoder: [usize; 3], motor: [usize; 3], signs: [f64; 3], unit: f64) -> (Wired, Setup) {
    let per_code = f64::from(DacCode::FULL_SCALE_N) / 32_767.0;
    let device = Wired {
        m_per_count: signs.map(|sign| sign * unit * 1e-5),
        encoder,
        n_per_code: [per_code, -per_code, per_code],
        motor,
        at_m: [3e-6; 3],
        m_per_s: [0.0; 3],
        middle: 1_000,
        late_n: [0.0; 3],
    };
    (device, Setup::of(&Port::DESKTOP, 3.0, DISTANCE_M))
}

fn found(rig: &mut Rig) -> Commissioned {
    assert_eq!(rig.until(|stage| stage == Stage::Done), Stage::Done);
    (&rig.haptic.bench().unwrap().told().1.unwrap()).into()
}

#[test]
fn swapped_mirrored_and_scaled_axes_are_found_and_the_device_then_reads_and_pushes_right() {
    let wirings = [([0, 1, 2], [0, 1, 2], [1.0; 3], 1.0), ([1, 2, 0], [2, 1, 0], [1.0, -1.0, -1.0], 10.0)];
    for (encoder, motor, signs, unit) in wirings {
        let (device, setup) = axes(encoder, motor, signs, unit);
        let mut rig = Rig::begin(device, &setup);
        let found = found(&mut rig);
        let wiring = found.wiring;
        for axis in 0..3 {
            assert_eq!(encoder[usize::from(wiring.sensor[axis])], axis);
            assert_eq!(motor[usize::from(wiring.motor[axis])], axis);
            assert_eq!(f64::from(wiring.motor_sign[axis]), [1.0, -1.0, 1.0][axis]);
            let ratio = f64::from(wiring.per_unit[axis]) / (signs[axis] * unit * 1e-5);
            assert!((ratio - 1.0).abs() < 0.01, "{wiring:?}");
            assert!((f64::from(found.friction_n[axis]) - FRICTION_N).abs() < 5e-3, "{found:?}");
            assert!((f64::from(found.mass_kg[axis]) / MASS_KG - 1.0).abs() < 0.1, "{found:?}");
        }
        let late_s = f32::from(found.delay_ticks) * 1e-3 + found.lag_s;
        assert!((1e-3..=2e-3).contains(&late_s), "{found:?}");
        assert!(!rig.haptic.board.pins.enabled && rig.haptic.board.fed > 1_000);
        assert_eq!(rig.haptic.controller.mode(), Mode::Idle);

        let mut wired = wiring;
        wired.per_unit = wiring.per_unit.map(|m| m / EncoderCounts::LENGTH_M);
        let mut device = Device::new(None, [0; 3]).with_wiring(wired);
        rig.device.at_m = [0.01, 0.02, -0.03];
        let counts = rig.device.counts().map(|counts| EncoderCounts(counts.0.wrapping_sub(rig.device.middle)));
        let at_m = device.sensed(&Reading::Joints(JointReading { counts, sequence: 9, status: SensorStatus::Good })).position_m;
        assert!((at_m - palpate::Vector3::new(0.01, 0.02, -0.03)).norm() < 4e-4, "{at_m}");
        let force_n = palpate::Vector3::new(0.3, 0.2, -0.1);
        let codes = device.outputs(palpate_controller::force_out::ActuatorCommand::Force(force_n)).codes;
        for (wire, axis) in motor.into_iter().enumerate() {
            let pushed_n = f64::from(codes[wire].0) * rig.device.n_per_code[axis];
            assert!((pushed_n - f64::from(force_n[axis])).abs() < 1e-3, "{codes:?}");
        }
    }
}

#[test]
fn a_paddle_with_a_reversed_encoder_and_motor_is_measured_by_its_joint() {
    let profile = paddle();
    let port = Port::DESKTOP.with_device(Device::new(Some(&profile), [0; 3]));
    let setup = Setup::of(&port, 3.0, DISTANCE_M);
    assert!(setup.sound() && setup.axes == [true, false, false], "{setup:?}");
    let lever_m = f64::from(profile.dimensions[0]);
    let device = Wired {
        m_per_count: [-lever_m * f64::from(profile.rad_per_count[0]), 1.0, 1.0],
        encoder: [0, 1, 2],
        n_per_code: [-f64::from(profile.full_scale_n_m[0]) / lever_m / 32_767.0, 0.0, 0.0],
        motor: [0, 1, 2],
        at_m: [0.0; 3],
        m_per_s: [0.0; 3],
        middle: 1_000,
        late_n: [0.0; 3],
    };
    let found = found(&mut Rig::begin(device, &setup));
    assert_eq!((found.wiring.sensor[0], found.wiring.motor[0], found.wiring.motor_sign[0]), (0, 0, -1.0));
    let count_m = 0.09 * profile.rad_per_count[0];
    assert!((found.wiring.per_unit[0] / -count_m - 1.0).abs() < 1e-3, "the data sheet's: {found:?}");
    assert!((f64::from(found.friction_n[0]) - FRICTION_N).abs() < 5e-3 && found.mass_kg[1] == 0.0, "{found:?}");
}

/// Runs until the first motor drives.
fn driven() -> Rig {
    let (device, setup) = axes([0, 1, 2], [0, 1, 2], [1.0; 3], 1.0);
    let mut rig = Rig::begin(device, &setup);
    assert_eq!(rig.until(|stage| stage == Stage::Drive(0)), Stage::Drive(0));
    (0..400).for_each(|_| _ = rig.step(Command::HEARD));
    assert!(rig.haptic.board.pins.enabled);
    rig
}

/// Runs until the first motor drives, then once with this command.
fn ended_by(change: impl Fn(&mut Rig), command: Command) -> (Stage, bool) {
    let mut rig = driven();
    change(&mut rig);
    rig.step(command);
    (rig.stage(), rig.haptic.board.pins.enabled)
}

#[test]
fn whatever_interrupts_it_turns_the_outputs_off_in_the_same_tick() {
    let interrupted = (Stage::Stopped(Trouble::Interrupted), false);
    let faulted = (Stage::Stopped(Trouble::Faulted), false);
    assert_eq!(ended_by(|_| (), Command { asked: Some(Ask::Stop), ..Command::HEARD }), interrupted);
    assert_eq!(ended_by(|rig| rig.haptic.end_commissioning(), Command::HEARD), interrupted);
    assert_eq!(ended_by(|rig| rig.haptic.board.stop = Some(Fault::EmergencyStop), Command::HEARD), faulted);
    assert_eq!(ended_by(|rig| rig.haptic.board.supply_low = true, Command::HEARD), faulted);
    assert_eq!(ended_by(|_| (), Command { operator_absent: true, ..Command::HEARD }), interrupted);
    assert_eq!(ended_by(|rig| rig.tick += 1, Command::HEARD), interrupted, "a period without a tick");
    assert_eq!(ended_by(|rig| rig.status = SensorStatus::Failed, Command::HEARD), faulted);
    let silent = |rig: &mut Rig| (0..19).for_each(|_| _ = rig.step(Command::default()));
    assert_eq!(ended_by(silent, Command::default()), interrupted);
    let heard = |rig: &mut Rig| (0..18).for_each(|_| _ = rig.step(Command::default()));
    assert_eq!(ended_by(heard, Command::HEARD).0, Stage::Drive(0));
    let held = |rig: &mut Rig| rig.device.at_m[0] += 0.1;
    assert_eq!(ended_by(held, Command::HEARD), (Stage::Stopped(Trouble::TooFar), false));
}

#[test]
fn a_host_that_pauses_ends_it_only_while_a_motor_is_driven() {
    let (device, setup) = axes([0, 1, 2], [0, 1, 2], [1.0; 3], 1.0);
    let mut rig = Rig::begin(device, &setup);
    (0..499).for_each(|_| _ = rig.step(Command::default()));
    assert_eq!(rig.stage(), Stage::Start(0), "the outputs are off");
    rig.step(Command::default());
    assert_eq!(rig.stage(), Stage::Stopped(Trouble::Interrupted));
}

#[test]
fn another_patch_or_profile_turns_the_outputs_off_before_it_is_opened() {
    let mut rig = driven();
    rig.haptic.end_commissioning();
    assert!(!rig.haptic.board.pins.enabled);
}

#[test]
fn nothing_arms_meanwhile_and_a_wrong_unit_is_no_fault_then() {
    // counts of 0.1 um: by the profile the handle leaves the workspace
    let (device, setup) = axes([0, 1, 2], [0, 1, 2], [1.0; 3], 0.01);
    let mut rig = Rig::begin(device, &setup);
    for _ in 0..2_000 {
        rig.step(Command { asked: Some(Ask::Arm), ..Command::HEARD });
    }
    assert_eq!((rig.haptic.controller.mode(), rig.stage()), (Mode::Idle, Stage::Start(1)));
}

#[test]
fn a_setup_out_of_range_is_unsound() {
    let right = Setup::of(&Port::DESKTOP, 3.0, DISTANCE_M);
    assert!(right.sound());
    for wrong in [
        Setup { distance_m: f32::NAN, ..right },
        Setup { distance_m: 1e-3, ..right },
        Setup { axes: [false; 3], ..right },
        Setup { force_limit_n: 0.0, ..right },
        Setup { stated_m_per_count: [1e-5, 0.0, 1e-5], ..right },
        Setup { share_per_n: [0.1, 0.1, 3.0], ..right },
    ] {
        assert!(!wrong.sound(), "{wrong:?}");
    }
}

#[test]
fn a_host_begins_it_confirms_its_steps_and_stops_it_over_the_link() {
    let joints = |sequence: u32| ToBoard::Joints { counts: [0; 3], sequence, good: true };
    let setup = Setup::of(&Port::DESKTOP, 3.0, DISTANCE_M);
    let mut messages: Vec<ToBoard> = (1..=5).map(joints).collect();
    messages.push(ToBoard::Commission(Setup { distance_m: 9.0, ..setup }));
    messages.extend([ToBoard::Commission(setup), joints(6), ToBoard::Confirm, joints(7), ToBoard::Confirm, joints(8)]);
    messages.extend([ToBoard::Commission(setup), joints(9), ToBoard::Ask(HostAsk::Stop), joints(10)]);
    let told: Vec<FromBoard> = answers(&messages)
        .0
        .into_iter()
        .map(|frame| decoded(frame, |message| message))
        .filter(|message| !matches!(message, FromBoard::Record(_)))
        .collect();
    let step = |stage| match stage {
        FromBoard::Commissioning(progress) => progress.stage(),
        _ => None,
    };
    assert_eq!(told.first(), Some(&FromBoard::Refused(Refusal::Commissioning)));
    assert_eq!(
        told.into_iter().skip(1).map(step).collect::<Vec<_>>(),
        [
            Some(Stage::Start(0)),
            Some(Stage::Move(0)),
            Some(Stage::Stopped(Trouble::NotMoved(0))),
            Some(Stage::Start(0)),
            Some(Stage::Stopped(Trouble::Interrupted))
        ]
    );
}
