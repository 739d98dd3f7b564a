//! `palpate mesh check`.

use std::path::PathBuf;

use clap::Subcommand;

use crate::error::Error;
use palpate_tissue::mesh::import::import;

#[derive(Clone, Debug, Subcommand)]
pub(super) enum MeshCommand {
    /// Import a mesh file and report what was found.
    ///
    /// Reads Gmsh 1, 2.2 and 4.1 ASCII and legacy ASCII VTK. Writes nothing.
    Check {
        /// The mesh file.
        file: PathBuf,
        /// Metres in one unit of the file: 1 for metres, 0.001 for millimetres.
        #[arg(long, value_name = "METRES", default_value_t = 1.0)]
        unit_m: f64,
    },
}

impl MeshCommand {
    pub(super) fn run(&self) -> Result<(), Error> {
        match self {
            Self::Check { file, unit_m } => check(file, *unit_m),
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
