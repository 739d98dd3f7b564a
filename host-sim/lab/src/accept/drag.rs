//! T5, friction: a ball that is pressed and dragged is compared with Cattaneo and Mindlin, a flat
//! end that slides with Coulomb's law, and a flat end that sticks with a glued disc of finite
//! elements. A ball held under a sideways force is followed for a minute to see whether it creeps.
//!
//! The closed form starts without a force along the surface. A press with friction leaves such a
//! force, which at a small coefficient uses up much of the friction limit; so the ball is pressed
//! without friction, and friction is switched on afterwards.

use palpate::{NodeStep, Output, Params, ProbeShape, Vector3};
use palpate_fit::partial_slip::{PartialSlip, tilted};
use palpate_tissue::answer::Answer;
use palpate_tissue::patch::Memory;
use rayon::prelude::*;

use super::bench::{Bench, RADIUS_M, Run};
use super::{Curve, Figure, Outcome, Picture, Row};
use crate::Error;

mod shipped;

const SOURCE: &str = "host-sim/fit/src/partial_slip.rs (Cattaneo 1938, Mindlin 1949)";
const FRICTION: [f64; 4] = [0.1, 0.3, 0.6, 1.0];
/// Depths of the presses [m], up to a quarter of the radius.
const DEPTHS_M: [f64; 3] = [1e-3, 2e-3, 4e-3];
/// Depth of the drags in the picture, and of the drag without friction [m].
const SHOWN_M: f64 = 2e-3;
/// Largest length at which full slip may begin [m]; cases that need a longer drag are left out.
const LONGEST_M: f64 = 5e-3;
/// Length of a drag, divided by the length at which full slip begins (1).
const BEYOND: f64 = 1.25;
/// Number of ticks of the press, of the pause after it, and of a drag.
const PRESSED: usize = 500;
const RESTED: usize = 800;
const DRAGGED: usize = 1300;
/// Number of ticks over which a drag accelerates: a sudden start would shake the block.
const STARTED: usize = 160;
/// Largest accepted difference from the closed form, divided by mu N (1).
const MOST: f64 = 0.03;
/// Accepted range of the friction force in full slip, divided by its closed form (1).
const SLIDES: [f64; 2] = [0.995, 1.005];
/// Heading of the drags [rad], not along an axis of the mesh.
const TURNED: f64 = 0.8;

/// Force along the surface, positive against the heading `turned` [rad], and normal force [N].
fn parts(output: &Output, turned: f64) -> [f64; 2] {
    let (force, normal) = (output.force_n.cast::<f64>(), output.normal.cast::<f64>());
    let push = force.dot(&normal);
    [-(force - normal * push).dot(&Vector3::new(turned.cos(), turned.sin(), 0.0)), push]
}

/// Share of a drag's length that is covered after `tick` ticks (1).
fn done(tick: usize) -> f64 {
    let (n, started) = (tick as f64, STARTED as f64);
    let ticks = if tick < STARTED { n * n / (2.0 * started) } else { n - 0.5 * started };
    ticks / (DRAGGED as f64 - 0.5 * started)
}

/// Force along the surface and normal force [N] in every tick of a drag of `length_m`, after a
/// press without friction.
fn drag(bench: &Bench, friction: f64, depth_m: f64, length_m: f64) -> Result<Vec<[f64; 2]>, Error> {
    let model = bench.patch.wide_model();
    let (mut memory, mut node_step) = (Memory::for_model(&model), vec![NodeStep::ZERO; model.nodes.len()]);
    let smooth = Params { friction: 0.0, ..bench.params }.build(&model, &mut node_step)?;
    let mut run = Run::start(&model, &Params { friction: friction as f32, ..bench.params }, &mut memory)?;
    let rough = run.retune(smooth);
    for n in 0..PRESSED + RESTED {
        run.at([0.0; 2], depth_m * (n as f64 / PRESSED as f64).min(1.0))?;
    }
    run.retune(rough);
    let heading = [TURNED.cos(), TURNED.sin()];
    (1..=DRAGGED).map(|n| Ok(parts(&run.at(heading.map(|c| c * length_m * done(n)), depth_m)?, TURNED))).collect()
}

/// Normalises a drag: (length divided by that at full slip, force along the surface divided by mu
/// N).
fn shares(forces_n: &[[f64; 2]], friction: f64) -> Vec<(f64, f64)> {
    forces_n.iter().zip(1..).map(|([along, push], n)| (BEYOND * done(n), along / (friction * push))).collect()
}

/// Largest difference from the closed form of partial slip, divided by mu N (1).
fn off(shares: &[(f64, f64)]) -> f64 {
    let partial = shares.iter().filter(|(over_slips, _)| *over_slips < 1.0);
    partial.map(|(over_slips, share)| (share - PartialSlip::share(*over_slips)).abs()).fold(0.0, f64::max)
}

/// The value that differs most from `from`.
fn farthest(from: f64, values: impl Iterator<Item = f64>) -> f64 {
    values.fold(from, |worst, value| if (worst - from).abs() > (value - from).abs() { worst } else { value })
}

/// The row and the picture of the ball that is dragged over the large block.
fn ball() -> Result<(Row, Picture), Error> {
    let bench = Bench::large()?;
    let poisson_ratio = f64::from(bench.params.poisson_ratio);
    let slips_m = |friction: f64, depth_m: f64| PartialSlip { friction, poisson_ratio, depth_m }.slips_m();
    let cases = FRICTION.iter().flat_map(|friction| DEPTHS_M.map(|depth_m| (*friction, depth_m)));
    let mut cases: Vec<(f64, f64)> = cases.filter(|(friction, d)| slips_m(*friction, *d) < LONGEST_M).collect();
    cases.push((0.0, SHOWN_M));
    let length_m = |(friction, depth_m): (f64, f64)| BEYOND * slips_m(if friction == 0.0 { 1.0 } else { friction }, depth_m);
    let forces_n: Vec<Vec<[f64; 2]>> =
        cases.par_iter().map(|case| drag(&bench, case.0, case.1, length_m(*case))).collect::<Result<_, Error>>()?;
    let without_n = forces_n.last().map_or(&[][..], Vec::as_slice);
    let drags = |friction: f64| {
        let found = cases.iter().zip(&forces_n).filter(move |(case, _)| case.0 == friction);
        found.map(move |(case, forces_n)| (case.1, shares(forces_n, friction)))
    };
    let slides =
        |depth_m: f64, shares: &[(f64, f64)]| shares.last().map_or(f64::NAN, |(_, share)| share / tilted(depth_m / RADIUS_M));
    let partial = FRICTION.map(|friction| Figure {
        what: format!("partial slip, mu {friction}: off, of mu N"),
        accepted: [0.0, MOST],
        ours: farthest(0.0, drags(friction).map(|(_, shares)| off(&shares))),
        without_term: off(&shares(without_n, friction)),
    });
    let full = FRICTION.map(|friction| Figure {
        what: format!("full slip, mu {friction}: over its closed form"),
        accepted: SLIDES,
        ours: farthest(1.0, drags(friction).map(|(depth_m, shares)| slides(depth_m, &shares))),
        without_term: slides(SHOWN_M, &shares(without_n, friction)),
    });
    let row = Row {
        test: "T5".into(),
        data: format!("closed forms, ball of {} mm, 1, 2 and 4 mm deep", RADIUS_M * 1e3),
        source: SOURCE.into(),
        term: "friction".into(),
        fitted: "nothing".into(),
        predicted: "worst of the depths; drags to 5 mm, in full slip the tilt of the pushes counted".into(),
        figures: partial.into_iter().chain(full).collect(),
    };
    let every = |points: &[(f64, f64)]| points.iter().step_by(10).copied().collect::<Vec<_>>();
    let theory = (0..=25).map(|n| 0.05 * f64::from(n)).map(|over_slips| (over_slips, PartialSlip::share(over_slips)));
    let mut curves = vec![Curve { name: "Cattaneo and Mindlin".into(), points: theory.collect(), measured: true }];
    for friction in FRICTION {
        let shown = drags(friction).find(|(depth_m, _)| *depth_m == SHOWN_M).map(|(_, shares)| every(&shares));
        curves.push(Curve { name: format!("ours, mu {friction}"), points: shown.unwrap_or_default(), measured: false });
    }
    let without = every(&shares(without_n, 1.0));
    curves.push(Curve { name: "ours without friction".into(), points: without, measured: false });
    let picture = Picture {
        name: "friction".into(),
        title: format!("ball of {} mm, {} mm deep, dragged", RADIUS_M * 1e3, SHOWN_M * 1e3),
        below: format!(
            "pressed without friction; a full slide bears {:.3} for the tilt of the pushes",
            tilted(SHOWN_M / RADIUS_M)
        ),
        axes: ["length of the drag over that at which all slips (1)", "force along the surface over mu N (1)"].map(Into::into),
        curves,
    };
    Ok((row, picture))
}

/// Runs comparison T5, a drag with friction.
pub(super) fn run() -> Result<Outcome, Error> {
    let (row, picture) = ball()?;
    Ok(Outcome { rows: vec![row, shipped::flat()?, shipped::glued()?, shipped::held()?], pictures: vec![picture] })
}
