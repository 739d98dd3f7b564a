//! The stored answers of the project: their contents, and how to recompute them.
//!
//! Forces of centred presses come from meshes as fine as the contact needs, with one mesh for every
//! range of depths. At a place away from the centre the symmetry that reduces the mesh is missing.
//! Therefore a coarser mesh, with the same fineness and symmetry at both places, gives only the
//! *ratio* to the force at the centre, in which the effect of the mesh cancels. The stored force is
//! this ratio times the fine centred force. Discs glued to the block are solved on the whole block.

use nalgebra::Vector3;

use super::body::{Material, Stiffness};
use super::domain::BlockCase;
use super::glued::{Disc, glued_stiffness};
use super::newton::Press;
use super::probe::RigidProbe;
use super::shape::TetRule;
use palpate_tissue::answer::{Answer, AnswerProbe, AnswerTissue, GluedAnswer, HoldAnswer};
use palpate_tissue::error::Error;
use palpate_tissue::mesh::{BlockSpec, block};
use palpate_tissue::scene::{Inclusion, Shape};

const BLOCK_M: [f64; 3] = [0.08, 0.08, 0.04];
const POISSON_RATIO: f64 = 0.45;
/// Spacing of the surface grid of a hold [m], and number of its points to each side of the centre.
const SPACING_M: f64 = 1e-3;
const HALF_COUNT: usize = 22;
/// Number of corner nodes of the block to which a disc is glued, before refinement, and the longest
/// element edges at the edge of the disc [disc radii].
const GLUED_NODES: usize = 300;
const GLUED_EDGES: [f64; 2] = [0.05, 0.025];

/// Contents of one stored file.
pub struct Shipped {
    /// Name of the file.
    pub file: &'static str,
    shape: Shape,
    radius_mm: f64,
    inclusion: &'static [Inclusion],
    centred: &'static [Batch],
    /// Depths of the holds whose surface grid is stored [mm].
    surfaces_mm: &'static [f64],
    moved: Option<Moved>,
    /// Centres of discs with the radius of the probe, each glued and moved along z and along x
    /// [mm].
    glued_mm: &'static [[f64; 2]],
}

/// Presses that are solved on one mesh.
struct Batch {
    depths_mm: &'static [f64],
    /// Number of corner nodes of the quarter block.
    nodes: usize,
    fine_radius_mm: f64,
}

/// Presses at places away from the centre with y = 0, solved on half a block.
struct Moved {
    places_mm: &'static [[f64; 2]],
    depths_mm: &'static [f64],
    /// Number of corner nodes of the half block.
    nodes: usize,
    fine_radius_mm: f64,
    /// Whether only the ratio to the centre is used, because the tissue is homogeneous.
    ratio: bool,
}

const NODULE: [Inclusion; 1] =
    [Inclusion { center_m: [0.0, 0.0, -0.012], radius_m: 0.006, stiffness_ratio: 10.0, stiffening_b: None }];

/// All stored answers.
pub const SHIPPED: [Shipped; 4] = [
    Shipped {
        file: "block.json",
        shape: Shape::Hemisphere,
        radius_mm: 8.0,
        inclusion: &[],
        centred: &[
            Batch { depths_mm: &[0.25, 0.5], nodes: 1600, fine_radius_mm: 2.5 },
            Batch { depths_mm: &[1.0, 1.5, 2.0], nodes: 1600, fine_radius_mm: 4.5 },
            Batch { depths_mm: &[3.0, 4.0, 5.0, 6.0, 8.0, 10.0], nodes: 1600, fine_radius_mm: 7.5 },
        ],
        surfaces_mm: &[0.5, 1.0, 2.0, 4.0, 8.0],
        moved: Some(Moved {
            places_mm: &[[4.0, 0.0], [8.0, 0.0], [12.0, 0.0], [16.0, 0.0]],
            depths_mm: &[0.5, 1.0, 2.0, 4.0, 6.0],
            nodes: 900,
            fine_radius_mm: 5.0,
            ratio: true,
        }),
        glued_mm: &[[0.0, 0.0], [9.0, 5.0]],
    },
    Shipped {
        file: "flat.json",
        shape: Shape::Flat,
        radius_mm: 8.0,
        inclusion: &[],
        centred: &[Batch { depths_mm: &[1.0, 2.0], nodes: 1200, fine_radius_mm: 9.0 }],
        surfaces_mm: &[],
        moved: None,
        glued_mm: &[],
    },
    Shipped {
        file: "sphere-5mm.json",
        shape: Shape::Sphere,
        radius_mm: 5.0,
        inclusion: &[],
        centred: &[
            Batch { depths_mm: &[0.5, 1.0], nodes: 900, fine_radius_mm: 3.0 },
            Batch { depths_mm: &[2.0, 3.0, 4.0], nodes: 900, fine_radius_mm: 5.0 },
        ],
        surfaces_mm: &[],
        moved: None,
        glued_mm: &[],
    },
    Shipped {
        file: "nodule.json",
        shape: Shape::Hemisphere,
        radius_mm: 8.0,
        inclusion: &NODULE,
        centred: &[Batch { depths_mm: &[2.0, 4.0], nodes: 1000, fine_radius_mm: 12.0 }],
        surfaces_mm: &[],
        moved: Some(Moved {
            places_mm: &[[3.0, 0.0], [6.0, 0.0], [9.0, 0.0], [12.0, 0.0]],
            depths_mm: &[2.0, 4.0],
            nodes: 900,
            fine_radius_mm: 12.0,
            ratio: false,
        }),
        glued_mm: &[],
    },
];

impl Shipped {
    /// Solves all presses and discs; calls `progress` with (place, depth) after every step, in
    /// metres.
    ///
    /// # Errors
    /// Fails if a mesh cannot be generated, or if a press does not converge.
    pub fn solve(&self, mut progress: impl FnMut([f64; 2], f64)) -> Result<Answer, Error> {
        let mut holds = Vec::new();
        for batch in self.centred {
            let case = self.case([0.0; 2], batch.nodes, batch.fine_radius_mm, [true; 2]);
            holds.extend(self.press(&case, batch.depths_mm, self.surfaces_mm, &mut progress)?);
        }
        if let Some(moved) = &self.moved {
            let centred = holds.clone();
            // presses to the same depths at the centre, on the coarser mesh
            let mut same = Vec::new();
            for place_mm in moved.places_mm {
                let place_m = place_mm.map(metres);
                let case = |place_m| self.case(place_m, moved.nodes, moved.fine_radius_mm, [false, true]);
                let mut solved = self.press(&case(place_m), moved.depths_mm, &[], &mut progress)?;
                if moved.ratio {
                    if same.is_empty() {
                        same = self.press(&case([0.0; 2]), moved.depths_mm, &[], &mut progress)?;
                    }
                    for (hold, same) in solved.iter_mut().zip(&same) {
                        let fine = centred.iter().find(|h| h.depth_m == hold.depth_m).map(|h| h.force_over_e_m2);
                        let Some(fine) = fine else {
                            return Err(Error::Usage(format!("{}: no centred press to {} m: list it", self.file, hold.depth_m)));
                        };
                        hold.force_over_e_m2 *= fine / same.force_over_e_m2;
                    }
                }
                holds.extend(solved);
            }
        }
        for hold in &mut holds {
            hold.force_over_e_m2 = rounded(hold.force_over_e_m2);
        }
        let glued = self.glued(&mut progress)?;
        let tissue = AnswerTissue {
            block_m: Some(BLOCK_M),
            mesh: None,
            poisson_ratio: POISSON_RATIO,
            stiffening_b: 0.0,
            inclusion: self.inclusion.to_vec(),
        };
        Ok(Answer { tissue, probe: AnswerProbe { shape: self.shape, radius_m: metres(self.radius_mm) }, holds, glued })
    }

    /// Solves the glued discs; calls `progress` before each of them, with depth zero.
    ///
    /// # Errors
    /// Fails if a mesh cannot be generated or solved.
    pub fn glued(&self, mut progress: impl FnMut([f64; 2], f64)) -> Result<Vec<GluedAnswer>, Error> {
        let mut solved = Vec::new();
        let tissue = Stiffness { ratio: 1.0, poisson_ratio: POISSON_RATIO, stiffening_b: 0.0 };
        let radius_m = metres(self.radius_mm);
        for place_mm in self.glued_mm {
            let [x, y] = place_mm.map(metres);
            progress([x, y], 0.0);
            let spec = BlockSpec { size_m: BLOCK_M, nodes: GLUED_NODES, fine_at_m: [x, y], fine_radius_m: 1.5 * radius_m };
            let mesh = block(&spec).map_err(|cause| Error::Usage(format!("{}: {cause}", self.file)))?;
            let bottom = (0..).zip(&mesh.nodes_m).filter(|(_, x)| x[2] <= -BLOCK_M[2]).map(|(n, _)| n);
            let anchors: Vec<u32> = bottom.collect();
            let disc = Disc { place_m: Vector3::new(x, y, 0.0), axis: Vector3::z(), radius_m };
            let directions = [Vector3::z(), Vector3::x()];
            let found = glued_stiffness(&mesh, |_, _| tissue, &anchors, &disc, &directions, &GLUED_EDGES)
                .map_err(|cause| Error::Check(format!("{}: {cause}", self.file)))?;
            solved.extend(directions.iter().zip(found.limit_m).map(|(direction, stiffness_m)| GluedAnswer {
                place_m: [x, y, 0.0],
                radius_m,
                direction: (*direction).into(),
                stiffness_over_e_m: rounded(stiffness_m),
            }));
        }
        Ok(solved)
    }

    fn case(&self, place_m: [f64; 2], nodes: usize, fine_radius_mm: f64, may_cut: [bool; 2]) -> BlockCase {
        BlockCase {
            size_m: BLOCK_M,
            place_m,
            material: Material { poisson_ratio: POISSON_RATIO, stiffening_b: 0.0, inclusions: self.inclusion.to_vec() },
            nodes,
            fine_radius_m: metres(fine_radius_mm),
            rule: TetRule::Four,
            may_cut,
        }
    }

    fn press(
        &self,
        case: &BlockCase,
        depths_mm: &[f64],
        surfaces_mm: &[f64],
        progress: &mut impl FnMut([f64; 2], f64),
    ) -> Result<Vec<HoldAnswer>, Error> {
        let block = case.build().map_err(|cause| Error::Usage(format!("{}: {cause}", self.file)))?;
        let probe = RigidProbe::new(self.shape, metres(self.radius_mm), block.place_m, Vector3::z());
        let Some(mut press) = Press::new(&block.body, probe, block.place_m) else {
            return Err(Error::Usage(format!("{}: not enough memory: take fewer nodes", self.file)));
        };
        let mut holds = Vec::new();
        for depth_mm in depths_mm {
            let depth_m = metres(*depth_mm);
            let stalled = press.go_to(depth_m, |at_m| progress(case.place_m, at_m)).err();
            if let Some(stalled) = stalled {
                return Err(Error::Check(format!("{}: no equilibrium beyond {} m", self.file, stalled.reached_m)));
            }
            let surface = surfaces_mm.contains(depth_mm).then(|| block.grid(&press.displacement_m, SPACING_M, HALF_COUNT));
            holds.push(HoldAnswer { place_m: block.place_m.into(), depth_m, force_over_e_m2: press.force_over_e_m2(), surface });
        }
        Ok(holds)
    }
}

/// Converts millimetres to the double that is nearest to the decimal number of metres, so that
/// files and scenes agree to the last bit.
fn metres(mm: f64) -> f64 {
    mm / 1000.0
}

/// Rounds to six digits: more than have converged, but few enough to hide the rounding of another
/// machine.
fn rounded(value: f64) -> f64 {
    format!("{value:.5e}").parse().unwrap_or(value)
}
