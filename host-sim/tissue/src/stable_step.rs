//! Longest stable substep, measured on the *pressed* patch, not at rest.
//!
//! Tissue stiffens under the probe: the limit there is well below the limit at rest. So the patch
//! is pressed to its depth limit with safely small substeps, and meanwhile the highest frequency of
//! its tangent stiffness is found by power iteration. Symplectic Euler is stable while `dt w < 2`.
//! Relaxation is left out: the immediate response is that of the elastic stiffness. Contact is
//! implicit and does not affect it. A tap compresses more for a few milliseconds, so the substeps
//! from this bound are then tried on a tap, and increased by one until the patch comes to rest
//! during it and after it.
//!
//! Tissue that stiffens is tried on faster taps first. At 1 m/s the probe is as fast as the shear
//! waves of soft tissue (1.07 m/s at 3.5 kPa): it squeezes the first elements before the next ones
//! move, and under the exponential law their stiffness rises up to 55 times (`stiffening::CAP`).
//! Within four ticks `dt w` then rises from 0.4 at rest past the limit of 2, before any tet is
//! inverted.

use palpate::stages::{force, integrate};
use palpate::{BuildError, GuardLimits, Model, Params, ProbePose, State, Terms, Tuned, Vector3, tick};

use crate::organ::tangents;
use crate::patch::{Memory, Patch};

/// Substeps of the measuring run: far below the limit of any patch that is worth running.
const CAREFUL_SUBSTEPS: u16 = 16;
/// Speed of the measuring press [m/s]: slow enough that inertia does not squeeze the tissue.
const PRESS_M_PER_S: f32 = 0.1;
/// Speed of the tap [m/s]: the upper end of a hand's speed on tissue.
const TAP_M_PER_S: f32 = 0.5;
/// Number of ticks between samples of the press.
const SAMPLE_EVERY: usize = 5;
/// Ticks within which a patch must come to rest after a tap and after its release.
const REST_TICKS: usize = 400;
/// Share of the tap's speed below which every node counts as at rest.
const REST_SHARE: f32 = 0.01;
/// Number of substeps beyond the bound that are tried on a tap.
const MOST_ADDED: u16 = 4;
/// Fast taps: places beside the site, in radii of the probe (1), and how much further outside they
/// start, in steps of a tick (1). Whether a tap near the limit diverges depends on how the nodes
/// lie under the probe and on when within a tick they are struck.
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
/// Ticks for which fast taps are held, and ticks of their retreat.
const FAST_TICKS: [usize; 2] = [20, 15];
/// Tick over the patch's own at which fast taps must not diverge either (1).
const LONGER: f32 = 1.15;
const ITERATIONS: usize = 30;
/// Share of the limit that is used.
pub const MARGIN: f64 = 0.9;

/// Share of an element's size that the tip may sink per tick. Waves of the floored masses cross
/// about 0.4 (shear) to 1.2 elements (volume) per tick. At this share, with implicit contact, every
/// tet of the shipped patches keeps a fifth of its volume in a tap to the probe's radius. At 0.29,
/// which is 1 m/s on the finer patches, tets turn inside out.
const SINK_SHARE: f64 = 0.16;

/// The limits that a patch's elements set, whatever its stiffness: floored masses carry waves at
/// element size over tick.
#[must_use]
pub fn limits(patch: &Patch, tick_s: f64) -> GuardLimits {
    let max_sink_m_per_s = GuardLimits::HIGHEST.max_sink_m_per_s.min((SINK_SHARE * patch.element_m() / tick_s) as f32);
    GuardLimits { max_sink_m_per_s, ..GuardLimits::HIGHEST }
}

/// Parameters for another tick with the masses, the foundation and the damping of this one: a patch
/// that is stable at a tick 15 % longer has a margin of 1.15 at this one. At a shorter one the
/// dashpot is at most what a substep can carry.
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

/// Limits of the substep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StableStep {
    /// Longest stable substep at rest [s].
    pub rest_s: f64,
    /// Longest stable substep during the press to the depth limit [s]: the decisive one.
    pub pressed_s: f64,
}

impl StableStep {
    /// Substeps that a tick needs to stay within `MARGIN` of the limit.
    #[must_use]
    pub fn substeps(&self, tick_s: f64) -> f64 {
        (tick_s / (MARGIN * self.pressed_s)).ceil()
    }

    /// Measures a patch. `None` when the patch does not even survive the measuring press.
    ///
    /// # Errors
    /// Parameters or a model that [`Params::build`] refuses.
    pub fn measure(model: &Model, params: &Params, site_m: Vector3<f32>) -> Result<Option<Self>, BuildError> {
        let careful =
            Params { substeps: CAREFUL_SUBSTEPS.max(params.substeps), limits: unbounded_but_sink(params), ..elastic(params) };
        let mut memory = Memory::for_model(model);
        let mut scratch = Memory::for_model(model);
        let (tuned, mut state) = memory.start(model, &careful)?;
        let (_, mut trial) = scratch.start(model, &careful)?;
        let limit = |w2: f64| (4.0 / w2).sqrt();
        let mut shape = ModeShape::seeded(model.nodes.len());
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

/// The fewest substeps, from `least` on, with which a patch taken to its depth limit in a tap comes
/// to rest there and after the release; if none does (tissue that sags slowly, or a press beyond
/// its limits), the fewest without a fault. `None` if all have one. Tissue that stiffens also
/// withstands fast taps ([`substeps_for_fast_taps`]).
///
/// # Errors
/// Parameters or a model that [`Params::build`] refuses.
pub fn substeps_for_taps(model: &Model, params: &Params, site_m: Vector3<f32>, least: u16) -> Result<Option<u16>, BuildError> {
    let Some(least) = substeps_for_fast_taps(model, params, site_m, least)? else { return Ok(None) };
    let mut without_fault = None;
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

/// The fewest substeps, from `least` on, with which tissue that stiffens survives taps to its depth
/// limit at the fastest speed that the guard shows a patch, at the site and within half a radius of
/// it, also at a tick 15 % longer. The masses stay the same. `None` if no number up to twice
/// `least` and a few more is enough. Tissue that does not stiffen gets `least`: with it no tap of
/// 1 m/s diverges from 1 to 100 kPa.
///
/// # Errors
/// Parameters or a model that [`Params::build`] refuses.
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
        let place_m = site_m + beside[0] * right + beside[1] * ahead;
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

/// Tip depths [m] from just outside to the depth limit, tick by tick; `phase` is how much further
/// outside the tip starts, in steps. It starts outside, since a probe that starts inside gets no
/// force.
fn way_down(model: &Model, params: &Params, speed_m_per_s: f32, phase: f32) -> impl Iterator<Item = f32> {
    let step_m = speed_m_per_s * params.tick_s;
    let (start_m, end_m) = (-(2.0 + phase) * step_m, model.depth_limit_m);
    let ticks = ((end_m - start_m) / step_m).ceil() as usize;
    (0..=ticks).map(move |n| (start_m + n as f32 * step_m).min(end_m))
}

/// The parameters without relaxation, which alone would keep a patch from coming to rest after a
/// tap.
fn elastic(params: &Params) -> Params {
    Params { terms: Terms { relaxation: false, friction: false, ..params.terms }, ..*params }
}

/// Returns limits at their highest, except for the sink speed: the patch's stability is measured
/// without a force limit, but with the product's limit on the speed of a tap.
fn unbounded_but_sink(params: &Params) -> GuardLimits {
    GuardLimits { max_sink_m_per_s: params.limits.max_sink_m_per_s, ..GuardLimits::HIGHEST }
}

/// The shape of the highest mode, kept from sample to sample.
struct ModeShape(Vec<[f64; 3]>);

impl ModeShape {
    /// A shape that contains all modes; deterministic.
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
    /// left out, except where the tissue stiffens under it. The effect of a shape on the forces (`K
    /// u`) and on the velocities after a substep (`dt M^-1 K u`) are both read off the tick's own
    /// stages, so that the mass matrix is that of these stages.
    fn highest_square(&mut self, model: &Model, tuned: &Tuned, state: &State, trial: &mut State, tip_m: Vector3<f32>) -> f64 {
        let size = extent(model);
        // tissue under the probe is stiffer because of it, even though contact has no share
        let seen_m = if tuned.stiffens() { tip_m } else { tuned.probe().axis * (100.0 * size as f32) };
        let mut square = 0.0;
        for _ in 0..ITERATIONS {
            let largest = self.0.iter().flatten().fold(0.0_f64, |a, &c| a.max(c.abs()));
            self.0.iter_mut().flatten().for_each(|c| *c /= largest);
            // small for the tissue, large for f32
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

/// Force [N] on each node with the shape added to the state, and its velocity [m/s] one substep
/// later, from rest, with the probe's tip at `tip_m`. Forces on anchors are zero. `None` when a
/// node is too fast to be tissue.
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
