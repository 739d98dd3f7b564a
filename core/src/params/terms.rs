//! Terms of the model, each of which can be left out.

/// Terms of the model that act. All on is the product; springs alone are the papers' plain model.
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
    /// Where `relative_mass` is off, the mass floor leaves out the smoothest common motion, on one
    /// field and without a sum over neighbours, for boards that have no time for the sum.
    pub smooth_mass: bool,
    /// Tissue stiffens by [`super::Params::stiffening_b`]. If that is zero, the term costs nothing.
    pub stiffening: bool,
    /// Forces fade by [`super::Params::relaxation`]. Without terms there it costs nothing.
    pub relaxation: bool,
    /// The probe rubs by [`super::Params::friction`]. If that is zero, the term costs nothing.
    pub friction: bool,
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
    };
}
