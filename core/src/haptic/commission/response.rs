//! Delay, lag and mass of an axis from its answer to a force that is reversed while it moves.
//!
//! A force `F` sets the handle in motion, and `-F` brings it to rest. Meanwhile the friction keeps
//! its direction, so the position is a sum of five known shapes: one, time, its square (friction),
//! the integral of the position (viscous friction), and the double integral of the force of the
//! motor. Only the last one depends on delay and lag: the pair whose shape fits best is taken, and
//! its factor is one over the mass. Quantisation disturbs all pairs alike, and averages out over
//! the counts of a stroke and over the strokes.

use crate::lanes::sqrt;

/// Largest number of ticks of a stroke.
/// Source: derived; the longest push, 100 ticks, and 60 after it, five times [`LEAST`].
pub(super) const TICKS: usize = 160;
/// Number of powers of time among the shapes: one, time and its square.
/// Source: definition; the first three shapes of the header.
const POWERS: usize = 3;
/// Number of delays that are tried, from none on [ticks].
/// Source: derived; from none to `DeviceSpec::MOST_DELAY_TICKS`.
const DELAYS: usize = 8;
/// Number of lags that are tried, from none on.
/// Source: chosen; from none to 6 ticks.
const LAGS: usize = 13;
/// Step of the lags [ticks].
/// Source: chosen; half a tick, as close as `friction_mass_delay_and_lag_are_measured` asks for.
const LAG_STEP: f32 = 0.5;
/// Excess of a misfit over the least one that tells nothing, as a share of it (1).
/// Source: measured (`no_device_is_later_than_its_profile_says`); of 2400 handles with counts up to
/// 100 um, one is later than found by 0.16 ms at most. Without it some are by 1 ms.
const AS_WELL: f32 = 0.02;
const PAIRS: usize = DELAYS * LAGS;
/// Fewest readings to which shapes are fitted.
/// Source: derived; more than twice the five shapes of the header.
const LEAST: usize = 12;

/// Recording of a stroke, and the misfit of every pair over all strokes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Response {
    /// Travel after each tick [m], positive along the first force; while a stroke is fitted, the
    /// part of it that the shapes do not explain.
    travel_m: [f32; TICKS],
    ticks: usize,
    /// Tick in which the force was reversed.
    reversed: usize,
    shapes: Shapes,
    pair: usize,
    /// Smallest misfit of this stroke, and its one over mass.
    best: (f32, f32),
    misfit: [f32; PAIRS],
}

impl Response {
    pub const NEW: Self = Self {
        travel_m: [0.0; TICKS],
        ticks: 0,
        reversed: TICKS,
        shapes: Shapes { from: 0, to: 0, mean_square: 0.0, per_norm: [0.0; POWERS], gone: [0.0; TICKS] },
        pair: PAIRS,
        best: (f32::MAX, 0.0),
        misfit: [0.0; PAIRS],
    };

    /// Begins a stroke.
    #[inline]
    pub fn begin(&mut self) {
        (self.ticks, self.reversed) = (0, TICKS);
    }

    /// Records a reading; returns false if there is no room for more.
    #[inline]
    pub fn record(&mut self, travel_m: f32) -> bool {
        match self.travel_m.get_mut(self.ticks) {
            Some(place) => {
                *place = travel_m;
                self.ticks += 1;
                true
            }
            None => false,
        }
    }

    /// The next tick's force is the first that is reversed.
    #[inline]
    pub fn reverse(&mut self) {
        self.reversed = self.ticks;
    }

    /// Ticks so far, and whether the force is reversed.
    #[inline]
    pub fn state(&self) -> (usize, bool) {
        (self.ticks, self.reversed < TICKS)
    }

    /// Largest travel so far [m], and ticks since it was reached first.
    #[inline]
    pub fn summit(&self) -> (f32, usize) {
        let seen = self.travel_m.iter().take(self.ticks);
        let (at, most_m) = seen.enumerate().fold((0, 0.0), |top: (usize, f32), (n, x)| if *x > top.1 { (n, *x) } else { top });
        (most_m, self.ticks.saturating_sub(at))
    }

    /// Prepares the fit of a stroke. `moving_m` is the travel that counts as motion.
    #[inline]
    pub fn prepare(&mut self, moving_m: f32) {
        let (most_m, since) = self.summit();
        let to = self.ticks.saturating_sub(since);
        let from = self.travel_m.iter().take(to).position(|x| *x >= moving_m).unwrap_or(to);
        (self.shapes.from, self.shapes.to, self.pair) = (from, to, PAIRS);
        if to < from + LEAST || self.reversed >= to || most_m <= moving_m {
            return;
        }
        self.shapes.prepare(&self.travel_m);
        self.shapes.remove_from(&mut self.travel_m);
        (self.pair, self.best) = (0, (f32::MAX, 0.0));
    }

    /// Fits one pair of delay and lag; returns false when all are done.
    #[inline]
    pub fn fit(&mut self, force_n: f32, scratch: &mut [f32; TICKS]) -> bool {
        let Some(misfit) = self.misfit.get_mut(self.pair) else { return false };
        let (delay, lag) = pair(self.pair);
        let keeps = if lag > 0.0 { falls_to(1.0 / lag) } else { 0.0 };
        // position, velocity and force of a unit mass, in ticks
        let (mut x, mut v, mut acts) = (0.0_f32, 0.0_f32, 0.0_f32);
        for n in 0..self.shapes.to {
            // the force of tick n acts until the reading after it, which is recorded as number n
            let asked = match n.checked_sub(delay) {
                Some(sent) => {
                    if sent < self.reversed {
                        force_n
                    } else {
                        -force_n
                    }
                }
                None => 0.0,
            };
            let missing = acts - asked;
            let left = lag * (1.0 - keeps);
            x += v + 0.5 * asked + missing * lag * (1.0 - left);
            v += asked + missing * left;
            acts = asked + missing * keeps;
            put(scratch, n, x);
        }
        self.shapes.remove_from(scratch);
        let (from, to) = (self.shapes.from, self.shapes.to);
        let square = dot(scratch, scratch, from, to);
        let common = dot(scratch, &self.travel_m, from, to);
        let all = dot(&self.travel_m, &self.travel_m, from, to);
        let (explained, per_kg) =
            if square > 0.0 && common > 0.0 { (common * common / square, common / square) } else { (0.0, 0.0) };
        *misfit += all - explained;
        if all - explained < self.best.0 {
            self.best = (all - explained, per_kg);
        }
        self.pair += 1;
        true
    }

    /// One over the mass by the last stroke's best pair, in displacement per force and square tick
    /// [m/N]; zero if the stroke was too short.
    #[inline]
    pub fn per_kg(&self) -> f32 {
        if self.shapes.to < self.shapes.from + LEAST { 0.0 } else { self.best.1 }
    }

    /// Longest delay [ticks] and lag [ticks] that fit all strokes as well as any, and a step of the
    /// lag on top: a device that is later than its profile says may give the hand energy that no
    /// account sees. `None` if there was no stroke.
    #[inline]
    pub fn found(&self) -> Option<(u8, f32)> {
        let least = self.misfit.iter().copied().fold(f32::MAX, f32::min);
        let fits = |misfit: f32| misfit - least <= AS_WELL * least.abs();
        let late = |number: usize| pair(number).0 as f32 + pair(number).1;
        let fitting = self.misfit.iter().enumerate().filter(|(_, misfit)| fits(**misfit));
        let longest = fitting.max_by(|a, b| late(a.0).total_cmp(&late(b.0)).then(b.1.total_cmp(a.1)))?;
        let (delay, lag) = pair(longest.0);
        self.misfit.iter().any(|misfit| *misfit > 0.0).then_some((delay as u8, lag + LAG_STEP))
    }
}

/// The shapes that do not depend on delay and lag, over the readings in motion: orthonormal powers
/// of time, which are computed where they are needed, and the integral of the position.
#[derive(Clone, Copy, Debug)]
struct Shapes {
    from: usize,
    to: usize,
    /// Mean of the square of time, which makes the square orthogonal to one (1).
    mean_square: f32,
    per_norm: [f32; POWERS],
    gone: [f32; TICKS],
}

impl Shapes {
    #[inline]
    fn prepare(&mut self, travel_m: &[f32; TICKS]) {
        let count = (self.to - self.from) as f32;
        (self.mean_square, self.per_norm) = (0.0, [1.0; POWERS]);
        let squares =
            |shapes: &Self, power| (shapes.from..shapes.to).map(|n| shapes.power(power, n) * shapes.power(power, n)).sum();
        let second: f32 = squares(self, 1);
        self.mean_square = second / count;
        for power in 0..POWERS {
            let square: f32 = squares(self, power);
            if let Some(per_norm) = self.per_norm.get_mut(power) {
                *per_norm = 1.0 / sqrt(square);
            }
        }
        let mut gone = 0.0;
        for n in self.from..self.to {
            gone += at(travel_m, n);
            put(&mut self.gone, n, gone);
        }
        let mut row = self.gone;
        // twice, because single precision leaves a remainder
        self.remove_powers(&mut row);
        self.remove_powers(&mut row);
        let norm = sqrt(dot(&row, &row, self.from, self.to));
        let per_norm = if norm > 1e-20 { 1.0 / norm } else { 0.0 };
        self.gone = row.map(|x| x * per_norm);
    }

    /// A power of time at a reading, orthogonal to the lower ones and of length one.
    #[inline]
    fn power(&self, power: usize, n: usize) -> f32 {
        // symmetric about the middle of the readings, so that even and odd powers are orthogonal
        let count = (self.to - self.from) as f32;
        let t = (2.0 * (n - self.from) as f32 + 1.0 - count) / count;
        let value = match power {
            0 => 1.0,
            1 => t,
            _ => t * t - self.mean_square,
        };
        value * self.per_norm.get(power).copied().unwrap_or(0.0)
    }

    /// Removes the part of a row along the powers of time.
    #[inline]
    fn remove_powers(&self, row: &mut [f32; TICKS]) {
        for power in 0..POWERS {
            let part: f32 = (self.from..self.to).map(|n| at(row, n) * self.power(power, n)).sum();
            for n in self.from..self.to {
                let left = at(row, n) - part * self.power(power, n);
                put(row, n, left);
            }
        }
    }

    /// Removes the part of a row along all shapes; twice, because single precision leaves a
    /// remainder.
    #[inline]
    fn remove_from(&self, row: &mut [f32; TICKS]) {
        for _ in 0..2_u8 {
            self.remove_powers(row);
            let part = dot(row, &self.gone, self.from, self.to);
            row.iter_mut().zip(&self.gone).take(self.to).skip(self.from).for_each(|(x, shape)| *x -= part * shape);
        }
    }
}

/// `exp(-x)` for x between 0 and 2: a sixteenth of it as a series, then its sixteenth power.
#[inline]
fn falls_to(x: f32) -> f32 {
    let y = -x / 16.0;
    let mut power = 1.0 + y * (1.0 + y * (0.5 + y * (1.0 / 6.0 + y / 24.0)));
    for _ in 0..4_u8 {
        power *= power;
    }
    power
}

/// Delay and lag of a pair [ticks].
#[inline]
fn pair(number: usize) -> (usize, f32) {
    (number / LAGS, (number % LAGS) as f32 * LAG_STEP)
}

#[inline]
fn at(row: &[f32; TICKS], n: usize) -> f32 {
    row.get(n).copied().unwrap_or(0.0)
}

#[inline]
fn put(row: &mut [f32; TICKS], n: usize, value: f32) {
    if let Some(place) = row.get_mut(n) {
        *place = value;
    }
}

#[inline]
fn dot(a: &[f32; TICKS], b: &[f32; TICKS], from: usize, to: usize) -> f32 {
    a.iter().zip(b).take(to).skip(from).map(|(a, b)| a * b).sum()
}
