//! Closed surfaces from files: STL, OBJ, PLY, and the faces of mesh files without solids.

mod closed;
mod copies;
mod nested;
mod obj;
mod ply;
mod polygon;
mod stl;
mod weld;

use std::path::Path;

use super::check::size;
use super::crossings::{Crossings, crossings};
use super::distance::ClosedSurface;
use super::error::{Defect, MeshError};
use super::raw::RawMesh;
use super::resolve::nodes_by_number;
use super::up::Up;

/// Largest share of the surface that may lie in triangles that cross others (1): so little changes
/// a force less than the facets do. The distance, by which a surface is filled, needs no more.
const CROSSING_SHARE: f64 = 0.01;

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
    /// Number of triangles left out because another has the same corners.
    pub copies: usize,
    /// Number of closed surfaces inside the outer one, each of which bounds a cavity.
    pub hollows: usize,
    /// Number of closed surfaces inside the outer one that face outward as it does, left out: they
    /// mark a part of the body, and bound no cavity.
    pub labels: usize,
    /// Number of triangles of these.
    pub label_triangles: usize,
    /// Number of pairs of triangles that cross, and a place near the first in file units.
    pub crossings: Option<(usize, String)>,
    /// Extents along x, y, z [m].
    pub size_m: [f64; 3],
    /// Volume that the surface encloses, without the cavities [m^3].
    pub volume_m3: f64,
}

impl SurfaceReport {
    /// Phrases for everything that was left out or is doubtful.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let copies = (self.copies > 0).then(|| format!("{} triangle(s) left out, copies of others", self.copies));
        let labels = (self.labels > 0).then(|| {
            format!(
                "{} inner surface(s) of {} triangles left out: they face outward, so they mark a part and bound no hollow (a stiffer part: [[tissue.inclusion]])",
                self.labels, self.label_triangles
            )
        });
        let crossings = self.crossings.as_ref().map(|(pairs, near)| {
            format!("{pairs} pair(s) of triangles cross, the first near {near} in file units: the body is filled by distance, which may be off there")
        });
        copies.into_iter().chain(labels).chain(crossings).collect()
    }
}

/// Triangles as they are in their file: in file units, and not checked yet.
pub(super) struct RawSurface {
    format: &'static str,
    vertices: Vec<[f64; 3]>,
    /// Indices of each triangle's vertices.
    triangles: Vec<[u32; 3]>,
}

impl RawSurface {
    fn new(format: &'static str, vertices: Vec<[f64; 3]>) -> Self {
        Self { format, vertices, triangles: Vec::new() }
    }

    fn push_polygon(&mut self, corners: &[u32]) {
        match *corners {
            [a, b, c] => self.triangles.push([a, b, c]),
            _ => self.triangles.extend(polygon::triangles(&self.vertices, corners)),
        }
    }

    /// Adds a strip, in which every triangle has the last two corners of the one before.
    fn push_strip(&mut self, corners: &[u32]) {
        let triangles = corners.windows(3).enumerate().map(|(n, c)| [c[0], c[1 + n % 2], c[2 - n % 2]]);
        self.triangles.extend(triangles);
    }
}

/// The faces of a mesh file.
pub(super) fn of_faces(raw: &RawMesh) -> Result<RawSurface, MeshError> {
    let by_number = nodes_by_number(raw)?;
    let mut surface = RawSurface::new(raw.format, raw.nodes.iter().map(|node| node.position).collect());
    let mut face = Vec::new();
    let mut first = 0;
    for end in &raw.face_ends {
        face.clear();
        for number in &raw.face_corners[first..*end] {
            let found = by_number.binary_search_by_key(number, |(number, _)| *number).ok();
            let index = found.map(|at| by_number[at].1 as u32).ok_or_else(|| MeshError {
                file: raw.file.clone(),
                line: None,
                defect: Defect::Expected { what: "the number of a node of the file", found: number.to_string() },
            })?;
            face.push(index);
        }
        surface.push_polygon(&face);
        first = *end;
    }
    Ok(surface)
}

/// Format of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Format {
    StlText,
    StlBinary,
    Ply,
    Obj,
}

impl Format {
    /// Determines the format by the content or, if that is ambiguous, by the extension; `None` for
    /// anything else.
    pub fn of(path: &Path, data: &[u8]) -> Option<Self> {
        let extension = path.extension().map(|e| e.to_ascii_lowercase());
        let has_extension = |name: &str| extension.as_ref().is_some_and(|e| e == name);
        if stl::is_exactly_binary(data) {
            Some(Self::StlBinary)
        } else if stl::is_text(data) {
            Some(Self::StlText)
        } else if stl::is_binary_solid(data) {
            Some(Self::StlBinary)
        } else if ply::starts(data) {
            Some(Self::Ply)
        } else if has_extension("stl") {
            Some(Self::StlBinary)
        } else if has_extension("obj") || obj::starts(data) {
            Some(Self::Obj)
        } else {
            None
        }
    }
}

/// Whether the file has the length of a binary STL file with as many triangles as it announces.
pub(super) fn is_exactly_binary(data: &[u8]) -> bool {
    stl::is_exactly_binary(data)
}

/// Reads a surface.
pub(super) fn read(file: &str, data: &[u8], format: Format) -> Result<RawSurface, MeshError> {
    match format {
        Format::StlText => stl::read_text(file, &String::from_utf8_lossy(data)),
        Format::StlBinary => stl::read_binary(file, data),
        Format::Ply => ply::read(file, data),
        Format::Obj => obj::read(file, &String::from_utf8_lossy(data)),
    }
}

/// Closes, orients and checks a surface, `unit_m` metres per file unit.
pub(super) fn checked(file: &str, raw: RawSurface, unit_m: f64, up: Up) -> Result<ImportedSurface, MeshError> {
    let error = |defect| MeshError { file: file.to_owned(), line: None, defect };
    let format = raw.format;
    let mut closed = closed::close(&raw).map_err(error)?;
    drop(raw);
    closed.vertices.iter_mut().for_each(|at| *at = up.turned(*at));
    let in_metres: Vec<[f64; 3]> = closed.vertices.iter().map(|at| at.map(|x| x * unit_m)).collect();
    let size_m = size(&in_metres, unit_m).map_err(error)?;
    let surface = ClosedSurface::of_triangles(&in_metres, &closed.triangles);
    let surface = surface.ok_or_else(|| error(Defect::NoTriangles))?;
    // in file units, since rounding to metres may move a corner through a triangle that it touches
    let found = crossings(&surface, &closed.vertices, &closed.triangles);
    let crossings = found.map(|Crossings { pairs, near, share }| (pairs, nested::place(near), share));
    if let Some((pairs, near, _)) = crossings.clone().filter(|(_, _, share)| *share > CROSSING_SHARE) {
        return Err(error(Defect::Crossing { pairs, near }));
    }
    Ok(ImportedSurface {
        report: SurfaceReport {
            format,
            triangles: closed.triangles.len(),
            vertices: closed.vertices.len(),
            turned_triangles: closed.turned_triangles,
            left_out: closed.left_out,
            copies: closed.copies,
            hollows: closed.hollows,
            labels: closed.labels,
            label_triangles: closed.label_triangles,
            crossings: crossings.map(|(pairs, near, _)| (pairs, near)),
            size_m,
            volume_m3: closed.volume * unit_m.powi(3),
        },
        surface,
    })
}
