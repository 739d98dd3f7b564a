//! The data of a law: a patch without nodes. The stage [`crate::stages::law`] evaluates it.

use bytemuck::{Pod, Zeroable};
use nalgebra::Vector3;

use crate::fault::BuildError;
use crate::lanes::sqrt;

/// Largest number of branches.
pub const MOST_BRANCHES: usize = 4;
/// Number of splines: touch height [m], then a0 to a3.
pub const FIELDS: usize = 5;
/// Largest number of table rows along each side: with it, a table takes 4 KB.
const MOST_ROWS: u32 = 14;

/// Dashpot that leads to a rod of the tissue.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Branch {
    /// Force over E and speed over w, over g^2 [m^(3/2) or m]; zero leaves the branch out.
    pub c: f32,
    /// Length of the rod [m]; may be infinite.
    pub length_m: f32,
}

/// Constants of a law, in the layout of a patch file.
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct LawShape {
    /// Point of the rest surface in the middle of the table [m].
    pub origin_m: [f32; 3],
    /// Unit vector along x of the table, at right angles to the probe's axis.
    pub along: [f32; 3],
    /// Radius of the disc of places [m].
    pub reach_m: f32,
    /// Rows of the table along each side: 1 for constants, else 4 to 14.
    pub side: u32,
    /// Branches; the first two have `g^2 = sqrt(d)`, the others `g^2 = d`.
    pub branches: [Branch; MOST_BRANCHES],
}

/// Force over place, depth and speed.
#[derive(Clone, Copy, Debug)]
pub struct Law<'a> {
    /// Constants.
    pub shape: &'a LawShape,
    /// Control values of the splines: touch height [m] and a0 .. a3 [`m^(1/2)` .. `m^(-5/2)`],
    /// shape \[side, side\], y first.
    pub table: &'a [[f32; FIELDS]],
}

impl Law<'_> {
    /// Checks every number once, so that the tick need not.
    ///
    /// # Errors
    /// Names the item that is out of range; a negative constant would create energy.
    pub fn check(&self, axis: &Vector3<f32>) -> Result<(), BuildError> {
        let LawShape { along, reach_m, side, origin_m, branches } = *self.shape;
        if side != 1 && !(4..=MOST_ROWS).contains(&side) {
            return Err(BuildError::OutOfRange { parameter: "law.side", value: side as f32, min: 4.0, max: MOST_ROWS as f32 });
        }
        let (need, have) = ((side * side) as usize, self.table.len());
        if need != have {
            return Err(BuildError::LengthMismatch { item: "law.table", need, have });
        }
        if !origin_m.iter().all(|c| c.is_finite()) {
            return Err(BuildError::NotFinite { item: "law.origin_m", index: 0 });
        }
        for (index, row) in self.table.iter().enumerate() {
            if !row.iter().all(|value| value.is_finite()) {
                return Err(BuildError::NotFinite { item: "law.table", index });
            }
        }
        let along = Vector3::from(along);
        BuildError::within("law.along length", sqrt(along.dot(&along)), 0.999, 1.001)?;
        BuildError::within("cosine of law.along and probe.axis", along.dot(axis), -1e-3, 1e-3)?;
        BuildError::within("law.reach_m", reach_m, f32::MIN_POSITIVE, 1.0)?;
        for branch in branches {
            BuildError::within("law.branches.c", branch.c, 0.0, f32::MAX)?;
            BuildError::within("law.branches.length_m", branch.length_m, f32::MIN_POSITIVE, f32::INFINITY)?;
        }
        Ok(())
    }
}
