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

use std::path::Path;

use palpate_sim::command::campaign::Campaign;
use palpate_sim::command::merge::MergeArgs;
use palpate_sim::error::Error;
use palpate_tissue::shard::Part;

use crate::study::{Runner, Study, start};

type Merge = fn(Vec<Part>, &Path, bool) -> Result<(), Error>;

const fn mergeable<S: Study>() -> (&'static str, Merge) {
    (S::ID, Runner::<S>::merge)
}

/// Studies that run in shards.
const STUDIES: [(&str, Merge); 6] = [
    mergeable::<accept::Accept>(),
    mergeable::<chart::Chart>(),
    mergeable::<faults::Faults>(),
    mergeable::<fault_paths::Paths>(),
    mergeable::<fault_hands::YieldingHands>(),
    mergeable::<stability::Stability>(),
];

/// Runs a study.
///
/// # Errors
/// Its input is invalid, or one of its checks failed.
pub fn run(study: palpate_sim::command::Study<'_>) -> Result<(), Error> {
    use palpate_sim::command::Study as Asked;
    match study {
        Asked::Accept(args) => start::<accept::Accept>(args.options.clone(), &args.shards, &args.out),
        Asked::Chart(args) => chart::run(args),
        Asked::Faults(args) => faults::run(args),
        Asked::Paper(command) => paper::run(command),
        Asked::Stability(args) => start::<stability::Stability>(args.options.clone(), &args.shards, &args.out),
        Asked::Merge(args) => merge(args),
    }
}

fn merge(args: &MergeArgs) -> Result<(), Error> {
    let parts = args.parts()?;
    let study = MergeArgs::campaign(&parts)?.to_owned();
    match STUDIES.into_iter().find(|(id, _)| *id == study) {
        Some((_, merge)) => merge(parts, &args.out, args.all),
        None => Err(MergeArgs::unknown(&study)),
    }
}

#[cfg(test)]
mod tests {
    use palpate_sim::command::merge;
    use palpate_sim::command::options::accept::TESTS;

    use super::STUDIES;

    #[test]
    fn palpate_knows_the_names_of_the_studies_and_of_the_tests() {
        assert_eq!(STUDIES.map(|(id, _)| id), merge::STUDIES);
        assert_eq!(crate::accept::TESTS.map(|(name, ..)| name), TESTS);
    }
}
