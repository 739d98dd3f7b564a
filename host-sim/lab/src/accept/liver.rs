//! T2: pig liver, indented with a ball. Modulus, stiffening exponent and the depth of first contact
//! are fitted to every second depth by the engine of `palpate identify`; the patch is then pressed
//! to all ten depths.

use palpate_fit::identify::elastic::{Elastic, Setup};
use palpate_fit::identify::fit::{Problem, Settings};
use palpate_fit::identify::record::Record;
use palpate_tissue::Error as TissueError;
use palpate_tissue::press;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::Session;
use serde::Deserialize;

use super::{Curve, Figure, Outcome, Picture, Row};
use crate::Error;

const DATA: &str = include_str!("../../../../tests/data/pig_liver_indentation.toml");
const SOURCE: &str = "tests/data/pig_liver_indentation.toml (Wang et al., robot-palpation-data, raw records)";
/// Largest accepted root mean square error of the predicted forces, divided by the largest measured
/// force (1).
const MOST_RMS: f64 = 0.03;
/// Largest accepted difference between the computed and the measured exponent of force over depth
/// between the last two depths (1).
const MOST_OFF: f64 = 0.25;

/// Thickness of the liver [m], which the records do not give. The thinner the tissue, the smaller
/// the exponent that gives the same curvature of the force; at a thickness of 40 mm no exponent
/// gives the curvature of region 1.
const THICKNESS_M: f64 = 0.01;
const SIDE_M: f64 = 0.04;
/// Largest distance from first contact to where it was declared [m], since the ball may have touched
/// before; the fit without the term may also place it later, so that its misfit is not due to the
/// range.
const EARLIEST_M: f64 = 1.25e-3;
const LATEST_M: f64 = 1.5e-3;
/// Number of bisections of the offset under which the force at contact is that declared.
const HALVINGS: usize = 30;

/// Fitted modulus, exponent and offset.
struct StiffeningFit {
    youngs_modulus_pa: f64,
    stiffening_b: f64,
    /// Depth added to each recorded depth [m].
    offset_m: f64,
}

#[derive(Deserialize)]
struct Liver {
    ball_radius_m: f64,
    depth_m: Vec<f64>,
    region: Vec<Region>,
}

#[derive(Deserialize)]
struct Region {
    name: String,
    sites: usize,
    force_n: Vec<f64>,
    last_exponent: f64,
}

/// Every second value, the deepest included.
fn to_fit(values: &[f64]) -> Vec<f64> {
    values.iter().skip(1).step_by(2).copied().collect()
}

fn to_predict(values: &[f64]) -> Vec<f64> {
    values.iter().step_by(2).copied().collect()
}

impl Liver {
    fn scene(&self, youngs_modulus_pa: f64, b: f64, holds_m: &[f64]) -> Result<Scene, Error> {
        let holds: Vec<String> = holds_m.iter().map(f64::to_string).collect();
        let text = format!(
            "name = \"liver\"\n[tissue]\nblock_m = [{SIDE_M}, {SIDE_M}, {THICKNESS_M}]\n\
             youngs_modulus_pa = {youngs_modulus_pa}\npoisson_ratio = 0.45\ndensity_kg_per_m3 = 1060.0\nnodes = 410\n\
             stiffening_b = {b}\n[probe]\nshape = \"hemisphere\"\nradius_m = {}\nposition_m = [0.0, 0.0]\n[drive]\n\
             kind = \"depth\"\nholds_m = [{}]\nramp_m_per_s = 0.02\nhold_s = 0.3\n",
            self.ball_radius_m,
            holds.join(", ")
        );
        Ok(Scene::parse("liver", &text)?)
    }

    /// Force of the running patch at the end of a hold at each depth [N]; zero above the surface.
    fn press(&self, found: &StiffeningFit) -> Result<Vec<f64>, Error> {
        let depth_m: Vec<f64> = self.depth_m.iter().map(|d| d + found.offset_m).collect();
        let holds_m: Vec<f64> = depth_m.iter().copied().filter(|d| *d > 0.0).collect();
        let scene = self.scene(found.youngs_modulus_pa, found.stiffening_b, &holds_m)?;
        let session = Session::prepare(&scene)?;
        let run = press::run(&scene, &session, |_| ())?;
        if let Some(fault) = run.fault {
            return Err(TissueError::Check(format!("liver: {fault}")).into());
        }
        let above = std::iter::repeat_n(0.0, depth_m.len() - holds_m.len());
        Ok(above.chain(run.holds.iter().map(|hold| hold.force_n)).collect())
    }

    /// Fits every second depth. Contact was declared at the first depth at the latest, so under no
    /// more than the force there: an offset that breaks this is shortened until it does not.
    fn fit(&self, elastic: &Elastic, region: &Region, stiffens: bool) -> Option<StiffeningFit> {
        let (depth_m, force_n) = (to_fit(&self.depth_m), to_fit(&region.force_n));
        let times_s: Vec<f64> = (0..depth_m.len()).map(|n| n as f64).collect();
        let within = |earliest_m: f64| {
            let range_m = [-earliest_m, if stiffens { 0.0 } else { LATEST_M }];
            let records = [Record::of_points(times_s.clone(), depth_m.clone(), force_n.clone(), range_m)];
            let settings = Settings { terms: 0..1, stiffens, ..Settings::default() };
            let found = Problem::new(elastic, &records, vec![depth_m.len()], settings).solve()?;
            let (tissue, offset_m) = (found.tissue(), -found.contact_m(0));
            let declared_n = tissue.youngs_modulus_pa * elastic.at(tissue.stiffening_b).force_m2(offset_m);
            let keeps = declared_n <= *region.force_n.first()?;
            let (youngs_modulus_pa, stiffening_b) = (tissue.youngs_modulus_pa, tissue.stiffening_b);
            Some((StiffeningFit { youngs_modulus_pa, stiffening_b, offset_m }, keeps))
        };
        let (found, keeps) = within(EARLIEST_M)?;
        if keeps {
            return Some(found);
        }
        let (mut low_m, mut high_m) = (0.0, found.offset_m);
        for _ in 0..HALVINGS {
            let middle_m = 0.5 * (low_m + high_m);
            if within(middle_m)?.1 { low_m = middle_m } else { high_m = middle_m }
        }
        Some(within(low_m)?.0)
    }

    fn last_exponent(&self, force_n: &[f64]) -> f64 {
        let ([.., f, g], [.., d, e]) = (force_n, self.depth_m.as_slice()) else { return f64::NAN };
        (g / f).ln() / (e / d).ln()
    }

    fn row(&self, region: &Region, found: &StiffeningFit, ours: &[f64], without: &[f64]) -> Row {
        Row {
            test: "T2".into(),
            data: format!("pig liver, {}, {} sites", region.name, region.sites),
            source: SOURCE.into(),
            term: "stiffening".into(),
            fitted: format!("to every second depth: {}", found.told()),
            predicted: "force at the five depths between, on the patch".into(),
            figures: vec![
                Figure {
                    what: "rms at these depths over largest force".into(),
                    accepted: [0.0, MOST_RMS],
                    ours: region.rms(ours),
                    without_term: region.rms(without),
                },
                Figure {
                    what: "exponent of the force at 2.8 mm (1)".into(),
                    accepted: [region.last_exponent - MOST_OFF, region.last_exponent + MOST_OFF],
                    ours: self.last_exponent(ours),
                    without_term: self.last_exponent(without),
                },
            ],
        }
    }

    fn picture(&self, region: &Region, found: &StiffeningFit, ours: &[f64], without: &[f64]) -> Picture {
        let curve = |name: &str, force_n: &[f64], measured: bool| Curve {
            name: name.into(),
            points: self.depth_m.iter().map(|d| d * 1e3).zip(force_n.iter().copied()).collect(),
            measured,
        };
        Picture {
            name: format!("liver_{}", region.name.replace(' ', "_")),
            title: format!("pig liver, {}: every second depth fitted, the others predicted", region.name),
            below: format!("{} sites; ball of {} mm; {}", region.sites, self.ball_radius_m * 1e3, found.told()),
            axes: ["depth since contact was declared [mm]", "force [N]"].map(Into::into),
            curves: vec![
                curve("measured, median", &region.force_n, true),
                curve("ours", ours, false),
                curve("ours without stiffening", without, false),
            ],
        }
    }
}

impl Region {
    /// Root mean square difference between prediction and measurement, divided by the largest force
    /// (1).
    fn rms(&self, force_n: &[f64]) -> f64 {
        let largest = self.force_n.iter().copied().fold(0.0, f64::max);
        let (ours, measured) = (to_predict(force_n), to_predict(&self.force_n));
        let square: f64 = ours.iter().zip(&measured).map(|(a, b)| (a - b).powi(2)).sum();
        (square / measured.len() as f64).sqrt() / largest
    }
}

impl StiffeningFit {
    fn told(&self) -> String {
        format!(
            "E = {:.1} kPa, b = {:.1}, contact {:.2} mm before it was declared; {:.0} mm thick is assumed",
            self.youngs_modulus_pa * 1e-3,
            self.stiffening_b,
            self.offset_m * 1e3,
            THICKNESS_M * 1e3
        )
    }
}

/// Runs comparison T2 with raw measurements of pig liver.
pub(super) fn run() -> Result<Outcome, Error> {
    let damaged =
        |what: &str| TissueError::Check(format!("tests/data/pig_liver_indentation.toml: {what}: take the file as it ships"));
    let liver: Liver = toml::from_str(DATA).map_err(|e| damaged(e.message()))?;
    let setup = Setup { ball_m: liver.ball_radius_m, block_m: [SIDE_M, SIDE_M, THICKNESS_M], poisson_ratio: 0.45 };
    let deepest_m = liver.depth_m.iter().copied().fold(0.0, f64::max) + EARLIEST_M;
    let elastic = Elastic::solve(&setup, deepest_m);
    let elastic = elastic.ok_or_else(|| TissueError::Check("liver: no equilibrium of the finite elements".into()))?;
    let mut outcome = Outcome { rows: Vec::new(), pictures: Vec::new() };
    for region in &liver.region {
        if region.force_n.len() != liver.depth_m.len() {
            return Err(damaged("not one force a depth").into());
        }
        let pressed = |stiffens: bool| {
            let found = liver.fit(&elastic, region, stiffens).ok_or_else(|| damaged("no modulus fits the forces"))?;
            let forces = liver.press(&found)?;
            Ok::<_, Error>((found, forces))
        };
        let (found, ours) = pressed(true)?;
        let (_, without) = pressed(false)?;
        outcome.rows.push(liver.row(region, &found, &ours, &without));
        outcome.pictures.push(liver.picture(region, &found, &ours, &without));
    }
    Ok(outcome)
}
