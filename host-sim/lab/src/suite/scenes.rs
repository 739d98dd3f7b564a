//! The scenes of the suite.

use palpate::ProbeShape;
use palpate_tissue::scene::Inclusion;

use crate::chart::TermErrors;
use crate::methods::Block;

/// Young's moduli of the plain block and of the block with terms [Pa].
pub(super) const SOFT_PA: f64 = 3500.0;
pub(super) const STIFF_PA: f64 = 20_000.0;

/// Reference of held presses.
pub(super) const BLOCK: &str = include_str!("../../../references/block.json");
const NODULE: &str = include_str!("../../../references/nodule.json");
const FLAT: &str = include_str!("../../../references/flat.json");
const SPHERE: &str = include_str!("../../../references/sphere-5mm.json");

/// A scene: what differs from the plain block, and its references.
pub struct SuiteScene {
    /// Name in tables.
    pub name: &'static str,
    /// Stored answer of held presses; empty if there is none.
    pub(super) held: &'static str,
    /// Range of the distance of the held presses from the centre [m].
    pub(super) away_m: [f64; 2],
    /// Names of the stored motions.
    pub(super) motions: &'static [&'static str],
    /// Error of a term of the tissue, which replaces the presses.
    pub(super) term: Option<fn(&TermErrors) -> Option<f64>>,
    /// Tip, if it is another one.
    tip: Option<(ProbeShape, f32)>,
    /// Whether the block holds the nodule.
    nodule: bool,
}

const PLAIN: SuiteScene = SuiteScene { name: "", held: "", away_m: [0.0; 2], motions: &[], term: None, tip: None, nodule: false };

/// Root mean square of two errors.
fn both([a, b]: [Option<f64>; 2]) -> Option<f64> {
    Some(((a?.powi(2) + b?.powi(2)) / 2.0).sqrt())
}

/// All scenes, in the order of the table.
pub const SCENES: [SuiteScene; 12] = [
    SuiteScene {
        name: "plain block",
        held: BLOCK,
        motions: &[
            "centre-3.5kpa-40",
            "centre-3.5kpa-200",
            "centre-20kpa-40",
            "centre-20kpa-200",
            "centre-100kpa-40",
            "centre-100kpa-200",
        ],
        ..PLAIN
    },
    SuiteScene {
        name: "off the centre",
        held: BLOCK,
        away_m: [0.004, 0.012],
        motions: &["aside-3.5kpa-40", "aside-3.5kpa-200", "aside-20kpa-200", "aside-100kpa-200", "askew-3.5kpa-200"],
        ..PLAIN
    },
    SuiteScene { name: "toward the edge", held: BLOCK, away_m: [0.016, 0.016], ..PLAIN },
    SuiteScene {
        name: "taps of 200 mm/s",
        motions: &["tap-3.5kpa-200", "tap-20kpa-200", "tap-100kpa-200", "tap-aside-20kpa-100"],
        ..PLAIN
    },
    SuiteScene { name: "tap of 500 mm/s", motions: &["centre-3.5kpa-500", "centre-20kpa-500", "centre-100kpa-500"], ..PLAIN },
    SuiteScene {
        name: "swing and drag",
        motions: &["swing-3.5kpa-10hz", "swing-20kpa-10hz", "swing-100kpa-10hz", "drag-3.5kpa-60"],
        ..PLAIN
    },
    SuiteScene {
        name: "above a nodule",
        held: NODULE,
        away_m: [0.0, 0.006],
        motions: &["nodule-3.5kpa-40", "nodule-3.5kpa-200"],
        nodule: true,
        ..PLAIN
    },
    SuiteScene { name: "beside a nodule", held: NODULE, away_m: [0.009, 0.012], nodule: true, ..PLAIN },
    SuiteScene { name: "ball of 5 mm", held: SPHERE, tip: Some((ProbeShape::Sphere, 5e-3)), ..PLAIN },
    SuiteScene { name: "flat end", held: FLAT, tip: Some((ProbeShape::Flat, 8e-3)), ..PLAIN },
    SuiteScene { name: "hold that relaxes", term: Some(|errors| both(errors.held_pct)), ..PLAIN },
    SuiteScene { name: "slide with friction", term: Some(|errors| errors.sideways_pct.map(f64::abs)), ..PLAIN },
];

impl SuiteScene {
    /// Whether the scene has a force that is compared at rest.
    #[must_use]
    pub fn is_held(&self) -> bool {
        !self.held.is_empty() || self.term.is_some()
    }

    /// The plain block with what differs.
    pub(super) fn changed(&self, mut block: Block) -> Block {
        if let Some((shape, radius_m)) = self.tip {
            (block.params.probe.shape, block.params.probe.radius_m) = (shape, radius_m);
        }
        if self.nodule {
            return block.with_inclusion(Inclusion {
                center_m: [0.0, 0.0, -0.012],
                radius_m: 0.006,
                stiffness_ratio: 10.0,
                stiffening_b: None,
            });
        }
        block
    }
}
