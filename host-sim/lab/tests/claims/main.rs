//! The studies keep their claims, in short form: the two papers, the methods with which the product
//! is compared, stability, faults, measured tissue, and the commands of `palpate` that report them.

// helpers of the product's tests, each of which some of these tests need in part
#[path = "../../../../tests/tests/core/allocations.rs"]
mod allocations;
#[path = "../../../../tests/src/bench.rs"]
#[allow(dead_code)]
mod bench;
#[path = "../../../../tests/src/case_ranges.rs"]
mod case_ranges;
#[path = "../../../../tests/src/palpate_command.rs"]
#[allow(dead_code)]
mod palpate_command;
#[path = "../../../../tests/src/schema.rs"]
#[allow(dead_code)]
mod schema;
#[path = "../../../../tests/src/share.rs"]
#[allow(dead_code)]
mod share;

mod accepted;
mod dynamic_truth;
mod fault_campaign;
mod faults_are_printed;
mod hanging;
mod known_limit_cycle;
mod methods_are_right;
mod methods_never_allocate;
mod no_force_without_contact;
mod paper_formulas;
mod paper_local_compression;
mod paper_pictures;
mod paper_volume_preserved;
mod papers_table;
mod ranges_make_one_run;
mod soak;
mod stability_loop;
mod stability_model;
mod suite;
mod yielding_hands;
