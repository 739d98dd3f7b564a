//! One path, derived from a number.

use std::f64::consts::TAU;

use rand_xoshiro::SplitMix64;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use super::ground::{PathGround, PathPatch};
use super::route::{Leg, Route};

/// Duration of the motion and of the rest at its end [ticks]: together at least two seconds.
const MOVING_TICKS: usize = 1400;
const REST_TICKS: usize = 620;
/// Slowest and fastest speed of the tip [m/s].
const SLOWEST_M_PER_S: f64 = 0.01;
const FASTEST_M_PER_S: f64 = 3.0;
/// Smallest and largest Young's modulus [Pa].
const SOFTEST_PA: f64 = 1e3;
const STIFFEST_PA: f64 = 100e3;

/// Kind of a path.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum PathKind {
    /// Enters through the surface, and leaves anywhere below it.
    Through,
    /// Slides along the surface while pressed in.
    Along,
    /// Passes around the tissue; the tip never touches it.
    Around,
    /// Passes below the tissue, then rises through it.
    Under,
    /// Slides along the surface and off the edge of the patch.
    OffEdge,
    /// Enters through the surface, and leaves through the side.
    OutOfSide,
    /// Enters through the side.
    IntoSide,
    /// Follows the edge of the patch.
    Rim,
    /// Taps the tissue in one place.
    Taps,
    /// Moves from point to point, anywhere.
    Wild,
}

/// Every kind of path, with its name.
pub const KINDS: [(PathKind, &str); 10] = [
    (PathKind::Through, "through"),
    (PathKind::Along, "along"),
    (PathKind::Around, "around"),
    (PathKind::Under, "under"),
    (PathKind::OffEdge, "off the edge"),
    (PathKind::OutOfSide, "out of the side"),
    (PathKind::IntoSide, "into the side"),
    (PathKind::Rim, "along the edge"),
    (PathKind::Taps, "taps"),
    (PathKind::Wild, "anywhere"),
];

/// Description of one run.
#[derive(Clone, Debug)]
pub struct PathCase {
    /// Number of the run.
    pub number: u64,
    /// Seed of the draw.
    pub seed: u64,
    /// Index into [`KINDS`].
    pub kind: usize,
    /// Index into the ground's patches.
    pub patch: usize,
    /// Index into the ground's devices.
    pub device: usize,
    /// Young's modulus [Pa].
    pub youngs_modulus_pa: f64,
    /// Whether the depth limit is that of the guard for this device, instead of the patch's own.
    pub guarded: bool,
    /// Path of the tip over time.
    pub route: Route,
}

impl PathCase {
    /// Draws the run with this number.
    pub fn draw(ground: &PathGround, number: u64, seed: u64) -> Self {
        let mut draw = Draw(SplitMix64::seed_from_u64(seed ^ number.wrapping_mul(0x9e37_79b9_7f4a_7c15)));
        let kind = (number % KINDS.len() as u64) as usize;
        let mut left = draw.below(ground.patches.iter().map(|p| p.share as usize).sum());
        let share = |p: &PathPatch| p.share as usize;
        let patch = ground.patches.iter().position(|p| {
            let here = left < share(p);
            left = left.saturating_sub(share(p));
            here
        });
        let patch = patch.unwrap_or_default();
        let device = draw.below(ground.devices.len());
        let youngs_modulus_pa = draw.by_factor(SOFTEST_PA, STIFFEST_PA);
        let guarded = draw.chance(0.5);
        let route = draw.route(&ground.patches[patch], KINDS[kind].0);
        Self { number, seed, kind, patch, device, youngs_modulus_pa, guarded, route }
    }
}

/// Random source of numbers and paths.
struct Draw(SplitMix64);

/// Coordinates of a point along the site's axes, the last of which points out of the tissue [m].
type At = [f64; 3];

impl Draw {
    fn share(&mut self) -> f64 {
        (self.0.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn below(&mut self, count: usize) -> usize {
        (self.share() * count as f64) as usize
    }

    fn chance(&mut self, share: f64) -> bool {
        self.share() < share
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    /// Draws a number between `low` and `high` whose logarithm is uniformly distributed.
    fn by_factor(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.share())
    }

    /// Draws a place in the footprint of the patch, which is scaled by `reach` about its centre.
    fn place(&mut self, patch: &PathPatch, reach: f64) -> [f64; 2] {
        let [low, high] = patch.extent_m;
        std::array::from_fn(|k| {
            let (middle, half) = (0.5 * (low[k] + high[k]), 0.5 * (high[k] - low[k]));
            middle + half * self.between(-reach, reach)
        })
    }

    /// Draws a place on the outline of the footprint, which is moved outwards by `out_m`.
    fn edge(&mut self, patch: &PathPatch, out_m: f64) -> [f64; 2] {
        let [low, high] = patch.extent_m;
        let (sin, cos) = self.between(0.0, TAU).sin_cos();
        let middle: [f64; 2] = std::array::from_fn(|k| 0.5 * (low[k] + high[k]));
        let half: [f64; 2] = std::array::from_fn(|k| 0.5 * (high[k] - low[k]) + out_m);
        // the outline is taken as round in half of the cases, and as a rectangle in the others
        let reach = if self.chance(0.5) { 1.0 } else { 1.0 / (cos.abs().max(sin.abs())) };
        [middle[0] + half[0] * cos * reach, middle[1] + half[1] * sin * reach]
    }

    fn route(&mut self, patch: &PathPatch, kind: PathKind) -> Route {
        let floor_m = patch.extent_m[0][2];
        let top_m = patch.extent_m[1][2].max(0.0);
        let depth_m = |draw: &mut Self| draw.by_factor(0.2e-3, (-floor_m).min(12e-3));
        let mut at: Vec<At> = Vec::new();
        let join = |[x, y]: [f64; 2], z: f64| [x, y, z];
        match kind {
            PathKind::Through => {
                let [x, y] = self.place(patch, 0.9);
                at.push([x, y, top_m + self.by_factor(1e-3, 20e-3)]);
                let end = if self.chance(0.5) {
                    self.place(patch, 1.0)
                } else {
                    let out_m = self.between(5e-3, 40e-3);
                    self.edge(patch, out_m)
                };
                at.push(join(end, floor_m - self.between(2e-3, 30e-3)));
                if self.chance(0.3) {
                    at.push([x, y, top_m + self.between(2e-3, 20e-3)]);
                }
            }
            PathKind::Along => {
                for _ in 0..1 + self.below(4) {
                    let (from, to, deep_m) = (self.place(patch, 0.95), self.place(patch, 0.95), depth_m(self));
                    at.extend([join(from, top_m + 2e-3), join(from, -deep_m), join(to, -deep_m)]);
                    if self.chance(0.7) {
                        at.push(join(to, top_m + 3e-3));
                    }
                }
            }
            PathKind::Around => {
                for _ in 0..3 + self.below(5) {
                    let out_m = self.by_factor(1.5e-3, 30e-3);
                    let side = self.edge(patch, out_m);
                    let above = self.place(patch, 1.3);
                    at.push(match self.below(3) {
                        0 => join(above, top_m + self.by_factor(1.5e-3, 20e-3)),
                        1 => join(side, self.between(floor_m, top_m)),
                        _ => join(side, if self.chance(0.5) { floor_m - out_m } else { top_m + out_m }),
                    });
                }
            }
            PathKind::Under => {
                let (from, to) = (self.place(patch, 1.3), self.place(patch, 1.0));
                let out_m = self.by_factor(1e-3, 20e-3);
                let outer = self.edge(patch, out_m + 5e-3);
                at.extend([join(outer, top_m + 5e-3), join(outer, floor_m - out_m)]);
                at.extend([join(from, floor_m - out_m), join(to, floor_m - out_m)]);
                at.push(join(to, if self.chance(0.5) { top_m + 10e-3 } else { self.between(floor_m, 0.0) }));
            }
            PathKind::OffEdge => {
                let (from, deep_m) = (self.place(patch, 0.9), depth_m(self));
                let out_m = self.by_factor(1e-3, 30e-3);
                let to = self.edge(patch, out_m);
                at.extend([join(from, top_m + 2e-3), join(from, -deep_m), join(to, -deep_m)]);
                if self.chance(0.4) {
                    at.extend([join(from, -deep_m), join(from, top_m + 5e-3)]);
                }
            }
            PathKind::OutOfSide => {
                let (start, entry, out_m) = (self.place(patch, 1.1), self.place(patch, 0.9), self.by_factor(1e-3, 40e-3));
                let deep_m = if self.chance(0.5) { depth_m(self) } else { self.between(0.3e-3, -floor_m) };
                let end = self.edge(patch, out_m);
                at.extend([join(start, top_m + self.by_factor(1e-3, 20e-3)), join(entry, -deep_m)]);
                at.push(join(end, self.between(floor_m - 5e-3, 0.0)));
                if self.chance(0.3) {
                    at.push(join(entry, -deep_m));
                }
            }
            PathKind::IntoSide => {
                let out_m = self.by_factor(1e-3, 20e-3);
                let (outer, inner) = (self.edge(patch, out_m), self.place(patch, 0.8));
                let deep_m = self.between(0.3e-3, -floor_m);
                at.extend([join(outer, top_m + 3e-3), join(outer, -deep_m), join(inner, -deep_m)]);
                if self.chance(0.6) {
                    at.push(join(inner, top_m + 5e-3));
                    at.extend([join(inner, -depth_m(self)), join(inner, top_m + 5e-3)]);
                }
            }
            PathKind::Rim => {
                let out_m = self.between(-8e-3, 8e-3);
                let deep_m = depth_m(self);
                let first = self.edge(patch, out_m);
                at.push(join(first, top_m + 3e-3));
                at.push(join(first, -deep_m));
                for _ in 0..1 + self.below(4) {
                    let next = self.edge(patch, out_m);
                    at.push(join(next, -deep_m));
                }
            }
            PathKind::Taps => {
                let place = self.place(patch, 1.05);
                at.push(join(place, top_m + 2e-3));
                for _ in 0..1 + self.below(6) {
                    let aside = self.place(patch, 1.0);
                    let near: [f64; 2] = std::array::from_fn(|k| place[k] + 0.1 * (aside[k] - place[k]));
                    let out_m = self.by_factor(0.5e-3, 10e-3);
                    at.extend([join(near, -depth_m(self)), join(near, top_m + out_m)]);
                }
            }
            PathKind::Wild => {
                for _ in 0..3 + self.below(6) {
                    let place = self.place(patch, 1.4);
                    at.push(join(place, self.between(floor_m - 20e-3, top_m + 25e-3)));
                }
            }
        }
        self.timed(patch, &at, top_m)
    }

    /// Draws speeds, stops and smoothing for these points; the first point, raised clear of the
    /// tissue, is the start.
    fn timed(&mut self, patch: &PathPatch, at: &[At], top_m: f64) -> Route {
        let [x, y, z] = at.first().copied().unwrap_or([0.0, 0.0, top_m]);
        let start = [x, y, z.max(top_m + 1.5e-3)];
        let one_speed = self.chance(0.5).then(|| self.by_factor(SLOWEST_M_PER_S, FASTEST_M_PER_S));
        let mut legs = Vec::new();
        for to in at {
            let m_per_s = one_speed.unwrap_or_else(|| self.by_factor(SLOWEST_M_PER_S, FASTEST_M_PER_S));
            let stop_ticks = if self.chance(0.25) { self.by_factor(1.0, 300.0) as u32 } else { 0 };
            legs.push(Leg { to_m: patch.point_m(to), m_per_s, stop_ticks });
        }
        let moving = if self.chance(0.5) { MOVING_TICKS } else { self.between(200.0, MOVING_TICKS as f64) as usize };
        let smooth = if self.chance(0.5) { 0 } else { self.by_factor(4.0, 120.0) as usize };
        Route::along(patch.point_m(&start), &legs, moving, MOVING_TICKS + REST_TICKS - moving, smooth)
    }
}
