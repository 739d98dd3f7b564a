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

use palpate_sim::command::Study;
use palpate_sim::command::campaign::Campaign;
use palpate_sim::command::merge::MergeArgs;
use palpate_sim::error::Error;

use self::accept::Accept;
use self::chart::Chart;
use self::fault_hands::YieldingHands;
use self::fault_paths::Paths;
use self::faults::Faults;
use self::stability::Stability;

/// Runs a study.
///
/// # Errors
/// Its input is invalid, or one of its checks failed.
pub fn run(study: Study<'_>) -> Result<(), Error> {
    match study {
        Study::Accept(args) => accept::run(args),
        Study::Chart(args) => chart::run(args),
        Study::Faults(args) => faults::run(args),
        Study::Paper(command) => paper::run(command),
        Study::Stability(args) => stability::run(args),
        Study::Merge(args) => merge(args),
    }
}

fn merge(args: &MergeArgs) -> Result<(), Error> {
    let parts = args.parts()?;
    let (out, all) = (&args.out, args.all);
    let campaign = MergeArgs::campaign(&parts)?.to_owned();
    match campaign.as_str() {
        Accept::COMMAND => Accept::merge(parts, out, all),
        Chart::COMMAND => Chart::merge(parts, out, all),
        Faults::COMMAND => Faults::merge(parts, out, all),
        Paths::COMMAND => Paths::merge(parts, out, all),
        YieldingHands::COMMAND => YieldingHands::merge(parts, out, all),
        Stability::COMMAND => Stability::merge(parts, out, all),
        other => Err(MergeArgs::unknown(other)),
    }
}

#[cfg(test)]
mod tests {
    use palpate_sim::command::merge::STUDIES;
    use palpate_sim::command::options::accept::TESTS;

    use super::*;

    #[test]
    fn palpate_knows_the_names_of_the_campaigns_and_of_the_tests() {
        let campaigns =
            [Accept::COMMAND, Chart::COMMAND, Faults::COMMAND, Paths::COMMAND, YieldingHands::COMMAND, Stability::COMMAND];
        assert_eq!(campaigns, STUDIES);
        assert_eq!(crate::accept::TESTS.map(|(name, ..)| name), TESTS);
    }
}
