//! Motions of the tip, which are the columns of the matrix.

use palpate::Params;
use palpate_tissue::scene::Inclusion as Ball;

use CaseTissue::{Frictional, Inclusion, Plain, Stiffening};

/// Motion of the tip: down at a constant speed, held, up at a constant speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stimulus {
    /// Depth of the hold [m].
    pub depth_m: f64,
    /// Speed of loading [m/s].
    pub in_m_per_s: f64,
    /// Speed of the retreat [m/s].
    pub out_m_per_s: f64,
    /// Jitter of the times of the poses, as a share of a tick (1).
    pub jitter: f64,
}

/// Behaviour that the product promises for a case.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Promise {
    /// The patch withstands the case.
    Pass,
    /// The guard holds the tip at the depth limit, and the patch does not fail.
    Hold,
    /// The guard holds the tip at the depth limit; once the hand is two probe radii beyond it, the
    /// force is released.
    LetThrough,
    /// Nothing is promised.
    None,
}

/// Tissue of a case: the standard block, as it is or with one addition.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CaseTissue {
    /// The standard block as it is.
    Plain,
    /// The standard block with a ball 12 mm deep that is ten times stiffer.
    Inclusion,
    /// The standard block with a friction coefficient of 0.5.
    Frictional,
    /// The standard block of a tissue that stiffens with an exponent b of 20.
    Stiffening,
}

impl CaseTissue {
    /// All tissues in the order of the table.
    pub const ALL: [Self; 4] = [Self::Plain, Self::Inclusion, Self::Frictional, Self::Stiffening];

    /// Name in files.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Plain => "plain",
            Self::Inclusion => "inclusion",
            Self::Frictional => "mu 0.5",
            Self::Stiffening => "b = 20",
        }
    }

    /// Whether only the product has the term that this tissue needs.
    pub const fn needs_a_term(self) -> bool {
        matches!(self, Self::Frictional | Self::Stiffening)
    }

    /// Adds the terms of this tissue to the parameters.
    pub const fn of(self, params: Params) -> Params {
        match self {
            Self::Plain | Self::Inclusion => params,
            Self::Frictional => Params { friction: 0.5, ..params },
            Self::Stiffening => Params { stiffening_b: 20.0, ..params },
        }
    }
}

/// A column of the matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LoadCase {
    /// Name in files.
    pub name: &'static str,
    /// Label above the column, in two lines.
    pub label: [&'static str; 2],
    /// Motion of the tip.
    pub stimulus: Stimulus,
    /// Tissue that is pressed.
    pub tissue: CaseTissue,
    /// Promise of the product.
    pub promise: Promise,
}

/// Speed of a slow press [m/s], which is that of a scene's ramp.
const SLOW_M_PER_S: f64 = 0.04;
/// Speed of the tap for which the product promises its behaviour [m/s].
const TAP_M_PER_S: f64 = 0.5;
/// Fastest retreat that the guard passes on [m/s].
const FASTEST_M_PER_S: f64 = 1.0;
/// Depth for which the product promises its behaviour [m], a fifth of the block's height.
const DEEP_M: f64 = 8e-3;

/// The inclusion of the scene `nodule`: ten times stiffer, 12 mm deep.
pub(super) const INCLUSION: Ball =
    Ball { center_m: [0.0, 0.0, -0.012], radius_m: 0.006, stiffness_ratio: 10.0, stiffening_b: None };

/// The standard slow press.
pub(super) const PRESS: Stimulus = Stimulus { depth_m: DEEP_M, in_m_per_s: SLOW_M_PER_S, out_m_per_s: SLOW_M_PER_S, jitter: 0.0 };
/// The standard tap.
pub(super) const TAP: Stimulus = Stimulus { in_m_per_s: TAP_M_PER_S, out_m_per_s: TAP_M_PER_S, ..PRESS };

const fn deep(depth_m: f64) -> Stimulus {
    Stimulus { depth_m, ..PRESS }
}

/// Columns of the table, from left to right.
pub const CASES: [LoadCase; 15] = [
    case("press-20", ["press", "20 %"], PRESS, Plain, Promise::Pass),
    case("press-40", ["press", "40 %"], deep(0.016), Plain, Promise::Hold),
    case("press-60", ["press", "60 %"], deep(0.024), Plain, Promise::Hold),
    case("press-80", ["press", "80 %"], deep(0.032), Plain, Promise::LetThrough),
    case("tap-0.5", ["tap", "0.5 m/s"], TAP, Plain, Promise::Pass),
    case("tap-1", ["tap", "1 m/s"], Stimulus { in_m_per_s: 1.0, out_m_per_s: 1.0, ..PRESS }, Plain, Promise::None),
    case("jitter-press", ["press,", "jitter"], Stimulus { jitter: 0.5, ..PRESS }, Plain, Promise::Pass),
    case("jitter-tap", ["tap 0.5,", "jitter"], Stimulus { jitter: 0.5, ..TAP }, Plain, Promise::Pass),
    case("inclusion-press", ["press,", "nodule"], PRESS, Inclusion, Promise::Pass),
    case("inclusion-tap", ["tap 0.5,", "nodule"], TAP, Inclusion, Promise::Pass),
    case("release", ["sudden", "release"], Stimulus { out_m_per_s: FASTEST_M_PER_S, ..PRESS }, Plain, Promise::Pass),
    case("friction-press", ["press,", "mu 0.5"], PRESS, Frictional, Promise::Pass),
    case("friction-tap", ["tap 0.5,", "mu 0.5"], TAP, Frictional, Promise::Pass),
    case("stiffening-press", ["press,", "b = 20"], PRESS, Stiffening, Promise::Pass),
    case("stiffening-tap", ["tap 0.5,", "b = 20"], TAP, Stiffening, Promise::Pass),
];

/// Columns of the quick matrix, by name.
pub const QUICK_CASES: [&str; 8] =
    ["press-20", "press-40", "tap-0.5", "jitter-press", "inclusion-press", "friction-tap", "stiffening-press", "stiffening-tap"];

const fn case(
    name: &'static str,
    label: [&'static str; 2],
    stimulus: Stimulus,
    tissue: CaseTissue,
    promise: Promise,
) -> LoadCase {
    LoadCase { name, label, stimulus, tissue, promise }
}

impl Stimulus {
    /// Whether the motion is so slow and smooth that the force during the descent is due to the
    /// stiffness of the tissue rather than its inertia, and therefore must not fall.
    pub fn is_slow(&self) -> bool {
        self.in_m_per_s <= 0.1 && self.jitter == 0.0
    }
}
