//! Closed surfaces from files: STL, as text or binary, and OBJ.

mod closed;
mod obj;
mod stl;

use std::path::Path;

use super::check::size;
use super::crossings::crossings;
use super::distance::ClosedSurface;
use super::error::{Defect, MeshError};

/// A closed surface that passed every check.
#[derive(Clone, Debug)]
pub struct ImportedSurface {
    /// The surface [m], its triangles counter-clockwise seen from outside.
    pub surface: ClosedSurface,
    /// Report on what was read, left out and corrected.
    pub report: SurfaceReport,
}

/// Findings of the import of a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct SurfaceReport {
    /// Name of the file format.
    pub format: &'static str,
    /// Number of triangles of the surface.
    pub triangles: usize,
    /// Number of corners, each of which several triangles share.
    pub vertices: usize,
    /// Number of triangles that faced inward and were reversed.
    pub turned_triangles: usize,
    /// Number of triangles left out because two of their corners coincide.
    pub left_out: usize,
    /// Number of closed surfaces inside the outer one, each of which bounds a cavity.
    pub hollows: usize,
    /// Extents along x, y, z [m].
    pub size_m: [f64; 3],
    /// Volume that the surface encloses, without the cavities [m^3].
    pub volume_m3: f64,
}

/// Triangles as they are in their file: in file units, and not checked yet.
struct RawSurface {
    format: &'static str,
    vertices: Vec<[f64; 3]>,
    /// Indices of each triangle's vertices.
    triangles: Vec<[u32; 3]>,
}

/// Format of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Format {
    StlText,
    StlBinary,
    Obj,
}

impl Format {
    /// Determines the format by the content or, if that is ambiguous, by the extension; `None` for
    /// anything else.
    pub fn of(path: &Path, data: &[u8]) -> Option<Self> {
        let extension = path.extension().map(|e| e.to_ascii_lowercase());
        let has_extension = |name: &str| extension.as_ref().is_some_and(|e| e == name);
        // Some programs begin a binary file with `solid` as well, so its length decides.
        if stl::is_binary(data) {
            Some(Self::StlBinary)
        } else if data.trim_ascii_start().get(..5).is_some_and(|start| start.eq_ignore_ascii_case(b"solid")) {
            Some(Self::StlText)
        } else if has_extension("stl") {
            Some(Self::StlBinary)
        } else if has_extension("obj") || obj::starts(data) {
            Some(Self::Obj)
        } else {
            None
        }
    }
}

/// Reads, closes, orients and checks a surface, `unit_m` metres per file unit.
pub(super) fn read(file: &str, data: &[u8], format: Format, unit_m: f64) -> Result<ImportedSurface, MeshError> {
    let raw = match format {
        Format::StlText => stl::read_text(file, &String::from_utf8_lossy(data)),
        Format::StlBinary => stl::read_binary(file, data),
        Format::Obj => obj::read(file, &String::from_utf8_lossy(data)),
    }?;
    let error = |defect| MeshError { file: file.to_owned(), line: None, defect };
    let closed = closed::close(&raw).map_err(error)?;
    let in_metres: Vec<[f64; 3]> = closed.vertices.iter().map(|at| at.map(|x| x * unit_m)).collect();
    let size_m = size(&in_metres, unit_m).map_err(error)?;
    let surface = ClosedSurface::of_triangles(&in_metres, &closed.triangles);
    let surface = surface.ok_or_else(|| error(Defect::NoTriangles))?;
    if let Some((pairs, at_m)) = crossings(&surface) {
        return Err(error(Defect::Crossing { pairs, near: closed::place(at_m.map(|x| x / unit_m)) }));
    }
    Ok(ImportedSurface {
        report: SurfaceReport {
            format: raw.format,
            triangles: closed.triangles.len(),
            vertices: closed.vertices.len(),
            turned_triangles: closed.turned_triangles,
            left_out: closed.left_out,
            hollows: closed.hollows,
            size_m,
            volume_m3: closed.volume * unit_m.powi(3),
        },
        surface,
    })
}
