//! Protocol between drawing and physics, through a channel or a worker's messages.

use palpate_loop::live::{Choice, Holding, Nodule};
use serde::{Deserialize, Serialize};

/// Silence after which each side takes the other as gone [s]: the loop then ends the force, and the
/// screen shows none. It is longer than a frame on a busy machine.
pub const SILENCE_S: f64 = 0.75;

/// Requests of the drawing side.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub enum Request {
    /// Target of the tip [m]; `None` away from the tissue. It is sent once per drawn frame and
    /// answered by an [`Answer::Frame`].
    Aim(Option<[f64; 3]>),
    /// Changes the tissue or the device.
    Choose(Choice, Holding),
    /// Whether frames contain a contact map; initially they do not.
    Map(bool),
    /// Clears the fault.
    Clear,
    /// Starts a recording.
    Record,
    /// Ends the recording; answered by an [`Answer::Trace`].
    Finish,
    /// Replays a trace; answered by an [`Answer::Said`].
    Replay(Vec<u8>),
    /// Requests the ticks of a trace as a table; answered by an [`Answer::Table`].
    Table(Vec<u8>),
}

/// An answer of the physics.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub enum Answer {
    /// The tissue was replaced by another one.
    Body(Box<Body>),
    /// State of the simulation to be drawn.
    Frame(Box<Frame>),
    /// A complete trace, and why it ended.
    Trace(Vec<u8>, Ended),
    /// Rows of comma-separated values.
    Table(String),
    /// A sentence for the user.
    Said(String),
    /// A sentence for the user about a request that was refused.
    Refused(String),
    /// Sent after a refusal: the choice and the holding that remain in use.
    Kept(Box<(Choice, Holding)>),
}

/// Why a recording ended.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Serialize)]
pub enum Ended {
    /// The recording ended as requested.
    Asked,
    /// The tissue or the device was changed.
    Changed,
    /// The recording reached its largest length.
    Full,
}

/// End of the probe, as it is drawn.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
pub enum Tip {
    /// A hemisphere or a ball.
    #[default]
    Ball,
    /// The flat end of a cylinder.
    Flat,
    /// A capsule: a ball that is extended by half of a length to either side.
    Capsule {
        /// Vector from the middle to either end [m].
        half_m: [f32; 3],
    },
    /// An ellipsoid, whose third semi-axis is the radius.
    Ellipsoid {
        /// The two semi-axes that are not along the probe's axis [m].
        semi_axes_m: [[f32; 3]; 2],
    },
}

/// Data for drawing a patch; constant while it lives.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct Body {
    /// Number of the body, which rises by one with every new body.
    pub number: u32,
    /// Choice that the body was made from.
    pub choice: Option<Choice>,
    /// Nodes at rest [m].
    pub rest_m: Vec<[f32; 3]>,
    /// The surface that a probe can touch.
    pub skin: Vec<[u16; 3]>,
    /// Nodes of each tet.
    pub tets: Vec<[u16; 4]>,
    /// Nodes at the ends of each spring.
    pub springs: Vec<[u16; 2]>,
    /// Nodes with a far field behind them.
    pub rim: Vec<u16>,
    /// Nodes that are fixed in space.
    pub anchors: Vec<u16>,
    /// Default site of the press [m].
    pub site_m: [f32; 3],
    /// Unit vector from the tip to the handle.
    pub axis: [f32; 3],
    /// Probe radius [m].
    pub radius_m: f32,
    /// Shape of the probe's tip.
    pub tip: Tip,
    /// Largest depth to which the patch responds [m].
    pub depth_limit_m: f32,
    /// Initial Young's modulus [Pa].
    pub youngs_modulus_pa: f32,
    /// Initial damping of the nodes [1/s].
    pub node_damping_per_s: f32,
    /// Share of a held force that remains (1); 1 if nothing relaxes.
    pub lasting_share: f32,
    /// Stiffening exponent (1); zero if nothing stiffens.
    pub stiffening_b: f32,
    /// Coefficient of friction (1); zero if the probe slides freely.
    pub friction: f32,
    /// Whether the tissue is a block, into which a nodule can be put.
    pub block: bool,
    /// Nodules of the scene itself, even if others replace them. In tissue other than a block their
    /// depth is measured from z = 0.
    pub own_nodules: Vec<Nodule>,
    /// Number of probe places at which the patch was calibrated; 0 if it was not calibrated.
    pub fitted_places: u32,
}

/// A sample of the plotted strips; a frame has a few of them.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct Sample {
    /// Virtual time [s].
    pub t_s: f64,
    /// Force on the device [N].
    pub force_n: f32,
    /// Component of the force along the surface [N].
    pub along_n: f32,
    /// Depth of the tip [m].
    pub depth_m: f32,
    /// Energy given to the hand in this contact [J].
    pub energy_j: f32,
    /// Mean duration of the last ticks [us].
    pub tick_us: f32,
}

/// Contact map of a frame; zeros without contact.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct Contact {
    /// Area of the contact [m^2].
    pub area_m2: f32,
    /// Centre of pressure [m].
    pub centre_m: [f32; 3],
    /// Half-axes of the ellipse [m].
    pub half_axes_m: [[f32; 3]; 2],
    /// Largest pressure [Pa].
    pub peak_pa: f32,
    /// Pressure on each triangle of the skin [Pa].
    pub pressure_pa: Vec<f32>,
}

/// State of the simulation to be drawn.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct Frame {
    /// Number of the body that this frame shows.
    pub body: u32,
    /// Positions of the nodes [m].
    pub nodes_m: Vec<[f32; 3]>,
    /// Position of the tip [m].
    pub tip_m: [f32; 3],
    /// Number of the loop's mode.
    pub mode: u8,
    /// Number of the latched fault; 0 without a fault.
    pub fault: u8,
    /// Limiters that acted, as bits of `ClampFlags`.
    pub limiters: u8,
    /// Force on the device [N].
    pub force_n: [f32; 3],
    /// Component of the force along the surface [N].
    pub along_n: [f32; 3],
    /// Depth of the tip [m].
    pub depth_m: f32,
    /// Centre of the contact [m].
    pub contact_m: [f32; 3],
    /// Contact map, if it was requested.
    pub map: Option<Contact>,
    /// Samples since the last frame.
    pub samples: Vec<Sample>,
    /// Number of ticks that ran.
    pub ticks: u64,
    /// Number of ticks that were due but never ran, since the machine was too slow or asleep.
    pub dropped: u64,
    /// Number of ticks in the last second of real time.
    pub hz: f32,
    /// Longest mean duration of a tick in a batch in the last second [us].
    pub worst_us: f32,
    /// Number of ticks recorded so far; `None` without a recording.
    pub recorded: Option<u32>,
    /// Whether a change waits until nothing is touched.
    pub waits: bool,
}
