//! Sine and cosine in single precision, without libm, whose `sinf` computes in double precision and
//! takes 1258 instructions on a Cortex-M4F.

use core::f32::consts::FRAC_2_PI;

/// A quarter turn [rad] in three parts: the first two have few enough digits for their multiples to
/// be exact (Cody and Waite; constants of Cephes).
const QUARTER: [f32; 3] = [1.570_312_5, 4.837_513e-4, 7.549_79e-8];

/// Sine and cosine of an angle of a few turns [rad], within 3e-7.
#[must_use]
pub fn sin_cos(angle_rad: f32) -> (f32, f32) {
    let turns = angle_rad * FRAC_2_PI;
    let quarter = (turns + 0.5_f32.copysign(turns)) as i32;
    let rest = QUARTER.into_iter().fold(angle_rad, |rest, part| rest - quarter as f32 * part);
    let square = rest * rest;
    // Taylor polynomials to the ninth and eighth order: error 3e-7 at an eighth of a turn
    let s = rest * (1.0 + square * (-1.0 / 6.0 + square * (1.0 / 120.0 + square * (-1.0 / 5040.0 + square / 362_880.0))));
    let c = 1.0 + square * (-0.5 + square * (1.0 / 24.0 + square * (-1.0 / 720.0 + square / 40_320.0)));
    match quarter & 3 {
        0 => (s, c),
        1 => (c, -s),
        2 => (-s, -c),
        _ => (-c, s),
    }
}

#[cfg(test)]
mod tests {
    use super::sin_cos;

    #[test]
    fn it_is_the_library_s_sine() {
        for step in -40_000..=40_000 {
            let angle = step as f32 * 5e-4;
            let (s, c) = sin_cos(angle);
            let (right_s, right_c) = (libm::sin(f64::from(angle)), libm::cos(f64::from(angle)));
            assert!((f64::from(s) - right_s).abs() < 3e-7 && (f64::from(c) - right_c).abs() < 3e-7, "{angle}");
        }
    }
}
