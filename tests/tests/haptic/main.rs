//! The haptic loop: faults, closed loops with emulated hands, recorded traces. Campaigns of faults,
//! paths and yielding hands are tests of the evidence.

mod boot_inside_tissue_gives_no_force;
mod checks_are_on;
mod commissioning;
mod faults_give_zero_force;
mod haptic_closed_loop;
mod haptic_invariants;
mod live_feel;
mod live_replay;
mod loop_closes;
mod safety_table;
mod taps_are_faithful;
mod tilted_tip;
