//! How long a substep may be: measured on the *pressed* patch, not at rest.
//!
//! Tissue stiffens under the probe: the limit there is well below the limit at rest. So the patch
//! is pressed to its depth limit with safely small substeps, and on the way the highest frequency
//! of its tangent stiffness is found by power iteration. Symplectic Euler is stable while `dt^2
//! w^2 + 2 dt c < 4`; the foundation's damping takes `2 dt c <= 2 zeta eta` of it. A tap squeezes
//! harder for a few milliseconds, so the substeps that this bound asks for are then tried on a tap,
//! and one is added until the patch comes to rest in it and after it.

use palpate::stages::force;
use palpate::{BuildError, Limits, Model, Params, ProbePose, State, Tuned, Vector3, tick};

use crate::patch::{Memory, Patch};

/// Substeps of the measuring run: far below the limit of any patch that is worth running.
const CAREFUL_SUBSTEPS: u16 = 16;
/// Speed of the measuring press [m/s]: slow enough that inertia does not squeeze the tissue.
const PRESS_M_PER_S: f32 = 0.1;
/// Speed of the tap [m/s]: the upper end of what a hand does on tissue.
const TAP_M_PER_S: f32 = 0.5;
/// A sample of the press every so many ticks.
const SAMPLE_EVERY: usize = 5;
/// Ticks that a patch gets to come to rest after a tap and after its release.
const REST_TICKS: usize = 400;
/// It rests when no node is faster than this share of the tap.
const REST_SHARE: f32 = 0.01;
/// Substeps tried on a tap beyond those of the bound.
const MOST_ADDED: u16 = 4;
const ITERATIONS: usize = 30;
/// Share of the limit that is used.
pub const MARGIN: f64 = 0.9;

/// How much of an element's size the tip may sink in a tick. Waves of the floored masses cross
/// about 0.4 (shear) to 1.2 elements (volume) a tick; measured: at 0.17 tets under the probe turn
/// inside out in a tap to the probe's radius, at 0.13 they keep a tenth of their volume and more.
const SINK_SHARE: f64 = 0.12;

/// The limits that a patch's elements set, whatever its stiffness: masses with a floor carry waves
/// at element size over tick.
#[must_use]
pub fn limits(patch: &Patch, tick_s: f64) -> Limits {
    let max_sink_m_per_s = Limits::HIGHEST.max_sink_m_per_s.min((SINK_SHARE * patch.element_m() / tick_s) as f32);
    Limits { max_sink_m_per_s, ..Limits::HIGHEST }
}

/// Limits of the substep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct StableStep {
    /// At rest [s].
    pub rest_s: f64,
    /// On the way down to the depth limit [s]: the one that counts.
    pub pressed_s: f64,
}

impl StableStep {
    /// Substeps a tick needs to stay within `MARGIN` of the limit.
    #[must_use]
    pub fn substeps(&self, tick_s: f64) -> f64 {
        (tick_s / (MARGIN * self.pressed_s)).ceil()
    }

    /// Measures a patch. `None` when the patch does not even survive the measuring press.
    ///
    /// # Errors
    /// Parameters or a model that [`Params::build`] refuses.
    pub fn measure(model: &Model, params: &Params, site_m: Vector3<f32>) -> Result<Option<Self>, BuildError> {
        let careful = Params { substeps: CAREFUL_SUBSTEPS.max(params.substeps), limits: unbounded_but_sink(params), ..*params };
        let mut memory = Memory::for_model(model);
        let mut scratch = Memory::for_model(model);
        let (tuned, mut state) = memory.start(model, &careful)?;
        let (_, mut trial) = scratch.start(model, &careful)?;
        let limit = |w2: f64| {
            // the cap is told for the tick, what it takes of a step's room is that of the substep
            let substeps = f64::from(params.substeps);
            let room = 4.0 - 2.0 * f64::from(params.contact_damping * params.contact_cap) / (substeps * substeps);
            (room.max(1.0) / w2).sqrt()
        };
        let mut shape = Shape::seeded(model.nodes.len());
        let rest = shape.highest_square(model, &tuned, &state, &mut trial, site_m);
        let mut highest = rest;
        for (n, depth_m) in way_down(model, params, PRESS_M_PER_S).enumerate() {
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
/// to rest there and after the release; where none brings rest (tissue that sags slowly, a press
/// beyond what it bears), the fewest that give no fault. `None` when all do.
///
/// # Errors
/// Parameters or a model that [`Params::build`] refuses.
pub fn substeps_for_taps(model: &Model, params: &Params, site_m: Vector3<f32>, least: u16) -> Result<Option<u16>, BuildError> {
    let mut without_fault = None;
    for substeps in least..=least.saturating_add(MOST_ADDED) {
        let params = Params { substeps, limits: unbounded_but_sink(params), ..*params };
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
        let (held, released) = (rests(way_down(model, &params, TAP_M_PER_S).chain(hold).collect()), rests(away.collect()));
        if held.0 && released.0 {
            without_fault = without_fault.or(Some(substeps));
            if held.1 && released.1 {
                return Ok(Some(substeps));
            }
        }
    }
    Ok(without_fault)
}

/// Tip depths [m] from just outside to the depth limit, tick by tick. From outside: a probe that
/// starts inside gets no force.
fn way_down(model: &Model, params: &Params, speed_m_per_s: f32) -> impl Iterator<Item = f32> {
    let step_m = speed_m_per_s * params.tick_s;
    let (start_m, end_m) = (-2.0 * step_m, model.depth_limit_m);
    let ticks = ((end_m - start_m) / step_m).ceil() as usize;
    (0..=ticks).map(move |n| (start_m + n as f32 * step_m).min(end_m))
}

/// Returns limits at their highest, except for the sink speed: what the patch bears is measured
/// without a limit of the force, but a tap is shown to it as the product shows it.
fn unbounded_but_sink(params: &Params) -> Limits {
    Limits { max_sink_m_per_s: params.limits.max_sink_m_per_s, ..Limits::HIGHEST }
}

/// The shape of the highest mode, kept from sample to sample.
struct Shape(Vec<[f64; 3]>);

impl Shape {
    /// Any shape with all modes in it; deterministic.
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

    /// Square of the highest angular frequency about the state [1/s^2].
    fn highest_square(&mut self, model: &Model, tuned: &Tuned, state: &State, trial: &mut State, tip_m: Vector3<f32>) -> f64 {
        let masses: Vec<f64> = (0..model.nodes.len()).map(|n| tuned.mass_kg(n).map_or(f64::INFINITY, f64::from)).collect();
        let size = extent(model);
        let mut square = 0.0;
        for _ in 0..ITERATIONS {
            let largest = self.0.iter().flatten().fold(0.0_f64, |a, &c| a.max(c.abs()));
            self.0.iter_mut().flatten().for_each(|c| *c /= largest);
            let norm: f64 = self.0.iter().zip(&masses).filter(|(_, m)| m.is_finite()).map(|(p, m)| m * dot(p, p)).sum();
            // small for the tissue, large for f32
            let step = 1e-4 * size;
            let up = forces(model, tuned, state, trial, tip_m, &self.0, step);
            let down = forces(model, tuned, state, trial, tip_m, &self.0, -step);
            let mut work = 0.0;
            for (((p, m), f), g) in self.0.iter_mut().zip(&masses).zip(&up).zip(&down) {
                let pull = [0, 1, 2].map(|k| (g[k] - f[k]) / (2.0 * step));
                work += dot(p, &pull);
                *p = pull.map(|c| if m.is_finite() { c / m } else { 0.0 });
            }
            square = work / norm;
        }
        square
    }
}

/// Forces on the nodes [N] with the shape added to the state, anchors zero.
fn forces(
    model: &Model,
    tuned: &Tuned,
    state: &State,
    trial: &mut State,
    tip_m: Vector3<f32>,
    shape: &[[f64; 3]],
    step: f64,
) -> Vec<[f64; 3]> {
    trial.copy_from(state);
    for (n, (node, p)) in state.nodes().iter().zip(shape).enumerate() {
        let x = node.position_m();
        let moved = [0, 1, 2].map(|k| (f64::from(x[k]) + step * p[k]) as f32);
        trial.place(n, moved.into(), Vector3::zeros());
    }
    force::accumulate(model, tuned, trial, tip_m, Vector3::zeros());
    let e = f64::from(tuned.youngs_modulus_pa());
    trial.nodes().iter().map(|n| n.force_over_modulus().map(|c| f64::from(c) * e).into()).collect()
}

/// Largest side of the patch [m].
fn extent(model: &Model) -> f64 {
    let side = |k: usize| {
        let (low, high) = model.nodes.iter().fold((f32::MAX, f32::MIN), |(l, h), n| (l.min(n.rest_m[k]), h.max(n.rest_m[k])));
        f64::from(high - low)
    };
    side(0).max(side(1)).max(side(2))
}

fn dot(a: &[f64; 3], b: &[f64; 3]) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}
