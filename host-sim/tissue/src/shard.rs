//! Splits a campaign of numbered cases into parts: the cases of a part, the file that it leaves,
//! and the check that such files make up the whole campaign.
//!
//! ```text
//! --shard 1/2 ─ Shard::cases ─ run ─ Part (shard.jsonl) ┐
//! --shard 2/2 ─ Shard::cases ─ run ─ Part (shard.jsonl) ┴ complete ─ palpate merge ─ as one run
//! ```
//!
//! Any scheduler can start the parts: they do not communicate.

mod complete;
pub mod exact;
mod inputs;
mod part;

use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

pub use complete::complete;
pub use inputs::scene_checksum;
pub use part::{FILE, Heading, Part, PartError, checksum, program};

/// Largest number of parts of a campaign: more than any scheduler takes, and few enough to iterate
/// over.
const MOST: u64 = 10_000_000;

/// Part `number` of `of`, counted from 1; written `7/1000`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct Shard {
    number: u64,
    of: u64,
}

impl Shard {
    /// Part `number` of `of`; `None` unless `1 <= number <= of` and `of` is at most ten million.
    #[must_use]
    pub fn new(number: u64, of: u64) -> Option<Self> {
        (of <= MOST && (1..=of).contains(&number)).then_some(Self { number, of })
    }

    /// Number of the part, counted from 1.
    #[must_use]
    pub fn number(self) -> u64 {
        self.number
    }

    /// Number of parts.
    #[must_use]
    pub fn of(self) -> u64 {
        self.of
    }

    /// Cases of the part out of `total`: consecutive, and as many as in any other part, or one
    /// fewer. Empty if there are fewer cases than parts.
    #[must_use]
    pub fn cases(self, total: u64) -> Range<u64> {
        let border = |shards: u64| (u128::from(total) * u128::from(shards) / u128::from(self.of)) as u64;
        border(self.number - 1)..border(self.number)
    }
}

impl fmt::Display for Shard {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}/{}", self.number, self.of)
    }
}

impl FromStr for Shard {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let numbers = text.split_once('/').and_then(|(number, of)| Some((number.parse().ok()?, of.parse().ok()?)));
        let shard = numbers.and_then(|(number, of)| Self::new(number, of));
        shard.ok_or_else(|| format!("{text} is no shard: give I/N with I from 1 to N and N at most {MOST}, such as 7/1000"))
    }
}

impl TryFrom<String> for Shard {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<Shard> for String {
    fn from(shard: Shard) -> Self {
        shard.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_hold_every_case_once_and_about_equally_many() {
        for (total, of) in [(0, 3), (1, 4), (10, 3), (1000, 1000), (999, 1000), (u64::MAX, 7)] {
            let mut next = 0;
            for number in 1..=of {
                let cases = Shard::new(number, of).unwrap().cases(total);
                assert_eq!(cases.start, next, "{number}/{of} of {total}");
                assert!((total / of..=total.div_ceil(of)).contains(&(cases.end - cases.start)), "{cases:?} of {total}");
                next = cases.end;
            }
            assert_eq!(next, total);
        }
    }

    #[test]
    fn what_is_no_shard_is_refused() {
        assert_eq!("7/1000".parse::<Shard>().unwrap().to_string(), "7/1000");
        for text in ["", "0/4", "5/4", "4", "1/0", "-1/4", "1/4/4", "a/b", "1 /4", "1/10000001", "1/99999999999999999999"] {
            assert!(text.parse::<Shard>().is_err(), "{text}");
        }
    }
}
