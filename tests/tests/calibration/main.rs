//! Calibration, patches with a far field, and plans.

mod calibrated_patches;
mod calibration_methods;
mod far_field_patches_answer;
mod far_field_patches_hold;
mod lost_presses;
mod moving_presses_agree;
mod nodules_by_touch;
mod plan_keeps_its_promise;
mod shipped_patches_are_current;
