//! Terms of the model, each of which can be left out.

/// Terms of the model that act. The product has all of them on; springs alone are the papers' plain
/// model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Terms {
    /// Nodal-averaged and per-tet volume energy.
    pub volume: bool,
    /// Compression compensation of springs and the barrier of tets.
    pub compensation: bool,
    /// Rim springs, the far field.
    pub rim: bool,
    /// The mass floor acts on the motion of neighbours relative to each other. When this is off, it
    /// acts on each node by itself.
    pub relative_mass: bool,
    /// If `relative_mass` is off, the smoothest common motion is exempt from the mass floor. This
    /// needs one field and no sum over neighbours, for boards that have no time for the sum.
    pub smooth_mass: bool,
    /// Tissue stiffens with [`super::Params::stiffening_b`]. If that is zero, the term costs
    /// nothing.
    pub stiffening: bool,
    /// Forces fade as in [`super::Params::relaxation`]. If that has no terms, relaxation costs
    /// nothing.
    pub relaxation: bool,
    /// The probe rubs with the coefficient [`super::Params::friction`]. If that is zero, the term
    /// costs nothing.
    pub friction: bool,
    /// A model with a law answers by it; when this is off, its nodes do.
    pub law: bool,
}

impl Terms {
    /// Every term, each in its best form.
    pub const ALL: Self = Self {
        volume: true,
        compensation: true,
        rim: true,
        relative_mass: true,
        smooth_mass: false,
        stiffening: true,
        relaxation: true,
        friction: true,
        law: true,
    };
    /// Springs, masses, contact: the papers' plain mass-spring model.
    pub const SPRINGS_ONLY: Self = Self {
        volume: false,
        compensation: false,
        rim: false,
        relative_mass: false,
        smooth_mass: false,
        stiffening: false,
        relaxation: false,
        friction: false,
        law: false,
    };
}
