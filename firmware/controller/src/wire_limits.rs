//! Limits of the haptic loop as they travel over the link and are stored in a profile.

use palpate::haptic::limits::LoopLimitSettings;
use serde::{Deserialize, Serialize};

/// [`LoopLimitSettings`] as two arrays, as sent over the link.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WireLimits {
    /// Largest force [N], slew rate [N/s] and speed [m/s], workspace margin (1), implausible ratio
    /// (1).
    pub scalars: [f32; 5],
    /// Consecutive odd poses (1), largest age of a pose, implausible and saturated ticks [ticks].
    pub counts: [u16; 4],
}

impl From<&LoopLimitSettings> for WireLimits {
    fn from(v: &LoopLimitSettings) -> Self {
        Self {
            scalars: [v.max_force_n, v.max_slew_n_per_s, v.max_speed_m_per_s, v.workspace_margin, v.implausible_ratio],
            counts: [v.odd_poses, v.max_age_ticks, v.implausible_ticks, v.saturated_ticks],
        }
    }
}

impl From<&WireLimits> for LoopLimitSettings {
    fn from(bounds: &WireLimits) -> Self {
        let [max_force_n, max_slew_n_per_s, max_speed_m_per_s, workspace_margin, implausible_ratio] = bounds.scalars;
        let [odd_poses, max_age_ticks, implausible_ticks, saturated_ticks] = bounds.counts;
        Self {
            max_force_n,
            max_slew_n_per_s,
            max_speed_m_per_s,
            odd_poses,
            max_age_ticks,
            workspace_margin,
            implausible_ratio,
            implausible_ticks,
            saturated_ticks,
        }
    }
}
