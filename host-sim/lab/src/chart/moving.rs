//! Force error on a moving probe, against the dynamic reference: ramps of 40, 100 and 200 mm/s to a
//! depth of 4 mm and a tap of 500 mm/s, each starting with the tissue at rest.

use palpate::Fault;
use palpate_tissue::moving::{Ramp, RampError, TruthError};
use serde::{Deserialize, Serialize};

use crate::error::Error;
use crate::methods::{Block, Method};

/// Speeds of the ramps [mm/s]; the last is the tap.
pub const SPEEDS_MM_PER_S: [u32; 4] = [40, 100, 200, 500];

/// Errors of one method in each ramp and in the tap.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Moving(pub [RampError; SPEEDS_MM_PER_S.len()]);

impl Moving {
    /// Root mean square over the ramps and the tap [%]; each error is relative to the largest force
    /// of its own ramp or tap.
    pub fn rms_pct(&self) -> f64 {
        (self.0.iter().map(|ramp| ramp.rms_pct.powi(2)).sum::<f64>() / self.0.len() as f64).sqrt()
    }

    /// Runs every ramp and the tap. `None` for a stiffness without a dynamic reference, and for a
    /// method that is not available.
    pub fn measure(method: Method, block: &Block, substeps: u16) -> Result<Option<Result<Self, Fault>>, Error> {
        let kpa = f64::from(block.params.youngs_modulus_pa) * 1e-3;
        let mut errors = Vec::new();
        for speed in SPEEDS_MM_PER_S {
            // dynamic references exist for 3.5, 20 and 100 kPa
            let ramp = match Ramp::named(&format!("centre-{kpa}kpa-{speed}")) {
                Err(TruthError::Unknown { .. }) => return Ok(None),
                other => other.map_err(palpate_tissue::Error::from)?,
            };
            let along = |force: palpate::Vector3<f32>| f64::from(force.dot(&block.params.probe.axis));
            let judged =
                method.run(block, substeps, |running| ramp.judge(|depth_m| running.tick(block.tip_m(depth_m)).map(along)))?;
            match judged {
                None => return Ok(None),
                Some(Err(fault)) => return Ok(Some(Err(fault))),
                Some(Ok(error)) => errors.push(error),
            }
        }
        Ok(errors.try_into().ok().map(|errors| Ok(Self(errors))))
    }
}
