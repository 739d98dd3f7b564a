//! The models of the two source papers, with the contact, node damping and mass floor that the
//! chart gives every explicit method.
//!
//! `volume-preserved` (000) has springs (11) as printed, corrections (6)-(9) with the paper's rates
//! (tau = 0, theta = pi/3, checked every 100 steps), and dampers of a tenth of critical, because
//! the stable step of (12) as printed is too short for a tick. `local-compression` (004) has one
//! stiffness for all springs, velocity Verlet, and the over-compression correction from 10 % on. It
//! has no damper, since the fit of `palpate paper local-compression` ends at the lower bound of d;
//! no region, which saves nothing at an error of 2 %; and no volume force, whose coefficient is not
//! printed.

use crate::paper_method::averaged::Averaged;
use crate::paper_method::damper::{Dampers, DampingLaw};
use crate::paper_method::direction::SpringDirection;
use crate::paper_method::length::SpringLength;
use crate::paper_method::over_compression::OverCompression;
use crate::paper_method::velocity_verlet::VelocityVerlet;
use crate::paper_method::{LocalCompression, VolumePreserved};
use palpate::method::Method;
use palpate::{Model, Params, Spring, Terms};

use super::{OnCore, RunningMethod, printed_springs};
use palpate_tissue::error::Error;
use palpate_tissue::patch::{Memory, Patch};

/// The fitted stiffness divided by the mean of (11), both on the block of 130 nodes at 20 kPa (1):
/// `palpate paper local-compression` ends at 0.1816 N/mm, and the mean is 0.1298 N/mm.
const FITTED_OVER_MEAN: f64 = 1.4;
/// Critical compression ratio (1); the paper does not state it.
const RATIO: f32 = 0.1;

pub(super) fn volume_preserved<T>(
    patch: &Patch,
    params: &Params,
    work: impl FnOnce(&mut dyn RunningMethod) -> T,
) -> Result<T, Error> {
    let own = patch.wide_model();
    let springs = printed_springs(&own, params);
    let model = Model { springs: &springs, ..own };
    let mut damping_m_s = vec![0.0; springs.len()];
    DampingLaw::Critical(0.1).fill(&model, params, &mut damping_m_s);
    let mut before_m: Vec<[f32; 3]> = model.nodes.iter().map(|n| n.rest_m).collect();
    let direction = SpringDirection { angle_rad: std::f32::consts::FRAC_PI_3, every: 100, before_m: &mut before_m, age: 0 };
    let method = VolumePreserved {
        dampers: Some(Dampers { damping_m_s: &damping_m_s }),
        length: Some(SpringLength { stretch: 0.0, compression: 0.0 }),
        direction: Some(direction),
        averaged: Averaged::for_nodes(model.nodes.len()),
    };
    run(&model, params, method, work)
}

/// Runs the model of paper 004. `even` is the patch without inclusions: the factor by which an
/// inclusion stiffens a spring of (11) is applied to the single stiffness as well.
pub(super) fn local_compression<T>(
    patch: &Patch,
    even: &Patch,
    params: &Params,
    work: impl FnOnce(&mut dyn RunningMethod) -> T,
) -> Result<T, Error> {
    let (own, even) = (patch.wide_model(), even.wide_model());
    let printed = printed_springs(&even, params);
    let mean = printed.iter().map(|s| f64::from(s.k)).sum::<f64>() / printed.len().max(1) as f64;
    let one = (FITTED_OVER_MEAN * mean) as f32;
    let stiffer = own.springs.iter().zip(even.springs).map(|(s, even)| (s, one * (s.k / even.k)));
    let springs: Vec<Spring> = stiffer.map(|(s, k)| Spring { k, k_rest: k * (s.k_rest / s.k), ..*s }).collect();
    let model = Model { springs: &springs, ..own };
    let method = LocalCompression {
        dampers: None,
        volume: None,
        region: None,
        step: VelocityVerlet::default(),
        compression: Some(OverCompression { ratio: RATIO }),
    };
    run(&model, params, method, work)
}

fn run<T>(
    model: &Model,
    params: &Params,
    method: impl Method,
    work: impl FnOnce(&mut dyn RunningMethod) -> T,
) -> Result<T, Error> {
    let params = Params { terms: Terms::SPRINGS_ONLY, ..*params };
    let mut memory = Memory::for_model(model);
    let (tuned, state) = memory.start(model, &params)?;
    Ok(work(&mut OnCore { model, tuned: &tuned, state, method }))
}
