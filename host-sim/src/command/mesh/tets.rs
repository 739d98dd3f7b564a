//! The command `palpate mesh tets`.

use std::fmt::Write;
use std::path::PathBuf;

use clap::Args;

use super::super::length::metres;
use super::super::progress::told;
use super::super::verdict::Verdict;
use super::{box_mm, print_surface};
use crate::error::Error;
use crate::{usda, vtu};
use palpate_tissue::Error as TissueError;
use palpate_tissue::mesh::import::{MeshFile, open};
use palpate_tissue::mesh::surface::surface;
use palpate_tissue::mesh::{ImportedSurface, LengthUnit, TetMesh, worst};
use palpate_tissue::organ::{MEAN_EDGE, OrganError, even_mesh};
use palpate_tissue::output::OutputFolder;
use palpate_tissue::tissue::underside;

/// Approximate number of nodes without `--element`.
const DEFAULT_NODES: f64 = 3000.0;
/// Largest number of nodes, since node numbers have 16 bits.
const MOST_NODES: usize = u16::MAX as usize;
/// Largest change of volume; beyond it the elements are too coarse [%].
const WORST_VOLUME_PCT: f64 = 20.0;
/// Direction against which the press from above acts.
const UP: [f64; 3] = [0.0, 0.0, 1.0];

#[derive(Args, Clone, Debug)]
pub(in crate::command) struct TetsArgs {
    /// The surface file, .stl or .obj.
    surface: PathBuf,
    /// Unit of its coordinates: m, cm, mm, um, or its length in metres.
    #[arg(long, alias = "unit-m", value_name = "UNIT")]
    unit: LengthUnit,
    /// Mean edge of the tets (2mm, 0.2cm, 0.002) [default: the length that gives about 3000 nodes].
    #[arg(long = "element", alias = "element-m", value_name = "LENGTH", value_parser = metres)]
    element_m: Option<f64>,
    /// Output folder [default: out/tets].
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

impl TetsArgs {
    pub(in crate::command) fn run(&self) -> Result<(), Error> {
        let imported = match told("reading the surface", || open(&self.surface, self.unit.metres))? {
            MeshFile::Surface(imported) => imported,
            MeshFile::Tets(_) => {
                let why = format!("{}: has tets already: give it to a scene as its mesh", self.surface.display());
                return Err(TissueError::Usage(why).into());
            }
        };
        let mesh = told("filling the surface", || self.fill(&imported))?;
        let stem = self.surface.file_stem().map_or_else(|| "surface".into(), |stem| stem.to_string_lossy().into_owned());
        let fixed = underside(&mesh, UP);
        let folder = OutputFolder::add_to(self.out.as_deref().unwrap_or("out/tets".as_ref()))?;
        folder.write(&format!("{stem}.msh"), msh(&mesh, &fixed).as_bytes())?;
        folder.write(&format!("{stem}.vtu"), vtu(&mesh, &fixed).as_bytes())?;
        folder.write(&format!("{stem}.usda"), usda::document(&mesh.nodes_m, &mesh.tets, &[]).as_bytes())?;
        let out = folder.publish()?;
        print_surface(&self.surface, &imported.report);
        print(&imported, &mesh, &fixed);
        println!("a scene takes it as mesh = \"{stem}.msh\", length_unit = \"m\"");
        Verdict::ok(format!(
            "wrote {}, {stem}.vtu and {stem}.usda: {} nodes, {} tets",
            out.join(format!("{stem}.msh")).display(),
            mesh.nodes_m.len(),
            mesh.tets.len()
        ))
        .last()
    }

    fn fill(&self, imported: &ImportedSurface) -> Result<TetMesh, Error> {
        let name = self.surface.display().to_string();
        let volume_m3 = imported.report.volume_m3;
        let usage = |why: String| Error::from(TissueError::Usage(format!("{name}: {why}")));
        // a lattice has two nodes in each cube
        let spacing_for = |nodes: f64| (2.0 * volume_m3 / nodes).cbrt();
        let spacing_m = self.element_m.map_or(spacing_for(DEFAULT_NODES), |element_m| element_m / MEAN_EDGE);
        let element_mm = spacing_m * MEAN_EDGE * 1e3;
        let size_m = imported.report.size_m.into_iter().fold(0.0, f64::max);
        if !(spacing_m > 0.0 && spacing_m < size_m) {
            let why = "--element must be above zero and smaller than the surface";
            return Err(usage(format!("{why}, {size_m:.4} m: give metres")));
        }
        let least_mm = spacing_for(MOST_NODES as f64) * MEAN_EDGE * 1e3;
        let too_many = |nodes: f64| {
            usage(format!(
                "elements of {element_mm:.3} mm make about {nodes:.0} nodes, at most {MOST_NODES} fit: give --element above {:.4}",
                1.1e-3 * least_mm
            ))
        };
        let expected = 2.0 * volume_m3 / spacing_m.powi(3);
        if expected > MOST_NODES as f64 {
            return Err(too_many(expected));
        }
        let implicit = |x| imported.surface.foot(x).distance_m;
        let mesh = even_mesh(&name, &implicit, imported.surface.bounds_m(), spacing_m).map_err(|cause| match cause {
            OrganError::TooCoarse { defect, .. } => {
                usage(format!("with elements of {element_mm:.2} mm the mesh {defect}: give a smaller --element"))
            }
            OrganError::Empty { .. } => {
                usage(format!("nothing of it is left with elements of {element_mm:.2} mm: give a smaller --element"))
            }
            OrganError::TooFine { points, .. } => usage(format!(
                "elements of {element_mm:.3} mm need a lattice of {points:.0} points, too many: give a larger --element"
            )),
            other => usage(other.to_string()),
        })?;
        if mesh.nodes_m.len() > MOST_NODES {
            return Err(too_many(mesh.nodes_m.len() as f64));
        }
        let off_pct = off_pct(&mesh, imported);
        if off_pct.abs() > WORST_VOLUME_PCT {
            return Err(usage(format!(
                "with elements of {element_mm:.2} mm the volume of the tets is {off_pct:+.0} % off that of the surface: give a smaller --element"
            )));
        }
        Ok(mesh)
    }
}

/// Difference between the volumes of tets and surface, relative to the surface's [%].
fn off_pct(mesh: &TetMesh, imported: &ImportedSurface) -> f64 {
    (mesh.volume_m3() / imported.report.volume_m3 - 1.0) * 100.0
}

fn print(imported: &ImportedSurface, mesh: &TetMesh, fixed: &[u32]) {
    println!(
        "filled with\n  {} nodes, {} tets; {:.3} cm^3 ({:+.1} % off the surface's)",
        mesh.nodes_m.len(),
        mesh.tets.len(),
        mesh.volume_m3() * 1e6,
        off_pct(mesh, imported)
    );
    if let Some(worst) = worst(mesh) {
        println!("  worst tet {} (quality {:.3}, 1 is regular)", worst.index, worst.quality);
    }
    let corner = |pick: fn(f64, f64) -> f64, start: f64| {
        let places = fixed.iter().map(|n| mesh.nodes_m[*n as usize].map(|x| x * 1e3));
        places.fold([start; 3], |corner, x| [0, 1, 2].map(|k| pick(corner[k], x[k])))
    };
    println!(
        "  supports  {} nodes, where the surface faces more than 120 degrees away from a press from above: {}",
        fixed.len(),
        box_mm([corner(f64::min, f64::INFINITY), corner(f64::max, f64::NEG_INFINITY)])
    );
}

/// The mesh as Gmsh 2.2 text: tets in the physical volume 1 "tissue", triangles in the physical
/// surface 2 "fixed".
fn msh(mesh: &TetMesh, fixed: &[u32]) -> String {
    let is_fixed = |t: &[u32; 3]| t.iter().all(|n| fixed.binary_search(n).is_ok());
    let supports: Vec<[u32; 3]> = surface(&mesh.tets).into_iter().filter(is_fixed).collect();
    let mut text = String::from(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n2\n2 2 \"fixed\"\n3 1 \"tissue\"\n$EndPhysicalNames\n",
    );
    // writing to a string does not fail
    let _ = writeln!(text, "$Nodes\n{}", mesh.nodes_m.len());
    for (n, [x, y, z]) in (1..).zip(&mesh.nodes_m) {
        let _ = writeln!(text, "{n} {x} {y} {z}");
    }
    let _ = writeln!(text, "$EndNodes\n$Elements\n{}", mesh.tets.len() + supports.len());
    for (n, tet) in (1..).zip(&mesh.tets) {
        let [a, b, c, d] = tet.map(|n| n + 1);
        let _ = writeln!(text, "{n} 4 2 1 1 {a} {b} {c} {d}");
    }
    for (n, triangle) in (mesh.tets.len() + 1..).zip(&supports) {
        let [a, b, c] = triangle.map(|n| n + 1);
        let _ = writeln!(text, "{n} 2 2 2 2 {a} {b} {c}");
    }
    text + "$EndElements\n"
}

fn vtu(mesh: &TetMesh, fixed: &[u32]) -> String {
    let is_fixed = (0..mesh.nodes_m.len() as u32).map(|n| [u8::from(fixed.binary_search(&n).is_ok())]);
    vtu::document(&mesh.nodes_m, &mesh.tets, &[vtu::Array::of("UInt8", "fixed", is_fixed)], &[])
}
