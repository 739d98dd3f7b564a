//! Every numbered equation of the two papers that runs on the core, compared with the printed (or
//! reconstructed) formula in double precision.

mod local_compression;
mod volume_preserved;

use crate::bench::{Bench, Deformation, Noise};
use palpate::{Model, Params, State, Terms, Vector3};

type Vector = Vector3<f64>;

/// Tolerance for single precision: a sum of some 15 terms, each the result of some 20 roundings of
/// 6e-8, after cancellation between lengths that differ by a few per cent.
const ROUNDING: f64 = 1e-4;

/// A block as in the papers: springs only, masses of (10).
fn bench() -> Bench {
    Bench::block(60).with(|p| {
        p.terms = Terms::SPRINGS_ONLY;
        p.mass_floor = 0.0;
        p.node_damping_per_s = 0.0;
        p.tick_s = 1e-4;
    })
}

/// Deforms a block by some 8 % and gives its nodes velocities of up to 0.1 m/s.
fn deform(model: &Model, state: &mut State, seed: u64) {
    let mut noise = Noise::new(seed);
    for (n, x) in (Deformation { seed, strain: 0.05, jitter: 0.08 }).of(model).into_iter().enumerate() {
        state.place(n, x, (noise.vector() * 0.1).cast());
    }
}

fn positions(state: &State) -> Vec<Vector> {
    state.nodes().iter().map(|n| n.position_m().cast()).collect()
}

fn velocities(state: &State) -> Vec<Vector> {
    state.nodes().iter().map(|n| n.velocity_m_per_s().cast()).collect()
}

/// Node forces of the last substep [N].
fn forces_n(state: &State, params: &Params) -> Vec<Vector> {
    state.nodes().iter().map(|n| n.force_over_modulus().cast::<f64>() * f64::from(params.youngs_modulus_pa)).collect()
}

/// End nodes, stiffness [N/m] and rest length [m] of each spring.
fn springs(model: &Model, params: &Params) -> Vec<([usize; 2], f64, f64)> {
    let e = f64::from(params.youngs_modulus_pa);
    model.springs.iter().map(|s| ([s.i.into(), s.j.into()], e * f64::from(s.k), f64::from(s.k_rest) / f64::from(s.k))).collect()
}

/// Mass of each node by (10) [kg].
fn masses_kg(model: &Model, params: &Params) -> Vec<f64> {
    model.nodes.iter().map(|n| f64::from(params.density_kg_per_m3) * f64::from(n.volume_m3)).collect()
}

#[track_caller]
fn assert_close(found: &[Vector], wanted: &[Vector], what: &str) {
    let size = wanted.iter().map(Vector::norm).fold(0.0, f64::max);
    assert!(size > 0.0, "{what}: nothing to compare");
    for (n, (f, w)) in found.iter().zip(wanted).enumerate() {
        assert!((f - w).norm() <= ROUNDING * size, "{what}: node {n} has {f:?}, the formula says {w:?}");
    }
}
