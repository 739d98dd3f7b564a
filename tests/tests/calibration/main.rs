//! Calibration, patches with a far field, and the smallest patch.

mod calibrated_patches;
mod calibration_methods;
mod far_field_patches_answer;
mod far_field_patches_hold;
mod laws_stiffen;
mod lost_presses;
mod moving_presses_agree;
mod nodules_by_touch;
mod shipped_patches_are_current;
mod smallest_keeps_its_promise;
