//! T4: a ball that is pressed into tissue which relaxes, held, and withdrawn, compared with the
//! closed forms of a linear viscoelastic body: Lee and Radok's for loading and hold, Ting's for the
//! retreat.
//!
//! Both forms take the force of the *elastic* body during loading as input, and are valid for any
//! body. They are therefore used twice: with the elastic patch's own force, which tests relaxation
//! alone, and with Hertz's force, which tests contact and relaxation together; in the second case
//! the modulus of the half-space is the only fitted number. The depth at which the ball loses
//! contact does not depend on any force.

use palpate::{MOST_TERMS, Params, PronyTerm};
use palpate_fit::half_space::HalfSpace;
use palpate_tissue::patch::Memory;
use palpate_tissue::scene::TICK_S;
use rayon::prelude::*;

use super::bench::{Bench, RADIUS_M, Run};
use super::{Curve, Figure, Outcome, Picture, Row};
use crate::Error;

const SOURCE: &str = "host-sim/fit/src/half_space.rs (Lee and Radok 1960, Ting 1966; Popov, Willert, Hess 2018)";
/// Two Prony terms like those of meat, after Iaquinta et al.
const TERMS: [PronyTerm; MOST_TERMS] =
    [PronyTerm { share: 0.26, time_s: 0.4 }, PronyTerm { share: 0.31, time_s: 4.4 }, PronyTerm::NONE];
/// Depths of the presses [m]: an eighth and a quarter of the radius.
const DEPTHS_M: [f64; 2] = [2e-3, 4e-3];
/// Number of ticks of loading, hold and retreat, and of the motion above the surface afterwards.
const LOADING: usize = 1000;
const HELD: usize = 2000;
const LEAVING: usize = 2000;
const ABOVE: usize = 40;
/// Largest accepted difference from a closed form during loading and hold, divided by the largest
/// force, and during the retreat, divided by the force at the end of the hold (1).
const MOST: f64 = 0.02;
/// Accepted range of the depth at which contact ends, divided by Ting's (1).
const LIFTS_OFF: [f64; 2] = [0.95, 1.05];
/// Spacing of the compared ticks.
const EVERY: usize = 20;

/// Depth of the tip in every tick of a press to `depth_m` [m].
fn motion(depth_m: f64) -> Vec<f64> {
    let way_in = (0..=LOADING).map(|n| depth_m * n as f64 / LOADING as f64);
    let way_out = (1..=LEAVING + ABOVE).map(|n| depth_m * (1.0 - n as f64 / LEAVING as f64));
    way_in.chain(std::iter::repeat_n(depth_m, HELD)).chain(way_out).collect()
}

/// Force in every tick of the motion `depths_m` [N].
fn press(bench: &Bench, relaxation: [PronyTerm; MOST_TERMS], depths_m: &[f64]) -> Result<Vec<f64>, Error> {
    let model = bench.patch.wide_model();
    let mut memory = Memory::for_model(&model);
    let mut run = Run::start(&model, &Params { relaxation, ..bench.params }, &mut memory)?;
    depths_m.iter().map(|depth_m| Ok(f64::from(run.at([0.0; 2], *depth_m)?.force_n.z))).collect()
}

/// Closed form of a viscoelastic body, from its elastic force in every tick.
struct Expected<'a> {
    space: &'a HalfSpace,
    depths_m: &'a [f64],
    elastic_n: Vec<f64>,
}

impl Expected<'_> {
    fn at(&self, tick: usize) -> f64 {
        let past = &self.elastic_n[..=tick];
        if tick <= LOADING + HELD {
            self.space.loaded_n(past, TICK_S)
        } else {
            self.space.retreating_n(past, &self.depths_m[..=tick], TICK_S)
        }
    }

    /// Largest difference from the closed form during loading and hold, divided by the largest
    /// force (1).
    fn off(&self, found_n: &[f64]) -> f64 {
        let ticks = (EVERY..=LOADING + HELD).step_by(EVERY);
        let (largest, off) = ticks.fold((0.0_f64, 0.0_f64), |(largest, off), tick| {
            let right_n = self.at(tick);
            (largest.max(right_n), off.max((found_n[tick] - right_n).abs()))
        });
        off / largest
    }

    /// Root mean square difference from the closed form during the retreat, divided by the force at
    /// the end of the hold (1).
    fn out(&self, found_n: &[f64]) -> f64 {
        let ticks = (LOADING + HELD + EVERY..found_n.len()).step_by(EVERY);
        let squares: Vec<f64> = ticks.map(|tick| (found_n[tick] - self.at(tick)).powi(2)).collect();
        (squares.iter().sum::<f64>() / squares.len() as f64).sqrt() / self.at(LOADING + HELD)
    }
}

/// Depth at which the force vanishes during the retreat [m].
fn lost_m(depths_m: &[f64], force_n: &[f64]) -> f64 {
    let ticks = LOADING + HELD..depths_m.len();
    ticks.into_iter().find(|tick| force_n[*tick] == 0.0).map_or(f64::NAN, |tick| depths_m[tick])
}

/// Compares a press to `depth_m` with the closed forms; returns its row and its picture.
fn compare(params: &Params, depth_m: f64, elastic_n: &[f64], ours_n: &[f64]) -> (Row, Picture) {
    let depths_m = motion(depth_m);
    let nu = f64::from(params.poisson_ratio);
    let youngs_pa = f64::from(params.youngs_modulus_pa);
    let terms = TERMS.iter().filter(|term| term.share > 0.0).map(|t| (f64::from(t.share), f64::from(t.time_s)));
    let mut space = HalfSpace { radius_m: RADIUS_M, plane_modulus_pa: youngs_pa / (1.0 - nu * nu), terms: terms.collect() };
    let fitted = elastic_n[LOADING] / space.hertz_n(depth_m);
    space.plane_modulus_pa *= fitted;
    let own = Expected { space: &space, depths_m: &depths_m, elastic_n: elastic_n.to_vec() };
    let hertz_n = depths_m.iter().map(|d| space.hertz_n(*d)).collect();
    let hertz = Expected { space: &space, depths_m: &depths_m, elastic_n: hertz_n };
    let lifts_off_m = space.lifts_off_m(&depths_m, TICK_S).unwrap_or(f64::NAN);
    let figure = |what: &str, accepted: [f64; 2], of: &dyn Fn(&[f64]) -> f64| Figure {
        what: what.into(),
        accepted,
        ours: of(ours_n),
        without_term: of(elastic_n),
    };
    let row = Row {
        test: "T4".into(),
        data: format!("closed forms, ball of {} mm, {} mm deep", RADIUS_M * 1e3, depth_m * 1e3),
        source: SOURCE.into(),
        term: "relaxation".into(),
        fitted: format!("the half-space's modulus, to the elastic patch: {fitted:.3} of its own"),
        predicted: "loading of 1 s, hold of 2 s, way out of 2 s, and where contact ends".into(),
        figures: vec![
            figure("in and held, off own elastic relaxed", [0.0, MOST], &|f| own.off(f)),
            figure("in and held, off Hertz relaxed", [0.0, MOST], &|f| hertz.off(f)),
            figure("way out, off Ting (own elastic), rms", [0.0, MOST], &|f| own.out(f)),
            figure("depth of lift-off over Ting's", LIFTS_OFF, &|f| lost_m(&depths_m, f) / lifts_off_m),
        ],
    };
    let curve = |name: &str, force_n: &dyn Fn(usize) -> f64, measured: bool, every: usize| Curve {
        name: name.into(),
        points: (0..depths_m.len()).step_by(every).map(|n| (n as f64 * TICK_S, force_n(n))).collect(),
        measured,
    };
    let picture = Picture {
        name: format!("relaxation_{}_mm", depth_m * 1e3),
        title: format!("ball of {} mm, {} mm deep: in, held and out", RADIUS_M * 1e3, depth_m * 1e3),
        below: format!(
            "contact ends {:.3} mm deep, {:.3} mm by Ting, {:.3} mm without relaxation",
            lost_m(&depths_m, ours_n) * 1e3,
            lifts_off_m * 1e3,
            lost_m(&depths_m, elastic_n).max(0.0) * 1e3
        ),
        axes: ["time [s]", "force [N]"].map(Into::into),
        curves: vec![
            curve("Lee and Radok, Ting (Hertz)", &|n| hertz.at(n), true, 10 * EVERY),
            curve("ours", &|n| ours_n[n], false, EVERY),
            curve("ours without relaxation", &|n| elastic_n[n], false, EVERY),
        ],
    };
    (row, picture)
}

/// Runs comparison T4, a press that retreats.
pub(super) fn run() -> Result<Outcome, Error> {
    let bench = Bench::large()?;
    let cases: Vec<_> = DEPTHS_M.iter().flat_map(|d| [(*d, [PronyTerm::NONE; MOST_TERMS]), (*d, TERMS)]).collect();
    let forces_n: Vec<Vec<f64>> =
        cases.par_iter().map(|(depth_m, terms)| press(&bench, *terms, &motion(*depth_m))).collect::<Result<_, _>>()?;
    let pairs = DEPTHS_M.iter().zip(forces_n.chunks_exact(2));
    let (rows, pictures) = pairs.map(|(depth_m, pair)| compare(&bench.params, *depth_m, &pair[0], &pair[1])).unzip();
    Ok(Outcome { rows, pictures })
}
