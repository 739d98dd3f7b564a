//! T1: beef, indented for four seconds and held. Two Prony terms are fitted to the sirloin in one
//! dimension, with the elastic force of the patch as the loading curve; the patch with these terms
//! is then pressed as in the tests and compared with the topside.

use palpate_tissue::Error as TissueError;
use palpate_tissue::press;
use palpate_tissue::scene::{Scene, TICK_S};
use palpate_tissue::session::Session;
use serde::Deserialize;

use super::{Curve, Figure, Outcome, Picture, PronyFit, Row, fit_prony};
use crate::Error;

const DATA: &str = include_str!("../../../../tests/data/beef_relaxation.toml");
const SOURCE: &str = "tests/data/beef_relaxation.toml (Iaquinta et al., perineal_indentation, raw records)";
/// Largest accepted root mean square error of the fitted and of the predicted figures (1).
const MOST_RMS: [f64; 2] = [0.01, 0.02];
/// Number of ticks between neighbouring points of a picture's curve.
const EVERY: usize = 20;

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
    /// Force in every tick of the loading [N].
    loading_n: Vec<f64>,
    /// Force during the hold, divided by the force at the end of the loading: (time since that end
    /// [s], ratio).
    left: Vec<(f64, f64)>,
    /// Force at the end of the loading [N].
    peak_n: f64,
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
        let force_n: Vec<f64> = run.ticks.iter().map(|row| f64::from(row.output.force_n.dot(&axis))).collect();
        let (loading_n, held_n) = (force_n.get(..=loaded).unwrap_or_default(), force_n.get(loaded..).unwrap_or_default());
        let peak_n = loading_n.last().copied().unwrap_or(f64::NAN);
        let held_s = self.time_s.iter().copied().fold(0.0, f64::max);
        let left = held_n.iter().enumerate().map(|(n, f)| (n as f64 * TICK_S, f / peak_n));
        let left = left.take_while(|(t_s, _)| *t_s <= held_s + 1e-9).collect();
        Ok(Held { loading_n: loading_n.to_vec(), left, peak_n })
    }

    fn rms(&self, held: &Held, cut: &Cut) -> f64 {
        let square: f64 = self.time_s.iter().zip(&cut.median).map(|(t, median)| (held.at(*t) - median).powi(2)).sum();
        (square / self.time_s.len() as f64).sqrt()
    }

    fn row(&self, cut: &Cut, fit: &PronyFit, ours: &Held, without: &Held, predicted: bool) -> Row {
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
        let [(g, tau_s), (h, slow_s)] = fit.terms;
        let terms =
            format!("shares {g:.3} and {h:.3} at {tau_s:.2} and {slow_s:.2} s, with the loading, to the medians of the sirloin");
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

    fn picture(&self, cut: &Cut, ours: &Held, without: &Held, predicted: bool) -> Picture {
        let measured = |name: &str, values: &[f64]| Curve {
            name: name.into(),
            points: self.time_s.iter().copied().zip(values.iter().copied()).collect(),
            measured: true,
        };
        let said = if predicted { "predicted from the sirloin" } else { "fitted to it" };
        let modulus_kpa = YOUNGS_MODULUS_PA * self.peak_n / ours.peak_n * 1e-3;
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
    let fit = fit_prony(&without.loading_n, TICK_S, &beef.time_s, &fitted.median);
    let fit = fit.ok_or_else(|| damaged("no two terms fit the medians"))?;
    let ours = beef.press(&fit.terms)?;
    let cuts = [(fitted, false), (predicted, true)];
    Ok(Outcome {
        rows: cuts.iter().map(|(cut, predicted)| beef.row(cut, &fit, &ours, &without, *predicted)).collect(),
        pictures: cuts.iter().map(|(cut, predicted)| beef.picture(cut, &ours, &without, *predicted)).collect(),
    })
}
