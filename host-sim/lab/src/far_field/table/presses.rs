//! Presses of one patch: at the site to several depths, and at places around it.

use palpate::Params;
use rayon::prelude::*;
use serde::Serialize;

use crate::error::Error;
use palpate_fit::calibrate::reference_map::ReferenceMap;
use palpate_fit::calibrate::targets::Reference;
use palpate_fit::statics::{CLEAR_M, Solver, Statics, Vector};
use palpate_tissue::Error as TissueError;
use palpate_tissue::answer::Answer;
use palpate_tissue::scene::Scene;

/// Depths at the site [probe radii]: 1, 2, 4 and 8 mm under a radius of 8 mm.
pub const DEPTHS_RADII: [f64; DEPTHS] = [0.125, 0.25, 0.5, 1.0];
pub const DEPTHS: usize = 4;
/// Number of these depths, from the shallowest on, for which an error is promised.
pub const PROMISED_DEPTHS: usize = 3;
/// Depth of the presses beside the site [probe radii].
pub const ASIDE_DEPTH_RADII: f64 = 0.5;
/// Distances of these presses from the site [probe radii].
pub const ASIDE_RADII: [f64; ASIDES] = [0.5, 1.0];
pub const ASIDES: usize = 2;
/// Unit displacements of the glued disc: pressed along z and sheared along x.
const GLUED: [[f64; 3]; 2] = [[0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];

/// Scene and presses that all rows of the table share.
#[derive(Clone, Debug)]
pub struct Setting {
    /// Parameters of the scene.
    pub params: Params,
    /// Place of the centred presses [m].
    pub site_m: Vector,
    directions: usize,
    radius_m: f64,
    /// The finite-element answer of the scene, if it ships.
    answer: Option<Answer>,
}

/// Forces of all presses over E, along the probe's axis [m^2]; `None` where no equilibrium was
/// found.
#[derive(Clone, Debug, PartialEq)]
pub struct Presses {
    /// Forces at the site, by depth.
    pub centred: [Option<f64>; DEPTHS],
    /// Forces beside the site, by distance and direction.
    pub aside: [Vec<Option<f64>>; ASIDES],
    /// Stiffness over E of a disc of the probe's radius that is glued to the site, when it is
    /// pressed and when it is sheared [m].
    pub glued_m: [Option<f64>; 2],
}

/// Errors of the forces and of the disc's stiffness [%].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Errors {
    /// Errors at the site, by depth; `None` if one of the two forces is unknown.
    pub centred_pct: [Option<f64>; DEPTHS],
    /// Largest error over the directions, with its sign, by distance; `None` if a force is unknown
    /// in one of the directions.
    pub aside_pct: [Option<f64>; ASIDES],
    /// Errors of the stiffness of the glued disc, pressed and sheared.
    pub glued_pct: [Option<f64>; 2],
}

impl Errors {
    /// Errors of presses of which nothing is known.
    pub const NONE: Self = Self { centred_pct: [None; DEPTHS], aside_pct: [None; ASIDES], glued_pct: [None; 2] };
}

fn error_pct(found: Option<f64>, wanted: Option<f64>) -> Option<f64> {
    Some(100.0 * (found? / wanted? - 1.0))
}

impl Presses {
    /// Errors of these presses relative to `other` ones of the same setting.
    #[must_use]
    pub fn against(&self, other: &Self) -> Errors {
        let worst = |k: usize| -> Option<f64> {
            let errors: Option<Vec<f64>> = self.aside[k].iter().zip(&other.aside[k]).map(|(a, b)| error_pct(*a, *b)).collect();
            errors?.into_iter().reduce(|w, e| if e.abs() > w.abs() { e } else { w })
        };
        Errors {
            centred_pct: std::array::from_fn(|k| error_pct(self.centred[k], other.centred[k])),
            aside_pct: std::array::from_fn(worst),
            glued_pct: std::array::from_fn(|k| error_pct(self.glued_m[k], other.glued_m[k])),
        }
    }
}

impl Setting {
    /// Plans the presses of a scene with a block.
    ///
    /// # Errors
    /// The scene has no block.
    pub fn of(scene: &Scene, directions: usize) -> Result<Self, Error> {
        super::block_of(scene)?;
        let [x, y] = scene.probe.position_m.unwrap_or_default();
        let answer = Answer::block();
        let centred = [x, y] == [0.0, 0.0];
        Ok(Self {
            params: scene.params([0.0, 0.0, 1.0]),
            site_m: Vector::new(x, y, 0.0),
            directions,
            radius_m: scene.probe.radius_m,
            answer: (centred && answer.is_for(scene)).then_some(answer),
        })
    }

    /// Radius of the probe [m].
    #[must_use]
    pub fn radius_m(&self) -> f64 {
        self.radius_m
    }

    /// Depths at the site [m].
    #[must_use]
    pub fn depths_m(&self) -> [f64; DEPTHS] {
        DEPTHS_RADII.map(|d| d * self.radius_m())
    }

    /// Places around the site at a distance from it [m].
    fn around_m(&self, distance_m: f64) -> Vec<Vector> {
        let turn = std::f64::consts::TAU / self.directions.max(1) as f64;
        // the offset keeps every direction off the axes of the block
        let angle = |n: usize| turn * (n as f64 + 0.3);
        (0..self.directions).map(|n| self.site_m + Vector::new(angle(n).cos(), angle(n).sin(), 0.0) * distance_m).collect()
    }

    /// Forces over E of presses at `place_m` to the ascending depths `depths_m` [m^2].
    #[must_use]
    pub fn forces(statics: &Statics, solver: &Solver, place_m: Vector, depths_m: &[f64]) -> Vec<Option<f64>> {
        let mut here = solver.rest(statics, place_m, CLEAR_M).ok();
        let mut press = |depth_m: f64| {
            here = solver.press(statics, here.as_ref()?, place_m - statics.axis() * depth_m, depth_m).ok();
            here.as_ref().map(|balance| balance.force)
        };
        depths_m.iter().map(|d| press(*d)).collect()
    }

    /// Presses a patch at all places and depths.
    ///
    /// # Errors
    /// The mesh is too large to be analysed.
    pub fn press(&self, statics: &Statics) -> Result<Presses, Error> {
        faer::set_global_parallelism(faer::Par::Seq);
        let solver = solver(statics)?;
        let mut places = vec![(self.site_m, self.depths_m().to_vec())];
        for distance in ASIDE_RADII {
            let depth_m = ASIDE_DEPTH_RADII * self.radius_m();
            places.extend(self.around_m(distance * self.radius_m()).into_iter().map(|place| (place, vec![depth_m])));
        }
        let found: Vec<Vec<Option<f64>>> =
            places.par_iter().map(|(place, depths)| Self::forces(statics, &solver, *place, depths)).collect();
        let aside = |k: usize| found[1 + k * self.directions..][..self.directions].iter().map(|f| f[0]).collect();
        let glued = |direction: Vector| {
            let disc = solver.glued(statics, self.site_m, self.radius_m(), direction);
            disc.ok().map(|disc| disc.stiffness_m)
        };
        Ok(Presses {
            centred: std::array::from_fn(|k| found[0][k]),
            aside: std::array::from_fn(aside),
            glued_m: GLUED.map(|direction| glued(direction.into())),
        })
    }

    /// Presses of the finite-element answer; `None` if the scene has none.
    #[must_use]
    pub fn elements(&self) -> Option<Presses> {
        let map = ReferenceMap::of(self.answer.as_ref()?)?;
        let depth_m = ASIDE_DEPTH_RADII * self.radius_m();
        let aside = |k: usize| {
            let places = self.around_m(ASIDE_RADII[k] * self.radius_m());
            places.into_iter().map(|place| map.force(place - self.site_m, depth_m)).collect()
        };
        let centred = self.depths_m().map(|d| map.force(Vector::zeros(), d));
        let same = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-9);
        let glued = |direction: [f64; 3]| {
            let discs = self.answer.iter().flat_map(|a| &a.glued);
            let mut here = discs.filter(|d| same(d.place_m, [0.0; 3]) && (d.radius_m - self.radius_m()).abs() < 1e-9);
            here.find(|d| same(d.direction, direction)).map(|d| d.stiffness_over_e_m)
        };
        Some(Presses { centred, aside: std::array::from_fn(aside), glued_m: GLUED.map(glued) })
    }

    /// Errors relative to finite elements; `None` if the scene has no such answer.
    #[must_use]
    pub fn against_elements(&self, presses: &Presses) -> Option<Errors> {
        self.elements().map(|elements| presses.against(&elements))
    }
}

pub(super) fn solver(statics: &Statics) -> Result<Solver, Error> {
    Ok(Solver::of(statics).ok_or_else(|| TissueError::Check("the mesh is too large to be analysed: take fewer nodes".into()))?)
}
