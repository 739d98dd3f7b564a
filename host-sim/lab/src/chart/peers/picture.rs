//! Pictures of theirs beside ours: cost of a tick against held and against moving error.

use palpate_charts::{MethodPoint, MethodPoints, SpeedAccuracy, speed_accuracy};
use palpate_tissue::output::OutputFolder;

use super::Peers;
use crate::chart::Run;
use crate::chart::figures::{COST_WORDS, ERROR_WORDS, front_of};
use crate::chart::run::Measured;
use crate::error::Error;
use crate::methods::Method;

/// Error of a measured run of ours, and of a row of theirs.
type Errors = [(&'static str, usize, fn(&Measured) -> Option<f64>, fn(&super::Peer) -> Option<f64>); 2];

/// Name, place of its words, ours, theirs.
const ERRORS: Errors = [
    ("held", 0, |m| m.accuracy.rms_pct(), |p| Some(p.held_rms_pct)),
    ("moving", 2, |m| m.moving_rms_pct(), |p| p.moving_rms_pct()),
];

/// Draws `peers_held_<kpa>` and `peers_moving_<kpa>` of every stiffness that both have; the names
/// that were written.
///
/// # Errors
/// A picture cannot be drawn or written.
pub fn draw_peers(folder: &OutputFolder, peers: &Peers, runs: &[Run], on_grids: &[Run]) -> Result<Vec<String>, Error> {
    let mut moduli: Vec<f64> = peers.rows.iter().map(|p| p.youngs_modulus_pa).collect();
    moduli.sort_by(f64::total_cmp);
    moduli.dedup();
    let mut names = Vec::new();
    for modulus_pa in moduli {
        if !runs.iter().any(|run| run.task.youngs_modulus_pa == modulus_pa) {
            continue;
        }
        for (name, words, own, theirs) in ERRORS {
            let mut models: Vec<String> = peers.rows.iter().map(super::Peer::name).collect();
            models.dedup();
            let own_points = |runs: &[Run], method: Method| -> Vec<MethodPoint> {
                let rows = runs.iter().filter(|r| r.task.method == method && r.task.youngs_modulus_pa == modulus_pa);
                let point = |run: &Run| {
                    let measured = run.outcome.as_ref().ok()?;
                    Some(MethodPoint {
                        nodes: run.task.nodes,
                        split: run.task.refinement,
                        cost: measured.time.min_us,
                        error: own(measured)?,
                        survived: run.survived().is_some(),
                    })
                };
                rows.filter_map(point).collect()
            };
            // ours keep the places, and so the looks, that they have in the other pictures
            let mut methods: Vec<MethodPoints> = Method::ALL
                .into_iter()
                .map(|method| {
                    let ours = matches!(method, Method::Palpate | Method::Calibrated);
                    let name = if method == Method::Calibrated { "ours, calibrated" } else { "ours, uncalibrated" };
                    MethodPoints { name, points: if ours { own_points(runs, method) } else { Vec::new() } }
                })
                .collect();
            methods.push(MethodPoints { name: "ours, on their grids", points: own_points(on_grids, Method::Palpate) });
            for model in &models {
                let rows = peers.rows.iter().filter(|p| p.youngs_modulus_pa == modulus_pa && p.name() == *model);
                let point = |p: &super::Peer| {
                    Some(MethodPoint { nodes: p.nodes, split: 1, cost: p.tick_min_us, error: theirs(p)?, survived: p.survived() })
                };
                methods.push(MethodPoints { name: model, points: rows.filter_map(point).collect() });
            }
            let theirs_drawn = methods.iter().skip(Method::ALL.len() + 1).any(|m| !m.points.is_empty());
            let ours_drawn = methods.iter().take(Method::ALL.len()).any(|m| !m.points.is_empty());
            if !theirs_drawn || !ours_drawn {
                continue;
            }
            let kpa = modulus_pa * 1e-3;
            let (what, error) = ERROR_WORDS[words];
            let file = format!("peers_{name}_{kpa}kpa");
            let front = front_of(&methods);
            let below = format!(
                "80 x 80 x 40 mm block, {kpa} kPa, hemisphere R = 8 mm, one core; ours: {}; theirs: {}, {}; fewest substeps that survive 8 mm, or else stay finite",
                palpate_tissue::machine::processor(),
                peers.machine,
                peers.date
            );
            let chart = SpeedAccuracy {
                title: &format!("Other people's engines and ours at the same press: {what}"),
                below: &below,
                cost: COST_WORDS[0].0,
                error,
                budget: Some((COST_WORDS[0].1, COST_WORDS[0].2)),
                methods: &methods,
                front: &front,
            };
            speed_accuracy(folder.draft(), &file, &chart)?;
            names.push(file);
        }
    }
    Ok(names)
}
