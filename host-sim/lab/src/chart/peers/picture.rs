//! Pictures of our results and those of other engines: cost of a tick against held error, and
//! against moving error.

use palpate_charts::Figure;

use super::{Peer, Peers};
use crate::chart::Run;
use crate::chart::figures::{COST_WORDS, ERROR_WORDS, Point, points, scatter};
use crate::chart::run::Measured;
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

/// `peers_held_<kpa>` and `peers_moving_<kpa>` for every stiffness at which both sides were run.
/// Our models are in the same order, and therefore with the same markers, as in the other pictures;
/// then come our model on the grids of the other engines, our model with searched contact
/// parameters, and each model of the other engines.
pub fn figures(peers: &Peers, runs: &[Run], on_grids: &[Run], searched: &[Run]) -> Vec<Figure> {
    let mut moduli: Vec<f64> = peers.rows.iter().map(|p| p.youngs_modulus_pa).collect();
    moduli.sort_by(f64::total_cmp);
    moduli.dedup();
    let mut models: Vec<String> = peers.rows.iter().map(Peer::name).collect();
    models.dedup();
    let machine = palpate_tissue::machine::processor();
    let elsewhere = if peers.machine == machine { String::new() } else { format!(" on {}", peers.machine) };
    let mut figures = Vec::new();
    for modulus_pa in moduli {
        for quantity in &QUANTITIES {
            let own = |runs: &[Run], method: Method| {
                let rows = runs.iter().filter(|r| r.task.method == method && r.task.youngs_modulus_pa == modulus_pa);
                points(rows, |m| Some((m.time.min_us, (quantity.own)(m)?)))
            };
            let of_method = |method: Method| match method {
                Method::Palpate => ("ours, uncalibrated", own(runs, method)),
                Method::Calibrated => ("ours, calibrated", own(runs, method)),
                _ => (method.name(), Vec::new()),
            };
            let theirs = |model: &str| {
                let rows = peers.rows.iter().filter(|p| p.youngs_modulus_pa == modulus_pa && p.name() == model);
                let point = |p: &Peer| {
                    let at = (p.tick_min_us, (quantity.theirs)(p)?);
                    Some(Point { nodes: p.nodes, split: 1, at, survived: p.survived() })
                };
                let mut points: Vec<Point> = rows.filter_map(point).collect();
                points.sort_by(|a, b| a.at.0.total_cmp(&b.at.0));
                points
            };
            let mut methods: Vec<(&str, Vec<Point>)> = Method::ALL.map(of_method).into();
            methods.push(("ours, on their grids", own(on_grids, Method::Palpate)));
            methods.push(("ours, contact searched", own(searched, Method::Calibrated)));
            methods.extend(models.iter().map(|model| (model.as_str(), theirs(model))));
            let drawn = |methods: &[(&str, Vec<Point>)]| methods.iter().any(|(_, points)| !points.is_empty());
            let (ours, theirs) = methods.split_at(Method::ALL.len());
            if !drawn(ours) || !drawn(&theirs[2..]) {
                continue;
            }
            let kpa = modulus_pa * 1e-3;
            let below = format!(
                "block of {kpa} kPa, hemisphere R = 8 mm, one core of {machine}; theirs of {}{elsewhere}; lower and further left is better",
                peers.date
            );
            let title = format!("Engines of other people and ours at the same press: {}", quantity.words);
            let (x, budget, budget_name) = COST_WORDS[0];
            let plot = scatter(x, quantity.axis, Some((budget, budget_name)), &methods);
            figures.push(Figure::plot(format!("peers_{}_{kpa}kpa", quantity.name), title, below, plot));
        }
    }
    figures
}
