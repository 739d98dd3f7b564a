//! Compression compensation as a conservative force.
//!
//! The papers push over-compressed springs apart by moving their ends (000 eq 8; 004 eqs 11-13).
//! That acts as a stiffness of about m/dt^2, so the force depends on the time step (measured: by up
//! to +2800 %). Here the same intent is an energy, so the force depends on the tissue alone. Both
//! laws are evaluated inside the loops of `spring` and `volume`, at the cost of a few instructions.
//!
//! * in: a spring's length and constants, or a tet's share of its rest volume
//! * out: the force or pressure to add
//! * failures: none

use crate::lanes::Lanes;

/// Below this share of its rest volume a tet is pushed open.
pub const BARRIER_BELOW: f32 = 0.4;
/// Slope of the barrier, one over [`BARRIER_BELOW`]. The barrier grows linearly: if it grew as
/// `1 / J`, the step would be too long for a stable barrier just when a tap needs one.
pub(super) const BARRIER_SLOPE: f32 = 1.0 / BARRIER_BELOW;

/// Extra force per length over E of a spring shorter than `onset` times its rest length: `chi k
/// (1 - onset l0 / l)`, zero otherwise.
///
/// `stretch` is `k l0 / l`. Energy: `chi k / 2 (l - onset l0)^2`.
#[cfg_attr(armv7em_fp, expect(dead_code, reason = "in assembly there"))]
#[inline(always)]
pub(crate) fn of_spring<L: Lanes<W>, const W: usize>(k: L, stretch: L, onset: L, chi: L) -> L {
    chi * (k - onset * stretch).negative_part()
}

/// Extra pressure over E (divided by 6, as the tet gradients are) of a tet at `j` of its rest
/// volume: `3 mu / 6 (1 - j / 0.4)`, zero above 0.4.
#[cfg_attr(armv7em_fp, expect(dead_code, reason = "in assembly there"))]
#[inline(always)]
pub(crate) fn of_tet<L: Lanes<W>, const W: usize>(j: L, barrier: L) -> L {
    if !j.any_below(BARRIER_BELOW) {
        return L::splat(0.0);
    }
    let lack = -(j - L::splat(BARRIER_BELOW)).negative_part();
    barrier * lack * L::splat(BARRIER_SLOPE)
}
