//! Defects on purpose, to prove that the fault campaign notices them: `--features planted-defects`, never on a board.
//!
//! A defect stands as one condition at the place where the mistake would be made. Without the feature [`planted`] is a constant false and nothing of it
//! is left in the program.

/// What may be broken on purpose, one at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Defect {
    /// The force is not shortened to its limit.
    NoForceLimit = 1,
    /// Each axis is clipped, not the vector.
    LimitPerAxis,
    /// The limit is asked as `<` of a length that may be NaN.
    NanForcePasses,
    /// The force grows as it likes.
    NoSlewLimit,
    /// The slew limit is twice as high.
    SlewDoubled,
    /// The slew limit holds the force back on its way out, too.
    SlewHoldsBack,
    /// The fall of `SafeRamp` is left out.
    RampDoesNotFall,
    /// A pose that is no number is rendered.
    NanPoseRendered,
    /// The sensor's own verdict is not read.
    SensorUnheard,
    /// A pose of any age is rendered.
    StaleRendered,
    /// A pose may be one tick older than the limit.
    StaleOneMore,
    /// Sequence numbers are compared without their wrap.
    SequenceDoesNotWrap,
    /// Unbelievable poses are forgiven, however many.
    SpeedForgiven,
    /// The first unbelievable pose is rendered.
    GlitchRendered,
    /// The workspace has no end.
    WorkspaceEndless,
    /// What the board found is not read.
    FindingUnheard,
    /// On a fault the device keeps its force.
    FaultKeepsForce,
    /// Damping acts in free space.
    ForceInFreeSpace,
    /// The gain after arming is one at once.
    NoRampIn,
    /// That gain rises while the tissue is pressed.
    RampInRisesInContact,
    /// The host's silence is not heard.
    SilenceUnheard,
    /// The host's silence is counted at half speed.
    SilenceHalfHeard,
    /// A fault is cleared without good poses before.
    ClearedAtOnce,
    /// Arming does not wait for calm.
    ArmedAtOnce,
    /// Arming does not ask whether the probe is outside.
    ArmedInside,
    /// A later fault takes the place of the first.
    FaultReplaced,
    /// A fault ends by itself.
    FaultUnlatched,
    /// A late tick is not heard.
    LateUnheard,
    /// After a late tick the force is not halved.
    LateNotHalved,
    /// Late ticks are not counted over the window.
    LateTicksForgotten,
    /// Energy is not added up.
    EnergyUnseen,
    /// Energy is counted with the force that was sent, not with the one that acts.
    EnergyOfWrongTick,
    /// The gain stays one after an energy alarm.
    EnergyGainStuck,
    /// An implausible force of the model is borne for ever.
    ImplausibleBorne,
    /// Saturation is borne for ever.
    SaturationUnrelieved,
    /// Lowered limits are not taken.
    LoweringIgnored,
    /// Limits may be raised.
    RaisingAllowed,
    /// Damping may pull the probe into the tissue.
    DampingSticks,
    /// A reading that stops dead is believed.
    FrozenBelieved,
    /// A probe that runs away against the force is let run.
    RunawayBorne,
}

#[cfg(feature = "planted-defects")]
mod switch {
    use core::sync::atomic::{AtomicU8, Ordering};

    use super::Defect;

    static PLANTED: AtomicU8 = AtomicU8::new(0);

    impl Defect {
        /// Every one.
        pub const ALL: [Self; 40] = [
            Self::NoForceLimit,
            Self::LimitPerAxis,
            Self::NanForcePasses,
            Self::NoSlewLimit,
            Self::SlewDoubled,
            Self::SlewHoldsBack,
            Self::RampDoesNotFall,
            Self::NanPoseRendered,
            Self::SensorUnheard,
            Self::StaleRendered,
            Self::StaleOneMore,
            Self::SequenceDoesNotWrap,
            Self::SpeedForgiven,
            Self::GlitchRendered,
            Self::WorkspaceEndless,
            Self::FindingUnheard,
            Self::FaultKeepsForce,
            Self::ForceInFreeSpace,
            Self::NoRampIn,
            Self::RampInRisesInContact,
            Self::SilenceUnheard,
            Self::SilenceHalfHeard,
            Self::ClearedAtOnce,
            Self::ArmedAtOnce,
            Self::ArmedInside,
            Self::FaultReplaced,
            Self::FaultUnlatched,
            Self::LateUnheard,
            Self::LateNotHalved,
            Self::LateTicksForgotten,
            Self::EnergyUnseen,
            Self::EnergyOfWrongTick,
            Self::EnergyGainStuck,
            Self::ImplausibleBorne,
            Self::SaturationUnrelieved,
            Self::LoweringIgnored,
            Self::RaisingAllowed,
            Self::DampingSticks,
            Self::FrozenBelieved,
            Self::RunawayBorne,
        ];

        /// Plants this defect in every loop of the process, in place of the one before.
        pub fn plant(self) {
            PLANTED.store(self as u8, Ordering::SeqCst);
        }

        /// Takes every defect out.
        pub fn heal() {
            PLANTED.store(0, Ordering::SeqCst);
        }
    }

    /// Whether this defect is planted.
    #[inline]
    pub(crate) fn planted(defect: Defect) -> bool {
        PLANTED.load(Ordering::Relaxed) == defect as u8
    }
}

#[cfg(feature = "planted-defects")]
pub(crate) use switch::planted;

/// Whether this defect is planted: never.
#[cfg(not(feature = "planted-defects"))]
#[inline(always)]
pub(crate) const fn planted(_: Defect) -> bool {
    false
}

#[cfg(all(feature = "planted-defects", target_os = "none"))]
compile_error!("planted-defects breaks the loop on purpose: it is for the tests on the desktop, never for a board");
