//! T1: beef, indented for four seconds and held. Two Prony terms are identified from the sirloin,
//! with the elastic force of the patch as the elastic curve; the patch with these terms is then
//! pressed as in the tests and compared with the topside.

use palpate_fit::identify::elastic::{Elastic, depths_m};
use palpate_fit::identify::fit::{Problem, Settings};
use palpate_fit::identify::model::Tissue;
use palpate_fit::identify::record::Record;
use palpate_tissue::Error as TissueError;
use palpate_tissue::press;
use palpate_tissue::scene::{Scene, TICK_S};
use palpate_tissue::session::Session;
use serde::Deserialize;

use super::{Curve, Figure, Outcome, Picture, Row};
use crate::Error;

const DATA: &str = include_str!("../../../../tests/data/beef_relaxation.toml");
const SOURCE: &str = "tests/data/beef_relaxation.toml (Iaquinta et al., perineal_indentation, raw records)";
/// Largest accepted root mean square error of the fitted and of the predicted figures (1).
const MOST_RMS: [f64; 2] = [0.01, 0.02];
/// Number of ticks between neighbouring points of a picture's curve, and between fitted rows.
const EVERY: usize = 20;
/// Settings of the fit: during a loading of seconds the fast part relaxes already, and a hold of
/// 0.5 to 9.5 s determines two terms with times in this range [s].
const SETTINGS: Settings = Settings { terms: 2..3, stiffens: false, contact: false, times_s: Some([0.1, 30.0]), delay: false };

#[derive(Deserialize)]
struct Beef {
    tip_radius_m: f64,
    ramp_s: f64,
    depth_m: f64,
    peak_n: f64,
    time_s: Vec<f64>,
    cut: Vec<Cut>,
}

#[derive(Deserialize)]
struct Cut {
    name: String,
    tests: usize,
    median: Vec<f64>,
    low: Vec<f64>,
    high: Vec<f64>,
}

/// Forces of a press and of the hold after it.
struct Held {
    /// Depth [m] and force [N] in every tick of the loading.
    loading: Vec<(f64, f64)>,
    /// Force during the hold, divided by the force at the end of the loading: (time since that end
    /// [s], ratio).
    left: Vec<(f64, f64)>,
}

impl Held {
    fn at(&self, t_s: f64) -> f64 {
        self.left.iter().find(|(t, _)| *t >= t_s - 1e-9).map_or(f64::NAN, |(_, left)| *left)
    }

    fn curve(&self, name: &str) -> Curve {
        Curve { name: name.into(), points: self.left.iter().step_by(EVERY).copied().collect(), measured: false }
    }
}

/// Young's modulus of the scene [Pa]; its value does not matter, because ratios of forces are
/// compared.
const YOUNGS_MODULUS_PA: f64 = 20e3;

impl Beef {
    /// The tests as a scene.
    fn scene(&self, terms: &[(f64, f64)]) -> Result<Scene, Error> {
        let relaxation: String =
            terms.iter().map(|(share, time_s)| format!("[[tissue.relaxation]]\nshare = {share}\ntime_s = {time_s}\n")).collect();
        let text = format!(
            "name = \"beef\"\n[tissue]\nblock_m = [0.08, 0.08, 0.04]\nyoungs_modulus_pa = {YOUNGS_MODULUS_PA}\n\
             poisson_ratio = 0.45\ndensity_kg_per_m3 = 1060.0\nnodes = 1020\n{relaxation}[probe]\nshape = \"hemisphere\"\n\
             radius_m = {}\nposition_m = [0.0, 0.0]\n[drive]\nkind = \"depth\"\nholds_m = [{}]\nramp_m_per_s = {}\nhold_s = {}\n",
            self.tip_radius_m,
            self.depth_m,
            self.depth_m / self.ramp_s,
            self.time_s.iter().copied().fold(0.0, f64::max) + 0.1
        );
        Ok(Scene::parse("beef", &text)?)
    }

    /// Presses the patch as in the tests.
    fn press(&self, terms: &[(f64, f64)]) -> Result<Held, Error> {
        let scene = self.scene(terms)?;
        let session = Session::prepare(&scene)?;
        let run = press::run(&scene, &session, |_| ())?;
        if let Some(fault) = run.fault {
            return Err(TissueError::Check(format!("beef: {fault}")).into());
        }
        let axis = session.params.probe.axis;
        let loaded = run.ticks.iter().position(|row| row.command_m > self.depth_m - 1e-7).unwrap_or_default();
        let pressed: Vec<(f64, f64)> =
            run.ticks.iter().map(|row| (row.command_m, f64::from(row.output.force_n.dot(&axis)))).collect();
        let (loading, held) = (pressed.get(..=loaded).unwrap_or_default(), pressed.get(loaded..).unwrap_or_default());
        let peak_n = loading.last().map_or(f64::NAN, |(_, force_n)| *force_n);
        let held_s = self.time_s.iter().copied().fold(0.0, f64::max);
        let left = held.iter().enumerate().map(|(n, (_, force_n))| (n as f64 * TICK_S, force_n / peak_n));
        let left = left.take_while(|(t_s, _)| *t_s <= held_s + 1e-9).collect();
        Ok(Held { loading: loading.to_vec(), left })
    }

    /// Identifies the tissue of a cut. Of the loading only the motion and the last force are known.
    fn identify(&self, elastic: &Held, cut: &Cut) -> Option<Tissue> {
        let force_m2 = |depth_m: f64| {
            let tick = elastic.loading.partition_point(|(d, _)| *d < depth_m).min(elastic.loading.len() - 1);
            let [(a, f), (b, g)] = elastic.loading.get(tick.checked_sub(1)?..=tick)?.try_into().ok()?;
            Some((f + (g - f) * (depth_m - a) / (b - a)) / YOUNGS_MODULUS_PA)
        };
        let at_m = depths_m(self.depth_m);
        let solved = at_m.iter().map(|d| force_m2(*d)).collect::<Option<Vec<f64>>>()?;
        let elastic_force = Elastic::of(self.depth_m, solved[0] / at_m[0].powf(1.5), 1.5, &[(0.0, solved)])?;
        let ticks = (0..elastic.loading.len()).rev().step_by(EVERY).collect::<Vec<_>>().into_iter().rev();
        let mut rows: Vec<[f64; 3]> = ticks.map(|n| [n as f64 * TICK_S, elastic.loading[n].0, f64::NAN]).collect();
        let end = rows.last_mut()?;
        (end[1], end[2]) = (self.depth_m, self.peak_n);
        let end_s = end[0];
        rows.extend(self.time_s.iter().zip(&cut.median).map(|(t, left)| [end_s + t, self.depth_m, left * self.peak_n]));
        let column = |k: usize| rows.iter().map(|row| row[k]).collect::<Vec<f64>>();
        let record = Record::of_points(column(0), column(1), column(2), [0.0; 2]);
        Some(Problem::new(&elastic_force, &[record], vec![rows.len()], SETTINGS).solve()?.tissue())
    }

    fn rms(&self, held: &Held, cut: &Cut) -> f64 {
        let square: f64 = self.time_s.iter().zip(&cut.median).map(|(t, median)| (held.at(*t) - median).powi(2)).sum();
        (square / self.time_s.len() as f64).sqrt()
    }

    fn row(&self, cut: &Cut, beef: &Tissue, ours: &Held, without: &Held, predicted: bool) -> Row {
        let bands = cut.low.iter().zip(&cut.high);
        let mut figures: Vec<Figure> = self
            .time_s
            .iter()
            .zip(bands)
            .map(|(t_s, (low, high))| Figure {
                what: format!("force left after {t_s} s (1)"),
                accepted: [*low, *high],
                ours: ours.at(*t_s),
                without_term: without.at(*t_s),
            })
            .collect();
        figures.push(Figure {
            what: "difference from the medians, rms (1)".into(),
            accepted: [0.0, MOST_RMS[usize::from(predicted)]],
            ours: self.rms(ours, cut),
            without_term: self.rms(without, cut),
        });
        let told = |of: fn(&(f64, f64)) -> f64, digits: usize| {
            beef.terms.iter().map(|term| format!("{:.digits$}", of(term))).collect::<Vec<_>>().join(" and ")
        };
        let (shares, times_s) = (told(|term| term.0, 3), told(|term| term.1, 2));
        let terms = format!("shares {shares} at {times_s} s, with the loading, to the medians of the sirloin");
        Row {
            test: "T1".into(),
            data: format!("beef, {}, {} tests", cut.name, cut.tests),
            source: SOURCE.into(),
            term: "relaxation".into(),
            fitted: if predicted { format!("nothing of this cut ({terms})") } else { terms },
            predicted: if predicted {
                "force left at five times of a hold, on the patch".into()
            } else {
                "nothing: that the patch follows its own terms".into()
            },
            figures,
        }
    }

    fn picture(&self, cut: &Cut, beef: &Tissue, ours: &Held, without: &Held, predicted: bool) -> Picture {
        let measured = |name: &str, values: &[f64]| Curve {
            name: name.into(),
            points: self.time_s.iter().copied().zip(values.iter().copied()).collect(),
            measured: true,
        };
        let said = if predicted { "predicted from the sirloin" } else { "fitted to it" };
        let modulus_kpa = beef.youngs_modulus_pa * 1e-3;
        Picture {
            name: format!("beef_{}", cut.name),
            title: format!("beef, {}: force left in a hold, {said}", cut.name),
            below: format!(
                "{} tests; tip of {} mm to {} mm in {} s; {} N there would be {modulus_kpa:.0} kPa at once",
                cut.tests,
                self.tip_radius_m * 1e3,
                self.depth_m * 1e3,
                self.ramp_s,
                self.peak_n
            ),
            axes: ["time since the end of the loading [s]", "force over that at the end of the loading (1)"].map(Into::into),
            curves: vec![
                measured("measured, median", &cut.median),
                measured("10 % of tests below", &cut.low),
                measured("10 % of tests above", &cut.high),
                ours.curve("ours"),
                without.curve("ours without relaxation"),
            ],
        }
    }
}

/// Runs comparison T1 with raw measurements of beef.
pub(super) fn run() -> Result<Outcome, Error> {
    let damaged = |what: &str| TissueError::Check(format!("tests/data/beef_relaxation.toml: {what}: take the file as it ships"));
    let beef: Beef = toml::from_str(DATA).map_err(|e| damaged(e.message()))?;
    let [fitted, predicted] = beef.cut.as_slice() else { return Err(damaged("not two cuts").into()) };
    let without = beef.press(&[])?;
    let found = beef.identify(&without, fitted).ok_or_else(|| damaged("no two terms fit the medians"))?;
    let ours = beef.press(&found.terms)?;
    let cuts = [(fitted, false), (predicted, true)];
    Ok(Outcome {
        rows: cuts.iter().map(|(cut, predicted)| beef.row(cut, &found, &ours, &without, *predicted)).collect(),
        pictures: cuts.iter().map(|(cut, predicted)| beef.picture(cut, &found, &ours, &without, *predicted)).collect(),
    })
}
