//! Finite elements of a cylinder that a ball presses on its axis: the reference's law of tissue and
//! contact ([`crate::reference::body`], [`crate::reference::touch`]) in two dimensions, which takes
//! a hundredth of its time. Nine-node rectangles, finest under the ball; all forces are divided by
//! Young's modulus.

mod energy;
mod equilibrium;
mod mesh;

use equilibrium::SOFTNESS;
use mesh::{Mesh, Pressed};

/// A cylinder with a fixed bottom under a ball on its axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cylinder {
    /// Radius of the ball [m].
    pub ball_m: f64,
    /// Radius of the cylinder [m].
    pub radius_m: f64,
    /// Height of the cylinder [m].
    pub height_m: f64,
    /// Poisson's ratio (1), below 0.5.
    pub poisson_ratio: f64,
    /// Stiffening exponent (1).
    pub stiffening_b: f64,
    /// Size of the elements under the ball, divided by the contact radius (1).
    pub fineness: f64,
}

/// Quadratic shape functions in one dimension and their slopes, at `x` in [-1, 1].
fn shape(x: f64) -> [[f64; 2]; 3] {
    [[0.5 * x * (x - 1.0), x - 0.5], [1.0 - x * x, -2.0 * x], [0.5 * x * (x + 1.0), x + 0.5]]
}

impl Cylinder {
    /// Forces over Young's modulus [m^2] at ascending depths [m]; fewer if no equilibrium is found.
    ///
    /// The elements shrink with the contact, and are narrow at its edge, so that their error is
    /// about the same part of every force. With the same elements for all depths it was 3 % of the
    /// smallest force, and swung by 0.3 % as the edge crossed elements.
    #[must_use]
    pub fn forces_m2(&self, depths_m: &[f64]) -> Vec<f64> {
        let (mut forces, mut found) = (Vec::new(), Vec::<Pressed>::new());
        for depth_m in depths_m {
            // the contact grows about as Hertz's does
            let contact_m = found.last().map_or((self.ball_m * depth_m).sqrt(), |last| last.contact_m * last.growth(*depth_m));
            let mesh = Mesh::new(self, contact_m.min(self.radius_m));
            let Some(mut solver) = mesh.analyse() else { break };
            let near = mesh.grown_from(&found, *depth_m).and_then(|u| mesh.settle(&mut solver, u, *depth_m, SOFTNESS));
            let Some((u, force)) = near.or_else(|| mesh.press(&mut solver, *depth_m)) else { break };
            forces.push(force);
            let contact_m = mesh.contact_radius_m(&u, *depth_m);
            found.push(Pressed { mesh, u, depth_m: *depth_m, contact_m });
        }
        forces
    }
}
