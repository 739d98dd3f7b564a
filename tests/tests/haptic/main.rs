//! The haptic loop: no force without contact, faults, closed loops with emulated hands, recorded
//! traces.

mod boot_inside_tissue_gives_no_force;
mod checks_are_on;
mod fault_campaign;
mod faults_give_zero_force;
mod haptic_closed_loop;
mod haptic_invariants;
mod known_limit_cycle;
mod live_feel;
mod live_replay;
mod loop_closes;
mod no_force_without_contact;
mod safety_table;
mod soak;
mod taps_are_faithful;
