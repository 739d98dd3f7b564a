//! The 3-D finite-element model with which Fig. 8 is compared: [`palpate_fit::reference`] on the
//! same mesh, with 10-node tets whose stiffness is evaluated at their quadrature points.
//!
//! The model is static: Newton's method advances in steps of depth until the force is reached.
//! Since it has no time, its stop criterion is a residual of 1e-8 of the contact force.

use palpate::Vector3;

use super::find_depth::find_depth;
use super::site::Site;
use crate::error::Error;
use crate::methods::Block;
use palpate_fit::reference::body::{Body, Stiffness};
use palpate_fit::reference::newton::Press;
use palpate_fit::reference::probe::RigidProbe;
use palpate_fit::reference::quadratic::QuadraticMesh;
use palpate_fit::reference::shape::{TET_EDGES, TetRule};
use palpate_tissue::Error as TissueError;
use palpate_tissue::clock::thread_time;
use palpate_tissue::scene::Shape;

/// Equilibrium of the reference under a force.
#[derive(Clone, Debug)]
pub struct ReferencePress {
    /// Force on the finger [N].
    pub force_n: f64,
    /// Depth of the tip [m].
    pub depth_m: f64,
    /// CPU time since the undeformed state [s].
    pub cpu_s: f64,
    /// Positions of the corner nodes [m]; mid-edge nodes are left out.
    pub position_m: Vec<Vector3<f64>>,
}

/// The reference of a block or an organ.
pub struct Truth {
    body: Body,
    block: Block,
    corners: usize,
}

impl Truth {
    /// Prepares tissue whose tets have one stiffness each, as in the other methods.
    pub fn same_mesh(block: &Block) -> Self {
        Self::new(block, |tet, _| block.tissue.stiffness_ratio[tet], TetRule::Four)
    }

    /// Prepares an organ whose layers run through its elements.
    pub fn layered(site: &Site) -> Self {
        let e = f64::from(site.block.params.youngs_modulus_pa);
        Self::new(&site.block, |_, x| site.youngs_modulus_at_pa((*x).into()) / e, TetRule::Eleven)
    }

    fn new(block: &Block, ratio: impl Fn(usize, &Vector3<f64>) -> f64, rule: TetRule) -> Self {
        let mesh = QuadraticMesh::new(&block.tissue.mesh);
        let corners = block.tissue.mesh.nodes_m.len();
        let mut held = block.fixed();
        held.resize(mesh.nodes_m.len(), false);
        // the mid-edge node between two fixed nodes is fixed too
        for tet in &mesh.tets {
            for (e, [i, j]) in TET_EDGES.into_iter().enumerate() {
                held[tet[4 + e] as usize] |= held[tet[i] as usize] && held[tet[j] as usize];
            }
        }
        let fixed = held.iter().map(|held| [*held; 3]).collect();
        let free = |t: &[u32; 6]| !t.iter().all(|n| held[*n as usize]);
        let touchable = (0..mesh.triangles.len()).filter(|t| free(&mesh.triangles[*t])).collect();
        let poisson_ratio = f64::from(block.params.poisson_ratio);
        let stiffness = |tet: usize, x: &Vector3<f64>| Stiffness { ratio: ratio(tet, x), poisson_ratio, stiffening_b: 0.0 };
        let body = Body::with_stiffness(mesh, stiffness, fixed, touchable, 1.0, rule);
        Self { body, block: block.clone(), corners }
    }

    /// Presses with ascending forces, starting undeformed; ends before the first force without an
    /// equilibrium. CPU times are those of one thread only if the caller provides a single thread.
    pub fn press(&self, forces_n: &[f64], mut progress: impl FnMut(f64)) -> Result<Vec<ReferencePress>, Error> {
        let e = f64::from(self.block.params.youngs_modulus_pa);
        let radius_m = f64::from(self.block.params.probe.radius_m);
        let place = Vector3::from(self.block.tissue.site_m);
        let probe = RigidProbe::new(Shape::Hemisphere, radius_m, place, self.block.params.probe.axis.cast());
        let mut press = Press::new(&self.body, probe, place).ok_or_else(|| {
            TissueError::Usage("not enough memory for the finite-element reference: give a coarser mesh".into())
        })?;
        let begun = thread_time();
        let mut held = Vec::new();
        for &force_n in forces_n {
            if find_depth(&mut press, force_n / e, radius_m, &mut |_| progress(force_n)).is_err() {
                break;
            }
            let position_m = (0..self.corners).map(|n| self.body.mesh.nodes_m[n] + press.displacement_m[n]).collect();
            let cpu_s = (thread_time() - begun).as_secs_f64();
            held.push(ReferencePress { force_n: press.force_over_e_m2() * e, depth_m: press.depth_m(), cpu_s, position_m });
        }
        Ok(held)
    }
}
