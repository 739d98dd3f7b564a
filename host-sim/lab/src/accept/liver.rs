//! T2: pig liver, indented with a ball. Modulus, stiffening exponent and the depth of first contact
//! are fitted to every second depth with the statics of the patch; the patch is then pressed to all
//! ten depths.

use palpate::Params;
use palpate_fit::identify::elastic::{Elastic, depths_m};
use palpate_fit::identify::fit::{Problem, Settings};
use palpate_fit::identify::model::Tissue;
use palpate_fit::identify::record::Record;
use palpate_fit::statics::{Solver, Statics, Vector};
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
/// Stiffening exponents at which the force is computed (1), and the deepest depth [m].
const EXPONENTS: [f64; 5] = [0.0, 2.5, 5.0, 7.5, 10.0];
const DEEPEST_M: f64 = 4.25e-3;
/// Range of the depth of first contact [m], since the ball may have touched before contact was
/// declared. The fit without the term may also place first contact later, so that its misfit is not
/// due to this range.
const CONTACT_M: [f64; 2] = [-1.25e-3, 0.0];
const ANY_CONTACT_M: [f64; 2] = [-1.25e-3, 1.5e-3];
/// Number of bisections of the depth of first contact.
const HALVINGS: usize = 12;

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

/// Identified modulus [Pa], exponent (1) and depth added to each recorded depth [m].
struct Found {
    youngs_modulus_pa: f64,
    stiffening_b: f64,
    offset_m: f64,
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

    /// Forces of the patch in equilibrium, divided by E [m^2], at stiffening exponent `b`.
    fn forces(&self, session: &Session, b: f64) -> Result<Vec<f64>, Error> {
        let failed = |what: String| TissueError::Check(format!("liver, b = {b}: {what}"));
        let params = Params { stiffening_b: b as f32, ..session.params };
        let statics = Statics::of(&session.patch.model(), &params).map_err(TissueError::from)?;
        let solver = Solver::of(&statics).ok_or_else(|| failed("the mesh is too large".into()))?;
        let site_m: Vector = session.patch.site_m().cast();
        let mut here = solver.rest(&statics, site_m, 1e-6).map_err(|e| failed(e.to_string()))?;
        let force = depths_m(DEEPEST_M).into_iter().map(|depth_m| {
            let tip_m = site_m - statics.axis() * depth_m;
            here = solver.press(&statics, &here, tip_m, depth_m).map_err(|e| failed(e.to_string()))?;
            Ok(here.force)
        });
        force.collect()
    }

    fn elastic(&self) -> Result<Elastic, Error> {
        let session = Session::prepare(&self.scene(5e3, 0.0, &[DEEPEST_M])?)?;
        let solved = EXPONENTS.map(|b| self.forces(&session, b).map(|force| (b, force)));
        let solved = solved.into_iter().collect::<Result<Vec<_>, Error>>()?;
        let scale = solved[0].1[0] / depths_m(DEEPEST_M)[0].powf(1.5);
        let elastic = Elastic::of(DEEPEST_M, scale, 1.5, &solved);
        Ok(elastic.ok_or_else(|| TissueError::Check("liver: a force is not positive".into()))?)
    }

    /// Force of the running patch at the end of a hold at each depth [N]; zero above the surface.
    fn press(&self, found: &Found) -> Result<Vec<f64>, Error> {
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

    fn identify(&self, elastic: &Elastic, region: &Region, contact_m: [f64; 2], stiffens: bool) -> Option<Found> {
        let (depth_m, force_n) = (to_fit(&self.depth_m), to_fit(&region.force_n));
        // the steps are quasi-static
        let steps_s: Vec<f64> = (0..depth_m.len()).map(|n| n as f64).collect();
        let settings = Settings { terms: 0..1, stiffens, ..Settings::default() };
        let within = |contact_m: [f64; 2]| {
            let mut record = Record::of_points(steps_s.clone(), depth_m.clone(), force_n.clone(), contact_m);
            // where the fit begins
            record.contact_m = f64::midpoint(contact_m[0], contact_m[1]);
            let found = Problem::new(elastic, &[record], vec![depth_m.len()], settings.clone()).solve()?;
            let Tissue { youngs_modulus_pa, stiffening_b, .. } = found.tissue();
            Some(Found { youngs_modulus_pa, stiffening_b, offset_m: -found.contact_m(0) })
        };
        let mut found = within(contact_m)?;
        // contact was declared at the first depth at the latest, so under no more than the force
        // there
        let declared = |found: &Found| {
            let declared_m2 = elastic.at(found.stiffening_b).force_m2(found.offset_m);
            found.youngs_modulus_pa * declared_m2 <= region.force_n[0]
        };
        if !declared(&found) {
            let (mut early_m, mut late_m) = (-found.offset_m, 0.0);
            for _ in 0..HALVINGS {
                let middle_m = f64::midpoint(early_m, late_m);
                *(if declared(&within([middle_m; 2])?) { &mut late_m } else { &mut early_m }) = middle_m;
            }
            found = within([late_m; 2])?;
        }
        Some(found)
    }

    fn last_exponent(&self, force_n: &[f64]) -> f64 {
        let ([.., f, g], [.., d, e]) = (force_n, self.depth_m.as_slice()) else { return f64::NAN };
        (g / f).ln() / (e / d).ln()
    }

    fn row(&self, region: &Region, found: &Found, ours: &[f64], without: &[f64]) -> Row {
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

    fn picture(&self, region: &Region, found: &Found, ours: &[f64], without: &[f64]) -> Picture {
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

impl Found {
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
    let elastic = liver.elastic()?;
    let mut outcome = Outcome { rows: Vec::new(), pictures: Vec::new() };
    for region in &liver.region {
        if region.force_n.len() != liver.depth_m.len() {
            return Err(damaged("not one force a depth").into());
        }
        let pressed = |contact_range_m: [f64; 2], stiffens: bool| {
            let found = liver.identify(&elastic, region, contact_range_m, stiffens);
            let found = found.ok_or_else(|| damaged("no modulus fits the forces"))?;
            Ok::<_, Error>((liver.press(&found)?, found))
        };
        let (ours, found) = pressed(CONTACT_M, true)?;
        let (without, _) = pressed(ANY_CONTACT_M, false)?;
        outcome.rows.push(liver.row(region, &found, &ours, &without));
        outcome.pictures.push(liver.picture(region, &found, &ours, &without));
    }
    Ok(outcome)
}
