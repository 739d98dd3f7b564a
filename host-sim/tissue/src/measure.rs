//! Quantities measured on a running patch, in `f64`, outside the tick.

use palpate::{Model, State, Vector3};

/// Smallest ratio of a tet's volume to its rest volume (1), and change of the total volume [%].
#[must_use]
pub fn volumes(model: &Model, state: &State) -> (f64, f64) {
    let (mut least, mut total, mut rest_total) = (f64::INFINITY, 0.0, 0.0);
    for tet in model.tets {
        let [a, b, c, d] = tet.node.map(|n| state.nodes()[usize::from(n)].position_m().cast::<f64>());
        let six_volume = (b - a).cross(&(c - a)).dot(&(d - a));
        let rest = 1.0 / f64::from(tet.six_volume_reciprocal);
        least = least.min(six_volume / rest);
        total += six_volume;
        rest_total += rest;
    }
    (least, (total / rest_total - 1.0) * 100.0)
}

/// Displacement of every node from its rest position [m].
#[must_use]
pub fn displacements(model: &Model, state: &State) -> Vec<Vector3<f32>> {
    model.nodes.iter().zip(state.nodes()).map(|(rest, node)| node.position_m() - Vector3::from(rest.rest_m)).collect()
}

/// Largest displacement of a node from its rest position [m].
#[must_use]
pub fn largest_displacement_m(model: &Model, state: &State) -> f64 {
    displacements(model, state).iter().map(|u| f64::from(u.norm())).fold(0.0, f64::max)
}
