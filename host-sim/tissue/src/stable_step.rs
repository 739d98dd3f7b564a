//! Longest stable substep, measured on the *pressed* patch, not at rest.
//!
//! Tissue stiffens under the probe, so the limit is much lower there than at rest. The patch is
//! therefore pressed to its depth limit with safely small substeps, while power iteration finds the
//! highest frequency of its tangent stiffness. Symplectic Euler is stable while `dt w < 2`.
//! Relaxation is left out: the immediate response is that of the elastic stiffness. Contact is
//! implicit and does not affect the limit. A tap compresses the tissue further for a few
//! milliseconds. The number of substeps from this bound is therefore tried on a tap, and raised by
//! one until the patch comes to rest under the tip and again after its release.
//!
//! Tissue that stiffens is tried on faster taps first. At 1 m/s the probe is as fast as the shear
//! waves of soft tissue (1.07 m/s at 3.5 kPa): it squeezes the first elements before the next ones
//! move, and by the exponential law their stiffness rises up to 55 times (`stiffening::CAP`).
//! Within four ticks `dt w` then rises from 0.4 at rest past the limit of 2, before any tet is
//! inverted.

use palpate::stages::{force, integrate};
use palpate::{BuildError, GuardLimits, Model, Params, ProbePose, State, Terms, Tuned, Vector3, tick};

use crate::organ::tangents;
use crate::patch::{Memory, Patch};

/// Substeps per tick of the measuring run: each is far shorter than the limit of any usable patch.
const CAREFUL_SUBSTEPS: u16 = 16;
/// Speed of the measuring press [m/s]: slow enough that inertia does not squeeze the tissue.
const PRESS_M_PER_S: f32 = 0.1;
/// Speed of the tap [m/s]: the upper end of a hand's speed on tissue.
const TAP_M_PER_S: f32 = 0.5;
/// Number of ticks between samples of the press.
const SAMPLE_EVERY: usize = 5;
/// Ticks within which a patch must come to rest after a tap and after its release.
const REST_TICKS: usize = 400;
/// Share of the tap's speed (1): a patch is at rest if no node is faster.
const REST_SHARE: f32 = 0.01;
/// Largest number of substeps that are added to the bound.
const MOST_ADDED: u16 = 4;
/// Fast taps: place of each beside the site along two tangents, in probe radii (1), and extra
/// distance from the surface at which it starts, in ticks at the tap's speed (1). Whether a tap
/// near the limit diverges depends on the nodes under the probe and on the instant within a tick at
/// which they are struck.
const FAST_TAPS: [([f32; 2], f32); 12] = [
    ([0.0, 0.0], 0.0),
    ([0.0, 0.0], 0.25),
    ([0.0, 0.0], 0.5),
    ([0.0, 0.0], 0.75),
    ([0.25, 0.0], 0.125),
    ([-0.12, 0.22], 0.375),
    ([-0.12, -0.22], 0.625),
    ([0.0, 0.5], 0.875),
    ([0.43, -0.25], 0.0),
    ([-0.43, -0.25], 0.25),
    ([0.43, 0.25], 0.5),
    ([-0.43, 0.25], 0.75),
];
/// Ticks for which a fast tap is held, and ticks of its retreat.
const FAST_TICKS: [usize; 2] = [20, 15];
/// Longer tick at which fast taps must not diverge either, over the patch's own tick (1).
const LONGER: f32 = 1.15;
/// Number of power iterations for each sample.
const ITERATIONS: usize = 30;
/// Longest tick that a law is given [s], the longest that the core accepts.
const LAW_S: f64 = 1e-2;
/// Share of the longest stable substep that is used (1).
pub const MARGIN: f64 = 0.9;

/// Share of an element's size by which the tip may sink per tick (1). Waves of the floored masses
/// cross about 0.4 (shear) to 1.2 elements (volume) per tick. At this share, with implicit contact,
/// every tet of the shipped patches keeps a fifth of its volume in a tap as deep as the probe's
/// radius. At 0.29, which is 1 m/s on the finer patches, tets turn inside out.
const SINK_SHARE: f64 = 0.16;

/// The guard's limits that follow from the size of a patch's elements, whatever its stiffness: with
/// floored masses, waves travel about one element per tick.
#[must_use]
pub fn limits(patch: &Patch, tick_s: f64) -> GuardLimits {
    let max_sink_m_per_s = GuardLimits::HIGHEST.max_sink_m_per_s.min((SINK_SHARE * patch.element_m() / tick_s) as f32);
    GuardLimits { max_sink_m_per_s, ..GuardLimits::HIGHEST }
}

/// Parameters for another tick, with masses, foundation and damping unchanged: a patch that is
/// stable at a tick 15 % longer has a margin of 1.15 at its own tick. At a shorter tick the
/// contact's damping is limited to 1, the most that a substep can apply.
#[must_use]
pub fn with_tick(params: &Params, tick_s: f32) -> Params {
    let longer = tick_s / params.tick_s;
    Params {
        tick_s,
        mass_floor: params.mass_floor / (longer * longer),
        contact_damping: (params.contact_damping / longer).min(1.0),
        ..*params
    }
}

/// Longest stable substeps of a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StableStep {
    /// Longest stable substep at rest [s].
    pub rest_s: f64,
    /// Longest stable substep during the press to the depth limit [s]: the decisive one.
    pub pressed_s: f64,
}

impl StableStep {
    /// Number of substeps per tick that keeps a substep within `MARGIN` of the limit.
    #[must_use]
    pub fn substeps(&self, tick_s: f64) -> f64 {
        (tick_s / (MARGIN * self.pressed_s)).ceil()
    }

    /// Measures the limits of a patch. Returns `None` if the patch does not survive the measuring
    /// press.
    ///
    /// # Errors
    /// Fails if [`Params::build`] rejects the model or the parameters.
    pub fn measure(model: &Model, params: &Params, site_m: Vector3<f32>) -> Result<Option<Self>, BuildError> {
        if model.law.is_some() && params.terms.law {
            // a law has no step that could be unstable
            return Ok(Some(Self { rest_s: LAW_S, pressed_s: LAW_S }));
        }
        let careful =
            Params { substeps: CAREFUL_SUBSTEPS.max(params.substeps), limits: unbounded_but_sink(params), ..elastic(params) };
        let mut memory = Memory::for_model(model);
        let mut scratch = Memory::for_model(model);
        let (tuned, mut state) = memory.start(model, &careful)?;
        let (_, mut trial) = scratch.start(model, &careful)?;
        let limit = |w2: f64| (4.0 / w2).sqrt();
        let mut shape = ModeShape::seeded(model.nodes.len());
        let site_m = site_m + params.touch_offset_m();
        let above_m = site_m + params.probe.axis * extent(model) as f32;
        let rest = shape.highest_square(model, &tuned, &state, &mut trial, above_m);
        let mut highest = rest;
        for (n, depth_m) in way_down(model, params, PRESS_M_PER_S, 0.0).enumerate() {
            let tip_m = site_m - params.probe.axis * depth_m;
            if tick(model, &tuned, &mut state, ProbePose { tip_m }).fault.is_some() {
                return Ok(None);
            }
            if n % SAMPLE_EVERY == 0 || depth_m == model.depth_limit_m {
                highest = highest.max(shape.highest_square(model, &tuned, &state, &mut trial, tip_m));
            }
        }
        Ok(highest.is_finite().then(|| Self { rest_s: limit(rest), pressed_s: limit(highest) }))
    }
}

/// The smallest number of substeps, from `least` on, with which a patch that is tapped to its depth
/// limit comes to rest there and again after the release. If no number does (tissue that sags
/// slowly, or a press beyond the patch's limits), the smallest number without a fault; `None` if
/// every number has one. Tissue that stiffens must also survive fast taps
/// ([`substeps_for_fast_taps`]).
///
/// # Errors
/// Fails if [`Params::build`] rejects the model or the parameters.
pub fn substeps_for_taps(model: &Model, params: &Params, site_m: Vector3<f32>, least: u16) -> Result<Option<u16>, BuildError> {
    let Some(least) = substeps_for_fast_taps(model, params, site_m, least)? else { return Ok(None) };
    let mut without_fault = None;
    let site_m = site_m + params.touch_offset_m();
    for substeps in least..=least.saturating_add(MOST_ADDED) {
        let params = Params { substeps, limits: unbounded_but_sink(params), ..elastic(params) };
        let mut memory = Memory::for_model(model);
        let (tuned, mut state) = memory.start(model, &params)?;
        let hold = std::iter::repeat_n(model.depth_limit_m, REST_TICKS);
        let away = std::iter::repeat_n(-params.probe.radius_m, REST_TICKS);
        let mut rests = |depths_m: Vec<f32>| {
            let fault = depths_m.into_iter().find_map(|depth_m| {
                let tip_m = site_m - params.probe.axis * depth_m;
                tick(model, &tuned, &mut state, ProbePose { tip_m }).fault
            });
            let fastest = state.nodes().iter().map(|n| n.velocity_m_per_s().norm()).fold(0.0, f32::max);
            (fault.is_none(), fastest <= REST_SHARE * TAP_M_PER_S)
        };
        let (held, released) = (rests(way_down(model, &params, TAP_M_PER_S, 0.0).chain(hold).collect()), rests(away.collect()));
        if held.0 && released.0 {
            without_fault = without_fault.or(Some(substeps));
            if held.1 && released.1 {
                return Ok(Some(substeps));
            }
        }
    }
    Ok(without_fault)
}

/// The smallest number of substeps, from `least` on, with which tissue that stiffens survives taps
/// to its depth limit. The taps are as fast as the guard lets a tip move, at the site and within
/// half a probe radius of it, at the patch's own tick and at one 15 % longer with the same masses.
/// `None` if no number up to twice `least` and a few more is enough. Tissue that does not stiffen
/// gets `least`: no tap of 1 m/s diverges with it, from 1 to 100 kPa.
///
/// # Errors
/// Fails if [`Params::build`] rejects the model or the parameters.
pub fn substeps_for_fast_taps(
    model: &Model,
    params: &Params,
    site_m: Vector3<f32>,
    least: u16,
) -> Result<Option<u16>, BuildError> {
    if !params.terms.stiffening || params.stiffening_b == 0.0 {
        return Ok(Some(least));
    }
    for substeps in least..=least.saturating_mul(2).saturating_add(MOST_ADDED) {
        let params = Params { substeps, ..*params };
        let longer = with_tick(&params, LONGER * params.tick_s);
        if survives_fast_taps(model, &longer, site_m)? && survives_fast_taps(model, &params, site_m)? {
            return Ok(Some(substeps));
        }
    }
    Ok(None)
}

fn survives_fast_taps(model: &Model, params: &Params, site_m: Vector3<f32>) -> Result<bool, BuildError> {
    let params = Params { limits: unbounded_but_sink(params), ..elastic(params) };
    let (speed_m_per_s, [held, away]) = (params.limits.max_speed_m_per_s, FAST_TICKS);
    let beside = tangents(params.probe.axis.cast().into()).map(|t| Vector3::from(t).cast::<f32>() * params.probe.radius_m);
    for ([right, ahead], phase) in FAST_TAPS {
        let place_m = site_m + params.touch_offset_m() + beside[0] * right + beside[1] * ahead;
        let mut memory = Memory::for_model(model);
        let (tuned, mut state) = memory.start(model, &params)?;
        let hold = std::iter::repeat_n(model.depth_limit_m, held);
        let out = (1..=away).map(|n| model.depth_limit_m - n as f32 * speed_m_per_s * params.tick_s);
        for depth_m in way_down(model, &params, speed_m_per_s, phase).chain(hold).chain(out) {
            let tip_m = place_m - params.probe.axis * depth_m;
            if tick(model, &tuned, &mut state, ProbePose { tip_m }).fault.is_some() {
                return Ok(false);
            }
        }
    }
    Ok(true)
}

/// Depths of the tip [m], one per tick, from just outside to the depth limit; `phase` is the extra
/// distance of the start from the surface, in ticks at this speed (1). The tip starts outside,
/// since a probe that starts inside gets no force.
fn way_down(model: &Model, params: &Params, speed_m_per_s: f32, phase: f32) -> impl Iterator<Item = f32> {
    let step_m = speed_m_per_s * params.tick_s;
    let (start_m, end_m) = (-(2.0 + phase) * step_m, model.depth_limit_m);
    let ticks = ((end_m - start_m) / step_m).ceil() as usize;
    (0..=ticks).map(move |n| (start_m + n as f32 * step_m).min(end_m))
}

/// The parameters without relaxation and friction: relaxation alone would keep a patch from coming
/// to rest after a tap.
fn elastic(params: &Params) -> Params {
    Params { terms: Terms { relaxation: false, friction: false, ..params.terms }, ..*params }
}

/// The guard's limits at their highest values, except for the sink speed: stability is measured
/// without a force limit, but with the product's limit on the speed of a tap.
fn unbounded_but_sink(params: &Params) -> GuardLimits {
    GuardLimits { max_sink_m_per_s: params.limits.max_sink_m_per_s, ..GuardLimits::HIGHEST }
}

/// Shape of the mode with the highest frequency; each sample starts from that of the last one.
struct ModeShape(Vec<[f64; 3]>);

impl ModeShape {
    /// A shape that contains all modes, from a generator with a fixed seed.
    fn seeded(nodes: usize) -> Self {
        let mut x = 0x9e37_79b9_7f4a_7c15_u64;
        let mut next = || {
            x ^= x << 13;
            x ^= x >> 7;
            x ^= x << 17;
            (x >> 40) as f64 / (1u64 << 24) as f64 - 0.5
        };
        Self((0..nodes).map(|_| [next(), next(), next()]).collect())
    }

    /// Square of the highest angular frequency about the state [1/s^2]. Contact is implicit and
    /// left out, except that tissue that stiffens does so under the tip at `tip_m`. The tick's own
    /// stages give both the forces that a shape causes (`K u`) and the velocities after a substep
    /// (`dt M^-1 K u`), so that the mass matrix is the one that they use.
    fn highest_square(&mut self, model: &Model, tuned: &Tuned, state: &State, trial: &mut State, tip_m: Vector3<f32>) -> f64 {
        let size = extent(model);
        // tissue that stiffens is stiffer under the probe, even though contact itself is left out
        let seen_m = if tuned.stiffens() { tip_m } else { tuned.probe().axis * (100.0 * size as f32) };
        let mut square = 0.0;
        for _ in 0..ITERATIONS {
            let largest = self.0.iter().flatten().fold(0.0_f64, |a, &c| a.max(c.abs()));
            self.0.iter_mut().flatten().for_each(|c| *c /= largest);
            // small against the tissue, large against the rounding of f32
            let step = 1e-4 * size;
            let [Some(up), Some(down)] = [step, -step].map(|step| response(model, tuned, state, trial, &self.0, seen_m, step))
            else {
                return f64::INFINITY;
            };
            let (mut work, mut power) = (0.0, 0.0);
            for ((p, (f, v)), (g, w)) in self.0.iter_mut().zip(&up).zip(&down) {
                let pull = (Vector3::from(*g) - Vector3::from(*f)) / (2.0 * step);
                let turn = (Vector3::from(*w) - Vector3::from(*v)) / (2.0 * step * f64::from(tuned.substep_s()));
                work += Vector3::from(*p).dot(&pull);
                power += turn.dot(&pull);
                *p = turn.into();
            }
            square = power / work;
        }
        square
    }
}

/// Force on each node with the shape added to the state [N], and the node's velocity one substep
/// later, from rest [m/s], with the tip of the probe at `tip_m`. Forces on anchors are zero. `None`
/// if a node is so fast that the integration has diverged.
fn response(
    model: &Model,
    tuned: &Tuned,
    state: &State,
    trial: &mut State,
    shape: &[[f64; 3]],
    tip_m: Vector3<f32>,
    step: f64,
) -> Option<Vec<([f64; 3], [f64; 3])>> {
    trial.copy_from(state);
    for (n, (node, p)) in state.nodes().iter().zip(shape).enumerate() {
        let x = node.position_m();
        let moved = [0, 1, 2].map(|k| (f64::from(x[k]) + step * p[k]) as f32);
        trial.place(n, moved.into(), Vector3::zeros());
    }
    force::accumulate(model, tuned, trial, tip_m, Vector3::zeros());
    let e = f64::from(tuned.youngs_modulus_pa());
    let free = |n: usize| tuned.node_step().get(n).is_some_and(|node| node.step > 0.0);
    let forces: Vec<[f64; 3]> = (trial.nodes().iter().enumerate())
        .map(|(n, node)| if free(n) { node.force_over_modulus().map(|c| f64::from(c) * e).into() } else { [0.0; 3] })
        .collect();
    integrate::advance(model, tuned, trial).ok()?;
    let velocities = trial.nodes().iter().map(|node| node.velocity_m_per_s().map(f64::from).into());
    Some(forces.into_iter().zip(velocities).collect())
}

/// Largest side of the patch [m].
fn extent(model: &Model) -> f64 {
    let side = |k: usize| {
        let (low, high) = model.nodes.iter().fold((f32::MAX, f32::MIN), |(l, h), n| (l.min(n.rest_m[k]), h.max(n.rest_m[k])));
        f64::from(high - low)
    };
    side(0).max(side(1)).max(side(2))
}
