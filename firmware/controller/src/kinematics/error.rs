//! Reasons for which a mechanism is refused.

use core::fmt;

use serde::{Deserialize, Serialize};

/// Why a mechanism is impossible, or cannot move as its profile says.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(target_os = "none", derive(defmt::Format))]
pub enum MechanismError {
    /// The joint's angle per count is implausibly large or small.
    Encoder,
    /// The motor's torque is implausibly large or small.
    Motor,
    /// No mechanism of this kind can have these dimensions.
    Arms,
    /// The home pose is impossible, or lies outside the workspace.
    Home,
    /// The workspace extends beyond the mechanism's reach.
    Reach,
    /// The motors cannot give the largest force in the home pose.
    Force,
    /// The displacement of the probe per count differs from the profile's `count_m`.
    Count,
}

impl fmt::Display for MechanismError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Encoder => "a joint turns too far or too little in one count: check counts_per_turn and gear_ratio",
            Self::Motor => {
                "a joint's torque at full scale is too large or too small: check torque_constant_n_m_per_a, full_scale_a and gear_ratio"
            }
            Self::Arms => "no such mechanism has these dimensions: check them, in metres",
            Self::Home => "the mechanism cannot be in its home pose, or that lies outside workspace_m: check home_deg and dimensions",
            Self::Reach => "the workspace goes beyond what the mechanism reaches: make workspace_m smaller, or check the dimensions",
            Self::Force => "the motors are too weak for max_force_n in the home pose: lower it, or check torque constant and gear",
            Self::Count => "count_m is not what a count of every joint moves the probe by along an axis at home, within a tenth",
        })
    }
}

impl core::error::Error for MechanismError {}
