//! Held part of a law: the splines of touch height and constants over the places.

use palpate::LAW_FIELDS;

use super::LawPresses;
use super::squares::Squares;
use crate::calibrate::places::sunflower;
use crate::statics::Vector;

/// Number of places over the disc, besides the centre.
pub(super) const PLACES: usize = 80;
/// Number of steps from the shallowest to the deepest press, of equal ratio.
const DEPTHS: usize = 10;
/// Constants of the force at a place: `d^(3/2) (a0 + a1 d + a2 d^2 + a3 d^3)`.
const CONSTANTS: usize = LAW_FIELDS - 1;
/// Depth by which the powers of d are scaled, so that the constants are of one size [m].
const SCALE_M: f64 = 4e-3;
/// Weight of the bending of a table (1), against relative errors of the force: it decides where no
/// place is, as in the corners.
const BENDING: f64 = 1e-4;

/// Adds the bending of every field of a table.
fn smooth(squares: &mut Squares, side: usize, fields: usize) {
    let at = |x: usize, y: usize, field: usize| (y * side + x) * fields + field;
    let bend = |[a, b, c]: [usize; 3]| [(a, BENDING), (b, -2.0 * BENDING), (c, BENDING)];
    for (field, y, x) in (0..fields).flat_map(|f| (0..side).flat_map(move |y| (1..side - 1).map(move |x| (f, y, x)))) {
        squares.add(&bend([x - 1, x, x + 1].map(|x| at(x, y, field))), 0.0);
        squares.add(&bend([x - 1, x, x + 1].map(|x| at(y, x, field))), 0.0);
    }
}

/// Control values that act at a place, each with its weight; one without a table.
fn weights(side: usize, reach_m: f64, place_m: [f64; 2]) -> Vec<(usize, f64)> {
    if side == 1 {
        return vec![(0, 1.0)];
    }
    let cells = side - 3;
    let [(column, x), (row, y)] = place_m.map(|m| {
        let t = (m + reach_m) / (2.0 * reach_m) * cells as f64;
        let whole = (t.max(0.0) as usize).min(cells - 1);
        let (f, e) = (t - whole as f64, 1.0 - (t - whole as f64));
        let sixth = [e.powi(3), 4.0 - 6.0 * f * f + 3.0 * f.powi(3), 1.0 + 3.0 * f * (1.0 + f * e), f.powi(3)];
        (whole, sixth.map(|w| w / 6.0))
    });
    let at = |n: usize| ((row + n / 4) * side + column + n % 4, y[n / 4] * x[n % 4]);
    (0..16).map(at).collect()
}

/// Control values of a law, shape \[side, side\]; `None` if the reference lacks a place.
pub(super) fn fit(presses: &LawPresses, side: usize, reach_m: f64, axis: Vector) -> Option<Vec<[f32; LAW_FIELDS]>> {
    let count = side * side;
    let places: Vec<[f64; 2]> = std::iter::once([0.0; 2]).chain(sunflower(PLACES, reach_m)).collect();
    let [shallowest_m, deepest_m] = presses.depths_m;
    let between = (1..DEPTHS).map(|n| shallowest_m * (deepest_m / shallowest_m).powf(n as f64 / DEPTHS as f64));
    let depths_m: Vec<f64> = [shallowest_m].into_iter().chain(between).chain([deepest_m]).collect();
    let mut heights = Squares::new(count);
    let mut constants = Squares::new(count * CONSTANTS);
    for place_m in &places {
        let (weights, offset_m) = (weights(side, reach_m, *place_m), presses.known.place_m(*place_m)?);
        // depths of the reference begin at the surface below the tip, those of the law where
        // the tip touches
        let touch_m = presses.known.touch_m(*place_m)?;
        let lift_m = touch_m - offset_m.dot(&axis);
        heights.add(&weights, touch_m);
        for depth_m in &depths_m {
            let force_m2 = presses.known.force(offset_m, *depth_m)?;
            let d = depth_m + lift_m;
            let row: Vec<(usize, f64)> = weights
                .iter()
                .flat_map(|(n, w)| {
                    (0..CONSTANTS).map(move |k| (n * CONSTANTS + k, w * d.powf(1.5) * (d / SCALE_M).powi(k as i32) / force_m2))
                })
                .collect();
            constants.add(&row, 1.0);
        }
    }
    if side > 1 {
        smooth(&mut heights, side, 1);
        smooth(&mut constants, side, CONSTANTS);
    }
    let all = |squares: &Squares, count| Some(squares.solve(&(0..count).collect::<Vec<usize>>())?.1);
    let (heights, constants) = (all(&heights, count)?, all(&constants, count * CONSTANTS)?);
    let row = |n: usize| {
        std::array::from_fn(|k| match k.checked_sub(1) {
            None => heights[n] as f32,
            Some(k) => (constants[n * CONSTANTS + k] / SCALE_M.powi(k as i32)) as f32,
        })
    };
    Some((0..count).map(row).collect())
}
