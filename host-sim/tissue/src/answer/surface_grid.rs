//! Displacement of the surface on a square grid, compact enough to ship.

use serde::{Deserialize, Serialize};

/// Displacement of the top surface on a square grid around the place of the press, rounded to
/// nanometres.
#[derive(Clone, Debug, Deserialize, PartialEq, Serialize)]
#[serde(deny_unknown_fields)]
pub struct SurfaceGrid {
    /// Distance between grid points [m].
    pub spacing_m: f64,
    /// The grid has `2 half_count + 1` points per side, the middle one at the place.
    pub half_count: usize,
    /// Displacement [nm], shape \[(2n+1)^2\]\[3\], x fastest, from the corner of smallest x and y.
    pub displacement_nm: Vec<[i32; 3]>,
}

impl SurfaceGrid {
    /// Samples a displacement field; `at` gives the displacement [m] at an offset from the place
    /// [m].
    #[must_use]
    pub fn sample(spacing_m: f64, half_count: usize, at: impl Fn([f64; 2]) -> [f64; 3]) -> Self {
        let side = 2 * half_count + 1;
        let offset_m = |n: usize| (n as f64 - half_count as f64) * spacing_m;
        let nanometres = |v: f64| (v * 1e9).round() as i32;
        let displacement_nm = (0..side * side).map(|n| at([offset_m(n % side), offset_m(n / side)]).map(nanometres)).collect();
        Self { spacing_m, half_count, displacement_nm }
    }

    /// Displacement [m] at an offset from the place [m]; `None` outside the grid.
    ///
    /// Bicubic (Catmull and Rom 1974), with the outermost rows repeated.
    #[must_use]
    pub fn at_m(&self, offset_m: [f64; 2]) -> Option<[f64; 3]> {
        let side = 2 * self.half_count + 1;
        let [x, y] = offset_m.map(|o| o / self.spacing_m + self.half_count as f64);
        let last = (side - 1) as f64;
        if !(0.0..=last).contains(&x) || !(0.0..=last).contains(&y) || self.displacement_nm.len() != side * side {
            return None;
        }
        let cell = |v: f64| (v.floor() as usize).min(side.saturating_sub(2));
        let (i, j) = (cell(x), cell(y));
        let (wx, wy) = (weights(x - i as f64), weights(y - j as f64));
        let near = |cell: usize, n: usize| (cell + n).saturating_sub(1).min(side - 1);
        let mut sum = [0.0; 3];
        for (b, wy) in wy.into_iter().enumerate() {
            for (a, wx) in wx.into_iter().enumerate() {
                let value = self.displacement_nm[near(j, b) * side + near(i, a)];
                for k in 0..3 {
                    sum[k] += wx * wy * f64::from(value[k]) * 1e-9;
                }
            }
        }
        Some(sum)
    }
}

/// Weights of four consecutive points, between the middle two of which `t` runs from 0 to 1.
fn weights(t: f64) -> [f64; 4] {
    let (t2, t3) = (t * t, t * t * t);
    [0.5 * (-t3 + 2.0 * t2 - t), 0.5 * (3.0 * t3 - 5.0 * t2 + 2.0), 0.5 * (-3.0 * t3 + 4.0 * t2 + t), 0.5 * (t3 - t2)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quadratic_field_is_kept_and_outside_is_none() {
        let field = |[x, y]: [f64; 2]| [2.0 * x, x * x * 10.0 - y, x * y * 5.0];
        let grid = SurfaceGrid::sample(1e-3, 6, field);
        for offset in [[0.0, 0.0], [0.0013, -0.0021], [-0.0035, 0.004]] {
            let (got, want) = (grid.at_m(offset).unwrap(), field(offset));
            for k in 0..3 {
                assert!((got[k] - want[k]).abs() < 2e-9, "{offset:?}: {got:?} for {want:?}");
            }
        }
        assert!(grid.at_m([0.006, -0.006]).is_some());
        assert_eq!(grid.at_m([0.00601, 0.0]), None);
        assert_eq!(grid.at_m([f64::NAN, 0.0]), None);
    }
}
