//! Over-compression correction (11)-(13): the force on a held finger as a function of the time
//! step.
//!
//! A node moves by C/2 in every step, however short the step is. That is a speed of C/(2 dt) which
//! no force of the tissue opposes, since the velocities are unchanged. The force on the finger then
//! depends on the time step instead of the tissue.

use crate::paper_method::LocalCompression;
use crate::paper_method::over_compression::OverCompression;
use crate::paper_method::velocity_verlet::VelocityVerlet;
use palpate::{Model, Params, Terms};

use super::super::methods::springs_of;
use super::super::steps::hold;
use crate::error::Error;
use crate::methods::{Block, OnCore};
use palpate_tissue::patch::{Material, Memory, Patch};

/// Depth of the finger [m].
pub const DEPTH_M: f64 = 0.004;
/// Damping of the masses [1/s]. The correction adds energy to the tissue; with a tenth of this
/// damping it diverges at longer steps.
const SETTLING_PER_S: f32 = 400.0;

/// Mechanism that resists compression.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Compensation {
    /// Springs alone, without a correction.
    None,
    /// (11)-(13) with this `tau_c`.
    Printed(f32),
    /// The product's compensation: an additional spring energy beyond a threshold of compression.
    Energy,
}

/// Forces of one kind of compensation at several time steps; a step at which the press diverges is
/// left out.
#[derive(Clone, Debug)]
pub struct AgainstStep {
    /// Mechanism that resists compression.
    pub compensation: Compensation,
    /// Pairs of time step [s] and force [N].
    pub points: Vec<(f64, f64)>,
}

/// Presses springs of a single stiffness k [N/m] with every kind of compensation at every time
/// step.
pub fn measure(block: &Block, stiffness_n_per_m: f64, steps_s: &[f64]) -> Result<Vec<AgainstStep>, Error> {
    let kinds = [
        Compensation::None,
        Compensation::Printed(0.0),
        Compensation::Printed(0.05),
        Compensation::Printed(0.1),
        Compensation::Energy,
    ];
    let patch = Patch::build(&block.tissue, &Material::default(), None);
    let own = patch.wide_model();
    let mut found = Vec::new();
    for compensation in kinds {
        let mut points = Vec::new();
        for &step_s in steps_s {
            let terms = Terms { compensation: compensation == Compensation::Energy, ..Terms::SPRINGS_ONLY };
            let params =
                Params { tick_s: step_s as f32, mass_floor: 0.0, node_damping_per_s: SETTLING_PER_S, terms, ..block.params };
            let springs = springs_of(&own, &params, stiffness_n_per_m);
            let model = Model { springs: &springs, ..own };
            let mut memory = Memory::for_model(&model);
            let (tuned, state) = memory.start(&model, &params)?;
            let correction = match compensation {
                Compensation::Printed(ratio) => Some(OverCompression { ratio }),
                _ => None,
            };
            let method = LocalCompression {
                dampers: None,
                volume: None,
                region: None,
                step: VelocityVerlet::default(),
                compression: correction,
            };
            let stepped = Block { params, ..block.clone() };
            let mut running = OnCore { model: &model, tuned: &tuned, state, method };
            if let Ok(held) = hold(&stepped, &mut running, DEPTH_M) {
                points.push((step_s, held.force_n));
            }
        }
        found.push(AgainstStep { compensation, points });
    }
    Ok(found)
}

impl Compensation {
    /// Name in legends.
    pub fn name(self) -> String {
        match self {
            Self::None => "springs alone".into(),
            Self::Printed(ratio) => format!("(11)-(13), tau_c = {ratio}"),
            Self::Energy => "as an energy (the product's)".into(),
        }
    }
}
