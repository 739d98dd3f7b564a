//! A running patch. Its file is read in place (in flash on a board); the tissue core's state is in
//! RAM.

use palpate::haptic::cycle::Renderer;
use palpate::{BuildError, Fault, Model, Output, Params, PatchFile, Placement, ProbePose, State, Tuned, Vector3};

use crate::refusal::Refusal;

pub mod contact;
pub mod cost;
mod refusal;
pub mod site;
pub mod step;

pub use contact::Contact;
pub use cost::Budget;

/// RAM of the smallest supported board, less 16 KB for the stack and 8 KB for everything else.
#[cfg(target_os = "none")]
const RAM_FOR_PATCH: usize = 112 * 1024;

/// Bytes of a patch file, aligned to a word, since a patch is read in place as words.
#[repr(C, align(4))]
pub struct WordAligned<Bytes: ?Sized>(pub Bytes);

/// Everything that the tick writes, and the data that it reads outside the flash: for 480 nodes and
/// 1024 surface triangles, of tissue with relaxation 160 nodes, and 48 nodes at once in contact
/// with a probe with friction. The largest patch that a board has time for has 138 nodes.
#[cfg(not(feature = "small-ram"))]
pub type Memory = palpate::Memory<480, 1024, 160, 48>;
/// As on larger boards, for 160 nodes.
#[cfg(feature = "small-ram")]
pub type Memory = palpate::Memory<160, 512, 160, 48>;

#[cfg(target_os = "none")]
const _: () = assert!(size_of::<Memory>() <= RAM_FOR_PATCH, "the patch's state must leave room for the stacks");

/// One patch at rest or in motion under the device: a renderer in the device's frame.
pub struct Patch<'a> {
    model: Model<'a>,
    params: Params,
    tuned: Tuned<'a>,
    /// Young's modulus in the patch file [Pa].
    packed_pa: f32,
    /// Checksum of the patch file.
    checksum: u32,
    /// Cycles of its costliest tick, by [`cost`].
    predicted_cycles: f32,
    /// Requested Young's modulus that has not been applied yet [Pa].
    asked_pa: Option<f32>,
    state: State<'a>,
    placement: Placement,
    /// Point of the surface at which the patch is pressed [m], in the patch's own frame.
    site_m: Vector3<f32>,
    /// The contact at the depth limit, once it was measured.
    contact: Option<Contact>,
    /// Whether the next tick resets the patch to rest.
    resting: bool,
}

/// Name of a patch's own substep in [`BuildError::OutOfRange`].
pub const SUBSTEP: &str = "substep of the patch in s";
/// Name of a patch's tick in [`BuildError::OutOfRange`] when it differs from the loop's.
pub const TICK: &str = "tick_s of the patch";
/// The loop's tick [s].
pub(crate) const TICK_S: f32 = 1e-3;
/// Name of the foundation's dashpot in [`BuildError::OutOfRange`].
pub const DASHPOT: &str = "contact_damping of the patch";
/// Smallest accepted dashpot (1): that of the shipped patch with the finest elements that a board
/// runs. Without a dashpot, a force that is held constant for a tick creates energy.
const LEAST_DASHPOT: f32 = 0.25;
/// Name of the exponent of stiffening in [`BuildError::OutOfRange`]; boards do not compute that
/// term.
pub const EXPONENT: &str = "stiffening_b of the patch";
/// Largest number of foundation points per triangle: no board's image has room for sixteen.
const MOST_POINTS: usize = 9;
/// Name of Young's modulus in [`BuildError::OutOfRange`] when it is too far from the patch's own.
pub const MODULUS: &str = "youngs_modulus_pa of the patch";

/// Checks a patch as the board would run it, up to the largest modulus that may be requested.
/// Returns the predicted cycles of its costliest tick, and the number of triangles that it presses
/// in it.
///
/// # Errors
/// See [`Patch::open_within`].
// not inlined: the start that follows would keep these masses and parameters on the stack
#[inline(never)]
fn judge(
    budget: &Budget,
    file: &PatchFile,
    memory: &mut Memory,
    after_round: &mut dyn FnMut(),
) -> Result<(f32, usize), BuildError> {
    let (model, params) = (&file.model, &file.params);
    let (mut tuned, scratch) = memory.judge(model, params, after_round)?;
    if model.spring_rows.is_empty() && model.law.is_none() {
        // the board processes springs by rows: without rows it would process none
        return Err(BuildError::LengthMismatch { item: "spring rows", need: model.nodes.len(), have: 0 });
    }
    let most_pressed = site::check(file)?.max(site::most_in_reach(file, after_round));
    let predicted_cycles = budget.check(file, most_pressed)?;
    if model.law.is_some() {
        // a law has no step that could be unstable
        return Ok((predicted_cycles, most_pressed));
    }
    // twice the packed modulus may be requested later
    let stiffest = Params { youngs_modulus_pa: 2.0 * params.youngs_modulus_pa, ..*params };
    // as the board runs it after such a request: the smooth fields stay, their gains are recomputed
    stiffest.retune(model, &mut tuned);
    after_round();
    step::check(model, &stiffest, &tuned, scratch, after_round)?;
    after_round();
    Ok((predicted_cycles, most_pressed))
}

impl<'a> Patch<'a> {
    /// [`Patch::open_within`] with the budget of the fastest board, for the desktop.
    ///
    /// # Errors
    /// See [`Patch::open_within`].
    pub fn open(bytes: &'a [u8], memory: &'a mut Memory, youngs_modulus_pa: Option<f32>) -> Result<Self, BuildError> {
        Self::open_within(&Budget::M7_480, bytes, memory, youngs_modulus_pa, &mut || {})
    }

    /// Checks a packed patch and starts it at rest. The bytes must start on a 4-byte boundary.
    /// `youngs_modulus_pa`, between half and twice the packed one, replaces it. Tick, cost and step
    /// are checked against this board's own bounds, not against the figures in the file.
    /// `after_round` is called repeatedly in between, since opening a large patch takes many ticks.
    ///
    /// # Errors
    /// [`BuildError`], if the file is invalid, the patch does not fit the memory, costs more than
    /// the budget, or cannot be stable with its own substeps.
    pub fn open_within(
        budget: &Budget,
        bytes: &'a [u8],
        memory: &'a mut Memory,
        youngs_modulus_pa: Option<f32>,
        after_round: &mut dyn FnMut(),
    ) -> Result<Self, BuildError> {
        let file = PatchFile::open(bytes)?;
        after_round();
        let (model, mut params) = (file.model, file.params);
        // speeds and masses in the file refer to its tick: with another one the guard would admit
        // other speeds
        BuildError::within(TICK, params.tick_s, TICK_S, TICK_S)?;
        BuildError::within(SUBSTEP, params.tick_s / f32::from(params.substeps.max(1)), 0.0, file.stable_dt_s)?;
        BuildError::within(DASHPOT, params.contact_damping, LEAST_DASHPOT, 1.0)?;
        BuildError::within(EXPONENT, params.stiffening_b, 0.0, 0.0)?;
        if model.points_per_triangle() > MOST_POINTS {
            // the error of a board, whose core does not support them and finds the lengths
            // inconsistent
            let need = MOST_POINTS * model.triangles.len();
            return Err(BuildError::LengthMismatch { item: "foundation", need, have: model.foundation.len() });
        }
        let packed_pa = params.youngs_modulus_pa;
        let (predicted_cycles, most_pressed) = judge(budget, &file, memory, after_round)?;
        if let Some(asked) = youngs_modulus_pa {
            BuildError::within(MODULUS, asked, 0.5 * packed_pa, 2.0 * packed_pa)?;
            params.youngs_modulus_pa = asked;
        }
        let placement = Placement::new(file.site_m, params.probe.axis);
        let (mut tuned, state) = memory.start_in_rounds(&model, &params, after_round)?;
        tuned.most_pressed = most_pressed;
        let checksum = PatchFile::checksum(bytes).unwrap_or_default();
        let site_m = file.site_m;
        let (asked_pa, contact, resting) = (None, None, false);
        Ok(Self {
            model,
            params,
            tuned,
            packed_pa,
            checksum,
            predicted_cycles,
            asked_pa,
            state,
            placement,
            site_m,
            contact,
            resting,
        })
    }

    /// [`Patch::open_within`] for a device: the contact must suit its stiffness ceiling [N/m], and
    /// the tip the elements under it.
    ///
    /// # Errors
    /// Errors of [`Patch::open_within`] and [`Patch::check_contact`].
    pub fn open_for(
        budget: &Budget,
        ceiling_n_per_m: f32,
        bytes: &'a [u8],
        memory: &'a mut Memory,
        youngs_modulus_pa: Option<f32>,
        after_round: &mut dyn FnMut(),
    ) -> Result<Self, Refusal> {
        let mut patch = Self::open_within(budget, bytes, memory, youngs_modulus_pa, after_round)?;
        patch.check_contact(ceiling_n_per_m, after_round)?;
        Ok(patch)
    }

    /// Requests another Young's modulus [Pa], at any time; [`Patch::settle`] applies it.
    ///
    /// # Errors
    /// [`BuildError::OutOfRange`] if it is not between half and twice the packed one.
    pub fn ask_modulus(&mut self, youngs_modulus_pa: f32) -> Result<(), BuildError> {
        self.within_range(youngs_modulus_pa)?;
        self.asked_pa = Some(youngs_modulus_pa);
        Ok(())
    }

    fn within_range(&self, youngs_modulus_pa: f32) -> Result<(), BuildError> {
        BuildError::within(MODULUS, youngs_modulus_pa, 0.5 * self.packed_pa, 2.0 * self.packed_pa)
    }

    /// Applies a requested modulus between two ticks. An increase waits until the probe does not
    /// touch: stiffened under the probe, the tissue would add energy.
    pub fn settle(&mut self, in_contact: bool) {
        let Some(asked_pa) = self.asked_pa.filter(|pascal| !in_contact || *pascal < self.params.youngs_modulus_pa) else {
            return;
        };
        self.asked_pa = None;
        self.params.youngs_modulus_pa = asked_pa;
        self.params.retune(&self.model, &mut self.tuned);
    }

    /// Runs a tick with the tip this deep below the site [m], for a board that measures its
    /// duration.
    #[inline(never)]
    pub fn tap(&mut self, depth_m: f32) {
        let pose = ProbePose { tip_m: self.site_m - self.params.probe.axis * depth_m };
        palpate::tick(&self.model, &self.tuned, &mut self.state, pose);
    }

    /// Puts the patch at rest at once.
    #[inline(never)]
    pub fn rest(&mut self) {
        self.state.reset(&self.model);
    }

    /// Hash of all node positions and velocities.
    #[must_use]
    pub fn state_hash(&self) -> u64 {
        self.state.hash()
    }

    /// Mesh and constants of the patch, as its file contains them.
    #[must_use]
    pub fn model(&self) -> &Model<'a> {
        &self.model
    }

    /// State that the tick changes, in the patch's own frame.
    #[must_use]
    pub fn state(&self) -> &State<'a> {
        &self.state
    }

    /// Transformation between the device's frame and the patch's own.
    #[must_use]
    pub fn placement(&self) -> &Placement {
        &self.placement
    }
}

/// The patch under the device, or none while another one is being uploaded. A tick with force but
/// without a patch is a fault.
pub struct PatchSlot<'a>(pub Option<Patch<'a>>);

impl PatchSlot<'_> {
    /// Nodes of the patch, and the hash of its state.
    #[must_use]
    pub fn state(&self) -> (usize, u64) {
        self.0.as_ref().map_or((0, 0), |patch| (patch.model().nodes.len(), patch.state_hash()))
    }

    /// Checksum of the patch file, Young's modulus [Pa], and predicted cycles of the costliest
    /// tick; zeros while there is no patch.
    #[must_use]
    pub fn identity(&self) -> (u32, f32, f32) {
        let of = |patch: &Patch<'_>| (patch.checksum, patch.params.youngs_modulus_pa, patch.predicted_cycles);
        self.0.as_ref().map_or((0, 0.0, 0.0), of)
    }

    /// Like [`Patch::ask_modulus`], on a device with this stiffness ceiling [N/m].
    ///
    /// # Errors
    /// Errors of [`Patch::ask_modulus`] and [`Patch::check_modulus`], and [`Refusal::NoPatch`] if
    /// there is no patch.
    pub fn ask_modulus(&mut self, youngs_modulus_pa: f32, ceiling_n_per_m: f32) -> Result<(), Refusal> {
        let patch = self.0.as_mut().ok_or(Refusal::NoPatch)?;
        patch.check_modulus(youngs_modulus_pa, ceiling_n_per_m)?;
        Ok(patch.ask_modulus(youngs_modulus_pa)?)
    }

    /// Calls [`Patch::check_contact`] if there is a patch.
    ///
    /// # Errors
    /// Errors of [`Patch::check_contact`].
    pub fn check_contact(&mut self, ceiling_n_per_m: f32, after_round: &mut dyn FnMut()) -> Result<(), Refusal> {
        self.0.as_mut().map_or(Ok(()), |patch| patch.check_contact(ceiling_n_per_m, after_round))
    }

    /// Calls [`Patch::settle`] if there is a patch.
    pub fn settle(&mut self, in_contact: bool) {
        if let Some(patch) = &mut self.0 {
            patch.settle(in_contact);
        }
    }
}

impl Renderer for PatchSlot<'_> {
    #[inline(always)]
    fn render(&mut self, pose: ProbePose) -> Output {
        match &mut self.0 {
            Some(patch) => patch.render(pose),
            None => Output { fault: Some(Fault::SizeMismatch), ..Output::NONE },
        }
    }

    fn reset(&mut self) {
        if let Some(patch) = &mut self.0 {
            patch.reset();
        }
    }
}

impl Renderer for Patch<'_> {
    /// Returns the force on the probe for a pose of the device; both are in the device's frame.
    #[inline(always)]
    fn render(&mut self, pose: ProbePose) -> Output {
        if core::mem::take(&mut self.resting) {
            self.state.reset(&self.model);
            return Output::NONE;
        }
        let pose = self.placement.pose_to_patch(pose);
        self.placement.output_to_device(palpate::tick(&self.model, &self.tuned, &mut self.state, pose))
    }

    /// Requests a reset, which the next tick makes instead of computing a force: one period has no
    /// time for both, and the first tick of arming gives no force in any case.
    fn reset(&mut self) {
        self.resting = true;
    }
}

#[cfg(test)]
mod tests;
