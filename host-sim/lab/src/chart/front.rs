//! The Pareto front: what nothing else beats in cost and error both.

/// Indices of the points (cost, error) that no other point beats, by rising cost. A point that is
/// not finite is on no front; of equal points the first is.
#[must_use]
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
