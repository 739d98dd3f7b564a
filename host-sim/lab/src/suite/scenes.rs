//! The scenes of the suite.

use palpate::ProbeShape;
use palpate_tissue::scene::Inclusion;

use crate::methods::{BLOCK_M, Block};

/// Young's modulus of the blocks, and of the block that relaxes and has friction [Pa].
const SOFT_PA: f64 = 3500.0;
const TERMS_PA: f64 = 20_000.0;

const BLOCK: &str = include_str!("../../../references/block.json");
const NODULE: &str = include_str!("../../../references/nodule.json");
const FLAT: &str = include_str!("../../../references/flat.json");
const SPHERE: &str = include_str!("../../../references/sphere-5mm.json");

/// A scene: what differs from the plain block, and its references.
pub struct SuiteScene {
    /// Name in tables.
    pub name: &'static str,
    /// Name in pictures, in two lines.
    pub label: [&'static str; 2],
    pub(super) kind: Kind,
}

pub(super) enum Kind {
    /// The block, with presses and motions that are stored for it.
    Stored { presses: &'static [Presses], motions: &'static [&'static str], nodule: bool },
    /// A tissue of its own, whose scene, references, law and patch are in files of this name. The
    /// mesh generator of blocks makes its meshes if it is one, or one with an inclined top.
    Own(&'static str, Option<Cuboid>),
    /// Slide with friction and back.
    Slide,
    /// Press, relax, slide, and return to the first place.
    Return,
    /// The block becomes that with the nodule while it is pressed.
    Change,
}

/// A block whose top rises along x.
#[derive(Clone, Copy)]
pub(super) struct Cuboid {
    /// Sides [m], with the height in the middle.
    pub size_m: [f64; 3],
    /// Slope of the top (1).
    pub rise: f64,
}

/// Held presses of the block.
pub(super) struct Presses {
    /// Stored answer.
    pub answer: &'static str,
    /// Largest distance from the centre [m].
    pub within_m: f64,
    /// Tip, if it is not the hemisphere.
    pub tip: Option<(ProbeShape, f32)>,
}

const PLAIN: Presses = Presses { answer: BLOCK, within_m: 0.012, tip: None };
/// The law of the nodule ends 9.2 mm from its site.
const ON_NODULE: Presses = Presses { answer: NODULE, within_m: 0.009, tip: None };

/// Held presses before and after the change of a region.
pub(super) const CHANGE: [Presses; 2] = [Presses { within_m: 0.0, ..PLAIN }, Presses { within_m: 0.0, ..ON_NODULE }];

/// All scenes, in the order of the table.
pub const SCENES: [SuiteScene; 12] = [
    SuiteScene {
        name: "plain block",
        label: ["plain", "block"],
        kind: Kind::Stored {
            presses: &[PLAIN],
            motions: &[
                "centre-3.5kpa-40",
                "centre-3.5kpa-200",
                "centre-20kpa-40",
                "centre-20kpa-200",
                "centre-100kpa-40",
                "centre-100kpa-200",
                "aside-3.5kpa-200",
                "aside-20kpa-200",
            ],
            nodule: false,
        },
    },
    SuiteScene {
        name: "near an edge",
        label: ["near an", "edge"],
        kind: Kind::Own("edge", Some(Cuboid { size_m: BLOCK_M, rise: 0.0 })),
    },
    SuiteScene {
        name: "sloped face",
        label: ["sloped", "face"],
        kind: Kind::Own("slope", Some(Cuboid { size_m: BLOCK_M, rise: 0.5 })),
    },
    SuiteScene { name: "dome", label: ["dome", ""], kind: Kind::Own("dome", None) },
    SuiteScene {
        name: "thin layer",
        label: ["thin", "layer"],
        kind: Kind::Own("thin", Some(Cuboid { size_m: [0.08, 0.08, 0.01], rise: 0.0 })),
    },
    SuiteScene { name: "stiff layer below", label: ["stiff", "below"], kind: Kind::Own("stiff", None) },
    SuiteScene {
        name: "nodule under and beside",
        label: ["nodule", ""],
        kind: Kind::Stored { presses: &[ON_NODULE], motions: &["nodule-3.5kpa-40", "nodule-3.5kpa-200"], nodule: true },
    },
    SuiteScene {
        name: "taps, swings, drag",
        label: ["taps,", "swings"],
        kind: Kind::Stored {
            presses: &[Presses { within_m: 0.0, ..PLAIN }],
            motions: &[
                "tap-3.5kpa-200",
                "tap-20kpa-200",
                "tap-100kpa-200",
                "tap-aside-20kpa-100",
                "swing-3.5kpa-10hz",
                "swing-20kpa-10hz",
                "swing-100kpa-10hz",
                "drag-3.5kpa-60",
                "centre-3.5kpa-500",
                "centre-20kpa-500",
                "centre-100kpa-500",
            ],
            nodule: false,
        },
    },
    SuiteScene {
        name: "another tip",
        label: ["another", "tip"],
        kind: Kind::Stored {
            presses: &[
                Presses { answer: SPHERE, tip: Some((ProbeShape::Sphere, 5e-3)), ..PLAIN },
                Presses { answer: FLAT, tip: Some((ProbeShape::Flat, 8e-3)), ..PLAIN },
            ],
            motions: &[],
            nodule: false,
        },
    },
    SuiteScene { name: "slide with friction and back", label: ["friction", "and back"], kind: Kind::Slide },
    SuiteScene { name: "relax, slide, return", label: ["slide and", "return"], kind: Kind::Return },
    SuiteScene { name: "region changed while pressed", label: ["region", "changed"], kind: Kind::Change },
];

impl SuiteScene {
    /// Young's modulus of the block [Pa].
    pub(super) fn modulus_pa(&self) -> f64 {
        if matches!(self.kind, Kind::Slide | Kind::Return) { TERMS_PA } else { SOFT_PA }
    }

    /// Whether the scene has motions.
    pub fn moves(&self) -> bool {
        match &self.kind {
            Kind::Stored { motions, .. } => !motions.is_empty(),
            Kind::Own(..) => true,
            _ => false,
        }
    }
}

/// The nodule of [`NODULE`].
pub(super) fn with_nodule(block: Block) -> Block {
    block.with_inclusion(Inclusion { center_m: [0.0, 0.0, -0.012], radius_m: 0.006, stiffness_ratio: 10.0, stiffening_b: None })
}
