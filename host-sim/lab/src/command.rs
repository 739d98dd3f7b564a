//! The commands of `palpate` that this workspace executes. Their command lines are read by
//! [`palpate_sim::command`].

mod accept;
mod chart;
mod fault_adversary;
mod fault_hands;
mod fault_paths;
mod fault_trade;
mod faults;
mod paper;
mod stability;
mod suite;
mod unseen;

use palpate_sim::error::Error;

use crate::study::start;

/// Runs a study.
pub fn run(study: palpate_sim::command::Study<'_>) -> Result<(), Error> {
    use palpate_sim::command::Study as Asked;
    match study {
        Asked::Accept(args) => start(accept::Accept::of(&args.options), &args.cases, &args.out),
        Asked::Chart(args) => chart::run(args),
        Asked::Faults(args) => faults::run(args),
        Asked::Paper(command) => paper::run(command),
        Asked::Suite(args) => start(suite::Suite::of(&args.options), &args.cases, &args.out),
        Asked::Unseen(args) => start(unseen::Unseen::of(&args.options), &args.cases, &args.out),
        Asked::Stability(args) => start(stability::Stability::of(&args.options)?, &args.cases, &args.out),
    }
}

#[cfg(test)]
mod tests {
    use palpate_sim::command::options::accept::TESTS;

    #[test]
    fn palpate_knows_the_names_of_the_tests() {
        assert_eq!(crate::accept::TESTS.map(|(name, ..)| name), TESTS);
    }
}
