//! Report of an identification: lines, picture and summary.

use palpate_charts::{Figure, Form, Level, Plot, ScaledAxis, Series};
use palpate_fit::identify::fit::{Estimate, Quantity};
use palpate_fit::identify::record::Record;
use palpate_fit::identify::study::Identified;
use serde::Serialize;

use super::patch::Beside;
use crate::command::options::identify::IdentifyArgs;

/// Number of sentences on what the data cannot say that are printed, within the first ten lines.
const SHOWN: usize = 6;

/// Name, unit and factor of a quantity for people, and its key.
fn words(of: Quantity) -> (String, &'static str, f64, String) {
    match of {
        Quantity::Modulus => ("modulus E, instantaneous".into(), "kPa", 1e-3, "youngs_modulus_pa".into()),
        Quantity::Relaxed => ("modulus E, relaxed".into(), "kPa", 1e-3, "long_term_modulus_pa".into()),
        Quantity::Exponent => ("exponent b".into(), "", 1.0, "stiffening_b".into()),
        Quantity::Share(k) => (format!("share of term {}", k + 1), "", 1.0, format!("share_{}", k + 1)),
        Quantity::Time(k) => (format!("time of term {}", k + 1), "s", 1.0, format!("time_{}_s", k + 1)),
        Quantity::Contact(k) => (format!("contact of test {}", k + 1), "mm", 1e3, format!("contact_{}_m", k + 1)),
    }
}

/// The result in a line.
pub(super) fn headline(found: &Identified) -> String {
    let of = |e: &Estimate| {
        let (name, unit, per, _) = words(e.of);
        let [low, high] = e.interval.map(|x| x * per);
        match e.told() {
            true => format!("{name} {:.3} {unit}", e.value * per).trim_end().to_owned(),
            false => format!("{name} between {low:.3} and {high:.3} {unit}").trim_end().to_owned(),
        }
    };
    let said = found.estimates.iter().filter(|e| e.of != Quantity::Relaxed).map(of).collect::<Vec<_>>().join("; ");
    format!("{said}; the model is {:.2} % rms of the peak off the data", found.rms_pct)
}

pub(super) fn print(args: &IdentifyArgs, found: &Identified, records: &[Record], notes: &[String]) {
    println!("not known from these data:");
    found.unsaid.iter().take(SHOWN).for_each(|line| println!("  - {line}"));
    if found.unsaid.len() > SHOWN {
        println!("  - and {} more, which summary.json lists", found.unsaid.len() - SHOWN);
    }
    println!("\n{:26} {:>10}   90 % interval", "", "value");
    for e in &found.estimates {
        let (name, unit, per, _) = words(e.of);
        let [low, high] = e.interval.map(|x| x * per);
        let mark = if e.told() { "" } else { "  not told" };
        println!("{name:26} {:>10.4} {unit:3} {low:.4} to {high:.4}{mark}", e.value * per);
    }
    let criteria: Vec<String> = found.criteria.iter().map(|(terms, c)| format!("{terms}: {c:.1}")).collect();
    println!(
        "\nrelaxation terms: {} of at most 3; corrected information criterion (AICc, least is best) by their number: {}",
        found.tissue.terms.len(),
        criteria.join(", ")
    );
    println!(
        "stiffening lowers the criterion by {:.1}; without stiffening E = {:.3} kPa and the forces are {:.2} % rms of the peak off",
        found.exponent_gain,
        found.plain.0.youngs_modulus_pa * 1e-3,
        found.plain.1
    );
    for (record, test) in records.iter().zip(&found.tests) {
        let [press, hold] = [record.segments.press.len(), record.segments.hold.len()];
        println!(
            "{}: contact at {:.3} mm, then {:.2} mm deep at {:.2} mm/s ({press} rows), held {:.1} s ({hold} rows), retreat {} rows",
            record.name,
            test.contact_m * 1e3,
            test.depth_m * 1e3,
            record.speed_m_per_s() * 1e3,
            record.hold_s(),
            record.segments.retreat.len()
        );
        for (name, pct, fitted) in &test.segments {
            println!("  {name:18} {pct:5.2} % rms of the peak, {}", if *fitted { "fitted" } else { "predicted" });
        }
        if let Some([measured, ours]) = test.lift_off_m {
            println!("  lift-off {:.2} mm below first contact, predicted {:.2} mm", measured * 1e3, ours * 1e3);
        }
    }
    for slide in &found.slides {
        let [low, high] = slide.interval;
        println!(
            "slid {:.1} mm at {:.1} mm/s: friction {:.3}, 90 % interval {low:.3} to {high:.3}; from row to row it changes by {:.0} %",
            slide.travel_m * 1e3,
            slide.speed_m_per_s * 1e3,
            slide.friction,
            100.0 * slide.pulsing
        );
    }
    notes.iter().for_each(|note| println!("note: {note}"));
    if args.block.is_none() {
        println!("note: the tissue is taken to be wide (give --block if its sides are within two thicknesses of the tip)");
    }
}

/// Data, model and residual over time, and the force of the patch if there is one.
pub(super) fn figure(found: &Identified, records: &[Record], (beside, name): (&[Beside], &str)) -> Figure {
    let (record, test) = (&records[0], &found.tests[0]);
    let unit = if record.force_n.iter().all(|f| f.abs() < 1.0) { (1e3, "mN") } else { (1.0, "N") };
    let over_time = |values: &dyn Fn(usize) -> f64| -> Vec<(f64, f64)> {
        (0..record.time_s.len()).map(|n| (record.time_s[n] - record.time_s[0], values(n) * unit.0)).collect()
    };
    let axis = |title: String| ScaledAxis::linear(title);
    let dots = |name: &str, points: Vec<(f64, f64)>| {
        let mut dots: Vec<palpate_charts::Dot> = points.into_iter().map(Into::into).collect();
        dots.iter_mut().for_each(|dot| dot.radius_px = 1.6);
        Series::dots(name, dots)
    };
    let data = dots("measured", over_time(&|n| record.force_n[n]));
    let model = Series::curve("model", over_time(&|n| test.model_n[n]));
    let patch = beside.iter().take(1).map(|beside| {
        let points = record.time_s.iter().zip(&beside.force_n).map(|(t_s, force_n)| (t_s - record.time_s[0], force_n * unit.0));
        Series::curve(name, points)
    });
    let forces = [data, model].into_iter().chain(patch).collect();
    let rest = dots("measured less model", over_time(&|n| record.force_n[n] - test.model_n[n]));
    let plots = vec![
        Plot::new(axis("time [s]".into()), axis(format!("force [{}]", unit.1)), forces),
        Plot::new(axis("time [s]".into()), axis(format!("difference [{}]", unit.1)), vec![rest])
            .levels([Level::new("no difference", 0.0)]),
    ];
    Figure {
        name: "identified".into(),
        title: format!("{}: measured and identified force", record.name),
        below: format!(
            "E = {:.2} kPa, b = {:.2}, relaxation terms: {}; {:.2} % rms of the peak in the fitted rows",
            found.tissue.youngs_modulus_pa * 1e-3,
            found.tissue.stiffening_b,
            found.tissue.terms.len(),
            found.rms_pct
        ),
        form: Form::Panels(plots),
    }
}

#[derive(Serialize)]
struct Summary {
    thickness_m: f64,
    thickness_interval_m: [f64; 2],
    friction: Option<[f64; 3]>,
    estimates: Vec<Value>,
    unsaid: Vec<String>,
    terms: usize,
    criteria: Vec<(usize, f64)>,
    exponent_gain: f64,
    plain_modulus_pa: f64,
    plain_rms_pct: f64,
    rms_pct: f64,
    /// Of each test, the rms differences of the patch in press, hold and retreat over the peak [%].
    #[serde(skip_serializing_if = "Vec::is_empty")]
    patch_rms_pct: Vec<[f64; 3]>,
    tests: Vec<Test>,
}

#[derive(Serialize)]
struct Value {
    name: String,
    value: f64,
    low: f64,
    high: f64,
    told: bool,
}

#[derive(Serialize)]
struct Test {
    name: String,
    contact_m: f64,
    depth_m: f64,
    hold_s: f64,
    segments: Vec<(&'static str, f64, bool)>,
    lift_off_m: Option<[f64; 2]>,
}

pub(super) fn summary(found: &Identified, records: &[Record], beside: &[Beside]) -> impl Serialize + use<> {
    let value =
        |e: &Estimate| Value { name: words(e.of).3, value: e.value, low: e.interval[0], high: e.interval[1], told: e.told() };
    Summary {
        thickness_m: found.block_m[2],
        thickness_interval_m: found.thickness_m,
        friction: found.friction(),
        estimates: found.estimates.iter().map(value).collect(),
        unsaid: found.unsaid.clone(),
        terms: found.tissue.terms.len(),
        criteria: found.criteria.clone(),
        exponent_gain: found.exponent_gain,
        plain_modulus_pa: found.plain.0.youngs_modulus_pa,
        plain_rms_pct: found.plain.1,
        rms_pct: found.rms_pct,
        patch_rms_pct: beside.iter().map(|beside| beside.rms_pct).collect(),
        tests: records
            .iter()
            .zip(&found.tests)
            .map(|(record, test)| Test {
                name: record.name.clone(),
                contact_m: test.contact_m,
                depth_m: test.depth_m,
                hold_s: record.hold_s(),
                segments: test.segments.clone(),
                lift_off_m: test.lift_off_m,
            })
            .collect(),
    }
}
