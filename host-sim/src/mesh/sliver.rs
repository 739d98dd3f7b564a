//! Raises the worst tets: flips what can be flipped, moves what can be moved, until neither helps.

use super::flip::Complex;
use super::grading::Grading;
use super::seed::Cloud;
use super::vector::{Vec3, add_scaled};

/// Tets at or above this radius ratio are left alone.
const GOOD: f64 = 0.6;
const PASSES: usize = 12;
/// First and last step of a move, in elements.
const FIRST_STEP: f64 = 0.2;
const LAST_STEP: f64 = 0.01;

/// Improves the tets of a cloud and moves its nodes; no hull face leaves its plane, no tet is inverted.
pub(super) fn remove_slivers(cloud: &mut Cloud, grading: &Grading, tets: Vec<[u32; 4]>) -> Vec<[u32; 4]> {
    if std::env::var("DBG").is_ok() { let mut r: Vec<f64> = super::relax::edges(&tets).iter().map(|e| { let [a,b]=e.map(|n| cloud.at[n as usize]); super::vector::distance(a,b)/grading.size_at(add_scaled(a,0.5,super::vector::sub(b,a)))}).collect(); r.sort_by(f64::total_cmp); let n=r.len(); println!("   befor: min {:.2} 1% {:.2} 10% {:.2} 50% {:.2} 90% {:.2} max {:.2}", r[0], r[n/100], r[n/10], r[n/2], r[n*9/10], r[n-1]);}
    let mut complex = Complex::new(cloud, tets);
    for _ in 0..PASSES {
        let flipped = complex.flip_below(GOOD);
        let moved = smooth(&mut complex, grading);
        if !flipped && !moved {
            break;
        }
    }
    let tets = complex.into_tets();
    if std::env::var("DBG").is_ok() { let mut r: Vec<f64> = super::relax::edges(&tets).iter().map(|e| { let [a,b]=e.map(|n| cloud.at[n as usize]); super::vector::distance(a,b)/grading.size_at(add_scaled(a,0.5,super::vector::sub(b,a)))}).collect(); r.sort_by(f64::total_cmp); let n=r.len(); println!("   after: min {:.2} 1% {:.2} 10% {:.2} 50% {:.2} 90% {:.2} max {:.2}", r[0], r[n/100], r[n/10], r[n/2], r[n*9/10], r[n-1]);}
    tets
}

fn smooth(complex: &mut Complex, grading: &Grading) -> bool {
    let mut moved = false;
    for node in 0..complex.cloud.at.len() {
        let start = complex.worst_around(node, complex.cloud.at[node]);
        if start >= GOOD {
            continue;
        }
        let size = grading.size_at(complex.cloud.at[node]);
        let (mut best, mut step) = (start, FIRST_STEP);
        while step > LAST_STEP {
            let here = complex.cloud.at[node];
            let mut better = here;
            for direction in directions(complex.cloud.pinned[node]) {
                let there = add_scaled(here, step * size, direction);
                let worst = complex.worst_around(node, there);
                if worst > best {
                    (best, better) = (worst, there);
                }
            }
            if better == here {
                step *= 0.5;
            }
            complex.cloud.at[node] = better;
        }
        complex.refresh_around(node);
        moved |= best > start * 1.01;
    }
    moved
}

/// The six axes and eight diagonals that a node may take.
fn directions(pinned: [bool; 3]) -> Vec<Vec3> {
    let mut all = vec![];
    for code in 0..27 {
        let d = [code % 3 - 1, code / 3 % 3 - 1, code / 9 - 1];
        if code != 13 && (0..3).all(|k| d[k] == 0 || !pinned[k]) {
            all.push(d.map(f64::from));
        }
    }
    all
}
