//! The command line, run as a user runs it.

mod bad_files_say_what_where_how;
mod bad_input_says_what_where_how;
mod bad_terms_say_what_where_how;
mod bad_tests_say_what_where_how;
mod contact_map_is_written;
mod documents_are_short;
mod drives_reach_their_targets;
mod every_preset_presses;
mod every_scene_key_acts;
mod fit_goes_on;
mod limits_are_data;
mod live_follows_a_board;
mod live_looks_for_a_display;
mod mistyped_command_lines_name_the_help;
mod pictures;
mod press_writes_the_contract;
mod ranges_make_one_run;
mod readme_and_book;
mod readme_commands_run;
mod release_artefacts;
mod replay_is_bit_exact;
mod results_are_never_mixed;
mod scene_reference;
mod summaries_say_how_they_were_made;
mod surfaces_become_tets;
mod terminal;
