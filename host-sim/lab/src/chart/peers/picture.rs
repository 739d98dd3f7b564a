//! Pictures of our results and those of other engines: cost of a tick against held error, and
//! against moving error.

use palpate_charts::{MethodPoint, MethodPoints, SpeedAccuracy, speed_accuracy};
use palpate_tissue::output::OutputFolder;

use super::{Peer, Peers};
use crate::chart::Run;
use crate::chart::figures::{COST_WORDS, ERROR_WORDS, front_of};
use crate::chart::run::Measured;
use crate::error::Error;
use crate::methods::Method;

/// An error, and how to read it from a run of our models and from a row of another engine.
struct Quantity {
    name: &'static str,
    words: &'static str,
    axis: &'static str,
    own: fn(&Measured) -> Option<f64>,
    theirs: fn(&Peer) -> Option<f64>,
}

const QUANTITIES: [Quantity; 2] = [
    Quantity {
        name: "held",
        words: "force in a hold",
        axis: ERROR_WORDS[0].1,
        own: |m| m.accuracy.rms_pct(),
        theirs: |p| Some(p.held_rms_pct),
    },
    Quantity {
        name: "moving",
        words: "force while the probe moves",
        axis: ERROR_WORDS[2].1,
        own: |m| m.moving_rms_pct(),
        theirs: Peer::moving_rms_pct,
    },
];

/// Draws `peers_held_<kpa>` and `peers_moving_<kpa>` for every stiffness at which both sides were
/// run; returns the names of the pictures.
///
/// # Errors
/// Fails if a picture cannot be drawn or written.
pub fn draw_peers(
    folder: &OutputFolder,
    peers: &Peers,
    runs: &[Run],
    on_grids: &[Run],
    searched: &[Run],
) -> Result<Vec<String>, Error> {
    let mut moduli: Vec<f64> = peers.rows.iter().map(|p| p.youngs_modulus_pa).collect();
    moduli.sort_by(f64::total_cmp);
    moduli.dedup();
    let mut models: Vec<String> = peers.rows.iter().map(Peer::name).collect();
    models.dedup();
    let mut names = Vec::new();
    for modulus_pa in moduli {
        for quantity in &QUANTITIES {
            let methods = series(quantity, modulus_pa, &models, peers, [runs, on_grids, searched]);
            let (ours, theirs) = methods.split_at(Method::ALL.len());
            let drawn = |series: &[MethodPoints]| series.iter().any(|m| !m.points.is_empty());
            if drawn(ours) && drawn(&theirs[2..]) {
                names.push(draw(folder, quantity, modulus_pa, peers, &methods)?);
            }
        }
    }
    Ok(names)
}

/// Lists the series of a picture: our models in the same order, and therefore with the same
/// markers, as in the other pictures; our model on the grids of the other engines; our model with
/// searched contact parameters; and each model of the other engines.
fn series<'a>(
    quantity: &Quantity,
    modulus_pa: f64,
    models: &'a [String],
    peers: &Peers,
    [runs, on_grids, searched]: [&[Run]; 3],
) -> Vec<MethodPoints<'a>> {
    let own = |runs: &[Run], method: Method| -> Vec<MethodPoint> {
        let rows = runs.iter().filter(|r| r.task.method == method && r.task.youngs_modulus_pa == modulus_pa);
        let point = |run: &Run| {
            let measured = run.outcome.as_ref().ok()?;
            let (cost, error) = (measured.time.min_us, (quantity.own)(measured)?);
            Some(MethodPoint {
                nodes: run.task.nodes,
                split: run.task.refinement,
                cost,
                error,
                survived: run.survived().is_some(),
            })
        };
        rows.filter_map(point).collect()
    };
    let theirs = |model: &String| -> Vec<MethodPoint> {
        let rows = peers.rows.iter().filter(|p| p.youngs_modulus_pa == modulus_pa && p.name() == *model);
        let point = |p: &Peer| {
            let (cost, error) = (p.tick_min_us, (quantity.theirs)(p)?);
            Some(MethodPoint { nodes: p.nodes, split: 1, cost, error, survived: p.survived() })
        };
        let mut points: Vec<MethodPoint> = rows.filter_map(point).collect();
        points.sort_by(|a, b| a.cost.total_cmp(&b.cost));
        points
    };
    let of_method = |method: Method| match method {
        Method::Palpate => MethodPoints { name: "ours, uncalibrated", points: own(runs, method) },
        Method::Calibrated => MethodPoints { name: "ours, calibrated", points: own(runs, method) },
        _ => MethodPoints { name: method.name(), points: Vec::new() },
    };
    let mut all: Vec<MethodPoints> = Method::ALL.map(of_method).into();
    all.push(MethodPoints { name: "ours, on their grids", points: own(on_grids, Method::Palpate) });
    all.push(MethodPoints { name: "ours, contact searched", points: own(searched, Method::Calibrated) });
    all.extend(models.iter().map(|model| MethodPoints { name: model, points: theirs(model) }));
    all
}

fn draw(
    folder: &OutputFolder,
    quantity: &Quantity,
    modulus_pa: f64,
    peers: &Peers,
    methods: &[MethodPoints],
) -> Result<String, Error> {
    let kpa = modulus_pa * 1e-3;
    let name = format!("peers_{}_{kpa}kpa", quantity.name);
    let machine = palpate_tissue::machine::processor();
    let theirs = if peers.machine == machine { String::new() } else { format!(" on {}", peers.machine) };
    let below = format!(
        "block of {kpa} kPa, hemisphere R = 8 mm, one core of {machine}; theirs of {}{theirs}; lower and further left is better",
        peers.date
    );
    let front = front_of(methods);
    let chart = SpeedAccuracy {
        title: &format!("Engines of other people and ours at the same press: {}", quantity.words),
        below: &below,
        cost: COST_WORDS[0].0,
        error: quantity.axis,
        budget: Some((COST_WORDS[0].1, COST_WORDS[0].2)),
        methods,
        front: &front,
    };
    speed_accuracy(folder.draft(), &name, &chart)?;
    Ok(name)
}
