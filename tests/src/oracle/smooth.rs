//! The smooth fields on which the mass matrix is inverted exactly, implemented from their
//! description in `core/src/smooth.rs`.

use palpate::Model;

/// A field; it adds `shape (shape . force) per_kg` to the accelerations.
#[derive(Clone, Debug)]
pub struct Field {
    /// Value of the field at each node, shape \[nodes\], zero at anchors.
    pub shape: Vec<f64>,
    /// Reciprocal of the mass that the series lacks [1/kg].
    pub per_kg: f64,
}

/// Number of averaging rounds, as documented.
const ROUNDS: usize = 32;
/// Smallest eigenvalue, as documented.
const LEAST: f64 = 0.01;

/// Returns the fields of a mass matrix, given by its diagonal and the masses between the ends of
/// springs; the list is empty if all masses between springs' ends are zero. With the two terms of
/// the `series` there are four fields, with the diagonal alone there is one.
pub fn fields(model: &Model, mass_kg: &[f64], between_kg: &[f64], anchored: &[bool], series: bool) -> Vec<Field> {
    if between_kg.iter().all(|kg| *kg == 0.0) {
        return Vec::new();
    }
    let nodes = 0..mass_kg.len();
    let dot = |a: &[f64], b: &[f64]| nodes.clone().map(|n| a[n] * b[n] * mass_kg[n]).sum::<f64>();
    // the off-diagonal part of the matrix times a shape
    let spread = |shape: &[f64]| {
        let mut sum = vec![0.0; shape.len()];
        for (spring, kg) in model.springs.iter().zip(between_kg) {
            let [i, j] = [spring.i, spring.j].map(usize::from);
            sum[i] += kg * shape[j];
            sum[j] += kg * shape[i];
        }
        sum
    };
    let mut shapes: Vec<Vec<f64>> = Vec::new();
    for seed in 0..if series { 4 } else { 1 } {
        let start = |n: usize| if seed == 0 { 1.0 } else { f64::from(model.nodes[n].rest_m[seed - 1]) };
        let mut shape: Vec<f64> = nodes.clone().map(|n| if anchored[n] { 0.0 } else { start(n) }).collect();
        let clear = |shape: &mut Vec<f64>| {
            for other in &shapes {
                let part = dot(shape, other) / dot(other, other);
                shape.iter_mut().zip(other).for_each(|(s, o)| *s -= part * o);
            }
        };
        clear(&mut shape);
        for _ in 0..ROUNDS {
            let sum = spread(&shape);
            shape = nodes.clone().map(|n| if anchored[n] { 0.0 } else { sum[n] / mass_kg[n] }).collect();
        }
        clear(&mut shape);
        shapes.push(shape);
    }
    let gained = shapes.into_iter().filter_map(|shape| {
        let all = dot(&shape, &shape);
        let between: f64 = spread(&shape).iter().zip(&shape).map(|(a, b)| a * b).sum();
        let l = (1.0 - between / all).max(LEAST);
        let (has, below) = if series { (3.0 - 2.0 * l, 0.5) } else { (1.0, 1.0) };
        (l < below).then(|| Field { per_kg: (1.0 / l - has) / all, shape })
    });
    gained.collect()
}
