//! T3: silicone cylinders, squeezed to a third of their height. The modulus and the stiffening
//! exponent of each are fitted with the law of the patch in uniform deformation.

use palpate::Params;
use palpate_tissue::Error as TissueError;
use palpate_tissue::mesh::{BlockSpec, block};
use palpate_tissue::patch::{Material, Patch};
use palpate_tissue::tissue::Tissue;
use serde::Deserialize;

use super::uniform::Uniform;
use super::{Curve, Figure, Outcome, Picture, Row};
use crate::Error;

const DATA: &str = include_str!("../../../../tests/data/silicone_phantoms.toml");
const SOURCE: &str = "tests/data/silicone_phantoms.toml (Dawood et al. 2026, tissue-phantom-material-database, CC BY 4.0)";
/// Largest accepted root mean square of the residual, divided by the largest stress (1).
const MOST_RMS: f64 = 0.012;
/// Poisson's ratio (1): silicone hardly changes its volume, but closer to 0.5 rounding dominates
/// the bulk term of the patch.
const POISSON_RATIO: f64 = 0.495;
/// Step between the exponents tried (1), and their number.
const STEP_B: f64 = 0.005;
const STEPS: usize = 120;
/// Sides of a block of about the height and width of the cylinders [m], and its number of nodes.
const BLOCK_M: [f64; 3] = [0.05, 0.05, 0.03];
const NODES: usize = 300;

#[derive(Deserialize)]
struct Silicones {
    strain: Vec<f64>,
    phantom: Vec<Phantom>,
}

#[derive(Deserialize)]
struct Phantom {
    name: String,
    stress_pa: Vec<f64>,
}

/// A fit with stiffening, and the residual of the fit without it.
struct Fit {
    b: f64,
    youngs_modulus_pa: f64,
    rms: f64,
    without_rms: f64,
}

/// Best modulus [Pa] for stresses `over_e` that were divided by it, and the root mean square of the
/// residual, divided by the largest stress (1).
fn scaled(over_e: &[f64], stress_pa: &[f64]) -> (f64, f64) {
    let (ss, sp): (f64, f64) = over_e.iter().zip(stress_pa).fold((0.0, 0.0), |(ss, sp), (s, p)| (ss + s * s, sp + s * p));
    let e = sp / ss;
    let square: f64 = over_e.iter().zip(stress_pa).map(|(s, p)| (s * e - p).powi(2)).sum();
    let largest = stress_pa.iter().copied().fold(0.0, f64::max);
    (e, (square / stress_pa.len() as f64).sqrt() / largest)
}

fn fit(stresses: &[Vec<f64>], phantom: &Phantom) -> Option<Fit> {
    let without_rms = scaled(stresses.first()?, &phantom.stress_pa).1;
    let tried = stresses.iter().enumerate().map(|(n, over_e)| {
        let (youngs_modulus_pa, rms) = scaled(over_e, &phantom.stress_pa);
        Fit { b: STEP_B * n as f64, youngs_modulus_pa, rms, without_rms }
    });
    tried.min_by(|a, b| a.rms.total_cmp(&b.rms))
}

/// Runs comparison T3 with measurements of silicone phantoms.
pub(super) fn run() -> Result<Outcome, Error> {
    let damaged =
        |what: &str| TissueError::Check(format!("tests/data/silicone_phantoms.toml: {what}: take the file as it ships"));
    let data: Silicones = toml::from_str(DATA).map_err(|e| damaged(e.message()))?;
    let spec = BlockSpec { size_m: BLOCK_M, nodes: NODES, fine_at_m: [0.0; 2], fine_radius_m: 0.02 };
    let mesh = block(&spec).map_err(|cause| TissueError::Check(format!("the silicone cannot be meshed: {cause}")))?;
    let stiffness_ratio = vec![1.0; mesh.tets.len()];
    let tissue = Tissue::closed(mesh, stiffness_ratio, vec![0], [0.0; 3], 0.01);
    let patch = Patch::build(&tissue, &Material { poisson_ratio: POISSON_RATIO, ..Material::default() }, None);
    let params = Params { poisson_ratio: POISSON_RATIO as f32, ..Params::default() };
    let law = Uniform::of(&patch.model(), &params);
    let stresses: Vec<Vec<f64>> =
        (0..=STEPS).map(|n| data.strain.iter().map(|strain| law.stress(STEP_B * n as f64, *strain)).collect()).collect();
    let fits = data.phantom.iter().map(|phantom| fit(&stresses, phantom)).collect::<Option<Vec<Fit>>>();
    let fits = fits.ok_or_else(|| damaged("no modulus fits the stresses"))?;
    let worst = |of: &str, rms: fn(&Fit) -> f64| {
        let of_kind = data.phantom.iter().zip(&fits).filter(|(phantom, _)| phantom.name.starts_with(of));
        of_kind.map(|(_, fit)| rms(fit)).fold(0.0, f64::max)
    };
    let figures = ["EF10", "EF30", "EF50"].map(|kind| Figure {
        what: format!("worst rms of {kind} over largest stress (1)"),
        accepted: [0.0, MOST_RMS],
        ours: worst(kind, |fit| fit.rms),
        without_term: worst(kind, |fit| fit.without_rms),
    });
    let (low, high) = fits.iter().fold((f64::MAX, 0.0_f64), |(low, high), fit| (low.min(fit.b), high.max(fit.b)));
    let row = Row {
        test: "T3".into(),
        data: format!("silicone, {} phantoms, squeezed to 65 %", fits.len()),
        source: SOURCE.into(),
        term: "stiffening".into(),
        fitted: format!("modulus and b ({low:.2} to {high:.2}) of each, to its eight stresses"),
        predicted: "nothing: that two numbers describe a curve, by the patch's law in uniform deformation".into(),
        figures: figures.into(),
    };
    let pictures = data.phantom.iter().zip(&fits).take(1).map(|(phantom, fit)| {
        let curve = |name: &str, stress_pa: Vec<f64>, measured: bool| Curve {
            name: name.into(),
            points: data.strain.iter().copied().zip(stress_pa.iter().map(|p| p * 1e-3)).collect(),
            measured,
        };
        let ours = |b: f64| -> Vec<f64> { data.strain.iter().map(|strain| law.stress(b, *strain)).collect() };
        let times = |over_e: &[f64]| {
            let e = scaled(over_e, &phantom.stress_pa).0;
            over_e.iter().map(|s| s * e).collect::<Vec<f64>>()
        };
        Picture {
            name: format!("silicone_{}", phantom.name),
            title: format!("silicone {}: stress of a squeezed cylinder", phantom.name),
            below: format!("mean of ten; E = {:.2} kPa, b = {:.2}", fit.youngs_modulus_pa * 1e-3, fit.b),
            axes: ["engineering strain (1)", "engineering stress [kPa]"].map(Into::into),
            curves: vec![
                curve("measured", phantom.stress_pa.clone(), true),
                curve("ours", times(&ours(fit.b)), false),
                curve("ours without stiffening", times(&ours(0.0)), false),
            ],
        }
    });
    Ok(Outcome { pictures: pictures.collect(), rows: vec![row] })
}
