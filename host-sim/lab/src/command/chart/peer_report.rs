//! `palpate chart --with`: compares other engines with ours.

use crate::chart::peers::{
    Compared, Factors, Peers, RAMPS_MM_PER_S, compare, draw_peers, least, same_meshes, searched, write_compared,
};
use crate::chart::{Reference, Run};
use palpate_sim::error::Error;
use palpate_tissue::output::OutputFolder;

/// Runs our model on the meshes of the other engines, writes `peers.csv` and the pictures, and
/// prints the comparison.
pub fn add(folder: &OutputFolder, peers: &Peers, runs: &[Run], moving: bool) -> Result<(), Error> {
    let reference = Reference::block();
    let on_grids = same_meshes(&peers.rows, &reference, moving)?;
    let searched = if moving { searched(&peers.rows, runs, &reference)? } else { Vec::new() };
    let compared = compare(&peers.rows, &[runs, &searched[..]].concat(), &on_grids);
    write_compared(folder, &compared)?;
    draw_peers(folder, peers, runs, &on_grids, &searched)?;
    print_searched(&searched);
    print_compared(peers, &compared);
    Ok(())
}

fn print_searched(searched: &[Run]) {
    for run in searched {
        let Some(measured) = run.survived() else { continue };
        let (nodes, kpa, us) = (run.task.nodes, run.task.youngs_modulus_pa * 1e-3, measured.time.min_us);
        let or_dash = |v: Option<f64>| v.map_or("-".into(), |v| format!("{v:.1}"));
        let [held, moving] = [measured.accuracy.rms_pct(), measured.moving_rms_pct()].map(or_dash);
        println!(
            "ours, contact searched: {nodes} nodes at {kpa} kPa, {} substeps: {us:.1} us, held {held} %, moving {moving} %",
            measured.substeps
        );
    }
}

fn print_compared(peers: &Peers, compared: &[Compared]) {
    println!(
        "\nengines of other people ({}, {}); cheaper: their tick over that of our cheapest as right; nearer: their error over that of our best as cheap",
        peers.machine, peers.date
    );
    println!(
        "{:<34} {:<10} {:>4} {:>5} {:>9} {:>7} {:>8} | {:>13} {:>13} | {:>22}",
        "engine", "mesh", "kPa", "steps", "us/tick", "held %", "moving %", "held x cheap", "moving", "ours, same mesh us % %"
    );
    let or_none = |v: Option<f64>| v.map_or("none".into(), |v| if v < 10.0 { format!("{v:.1}") } else { format!("{v:.0}") });
    let or_dash = |v: Option<f64>| v.map_or("-".into(), |v| format!("{v:.1}"));
    let both = |f: Factors| format!("{} / {}", or_none(f.cheaper), or_none(f.nearer));
    for row in compared {
        let p = row.peer;
        let (kpa, moving) = (p.youngs_modulus_pa * 1e-3, p.moving_rms_pct());
        print!("{:<34} {:<10} {kpa:>4} {:>5} {:>9.1}", p.name(), p.mesh, p.substeps, p.tick_min_us);
        print!(" {:>7.1} {:>8} | {:>13}", p.held_rms_pct, or_dash(moving), both(row.held));
        let same = row.same_mesh.map_or("-".into(), |ours| ours.map(or_dash).join(" "));
        print!(" {:>13} | {same:>22}", row.moving.map_or("-".into(), both));
        println!("{}", if p.survived() { String::new() } else { format!("  {}", p.survives) });
    }
    println!("over all rows, ours is at least (none: a row to which ours has no answer)");
    let say = |what: &str, f: Factors| {
        println!("  {what:<22} {:>5} times cheaper as right, {:>5} times nearer as cheap", or_none(f.cheaper), or_none(f.nearer));
    };
    say("held", least(compared, |row| Some(row.held)));
    say("moving, all four", least(compared, |row| row.moving));
    for (n, speed) in RAMPS_MM_PER_S.into_iter().enumerate() {
        say(&format!("ramp of {speed} mm/s"), least(compared, |row| row.ramps[n]));
    }
}
