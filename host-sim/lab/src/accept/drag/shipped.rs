//! The shipped patches under a probe that slides, under one that sticks, and under one that is held
//! under a sideways force for a minute.

use super::{Answer, Bench, Error, FRICTION, Figure, Memory, Params, ProbeShape, Row, Run, SLIDES, parts};
use rayon::prelude::*;

/// Number of nodes of the patch on which the probe slides or is held, and of those on which it
/// sticks.
const NODES: usize = 410;
const STUCK_NODES: [usize; 3] = [130, 410, 1020];
/// Number of ticks of a press and of the pause after it.
const PRESSED: usize = 1500;
/// Depth of a flat end [m], so small that its edge does not dig in.
const FLAT_M: f64 = 2e-4;
/// Displacement per tick of a slide [m], and its number of ticks.
const SLIDE_M: f64 = 2e-6;
const SLIDE: usize = 1500;
/// Displacement per tick of a sticking probe [m], number of ticks of that motion, and number of
/// ticks with the pause after it.
const STICK_M: f64 = 2e-7;
const STICK: usize = 100;
const STUCK: usize = 1000;
/// Friction coefficient so high that nothing slips (1).
const STICKS: f32 = 5.0;
/// Accepted range of the sticking probe's stiffness, divided by that of the glued disc (1).
const GLUED: [f64; 2] = [0.97, 1.03];
/// Headings over which the stiffness is averaged [rad], since the mesh is not isotropic.
const HEADINGS: [f64; 3] = [0.0, 0.8, 2.1];
/// A hold: its depth [m], the pull divided by the friction limit (1), the number of ticks until it
/// has settled, and the number of ticks for which it is then observed.
const HOLD_M: f64 = 2e-3;
const PULL: f64 = 0.9;
const SETTLED: usize = 5000;
const HELD: usize = 60_000;
/// Damping of the massless handle to which the pull is applied [N s/m].
const HANDLE_N_S_PER_M: f64 = 1.0;
/// Displacement beyond which a probe counts as lost [m].
const LOST_M: f64 = 2e-3;
/// Largest accepted creep in a minute [um].
const CREEPS_UM: f64 = 1.0;

/// Presses from above the surface and waits; returns the force along the surface and the normal
/// force [N].
fn pressed(run: &mut Run, depth_m: f64, turned: f64) -> Result<[f64; 2], Error> {
    let mut last = [0.0; 2];
    for n in 0..PRESSED {
        last = parts(&run.at([0.0; 2], (-1e-3 + 2e-5 * n as f64).min(depth_m))?, turned);
    }
    Ok(last)
}

/// Force along the surface in the full slide of a flat end, divided by the normal force (1).
fn slides(friction: f64) -> Result<f64, Error> {
    let bench = Bench::shipped(NODES, ProbeShape::Flat)?;
    let model = bench.patch.wide_model();
    let mut memory = Memory::for_model(&model);
    let mut run = Run::start(&model, &Params { friction: friction as f32, ..bench.params }, &mut memory)?;
    let mut last = pressed(&mut run, FLAT_M, 0.0)?;
    for n in 1..=SLIDE {
        last = parts(&run.at([SLIDE_M * n as f64, 0.0], FLAT_M)?, 0.0);
    }
    Ok(last[0] / last[1])
}

/// Row of the flat end that slides.
pub(super) fn flat() -> Result<Row, Error> {
    let without = slides(0.0)?;
    let figure = |friction: &f64| -> Result<Figure, Error> {
        Ok(Figure {
            what: format!("full slip, mu {friction}: over mu N"),
            accepted: SLIDES,
            ours: slides(*friction)? / friction,
            without_term: without / friction,
        })
    };
    Ok(Row {
        test: "T5".into(),
        data: format!("Coulomb, flat end of 8 mm, shipped patch of {NODES} nodes"),
        source: "Coulomb's law".into(),
        term: "friction".into(),
        fitted: "nothing".into(),
        predicted: "force along the surface over the push, 3 mm from where it was pressed".into(),
        figures: FRICTION.par_iter().map(figure).collect::<Result<_, Error>>()?,
    })
}

/// Stiffness along the surface under a flat end, divided by that of the glued disc (1).
fn stuck(nodes: usize, friction: f32) -> Result<f64, Error> {
    let bench = Bench::shipped(nodes, ProbeShape::Flat)?;
    let answer = Answer::block();
    let glued = answer.glued.iter().find(|g| g.place_m == [0.0; 3] && g.direction == [1.0, 0.0, 0.0]);
    let right = glued.map_or(f64::NAN, |g| g.stiffness_over_e_m) * f64::from(bench.params.youngs_modulus_pa);
    let model = bench.patch.wide_model();
    let of = |turned: f64| {
        let mut memory = Memory::for_model(&model);
        let mut run = Run::start(&model, &Params { friction, ..bench.params }, &mut memory)?;
        let before = pressed(&mut run, FLAT_M, turned)?;
        let mut last = before;
        for n in 1..=STUCK {
            let way_m = STICK_M * n.min(STICK) as f64;
            last = parts(&run.at([way_m * turned.cos(), way_m * turned.sin()], FLAT_M)?, turned);
        }
        Ok((last[0] - before[0]) / (STICK_M * STICK as f64))
    };
    let stiffness = HEADINGS.map(of).into_iter().collect::<Result<Vec<f64>, Error>>()?;
    Ok(stiffness.iter().sum::<f64>() / stiffness.len() as f64 / right)
}

/// Row of the flat end that sticks.
pub(super) fn glued() -> Result<Row, Error> {
    let figure = |nodes: &usize| -> Result<Figure, Error> {
        Ok(Figure {
            what: format!("stuck, over glued disc, {nodes} nodes"),
            accepted: GLUED,
            ours: stuck(*nodes, STICKS)?,
            without_term: stuck(*nodes, 0.0)?,
        })
    };
    Ok(Row {
        test: "T5".into(),
        data: "finite elements, disc of 8 mm, shipped patches".into(),
        source: "host-sim/tissue/references/block.json (glued disc, own finite elements)".into(),
        term: "friction".into(),
        fitted: "nothing of friction (the patches to frictionless presses)".into(),
        predicted: "stiffness along the surface, mean of three headings".into(),
        figures: STUCK_NODES.par_iter().map(figure).collect::<Result<_, Error>>()?,
    })
}

/// Largest displacement of a ball in the minute after the first five seconds [um], under a sideways
/// pull of 0.9 `bears` times the normal force. A probe that friction does not hold is followed for
/// 2 mm only.
fn creeps_um(friction: f64, bears: f64) -> Result<f64, Error> {
    let bench = Bench::shipped(NODES, ProbeShape::Hemisphere)?;
    let model = bench.patch.wide_model();
    let mut memory = Memory::for_model(&model);
    let mut run = Run::start(&model, &Params { friction: friction as f32, ..bench.params }, &mut memory)?;
    let pull_n = PULL * bears * pressed(&mut run, HOLD_M, 0.0)?[1];
    let (mut x_m, mut last_n, mut settled_m, mut farthest_m) = (0.0, 0.0, 0.0, 0.0_f64);
    for n in 0..SETTLED + HELD {
        let pulled = (n as f64 * 1e-3).min(1.0);
        x_m += 1e-3 * (pull_n * pulled + last_n) / HANDLE_N_S_PER_M;
        last_n = f64::from(run.at([x_m, 0.0], HOLD_M)?.force_n.x);
        if n < SETTLED {
            settled_m = x_m;
        }
        farthest_m = farthest_m.max((x_m - settled_m).abs());
        if farthest_m > LOST_M {
            break;
        }
    }
    Ok(farthest_m * 1e6)
}

/// Row of the ball that is held under a sideways force.
pub(super) fn held() -> Result<Row, Error> {
    let figure = |friction: &f64| -> Result<Figure, Error> {
        Ok(Figure {
            what: format!("creep in a minute, mu {friction} [um]"),
            accepted: [0.0, CREEPS_UM],
            ours: creeps_um(*friction, *friction)?,
            without_term: creeps_um(0.0, *friction)?,
        })
    };
    Ok(Row {
        test: "T5".into(),
        data: format!("hold, ball of 8 mm, 2 mm deep, {NODES} nodes"),
        source: "a place that is held does not move".into(),
        term: "friction".into(),
        fitted: "nothing".into(),
        predicted: "way of a probe pulled aside with 0.9 of what friction bears".into(),
        figures: FRICTION.par_iter().map(figure).collect::<Result<_, Error>>()?,
    })
}
