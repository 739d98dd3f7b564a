//! The bump: the force that inclusions add to a press, computed by finite elements.
//!
//! Each place is pressed twice on one mesh, with and without the inclusions. The mesh affects both
//! forces almost equally, so their ratio is more accurate than either force.

use std::sync::atomic::{AtomicUsize, Ordering};

use faer::linalg::solvers::Solve;
use faer::{Mat, Side};
use nalgebra::Vector3;
use rayon::prelude::*;

use super::presses::{JUDGED_RADII, Level, UNSEEN_PLACES, UNSEEN_SEED};
use crate::calibrate::places::{random, sunflower};
use crate::reference::body::{Material, Stiffness};
use crate::reference::conform::conform;
use crate::reference::domain::{BlockBody, BlockCase};
use crate::reference::newton::Press;
use crate::reference::probe::RigidProbe;
use crate::reference::refine::refine;
use crate::reference::shape::TetRule;
use crate::solved::Solved;
use palpate_tissue::error::Error;
use palpate_tissue::mesh::{BlockSpec, TetMesh, block};
use palpate_tissue::scene::{Inclusion, Scene};

/// Number of corner nodes of the block's mesh before it is refined under the probe and in the
/// inclusions.
const BASE_NODES: usize = 120;
/// Maximum number of corner nodes of a mesh.
const MOST_NODES: usize = 6000;
/// Upper limit of the radius of the smallest contact [probe radii].
const LARGEST_RADII: f64 = 0.35;
/// Number of fitted places besides the centre, the same number with `--quick`, and the radius
/// around the centre over which they are spread [probe radii].
const KNOWN_PLACES: usize = 14;
const QUICK_PLACES: usize = 8;
pub(super) const KNOWN_RADII: f64 = 1.65;
/// Share of the force below which inclusions are not fitted (1).
const LEAST_FELT: f64 = 2e-3;
/// Number of terms with which the bump of each inclusion is interpolated between the places.
const TERMS: i32 = 3;
/// Weight of the ridge on each term, whereas the places have weights of one.
const RIDGE: f64 = 1e-6;
/// Number of places on the line along which the bump is evaluated and drawn. It is even, so that no
/// place is at the centre.
const LINE_PLACES: usize = 8;
/// Depths of the fit and of the evaluation, as shares of the deepest hold (1).
const FITTED: [f64; 3] = [0.25, 0.5, 1.0];
const UNSEEN: [f64; 2] = [0.375, 0.75];

/// Refinement of a mesh: longest edge, divided by the radius of the smallest contact and by that of
/// an inclusion, and growth of the edge per distance from either (1). As an example, a ball with a
/// radius of 4 mm, 10 mm below the surface and ten times as stiff, under a probe with R = 8 mm,
/// adds 8.97 % to the force at a depth of 3 mm if the edges in the ball are 1.1 of its radius, 8.65
/// % with 0.8, 8.51 % with 0.55, 8.38 % with 0.4, and 8.33 % with 0.3.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Edges {
    contact: f64,
    ball: f64,
    growth: f64,
}

const COARSE: Edges = Edges { contact: 1.4, ball: 0.9, growth: 0.9 };
const FINE: Edges = Edges { contact: 1.2, ball: 0.55, growth: 0.75 };
/// Refinement of the coarser and of the finer mesh with `--quick`.
const QUICK: [Edges; 2] = [Edges { contact: 2.0, ball: 1.4, growth: 1.2 }, Edges { contact: 1.4, ball: 1.0, growth: 1.0 }];

/// Ratios of the forces with the inclusions to those without them, at places and depths.
#[derive(Clone, Debug, PartialEq)]
pub struct Bumps {
    /// Places relative to the centre of the top [m]: the centre, further places for the fit, those
    /// on the line, and further places for the evaluation alone.
    pub places_m: Vec<[f64; 2]>,
    /// Number of places for the fit, including the centre.
    pub known_places: usize,
    /// Number of places on the line, which follow those for the fit. The line is along x and passes
    /// above the inclusion nearest to the centre.
    pub line_places: usize,
    /// Depths in ascending order [m].
    pub depths_m: Vec<f64>,
    /// Depths for the fit, a subset of `depths_m` [m].
    pub fitted_m: Vec<f64>,
    /// Force with the inclusions, divided by that without them (1), shape \[places\]\[depths\].
    pub ratio: Vec<Vec<f64>>,
    /// Root mean square deviation of the solved bumps from their interpolation, divided by the
    /// highest bump (1).
    pub scatter: f64,
    /// Coefficients of the interpolation between the places, shape \[depths\]\[inclusions x
    /// terms\].
    terms: Vec<Vec<f64>>,
    inclusions: Vec<Inclusion>,
    /// Estimated relative error of the bump near its maximum, the largest over all depths (1): the
    /// difference between the finer of two meshes and their extrapolated limit.
    pub error: f64,
}

/// Presses a block with and without its inclusions, unless an earlier run has done so. Calls
/// `progress` with the number of finished places and the total number.
///
/// # Errors
/// Fails if the block cannot be meshed, if there is no equilibrium at some depth, or if there is
/// not enough memory.
pub fn solve_bumps(
    scene: &Scene,
    deepest_m: f64,
    level: Level,
    solved: &Solved,
    progress: impl Fn(usize, usize) + Sync,
) -> Result<Bumps, Error> {
    let radius_m = scene.probe.radius_m;
    let (known, [coarser, finer]) = match level {
        Level::Full => (KNOWN_PLACES, [COARSE, FINE]),
        Level::Quick => (QUICK_PLACES, QUICK),
    };
    let mut places_m = vec![[0.0; 2]];
    places_m.extend(sunflower(known, KNOWN_RADII * radius_m));
    let over = above(&scene.tissue.inclusion);
    places_m.extend(line(JUDGED_RADII * radius_m, over[1]));
    places_m.extend(random(UNSEEN_PLACES, JUDGED_RADII * radius_m, UNSEEN_SEED));
    let fitted_m = FITTED.map(|share| share * deepest_m).to_vec();
    let mut depths_m: Vec<f64> = fitted_m.iter().copied().chain(UNSEEN.map(|share| share * deepest_m)).collect();
    depths_m.sort_by(f64::total_cmp);
    let size_m = scene.tissue.block_m.unwrap_or_default();
    let spec = BlockSpec { size_m, nodes: BASE_NODES, fine_at_m: [0.0; 2], fine_radius_m: radius_m };
    let mesh = block(&spec).map_err(|cause| Error::Usage(format!("{}: tissue.block_m: {cause}", scene.file)))?;
    let bench = Bench { scene, mesh, size_m, depths_m: &depths_m };
    // the place nearest to the maximum of the bump is solved on two meshes
    let away = |n: &usize| (0..2).map(|k| (places_m[*n][k] - over[k]).powi(2)).sum::<f64>();
    let highest = (0..places_m.len()).min_by(|a, b| away(a).total_cmp(&away(b))).unwrap_or(0);
    let tasks: Vec<([f64; 2], Edges)> =
        [(places_m[highest], finer)].into_iter().chain(places_m.iter().map(|place| (*place, coarser))).collect();
    let done = AtomicUsize::new(0);
    let one = |task: &([f64; 2], Edges)| -> Result<Vec<f64>, Error> {
        let found = solved.answer(&bench.problem(task), depths_m.len(), || bench.ratios(task.0, task.1))?;
        progress(done.fetch_add(1, Ordering::Relaxed) + 1, tasks.len());
        Ok(found)
    };
    // at most one place per core at a time, because a place takes seconds
    let mut ratio: Vec<Vec<f64>> = tasks.par_iter().with_max_len(1).map(one).collect::<Result<_, _>>()?;
    let fine = ratio.remove(0);
    let coarse = ratio.get(highest).cloned().unwrap_or_default();
    // the error is of second order in the edge length in the ball, because facets are chords
    let gain = (coarser.ball / finer.ball).powi(2) - 1.0;
    let changes = || fine.iter().zip(&coarse).map(|(f, c)| ((f - c) / gain, f - 1.0));
    let error = changes().map(|(change, bump)| (change / bump).abs()).fold(0.0, f64::max);
    // the two meshes give the error of the coarser one, which is almost the same at every place
    let share: Vec<f64> = changes().zip(&coarse).map(|((change, bump), c)| (bump + change) / (c - 1.0)).collect();
    for place in &mut ratio {
        place.iter_mut().zip(&share).for_each(|(own, share)| *own = 1.0 + (*own - 1.0) * share);
    }
    let most = ratio.iter().flatten().map(|ratio| (ratio - 1.0).abs()).fold(0.0, f64::max);
    if most.is_nan() || most < LEAST_FELT {
        let why = format!(
            "adds at most {:.3} % to any force within {:.1} mm of the centre: no finger feels it and no fit finds it, leave it out",
            100.0 * most,
            KNOWN_RADII * radius_m * 1e3
        );
        return Ok(scene.bad("tissue.inclusion", &why)?);
    }
    let bumps = Bumps {
        places_m,
        known_places: 1 + known,
        line_places: LINE_PLACES,
        depths_m,
        fitted_m,
        ratio,
        scatter: 0.0,
        terms: Vec::new(),
        inclusions: scene.tissue.inclusion.clone(),
        error,
    };
    bumps.between().ok_or_else(|| Error::Check(format!("{}: tissue.inclusion: its bump is not smooth", scene.file)))
}

impl Bumps {
    /// Returns the bumps with their interpolation: the sum over the inclusions of `c_k / (1 + (s /
    /// z)^2)^k`, where s is the distance from the point above an inclusion at the depth z. The
    /// force that a ball in a half-space adds on its surface has this form for every press.
    fn between(mut self) -> Option<Self> {
        let known = self.places_m.get(..self.known_places)?;
        let rows: Vec<Vec<f64>> = known.iter().map(|place| self.shapes(*place)).collect();
        let (places, depths) = (rows.len(), self.depths_m.len());
        let shapes = Mat::from_fn(places, rows.first()?.len(), |place, term| rows[place][term]);
        let bumps = Mat::from_fn(places, depths, |place, depth| self.ratio[place][depth] - 1.0);
        let mut normal = shapes.transpose() * &shapes;
        (0..normal.nrows()).for_each(|k| normal[(k, k)] += RIDGE);
        let factors = normal.llt(Side::Lower).ok()?.solve(shapes.transpose() * &bumps);
        let left = &shapes * &factors - &bumps;
        let share = |depth: usize| left.col(depth).squared_norm_l2() / bumps.col(depth).norm_max().powi(2);
        self.scatter = ((0..depths).map(share).sum::<f64>() / (places * depths) as f64).sqrt();
        self.terms = (0..depths).map(|depth| factors.col(depth).iter().copied().collect()).collect();
        Some(self)
    }

    fn shapes(&self, place_m: [f64; 2]) -> Vec<f64> {
        let of = |ball: &Inclusion| {
            let [x, y, z] = ball.center_m;
            let near = 1.0 / (1.0 + ((place_m[0] - x).powi(2) + (place_m[1] - y).powi(2)) / (z * z).max(ball.radius_m.powi(2)));
            (1..=TERMS).map(move |k| near.powi(k))
        };
        self.inclusions.iter().flat_map(of).collect()
    }

    /// Force with the inclusions divided by that without them (1), at any place and depth: linear
    /// between the solved depths and constant beyond them.
    #[must_use]
    pub fn ratio_between(&self, place_m: [f64; 2], depth_m: f64) -> Option<f64> {
        let shapes = self.shapes(place_m);
        let at = |n: usize| Some(1.0 + self.terms.get(n)?.iter().zip(&shapes).map(|(c, shape)| c * shape).sum::<f64>());
        let above = self.depths_m.partition_point(|own| *own < depth_m);
        let (Some(low), Some(high)) = (above.checked_sub(1), self.depths_m.get(above)) else {
            return at(above.min(self.depths_m.len() - 1));
        };
        let share = (depth_m - self.depths_m[low]) / (high - self.depths_m[low]);
        Some(at(low)? * (1.0 - share) + at(above)? * share)
    }

    /// Force with the inclusions divided by that without them (1), at a place and a depth that were
    /// solved.
    #[must_use]
    pub fn ratio(&self, place_m: [f64; 2], depth_m: f64) -> Option<f64> {
        let place = self.places_m.iter().position(|own| *own == place_m)?;
        let depth = self.depths_m.iter().position(|own| *own == depth_m)?;
        self.ratio.get(place)?.get(depth).copied()
    }

    /// Places for the evaluation alone, including those on the line [m].
    #[must_use]
    pub fn unseen_m(&self) -> &[[f64; 2]] {
        self.places_m.get(self.known_places..).unwrap_or_default()
    }

    /// Places on the line [m], in the order of increasing x.
    #[must_use]
    pub fn line_m(&self) -> &[[f64; 2]] {
        self.unseen_m().get(..self.line_places).unwrap_or_default()
    }
}

/// Place on the top above the inclusion that is nearest to the centre [m].
fn above(balls: &[Inclusion]) -> [f64; 2] {
    let away = |ball: &&Inclusion| ball.center_m[0].hypot(ball.center_m[1]);
    balls.iter().min_by(|a, b| away(a).total_cmp(&away(b))).map_or([0.0; 2], |ball| [ball.center_m[0], ball.center_m[1]])
}

/// Places along x across a disc, at `y_m` or, if that is too far out, where about 70 % of the
/// diameter is left [m].
fn line(radius_m: f64, y_m: f64) -> Vec<[f64; 2]> {
    let y_m = y_m.clamp(-0.7 * radius_m, 0.7 * radius_m);
    let half_m = (radius_m * radius_m - y_m * y_m).sqrt();
    let last = (LINE_PLACES - 1) as f64;
    (0..LINE_PLACES).map(|n| [half_m * (2.0 * n as f64 / last - 1.0), y_m]).collect()
}

/// Inputs that are common to all presses.
struct Bench<'a> {
    scene: &'a Scene,
    mesh: TetMesh,
    size_m: [f64; 3],
    depths_m: &'a [f64],
}

impl Bench<'_> {
    /// Text of all inputs on which the ratios depend.
    fn problem(&self, task: &([f64; 2], Edges)) -> String {
        let (tissue, probe) = (&self.scene.tissue, &self.scene.probe);
        let own = (tissue.block_m, tissue.poisson_ratio, &tissue.inclusion, probe.shape, probe.radius_m);
        format!("bump {own:?}\n{:?} {task:?}\n{:?}", self.depths_m, self.mesh)
    }

    fn ratios(&self, place_m: [f64; 2], edges: Edges) -> Result<Vec<f64>, Error> {
        let [x, y] = place_m;
        let place = Vector3::new(x, y, 0.0);
        let radius_m = self.scene.probe.radius_m;
        let smallest_m = (radius_m * self.depths_m[0]).sqrt().min(LARGEST_RADII * radius_m);
        let balls = &self.scene.tissue.inclusion;
        let longest_m = |at: [f64; 3]| {
            let away = |from: Vector3<f64>, of_m: f64| ((Vector3::from(at) - from).norm() - of_m).max(0.0);
            let contact_m = edges.contact * smallest_m + edges.growth * away(place, smallest_m);
            let ball_m = |ball: &Inclusion| edges.ball * ball.radius_m + edges.growth * away(ball.center_m.into(), ball.radius_m);
            balls.iter().map(ball_m).fold(contact_m, f64::min)
        };
        let mesh = refine(&self.mesh, longest_m, MOST_NODES);
        let (mesh, ratio) = conform(&mesh, balls);
        let [without, with] = [false, true].map(|with| self.body(&mesh, place_m, |tet| if with { ratio[tet] } else { 1.0 }));
        let (mut plain, mut stiff) = (self.press(&without)?, self.press(&with)?);
        let mut ratios = Vec::with_capacity(self.depths_m.len());
        for depth_m in self.depths_m {
            let forces = [&mut plain, &mut stiff].map(|press| {
                press.go_to(*depth_m, |_| {}).map(|()| press.force_over_e_m2()).map_err(|stalled| {
                    Error::Usage(format!(
                        "{}: drive: at {place_m:?} m no equilibrium was found deeper than {:.5} m: press less deep",
                        self.scene.file, stalled.reached_m
                    ))
                })
            });
            let [plain_m2, stiff_m2] = forces;
            ratios.push(stiff_m2? / plain_m2?);
        }
        Ok(ratios)
    }

    fn body(&self, mesh: &TetMesh, place_m: [f64; 2], ratio: impl Fn(usize) -> f64) -> BlockBody {
        let poisson_ratio = self.scene.tissue.poisson_ratio;
        let case = BlockCase {
            size_m: self.size_m,
            place_m,
            material: Material { poisson_ratio, stiffening_b: 0.0, inclusions: Vec::new() },
            nodes: mesh.nodes_m.len(),
            fine_radius_m: 0.0,
            rule: TetRule::Four,
            may_cut: [false; 2],
        };
        case.support_with(mesh, [false; 2], |tet, _| Stiffness { ratio: ratio(tet), poisson_ratio, stiffening_b: 0.0 })
    }

    fn press<'b>(&self, built: &'b BlockBody) -> Result<Press<'b>, Error> {
        let probe = RigidProbe::new(self.scene.probe.shape, self.scene.probe.radius_m, built.place_m, Vector3::z());
        Press::new(&built.body, probe, built.place_m)
            .ok_or_else(|| Error::Usage(format!("{}: not enough memory for the finite elements: use --quick", self.scene.file)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn bumps(ratio: impl Fn([f64; 2], f64) -> f64) -> Bumps {
        let ball = |x: f64| Inclusion { center_m: [x, 0.001, -0.01], radius_m: 0.004, stiffness_ratio: 10.0, stiffening_b: None };
        let mut places_m = vec![[0.0; 2]];
        places_m.extend(sunflower(KNOWN_PLACES, 0.0132));
        let known_places = places_m.len();
        places_m.extend(line(0.012, 0.001));
        let depths_m = vec![0.001, 0.002, 0.004];
        let of = |place: &[f64; 2]| depths_m.iter().map(|depth| ratio(*place, *depth)).collect();
        let ratio = places_m.iter().map(of).collect();
        let inclusions = vec![ball(-0.004), ball(0.006)];
        let bumps = Bumps {
            known_places,
            line_places: LINE_PLACES,
            fitted_m: vec![0.001, 0.004],
            places_m,
            depths_m,
            ratio,
            scatter: 0.0,
            terms: Vec::new(),
            inclusions,
            error: 0.0,
        };
        bumps.between().unwrap()
    }

    /// Force as in Boussinesq's solution above two balls; it is larger for a deeper press.
    fn smooth([x, y]: [f64; 2], depth_m: f64) -> f64 {
        let near = |at: f64, z: f64| (1.0 + ((x - at).powi(2) + (y - 0.001).powi(2)) / (z * z)).powf(-1.5);
        1.0 + depth_m.sqrt() * (1.2 * near(-0.004, 0.010) + 0.5 * near(0.006, 0.011))
    }

    #[test]
    fn between_solved_places_and_depths_the_bump_is_smooth() {
        let bumps = bumps(smooth);
        let highest = smooth([-0.003, 0.001], 0.004) - 1.0;
        assert!(bumps.scatter < 0.01, "{}", bumps.scatter);
        for place in random(50, 0.012, 3) {
            for depth_m in [0.001, 0.002, 0.004] {
                let off = (bumps.ratio_between(place, depth_m).unwrap() - smooth(place, depth_m)) / highest;
                assert!(off.abs() < 0.02, "{place:?} {depth_m} {off}");
            }
            let [low, middle, high] = [0.002, 0.003, 0.004].map(|depth_m| bumps.ratio_between(place, depth_m).unwrap());
            assert!((middle - 0.5 * (low + high)).abs() < 1e-12);
            assert_eq!(bumps.ratio_between(place, 0.0001), bumps.ratio_between(place, 0.001));
            assert_eq!(bumps.ratio_between(place, 0.01), bumps.ratio_between(place, 0.004));
        }
    }

    #[test]
    fn scatter_tells_bumps_that_are_not_smooth() {
        let rough = bumps(|place, depth_m| smooth(place, depth_m) + 0.01 * (place[0] * 3e4).sin());
        assert!(rough.scatter > 0.05, "{}", rough.scatter);
    }

    #[test]
    fn the_line_crosses_the_disc_and_is_unseen() {
        let bumps = bumps(smooth);
        let line = bumps.line_m();
        assert_eq!(line.len(), LINE_PLACES);
        assert!(line.is_sorted_by(|a, b| a[0] < b[0]) && line.iter().all(|p| p[0].hypot(p[1]) < 0.012 + 1e-9));
        assert!(line.iter().all(|p| !bumps.places_m[..bumps.known_places].contains(p)));
        assert_eq!(bumps.ratio(line[2], 0.002), Some(smooth(line[2], 0.002)));
        assert_eq!(bumps.ratio(line[2], 0.003), None);
    }
}
