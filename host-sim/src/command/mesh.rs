//! `palpate mesh check` and `palpate mesh pack`.

use std::path::PathBuf;

use clap::Subcommand;

use super::Common;
use crate::budget::{MACHINES, Machine, triangles_in_reach};
use crate::error::Error;
use crate::mesh::import;
use crate::output::OutputFolder;
use crate::scene::Scene;
use crate::session::Session;

#[derive(Clone, Debug, Subcommand)]
pub(super) enum MeshCommand {
    /// Import a mesh file and report what was found: Gmsh 1, 2.2, 4.1 ASCII; TetGen .node/.ele; legacy ASCII VTK.
    Check {
        /// The mesh file.
        file: PathBuf,
        /// Metres in one unit of the file: 1 for metres, 0.001 for millimetres.
        #[arg(long, default_value_t = 1.0)]
        unit_m: f64,
    },
    /// Build a scene's patch and write it as a patch file for a board.
    Pack {
        #[command(flatten)]
        common: Common,
        /// Board whose cycle budget the patch must meet: desktop, m4f-168 or m7-480.
        #[arg(long, default_value = "m4f-168")]
        board: String,
        /// Nodes of the block's mesh, in place of the scene's.
        #[arg(long)]
        nodes: Option<usize>,
    },
}

impl MeshCommand {
    pub(super) fn run(&self) -> Result<(), Error> {
        match self {
            Self::Check { file, unit_m } => check(file, *unit_m),
            Self::Pack { common, board, nodes } => pack(common, board, *nodes),
        }
    }
}

fn check(file: &std::path::Path, unit_m: f64) -> Result<(), Error> {
    let report = import(file, unit_m)?.report;
    let [x, y, z] = report.size_m.map(|m| m * 1e3);
    println!("{}: {}", file.display(), report.format);
    println!("  {} nodes, {} tets; {x:.2} x {y:.2} x {z:.2} mm, {:.3} cm^3", report.nodes, report.tets, report.volume_m3 * 1e6);
    println!("  worst tet {} (quality {:.4}, 1 is regular)", report.worst_tet.index, report.worst_tet.quality);
    println!("  {} tets turned round, {} unused nodes left out", report.flipped_tets, report.unused_nodes);
    for (kind, count) in &report.ignored {
        println!("  {count} {kind} left out");
    }
    Ok(())
}

fn pack(common: &Common, board: &str, nodes: Option<usize>) -> Result<(), Error> {
    let Some(machine) = Machine::named(board) else {
        let names = MACHINES.map(|m| m.name).join(", ");
        return Err(Error::TooSlow(format!("no board \"{board}\": choose one of {names}")));
    };
    let mut scene = Scene::load(&common.scene)?;
    scene.tissue.nodes = nodes.or(scene.tissue.nodes);
    let folder = OutputFolder::open(&common.folder("mesh-pack"))?;
    let session = Session::prepare(&scene)?;
    let model = session.patch.model();
    let touched = triangles_in_reach(&model, session.patch.site_m().into(), session.params.probe.radius_m);
    let cost = machine.cost(&model, touched, session.params.substeps);
    if cost.units > cost.budget {
        return Err(Error::TooSlow(format!(
            "{} nodes take about {:.0} {} a tick, {:.0} fit on {}: take fewer nodes or a faster board",
            model.nodes.len(),
            cost.units,
            machine.unit,
            cost.budget,
            machine.name
        )));
    }
    let bytes = session.patch.pack(&session.params, session.stable.pressed_s as f32);
    let name = format!("{}-{}.patch", scene.name, machine.name);
    folder.write(&name, &bytes)?;
    println!(
        "{}: {} nodes, {} springs, {} tets, {} bytes; about {:.0} of {:.0} {} a tick on {} (estimate)",
        folder.path().join(name).display(),
        model.nodes.len(),
        model.springs.len(),
        model.tets.len(),
        bytes.len(),
        cost.units,
        cost.budget,
        machine.unit,
        machine.name
    );
    Ok(())
}
