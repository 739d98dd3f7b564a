//! The tissue core bound to this image: patch in flash, state in RAM. The only file that names the core's types.

use palpate::{BuildError, Model, Node, Output, PatchFile, ProbePose, State, TetShapes, Tuned};
use static_cell::ConstStaticCell;

use crate::placement::Placement;

/// Nodes that the reserved RAM holds.
const NODES: usize = 512;
/// Surface triangles that it holds.
const TRIANGLES: usize = 1024;
/// RAM of the least of the supported boards, less 16 KB for stacks and telemetry.
#[cfg(target_os = "none")]
const RAM_FOR_PATCH: usize = 112 * 1024;

/// The patch is read in place, as words.
#[repr(C, align(4))]
struct WordAligned<Bytes: ?Sized>(Bytes);

/// What `PALPATE_PATCH` named when the image was built.
static PATCH_FILE: &WordAligned<[u8]> = &WordAligned(*include_bytes!(concat!(env!("OUT_DIR"), "/packed.patch")));

/// Everything that the tick writes, and what it reads besides the flash.
pub struct Memory {
    nodes: [Node; NODES],
    node_step: [f32; NODES],
    candidates: [u16; TRIANGLES],
    cap_m: [f32; TRIANGLES],
    /// The desktop keeps what the board computes twice.
    #[cfg(not(target_os = "none"))]
    shapes: [TetShapes; NODES],
}

#[cfg(target_os = "none")]
const _: () = assert!(size_of::<Memory>() <= RAM_FOR_PATCH, "the patch's state must leave room for the stacks");

impl Memory {
    /// As it is reserved.
    pub const RESERVED: Self = Self {
        nodes: [Node::ZERO; NODES],
        node_step: [0.0; NODES],
        candidates: [0; TRIANGLES],
        cap_m: [0.0; TRIANGLES],
        #[cfg(not(target_os = "none"))]
        shapes: [TetShapes::ZERO; NODES],
    };
}

static MEMORY: ConstStaticCell<Memory> = ConstStaticCell::new(Memory::RESERVED);

/// One patch under the device, ready to tick.
pub struct Patch {
    model: Model<'static>,
    tuned: Tuned<'static>,
    state: State<'static>,
    placement: Placement,
}

/// Why there is no patch to tick.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LoadError {
    /// The packed patch in flash was refused.
    Patch(BuildError),
    /// The one state there is has been handed out before.
    StateTaken,
}

/// Checks the patch in flash and puts it at rest. Works once: the state lives in a static.
///
/// # Errors
/// When the patch is refused, and on a second call.
pub fn load() -> Result<Patch, LoadError> {
    let memory = MEMORY.try_take().ok_or(LoadError::StateTaken)?;
    Patch::open(&PATCH_FILE.0, memory).map_err(LoadError::Patch)
}

impl Patch {
    /// Checks a packed patch that starts on a word and puts it at rest in the memory given.
    ///
    /// # Errors
    /// When the patch is refused or does not fit.
    pub fn open(bytes: &'static [u8], memory: &'static mut Memory) -> Result<Self, BuildError> {
        let file = PatchFile::open(bytes)?;
        let model = file.model;
        let placement = Placement::new(file.site_m, file.params.probe.axis);
        let tuned = file.params.build(&model, &mut memory.node_step, &mut memory.cap_m)?;
        #[cfg(not(target_os = "none"))]
        let shapes = &mut memory.shapes[..];
        #[cfg(target_os = "none")]
        let shapes: &mut [TetShapes] = &mut [];
        let state = State::new(&model, &mut memory.nodes, &mut memory.candidates, shapes)?;
        Ok(Self { model, tuned, state, placement })
    }

    /// Answers a pose of the device with the force on its probe, both in the device's frame.
    #[inline(always)]
    pub fn tick(&mut self, pose: ProbePose) -> Output {
        let pose = ProbePose { tip_m: self.placement.to_patch(pose.tip_m) };
        let output = palpate::tick(&self.model, &self.tuned, &mut self.state, pose);
        Output { force_n: self.placement.to_device(output.force_n), ..output }
    }

    /// Hash of all positions and velocities.
    #[must_use]
    pub fn state_hash(&self) -> u64 {
        self.state.hash()
    }

    /// The patch.
    #[must_use]
    pub fn model(&self) -> &Model<'static> {
        &self.model
    }
}
