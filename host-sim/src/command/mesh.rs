//! The commands `palpate mesh check` and `palpate mesh tets`.

mod tets;

use std::path::{Path, PathBuf};

use clap::Subcommand;

use super::progress::told;
use super::verdict::Verdict;
use crate::error::Error;
use palpate_tissue::mesh::import::{MeshFile, open};
use palpate_tissue::mesh::{ImportReport, LengthUnit, SurfaceReport};

#[derive(Clone, Debug, Subcommand)]
pub(super) enum MeshCommand {
    /// Import a mesh or surface file and report its contents.
    ///
    /// Reads solids of Gmsh (1, 2, 4; text or binary), VTK (legacy .vtk, text or binary; .vtu) and
    /// USD (.usda), and surfaces of the first two (.vtp too), STL (text or binary), OBJ and PLY.
    /// Writes nothing.
    Check {
        /// The mesh or surface file.
        file: PathBuf,
        /// Unit of the mesh's coordinates: m, cm, mm, um, or its length in metres.
        #[arg(long, alias = "unit-m", value_name = "UNIT", default_value = "m")]
        unit: LengthUnit,
    },
    /// Fill a closed surface (STL, OBJ, PLY, VTK) with tets of one size.
    ///
    /// Writes <surface>.msh for scenes and Gmsh, <surface>.vtu for ParaView and <surface>.usda for
    /// engines, in metres, and prints where the tissue is supported against a press from above. A
    /// scene can also use the surface itself as its mesh: its tets are then small under the probe
    /// and grow away from it.
    Tets(tets::TetsArgs),
}

impl MeshCommand {
    pub(super) fn run(&self) -> Result<(), Error> {
        match self {
            Self::Check { file, unit } => check(file, *unit),
            Self::Tets(args) => args.run(),
        }
    }
}

fn check(file: &Path, unit: LengthUnit) -> Result<(), Error> {
    let verdict = match told("reading the file", || open(file, unit.metres))? {
        MeshFile::Tets(imported) => {
            let verdict = Verdict::ok("tets that a scene takes as its mesh").first();
            print_tets(file, &imported.report);
            verdict
        }
        MeshFile::Surface(imported) => {
            let words = "a closed surface without tets: palpate mesh tets makes them, or a scene takes it as its mesh";
            let verdict = Verdict::ok(words).first();
            print_surface(file, &imported.report);
            verdict
        }
    };
    verdict.last()
}

fn print_tets(file: &Path, report: &ImportReport) {
    let [x, y, z] = report.size_m.map(|m| m * 1e3);
    println!("{}: {}", file.display(), report.format);
    println!("  {} nodes, {} tets; {x:.2} x {y:.2} x {z:.2} mm, {:.3} cm^3", report.nodes, report.tets, report.volume_m3 * 1e6);
    println!("  worst tet {} (quality {:.4}, 1 is regular)", report.worst_tet.index, report.worst_tet.quality);
    println!("  {} inverted tets corrected, {} unused nodes left out", report.flipped_tets, report.unused_nodes);
    for note in report.notes() {
        println!("  {note}");
    }
    for (kind, count) in &report.ignored {
        println!("  {count} element(s) of type {kind} left out");
    }
}

/// Prints two or three lines about a surface file.
fn print_surface(file: &Path, report: &SurfaceReport) {
    let [x, y, z] = report.size_m.map(|m| m * 1e3);
    println!("{}: {}", file.display(), report.format);
    println!(
        "  {} triangles, {} vertices, closed; {x:.2} x {y:.2} x {z:.2} mm, {:.3} cm^3",
        report.triangles,
        report.vertices,
        report.volume_m3 * 1e6
    );
    println!("  {} triangles turned outward, {} without area left out", report.turned_triangles, report.left_out);
    if report.hollows > 0 {
        println!("  {} closed hollow(s) inside", report.hollows);
    }
    for note in report.notes() {
        println!("  {note}");
    }
}

/// Describes a box by its lowest and highest corner [mm].
pub(super) fn box_mm([low, high]: [[f64; 3]; 2]) -> String {
    // adding zero turns -0 into 0
    let rounded = |x: f64| (x * 10.0).round() / 10.0 + 0.0;
    let [x, y, z] = [0, 1, 2].map(|k| format!("{:.1} .. {:.1}", rounded(low[k]), rounded(high[k])));
    format!("x {x}, y {y}, z {z} mm")
}
