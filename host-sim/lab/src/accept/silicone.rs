//! T3: silicone cylinders, squeezed to a third of their height. The modulus and the stiffening
//! exponent of each are identified with the law of the patch in uniform deformation.

use palpate::Params;
use palpate_fit::identify::elastic::{Elastic, depths_m};
use palpate_fit::identify::fit::{Problem, Settings};
use palpate_fit::identify::model::Tissue as Found;
use palpate_fit::identify::record::Record;
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
/// Exponents at which the stress is computed (1).
const EXPONENTS: [f64; 5] = [0.0, 0.1, 0.2, 0.4, 0.6];
/// Strain in which the law is linear (1).
const SMALL: f64 = 1e-4;
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

/// Modulus and exponent that fit the stresses of a phantom best.
fn identify(elastic: &Elastic, strain: &[f64], phantom: &Phantom, stiffens: bool) -> Option<Found> {
    let at_s = (0..strain.len()).map(|n| n as f64).collect();
    let record = [Record::of_points(at_s, strain.to_vec(), phantom.stress_pa.clone(), [0.0; 2])];
    // silicone hardly relaxes
    let settings = Settings { terms: 0..1, stiffens, contact: false, ..Settings::default() };
    Some(Problem::new(elastic, &record, vec![strain.len()], settings).solve()?.tissue())
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
    let deepest = data.strain.iter().copied().fold(0.0, f64::max);
    let solved = EXPONENTS.map(|b| (b, depths_m(deepest).map(|strain| law.stress(b, strain)).to_vec()));
    let elastic = Elastic::of(deepest, law.stress(0.0, SMALL) / SMALL, 1.0, &solved);
    let elastic = elastic.ok_or_else(|| damaged("a stress is not positive"))?;
    let stress_pa = |found: &Found| -> Vec<f64> {
        data.strain.iter().map(|strain| found.youngs_modulus_pa * law.stress(found.stiffening_b, *strain)).collect()
    };
    let fits = data.phantom.iter().map(|phantom| {
        let [with, without] = [true, false].map(|stiffens| identify(&elastic, &data.strain, phantom, stiffens));
        with.zip(without).ok_or_else(|| damaged("no modulus fits the stresses"))
    });
    let fits = fits.collect::<Result<Vec<(Found, Found)>, _>>()?;
    let rms = |found: &Found, phantom: &Phantom| {
        let square: f64 = stress_pa(found).iter().zip(&phantom.stress_pa).map(|(ours, measured)| (ours - measured).powi(2)).sum();
        (square / data.strain.len() as f64).sqrt() / phantom.stress_pa.iter().copied().fold(0.0, f64::max)
    };
    let worst = |of: &str, chosen: fn(&(Found, Found)) -> &Found| {
        let of_kind = data.phantom.iter().zip(&fits).filter(|(phantom, _)| phantom.name.starts_with(of));
        of_kind.map(|(phantom, fit)| rms(chosen(fit), phantom)).fold(0.0, f64::max)
    };
    let figures = ["EF10", "EF30", "EF50"].map(|kind| Figure {
        what: format!("worst rms of {kind} over largest stress (1)"),
        accepted: [0.0, MOST_RMS],
        ours: worst(kind, |fit| &fit.0),
        without_term: worst(kind, |fit| &fit.1),
    });
    let (low, high) =
        fits.iter().fold((f64::MAX, 0.0_f64), |(low, high), (fit, _)| (low.min(fit.stiffening_b), high.max(fit.stiffening_b)));
    let row = Row {
        test: "T3".into(),
        data: format!("silicone, {} phantoms, squeezed to 65 %", fits.len()),
        source: SOURCE.into(),
        term: "stiffening".into(),
        fitted: format!("modulus and b ({low:.2} to {high:.2}) of each, to its eight stresses"),
        predicted: "nothing: that two numbers describe a curve, by the patch's law in uniform deformation".into(),
        figures: figures.into(),
    };
    let pictures = data.phantom.iter().zip(&fits).take(1).map(|(phantom, (fit, plain))| {
        let curve = |name: &str, stress_pa: Vec<f64>, measured: bool| Curve {
            name: name.into(),
            points: data.strain.iter().copied().zip(stress_pa.iter().map(|p| p * 1e-3)).collect(),
            measured,
        };
        Picture {
            name: format!("silicone_{}", phantom.name),
            title: format!("silicone {}: stress of a squeezed cylinder", phantom.name),
            below: format!("mean of ten; E = {:.2} kPa, b = {:.2}", fit.youngs_modulus_pa * 1e-3, fit.stiffening_b),
            axes: ["engineering strain (1)", "engineering stress [kPa]"].map(Into::into),
            curves: vec![
                curve("measured", phantom.stress_pa.clone(), true),
                curve("ours", stress_pa(fit), false),
                curve("ours without stiffening", stress_pa(plain), false),
            ],
        }
    });
    Ok(Outcome { pictures: pictures.collect(), rows: vec![row] })
}
