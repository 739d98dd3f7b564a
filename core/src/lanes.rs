//! One arithmetic at two widths.
//!
//! The force kernels are written once, over [`Lanes`]. The board runs them on `f32`; processors
//! with 128-bit registers run them on four springs or tets at a time. Every operation is
//! elementwise and exactly rounded (`+ - * / sqrt`, never fused), so both widths give the same
//! bits; `board_and_desktop_give_the_same_bits` (tests) verifies it.

use core::ops::{Add, AddAssign, Div, Mul, MulAssign, Neg, Sub, SubAssign};

use nalgebra::{Scalar, Vector3};

/// Floats stored per node row. A 16-byte row loads in one instruction on processors with 128-bit
/// registers; the board stores three and saves a quarter of the RAM. The fourth float stays zero.
pub const ROW: usize = if cfg!(target_os = "none") { 3 } else { 4 };

/// x, y, z of one node quantity (and a zero that pads the row on the desktop).
pub type Row = [f32; ROW];

/// A row of x, y, z.
#[inline(always)]
pub fn row(v: Vector3<f32>) -> Row {
    let mut r = [0.0; ROW];
    r[0] = v.x;
    r[1] = v.y;
    r[2] = v.z;
    r
}

/// x, y, z of a row.
#[inline(always)]
pub fn vector(r: &Row) -> Vector3<f32> {
    Vector3::new(r[0], r[1], r[2])
}

/// `a - b`.
#[cfg(not(target_os = "none"))]
#[inline(always)]
pub fn difference(a: &Row, b: &Row) -> Row {
    core::array::from_fn(|k| a[k] - b[k])
}

/// `r * s`.
#[cfg(not(target_os = "none"))]
#[inline(always)]
pub fn scaled(r: &Row, s: f32) -> Row {
    core::array::from_fn(|k| r[k] * s)
}

/// `into += r`.
#[inline(always)]
pub fn add(into: &mut Row, r: &Row) {
    for (a, b) in into.iter_mut().zip(r) {
        *a += b;
    }
}

/// `into -= r`.
#[cfg_attr(armv7em_fp, expect(dead_code, reason = "in assembly there"))]
#[inline(always)]
pub fn subtract(into: &mut Row, r: &Row) {
    for (a, b) in into.iter_mut().zip(r) {
        *a -= b;
    }
}

/// Square root as the one hardware instruction.
///
/// nalgebra's `norm()` and `libm::sqrtf` are 60-70 instructions on a Cortex-M4F; this is
/// `vsqrt.f32` there (`sqrtss` on x86-64).
#[inline(always)]
pub fn sqrt(x: f32) -> f32 {
    #[allow(unsafe_code)] // reason: `f32::sqrt` is not in `core`; the C function has no precondition, so it is declared safe
    unsafe extern "C" {
        safe fn sqrtf(x: f32) -> f32;
    }
    sqrtf(x)
}

/// Square root as a function, for code that runs once: inlined, the instruction is followed by a
/// call for negative numbers.
#[inline(never)]
#[must_use]
pub fn square_root(x: f32) -> f32 {
    sqrt(x)
}

/// `W` numbers on which every operation acts elementwise.
#[cfg_attr(armv7em_fp, expect(dead_code, reason = "in assembly there"))]
pub trait Lanes<const W: usize>:
    Scalar
    + Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + MulAssign
{
    /// Sets every lane to this number.
    fn splat(x: f32) -> Self;
    /// Sets each lane to its element of the array.
    fn from_array(x: [f32; W]) -> Self;
    /// Returns the lanes as an array.
    fn to_array(self) -> [f32; W];
    /// Square root of lanes that are sums of squares.
    fn root(self) -> Self;
    /// Keeps lanes that are negative and makes the others zero.
    fn negative_part(self) -> Self;
    /// The larger of each lane and `floor`.
    fn at_least(self, floor: f32) -> Self;
    /// True if any lane is below `limit`.
    fn any_below(self, limit: f32) -> bool;
    /// Transposes `W` rows to x, y and z lanes.
    fn from_rows(rows: [Row; W]) -> Vector3<Self>;
    /// Transposes x, y and z lanes to `W` rows.
    fn to_rows(v: Vector3<Self>) -> [Row; W];
}

impl Lanes<1> for f32 {
    #[inline(always)]
    fn splat(x: f32) -> Self {
        x
    }
    #[inline(always)]
    fn from_array(x: [f32; 1]) -> Self {
        x[0]
    }
    #[inline(always)]
    fn to_array(self) -> [f32; 1] {
        [self]
    }
    #[inline(always)]
    fn root(self) -> Self {
        sqrt(self)
    }
    #[inline(always)]
    fn negative_part(self) -> Self {
        if self < 0.0 { self } else { 0.0 }
    }
    #[inline(always)]
    fn at_least(self, floor: f32) -> Self {
        if self < floor { floor } else { self }
    }
    #[inline(always)]
    fn any_below(self, limit: f32) -> bool {
        self < limit
    }
    #[inline(always)]
    fn from_rows(rows: [Row; 1]) -> Vector3<Self> {
        vector(&rows[0])
    }
    #[inline(always)]
    fn to_rows(v: Vector3<Self>) -> [Row; 1] {
        [row(v)]
    }
}

#[cfg(not(target_os = "none"))]
mod four {
    use nalgebra::Vector3;
    use wide::f32x4;

    use super::{Lanes, Row};

    impl Lanes<4> for f32x4 {
        #[inline(always)]
        fn splat(x: f32) -> Self {
            f32x4::splat(x)
        }
        #[inline(always)]
        fn from_array(x: [f32; 4]) -> Self {
            f32x4::new(x)
        }
        #[inline(always)]
        fn to_array(self) -> [f32; 4] {
            self.to_array()
        }
        #[inline(always)]
        fn root(self) -> Self {
            self.sqrt()
        }
        #[inline(always)]
        fn negative_part(self) -> Self {
            self.fast_min(f32x4::ZERO)
        }
        #[inline(always)]
        fn at_least(self, floor: f32) -> Self {
            self.fast_max(f32x4::splat(floor))
        }
        #[inline(always)]
        fn any_below(self, limit: f32) -> bool {
            self.simd_lt(f32x4::splat(limit)).any()
        }
        #[inline(always)]
        fn from_rows(rows: [Row; 4]) -> Vector3<Self> {
            let [x, y, z, _] = f32x4::transpose(rows.map(f32x4::new));
            Vector3::new(x, y, z)
        }
        #[inline(always)]
        fn to_rows(v: Vector3<Self>) -> [Row; 4] {
            f32x4::transpose([v.x, v.y, v.z, f32x4::ZERO]).map(f32x4::to_array)
        }
    }
}
