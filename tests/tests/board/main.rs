//! The firmware in the emulator: results bit-identical to the desktop's, cost, crashes, late ticks.

#[cfg(unix)]
mod a_board_on_a_port;
mod a_rubbing_probe_on_the_board;
mod board_and_desktop_give_the_same_bits;
mod board_cost;
mod classes_agree_with_the_disassembler;
#[cfg(unix)]
mod commission_on_a_port;
mod crashes_turn_the_outputs_off;
mod emulated_board_equals_the_desktop;
mod emulated_loop_equals_the_desktop;
mod flashed_image_runs;
mod flashed_periods;
mod image_fits_the_board;
mod image_has_no_double_precision_and_no_allocator;
mod images_are_built_for_their_cores;
mod images_set_up_their_chips;
mod late_ticks_release_the_force;
mod live_trace_on_the_board;
mod log_over_the_link;
mod mechanisms_on_the_board;
mod mishaps_end_the_force;
#[cfg(unix)]
mod paddle_on_a_port;
mod pico_2_counts_encoder_edges;
mod profiles_stay;
mod self_test_says_same_bits;
mod the_loop_closes_around_the_image;
mod tick_cannot_panic;
mod uart_carries_frames;
