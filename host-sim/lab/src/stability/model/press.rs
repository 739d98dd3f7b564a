//! Moves the tip through a stimulus and records the data on which a verdict is based.

use palpate::{ClampFlags, Vector3};
use rand_xoshiro::SplitMix64;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use super::load_case::Stimulus;
use crate::chart::CLEAR_M;
use crate::methods::{Block, RunningMethod};

/// Duration of the hold, and time for the tissue to come to rest after the release [s].
const HOLD_S: f64 = 0.35;
const REST_S: f64 = 0.5;
/// Duration at the end of the hold over which the tissue must be at rest [s].
const STILL_S: f64 = 0.02;

/// One tick of the descent, before the tip slows down for the hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Loading {
    /// Commanded depth of the tip, before the guard [m].
    pub depth_m: f64,
    /// Force along the handle, out of the tissue [N].
    pub force_n: f64,
}

/// Record of a press.
#[derive(Clone, Debug, PartialEq)]
pub struct Trace {
    /// Ticks of the descent.
    pub loading: Vec<Loading>,
    /// Depth of the tip at divergence [m], after which nothing is measured; `None` without
    /// divergence.
    pub diverged_at_m: Option<f64>,
    /// Smallest ratio of a tet's volume to its rest volume in any tick (1).
    pub lowest_j: f64,
    /// Smallest ratio of a tet's volume to its rest volume at the end of the hold (1).
    pub held_j: f64,
    /// Largest force along the handle [N].
    pub peak_n: f64,
    /// Force at the end of the hold [N].
    pub held_n: f64,
    /// Largest displacement of a node in the last 20 ms of the hold [m].
    pub moved_m: f64,
    /// Change of the force in these 20 ms, divided by the largest force (1).
    pub force_change: f64,
    /// Largest distance of a node from its rest position half a second after the release [m].
    pub residual_m: f64,
    /// Inputs that the guard clamped in any tick.
    pub limiters: ClampFlags,
}

/// Presses, holds and releases, with the tick length of the block's parameters.
pub fn press(block: &Block, running: &mut dyn RunningMethod, stimulus: &Stimulus) -> Trace {
    let mut watch = Recorder::new(block);
    if let Err(depth_m) = watch.whole(block, running, stimulus) {
        watch.trace.diverged_at_m = Some(depth_m);
    }
    watch.trace
}

struct Recorder {
    tets: Vec<([u32; 4], f64)>,
    rest_m: Vec<Vector3<f64>>,
    position_m: Vec<Vector3<f64>>,
    trace: Trace,
}

impl Recorder {
    fn new(block: &Block) -> Self {
        let mesh = &block.tissue.mesh;
        let rest_m: Vec<Vector3<f64>> = mesh.nodes_m.iter().map(|x| Vector3::from(*x)).collect();
        let tets = mesh.tets.iter().map(|tet| (*tet, 1.0 / six_volume(tet, &rest_m))).collect();
        let trace = Trace {
            loading: Vec::new(),
            diverged_at_m: None,
            lowest_j: f64::INFINITY,
            held_j: f64::NAN,
            peak_n: 0.0,
            held_n: f64::NAN,
            moved_m: f64::NAN,
            force_change: f64::NAN,
            residual_m: f64::NAN,
            limiters: ClampFlags::DEFAULT,
        };
        Self { tets, position_m: rest_m.clone(), rest_m, trace }
    }

    /// Runs a whole stimulus; the error is the depth at which the method diverged [m].
    fn whole(&mut self, block: &Block, running: &mut dyn RunningMethod, stimulus: &Stimulus) -> Result<(), f64> {
        let tick_s = f64::from(block.params.tick_s);
        let ticks = |seconds: f64| (seconds / tick_s).ceil() as usize;
        let displacement_m = stimulus.depth_m + CLEAR_M;
        // uniform in -1 .. 1, from a fixed seed, so that every machine gives the same result
        let mut random = SplitMix64::seed_from_u64(7);
        let mut late = || stimulus.jitter * ((random.next_u64() >> 11) as f64 / (1_u64 << 52) as f64 - 1.0);

        let down = ticks(displacement_m / stimulus.in_m_per_s) + 1;
        for n in 0..=down {
            let time_s = (n as f64 + late()) * tick_s;
            let depth_m = (time_s.max(0.0) * stimulus.in_m_per_s - CLEAR_M).min(stimulus.depth_m);
            let force_n = self.tick(block, running, depth_m)?.0;
            // as the tip slows down, the force falls by its viscous part, which does not count as a
            // fall during the descent
            if depth_m < stimulus.depth_m && !running.limiters().contains(ClampFlags::DEPTH) {
                self.trace.loading.push(Loading { depth_m, force_n });
            }
        }
        let still = ticks(STILL_S);
        for _ in 0..ticks(HOLD_S) - still {
            self.tick(block, running, stimulus.depth_m)?;
        }
        let before_m = self.position_m.clone();
        let (mut least_n, mut most_n) = (f64::INFINITY, f64::NEG_INFINITY);
        for _ in 0..still {
            let (force_n, j) = self.tick(block, running, stimulus.depth_m)?;
            (least_n, most_n) = (least_n.min(force_n), most_n.max(force_n));
            (self.trace.held_j, self.trace.held_n) = (j, force_n);
        }
        self.trace.moved_m = self.furthest_m(&before_m);
        self.trace.force_change = (most_n - least_n) / most_n.abs().max(f64::MIN_POSITIVE);

        let up = ticks(displacement_m / stimulus.out_m_per_s) + 1;
        for n in 0..=up {
            let time_s = (n as f64 + late()) * tick_s;
            let depth_m = (stimulus.depth_m - time_s.max(0.0) * stimulus.out_m_per_s).max(-CLEAR_M);
            self.tick(block, running, depth_m)?;
        }
        for _ in 0..ticks(REST_S) {
            self.tick(block, running, -CLEAR_M)?;
        }
        self.trace.residual_m = self.furthest_m(&self.rest_m);
        Ok(())
    }

    /// Runs one tick and returns the force along the handle [N] and the smallest J; the error is
    /// the depth at which the method diverged [m].
    fn tick(&mut self, block: &Block, running: &mut dyn RunningMethod, depth_m: f64) -> Result<(f64, f64), f64> {
        let force = running.tick(block.tip_m(depth_m)).map_err(|_| depth_m)?;
        let force_n = f64::from(force.dot(&block.params.probe.axis));
        for (n, x) in (0..).zip(&mut self.position_m) {
            *x = running.position_m(n).cast();
        }
        let j =
            self.tets.iter().map(|(tet, per_rest)| six_volume(tet, &self.position_m) * per_rest).fold(f64::INFINITY, f64::min);
        // `min` would silently drop a NaN
        if !(force_n.is_finite() && self.position_m.iter().all(|x| x.iter().all(|c| c.is_finite()))) {
            return Err(depth_m);
        }
        let trace = &mut self.trace;
        trace.lowest_j = trace.lowest_j.min(j);
        trace.peak_n = trace.peak_n.max(force_n);
        trace.limiters.set(running.limiters());
        Ok((force_n, j))
    }

    fn furthest_m(&self, from_m: &[Vector3<f64>]) -> f64 {
        self.position_m.iter().zip(from_m).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max)
    }
}

fn six_volume(tet: &[u32; 4], position_m: &[Vector3<f64>]) -> f64 {
    let [a, b, c, d] = tet.map(|n| position_m[n as usize]);
    (b - a).dot(&(c - a).cross(&(d - a)))
}
