//! The patch at rest under a probe: equilibrium of the model's energies in `f64`, its tangent
//! stiffness, and the derivatives of forces and displacements with respect to every constant of the
//! model.
//!
//! The energies are those of the tick (`core/src/stages/force`), divided by Young's modulus. They
//! do not depend on mass or time: a few Newton steps find the state to which the tick settles,
//! together with its derivatives.

mod contact;
mod elastic;
mod equilibrium;
mod glued;
mod rim;
mod sensitivity;
mod stiffening;
mod tangent;

use nalgebra::Vector3;
use palpate::{BuildError, Model, Params, Probe};

pub use equilibrium::{Balance, Solver, Unbalanced};
pub use glued::Glued;
pub use rim::Rim;
pub use sensitivity::Gradient;

/// Height of the tip above the surface before a press begins [m].
pub const CLEAR_M: f64 = 1e-4;

/// A point or a vector.
pub type Vector = Vector3<f64>;

/// A spring of the patch.
#[derive(Clone, Copy, Debug)]
pub struct StaticSpring {
    /// First and second node of the spring.
    pub node: [usize; 2],
    /// Stiffness over E [m].
    pub k: f64,
    /// Rest length [m].
    pub rest_m: f64,
}

/// A tet, as in [`palpate::Tet`].
#[derive(Clone, Copy, Debug)]
pub struct StaticTet {
    /// Corner nodes.
    pub node: [usize; 4],
    /// Reciprocal of six times the rest volume [1/m^3].
    pub six_volume_reciprocal: f64,
    /// Volume stiffness of the tet itself, over E (1).
    pub bulk: f64,
    /// Stiffness of the barrier against inversion, over E (1).
    pub barrier: f64,
}

/// A surface triangle with the stiffness of its foundation points over E [m].
#[derive(Clone, Debug)]
pub struct StaticTriangle {
    /// Corner nodes.
    pub node: [usize; 3],
    /// Initial stiffness of each point over E [m].
    pub k: Vec<f64>,
}

/// The constants of a patch in `f64`; all stiffnesses are divided by E.
#[derive(Clone, Debug)]
pub struct Statics {
    /// Rest positions [m], shape \[nodes\].
    pub rest_m: Vec<Vector>,
    /// Index of each node among the free ones, `None` for anchors, shape \[nodes\].
    pub(crate) free: Vec<Option<usize>>,
    /// Reciprocal of six times the volume of the tets around each node [1/m^3], shape \[nodes\].
    pub(crate) six_volume_reciprocal: Vec<f64>,
    /// Nodal volume stiffness over E, as in [`palpate::NodeRest::pressure`], shape \[nodes\].
    pub pressure: Vec<f64>,
    /// Springs of the patch, shape \[springs\].
    pub springs: Vec<StaticSpring>,
    /// Tets of the patch, shape \[tets\].
    pub tets: Vec<StaticTet>,
    /// Surface triangles with their foundation points, shape \[triangles\].
    pub triangles: Vec<StaticTriangle>,
    /// Coefficient with which the foundation stiffens [1/m].
    pub stiffening_per_m: f64,
    /// Stiffness factor of the compensation, chi (1).
    pub compensation: f64,
    /// Compression at which the compensation begins, `tau_c` (1).
    pub compensation_threshold: f64,
    /// Whether the volume terms and the compensation are active.
    pub(crate) volume_acts: bool,
    pub(crate) compensation_acts: bool,
    /// Steepness of every node, as in [`palpate::Model::steepness`]; may be empty.
    steepness_of: Vec<f64>,
    /// Logarithm of a node's stiffness factor, divided by its energy density over E (1), before the
    /// factor `steepness_of`.
    pub(crate) steepness: f64,
    /// Elastic support of the rim nodes, if there is one.
    pub rim: Option<Rim>,
    /// Probe that presses the patch.
    pub probe: Probe,
}

impl Statics {
    /// Converts a patch of the core.
    ///
    /// # Errors
    /// See [`Params::build`].
    pub fn of(model: &Model, params: &Params) -> Result<Self, BuildError> {
        params.check()?;
        model.check()?;
        let mut free: Vec<Option<usize>> = vec![Some(0); model.nodes.len()];
        model.anchors.iter().for_each(|&a| free[usize::from(a)] = None);
        free.iter_mut().flatten().enumerate().for_each(|(n, slot)| *slot = n);
        Ok(Self {
            rest_m: model.nodes.iter().map(|n| Vector::from(n.rest_m.map(f64::from))).collect(),
            free,
            six_volume_reciprocal: model.nodes.iter().map(|n| f64::from(n.six_volume_reciprocal)).collect(),
            pressure: model.nodes.iter().map(|n| f64::from(n.pressure)).collect(),
            springs: model
                .springs
                .iter()
                .map(|s| StaticSpring {
                    node: [s.i.into(), s.j.into()],
                    k: f64::from(s.k),
                    rest_m: f64::from(s.k_rest) / f64::from(s.k),
                })
                .collect(),
            tets: model
                .tets
                .iter()
                .map(|t| StaticTet {
                    node: t.node.map(usize::from),
                    six_volume_reciprocal: f64::from(t.six_volume_reciprocal),
                    bulk: f64::from(t.bulk),
                    barrier: f64::from(t.barrier),
                })
                .collect(),
            triangles: model
                .triangles
                .iter()
                .zip(model.foundation.chunks(model.points_per_triangle()))
                .map(|(t, points)| StaticTriangle {
                    node: t.node.map(usize::from),
                    k: points.iter().map(|p| f64::from(p.k)).collect(),
                })
                .collect(),
            stiffening_per_m: f64::from(model.stiffening_per_m),
            compensation: f64::from(params.compensation),
            compensation_threshold: f64::from(params.compensation_threshold),
            volume_acts: params.terms.volume,
            compensation_acts: params.terms.compensation,
            steepness_of: model.steepness.iter().map(|s| f64::from(*s)).collect(),
            steepness: stiffening::steepness(params),
            rim: Rim::of(model),
            probe: params.probe,
        })
    }

    /// Number of free nodes.
    #[must_use]
    pub fn free_nodes(&self) -> usize {
        self.free.iter().flatten().count()
    }

    /// Unit vector along the probe's axis, from the tip to the handle.
    #[must_use]
    pub fn axis(&self) -> Vector {
        self.probe.axis.cast()
    }
}
