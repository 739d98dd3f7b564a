//! The commissioning on an emulated handle: what it finds, and everything that ends it.
#![expect(clippy::disallowed_types, reason = "the handle is no part of the board, and moves by less than single precision tells")]

use std::collections::VecDeque;

use palpate::haptic::commission::{Commissioned, Commissioning, Plan, Stage, Trouble};

/// Distance of the motions by hand [m], and ticks that each takes.
const DISTANCE_M: f64 = 0.04;
const MOTION: u32 = 300;
/// Steps of the handle per tick.
const STEPS: u32 = 20;
const STEP_S: f64 = 1e-3 / 20.0;

/// A handle with its wires. Every axis has the same mass and friction.
#[derive(Clone, Debug)]
struct Handle {
    mass_kg: f64,
    friction_n: f64,
    viscous_n_s_per_m: f64,
    delay: usize,
    lag_s: f64,
    /// Step of the readings [m]; zero for ideal sensors.
    count_m: f64,
    /// Axis that each sensor reads, and metres of the axis per unit of the reading.
    reads: [usize; 3],
    m_per_unit: [f64; 3],
    /// Force along the axes by a newton of each motor.
    drives: [[f64; 3]; 3],
    /// Spring to the place where the handle was let go [N/m], and a steady force along x [N].
    held_n_per_m: f64,
    steady_n: f64,
    /// Displacement of the hand in the motion along each axis [m].
    moves_m: [[f64; 3]; 3],
    at_m: [f64; 3],
    m_per_s: [f64; 3],
    acting_n: [f64; 3],
    line_n: VecDeque<[f64; 3]>,
}

/// A handle of 80 g with 50 mN of friction, straight wires and counts of 10 um, in which forces
/// act at once.
fn handle() -> Handle {
    let along = |length: f64| [[length, 0.0, 0.0], [0.0, length, 0.0], [0.0, 0.0, length]];
    Handle {
        mass_kg: 0.08,
        friction_n: 0.05,
        viscous_n_s_per_m: 0.1,
        delay: 0,
        lag_s: 0.0,
        count_m: 10e-6,
        reads: [0, 1, 2],
        m_per_unit: [1.0; 3],
        drives: along(1.0),
        held_n_per_m: 0.0,
        steady_n: 0.0,
        moves_m: along(DISTANCE_M),
        at_m: [3.1e-4, -2.3e-4, 1.7e-4],
        m_per_s: [0.0; 3],
        acting_n: [0.0; 3],
        line_n: VecDeque::new(),
    }
}

impl Handle {
    fn readings(&self) -> [f32; 3] {
        let read = |axis: usize| match self.count_m > 0.0 {
            true => (self.at_m[axis] / self.count_m).floor() * self.count_m,
            false => self.at_m[axis],
        };
        std::array::from_fn(|sensor| (read(self.reads[sensor]) / self.m_per_unit[self.reads[sensor]]) as f32)
    }

    fn drive(&mut self, commands_n: [f32; 3], home_m: [f64; 3]) {
        let along = |axis: usize| commands_n.iter().zip(self.drives).map(|(n, to)| f64::from(*n) * to[axis]).sum();
        self.line_n.push_back(std::array::from_fn(along));
        let asked_n = if self.line_n.len() > self.delay { self.line_n.pop_front().unwrap() } else { [0.0; 3] };
        for _ in 0..STEPS {
            for axis in 0..3 {
                let share = if self.lag_s > 0.0 { 1.0 - (-STEP_S / self.lag_s).exp() } else { 1.0 };
                self.acting_n[axis] += (asked_n[axis] - self.acting_n[axis]) * share;
                let held_n = self.held_n_per_m * (home_m[axis] - self.at_m[axis]);
                let steady_n = if axis == 0 { self.steady_n } else { 0.0 };
                let force_n = self.acting_n[axis] + held_n + steady_n - self.viscous_n_s_per_m * self.m_per_s[axis];
                let faster = self.m_per_s[axis] + force_n / self.mass_kg * STEP_S;
                let slower = (faster.abs() - self.friction_n / self.mass_kg * STEP_S).max(0.0);
                self.m_per_s[axis] = slower.copysign(faster);
                self.at_m[axis] += self.m_per_s[axis] * STEP_S;
            }
        }
    }
}

fn plan() -> Plan {
    Plan { axes: [true; 3], distance_m: DISTANCE_M as f32, force_limit_n: 3.0, stated_m_per_unit: [1.0; 3], tick_s: 1e-3 }
}

/// Runs a commissioning with the steps of its user. `seen` is called after every tick.
fn run(handle: &mut Handle, plan: Plan, mut seen: impl FnMut(&mut Commissioning, &mut Handle)) -> Result<Commissioned, Trouble> {
    let most_n = plan.force_limit_n.min(0.5);
    let mut commissioning = Commissioning::new(plan);
    let (mut from_m, mut since) = (handle.at_m, 0_u32);
    for _ in 0..200_000 {
        let stage = commissioning.stage();
        match stage {
            Stage::Done => return Ok(*commissioning.result().unwrap()),
            Stage::Stopped(trouble) => return Err(trouble),
            Stage::Move(axis) => {
                let share = 0.5 - 0.5 * (std::f64::consts::PI * f64::from(since.min(MOTION)) / f64::from(MOTION)).cos();
                let way_m = handle.moves_m[usize::from(axis)];
                handle.at_m = std::array::from_fn(|axis| from_m[axis] + share * way_m[axis]);
            }
            Stage::Start(_) | Stage::LetGo => from_m = handle.at_m,
            Stage::Drive(_) => {}
        }
        let confirms = stage.asks() && since > MOTION;
        let commands_n = commissioning.tick(handle.readings(), confirms);
        let left = stage.asks() && commissioning.stage() != stage && !commissioning.stage().ended();
        assert!(confirms || !left, "{stage:?} was left without the user");
        let drives = commands_n.iter().filter(|n| **n != 0.0).count();
        assert!(commands_n.iter().all(|n| n.abs() <= most_n) && drives <= 1, "{commands_n:?}");
        assert!(drives == 0 || matches!(commissioning.stage(), Stage::Drive(_)), "{commands_n:?} in {stage:?}");
        if matches!(stage, Stage::Drive(_)) {
            handle.drive(commands_n, from_m);
        }
        since = if commissioning.stage() == stage { since + 1 } else { 0 };
        seen(&mut commissioning, handle);
    }
    panic!("it does not end: {:?}", commissioning.stage());
}

fn found(handle: &mut Handle, plan: Plan) -> Commissioned {
    run(handle, plan, |_, _| ()).unwrap_or_else(|trouble| panic!("{handle:?}: {trouble}"))
}

#[test]
fn swapped_and_mirrored_wires_and_a_wrong_unit_are_found() {
    let mut handle = Handle {
        reads: [2, 0, 1],
        m_per_unit: [0.1, -0.1, 0.1],
        drives: [[0.0, -1.0, 0.0], [0.0, 0.0, 1.0], [-1.0, 0.0, 0.0]],
        ..handle()
    };
    let Commissioned { wiring, count_m, .. } = found(&mut handle, plan());
    assert_eq!((wiring.sensor, wiring.motor, wiring.motor_sign), ([1, 2, 0], [2, 0, 1], [-1.0, -1.0, 1.0]));
    for (unit, right) in wiring.per_unit.into_iter().zip(handle.m_per_unit) {
        assert!((f64::from(unit) / right - 1.0).abs() < 2e-3, "{wiring:?}");
    }
    assert!(count_m.iter().all(|m| (m / 10e-6 - 1.0).abs() < 0.02), "{count_m:?}");
    // the same device straight: the reading of every axis follows it
    let read = wiring.read([1.0, 2.0, 3.0]);
    assert!((read[0] - 0.2).abs() < 1e-3 && (read[1] + 0.3).abs() < 1e-3 && (read[2] - 0.1).abs() < 1e-3, "{read:?}");
    assert_eq!(wiring.drive([1.0, 2.0, 3.0]), [-2.0, 3.0, -1.0]);
}

#[test]
fn friction_mass_delay_and_lag_are_measured() {
    let settings = [
        (0.0, 0.05, 0, 0.0, 10e-6),
        (0.05, 0.08, 1, 1e-3, 10e-6),
        (0.2, 0.2, 3, 3e-3, 10e-6),
        (0.1, 0.1, 7, 0.0, 55e-6),
        (0.03, 0.05, 2, 5e-3, 0.0),
    ];
    for (friction_n, mass_kg, delay, lag_s, count_m) in settings {
        let viscous_n_s_per_m = if friction_n == 0.0 { 0.5 } else { 0.1 };
        let mut handle = Handle { friction_n, mass_kg, delay, lag_s, count_m, viscous_n_s_per_m, ..handle() };
        let found = found(&mut handle, plan());
        let late_s = f64::from(found.delay_ticks) * 1e-3 + f64::from(found.lag_s) - delay as f64 * 1e-3 - lag_s;
        assert!((0.0..if count_m > 20e-6 { 2e-3 } else { 1.01e-3 }).contains(&late_s), "{late_s} {handle:?} {found:?}");
        // an error of 6 ms in delay and lag would be 1.5 mN of friction
        let rubs_n = if count_m > 20e-6 || friction_n == 0.0 { 5e-3 } else { 1e-3 };
        let ratio = if count_m > 20e-6 { 0.2 } else { 0.05 };
        for axis in 0..3 {
            assert!((f64::from(found.friction_n[axis]) - friction_n).abs() < rubs_n, "{handle:?} {found:?}");
            assert!((f64::from(found.mass_kg[axis]) / mass_kg - 1.0).abs() < ratio, "{handle:?} {found:?}");
            assert!((f64::from(found.count_m[axis]) - count_m).abs() < 0.02 * count_m + 1e-7, "{found:?}");
        }
    }
}

/// Handles whose best fit is later than they are by more than half a tick, of 2400 that were drawn:
/// mass [kg], friction [N], viscous friction [N s/m], delay [ticks], lag [s] and count [m].
const HARD: [(f64, f64, f64, usize, f64, f64); 8] = [
    (0.0301, 0.1696, 0.274, 7, 5.98e-3, 40e-6),
    (0.1011, 0.0059, 0.228, 6, 1.45e-3, 60e-6),
    (0.0707, 0.0242, 0.208, 2, 0.37e-3, 80e-6),
    (0.1983, 0.0478, 0.340, 7, 0.0, 80e-6),
    (0.2759, 0.0134, 0.263, 2, 3.82e-3, 80e-6),
    (0.1954, 0.0244, 0.129, 0, 4.97e-3, 80e-6),
    (0.1927, 0.0876, 0.190, 4, 5.77e-3, 80e-6),
    (0.1900, 0.1049, 0.158, 2, 5.57e-3, 80e-6),
];

#[test]
fn no_device_is_later_than_its_profile_says() {
    let mut random = 7_u64;
    let mut draw = || {
        random = random.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (random >> 40) as f64 / f64::from(1 << 24)
    };
    let drawn = (0..16).map(|number| {
        let lag_s = if draw() < 0.4 { 0.0 } else { 6e-3 * draw() };
        let mass_kg = 0.03 * 10.0_f64.powf(draw());
        (mass_kg, 0.2 * draw(), 0.05 + 0.3 * draw(), (8.0 * draw()) as usize, lag_s, 25e-6 * f64::from(number % 4))
    });
    let drawn = drawn.collect::<Vec<_>>();
    let mut sum_ms = 0.0;
    for &(mass_kg, friction_n, viscous_n_s_per_m, delay, lag_s, count_m) in drawn.iter().chain(&HARD) {
        let mut handle = Handle { mass_kg, friction_n, viscous_n_s_per_m, delay, lag_s, count_m, ..handle() };
        let found = found(&mut handle, plan());
        let spare_ms = f64::from(found.delay_ticks) + (f64::from(found.lag_s) - lag_s) * 1e3 - delay as f64;
        assert!(spare_ms > -0.2, "{spare_ms} ms, {handle:?} {found:?}");
        sum_ms += spare_ms;
    }
    assert!(sum_ms < 1.5 * 24.0, "as short as it may be: {sum_ms} ms in all");
}

#[test]
fn a_weak_device_is_pushed_with_its_own_limit_at_most() {
    let weak = Plan { force_limit_n: 0.15, ..plan() };
    assert!(found(&mut handle(), weak).friction_n.iter().all(|n| (n - 0.05).abs() < 5e-3));
    let stuck = run(&mut Handle { friction_n: 0.2, ..handle() }, weak, |_, _| ());
    assert_eq!(stuck, Err(Trouble::Stuck(0)));
}

#[test]
fn the_stated_unit_is_kept_within_a_tenth_and_else_the_measured_one_is_taken() {
    for (stated, kept) in [(1.0, true), (0.92, true), (1.09, true), (0.9, false), (1.12, false)] {
        let found = found(&mut handle(), Plan { stated_m_per_unit: [stated; 3], ..plan() });
        let right = if kept { stated } else { 1.0 };
        assert!(found.wiring.per_unit.iter().all(|unit| (unit / right - 1.0).abs() < 1e-3), "{stated}: {found:?}");
    }
}

#[test]
fn a_device_of_one_axis_has_one_motor_and_the_other_wires_are_spare() {
    // only sensor 1 reads and only motor 0 drives
    let mut handle = Handle { reads: [0, 2, 1], drives: [[0.0, 0.0, -1.0], [0.0; 3], [0.0; 3]], ..handle() };
    let found = found(&mut handle, Plan { axes: [false, false, true], ..plan() });
    assert_eq!((found.wiring.sensor, found.wiring.motor), ([0, 2, 1], [1, 2, 0]));
    assert_eq!((found.wiring.motor_sign, found.mass_kg[0], found.friction_n[1]), ([1.0, 1.0, -1.0], 0.0, 0.0));
    assert!((found.mass_kg[2] / 0.08 - 1.0).abs() < 0.05, "{found:?}");
    let mut asked = Vec::new();
    let plane = run(
        &mut Handle { drives: [handle.drives[0], [0.0; 3], [1.0, 0.0, 0.0]], ..self::handle() },
        Plan { axes: [true, false, true], ..plan() },
        |commissioning, _| {
            if let Stage::Move(axis) = commissioning.stage()
                && asked.last() != Some(&axis)
            {
                asked.push(axis);
            }
        },
    );
    assert!(plane.is_ok() && asked == [0, 2], "{asked:?}: {plane:?}");
    assert!(found.count_m[0] == 0.0 && found.count_m[2] > 9e-6, "{found:?}");
    assert_eq!(run(&mut handle, Plan { axes: [false; 3], ..plan() }, |_, _| ()), Err(Trouble::Unclear));
}

#[test]
fn a_motion_by_hand_that_says_nothing_ends_it() {
    let moves_m = |axis: usize, way_m: [f64; 3]| {
        let mut moved = Handle { count_m: 100e-6, ..handle() };
        moved.moves_m[axis] = way_m;
        run(&mut moved, plan(), |commissioning, _| {
            if let Stage::Drive(_) = commissioning.stage() {
                commissioning.stop(Trouble::Interrupted);
            }
        })
    };
    assert_eq!(moves_m(0, [0.0; 3]), Err(Trouble::NotMoved(0)));
    assert_eq!(moves_m(1, [0.0, 19e-4, 0.0]), Err(Trouble::NotMoved(1)));
    assert_eq!(moves_m(1, [0.0, 23e-4, 0.0]), Err(Trouble::Interrupted), "twenty counts are enough");
    assert_eq!(moves_m(2, [0.0, 0.022, 0.04]), Err(Trouble::Slanted(2)));
    assert_eq!(moves_m(2, [0.0, 0.04, 0.022]), Err(Trouble::Slanted(2)));
    assert_eq!(moves_m(2, [0.0, -0.018, 0.04]), Err(Trouble::Interrupted), "it may slant by 24 degrees");
    assert_eq!(moves_m(1, [0.04, 0.0, 0.0]), Err(Trouble::SameSensor(1)));
}

#[test]
fn a_handle_that_does_not_answer_its_motors_as_a_free_one_ends_it() {
    let ended = |handle: Handle| run(&mut handle.clone(), plan(), |_, _| ());
    let straight = handle().drives;
    let [x, y, z] = straight;
    for n_per_m in [30.0, 100.0, 190.0, 1_000.0] {
        let held = ended(Handle { held_n_per_m: n_per_m, ..handle() });
        // a stiff hand lets the handle move by less than the push that is tried
        let stiff = matches!(held, Err(Trouble::Stuck(0)));
        assert!(matches!(held, Err(Trouble::Held(0))) || (stiff && n_per_m > 500.0), "{n_per_m} N/m: {held:?}");
    }
    assert!(ended(Handle { friction_n: 0.42, ..handle() }).is_ok(), "with what 0.5 N leaves");
    assert_eq!(ended(Handle { friction_n: 0.6, ..handle() }), Err(Trouble::Stuck(0)));
    assert_eq!(ended(Handle { drives: [x, [0.0; 3], z], ..handle() }), Err(Trouble::Stuck(1)));
    assert_eq!(ended(Handle { drives: [x, [0.0, 0.7, 0.7], z], ..handle() }), Err(Trouble::TwoAxes(1)));
    assert!(ended(Handle { drives: [x, [0.0, 1.0, 0.3], z], ..handle() }).is_ok(), "most of it along one axis");
    assert_eq!(ended(Handle { drives: [x, y, y], ..handle() }), Err(Trouble::SameMotor(2)));
    assert_eq!(ended(Handle { steady_n: 0.2, friction_n: 0.25, ..handle() }), Err(Trouble::Unsteady(0)));
    let dragged = ended(Handle { steady_n: 0.04, friction_n: 0.1, ..handle() }).unwrap();
    assert!((dragged.friction_n[0] - 0.1).abs() < 5e-3, "a cable may drag a little: {dragged:?}");
    assert_eq!(ended(Handle { steady_n: 0.1, ..handle() }), Err(Trouble::Moving));
    assert_eq!(ended(Handle { friction_n: 0.0, viscous_n_s_per_m: 0.0, ..handle() }), Err(Trouble::TooFar));
}

#[test]
fn a_handle_that_is_moved_while_no_motor_drives_it_ends_it_after_eight_seconds() {
    let mut ticks = 0;
    let moved = run(&mut handle(), plan(), |commissioning, handle| {
        if let Stage::Drive(0) = commissioning.stage() {
            ticks += 1;
            handle.at_m[0] += 0.5e-6;
        }
    });
    assert_eq!(moved, Err(Trouble::Moving));
    assert!((8_000..8_010).contains(&ticks), "{ticks}");
    let far = run(&mut handle(), plan(), |commissioning, handle| {
        if let Stage::Drive(0) = commissioning.stage() {
            handle.at_m[0] += 0.1;
        }
    });
    assert_eq!(far, Err(Trouble::Moving));
}

#[test]
fn whatever_stops_it_leaves_no_result_and_no_force() {
    for at in [Stage::Start(0), Stage::Move(2), Stage::LetGo, Stage::Drive(0), Stage::Drive(2)] {
        let stopped = run(&mut handle(), plan(), |commissioning, _| {
            if commissioning.stage() == at {
                commissioning.stop(Trouble::Interrupted);
                commissioning.stop(Trouble::Faulted);
                assert_eq!(commissioning.tick([0.0; 3], true), [0.0; 3]);
                assert!(commissioning.result().is_none() && commissioning.stage().ended());
            }
        });
        assert_eq!(stopped, Err(Trouble::Interrupted), "{at:?}: the first reason stays");
        let unread = run(&mut handle(), plan(), |commissioning, _| {
            if commissioning.stage() == at {
                assert_eq!(commissioning.tick([0.0, f32::NAN, 0.0], true), [0.0; 3]);
            }
        });
        assert_eq!(unread, Err(Trouble::Faulted), "{at:?}");
    }
}

#[test]
fn a_reason_is_read_back_from_its_number() {
    let of: [fn(u8) -> Trouble; 8] = [
        Trouble::NotMoved,
        Trouble::Slanted,
        Trouble::SameSensor,
        Trouble::Stuck,
        Trouble::Held,
        Trouble::Unsteady,
        Trouble::TwoAxes,
        Trouble::SameMotor,
    ];
    let numbered = of.iter().flat_map(|reason| (0..3).map(reason));
    let plain = [Trouble::Interrupted, Trouble::Faulted, Trouble::Moving, Trouble::TooFar, Trouble::Unclear];
    for reason in plain.into_iter().chain(numbered) {
        assert_eq!(Trouble::of_number(reason.number()), Some(reason));
    }
    assert_eq!(Trouble::of_number(0), None);
}

#[test]
fn a_result_that_gives_two_axes_one_wire_is_refused() {
    let right = found(&mut handle(), plan()).wiring;
    assert_eq!(right.check(), Ok(()));
    let mut wrong = [right; 5];
    wrong[0].sensor = [0, 1, 1];
    wrong[1].motor = [2, 1, 2];
    wrong[2].motor = [0, 1, 3];
    wrong[3].per_unit[1] = 0.0;
    wrong[4].motor_sign[2] = 0.5;
    assert!(wrong.iter().all(|wiring| wiring.check().is_err()), "{wrong:?}");
}
