//! T2: pig liver, probed with a ball. Modulus, stiffening exponent and the place of first contact
//! are fitted to every second depth by the patch's statics; the patch is then pressed to all ten.

use palpate::Params;
use palpate_fit::statics::{Solver, Statics, Vector};
use palpate_tissue::Error as TissueError;
use palpate_tissue::press;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::Session;
use serde::Deserialize;

use super::exponential_fit::{Curve as ForceCurve, ExponentialFit, fit, fit_curve};
use super::{Curve, Figure, Outcome, Picture, Row};
use crate::Error;

const DATA: &str = include_str!("../../../../tests/data/pig_liver_probing.toml");
const SOURCE: &str = "tests/data/pig_liver_probing.toml (Wang et al., robot-palpation-data, raw records)";
/// Largest root mean square of the predicted forces over the largest measured (1).
const MOST_RMS: f64 = 0.03;
/// Largest difference of the last exponent (1).
const MOST_OFF: f64 = 0.25;
/// Largest exponent tried.
const MOST_B: f64 = 48.0;
const STEP_M: f64 = 2.5e-4;
/// Deepest press [m]: the deepest recorded and the largest offset.
const DEEPEST_M: f64 = 4.5e-3;

#[derive(Deserialize)]
struct Liver {
    ball_radius_m: f64,
    region: Vec<Region>,
}

#[derive(Deserialize)]
struct Region {
    name: String,
    sites: usize,
    depth_m: Vec<f64>,
    force_n: Vec<f64>,
    last_exponent: f64,
}

/// Every second of them, the deepest among them.
fn fitted(values: &[f64]) -> Vec<f64> {
    values.iter().skip(1).step_by(2).copied().collect()
}

fn predicted(values: &[f64]) -> Vec<f64> {
    values.iter().step_by(2).copied().collect()
}

impl Liver {
    fn scene(&self, youngs_modulus_pa: f64, b: f64, holds_m: &[f64]) -> Result<Scene, Error> {
        let holds: Vec<String> = holds_m.iter().map(f64::to_string).collect();
        let text = format!(
            "name = \"liver\"\n[tissue]\nblock_m = [0.08, 0.08, 0.04]\nyoungs_modulus_pa = {youngs_modulus_pa}\n\
             poisson_ratio = 0.45\ndensity_kg_per_m3 = 1060.0\nnodes = 410\nstiffening_b = {b}\n[probe]\nshape = \"sphere\"\n\
             radius_m = {}\nposition_m = [0.0, 0.0]\n[drive]\nkind = \"depth\"\nholds_m = [{}]\nramp_m_per_s = 0.02\nhold_s = 0.3\n",
            self.ball_radius_m,
            holds.join(", ")
        );
        Ok(Scene::parse("liver", &text)?)
    }

    /// Force of the patch with an exponent, by its statics.
    fn curve(&self, session: &Session, b: f64) -> Result<ForceCurve, Error> {
        let params = Params { stiffening_b: b as f32, ..session.params };
        let statics = Statics::of(&session.patch.model(), &params).map_err(TissueError::from)?;
        let failed = |what: String| TissueError::Check(format!("liver, b = {b}: {what}"));
        let solver = Solver::of(&statics).ok_or_else(|| failed("the mesh is too large".into()))?;
        let site_m: Vector = session.patch.site_m().cast();
        let mut here = solver.rest(&statics, site_m, 1e-6).map_err(|e| failed(e.to_string()))?;
        let mut force_m2 = vec![0.0];
        for n in 1..=(DEEPEST_M / STEP_M).round() as usize {
            let depth_m = STEP_M * n as f64;
            here =
                solver.press(&statics, &here, site_m - statics.axis() * depth_m, depth_m).map_err(|e| failed(e.to_string()))?;
            force_m2.push(here.force);
        }
        Ok(ForceCurve { step_m: STEP_M, force_m2 })
    }

    /// Force of the running patch at the end of a hold at each depth of a region [N].
    fn press(&self, found: &ExponentialFit, depth_m: &[f64]) -> Result<Vec<f64>, Error> {
        let holds_m: Vec<f64> = depth_m.iter().map(|d| d + found.offset_m).collect();
        let scene = self.scene(found.youngs_modulus_pa, found.stiffening_b, &holds_m)?;
        let session = Session::prepare(&scene)?;
        let run = press::run(&scene, &session, |_| ())?;
        if let Some(fault) = run.fault {
            return Err(TissueError::Check(format!("liver: {fault}")).into());
        }
        let axis = session.params.probe.axis;
        let at = |hold_m: &f64| {
            let held = run.ticks.iter().filter(|row| (row.command_m - hold_m).abs() < 1e-9);
            held.map(|row| f64::from(row.output.force_n.dot(&axis))).last().unwrap_or(f64::NAN)
        };
        Ok(holds_m.iter().map(at).collect())
    }
}

impl Region {
    fn rms(&self, force_n: &[f64]) -> f64 {
        let largest = self.force_n.iter().copied().fold(0.0, f64::max);
        let (ours, measured) = (predicted(force_n), predicted(&self.force_n));
        let square: f64 = ours.iter().zip(&measured).map(|(a, b)| (a - b).powi(2)).sum();
        (square / measured.len() as f64).sqrt() / largest
    }

    fn last_exponent(&self, force_n: &[f64]) -> f64 {
        let ([.., f, g], [.., d, e]) = (force_n, self.depth_m.as_slice()) else { return f64::NAN };
        (g / f).ln() / (e / d).ln()
    }

    fn row(&self, found: &ExponentialFit, ours: &[f64], without: &[f64]) -> Row {
        let exponent = [self.last_exponent - MOST_OFF, self.last_exponent + MOST_OFF];
        Row {
            test: "T2",
            data: format!("pig liver, {}, {} sites", self.name, self.sites),
            source: SOURCE,
            term: "stiffening",
            fitted: format!(
                "E = {:.2} kPa, b = {:.1}, contact {:.2} mm before it was declared, to every second depth",
                found.youngs_modulus_pa * 1e-3,
                found.stiffening_b,
                found.offset_m * 1e3
            ),
            predicted: "force at the five depths between, on the patch".into(),
            figures: vec![
                Figure {
                    what: "difference at these depths, rms over largest force (1)".into(),
                    accepted: [0.0, MOST_RMS],
                    ours: self.rms(ours),
                    without_term: self.rms(without),
                },
                Figure {
                    what: "exponent of the force between the last two depths (1)".into(),
                    accepted: exponent,
                    ours: self.last_exponent(ours),
                    without_term: self.last_exponent(without),
                },
            ],
        }
    }

    fn picture(&self, found: &ExponentialFit, ours: &[f64], without: &[f64]) -> Picture {
        let curve = |name: &str, force_n: &[f64], measured: bool| Curve {
            name: name.into(),
            points: self.depth_m.iter().map(|d| d * 1e3).zip(force_n.iter().copied()).collect(),
            measured,
        };
        Picture {
            name: format!("liver_{}", self.name.replace(' ', "_")),
            title: format!("pig liver, {}: every second depth fitted, the others predicted", self.name),
            below: format!(
                "{} sites; E = {:.2} kPa at rest, b = {:.1}, contact {:.2} mm before it was declared",
                self.sites,
                found.youngs_modulus_pa * 1e-3,
                found.stiffening_b,
                found.offset_m * 1e3
            ),
            axes: ["depth from where contact was declared [mm]", "force [N]"],
            curves: vec![
                curve("measured, median", &self.force_n, true),
                curve("ours", ours, false),
                curve("ours without stiffening", without, false),
            ],
        }
    }
}

/// Runs the test.
pub(super) fn run() -> Result<Outcome, Error> {
    let damaged =
        |what: &str| TissueError::Check(format!("tests/data/pig_liver_probing.toml: {what}: take the file as it ships"));
    let liver: Liver = toml::from_str(DATA).map_err(|e| damaged(e.message()))?;
    let session = Session::prepare(&liver.scene(5e3, 0.0, &[DEEPEST_M])?)?;
    let mut curves: Vec<(f64, ForceCurve)> = Vec::new();
    let mut outcome = Outcome { rows: Vec::new(), pictures: Vec::new() };
    for region in &liver.region {
        let (depth_m, force_n) = (fitted(&region.depth_m), fitted(&region.force_n));
        let found = fit(MOST_B, &depth_m, &force_n, |b| -> Result<ForceCurve, Error> {
            if let Some((_, known)) = curves.iter().find(|(known, _)| *known == b) {
                return Ok(known.clone());
            }
            let curve = liver.curve(&session, b)?;
            curves.push((b, curve.clone()));
            Ok(curve)
        })?;
        let found = found.ok_or_else(|| damaged("no modulus fits the forces"))?;
        let neo_hookean = curves.iter().find(|(b, _)| *b == 0.0).and_then(|(_, c)| fit_curve(c, 0.0, &depth_m, &force_n));
        let neo_hookean = neo_hookean.ok_or_else(|| damaged("no modulus fits the forces"))?;
        let (ours, without) = (liver.press(&found, &region.depth_m)?, liver.press(&neo_hookean, &region.depth_m)?);
        outcome.rows.push(region.row(&found, &ours, &without));
        outcome.pictures.push(region.picture(&found, &ours, &without));
    }
    Ok(outcome)
}
