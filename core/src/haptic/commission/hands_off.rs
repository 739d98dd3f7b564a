//! The part of a commissioning in which motors drive the free handle, one after the other.

use super::response::{Response, TICKS};
use super::wiring::nth;
use super::{Commissioned, MOST_N, Plan, Trouble, Wiring, has};
use crate::haptic::between;

/// Growth of the force until the handle moves [N/s].
/// Source: chosen; the largest force comes after two seconds.
const RAMP_N_PER_S: f32 = 0.25;
/// Share of the force limit that a stroke adds to the force that moved the handle (1).
/// Source: chosen; with it `friction_mass_delay_and_lag_are_measured` passes.
const STROKE: f32 = 0.05;
/// Bounds of that addition [N].
/// Source: chosen; with them `friction_mass_delay_and_lag_are_measured` passes, and
/// `every_shipped_device_is_measured`.
const STROKE_N: [f32; 2] = [0.1, 0.2];
/// Travel after which a stroke's force is reversed [m].
/// Source: chosen; with it `friction_mass_delay_and_lag_are_measured` passes.
const STROKE_M: f32 = 3e-3;
/// Travel in counts, where that is longer (1).
/// Source: chosen; with it `friction_mass_delay_and_lag_are_measured` passes at counts of 100 um.
const STROKE_COUNTS: f32 = 60.0;
/// Friction for which that travel grows by itself, because a rubbing handle stops short [N].
/// Source: chosen; with it `friction_mass_delay_and_lag_are_measured` passes at 0.3 N of friction.
const LONGER_N: f32 = 0.2;
/// Longest time until then [ticks].
/// Source: derived; 45 g under the least stroke, 0.1 N, travel [`STROKE_M`] in 52 ticks, and a
/// rubbing handle takes up to twice as long.
const PUSH_TICKS: usize = 100;
/// Travel at which a ramp ends [m], long enough that a soft hand springs back against friction.
/// Source: chosen; with it every hand is found in `a_handle_that_is_held_or_moves_ends_it`.
const RAMP_M: f32 = 2.5e-3;
/// Ticks without progress after which a reversed stroke ends.
/// Source: derived; 45 g under the least stroke, 0.1 N, go back by [`MOVED_M`] within ten ticks.
const STANDS_TICKS: usize = 12;
/// Strokes of each motor, alternately in both directions.
/// Source: chosen; with it `friction_mass_delay_and_lag_are_measured` passes.
const STROKES: u8 = 8;
/// Ticks after which a handle that has moved by no more than half of [`MOVED_M`], or a count,
/// rests.
/// Source: derived; two periods of a tremor of 9 Hz. The slowest motion that is found is 0.25 mm/s,
/// a quarter of that which `a_handle_that_is_held_or_moves_ends_it` asks for.
const REST_TICKS: u16 = 200;
/// Ticks within which the handle has to come to rest.
/// Source: chosen; four times the two seconds that a ramp to the largest force takes.
const PATIENCE_TICKS: u16 = 8_000;
/// Travel that counts as motion, unless two counts are longer [m].
/// Source: derived; ten counts of the finest encoder with a profile, 10 um. A handle of 45 g
/// travels it while the ramp grows by 12 mN.
const MOVED_M: f32 = 100e-6;
/// Largest distance from the place where the handle was let go [m].
/// Source: chosen; half of the shorter sides of the workspace of the Touch.
const FAR_M: f32 = 60e-3;
/// A push of which less than this share is left at rest was held (1).
/// Source: chosen; with it every hand is found in `a_handle_that_is_held_or_moves_ends_it`.
const KEPT: f32 = 0.5;
/// Share that a second axis may have in a push (1).
/// Source: derived; a slant of 31 degrees (`a_motor_may_slant_by_thirty_degrees_and_not_by_more`).
const ASIDE: f32 = 0.6;
/// Largest difference between the forces that move the handle in the two directions: absolute [N],
/// and relative to their mean (1).
/// Source: derived; the first is twice the weight of 4 g, the second a friction that is half as
/// large again in one direction (`two_directions_of_a_free_handle_need_about_the_same_force`).
const UNEVEN: (f32, f32) = (0.08, 0.5);

/// Present state of a motor.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Step {
    /// Waits for rest.
    Rest,
    /// Raises the force.
    Ramp,
    /// Drives a stroke.
    Stroke,
    /// Fits the answer to a stroke, one pair of delay and lag per tick.
    Fit,
}

/// Finding for one motor.
#[derive(Clone, Copy, Debug, Default)]
struct Found {
    axis: Option<u8>,
    /// Sign of the motion along the axis under a positive force.
    sign: f32,
    /// Force at which the handle was seen to move, and its travel then, in both directions.
    moved_n: [f32; 2],
    moved_m: [f32; 2],
    /// Travel when the ramp ended [m].
    pushed_m: [f32; 2],
    /// Sum over the strokes of one over the mass [m/N per square tick], and number of them.
    per_kg: f32,
    strokes: u8,
}

/// Motors one after the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct HandsOff {
    plan: Plan,
    home_m: [f32; 3],
    moving_m: [f32; 3],
    motor: u8,
    step: Step,
    ticks: u16,
    /// Number of the push: two ramps, then the strokes.
    push: u8,
    /// Position since which the handle may be at rest, and ticks since then.
    still_m: [f32; 3],
    still: u16,
    /// Position at the beginning of a push.
    from_m: [f32; 3],
    found: [Found; 3],
    response: Response,
    scratch: [f32; TICKS],
    ended: bool,
}

impl HandsOff {
    #[inline]
    pub fn new(plan: &Plan) -> Self {
        Self {
            plan: *plan,
            home_m: [0.0; 3],
            moving_m: [MOVED_M; 3],
            motor: 0,
            step: Step::Rest,
            ticks: 0,
            push: 0,
            still_m: [0.0; 3],
            still: 0,
            from_m: [0.0; 3],
            found: [Found {
                axis: None,
                sign: 1.0,
                moved_n: [0.0; 2],
                moved_m: [0.0; 2],
                pushed_m: [0.0; 2],
                per_kg: 0.0,
                strokes: 0,
            }; 3],
            response: Response::NEW,
            scratch: [0.0; TICKS],
            ended: false,
        }
    }

    /// Begins with the handle free, at this position.
    #[inline]
    pub fn begin(&mut self, at_m: [f32; 3], count_m: [f32; 3]) {
        (self.home_m, self.still_m, self.still, self.ticks) = (at_m, at_m, 0, 0);
        self.moving_m = count_m.map(|count_m| if 2.01 * count_m > MOVED_M { 2.01 * count_m } else { MOVED_M });
    }

    /// Runs one tick; returns the motor and its force [N].
    #[inline]
    pub fn tick(&mut self, at_m: [f32; 3]) -> Result<(u8, f32), Trouble> {
        if self.axes().any(|axis| (nth(at_m, axis) - nth(self.home_m, axis)).abs() > FAR_M) {
            let undriven = self.step == Step::Rest && self.push == 0;
            return Err(if undriven { Trouble::Moving } else { Trouble::TooFar });
        }
        self.ticks = self.ticks.saturating_add(1);
        self.still = self.still.saturating_add(1);
        // half of what counts as motion is at least a count
        let moves = |axis: u8| (nth(at_m, axis) - nth(self.still_m, axis)).abs() > 0.51 * nth(self.moving_m, axis);
        if (0..3).any(|axis| has(&self.plan, axis) && moves(axis)) {
            (self.still_m, self.still) = (at_m, 0);
        }
        match self.step {
            Step::Rest => self.rest(at_m),
            Step::Ramp => self.ramp(at_m),
            Step::Stroke => self.stroke(at_m),
            Step::Fit => {
                if !self.response.fit(self.stroke_n(), &mut self.scratch) {
                    self.fitted();
                }
                Ok((self.motor, 0.0))
            }
        }
    }

    #[inline]
    fn axes(&self) -> impl Iterator<Item = u8> + use<> {
        let plan = self.plan;
        (0..3).filter(move |axis| has(&plan, *axis))
    }

    /// Direction of the present push (1).
    #[inline]
    fn direction(&self) -> f32 {
        if self.push.is_multiple_of(2) { 1.0 } else { -1.0 }
    }

    #[inline]
    fn found(&mut self) -> Option<&mut Found> {
        self.found.get_mut(usize::from(self.motor))
    }

    #[inline]
    fn rest(&mut self, at_m: [f32; 3]) -> Result<(u8, f32), Trouble> {
        let none = (self.motor, 0.0);
        if self.still < REST_TICKS {
            return if self.ticks > PATIENCE_TICKS { Err(Trouble::Moving) } else { Ok(none) };
        }
        if (1..=2).contains(&self.push) {
            self.kept(at_m)?;
        }
        (self.from_m, self.ticks) = (at_m, 0);
        if self.push < 2 {
            self.step = Step::Ramp;
        } else if self.push < 2 + STROKES {
            self.even()?;
            self.response.begin();
            self.step = Step::Stroke;
            return Ok((self.motor, self.direction() * self.stroke_n()));
        } else {
            self.next_motor();
        }
        Ok(none)
    }

    /// A free handle stays where a push has moved it; one that is held springs back.
    #[inline]
    fn kept(&mut self, at_m: [f32; 3]) -> Result<(), Trouble> {
        let (motor, pushed, from_m) = (self.motor, usize::from(self.push - 1), self.from_m);
        let Some(found) = self.found() else { return Ok(()) };
        let Some(axis) = found.axis else { return Ok(()) };
        let sign = if pushed == 0 { found.sign } else { -found.sign };
        let left_m = (nth(at_m, axis) - nth(from_m, axis)) * sign;
        let moved_m = found.pushed_m.get(pushed).copied().unwrap_or(0.0);
        if left_m < KEPT * moved_m { Err(Trouble::Held(motor)) } else { Ok(()) }
    }

    /// The two directions of a free handle need about the same force.
    #[inline]
    fn even(&mut self) -> Result<(), Trouble> {
        let motor = self.motor;
        let Some(found) = self.found() else { return Ok(()) };
        let [one, other] = found.moved_n;
        if (one - other).abs() > UNEVEN.0 + UNEVEN.1 * 0.5 * (one + other) { Err(Trouble::Unsteady(motor)) } else { Ok(()) }
    }

    #[inline]
    fn ramp(&mut self, at_m: [f32; 3]) -> Result<(u8, f32), Trouble> {
        let force_n = RAMP_N_PER_S * self.plan.tick_s * f32::from(self.ticks);
        let (mut first, mut second) = ((0_u8, 0.0_f32), 0.0_f32);
        for axis in self.axes() {
            // in units of what counts as motion along the axis
            let moved = (nth(at_m, axis) - nth(self.from_m, axis)) / nth(self.moving_m, axis);
            if moved.abs() > first.1.abs() {
                second = first.1.abs();
                first = (axis, moved);
            } else if moved.abs() > second {
                second = moved.abs();
            }
        }
        let (axis, moved) = first;
        let (motor, push, sign) = (self.motor, usize::from(self.push), moved.signum() * self.direction());
        let moved_m = moved.abs() * nth(self.moving_m, axis);
        if let Some(found) = self.found()
            && let (Some(n), Some(m)) = (found.moved_n.get_mut(push), found.moved_m.get_mut(push))
            && moved.abs() >= 1.0
            && *n == 0.0
        {
            (*n, *m) = (force_n, moved_m);
        }
        if moved_m < RAMP_M || moved.abs() < 2.0 {
            if force_n <= self.most_n() {
                return Ok((motor, self.direction() * force_n));
            }
            // a device of fewer axes has fewer motors
            if self.axes().count() < 3 && self.push == 0 && moved.abs() < 1.0 {
                self.next_motor();
                return Ok((self.motor, 0.0));
            }
            return Err(if moved.abs() < 1.0 { Trouble::Stuck(motor) } else { Trouble::Held(motor) });
        }
        if second > ASIDE * moved.abs() {
            return Err(Trouble::TwoAxes(motor));
        }
        let another = self.found.iter().zip(0..3).any(|(found, n)| n != motor && found.axis == Some(axis));
        if another {
            return Err(Trouble::SameMotor(motor));
        }
        if let Some(found) = self.found() {
            if found.axis.is_some_and(|before| before != axis || found.sign != sign) {
                return Err(Trouble::Unsteady(motor));
            }
            (found.axis, found.sign) = (Some(axis), sign);
            if let Some(pushed) = found.pushed_m.get_mut(push) {
                *pushed = moved_m;
            }
        }
        self.pushed();
        Ok((motor, 0.0))
    }

    /// Larger of the forces at which the handle began to move [N].
    #[inline]
    fn moved_n(&self) -> f32 {
        let [one, other] = self.found.get(usize::from(self.motor)).map_or([0.0; 2], |found| found.moved_n);
        if one > other { one } else { other }
    }

    /// Force of a stroke [N].
    #[inline]
    fn stroke_n(&self) -> f32 {
        let margin_n = between(STROKE * self.plan.force_limit_n, STROKE_N[0], STROKE_N[1]);
        between(self.moved_n() + margin_n, 0.0, self.most_n())
    }

    /// Largest force of a push [N]: that of a device that was not commissioned, or the device's own
    /// limit.
    #[inline]
    fn most_n(&self) -> f32 {
        between(self.plan.force_limit_n, 0.0, MOST_N)
    }

    #[inline]
    fn stroke(&mut self, at_m: [f32; 3]) -> Result<(u8, f32), Trouble> {
        let (axis, sign) = self.found().map_or((0, 1.0), |found| (found.axis.unwrap_or(0), found.sign));
        let along = sign * self.direction();
        let travel_m = (nth(at_m, axis) - nth(self.from_m, axis)) * along;
        let room = self.response.record(travel_m);
        let moving_m = nth(self.moving_m, axis);
        let ((ticks, reversed), (summit_m, since)) = (self.response.state(), self.response.summit());
        let turned = reversed && (summit_m - travel_m >= moving_m || since > STANDS_TICKS);
        if !room || turned {
            self.response.prepare(moving_m);
            self.step = Step::Fit;
            return Ok((self.motor, 0.0));
        }
        let longest_m = 0.5 * STROKE_COUNTS * moving_m;
        let stroke_m = if longest_m > STROKE_M { longest_m } else { STROKE_M } * (1.0 + self.moved_n() / LONGER_N);
        if !reversed && (travel_m >= stroke_m || ticks >= PUSH_TICKS) {
            self.response.reverse();
        }
        let force_n = if self.response.state().1 { -self.stroke_n() } else { self.stroke_n() };
        Ok((self.motor, self.direction() * force_n))
    }

    #[inline]
    fn fitted(&mut self) {
        let per_kg = self.response.per_kg();
        if let Some(found) = self.found()
            && per_kg > 0.0
        {
            found.per_kg += per_kg;
            found.strokes += 1;
        }
        self.pushed();
    }

    /// Waits for rest before the next push.
    #[inline]
    fn pushed(&mut self) {
        self.push += 1;
        (self.step, self.ticks, self.still) = (Step::Rest, 0, 0);
    }

    #[inline]
    fn next_motor(&mut self) {
        (self.push, self.step, self.ticks, self.still) = (0, Step::Rest, 0, 0);
        self.ended = self.motor >= 2;
        self.motor += u8::from(!self.ended);
    }

    /// The result, once the last motor was measured.
    #[inline]
    pub fn result(&self, wiring: &Wiring) -> Option<Result<Commissioned, Trouble>> {
        self.ended.then(|| self.of(wiring))
    }

    #[inline]
    fn of(&self, wiring: &Wiring) -> Result<Commissioned, Trouble> {
        let (delay_ticks, lag_ticks) = self.response.found().ok_or(Trouble::Unclear)?;
        let tick_s = self.plan.tick_s;
        let mut result = Commissioned {
            wiring: *wiring,
            friction_n: [0.0; 3],
            mass_kg: [0.0; 3],
            count_m: [0.0; 3],
            delay_ticks,
            lag_s: lag_ticks * tick_s,
        };
        let mut spare = (0..3_u8).filter(|motor| self.found.get(usize::from(*motor)).is_some_and(|found| found.axis.is_none()));
        for axis in 0..3_u8 {
            let at = usize::from(axis);
            let driven = self.found.iter().zip(0..3_u8).find(|(found, _)| found.axis == Some(axis));
            let (motor, sign) = match driven {
                Some((found, motor)) => {
                    if found.strokes == 0 {
                        return Err(Trouble::Unclear);
                    }
                    let mass_kg = f32::from(found.strokes) / found.per_kg * tick_s * tick_s;
                    let late_s = f32::from(delay_ticks) * tick_s + result.lag_s;
                    if let (Some(kg), Some(n)) = (result.mass_kg.get_mut(at), result.friction_n.get_mut(at)) {
                        (*kg, *n) = (mass_kg, friction_n(found, mass_kg, late_s));
                    }
                    (motor, found.sign)
                }
                None if has(&self.plan, axis) => return Err(Trouble::Stuck(axis)),
                None => (spare.next().unwrap_or(axis), 1.0),
            };
            if let (Some(place), Some(places)) = (result.wiring.motor.get_mut(at), result.wiring.motor_sign.get_mut(at)) {
                (*place, *places) = (motor, sign);
            }
        }
        Ok(result)
    }
}

/// Friction: the force at which the motion was seen, less its growth since the motion began. Under
/// a force that grows by `r` a mass has travelled `r t^3 / 6 m` after the time `t`.
#[inline]
fn friction_n(found: &Found, mass_kg: f32, late_s: f32) -> f32 {
    let ([n, m], [other_n, other_m]) =
        ([found.moved_n, found.moved_m].map(|both| both[0]), [found.moved_n, found.moved_m].map(|both| both[1]));
    let each = [(n, m), (other_n, other_m)].map(|(moved_n, moved_m)| {
        let began_s = cube_root(6.0 * mass_kg * moved_m / RAMP_N_PER_S);
        moved_n - RAMP_N_PER_S * (began_s + late_s)
    });
    let mean_n = 0.5 * (each[0] + each[1]);
    if mean_n > 0.0 { mean_n } else { 0.0 }
}

/// Cube root of a number between 0 and 1, by Newton's method from above.
#[inline]
fn cube_root(cube: f32) -> f32 {
    let mut root = 1.0_f32;
    for _ in 0..24_u8 {
        root -= (root - cube / (root * root)) / 3.0;
    }
    root
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Runs the first motor of a handle of 45 g; motions along x come with a share of them along y,
    /// and the friction [N] depends on the direction.
    fn first_motor(aside: f32, friction_n: [f32; 2]) -> Result<(), Trouble> {
        let plan = Plan { axes: [true; 3], distance_m: 0.05, force_limit_n: 3.0, stated_m_per_unit: [1.0; 3], tick_s: 1e-3 };
        let mut hands_off = HandsOff::new(&plan);
        hands_off.begin([0.0; 3], [0.0; 3]);
        let (mut at_m, mut m_per_s) = (0.0_f32, 0.0_f32);
        for _ in 0..60_000 {
            let (motor, force_n) = hands_off.tick([at_m, aside * at_m, 0.0])?;
            if motor != 0 {
                break;
            }
            let forwards = if m_per_s == 0.0 { force_n > 0.0 } else { m_per_s > 0.0 };
            let most_n = friction_n[usize::from(!forwards)];
            let rub_n = if m_per_s == 0.0 { between(force_n, -most_n, most_n) } else { most_n * m_per_s.signum() };
            let next = m_per_s + (force_n - rub_n) * 1e-3 / 0.045;
            // friction stops a handle, and does not turn it round
            m_per_s = if m_per_s * next < 0.0 && force_n.abs() <= most_n { 0.0 } else { next };
            at_m += m_per_s * 1e-3;
        }
        Ok(())
    }

    #[test]
    fn a_motor_may_slant_by_thirty_degrees_and_not_by_more() {
        assert_eq!(first_motor(0.55, [0.1; 2]), Ok(()));
        assert_eq!(first_motor(0.65, [0.1; 2]), Err(Trouble::TwoAxes(0)));
    }

    #[test]
    fn two_directions_of_a_free_handle_need_about_the_same_force() {
        for friction_n in [[0.03, 0.09], [0.2, 0.4]] {
            assert_eq!(first_motor(0.0, friction_n), Ok(()), "{friction_n:?}");
        }
        for friction_n in [[0.03, 0.17], [0.15, 0.42]] {
            assert_eq!(first_motor(0.0, friction_n), Err(Trouble::Unsteady(0)), "{friction_n:?}");
        }
    }
}
