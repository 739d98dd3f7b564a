//! Pareto fronts: the points that no other point beats in both cost and error, or in cost and two
//! errors.

/// Indices of the points (cost, error) that no other point beats, by rising cost. A point that is
/// not finite is left out; of equal points the first one is kept.
pub fn front(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).filter(|&n| points[n].0.is_finite() && points[n].1.is_finite()).collect();
    order.sort_by(|&a, &b| points[a].0.total_cmp(&points[b].0).then(points[a].1.total_cmp(&points[b].1)));
    let mut least = f64::INFINITY;
    order.retain(|&n| {
        let better = points[n].1 < least;
        least = least.min(points[n].1);
        better
    });
    order
}

/// Indices of the points (cost, error, error) that no other point matches in two of the three
/// quantities and beats in the third, by rising cost. A point that is not finite is left out; of
/// equal points the first one is kept.
pub fn front_of_three(points: &[[f64; 3]]) -> Vec<usize> {
    let finite = |n: &usize| points[*n].iter().all(|v| v.is_finite());
    let beaten_by = |a: usize, b: usize| {
        let no_worse = points[b].iter().zip(points[a]).all(|(b, a)| *b <= a);
        no_worse && (points[b] != points[a] || b < a)
    };
    let all: Vec<usize> = (0..points.len()).filter(finite).collect();
    let mut front: Vec<usize> = all.iter().copied().filter(|&a| !all.iter().any(|&b| b != a && beaten_by(a, b))).collect();
    front.sort_by(|&a, &b| points[a][0].total_cmp(&points[b][0]));
    front
}
