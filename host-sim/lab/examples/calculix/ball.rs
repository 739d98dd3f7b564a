//! Writes the rigid ball as a shell of hexahedra whose nodes all have a prescribed displacement.

use std::fmt::Write;

use super::deck::RADIUS_MM;

/// Number of cells along a side, and their extent from the tip [rad].
const CELLS: usize = 48;
const REACH_RAD: f64 = 60.0 * std::f64::consts::PI / 180.0;
/// Radius of the inner layer, divided by that of the ball (1); it does not take part in the
/// contact.
const INNER: f64 = 0.8;

/// Writes nodes, elements and the outer surface, with the tip at the origin. Numbers continue after
/// `last_node` and `last_element`.
pub fn write(text: &mut String, last_node: usize, last_element: usize) {
    let step = 2.0 * REACH_RAD / CELLS as f64;
    // mean distance by which flat cells with nodes on the sphere would lie inside it
    let outer_mm = RADIUS_MM * (1.0 + step * step / 6.0);
    let side = CELLS + 1;
    text.push_str("*NODE, NSET=BALL\n");
    for (layer, radius_mm) in [outer_mm, INNER * RADIUS_MM].into_iter().enumerate() {
        for k in 0..side * side {
            let [x, y] = [k % side, k / side].map(|n| (n as f64 * step - REACH_RAD).tan());
            let scale = radius_mm / (1.0 + x * x + y * y).sqrt();
            let number = last_node + 1 + layer * side * side + k;
            _ = writeln!(text, "{number}, {:.9}, {:.9}, {:.9}", x * scale, y * scale, RADIUS_MM - scale);
        }
    }
    text.push_str("*ELEMENT, TYPE=C3D8, ELSET=SHELL\n");
    for k in 0..CELLS * CELLS {
        let corner = last_node + 1 + k / CELLS * side + k % CELLS;
        let face = [corner, corner + 1, corner + 1 + side, corner + side];
        let nodes = face.into_iter().chain(face.map(|n| n + side * side));
        let nodes: Vec<String> = nodes.map(|n| n.to_string()).collect();
        _ = writeln!(text, "{}, {}", last_element + 1 + k, nodes.join(", "));
    }
    text.push_str("*SURFACE, NAME=OUTSIDE\nSHELL, S1\n");
    text.push_str("*MATERIAL, NAME=RIGID\n*ELASTIC\n1000., 0.3\n*SOLID SECTION, ELSET=SHELL, MATERIAL=RIGID\n");
}
