//! XML VTK, `UnstructuredGrid` (`.vtu`) and `PolyData` (`.vtp`): pieces, with arrays as text, as
//! base64 or appended, which may be compressed by zlib. Attributes of points and cells are not
//! read.
//!
//! Pieces of a divided mesh repeat the points, and perhaps some cells, on their borders: points of
//! different pieces at the same place are one.

use std::collections::HashMap;

use roxmltree::{Document, Node};

use super::arrays::{Array, Data, Encoding};
use super::cells::Cells;
use crate::mesh::bytes::Order;
use crate::mesh::error::{Defect, MeshError, printable, quoted};
use crate::mesh::raw::{RawMesh, RawNode};

/// Start of the element with appended arrays, which is not XML if they are raw.
const APPENDED: &[u8] = b"<AppendedData";

/// Reads a `.vtu` or `.vtp` file.
pub(in crate::mesh) fn read(file: &str, data: &[u8]) -> Result<RawMesh, MeshError> {
    let at = data.windows(APPENDED.len()).position(|window| window == APPENDED);
    let (head, tail) = data.split_at(at.unwrap_or(data.len()));
    let mut text = String::from_utf8_lossy(head).into_owned();
    let appended = if tail.is_empty() {
        None
    } else {
        text.push_str("</VTKFile>");
        Some(Appended::of(tail).map_err(|defect| MeshError { file: file.to_owned(), line: None, defect })?)
    };
    let document = Document::parse(&text).map_err(|cause| MeshError {
        file: file.to_owned(),
        line: Some(cause.pos().row as usize),
        defect: Defect::Xml { cause: printable(&cause.to_string()) },
    })?;
    Reader { file, document: &document, appended }.mesh()
}

/// The appended data, without the `_` before them.
#[derive(Clone, Copy)]
struct Appended<'a> {
    is_raw: bool,
    data: &'a [u8],
}

impl<'a> Appended<'a> {
    fn of(tail: &'a [u8]) -> Result<Self, Defect> {
        let missing = || Defect::Truncated { what: "the appended data" };
        let tag = tail.iter().position(|byte| *byte == b'>').ok_or_else(missing)?;
        let (tag, data) = tail.split_at(tag + 1);
        let tag = String::from_utf8_lossy(tag).replace('\'', "\"");
        let is_raw = match tag.split_once("encoding=\"").and_then(|(_, rest)| rest.split('"').next()) {
            Some("raw") => true,
            Some("base64") => false,
            other => {
                return Err(Defect::Encoding {
                    what: "VTK appended data of encoding",
                    found: quoted(other.unwrap_or("")),
                    instead: "as raw or base64",
                });
            }
        };
        let start = data.iter().position(|byte| *byte == b'_').ok_or_else(missing)?;
        Ok(Self { is_raw, data: &data[start + 1..] })
    }
}

struct Reader<'a> {
    file: &'a str,
    document: &'a Document<'a>,
    appended: Option<Appended<'a>>,
}

impl<'a> Reader<'a> {
    fn mesh(&self) -> Result<RawMesh, MeshError> {
        let root = self.document.root_element();
        if !root.has_tag_name("VTKFile") {
            return Err(self.expected(root, "VTKFile", root.tag_name().name()));
        }
        let kind = root.attribute("type").unwrap_or("");
        if ["PUnstructuredGrid", "PPolyData"].contains(&kind) {
            return Err(self.error(root, Defect::PieceFiles));
        }
        let grid = root.children().find(|child| child.has_tag_name(kind));
        let Some(grid) = grid.filter(|_| ["UnstructuredGrid", "PolyData"].contains(&kind)) else {
            return Err(self.error(root, Defect::XmlDataSet { found: quoted(kind) }));
        };
        let encoding = self.encoding(root)?;
        let pieces: Vec<_> = grid.children().filter(|child| child.has_tag_name("Piece")).collect();
        if pieces.is_empty() {
            return Err(self.error(grid, Defect::MissingSection { section: "Piece" }));
        }
        let mut mesh = RawMesh::new("XML VTK", self.file);
        let mut at_place = HashMap::new();
        for piece in &pieces {
            let numbers = self.points(*piece, encoding, &mut mesh, (pieces.len() > 1).then_some(&mut at_place))?;
            // a point that does not exist in one piece keeps its number for the message, and must
            // not become one of another
            let missing = if pieces.len() == 1 { 0 } else { 1 << 62 };
            let number = |point: u64| numbers.get(point as usize).copied().unwrap_or(point | missing);
            match kind {
                "PolyData" => {
                    for (section, count, strips) in [("Polys", "NumberOfPolys", false), ("Strips", "NumberOfStrips", true)] {
                        let count = if piece.has_attribute(count) { self.count(*piece, count)? } else { 0 };
                        if count > 0 {
                            let (node, cells) = self.cells(*piece, section, count, encoding)?;
                            let taken = cells.take_faces(&number, strips, &mut mesh);
                            taken.map_err(|defect| self.error(node, defect))?;
                        }
                    }
                }
                _ => {
                    let count = self.count(*piece, "NumberOfCells")?;
                    if count == 0 && pieces.len() > 1 {
                        continue;
                    }
                    let (_, cells) = self.cells(*piece, "Cells", count, encoding)?;
                    let (node, types) = self.array(*piece, "Cells", Some("types"), encoding)?;
                    let types = types.wholes(count).map_err(|defect| self.error(node, defect))?;
                    for (own, code) in (0..).zip(types) {
                        cells.take(own, code, &number, &mut mesh).map_err(|defect| self.error(node, defect))?;
                    }
                }
            }
        }
        Ok(mesh)
    }

    /// Adds the points of a piece to a mesh, without those at a place in `at_place`; returns the
    /// number of each in the mesh.
    fn points(
        &self,
        piece: Node<'a, 'a>,
        encoding: Encoding,
        mesh: &mut RawMesh,
        mut at_place: Option<&mut HashMap<[u64; 3], u64>>,
    ) -> Result<Vec<u64>, MeshError> {
        let points = self.count(piece, "NumberOfPoints")?;
        if points == 0 && at_place.is_some() {
            return Ok(Vec::new());
        }
        let (node, positions) = self.array(piece, "Points", None, encoding)?;
        let positions = positions.reals(points.saturating_mul(3)).map_err(|defect| self.error(node, defect))?;
        let mut numbers = Vec::new();
        for position in positions.as_chunks::<3>().0 {
            let own = mesh.nodes.len() as u64;
            let number = match &mut at_place {
                // adding zero makes -0 and 0 equal
                Some(at_place) => *at_place.entry(position.map(|x| (x + 0.0).to_bits())).or_insert(own),
                None => own,
            };
            if number == own {
                mesh.nodes.push(RawNode { number, line: None, position: *position });
            }
            numbers.push(number);
        }
        Ok(numbers)
    }

    /// The cells of a section of a piece, and the element of their nodes for error messages.
    fn cells(
        &self,
        piece: Node<'a, 'a>,
        section: &'static str,
        count: u64,
        encoding: Encoding,
    ) -> Result<(Node<'a, 'a>, Cells), MeshError> {
        let (node, ends) = self.array(piece, section, Some("offsets"), encoding)?;
        let ends = ends.wholes(count).map_err(|defect| self.error(node, defect))?;
        let (node, nodes) = self.array(piece, section, Some("connectivity"), encoding)?;
        let nodes = nodes.wholes(ends.last().copied().unwrap_or(0)).map_err(|defect| self.error(node, defect))?;
        let cells = Cells::of_lists(nodes, &ends).map_err(|defect| self.error(node, defect))?;
        Ok((node, cells))
    }

    /// Encoding of the numbers that the file does not write as text.
    fn encoding(&self, root: Node) -> Result<Encoding, MeshError> {
        let order = match root.attribute("byte_order") {
            None | Some("LittleEndian") => Order::Little,
            Some("BigEndian") => Order::Big,
            Some(other) => return Err(self.expected(root, "the byte order LittleEndian or BigEndian", other)),
        };
        let wide = match root.attribute("header_type") {
            None | Some("UInt32") => false,
            Some("UInt64") => true,
            Some(other) => return Err(self.expected(root, "the header type UInt32 or UInt64", other)),
        };
        let zlib = match root.attribute("compressor") {
            None | Some("") => false,
            Some("vtkZLibDataCompressor") => true,
            Some(other) => {
                let (what, instead) = ("VTK compressor", "with zlib or uncompressed");
                return Err(self.error(root, Defect::Encoding { what, found: quoted(other), instead }));
            }
        };
        Ok(Encoding { order, wide, zlib })
    }

    fn count(&self, piece: Node, name: &'static str) -> Result<u64, MeshError> {
        let text = piece.attribute(name).unwrap_or("");
        text.trim().parse().map_err(|_| self.expected(piece, name, text))
    }

    /// An array of a section, and its element for error messages.
    fn array(
        &self,
        piece: Node<'a, 'a>,
        section: &'static str,
        name: Option<&str>,
        encoding: Encoding,
    ) -> Result<(Node<'a, 'a>, Array<'a>), MeshError> {
        let parent = piece.children().find(|child| child.has_tag_name(section));
        let parent = parent.ok_or_else(|| self.error(piece, Defect::MissingSection { section }))?;
        let mut arrays = parent.children().filter(|child| child.has_tag_name("DataArray"));
        let node = arrays.find(|array| name.is_none_or(|name| array.attribute("Name") == Some(name)));
        let section = match name {
            Some("connectivity") => "connectivity in Cells",
            Some("offsets") => "offsets in Cells",
            Some(_) => "types in Cells",
            None => "DataArray in Points",
        };
        let node = node.ok_or_else(|| self.error(parent, Defect::MissingSection { section }))?;
        let data = match node.attribute("format") {
            Some("ascii") => Ok(Data::Text(node.text().unwrap_or(""))),
            Some("binary") => Ok(Data::Base64(node.text().unwrap_or("").as_bytes())),
            Some("appended") => self.appended(node),
            other => Err(self.expected(node, "the format ascii, binary or appended", other.unwrap_or(""))),
        }?;
        let kind = node.attribute("type").unwrap_or("");
        let array = data.of_type(kind, encoding).ok_or_else(|| self.expected(node, "a type of numbers", kind))?;
        Ok((node, array))
    }

    fn appended(&self, node: Node) -> Result<Data<'a>, MeshError> {
        let Some(Appended { is_raw, data }) = self.appended else {
            return Err(self.error(node, Defect::MissingSection { section: "AppendedData" }));
        };
        let text = node.attribute("offset").unwrap_or("");
        let offset = text.trim().parse().map_err(|_| self.expected(node, "an offset", text))?;
        let data = data.get(offset..).ok_or_else(|| self.expected(node, "an offset into the appended data", text))?;
        Ok(if is_raw { Data::Raw(data) } else { Data::Base64(data) })
    }

    fn expected(&self, node: Node, what: &'static str, found: &str) -> MeshError {
        self.error(node, Defect::Expected { what, found: quoted(found) })
    }

    fn error(&self, node: Node, defect: Defect) -> MeshError {
        let line = self.document.text_pos_at(node.range().start).row as usize;
        MeshError { file: self.file.to_owned(), line: Some(line), defect }
    }
}
