//! Command line of `palpate faults`.

use std::path::PathBuf;

use clap::Args;

use crate::command::campaign::CaseArgs;

/// Largest number of runs: two months on a thousand cores; a larger number is probably a typing
/// error.
const MOST_CASES: u64 = 100_000_000_000;

#[derive(Args, Clone, Debug)]
pub struct FaultsArgs {
    /// Runs, spread evenly over the kinds of fault [default: 100000, with --quick 6000].
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u64).range(100..=MOST_CASES))]
    pub runs: Option<u64>,
    /// Seed for the draw of hands, motions and moments.
    #[arg(long, value_name = "NUMBER", default_value_t = 1)]
    pub seed: u64,
    /// Also run this many seconds of normal use, in which no fault may occur. It is one long run,
    /// so --cases excludes it.
    #[arg(conflicts_with = "cases", long = "soak-s", value_name = "SECONDS", default_value_t = 0, value_parser = clap::value_parser!(u32).range(0..=1_000_000))]
    pub soak_s: u32,
    /// Instead, run this many random paths (at least 10) through, along, around and under every
    /// shipped patch, at 1-100 kPa, on every device. Writes paths.csv and summary.json; exits with
    /// 1 if a path breaks an invariant, or a fault ends motion that a hand can make.
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u64).range(10..=MOST_CASES), conflicts_with_all = ["runs", "soak_s"])]
    pub paths: Option<u64>,
    /// Instead, run this many random yielding hands (at least 10), every second one on a shipped
    /// device, a fixed family of light hands on stiff tissue, and, without --quick, a minute of
    /// each motion on each shipped device. Writes hands.csv and summary.json; exits with 1 if more
    /// energy is given, or less force is felt, than promised.
    #[arg(long, value_name = "COUNT", value_parser = clap::value_parser!(u64).range(10..=MOST_CASES), conflicts_with_all = ["runs", "soak_s", "paths"])]
    pub hands: Option<u64>,
    /// Instead, search over hands, motions, tissues, tips and devices for the most energy that a
    /// hand can be given; exits with 1 if it exceeds the printed bound.
    #[arg(long, conflicts_with_all = ["runs", "soak_s", "paths", "hands", "cases"])]
    pub adversary: bool,
    /// Rounds of the search, with --adversary [default: 60, with --quick 4].
    #[arg(long, value_name = "COUNT", requires = "adversary", value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub rounds: Option<u64>,
    /// Run what the search found again, as it was printed, with --adversary.
    #[arg(long, value_name = "RUN", requires = "adversary", conflicts_with = "rounds", value_parser = named_run)]
    pub genes: Option<String>,
    /// Instead, compare settings of the energy account: the force that is felt against the energy
    /// that is given. Writes trade.csv, summary.json and pictures.
    #[arg(long, conflicts_with_all = ["runs", "soak_s", "paths", "hands", "adversary", "cases"])]
    pub trade: bool,
    /// Run fewer: 6000 runs, or at most 4000 paths (12 and 32 s of processor time), or at most 400
    /// shorter runs of hands.
    #[arg(long)]
    pub quick: bool,
    /// Output folder, created if missing; a finished run replaces an earlier result in it.
    #[arg(long, value_name = "FOLDER", default_value = "out/faults")]
    pub out: PathBuf,
    #[command(flatten)]
    pub cases: CaseArgs,
}

/// Hexadecimal digits that describe a run of a yielding hand.
pub const RUN_DIGITS: usize = 124;

/// Accepts a run as `palpate faults --adversary` prints it: `person:` or `hand:` and its digits.
fn named_run(text: &str) -> Result<String, String> {
    let digits = text.strip_prefix("person:").or_else(|| text.strip_prefix("hand:"));
    match digits {
        Some(digits) if digits.len() == RUN_DIGITS && digits.bytes().all(|b| b.is_ascii_hexdigit()) => Ok(text.to_owned()),
        _ => Err(format!(
            "give a run as `palpate faults --adversary` prints it: person: or hand:, and {RUN_DIGITS} hexadecimal digits"
        )),
    }
}
