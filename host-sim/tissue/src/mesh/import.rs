//! Meshes from files: tets of Gmsh 1, 2.x and 4.1, VTK legacy and XML; surfaces of STL and OBJ.

use std::collections::BTreeMap;
use std::path::Path;

pub use super::check::MIN_QUALITY;
use super::check::check;
use super::error::{Defect, MeshError, quoted};
use super::file::{content, name, whole_file};
use super::quality::WorstTet;
use super::raw::RawMesh;
use super::resolve::resolve;
use super::surface_file::{self, Format, ImportedSurface};
use super::{TetMesh, gmsh, vtk};

/// A mesh that passed every check.
#[derive(Clone, Debug, PartialEq)]
pub struct Imported {
    /// Nodes in use, in the order of the file; tets in the order of the file.
    pub mesh: TetMesh,
    /// Report on what was read, left out and corrected.
    pub report: ImportReport,
}

/// Findings of an import.
#[derive(Clone, Debug, PartialEq)]
pub struct ImportReport {
    /// Name and version of the file format.
    pub format: &'static str,
    /// Number of nodes in use.
    pub nodes: usize,
    /// Number of tets.
    pub tets: usize,
    /// Number of inverted tets in the file, of which two nodes were swapped.
    pub flipped_tets: usize,
    /// Number of elements left out, by kind: triangles and lines, but also hexahedra and other
    /// solids.
    pub ignored: BTreeMap<&'static str, usize>,
    /// Number of nodes left out because no tet names them.
    pub unused_nodes: usize,
    /// Extents along x, y, z [m].
    pub size_m: [f64; 3],
    /// Sum of the tets' volumes [m^3].
    pub volume_m3: f64,
    /// The tet of lowest quality.
    pub worst_tet: WorstTet,
}

/// Content of a mesh file: tets, or a closed surface still to be filled with tets.
#[derive(Clone, Debug)]
pub enum MeshFile {
    /// A mesh that already has tets.
    Tets(Imported),
    /// A surface, of STL or OBJ.
    Surface(ImportedSurface),
}

/// Reads and checks the mesh or the surface in the file at `path`, `unit_m` metres per file unit.
///
/// # Errors
/// The first defect that is found: of the file, of its text, of a number in it, or of the mesh.
pub fn open(path: &Path, unit_m: f64) -> Result<MeshFile, MeshError> {
    if !(unit_m > 0.0 && unit_m.is_finite()) {
        return Err(whole_file(path, Defect::LengthUnit(unit_m)));
    }
    let (file, data) = (name(path), content(path)?);
    let data = data.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&data);
    let head = data.trim_ascii_start();
    let raw = if head.starts_with(b"$") {
        gmsh::read(&file, data)
    } else if head.starts_with(b"# vtk DataFile") {
        vtk::read(&file, data)
    } else if head.starts_with(b"<?xml") || head.starts_with(b"<VTKFile") {
        vtk::xml::read(&file, data)
    } else if let Some(format) = Format::of(path, data) {
        return surface_file::read(&file, data, format, unit_m).map(MeshFile::Surface);
    } else {
        let line = head.split(|byte| *byte == b'\n').next().unwrap_or_default();
        let starts = quoted(String::from_utf8_lossy(line).trim());
        Err(whole_file(path, Defect::UnknownFormat { starts }))
    }?;
    checked(raw, unit_m).map(MeshFile::Tets)
}

/// Reads, checks and orients the mesh in the file at `path`, `unit_m` metres per file unit.
///
/// # Errors
/// Errors of [`open`]; also if the file contains a surface.
pub fn import(path: &Path, unit_m: f64) -> Result<Imported, MeshError> {
    match open(path, unit_m)? {
        MeshFile::Tets(imported) => Ok(imported),
        MeshFile::Surface(surface) => Err(whole_file(path, Defect::Surface { format: surface.report.format })),
    }
}

fn checked(raw: RawMesh, unit_m: f64) -> Result<Imported, MeshError> {
    let mut solid = resolve(&raw, unit_m)?;
    let found = check(&mut solid, unit_m)?;
    let (index, quality) = found.worst;
    Ok(Imported {
        report: ImportReport {
            format: raw.format,
            nodes: solid.mesh.nodes_m.len(),
            tets: solid.mesh.tets.len(),
            flipped_tets: found.flipped_tets,
            ignored: raw.ignored,
            unused_nodes: solid.unused_nodes,
            size_m: found.size_m,
            volume_m3: found.volume_m3,
            worst_tet: WorstTet { index, quality },
        },
        mesh: solid.mesh,
    })
}
