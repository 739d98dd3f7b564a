//! Every method under every force, from load to rest; Fig. 8 shows the depths and Fig. 9 the times.

use crate::paper_method::region::{ContactPressure, StressRule};
use palpate::Vector3;

use super::methods::{Fitted, StudyMethod};
use super::truth::Truth;
use crate::error::Error;
use crate::methods::{Block, Method};
use palpate_tissue::Error as TissueError;

/// Name of the static reference in tables.
pub const STATIC: &str = "fem-static";
/// CPU time beyond which a press is not timed again [s].
const LONG_S: f64 = 0.2;
/// Number of times that a shorter press is timed.
const RUNS: usize = 3;
/// Damping of the masses of all methods except "d alone" [1/s].
pub const NODE_DAMPING_PER_S: f64 = 40.0;
/// Largest accepted relative change of the depth when nodes are frozen (1).
const REGION_ERROR: f64 = 0.02;
/// Thresholds that are tried, as shares of the force over the cross-section of the finger (1).
const THRESHOLDS: [f64; 8] = [0.3, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002];

/// A press that has come to rest.
#[derive(Clone, Debug)]
pub struct Point {
    /// Requested force [N].
    pub force_n: f64,
    /// Depth of the tip [m].
    pub depth_m: f64,
    /// Virtual time to rest [s]; the static method has none.
    pub virtual_s: Option<f64>,
    /// CPU time to rest [s].
    pub cpu_s: f64,
    /// Node positions [m], shape \[nodes\].
    pub position_m: Vec<Vector3<f64>>,
}

/// A method under ascending forces.
#[derive(Clone, Debug)]
pub struct Curve {
    /// Name of the method.
    pub name: &'static str,
    /// Step of the method [s].
    pub step_s: Option<f64>,
    /// Presses that came to rest.
    pub points: Vec<Point>,
    /// Reason why the press under the next force did not; `None` if there is no further force.
    pub ended: Option<String>,
}

impl Curve {
    /// A method without presses.
    pub fn empty(name: &'static str) -> Self {
        Self { name, step_s: None, points: Vec::new(), ended: None }
    }

    /// The press under a requested force; `None` if it did not come to rest.
    pub fn at(&self, force_n: f64) -> Option<&Point> {
        self.points.iter().find(|p| (p.force_n - force_n).abs() < 1e-9)
    }

    /// Root mean square of the relative deviation in depth from `truth` (1), over the forces that
    /// both curves have, and the number of these forces; `None` if there are none.
    pub fn depth_error(&self, truth: &Self) -> Option<(f64, usize)> {
        let both = self.points.iter().filter_map(|p| truth.at(p.force_n).map(|t| p.depth_m / t.depth_m - 1.0));
        let errors: Vec<f64> = both.collect();
        let mean = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
        (!errors.is_empty()).then(|| (mean.sqrt(), errors.len()))
    }
}

/// The methods of Figs. 8 and 9, including the product.
pub fn study_methods(fitted: Fitted) -> Vec<StudyMethod> {
    let charted = [Method::Springs, Method::Meshless, Method::NeoHookeanNodal, Method::Palpate, Method::Calibrated];
    let with_masses = Fitted { node_damping_per_s: NODE_DAMPING_PER_S, ..fitted };
    [fitted, with_masses].into_iter().map(StudyMethod::LocalCompression).chain(charted.map(StudyMethod::Charted)).collect()
}

/// The stress rule with the highest threshold of (7) that changes the depth under a force by at
/// most 2 %; `None` if no threshold tried does.
pub fn region_for(block: &Block, fitted: Fitted, step_s: f64, force_n: f64) -> Result<Option<StressRule>, Error> {
    let press = |region| StudyMethod::LocalCompression(Fitted { region, ..fitted }).press(block, step_s, force_n, 1);
    let Some(Ok(all)) = press(None)? else { return Ok(None) };
    let radius_m = f64::from(block.params.probe.radius_m);
    let mean_pa = force_n / (std::f64::consts::PI * radius_m * radius_m);
    for share in THRESHOLDS {
        let rule = StressRule::new((share * mean_pa) as f32, block.params.poisson_ratio, ContactPressure::UniformLoad);
        if let Some(Ok(some)) = press(Some(rule))?
            && (some.depth_m / all.depth_m - 1.0).abs() <= REGION_ERROR
        {
            return Ok(Some(rule));
        }
    }
    Ok(None)
}

/// Measures one method under every force, up to the first under which it does not come to rest.
/// `None` if it is not available.
pub fn curve(method: &StudyMethod, block: &Block, forces_n: &[f64]) -> Result<Option<Curve>, Error> {
    let (mut step_s, mut why) = (None, None);
    for &force_n in forces_n.iter().rev() {
        match method.step_s(block, force_n)? {
            None => return Ok(None),
            Some(Ok(found)) => {
                step_s = Some(found);
                break;
            }
            Some(Err(failure)) => why = Some(format!("{failure} under {force_n} N")),
        }
    }
    let Some(step_s) = step_s else {
        return Ok(Some(Curve { ended: why, ..Curve::empty(method.name()) }));
    };
    let mut curve = Curve { step_s: Some(step_s), ..Curve::empty(method.name()) };
    for &force_n in forces_n {
        let mut found = method.press(block, step_s, force_n, 1)?;
        if let Some(Ok(rest)) = &mut found
            && rest.cpu_s < LONG_S
            && let Some(Ok(again)) = method.press(block, step_s, force_n, RUNS - 1)?
        {
            rest.cpu_s = rest.cpu_s.min(again.cpu_s);
        }
        match found {
            Some(Ok(rest)) => curve.points.push(Point {
                force_n,
                depth_m: rest.depth_m,
                virtual_s: Some(rest.virtual_s),
                cpu_s: rest.cpu_s,
                position_m: rest.position_m,
            }),
            Some(Err(why)) => {
                curve.ended = Some(format!("{why} under {force_n} N"));
                break;
            }
            None => break,
        }
    }
    Ok(Some(curve))
}

/// The static reference on the same mesh, on one thread. Its time for a force includes that of all
/// smaller forces, through which it steps anyway.
pub fn static_curve(truth: &Truth, forces_n: &[f64]) -> Result<Curve, Error> {
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    let one =
        one.map_err(|why| TissueError::Usage(format!("no thread for the finite-element reference: {why}: end other programs")))?;
    let held = one.install(|| truth.press(forces_n, |_| ()))?;
    let reached = held.len();
    let points = held.into_iter().zip(forces_n).map(|(held, &force_n)| Point {
        force_n,
        depth_m: held.depth_m,
        virtual_s: None,
        cpu_s: held.cpu_s,
        position_m: held.position_m,
    });
    let points: Vec<Point> = points.collect();
    let ended = forces_n.get(reached).map(|f| format!("no equilibrium found under {f} N"));
    Ok(Curve { name: STATIC, step_s: None, points, ended })
}
