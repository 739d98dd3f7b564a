//! Meshes from files: solids of Gmsh, VTK and USD; surfaces of the first two, and of STL, OBJ and
//! PLY.

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
use super::{TetMesh, Up, gmsh, usd, vtk};

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
    /// Number of solids that were divided into tets, by kind.
    pub divided: BTreeMap<&'static str, usize>,
    /// Number of elements of second order that were read by their corners alone, by kind.
    pub by_corners: BTreeMap<&'static str, usize>,
    /// Number of elements left out that are no part of the body, by kind: triangles and lines.
    pub ignored: BTreeMap<&'static str, usize>,
    /// Number of tets left out because an earlier one has the same nodes.
    pub copies: usize,
    /// Axis that points up by the file's own words.
    pub up: Option<Up>,
    /// Number of nodes left out because no tet names them.
    pub unused_nodes: usize,
    /// Extents along x, y, z [m].
    pub size_m: [f64; 3],
    /// Sum of the tets' volumes [m^3].
    pub volume_m3: f64,
    /// The tet of lowest quality.
    pub worst_tet: WorstTet,
}

impl ImportReport {
    /// Phrases for every change on the way from the solids of the file to tets.
    #[must_use]
    pub fn notes(&self) -> Vec<String> {
        let divided = self.divided.iter().map(|(kind, n)| format!("{n} element(s) of type {kind} divided into tets"));
        let corners = self.by_corners.iter().map(|(kind, n)| format!("{n} {kind}(s) of second order read by their corners"));
        let copies = (self.copies > 0).then(|| format!("{} tet(s) left out, copies of others", self.copies));
        let up = self
            .up
            .filter(|up| *up != Up::Z)
            .map(|_| "the file names another axis than z as up: turned, unless the scene has tissue.up");
        divided.chain(corners).chain(copies).chain(up.map(String::from)).collect()
    }
}

/// Content of a mesh file: tets, or a closed surface still to be filled with tets.
#[derive(Clone, Debug)]
pub enum MeshFile {
    /// A mesh that already has tets.
    Tets(Imported),
    /// A surface.
    Surface(ImportedSurface),
}

/// Reads and checks the mesh or the surface in the file at `path`, `unit_m` metres per file unit.
///
/// # Errors
/// Errors of [`open_turned`].
pub fn open(path: &Path, unit_m: f64) -> Result<MeshFile, MeshError> {
    open_turned(path, unit_m, None)
}

/// Like [`open`], with the axis of the file that points up, where that is not the one that the file
/// names, or z.
///
/// # Errors
/// The first defect that is found: of the file, of its text, of a number in it, or of the mesh.
pub fn open_turned(path: &Path, unit_m: f64, up: Option<Up>) -> Result<MeshFile, MeshError> {
    if !(unit_m > 0.0 && unit_m.is_finite()) {
        return Err(whole_file(path, Defect::LengthUnit(unit_m)));
    }
    let (file, data) = (name(path), content(path)?);
    let data = data.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&data);
    let head = data.trim_ascii_start();
    if let Some((is, instead)) = foreign(head).filter(|_| !surface_file::is_exactly_binary(data)) {
        return Err(whole_file(path, Defect::Foreign { is, instead }));
    }
    let mut raw = if head.starts_with(b"$") {
        gmsh::read(&file, data)
    } else if head.get(..16).is_some_and(|start| start.eq_ignore_ascii_case(b"# vtk DataFile V")) {
        vtk::read(&file, data)
    } else if head.starts_with(b"<") {
        vtk::xml::read(&file, data)
    } else if head.starts_with(b"#usda") {
        usd::read(&file, data, unit_m)
    } else if let Some(format) = Format::of(path, data) {
        let surface = surface_file::read(&file, data, format)?;
        return surface_file::checked(&file, surface, unit_m, up.unwrap_or_default()).map(MeshFile::Surface);
    } else {
        let line = head.split(|byte| *byte == b'\n').next().unwrap_or_default();
        let starts = quoted(String::from_utf8_lossy(line).trim());
        Err(whole_file(path, Defect::UnknownFormat { starts }))
    }?;
    raw.complete();
    if !raw.has_solids() && !raw.face_ends.is_empty() {
        let surface = surface_file::of_faces(&raw)?;
        return surface_file::checked(&file, surface, unit_m, up.unwrap_or_default()).map(MeshFile::Surface);
    }
    let up = up.or(raw.up).unwrap_or_default();
    raw.nodes.iter_mut().for_each(|node| node.position = up.turned(node.position));
    checked(raw, unit_m).map(MeshFile::Tets)
}

/// Names a file that holds no mesh by its first bytes, and says what to do.
fn foreign(head: &[u8]) -> Option<(&'static str, &'static str)> {
    let begins = |with: &str| head.get(..with.len()).is_some_and(|start| start.eq_ignore_ascii_case(with.as_bytes()));
    let line = head.split(|byte| matches!(byte, b'\n' | b'\r')).next().unwrap_or_default();
    // the name of a Gmsh section stands alone, right behind its sign
    let is_comment = line.starts_with(b"$") && !line.get(1).is_some_and(u8::is_ascii_alphabetic);
    match () {
        () if begins("version https://git-lfs") => {
            Some(("a pointer of Git LFS, not the file itself", "fetch that with `git lfs pull`"))
        }
        () if begins("<!doctype html") || begins("<html") => {
            Some(("a web page, not a mesh", "download the file itself (on GitHub: Raw)"))
        }
        () if head.starts_with(b"\xff\xfe") || head.starts_with(b"\xfe\xff") || is_wide(head) => {
            Some(("text in UTF-16", "save it as UTF-8 or plain ASCII"))
        }
        () if begins("PXR-USDC") || head.starts_with(b"PK\x03\x04") => {
            Some(("binary USD, or another packed file", "unpack it as text: usdcat FILE -o FILE.usda"))
        }
        () if is_comment => Some((
            "it begins with `$` but with no section of Gmsh: a Nastran file",
            "export as Gmsh 2.2 or 4.1 (.msh) or as VTK (.vtu)",
        )),
        () => None,
    }
}

/// Whether every other byte is zero and those between are text: UTF-16 without its mark.
fn is_wide(head: &[u8]) -> bool {
    let pairs = head.get(..16).unwrap_or_default().chunks_exact(2);
    let text = |byte: u8| byte.is_ascii_graphic() || byte.is_ascii_whitespace();
    pairs.len() > 0 && (pairs.clone().all(|p| p[0] == 0 && text(p[1])) || pairs.clone().all(|p| p[1] == 0 && text(p[0])))
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
    let whole = |defect| MeshError { file: raw.file.clone(), line: None, defect };
    let listed = |kinds: &BTreeMap<&'static str, usize>| {
        kinds.iter().map(|(kind, count)| format!("{count} {kind}")).collect::<Vec<_>>().join(", ")
    };
    if !raw.unread.is_empty() {
        return Err(whole(Defect::Unread { kinds: listed(&raw.unread) }));
    }
    if raw.tets.is_empty() {
        let ignored = if raw.ignored.is_empty() { String::new() } else { format!(", only {}", listed(&raw.ignored)) };
        return Err(whole(Defect::NoTets { ignored }));
    }
    let mut solid = resolve(&raw, unit_m)?;
    let found = check(&mut solid, unit_m)?;
    let (index, quality) = found.worst;
    Ok(Imported {
        report: ImportReport {
            format: raw.format,
            nodes: solid.mesh.nodes_m.len(),
            tets: solid.mesh.tets.len(),
            flipped_tets: found.flipped_tets,
            divided: raw.divided,
            by_corners: raw.by_corners,
            ignored: raw.ignored,
            copies: solid.copies,
            up: raw.up,
            unused_nodes: solid.unused_nodes,
            size_m: found.size_m,
            volume_m3: found.volume_m3,
            worst_tet: WorstTet { index, quality },
        },
        mesh: solid.mesh,
    })
}
