//! The controller's library on this machine: link, configuration, kinematics, uploaded patches.

mod config_survives_a_power_cut;
mod glitched_joints;
// a test of the fast suite; the template for new devices uses its function
#[path = "../../../firmware/controller/tests/board/kinematics_keep_power.rs"]
mod kinematics_keep_power;
mod link_frames_are_checked;
mod mechanism_profiles;
mod mutated_patches;
mod patches_fit_their_boards;
mod your_device;
