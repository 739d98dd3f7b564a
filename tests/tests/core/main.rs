//! The physics of a tick: energy, momentum, rest and allocation, compared with an oracle in double
//! precision and with recorded force traces; and properties of the source text.

mod allocations;
mod constants_carry_their_source;
mod contact_map;
mod docs_name_the_thing;
mod energy_bound_is_proven;
mod energy_never_grows;
mod floored_power_leaves_the_force;
mod friction;
mod golden_force_traces;
mod imports_run_down;
mod momentum_is_balanced;
mod one_build;
mod oracle_agrees;
mod pins_are_those_of_the_firmware;
mod reaction_equals_anchor_force;
mod relaxation;
mod rest_stays_at_rest;
mod rigid_motion_gives_no_force;
mod stable_step_holds_when_pressed;
mod stiffening;
mod taps_hold_at_one_step;
mod tick_never_allocates;
mod wide_tips_keep_their_force;
