//! Finds the depth at which a press has a given force.

use palpate_fit::reference::newton::{Press, Stalled};

/// Accepted deviation of the force, as a share of its target (1).
const FORCE_TOLERANCE: f64 = 1e-4;
const MOST_TRIES: usize = 40;
/// Step of depth with which the target is bracketed [probe radii].
const SEARCH_RADII: f64 = 0.125;

/// Presses until the force over Young's modulus equals `wanted_m2`: steps inward until the force is
/// exceeded, then false position (Illinois).
pub fn find_depth(press: &mut Press, wanted_m2: f64, radius_m: f64, progress: &mut impl FnMut(f64)) -> Result<(), Stalled> {
    let step_m = SEARCH_RADII * radius_m;
    let mut low = (0.0, -wanted_m2);
    let mut high = loop {
        let at = (press.depth_m(), press.force_over_e_m2() - wanted_m2);
        if at.1 >= 0.0 {
            break at;
        }
        low = at;
        press.go_to(press.depth_m() + step_m, &mut *progress)?;
    };
    for _ in 0..MOST_TRIES {
        let off = press.force_over_e_m2() - wanted_m2;
        if off.abs() <= FORCE_TOLERANCE * wanted_m2 {
            return Ok(());
        }
        let middle_m = (low.0 * high.1 - high.0 * low.1) / (high.1 - low.1);
        press.go_to(middle_m, &mut *progress)?;
        let off = press.force_over_e_m2() - wanted_m2;
        if off < 0.0 {
            low = (middle_m, off);
            high.1 *= 0.5;
        } else {
            high = (middle_m, off);
            low.1 *= 0.5;
        }
    }
    Err(Stalled { reached_m: press.depth_m() })
}
