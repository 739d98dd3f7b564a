//! Permutation test of a difference of means.
//!
//! Marks are discrete and bounded and groups are small, so no distribution is assumed. A deal is a
//! way to divide the pooled values into two groups of the given sizes; the test counts the deals
//! whose means differ at least as much as those of the actual groups (two-sided).

use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};
use serde::Serialize;

/// Result of a permutation test.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Permutation {
    /// Share of the deals whose means differ at least as much as the observed ones (1).
    pub p: f64,
    /// Number of deals examined.
    pub deals: u64,
    /// Whether all deals were examined; otherwise they were drawn at random with a fixed seed.
    pub exact: bool,
}

/// Largest number of possible deals at which all of them are examined.
const ALL_DEALS: u64 = 1_000_000;
/// Number of deals that are drawn if there are more.
const DRAWN: u64 = 200_000;
/// Tolerance for comparing sums of the same values in another order, which differ by rounding; it
/// is far smaller than one mark.
const SAME: f64 = 1e-9;

/// Tests whether two samples differ in their means; `None` if one is empty.
pub fn permutation_test(a: &[f64], b: &[f64]) -> Option<Permutation> {
    if a.is_empty() || b.is_empty() {
        return None;
    }
    let mut pool: Vec<f64> = a.iter().chain(b).copied().collect();
    let (n, k) = (pool.len(), a.len());
    let total: f64 = pool.iter().sum();
    // with n, k and total fixed, the difference of the means is a linear function of the first sum
    let distance = |first: f64| (first / k as f64 - (total - first) / (n - k) as f64).abs();
    let found = distance(a.iter().sum()) - SAME;
    if let Some(deals) = choices(n, k).filter(|d| *d <= ALL_DEALS) {
        let extreme = count_deals(&pool, k, 0.0, &|first| distance(first) >= found);
        return Some(Permutation { p: extreme as f64 / deals as f64, deals, exact: true });
    }
    let mut dice = Xoshiro256PlusPlus::seed_from_u64(14);
    let mut extreme = 0;
    for _ in 0..DRAWN {
        for i in 0..k {
            let j = i + (dice.next_u64() % (n - i) as u64) as usize;
            pool.swap(i, j);
        }
        extreme += u64::from(distance(pool[..k].iter().sum()) >= found);
    }
    // the observed deal is counted as one of them, so p is never zero
    Some(Permutation { p: (extreme + 1) as f64 / (DRAWN + 1) as f64, deals: DRAWN, exact: false })
}

/// Number of ways to choose k of n; `None` if it exceeds u64.
fn choices(n: usize, k: usize) -> Option<u64> {
    (0..k.min(n - k)).try_fold(1_u64, |ways, i| Some(ways.checked_mul((n - i) as u64)? / (i as u64 + 1)))
}

/// Number of choices of `k` values from `pool` whose sum plus `so_far` is extreme.
fn count_deals(pool: &[f64], k: usize, so_far: f64, extreme: &impl Fn(f64) -> bool) -> u64 {
    if k == 0 {
        return u64::from(extreme(so_far));
    }
    let last = pool.len() + 1 - k;
    (0..last).map(|i| count_deals(&pool[i + 1..], k - 1, so_far + pool[i], extreme)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn separated_groups_have_the_p_of_counting() {
        // 2 of C(6,3) = 20 deals put all small values on one side
        let test = permutation_test(&[1.0, 2.0, 3.0], &[11.0, 12.0, 13.0]).unwrap();
        assert_eq!((test.deals, test.exact), (20, true));
        assert!((test.p - 0.1).abs() < 1e-12);
        assert_eq!(permutation_test(&[1.0], &[]), None);
    }

    #[test]
    fn equal_groups_differ_by_chance_always() {
        assert_eq!(permutation_test(&[0.1, 0.2, 0.3], &[0.3, 0.1, 0.2]).unwrap().p, 1.0);
    }

    #[test]
    fn drawn_deals_agree_with_the_normal_limit() {
        // 40 + 40 values: the difference of means is near normal; sd = sqrt(S/(N-1) * N/(k (N-k)))
        let a: Vec<f64> = (0..40).map(|i| f64::from(i * 7 % 40)).collect();
        let b: Vec<f64> = a.iter().map(|v| v + 5.0).collect();
        let test = permutation_test(&a, &b).unwrap();
        assert!(!test.exact);
        let pool: Vec<f64> = a.iter().chain(&b).copied().collect();
        let mean = pool.iter().sum::<f64>() / 80.0;
        let squares: f64 = pool.iter().map(|v| (v - mean).powi(2)).sum();
        let sd = (squares / 79.0 * 80.0 / 1600.0).sqrt();
        // two-sided tail of the normal at 5 / sd, by the midpoint rule
        let z = 5.0 / sd;
        let tail = (0..80_000).map(|i| z + (f64::from(i) + 0.5) * 1e-4).map(|x| (-x * x / 2.0).exp() * 1e-4).sum::<f64>();
        let expected = 2.0 * tail / std::f64::consts::TAU.sqrt();
        assert!((test.p - expected).abs() < 0.005, "{} against {expected}", test.p);
    }
}
