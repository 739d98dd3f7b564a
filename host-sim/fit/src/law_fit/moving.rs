//! Branches of a law, fitted to stored ramps by non-negative least squares.
//!
//! The branches are stepped as the core steps them, so the fit sees the tick that will run.

use palpate::{Branch, LAW_FIELDS, MOST_BRANCHES, Params};

use super::squares::Squares;
use palpate_tissue::error::Error;
use palpate_tissue::moving::Ramp;

/// Lengths that are tried [probe radii]; with the last, a branch is a dashpot to the ground.
const LENGTHS_RADII: [f64; 11] = [1.0, 1.5, 2.25, 3.0, 4.0, 5.0, 6.0, 7.5, 10.0, 15.0, f64::INFINITY];
/// Number of masses of a rod, as in the core.
const LUMPS: usize = 4;
/// Number of branches of each of the two shapes, `g^2 = sqrt(d)` and `g^2 = d`.
const EACH: usize = MOST_BRANCHES / 2;

/// Rod of a branch: see the law's stage in the core.
#[derive(Clone, Copy, Default)]
struct Rod {
    moves: [f64; LUMPS],
    pushes: [f64; LUMPS],
}

impl Rod {
    /// Moves the rod by a step, and returns the speed of its near end.
    fn step(&mut self, share: f64, slow: f64, drive: f64) -> f64 {
        let Self { moves, pushes } = self;
        let (mut weight, mut sum) = (slow, moves[LUMPS - 1]);
        let mut after = [[0.0; 2]; LUMPS];
        for n in (1..LUMPS).rev() {
            let part = 1.0 / (weight + share * share);
            let own = sum + share * pushes[n];
            after[n] = [part, own];
            sum = moves[n - 1] - share * pushes[n] + share * share * own * part;
            weight = slow + share * share * weight * part;
        }
        moves[0] = (sum + share * drive) / (weight + share);
        for n in 1..LUMPS {
            let [part, own] = after[n];
            moves[n] = (own + share * share * moves[n - 1]) * part;
            pushes[n] += share * (moves[n - 1] - moves[n]);
        }
        moves[0]
    }
}

/// Force of every candidate branch per its dashpot after each tick of a ramp, shape \[ticks,
/// candidates\]; candidates of the first shape come first.
fn columns(ramp: &Ramp, params: &Params) -> Vec<Vec<f64>> {
    let tick_s = f64::from(params.tick_s);
    let wave_m = tick_s * (ramp.truth.youngs_modulus_pa / f64::from(params.density_kg_per_m3)).sqrt();
    let fades = f64::from(params.node_damping_per_s) * tick_s;
    let radius_m = f64::from(params.probe.radius_m);
    let depths_m = ramp.depths_m();
    let mut rods = vec![Rod::default(); 2 * LENGTHS_RADII.len()];
    let mut rows = Vec::new();
    for pair in depths_m.windows(2) {
        let (d, sink) = (pair[1].max(0.0), (pair[1] - pair[0]) / wave_m);
        let shapes = [d.sqrt().sqrt(), d.sqrt()];
        let row = rods.iter_mut().enumerate().map(|(n, rod)| {
            let (g, length_m) = (shapes[n / LENGTHS_RADII.len()], LENGTHS_RADII[n % LENGTHS_RADII.len()] * radius_m);
            g * (g * sink - rod.step(LUMPS as f64 * wave_m / length_m, 1.0 + fades, g * sink))
        });
        rows.push(row.collect());
    }
    rows
}

/// Branches with the least error over some ramps, with the held part of `row` at their site.
///
/// # Errors
/// A stored ramp cannot be read.
pub fn branches(row: &[f32; LAW_FIELDS], ramps: &[Ramp], params: &Params) -> Result<[Branch; MOST_BRANCHES], Error> {
    let candidates = 2 * LENGTHS_RADII.len();
    let mut squares = Squares::new(candidates);
    let [_, a0, a1, a2, a3] = row.map(f64::from);
    for ramp in ramps {
        let wanted_m2 = ramp.judged_force_over_e_m2();
        let largest_m2 = wanted_m2.iter().copied().fold(0.0, f64::max);
        let weight = 1.0 / (largest_m2 * (wanted_m2.len() as f64).sqrt());
        let (rows, depths_m) = (columns(ramp, params), ramp.depths_m());
        // the first wanted force is that of the tick after the touch
        let touched = depths_m.iter().position(|d| *d > 0.0).unwrap_or_default();
        for ((wanted_m2, d), row) in wanted_m2.iter().zip(&depths_m[touched..]).zip(&rows[touched - 1..]) {
            let held_m2 = d.powf(1.5) * (a0 + d * (a1 + d * (a2 + d * a3)));
            let row: Vec<(usize, f64)> = row.iter().map(|c| c * weight).enumerate().collect();
            squares.add(&row, (wanted_m2 - held_m2) * weight);
        }
    }
    let lengths = LENGTHS_RADII.len();
    let pairs: Vec<[usize; EACH]> = (0..lengths).flat_map(|a| (a + 1..lengths).map(move |b| [a, b])).collect();
    let mut best = (0.0, Vec::new(), Vec::new());
    for [a, b] in &pairs {
        for [c, d] in &pairs {
            let chosen = [*a, *b, lengths + c, lengths + d];
            let (gain, c) = squares.non_negative(&chosen);
            if gain > best.0 {
                best = (gain, chosen.to_vec(), c);
            }
        }
    }
    let mut found = [Branch { c: 0.0, length_m: f32::INFINITY }; MOST_BRANCHES];
    for (branch, (n, c)) in found.iter_mut().zip(best.1.iter().zip(best.2)) {
        let length_m = LENGTHS_RADII[n % lengths] * f64::from(params.probe.radius_m);
        *branch = Branch { c: c as f32, length_m: if c > 0.0 { length_m as f32 } else { f32::INFINITY } };
    }
    Ok(found)
}
