//! Improves the worst tets by flips and by moves of nodes, until neither helps.

use super::flip::Complex;
use super::grading::Grading;
use super::seed::Cloud;
use super::vector::{Vec3, add_scaled};

/// Tets at or above this radius ratio are left alone.
const GOOD: f64 = 0.55;
/// Length of an edge, in elements, below which it counts as a fault, so that no small tet shortens
/// the stable time step.
const SHORT_EDGE: f64 = 0.6;
/// Largest number of rounds of flips and moves; most blocks need fewer.
const PASSES: usize = 12;
/// First step of a move, in elements.
const FIRST_STEP: f64 = 0.2;
/// Step below which a move ends, in elements.
const LAST_STEP: f64 = 0.01;
/// Least distance between the shell and a node that is not on it, in elements.
const OFF_SHELL: f64 = 0.35;

/// Improves the tets of a cloud and moves its nodes; hull faces stay in their planes, and no tet is
/// inverted.
pub(super) fn remove_slivers(cloud: &mut Cloud, grading: &Grading, tets: Vec<[u32; 4]>) -> Vec<[u32; 4]> {
    let mut complex = Complex::new(cloud, tets);
    for _ in 0..PASSES {
        let flipped = complex.flip_below(GOOD);
        let moved = smooth(&mut complex, grading);
        if !flipped && !moved {
            break;
        }
    }
    complex.into_tets()
}

fn smooth(complex: &mut Complex, grading: &Grading) -> bool {
    let mut moved = false;
    for node in 0..complex.cloud.at.len() {
        let size = grading.size_at(complex.cloud.at[node]);
        let score = |complex: &Complex, there| complex.worst_around(node, there, SHORT_EDGE * size);
        let start = score(complex, complex.cloud.at[node]);
        if start >= GOOD {
            continue;
        }
        let side = complex.cloud.side[node];
        let (mut best, mut step) = (start, FIRST_STEP);
        while step > LAST_STEP {
            let here = complex.cloud.at[node];
            let mut better = here;
            for direction in directions(complex.cloud.pinned[node]) {
                let there = grading.hold(side, add_scaled(here, step * size, direction), OFF_SHELL * size);
                let worst = score(complex, there);
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

/// Directions in which a node may step, among those to the 26 neighbours of a cube's centre.
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

#[cfg(test)]
mod tests {
    use super::super::delaunay::delaunay;
    use super::super::grading::Grading;
    use super::super::seed::seed;
    use super::*;
    use crate::mesh::block::vector::{cross, dot, sub};
    use crate::mesh::radius_ratio;

    #[test]
    fn worst_tet_rises_and_the_volume_stays() {
        let (low, high) = ([-0.5, -0.5, -1.0], [0.5, 0.5, 0.0]);
        let mut grading = Grading { low, high, spot: [0.0; 3], shell: None, fine_radius: 0.1, fine_size: 0.0, growth: 0.0 };
        let budget = grading.fit(200).unwrap();
        // The cloud is not relaxed, so that there are plenty of slivers.
        let mut cloud = seed(&grading, &budget, 0);
        let tets = delaunay(&cloud.at).unwrap();
        let worst = |cloud: &Cloud, tets: &[[u32; 4]]| {
            tets.iter().map(|t| radius_ratio(t.map(|n| cloud.at[n as usize]))).fold(1.0, f64::min)
        };
        assert!(worst(&cloud, &tets) < 0.1);
        let better = remove_slivers(&mut cloud, &grading, tets);
        assert!(worst(&cloud, &better) > 0.3);
        let six_volume = |t: &[u32; 4]| {
            let [a, b, c, d] = t.map(|n| cloud.at[n as usize]);
            dot(cross(sub(b, a), sub(c, a)), sub(d, a))
        };
        let whole: f64 = better.iter().map(six_volume).sum();
        assert!((whole - 6.0).abs() < 1e-12);
    }
}
