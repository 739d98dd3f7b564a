//! Errors of a method that lacks terms of the tissue model: in a hold whose force relaxes, in a
//! deep press into tissue that stiffens, and in a slide with friction.
//!
//! Our methods run with the term in question, the others unchanged, since none of them has it. The
//! references are the elastic finite-element force times the relaxation function of the preset
//! `beef`, finite elements of the Fung-Demiray law, and Coulomb's law applied to the computed
//! normal force.

use serde::{Deserialize, Serialize};

use super::reference::Reference;
use super::survive::{CLEAR_M, Survival, least_substeps};
use crate::error::Error;
use crate::methods::{Block, Method, RunningMethod};
use palpate::{MOST_TERMS, Params, PronyTerm, Vector3};
use palpate_tissue::error::Error as TissueError;
use palpate_tissue::scene::Scene;

/// Finite-element forces of the Fung-Demiray law, by exponent and place.
const STIFFENING: &str = include_str!("../../../../tests/data/stiffening_reference.json");
/// Exponent b of the tissue that stiffens (1).
const STIFFENING_B: f64 = 10.0;
/// Depth of the deep press [m]: three quarters of the radius.
const DEEP_M: f64 = 6e-3;
/// Depth of the hold and of the slide [m].
const DEPTH_M: f64 = 2e-3;
/// Speed of loading [m/s].
const IN_M_PER_S: f64 = 0.1;
/// Times after the start of the hold at which the force is compared [s].
const HELD_S: [f64; 2] = [1.0, 10.0];
/// Time for the force to settle before it is compared, or before the slide starts [s].
const SETTLE_S: f64 = 0.4;
/// Friction coefficient of the slide (1), its length [m] and its speed [m/s].
const FRICTION: f64 = 0.46;
const SLIDE_M: f64 = 6e-3;
const SLIDE_M_PER_S: f64 = 0.02;
/// Length of the last part of the slide, over which the force is averaged [m]: one element of the
/// patch.
const AVERAGED_M: f64 = 3e-3;

/// Force errors of a method [%]; `None` where it diverges.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct TermErrors {
    /// Method that was measured.
    pub method: Method,
    /// Number of nodes.
    pub nodes: usize,
    /// Whether the method runs with the terms.
    pub has_terms: bool,
    /// Substeps per tick in elastic tissue and in tissue that stiffens.
    pub substeps: [u16; 2],
    /// Error after 1 and 10 s of a hold 2 mm deep in tissue that relaxes like beef.
    pub held_pct: [Option<f64>; 2],
    /// Error 6 mm deep (d/R = 0.75) in tissue that stiffens with b = 10.
    pub stiffening_pct: Option<f64>,
    /// Error of the force along the surface in a slide at 20 mm/s, against 0.46 times the normal
    /// force.
    pub sideways_pct: Option<f64>,
}

/// Measures a method on a block. `None` if it is not available or diverges with every number of
/// substeps that is tried.
pub fn term_errors(method: Method, block: &Block) -> Result<Option<TermErrors>, Error> {
    let terms = Terms::load()?;
    // springs alone are the model of a paper, so they are not counted as ours here
    let ours = method.is_ours() && method != Method::Springs;
    let with = |change: fn(&Terms, Params) -> Params| {
        let params = if ours { change(&terms, block.params) } else { block.params };
        Block { params, ..block.clone() }
    };
    let relaxing = with(|terms, params| Params { relaxation: terms.relaxation, ..params });
    let stiffening = with(|_, params| Params { stiffening_b: STIFFENING_B as f32, ..params });
    let rubbing = with(|_, params| Params { friction: FRICTION as f32, ..params });
    let Some(Ok(Survival { substeps, .. })) = least_substeps(method, block)? else { return Ok(None) };
    let stiffer = match least_substeps(method, &stiffening)? {
        Some(Ok(survival)) => survival.substeps,
        _ => substeps,
    };
    let e_pa = f64::from(block.params.youngs_modulus_pa);
    let elastic_n = Reference::block().force_over_e_m2(DEPTH_M).map(|force| force * e_pa);
    let held = method.run(&relaxing, substeps, |running| hold(&relaxing, running))?.flatten();
    let deep = method.run(&stiffening, stiffer, |running| deep(&stiffening, running))?.flatten();
    let sideways = method.run(&rubbing, substeps, |running| slide(&rubbing, running))?.flatten();
    let error_pct = |found: f64, wanted: f64| 100.0 * (found / wanted - 1.0);
    Ok(Some(TermErrors {
        method,
        nodes: block.size().nodes,
        has_terms: ours,
        substeps: [substeps, stiffer],
        held_pct: [0, 1].map(|n| Some(error_pct(held?[n], elastic_n? * terms.left(HELD_S[n])))),
        stiffening_pct: deep.map(|force_n| error_pct(force_n, terms.stiffened_m2 * e_pa)),
        sideways_pct: sideways.map(|ratio| error_pct(ratio, FRICTION)),
    }))
}

/// The relaxation terms and the reference of the stiffening tissue.
struct Terms {
    relaxation: [PronyTerm; MOST_TERMS],
    /// Force over E of the deep press by finite elements [m^2].
    stiffened_m2: f64,
}

#[derive(Deserialize)]
struct Stored {
    press: Vec<StoredPress>,
}

#[derive(Deserialize)]
struct StoredPress {
    b: f64,
    x_m: f64,
    depth_m: Vec<f64>,
    force_m2: Vec<f64>,
}

impl Terms {
    fn load() -> Result<Self, Error> {
        let damaged = || TissueError::Check("tests/data/stiffening_reference.json: take the file as it ships".into());
        let stored: Stored = serde_json::from_str(STIFFENING).map_err(|_| damaged())?;
        let press = stored.press.iter().find(|p| p.b == STIFFENING_B && p.x_m == 0.0).ok_or_else(damaged)?;
        let deep = press.depth_m.iter().position(|d| (d - DEEP_M).abs() < 1e-9).ok_or_else(damaged)?;
        let stiffened_m2 = *press.force_m2.get(deep).ok_or_else(damaged)?;
        let relaxation = Scene::load("beef").map_err(TissueError::from)?.tissue.relaxation();
        Ok(Self { relaxation, stiffened_m2 })
    }

    /// Share of the elastic force that is left (1) `held_s` after the end of a ramp of constant
    /// speed: the elastic force rises with depth^1.5, and each increment relaxes from the time at
    /// which it was added.
    fn left(&self, held_s: f64) -> f64 {
        const PARTS: i32 = 400;
        let ramp_s = DEPTH_M / IN_M_PER_S;
        let of_part = |n: i32| {
            let [from, to] = [n, n + 1].map(|n| f64::from(n) / f64::from(PARTS));
            let age_s = held_s + ramp_s * (1.0 - 0.5 * (from + to));
            (to.powf(1.5) - from.powf(1.5)) * self.left_of_step(age_s)
        };
        (0..PARTS).map(of_part).sum()
    }

    fn left_of_step(&self, age_s: f64) -> f64 {
        let faded = |term: &PronyTerm| f64::from(term.share) * -(-age_s / f64::from(term.time_s)).exp_m1();
        1.0 - self.relaxation.iter().filter(|term| term.share > 0.0).map(faded).sum::<f64>()
    }
}

/// Moves the tip from above the surface down to `depth_m`; returns the force there [N].
fn go_down(block: &Block, running: &mut dyn RunningMethod, depth_m: f64) -> Option<Vector3<f64>> {
    let step_m = IN_M_PER_S * f64::from(block.params.tick_s);
    let ticks = ((depth_m + CLEAR_M) / step_m).ceil() as usize;
    let mut last = Vector3::zeros();
    for n in 0..=ticks {
        let depth_m = (n as f64 * step_m - CLEAR_M).min(depth_m);
        last = running.tick(block.tip_m(depth_m)).ok()?.cast();
    }
    Some(last)
}

fn stay(block: &Block, running: &mut dyn RunningMethod, depth_m: f64, time_s: f64) -> Option<f64> {
    let ticks = (time_s / f64::from(block.params.tick_s)).round() as usize;
    let mut force_n = f64::NAN;
    for _ in 0..ticks {
        force_n = f64::from(running.tick(block.tip_m(depth_m)).ok()?.dot(&block.params.probe.axis));
    }
    Some(force_n)
}

/// Force at each of [`HELD_S`] after the start of the hold [N].
fn hold(block: &Block, running: &mut dyn RunningMethod) -> Option<[f64; 2]> {
    go_down(block, running, DEPTH_M)?;
    let first = stay(block, running, DEPTH_M, HELD_S[0])?;
    Some([first, stay(block, running, DEPTH_M, HELD_S[1] - HELD_S[0])?])
}

/// Force of the deep press along the probe's axis, after it has settled [N].
fn deep(block: &Block, running: &mut dyn RunningMethod) -> Option<f64> {
    go_down(block, running, DEEP_M)?;
    stay(block, running, DEEP_M, SETTLE_S)
}

/// Force along the surface divided by the normal force, averaged over the last part of the slide
/// (1).
fn slide(block: &Block, running: &mut dyn RunningMethod) -> Option<f64> {
    go_down(block, running, DEPTH_M)?;
    stay(block, running, DEPTH_M, SETTLE_S)?;
    let step_m = SLIDE_M_PER_S * f64::from(block.params.tick_s);
    let ticks = (SLIDE_M / step_m).round() as usize;
    let along = Vector3::new(1.0, 0.0, 0.0);
    let (mut against, mut push) = (0.0, 0.0);
    for n in 1..=ticks {
        let slid_m = n as f64 * step_m;
        let tip_m = block.tip_m(DEPTH_M) + along * slid_m as f32;
        let force_n = running.tick(tip_m).ok()?;
        if slid_m > SLIDE_M - AVERAGED_M {
            against -= f64::from(force_n.dot(&along));
            push += f64::from(force_n.dot(&block.params.probe.axis));
        }
    }
    Some(against / push)
}
