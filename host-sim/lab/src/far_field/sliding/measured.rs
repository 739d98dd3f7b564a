//! Measurements of a method: its cost and its force errors at rest along the path, at every speed,
//! and at places that the fit did not use.

use rayon::prelude::*;
use serde::Serialize;

use super::run::{Awake, Figures, Slide, largest, slide};
use super::study_methods::{Kind, StudyMethod};
use super::trajectory::Trajectory;
use crate::error::Error;
use palpate_fit::calibrate::targets::Reference;
use palpate_fit::statics::{CLEAR_M, Solver, Statics, Unbalanced, Vector};
use palpate_tissue::Error as TissueError;
use palpate_tissue::budget::{CostModel, MACHINES, triangles_in_reach};

/// Spacing of the presses at rest along the path [m].
const SPACING_M: f64 = 5e-4;
/// Force error up to which a method counts as accurate [%].
pub const TOLERANCE_PCT: f64 = 5.0;
/// Step [mm/s] and number of the speeds at which the end of the tolerance is searched.
const SPEED_STEP_MM_PER_S: f64 = 10.0;
const SPEEDS_TRIED: usize = 50;
/// Additional slides: depth and sideways distance from the trajectory, both in units of its depth
/// (1).
const ELSEWHERE: [(f64, f64); 4] = [(1.0 / 3.0, 0.0), (2.0 / 3.0, 0.0), (4.0 / 3.0, 0.0), (1.0, 4.0 / 3.0)];

/// Estimated share of a millisecond that a tick takes on a board; see [`palpate_tissue::budget`].
/// Triangles are counted with four foundation points each.
#[derive(Clone, Debug, Serialize)]
pub struct BoardShare {
    /// Name of the machine.
    pub machine: &'static str,
    /// Unit in which the machine counts cost.
    pub unit: &'static str,
    /// Cost of the tick in these units.
    pub units: f64,
    /// Share of the millisecond [%].
    pub share_pct: f64,
}

/// A slide at a place or depth that the fit did not use.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Elsewhere {
    /// Depth of the slide below the rest surface [mm].
    pub depth_mm: f64,
    /// Sideways distance from the trajectory [mm].
    pub aside_mm: f64,
    /// Largest force error at the trajectory's speed, with its sign [%]; `None` after a fault.
    pub worst_pct: Option<f64>,
}

/// All measurements of a method.
#[derive(Clone, Debug, Serialize)]
pub struct Measured {
    /// Name of the method.
    pub name: String,
    /// Name in a legend.
    #[serde(skip)]
    pub short: String,
    /// Kind of method.
    pub kind: Kind,
    /// Number of nodes.
    pub nodes: usize,
    /// Number of springs.
    pub springs: usize,
    /// Number of tets.
    pub tets: usize,
    /// Numbers of rim nodes and rim edges.
    pub rim: [usize; 2],
    /// Substeps per tick.
    pub substeps: u16,
    /// Stable step of the method [ms].
    pub stable_ms: f64,
    /// Cost of the most expensive tick on each board.
    pub boards: Vec<BoardShare>,
    /// Largest error, with its sign, and root mean square error of the force at rest along the path
    /// [%]. `None` if nodes are frozen.
    pub rest_pct: Option<[f64; 2]>,
    /// Largest deviation of the force at rest from that with the dense condensed outside [%], which
    /// is the part of the error due to the rim springs. `None` for patches without a condensed
    /// outside.
    pub rim_pct: Option<f64>,
    /// Figures at every speed [mm/s]; `None` after a fault.
    pub slides: Vec<(f64, Option<Figures>)>,
    /// Lowest speed tried at which the force error exceeds the tolerance [mm/s]; `None` if no speed
    /// up to 500 mm/s does.
    pub leaves_at_mm_per_s: Option<f64>,
    /// Slides at other depths and beside the trajectory.
    pub elsewhere: Vec<Elsewhere>,
    /// Every tick of the slide at the trajectory's own speed.
    #[serde(skip)]
    pub trace: Slide,
}

impl Measured {
    /// Measures a method on a trajectory at every speed of `speeds_m_per_s`.
    ///
    /// # Errors
    /// Fails if the core rejects the model or the parameters, or if a press has no equilibrium.
    pub fn of(
        method: &StudyMethod,
        trajectory: &Trajectory,
        speeds_m_per_s: &[f64],
        reference: &impl Reference,
    ) -> Result<Self, Error> {
        let (patch, params) = (&method.patch, &method.params);
        let model = patch.model();
        let free = model.nodes.len() - model.anchors.len();
        let e = f64::from(params.youngs_modulus_pa);
        let run = |trajectory: &Trajectory| slide(patch, params, method.awake, trajectory);
        let figures = |trajectory: &Trajectory| Ok::<_, Error>(run(trajectory)?.figures(reference, e, free));
        let at = |speed_m_per_s: f64| Trajectory { speed_m_per_s, ..*trajectory };
        let slides = speeds_m_per_s.iter().map(|v| Ok((v * 1e3, figures(&at(*v))?))).collect::<Result<Vec<_>, Error>>()?;
        let mut leaves_at_mm_per_s = None;
        for n in 1..=SPEEDS_TRIED {
            let speed_mm_per_s = SPEED_STEP_MM_PER_S * n as f64;
            if figures(&at(speed_mm_per_s * 1e-3))?.is_none_or(|f| f.worst_pct.abs() > TOLERANCE_PCT) {
                leaves_at_mm_per_s = Some(speed_mm_per_s);
                break;
            }
        }
        let across = Vector::z().cross(&trajectory.direction());
        let elsewhere = ELSEWHERE.iter().map(|(deep, aside)| {
            let (depth_m, aside_m) = (deep * trajectory.depth_m, aside * trajectory.depth_m);
            let there = Trajectory { depth_m, centre_m: trajectory.centre_m + across * aside_m, ..*trajectory };
            let worst_pct = figures(&there)?.map(|f| f.worst_pct);
            Ok(Elsewhere { depth_mm: depth_m * 1e3, aside_mm: aside_m * 1e3, worst_pct })
        });
        let elsewhere = elsewhere.collect::<Result<Vec<_>, Error>>()?;
        let (mut rest_pct, mut rim_pct) = (None, None);
        if matches!(method.awake, Awake::All) {
            let statics = Statics::of(&model, params)?;
            let own = at_rest(&statics, trajectory).map_err(no_balance)?;
            let wanted: Vec<f64> = own
                .iter()
                .map(|(along, _)| reference.force(trajectory.place_m(*along), trajectory.depth_m))
                .collect::<Option<_>>()
                .unwrap_or_default();
            let errors: Vec<f64> = own.iter().zip(&wanted).map(|((_, f), w)| 100.0 * (f / w - 1.0)).collect();
            let rms = (errors.iter().map(|e| e * e).sum::<f64>() / errors.len().max(1) as f64).sqrt();
            rest_pct = Some([largest(&errors), rms]);
            if let Some(exact) = &method.exact {
                let exact = at_rest(exact, trajectory).map_err(no_balance)?;
                let off: Vec<f64> = own.iter().zip(&exact).map(|((_, f), (_, e))| 100.0 * (f / e - 1.0)).collect();
                rim_pct = Some(largest(&off));
            }
        }
        Ok(Self {
            name: method.name.clone(),
            short: method.short.clone(),
            kind: method.kind,
            nodes: model.nodes.len(),
            springs: model.springs.len(),
            tets: model.tets.len(),
            rim: [model.rim_nodes.len(), model.rim_edges.len()],
            substeps: params.substeps,
            stable_ms: method.stable_s * 1e3,
            boards: MACHINES.iter().map(|machine| board(machine, method, trajectory)).collect(),
            rest_pct,
            rim_pct,
            slides,
            leaves_at_mm_per_s,
            elsewhere,
            trace: run(trajectory)?,
        })
    }

    /// Figures of the slide at `speed_mm_per_s`.
    #[must_use]
    pub fn at(&self, speed_mm_per_s: f64) -> Option<&Figures> {
        self.slides.iter().find(|(v, _)| (v - speed_mm_per_s).abs() < 1e-6)?.1.as_ref()
    }
}

/// Equilibrium force along the path: (signed distance from the middle [m], force over E [m^2]).
fn at_rest(statics: &Statics, trajectory: &Trajectory) -> Result<Vec<(f64, f64)>, Unbalanced> {
    faer::set_global_parallelism(faer::Par::Seq);
    let solver = Solver::of(statics).ok_or(Unbalanced { depth_mm: 0.0, steps: 0 })?;
    let rest = solver.rest(statics, trajectory.centre_m, CLEAR_M)?;
    let half = (0.5 * trajectory.stroke_m.norm() / SPACING_M).round() as i32;
    (-half..=half)
        .into_par_iter()
        .map(|n| {
            let along_m = SPACING_M * f64::from(n);
            let place_m = trajectory.place_m(along_m);
            let above = rest.with_tip(place_m + statics.axis() * CLEAR_M);
            let there = solver.press(statics, &above, place_m - statics.axis() * trajectory.depth_m, trajectory.depth_m)?;
            Ok((along_m, there.force))
        })
        .collect()
}

fn no_balance(cause: Unbalanced) -> Error {
    Error::Tissue(TissueError::Check(format!("along the stroke: {cause}")))
}

fn board(machine: &CostModel, method: &StudyMethod, trajectory: &Trajectory) -> BoardShare {
    let model = method.patch.model();
    let half_m = 0.5 * trajectory.stroke_m.norm();
    let touched = [-1.0, -0.5, 0.0, 0.5, 1.0].map(|share| {
        let place_m = trajectory.place_m(share * half_m).cast::<f32>();
        triangles_in_reach(&model, place_m.into(), method.params.probe.reach_m())
    });
    let cost = machine.cost(&model, touched.into_iter().max().unwrap_or_default(), method.params.substeps);
    let share_pct = 100.0 * cost.units / cost.budget * machine.load;
    BoardShare { machine: machine.name, unit: machine.unit, units: cost.units, share_pct }
}
