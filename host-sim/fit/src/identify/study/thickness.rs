//! A thickness of which only a range is known.

use super::super::fit::{CHI_90, Quantity};
use super::super::record::Record;
use super::{Identified, Plan, identify, identify_with};

/// Number of thicknesses of a range that are tried, and how often the best one's neighbourhood is
/// halved.
const THICKNESSES: usize = 4;
const HALVINGS: usize = 3;
/// Half width of the interval of a thickness, in its logarithm, up to which it is known (1).
const TOLD_THICKNESS: f64 = 0.2;

/// Identifies a tissue together with its thickness, of which only a range [m] is known.
///
/// # Errors
/// As [`identify`]; or only the combination of thickness, modulus and exponent is known, or the
/// range ends before the best thickness.
pub fn identify_within(plan: &Plan, range_m: [f64; 2], records: &[Record]) -> Result<Identified, String> {
    let at = |ln: f64| {
        let [x, y, _] = plan.block_m;
        identify(&Plan { block_m: [x, y, ln.exp()], ..*plan }, records).map(|found| (ln, found))
    };
    let [low, high] = range_m.map(f64::ln);
    let even = (0..THICKNESSES).map(|n| low + (high - low) * n as f64 / (THICKNESSES - 1) as f64);
    // a slab that is too thin for the depth has no equilibrium
    let mut unsolved = String::new();
    let mut tried: Vec<(f64, Identified)> = even.filter_map(|ln| at(ln).map_err(|why| unsolved = why).ok()).collect();
    if tried.is_empty() {
        return Err(unsolved);
    }
    for _ in 0..HALVINGS {
        let (best, count) = (likely(&tried).1, tried.len());
        if !combined(&tried, 0).is_empty() {
            break;
        }
        for n in [best + 1, best].into_iter().filter(|n| (1..count).contains(n)) {
            // as an end of the range, it may be too thin for the depth
            if let Ok(between) = at(tried[n - 1].0.midpoint(tried[n].0)) {
                tried.insert(n, between);
            }
        }
    }
    let why = combined(&tried, 1);
    if !why.is_empty() {
        return Err(format!("{}: {why}", records[0].name));
    }
    let ([first, last], best) = likely(&tried);
    let (end, is_whole) = (tried.len() - 1, first == 0 && last + 1 == tried.len());
    if (best == 0 || best == end) && !is_whole {
        return Err(format!(
            "{}: a thickness of {:.2} mm fits best, at the end of the range or of what this depth allows: give a wider range, or measure the thickness and state it with --thickness",
            records[0].name,
            tried[best].0.exp() * 1e3
        ));
    }
    // the end of the interval lies between a likely thickness and its unlikely neighbour
    let thickness_m = [tried[first.saturating_sub(1)].0, tried[(last + 1).min(end)].0].map(f64::exp);
    let of = |of: Quantity| {
        let all = tried[first..=last].iter().filter_map(|(_, found)| Some(found.of(of)?.interval));
        (of, all.fold([f64::MAX, f64::MIN], |[a, b], [c, d]| [a.min(c), b.max(d)]))
    };
    let others = [Quantity::Modulus, Quantity::Relaxed, Quantity::Exponent].map(of);
    let mut found = identify_with(&Plan { block_m: tried[best].1.block_m, ..*plan }, records, &others)?;
    found.thickness_m = thickness_m;
    let [low_mm, high_mm] = thickness_m.map(|m| m * 1e3);
    let how = if is_whole { "is anywhere in its range" } else { "is fitted" };
    found.unsaid.insert(0, format!("the thickness {how}, between {low_mm:.2} and {high_mm:.2} mm; state it with --thickness"));
    Ok(found)
}

/// First and last of the thicknesses that are likely at 90 %, and the most likely one.
fn likely(tried: &[(f64, Identified)]) -> ([usize; 2], usize) {
    let best = (0..tried.len()).min_by(|a, b| tried[*a].1.left.total_cmp(&tried[*b].1.left)).unwrap_or(0);
    let near = |n: &usize| tried[*n].1.left < tried[best].1.left + CHI_90 * tried[best].1.inflation;
    ([(0..tried.len()).find(near).unwrap_or(best), (0..tried.len()).rev().find(near).unwrap_or(best)], best)
}

/// Sentence on likely thicknesses, with some neighbours, that are too different to be called known;
/// empty if there is none.
fn combined(tried: &[(f64, Identified)], neighbours: usize) -> String {
    let ([first, last], _) = likely(tried);
    let (first, last) = (first.saturating_sub(neighbours), (last + neighbours).min(tried.len() - 1));
    if tried[last].0 - tried[first].0 <= 2.0 * TOLD_THICKNESS {
        return String::new();
    }
    let [from, to] = [first, last].map(|n| {
        let (ln, Identified { tissue, .. }) = &tried[n];
        format!("{:.1} mm with {:.2} kPa and b = {:.2}", ln.exp() * 1e3, tissue.youngs_modulus_pa * 1e-3, tissue.stiffening_b)
    });
    format!(
        "only the combination of thickness, modulus and exponent is known, from {from} to {to}: measure the thickness and state it with --thickness, or press deeper"
    )
}
