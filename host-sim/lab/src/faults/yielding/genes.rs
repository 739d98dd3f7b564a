//! The numbers that describe a run.

use std::fmt;
use std::slice::Iter;
use std::str::FromStr;

use rand_xoshiro::SplitMix64;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

/// Number of numbers that describe a run.
pub const GENES: usize = 31;
/// Largest gene.
const MOST: f64 = u16::MAX as f64;

/// The numbers that describe a run. As text they are hexadecimal, four digits per number, which
/// repeats the run exactly.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Genes([u16; GENES]);

impl Genes {
    /// Every gene in the middle of its range.
    pub const MIDDLE: Self = Self([u16::MAX / 2; GENES]);

    /// Draws the run with this number.
    pub fn draw(number: u64, seed: u64) -> Self {
        let mut random = source(number, seed);
        Self(std::array::from_fn(|_| random.next_u64() as u16))
    }

    /// A neighbour: one to four genes move by a tenth of their range or so, or are drawn anew.
    pub fn mutated(&self, number: u64, seed: u64) -> Self {
        let mut random = source(number, seed);
        let mut share = || (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64;
        let mut genes = *self;
        for _ in 0..=(4.0 * share()) as usize {
            let at = (share() * GENES as f64) as usize;
            if let Some(gene) = genes.0.get_mut(at) {
                let anew = share() < 0.25;
                let step = 0.3 * (share() + share() - 1.0);
                let value = if anew { share() } else { f64::from(*gene) / MOST + step };
                *gene = (value.clamp(0.0, 1.0) * MOST) as u16;
            }
        }
        genes
    }

    /// Reads the numbers one after the other.
    pub(super) fn reader(&self) -> Reader<'_> {
        Reader(self.0.iter())
    }
}

fn source(number: u64, seed: u64) -> SplitMix64 {
    SplitMix64::seed_from_u64(seed ^ number.wrapping_mul(0x9e37_79b9_7f4a_7c15))
}

impl fmt::Display for Genes {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|gene| write!(f, "{gene:04x}"))
    }
}

impl FromStr for Genes {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || format!("a run is {} hexadecimal digits, as `palpate faults --adversary` prints them", 4 * GENES);
        if !text.is_ascii() || text.len() != 4 * GENES {
            return Err(wrong());
        }
        let mut genes = [0; GENES];
        for (gene, digits) in genes.iter_mut().zip(text.as_bytes().chunks(4)) {
            let digits = std::str::from_utf8(digits).map_err(|_| wrong())?;
            *gene = u16::from_str_radix(digits, 16).map_err(|_| wrong())?;
        }
        Ok(Self(genes))
    }
}

/// Reads the numbers of a run one after the other, each between 0 and 1.
pub(super) struct Reader<'a>(Iter<'a, u16>);

impl Reader<'_> {
    pub(super) fn share(&mut self) -> f64 {
        self.0.next().map_or(0.5, |gene| f64::from(*gene) / MOST)
    }

    /// An index below `count`.
    pub(super) fn below(&mut self, count: usize) -> usize {
        ((self.share() * count as f64) as usize).min(count.saturating_sub(1))
    }

    pub(super) fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.share()
    }

    /// A number between `low` and `high` whose logarithm is linear in the gene.
    pub(super) fn by_factor(&mut self, low: f64, high: f64) -> f64 {
        low * (high / low).powf(self.share())
    }

    /// Zero for genes below `share`, and a number between `low` and `high` for the others.
    pub(super) fn or_zero(&mut self, share: f64, low: f64, high: f64) -> f64 {
        let at = self.share();
        if at < share { 0.0 } else { low + (high - low) * (at - share) / (1.0 - share) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn genes_are_read_back_from_their_text_and_other_text_is_refused() {
        let genes = Genes::draw(7, 3);
        assert_eq!(genes.to_string().parse(), Ok(genes));
        assert_ne!(genes, Genes::draw(8, 3));
        for wrong in ["", "00", &"g".repeat(4 * GENES), &"\u{e9}".repeat(2 * GENES)] {
            assert!(wrong.parse::<Genes>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_neighbour_differs_in_a_few_genes() {
        for number in 0..100 {
            let (one, other) = (Genes::MIDDLE, Genes::MIDDLE.mutated(number, 1));
            let differ = one.0.iter().zip(other.0).filter(|(a, b)| **a != *b).count();
            assert!((1..=4).contains(&differ), "{differ}");
        }
    }
}
