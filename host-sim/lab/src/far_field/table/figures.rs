//! Pictures of the table: error over radius, error over cost, and error over the share of awake
//! nodes.

use super::presses::Setting;
use super::{Awake, Kind, PROMISED_PCT, Row, Surroundings, Table};
use crate::chart::front;
use crate::error::Error;
use crate::far_field::rim_method::RimMethod;
use palpate_charts::{
    Level, LineSeries, Lines, MethodPoint, MethodPoints, Scale, ScaledAxis, SpeedAccuracy, lines, speed_accuracy,
};
use palpate_tissue::output::OutputFolder;

/// Smallest error that is drawn; smaller ones are raised to it [%].
const FLOOR_PCT: f64 = 0.01;

/// Reads an error from a row [%].
type Pick = fn(&Row) -> Option<f64>;

/// An error that is drawn over the patch radius.
struct Curve {
    title: String,
    pick: Pick,
    /// Whether a limit of this error is promised for rim springs.
    promised: bool,
}

/// Draws the pictures and returns their names without extension.
///
/// # Errors
/// Fails if a picture cannot be drawn or written.
pub fn draw(folder: &OutputFolder, scene: &str, setting: &Setting, table: &Table, awake: &Awake) -> Result<Vec<String>, Error> {
    let mut finenesses: Vec<f64> = table.rows.iter().map(|r| r.fine_m).collect();
    finenesses.dedup();
    let depth_mm = 0.5e3 * setting.radius_m();
    let centred: Pick = |r| r.against_dense?.centred_pct[2];
    let aside: Pick = |r| r.against_dense?.aside_pct[1];
    let mut names = Vec::new();
    for fine_m in finenesses {
        let fine = format!("elements of {:.1} mm", fine_m * 1e3);
        let ending = format!("{:.1}mm", fine_m * 1e3);
        let shear: Pick = |r| r.against_dense?.glued_pct[1];
        let off_mm = 1e3 * setting.radius_m();
        for (name, pick, promised, words) in [
            ("centred", centred, true, format!("centred press, {depth_mm:.0} mm deep")),
            ("aside", aside, true, format!("worst press {off_mm:.0} mm off the centre, {depth_mm:.0} mm deep")),
            ("shear", shear, false, "glued disc, sheared".to_owned()),
        ] {
            let name = format!("error_over_radius_{name}_{ending}");
            let curve = Curve { title: format!("{scene}, {fine}: {words}"), pick, promised };
            if over_radius(folder, &name, setting, table, fine_m, &curve)? {
                names.push(name);
            }
        }
        let name = format!("error_over_m4f_cycles_{ending}");
        if over_cycles(folder, &name, table, fine_m, &format!("{scene}, {fine}"))? {
            names.push(name);
        }
        let name = format!("error_over_us_{ending}");
        let title = format!("{scene}, {fine}: error against time of a tick");
        if over_time(folder, &name, table, fine_m, &title)? {
            names.push(name);
        }
    }
    for nodes in distinct(awake.regions.iter().map(|r| r.whole_nodes)) {
        let name = format!("error_over_awake_{nodes}");
        over_share(folder, &name, scene, setting, awake, nodes)?;
        names.push(name);
    }
    Ok(names)
}

/// A curve that owns its name.
struct Labelled {
    name: String,
    points: Vec<(f64, f64)>,
    joined: bool,
}

fn distinct(values: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut all: Vec<usize> = values.collect();
    all.dedup();
    all
}

fn drawn(error_pct: f64) -> f64 {
    error_pct.abs().max(FLOOR_PCT)
}

/// Full name in a legend.
fn words(edge: RimMethod) -> String {
    match edge {
        RimMethod::Fixed => "fixed edge (papers)".into(),
        RimMethod::Winkler => "Winkler springs".into(),
        RimMethod::Truncated => "exact outside, cut off".into(),
        RimMethod::RimSprings => "rim springs (ours)".into(),
        RimMethod::Modes(q) => format!("{q} modes"),
        RimMethod::LowRank(q) => format!("blocks less rank {q}"),
        RimMethod::Dense => "exact outside".into(),
    }
}

fn over_radius(
    folder: &OutputFolder,
    name: &str,
    setting: &Setting,
    table: &Table,
    fine_m: f64,
    curve: &Curve,
) -> Result<bool, Error> {
    let rows = |edge: RimMethod| table.rows.iter().filter(move |r| r.fine_m == fine_m && r.kind == Kind::Patch(edge));
    let labels: Vec<(RimMethod, String)> =
        RimMethod::ALL.iter().filter(|e| **e != RimMethod::Dense).map(|e| (*e, words(*e))).collect();
    let series: Vec<LineSeries> = labels
        .iter()
        .map(|(edge, label)| {
            let point = |r: &Row| Some((r.radius_m / setting.radius_m(), drawn((curve.pick)(r)?)));
            LineSeries { name: label, points: rows(*edge).filter_map(point).collect(), joined: true, marked: true }
        })
        .filter(|s| !s.points.is_empty())
        .collect();
    if series.is_empty() {
        return Ok(false);
    }
    let promised = format!("{PROMISED_PCT} %: promised for ours");
    let level = [Level { name: &promised, y: PROMISED_PCT }];
    let chart = Lines {
        title: &curve.title,
        below: "in place of the rest of the organ, at the edge of a patch; error against the rest condensed exactly (exact outside)",
        x: ScaledAxis { title: "radius of the patch [probe radii]", scale: Scale::Linear },
        y: ScaledAxis { title: "error of the force [%]", scale: Scale::Log },
        series: &series,
        levels: if curve.promised { &level } else { &[] },
    };
    lines(folder.draft(), name, &chart)?;
    Ok(true)
}

/// Largest error against dense S one probe radius off the centre [%], where the treatments differ
/// most.
fn worst_pct(row: &Row) -> Option<f64> {
    if row.kind == Kind::Patch(RimMethod::Dense) { Some(0.0) } else { row.against_dense?.aside_pct[1] }
}

fn over_cycles(folder: &OutputFolder, name: &str, table: &Table, fine_m: f64, scene: &str) -> Result<bool, Error> {
    let labels: Vec<String> = RimMethod::ALL.iter().map(|e| words(*e)).collect();
    let methods: Vec<MethodPoints> = RimMethod::ALL
        .iter()
        .zip(&labels)
        .map(|(edge, label)| {
            let rows = table.rows.iter().filter(|r| r.fine_m == fine_m && r.kind == Kind::Patch(*edge));
            let point = |r: &Row| {
                let cost = 1e-3 * r.cost.as_ref()?.tick_m4f_cycles;
                Some(MethodPoint { nodes: r.size.nodes, split: 1, cost, error: drawn(worst_pct(r)?), survived: true })
            };
            MethodPoints { name: label, points: rows.filter_map(point).collect() }
        })
        .collect();
    let places: Vec<(usize, usize)> =
        methods.iter().enumerate().flat_map(|(m, method)| (0..method.points.len()).map(move |p| (m, p))).collect();
    if places.is_empty() {
        return Ok(false);
    }
    let points: Vec<(f64, f64)> =
        places.iter().map(|(m, p)| (methods[*m].points[*p].cost, methods[*m].points[*p].error)).collect();
    let front: Vec<(usize, usize)> = front(&points).into_iter().map(|n| places[n]).collect();
    let chart = SpeedAccuracy {
        title: "Edge of a patch: error against cost",
        below: &format!(
            "{scene}; each line: patches of rising radius; the exact outside, zero by definition, is drawn at {FLOOR_PCT} %"
        ),
        cost: "cycles of a 1 ms tick on a Cortex-M4F [thousands, estimated]",
        error: "worst error one probe radius off the centre, against the exact outside [%]",
        budget: Some((168.0, "1 ms at 168 MHz")),
        methods: &methods,
        front: &front,
    };
    speed_accuracy(folder.draft(), name, &chart)?;
    Ok(true)
}

fn over_time(folder: &OutputFolder, name: &str, table: &Table, fine_m: f64, title: &str) -> Result<bool, Error> {
    let labels: Vec<(RimMethod, String)> =
        RimMethod::ALL.iter().filter(|e| **e != RimMethod::Dense).map(|e| (*e, words(*e))).collect();
    let series: Vec<LineSeries> = labels
        .iter()
        .map(|(edge, label)| {
            let rows = table.rows.iter().filter(|r| r.fine_m == fine_m && r.kind == Kind::Patch(*edge));
            let point = |r: &Row| Some((r.cost.as_ref()?.tick_us?, drawn(worst_pct(r)?)));
            LineSeries { name: label, points: rows.filter_map(point).collect(), joined: true, marked: true }
        })
        .filter(|s| !s.points.is_empty())
        .collect();
    if series.is_empty() {
        return Ok(false);
    }
    let chart = Lines {
        title,
        below: &format!(
            "each line: patches of rising radius; {}; {}",
            palpate_tissue::machine::processor(),
            palpate_tissue::machine::build()
        ),
        x: ScaledAxis { title: "time of a 1 ms tick on one desktop core [µs]", scale: Scale::Linear },
        y: ScaledAxis { title: "worst error one probe radius off the centre [%]", scale: Scale::Log },
        series: &series,
        levels: &[],
    };
    lines(folder.draft(), name, &chart)?;
    Ok(true)
}

fn over_share(
    folder: &OutputFolder,
    name: &str,
    scene: &str,
    setting: &Setting,
    awake: &Awake,
    nodes: usize,
) -> Result<(), Error> {
    let mut places: Vec<f64> = awake.regions.iter().filter(|r| r.whole_nodes == nodes).map(|r| r.aside_m).collect();
    places.dedup();
    places.sort_by(f64::total_cmp);
    places.dedup();
    let at = |aside_m: f64| if aside_m == 0.0 { "centre".to_string() } else { format!("{:.0} mm off", aside_m * 1e3) };
    let mut labelled: Vec<Labelled> = Vec::new();
    for (held, what) in [(Surroundings::Frozen, "rest stands still"), (Surroundings::SpringsOfSprings, "rim springs")] {
        for &aside_m in &places {
            let own = awake.regions.iter().filter(|r| r.whole_nodes == nodes && r.aside_m == aside_m && r.held == held);
            let points: Vec<(f64, f64)> = own.filter_map(|r| Some((100.0 * r.share, drawn(r.error_pct[1]?)))).collect();
            labelled.push(Labelled { name: format!("{what}, {}", at(aside_m)), points, joined: true });
        }
    }
    // regions in which the rule keeps every node awake have no error, so they are left out
    let rule = awake.stress.iter().filter(|s| s.whole_nodes == nodes && s.aside_m == 0.0 && s.share < 1.0);
    let points = rule.filter_map(|s| Some((100.0 * s.share, drawn(s.error_pct?)))).collect();
    labelled.push(Labelled { name: "papers' stress rule, centre".into(), points, joined: false });
    let series: Vec<LineSeries> = labelled
        .iter()
        .filter(|l| !l.points.is_empty())
        .map(|l| LineSeries { name: &l.name, points: l.points.clone(), joined: l.joined, marked: true })
        .collect();
    let chart = Lines {
        title: &format!("{scene}, {nodes} nodes: how much must be awake, {:.0} mm deep", 0.5e3 * setting.radius_m()),
        below: "only nodes within a ball around the contact move; the rest stands still, or is replaced by rim springs fitted to it",
        x: ScaledAxis { title: "awake share of the free nodes [%]", scale: Scale::Linear },
        y: ScaledAxis { title: "error of the force against all nodes awake [%]", scale: Scale::Log },
        series: &series,
        levels: &[Level { name: "2 %", y: 2.0 }],
    };
    lines(folder.draft(), name, &chart)?;
    Ok(())
}
