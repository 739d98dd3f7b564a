//! Our results against those of other engines: how much cheaper our models are at the same error,
//! and how much more accurate at the same cost.

use super::press::on_grid;
use super::{GRIDS, Peer, Peers, figures, grid_name, searched};
use crate::chart::moving::SPEEDS_MM_PER_S;
use crate::chart::run::Measured;
use crate::chart::{Reference, Run, Task, measure, rows};
use crate::error::Error;
use crate::methods::Method;
use crate::study::{Findings, Table};

/// Speeds of the ramps that are also compared one by one [mm/s], because the tap dominates the root
/// mean square over all of them.
pub const RAMPS_MM_PER_S: [u32; 2] = [40, 200];

/// A row of another engine against the best of our models. A factor above 1 is in our favour; it is
/// `None` if none of our models is as accurate, or none is as cheap.
#[derive(Clone, Debug, PartialEq)]
pub struct Compared<'a> {
    /// Row of the other engine.
    pub peer: &'a Peer,
    /// Factors for the force error in the holds.
    pub held: Factors,
    /// Factors for the force error while the probe moves, if both sides have one.
    pub moving: Option<Factors>,
    /// Factors for each of the ramps of 40 and 200 mm/s by itself.
    pub ramps: [Option<Factors>; RAMPS_MM_PER_S.len()],
    /// Our model on the same mesh: tick time [us], held error [%], moving error [%].
    pub same_mesh: Option<[Option<f64>; 3]>,
}

/// Factors between a row of another engine and the best of our models.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Factors {
    /// Cost of the other engine, divided by that of our cheapest model with at most the same error
    /// (1).
    pub cheaper: Option<f64>,
    /// Error of the other engine, divided by that of our most accurate model that costs no more
    /// (1).
    pub nearer: Option<f64>,
}

/// Runs our uncalibrated model on every grid that the other engines used.
pub fn same_meshes(peers: &[Peer], reference: &Reference, moving: bool) -> Result<Vec<Run>, Error> {
    let mut runs = Vec::new();
    for cells in GRIDS {
        let mut moduli: Vec<f64> = peers.iter().filter(|p| p.mesh == grid_name(cells)).map(|p| p.youngs_modulus_pa).collect();
        moduli.sort_by(f64::total_cmp);
        moduli.dedup();
        for youngs_modulus_pa in moduli {
            let block = on_grid(cells, youngs_modulus_pa);
            let task = Task { method: Method::Palpate, nodes: block.size().nodes, youngs_modulus_pa, refinement: 1 };
            runs.extend(measure(&[task], &block, reference, moving)?);
        }
    }
    Ok(runs)
}

/// Compares every row of the other engines with our models at the same stiffness; rows at a
/// stiffness at which ours were not run are left out.
pub fn compare<'a>(peers: &'a [Peer], runs: &[Run], on_grids: &[Run]) -> Vec<Compared<'a>> {
    let of_peer = |peer: &'a Peer| {
        let ours: Vec<&Measured> = runs
            .iter()
            .filter(|run| {
                matches!(run.task.method, Method::Palpate | Method::Calibrated)
                    && run.task.youngs_modulus_pa == peer.youngs_modulus_pa
            })
            .filter_map(Run::survived)
            .collect();
        if ours.is_empty() {
            return None;
        }
        let held = factors(&ours, peer, peer.held_rms_pct, |m| m.accuracy.rms_pct());
        let moved = ours.iter().any(|m| m.moving_rms_pct().is_some());
        let moving = peer.moving_rms_pct().filter(|_| moved).map(|pct| factors(&ours, peer, pct, |m| m.moving_rms_pct()));
        let on_mesh = |run: &&Run| run.task.nodes == peer.nodes && run.task.youngs_modulus_pa == peer.youngs_modulus_pa;
        let of_patch = |run: &&Run| run.task.method == Method::Calibrated && run.task.refinement == 1;
        let ramps = RAMPS_MM_PER_S.map(|speed| {
            let at = SPEEDS_MM_PER_S.iter().position(|v| *v == speed)?;
            let own = |m: &Measured| Some(m.moving?.0.get(at)?.rms_pct);
            peer.moving_pct[at].filter(|_| moved).map(|pct| factors(&ours, peer, pct, own))
        });
        let same = match peer.mesh.split_once('-') {
            Some(("grid", _)) => on_grids.iter().find(on_mesh),
            Some(("patch", _)) => runs.iter().filter(of_patch).find(on_mesh),
            _ => None,
        };
        let same_mesh = same.and_then(Run::survived).map(|m| [Some(m.time.min_us), m.accuracy.rms_pct(), m.moving_rms_pct()]);
        Some(Compared { peer, held, moving, ramps, same_mesh })
    };
    peers.iter().filter_map(of_peer).collect()
}

fn factors(ours: &[&Measured], peer: &Peer, error_pct: f64, error: impl Fn(&Measured) -> Option<f64>) -> Factors {
    let least = |values: &mut dyn Iterator<Item = f64>| values.reduce(f64::min);
    let as_right = |m: &&&Measured| error(m).is_some_and(|e| e <= error_pct);
    let as_cheap = |m: &&&Measured| m.time.min_us <= peer.tick_min_us;
    let cost_us = least(&mut ours.iter().filter(as_right).map(|m| m.time.min_us));
    let own_pct = least(&mut ours.iter().filter(as_cheap).filter_map(|m| error(m)));
    Factors { cheaper: cost_us.map(|us| peer.tick_min_us / us), nearer: own_pct.map(|pct| error_pct / pct) }
}

/// The smallest factor in cost and the smallest in error over all rows; `None` if there is no row,
/// or if a row has no counterpart among our models. `of` selects the quantity.
pub fn least(compared: &[Compared], of: impl Fn(&Compared) -> Option<Factors>) -> Factors {
    let over = |factor: fn(Factors) -> Option<f64>| {
        let all: Option<Vec<f64>> = compared.iter().filter_map(&of).map(factor).collect();
        all.and_then(|all| all.into_iter().reduce(f64::min))
    };
    Factors { cheaper: over(|f| f.cheaper), nearer: over(|f| f.nearer) }
}

fn table(compared: &[Compared]) -> Table {
    let mut table = Table::rows("peers", compared)
        .col("engine", |row| row.peer.engine.clone())
        .csv("version", |row| row.peer.version.clone())
        .col("model", |row| row.peer.model.clone())
        .col("mesh", |row| row.peer.mesh.clone())
        .csv("nodes", |row| row.peer.nodes)
        .csv("tets", |row| row.peer.tets)
        .col("youngs_modulus_pa", |row| row.peer.youngs_modulus_pa)
        .col("substeps", |row| row.peer.substeps)
        .col("survives_8mm", |row| row.peer.survives.clone())
        .col("tick_min_us", |row| row.peer.tick_min_us)
        .csv("tick_median_us", |row| row.peer.tick_median_us)
        .col("held_rms_pct", |row| row.peer.held_rms_pct)
        .col("moving_rms_pct", |row| row.peer.moving_rms_pct())
        .col("ours_cheaper_held", |row| row.held.cheaper)
        .col("ours_nearer_held", |row| row.held.nearer)
        .col("ours_cheaper_moving", |row| row.moving.and_then(|f| f.cheaper))
        .col("ours_nearer_moving", |row| row.moving.and_then(|f| f.nearer));
    for (n, speed) in RAMPS_MM_PER_S.into_iter().enumerate() {
        table = table
            .csv(&format!("ours_cheaper_{speed}_mm_per_s"), |row| row.ramps[n].and_then(|f| f.cheaper))
            .csv(&format!("ours_nearer_{speed}_mm_per_s"), |row| row.ramps[n].and_then(|f| f.nearer));
    }
    for (n, name) in ["tick_min_us", "held_rms_pct", "moving_rms_pct"].into_iter().enumerate() {
        table = table.col(&format!("ours_same_mesh_{name}"), |row| row.same_mesh.and_then(|ours| ours[n]));
    }
    table.all()
}

/// Runs our model on the meshes of the other engines, and adds the comparison.
pub fn add(findings: &mut Findings, peers: &Peers, runs: &[Run], moving: bool) -> Result<(), Error> {
    let reference = Reference::block();
    let on_grids = same_meshes(&peers.rows, &reference, moving)?;
    let searched = if moving { searched(&peers.rows, runs, &reference)? } else { Vec::new() };
    let compared = compare(&peers.rows, &[runs, &searched[..]].concat(), &on_grids);
    let about = format!(
        "engines of other people ({}, {}); cheaper: their tick over that of our cheapest as right; nearer: their error over that of our best as cheap",
        peers.machine, peers.date
    );
    findings.tables.push(table(&compared).about(about));
    if !searched.is_empty() {
        let table = rows("searched", &searched).only(|run| run.survived().is_some());
        findings.tables.push(table.about("ours, contact searched"));
    }
    findings.figures.extend(figures(peers, runs, &on_grids, &searched));
    let mut say = |what: &str, f: Factors| {
        let said = |v: Option<f64>| v.map_or("none".into(), |v| format!("{v:.1}"));
        findings.notes.push(format!(
            "over all rows, ours is at least, {what}: {} times cheaper as right, {} times nearer as cheap (none: no answer)",
            said(f.cheaper),
            said(f.nearer)
        ));
    };
    say("held", least(&compared, |row| Some(row.held)));
    say("moving, all four", least(&compared, |row| row.moving));
    for (n, speed) in RAMPS_MM_PER_S.into_iter().enumerate() {
        say(&format!("ramp of {speed} mm/s"), least(&compared, |row| row.ramps[n]));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_least_factor_is_none_where_one_is_missing() {
        let peer = Peer {
            engine: "engine".into(),
            version: "1".into(),
            model: "model".into(),
            mesh: "grid-245".into(),
            nodes: 245,
            tets: 720,
            youngs_modulus_pa: 3500.0,
            substeps: 1,
            survives: "yes".into(),
            tick_min_us: 100.0,
            tick_median_us: 100.0,
            held_rms_pct: 10.0,
            moving_pct: [None; 4],
            force_read: "contact".into(),
        };
        let row = |cheaper, nearer, moving| {
            let held = Factors { cheaper, nearer };
            Compared { peer: &peer, held, moving, ramps: [None; 2], same_mesh: None }
        };
        let moving = Some(Factors { cheaper: Some(7.0), nearer: Some(8.0) });
        let rows = [row(Some(3.0), Some(5.0), moving), row(Some(2.0), None, None)];
        assert_eq!(least(&rows, |row| Some(row.held)), Factors { cheaper: Some(2.0), nearer: None });
        assert_eq!(least(&rows, |row| row.moving), Factors { cheaper: Some(7.0), nearer: Some(8.0) });
        assert_eq!(least(&rows, |row| row.ramps[0]), Factors::default());
    }
}
