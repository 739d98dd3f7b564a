//! Protocol between drawing and physics, through a channel or a worker's messages.

use palpate_loop::live::{Choice, Holding, Nodule};
use serde::{Deserialize, Serialize};

/// Time of silence after which the other side counts as gone: the loop ends the force, the screen
/// shows none. Longer than a frame of a machine that is busy [s].
pub const SILENCE_S: f64 = 0.75;

/// Requests of the drawing side.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
pub enum Request {
    /// Target of the tip [m]; `None` away from the tissue. Once per drawn frame, and answered by an
    /// [`Answer::Frame`].
    Aim(Option<[f64; 3]>),
    /// Other tissue, another device.
    Choose(Choice, Holding),
    /// Whether frames contain a contact map; initially they do not.
    Map(bool),
    /// Forget the fault.
    Clear,
    /// Start a recording.
    Record,
    /// End the recording: answered by an [`Answer::Trace`].
    Finish,
    /// Repeat a trace: answered by an [`Answer::Said`].
    Replay(Vec<u8>),
    /// The ticks of a trace as a table: answered by an [`Answer::Table`].
    Table(Vec<u8>),
}

/// An answer of the physics.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub enum Answer {
    /// The tissue was replaced by another one.
    Body(Box<Body>),
    /// State of the simulation to be drawn.
    Frame(Box<Frame>),
    /// A trace, whole, and why it ended.
    Trace(Vec<u8>, Ended),
    /// Rows of comma-separated values.
    Table(String),
    /// A sentence for the user.
    Said(String),
    /// A sentence for the user, about something that was refused.
    Refused(String),
    /// Sent with a refusal: what is still pressed, and by whom.
    Kept(Box<(Choice, Holding)>),
}

/// Why a recording ended.
#[derive(Clone, Copy, Debug, Deserialize, PartialEq, Eq, Serialize)]
pub enum Ended {
    /// The recording ended as requested.
    Asked,
    /// Other tissue or another device came.
    Changed,
    /// The recording is as long as one may be.
    Full,
}

/// End of the probe, as it is drawn.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
pub enum Tip {
    /// Half a ball, or a whole one.
    #[default]
    Ball,
    /// The flat end of a cylinder.
    Flat,
    /// A ball drawn out by half of a length to either side.
    Capsule {
        /// Vector from the middle to either end [m].
        half_m: [f32; 3],
    },
    /// A whole ellipsoid.
    Ellipsoid {
        /// The two semi-axes that are not along the probe's axis [m].
        semi_axes_m: [[f32; 3]; 2],
    },
}

/// Data for drawing a patch; constant while it lives.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct Body {
    /// Counts bodies.
    pub number: u32,
    /// Choice that the body was made from.
    pub choice: Option<Choice>,
    /// Nodes at rest [m].
    pub rest_m: Vec<[f32; 3]>,
    /// The surface that a probe can touch.
    pub skin: Vec<[u16; 3]>,
    /// Nodes of each tet.
    pub tets: Vec<[u16; 4]>,
    /// Ends of springs.
    pub springs: Vec<[u16; 2]>,
    /// Nodes with a far field behind them.
    pub rim: Vec<u16>,
    /// Fixed nodes.
    pub anchors: Vec<u16>,
    /// Default place of the press [m].
    pub site_m: [f32; 3],
    /// Unit vector from the tip to the handle.
    pub axis: [f32; 3],
    /// Probe radius [m].
    pub radius_m: f32,
    /// Shape of the probe's tip.
    pub tip: Tip,
    /// Deepest press that the patch answers [m].
    pub depth_limit_m: f32,
    /// Initial Young's modulus [Pa].
    pub youngs_modulus_pa: f32,
    /// Initial damping of the nodes [1/s].
    pub node_damping_per_s: f32,
    /// Share of a held force that stays (1); 1 where nothing relaxes.
    pub lasting_share: f32,
    /// Stiffening exponent (1); zero where nothing stiffens.
    pub stiffening_b: f32,
    /// Coefficient of friction (1); zero slides freely.
    pub friction: f32,
    /// Whether the tissue is a block, into which a nodule can be put.
    pub block: bool,
    /// Nodules of the scene itself, whatever is inside now; of other tissue than a block, their
    /// depth counts from z = 0.
    pub own_nodules: Vec<Nodule>,
    /// Number of places at which the patch was calibrated; 0 if it comes from formulas alone.
    pub fitted_places: u32,
}

/// A sample of the plotted strips; a frame has a few of them.
#[derive(Clone, Copy, Debug, Default, Deserialize, PartialEq, Serialize)]
pub struct Sample {
    /// Virtual time [s].
    pub t_s: f64,
    /// Force on the device [N].
    pub force_n: f32,
    /// Part of the force along the surface [N].
    pub along_n: f32,
    /// Depth [m].
    pub depth_m: f32,
    /// Energy given to the hand in this contact [J].
    pub energy_j: f32,
    /// Mean time of the last ticks [us].
    pub tick_us: f32,
}

/// Contact map of a frame; zeros without contact.
#[derive(Clone, Debug, Default, Deserialize, Serialize)]
pub struct Contact {
    /// Area [m^2].
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
    /// The body that this is of.
    pub body: u32,
    /// Nodes [m].
    pub nodes_m: Vec<[f32; 3]>,
    /// Tip [m].
    pub tip_m: [f32; 3],
    /// Mode, by its number.
    pub mode: u8,
    /// Latched fault, by its number; 0 for none.
    pub fault: u8,
    /// Limiters that acted, as bits of `ClampFlags`.
    pub limiters: u8,
    /// Force on the device [N].
    pub force_n: [f32; 3],
    /// Part of the force along the surface [N].
    pub along_n: [f32; 3],
    /// Depth [m].
    pub depth_m: f32,
    /// Centre of the contact [m].
    pub contact_m: [f32; 3],
    /// Contact map, if requested.
    pub map: Option<Contact>,
    /// Since the last frame.
    pub samples: Vec<Sample>,
    /// Ticks run.
    pub ticks: u64,
    /// Ticks that were due and never ran: the machine was too slow or asleep.
    pub dropped: u64,
    /// Ticks of the last second of real time.
    pub hz: f32,
    /// Longest mean tick of a batch in the last second [us].
    pub worst_us: f32,
    /// Ticks recorded so far.
    pub recorded: Option<u32>,
    /// A change waits until nothing is touched.
    pub waits: bool,
}
