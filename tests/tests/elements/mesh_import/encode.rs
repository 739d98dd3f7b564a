//! Writers of binary and XML mesh files that use no code of the readers.

use std::fmt::Write as _;
use std::io::Write as _;

use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use flate2::Compression;
use flate2::write::ZlibEncoder;
use palpate_tissue::mesh::TetMesh;

/// Bytes per separately compressed block: so few that every array has several blocks.
const BLOCK: usize = 96;

/// Byte order of numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Order {
    Little,
    Big,
}

/// Encoding of the arrays in XML VTK.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Xml {
    Ascii,
    Base64,
    Appended,
    AppendedRaw,
}

#[derive(Default)]
struct Out {
    bytes: Vec<u8>,
    big: bool,
}

impl Out {
    fn new(order: Order) -> Self {
        Self { bytes: Vec::new(), big: order == Order::Big }
    }

    fn text(&mut self, text: &str) {
        self.bytes.extend(text.bytes());
    }

    fn number(&mut self, little: &[u8]) {
        if self.big { self.bytes.extend(little.iter().rev()) } else { self.bytes.extend(little) }
    }

    fn i32s(&mut self, values: &[i64]) {
        for value in values {
            self.number(&i32::try_from(*value).unwrap().to_le_bytes());
        }
    }

    fn i64s(&mut self, values: &[i64]) {
        for value in values {
            self.number(&value.to_le_bytes());
        }
    }

    fn f64s<'a>(&mut self, values: impl IntoIterator<Item = &'a f64>) {
        for value in values {
            self.number(&value.to_le_bytes());
        }
    }
}

fn tags(tet: [u32; 4]) -> [i64; 4] {
    tet.map(|node| i64::from(node) + 1)
}

/// Gmsh 2 with a triangle first, as in the text files; regions are physical groups, which may be
/// negative.
pub fn gmsh_2(mesh: &TetMesh, order: Order) -> Vec<u8> {
    let mut out = Out::new(order);
    out.text("$MeshFormat\n2.2 1 8\n");
    out.i32s(&[1]);
    let nodes = mesh.nodes_m.len();
    out.text(&format!("\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"liver\"\n$EndPhysicalNames\n$Nodes\n{nodes}\n"));
    for (number, at) in (1..).zip(&mesh.nodes_m) {
        out.i32s(&[number]);
        out.f64s(at);
    }
    out.text(&format!("\n$EndNodes\n$Elements\n{}\n", mesh.tets.len() + 1));
    out.i32s(&[2, 1, 2, 1, 7, 7, 1, 2, 3]);
    // Two blocks, since Gmsh writes one block per entity.
    let half = mesh.tets.len() / 2;
    let tets: Vec<_> = (2..).zip(mesh.tets.iter().zip(&mesh.regions)).collect();
    for block in [&tets[..half], &tets[half..]].into_iter().filter(|block| !block.is_empty()) {
        out.i32s(&[4, block.len() as i64, 3]);
        for (number, (tet, region)) in block {
            out.i32s(&[*number, -i64::from(**region), 1, 0]);
            out.i32s(&tags(**tet));
        }
    }
    out.text("\n$EndElements\n$NodeData\n1\n\"p\"\n");
    out.f64s(&[0.5]);
    out.text("\n$EndNodeData\n");
    out.bytes
}

/// Gmsh 4: volume 10 + r contains region r, and region 0 has no physical group. Nodes of surfaces
/// have parameters.
pub fn gmsh_4(mesh: &TetMesh, order: Order) -> Vec<u8> {
    let mut out = Out::new(order);
    out.text("$MeshFormat\n4.1 1 8\n");
    out.i32s(&[1]);
    out.text("\n$EndMeshFormat\n$Entities\n");
    out.i64s(&[1, 0, 1, 4]);
    out.i32s(&[1]);
    out.f64s(&[0.0; 3]);
    out.i64s(&[0]);
    out.i32s(&[5]);
    out.f64s(&[0.0; 6]);
    out.i64s(&[1]);
    out.i32s(&[3]);
    out.i64s(&[0]);
    for region in 0..4 {
        out.i32s(&[10 + region]);
        out.f64s(&[0.0; 6]);
        out.i64s(&[i64::from(region > 0)]);
        if region > 0 {
            out.i32s(&[-region]);
        }
        out.i64s(&[1]);
        out.i32s(&[5]);
    }
    let (nodes, half) = (mesh.nodes_m.len(), mesh.nodes_m.len() / 2);
    out.text("\n$EndEntities\n$Nodes\n");
    out.i64s(&[2, nodes as i64, 1, nodes as i64]);
    for (header, range, parameters) in [([2, 5, 1], 0..half, 2), ([3, 10, 0], half..nodes, 0)] {
        out.i32s(&header);
        out.i64s(&[range.len() as i64]);
        out.i64s(&range.clone().map(|node| node as i64 + 1).collect::<Vec<_>>());
        for at in &mesh.nodes_m[range] {
            out.f64s(at);
            out.f64s(&[0.25; 2][..parameters]);
        }
    }
    let tets: Vec<_> = mesh.tets.iter().zip(&mesh.regions).zip(2_i64..).collect();
    let runs: Vec<_> = tets.chunk_by(|((_, a), _), ((_, b), _)| a == b).collect();
    let count = tets.len() as i64 + 1;
    out.text("\n$EndNodes\n$Elements\n");
    out.i64s(&[runs.len() as i64 + 1, count, 1, count]);
    out.i32s(&[2, 5, 2]);
    out.i64s(&[1, 1, 1, 2, 3]);
    for run in runs {
        let ((_, region), _) = run[0];
        out.i32s(&[3, 10 + i64::from(*region), 4]);
        out.i64s(&[run.len() as i64]);
        for ((tet, _), number) in run {
            out.i64s(&[*number]);
            out.i64s(&tags(**tet));
        }
    }
    out.text("\n$EndElements\n");
    out.bytes
}

/// Legacy VTK, of version 5.1 with `offsets` and of version 3.0 without.
pub fn vtk(mesh: &TetMesh, offsets: bool) -> Vec<u8> {
    let mut out = Out::new(Order::Big);
    let version = if offsets { "5.1" } else { "3.0" };
    out.text(&format!(
        "# vtk DataFile Version {version}\n\nBINARY\nDATASET UNSTRUCTURED_GRID\nFIELD FieldData 1\nTIME 1 1 double\n"
    ));
    out.f64s(&[0.5]);
    out.text(&format!("\nPOINTS {} double\n", mesh.nodes_m.len()));
    out.f64s(mesh.nodes_m.iter().flatten());
    out.text("\nMETADATA\nINFORMATION 0\n\n");
    let count = mesh.tets.len();
    let nodes: Vec<i64> = mesh.tets.iter().flatten().map(|n| i64::from(*n)).collect();
    if offsets {
        out.text(&format!("CELLS {} {}\nOFFSETS vtktypeint64\n", count + 2, 4 * count + 3));
        out.i64s(&[0]);
        out.i64s(&(0..=count as i64).map(|cell| 4 * cell + 3).collect::<Vec<_>>());
        out.text("\nCONNECTIVITY vtktypeint64\n");
        out.i64s(&[0, 1, 2]);
        out.i64s(&nodes);
    } else {
        out.text(&format!("CELLS {} {}\n", count + 1, 5 * count + 4));
        out.i32s(&[3, 0, 1, 2]);
        for tet in nodes.chunks(4) {
            out.i32s(&[4]);
            out.i32s(tet);
        }
    }
    out.text(&format!("\nCELL_TYPES {}\n", count + 1));
    out.i32s(&[5]);
    out.i32s(&vec![10; count]);
    out.text(&format!("\nCELL_DATA {}\nSCALARS material int 1\nLOOKUP_TABLE default\n", count + 1));
    out.i32s(&vec![1; count + 1]);
    out.bytes
}

/// An array of a `.vtu` file.
enum Array {
    Reals(Vec<f64>),
    Wholes(Vec<i64>),
    Bytes(Vec<u8>),
}

impl Array {
    fn kind(&self) -> &'static str {
        match self {
            Self::Reals(_) => "Float64",
            Self::Wholes(_) => "Int64",
            Self::Bytes(_) => "UInt8",
        }
    }

    fn text(&self) -> String {
        let words: Vec<String> = match self {
            Self::Reals(values) => values.iter().map(ToString::to_string).collect(),
            Self::Wholes(values) => values.iter().map(ToString::to_string).collect(),
            Self::Bytes(values) => values.iter().map(ToString::to_string).collect(),
        };
        words.join("\n ")
    }

    /// Header and data, compressed if `packed`.
    fn bytes(&self, order: Order, wide: bool, packed: bool) -> [Vec<u8>; 2] {
        let mut data = Out::new(order);
        match self {
            Self::Reals(values) => data.f64s(values),
            Self::Wholes(values) => data.i64s(values),
            Self::Bytes(values) => data.bytes.extend(values),
        }
        let mut header = Out::new(order);
        let mut length = |value: usize| if wide { header.i64s(&[value as i64]) } else { header.i32s(&[value as i64]) };
        if !packed {
            length(data.bytes.len());
            return [header.bytes, data.bytes];
        }
        let blocks: Vec<_> = data.bytes.chunks(BLOCK).map(zlib).collect();
        length(blocks.len());
        length(BLOCK);
        length(data.bytes.len() % BLOCK);
        for block in &blocks {
            length(block.len());
        }
        [header.bytes, blocks.concat()]
    }
}

fn zlib(data: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(data).unwrap();
    encoder.finish().unwrap()
}

/// XML VTK with a triangle first and with point data that the reader must ignore.
pub fn vtu(mesh: &TetMesh, form: Xml, order: Order, wide: bool, packed: bool) -> Vec<u8> {
    let cells = mesh.tets.len() as i64;
    let nodes = [0, 1, 2].into_iter().chain(mesh.tets.iter().flatten().map(|n| i64::from(*n)));
    let types = [5].into_iter().chain(vec![10; mesh.tets.len()]);
    let arrays = [
        ("pressure", Array::Reals(vec![0.5; mesh.nodes_m.len()])),
        ("Points", Array::Reals(mesh.nodes_m.iter().flatten().copied().collect())),
        ("connectivity", Array::Wholes(nodes.collect())),
        ("offsets", Array::Wholes((0..=cells).map(|cell| 4 * cell + 3).collect())),
        ("types", Array::Bytes(types.collect())),
    ];
    let mut appended: Vec<u8> = Vec::new();
    let mut written = arrays.iter().map(|(name, array)| {
        let mut text = format!("<DataArray type=\"{}\" Name=\"{name}\" ", array.kind());
        let parts = array.bytes(order, wide, packed);
        match form {
            Xml::Ascii => write!(text, "format=\"ascii\">\n{}\n</DataArray>", array.text()),
            // VTK restarts the base64 encoding after the header only if the data are compressed.
            Xml::Base64 if packed => {
                let [header, data] = parts.map(|part| BASE64_STANDARD.encode(part));
                write!(text, "format=\"binary\">\n  {header}{data}\n</DataArray>")
            }
            Xml::Base64 => write!(text, "format=\"binary\">\n  {}\n</DataArray>", BASE64_STANDARD.encode(parts.concat())),
            Xml::Appended | Xml::AppendedRaw => {
                let offset = appended.len();
                match (form, packed) {
                    (Xml::AppendedRaw, _) => appended.extend(parts.concat()),
                    (_, true) => appended.extend(parts.map(|part| BASE64_STANDARD.encode(part)).concat().bytes()),
                    (_, false) => appended.extend(BASE64_STANDARD.encode(parts.concat()).bytes()),
                }
                write!(text, "format=\"appended\" offset=\"{offset}\"/>")
            }
        }
        .unwrap();
        text
    });
    let mut next = || written.next().unwrap();
    let order = if order == Order::Big { "BigEndian" } else { "LittleEndian" };
    let header = if wide { "UInt64" } else { "UInt32" };
    let compressor = if packed { " compressor=\"vtkZLibDataCompressor\"" } else { "" };
    let text = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"{order}\" header_type=\"{header}\"{compressor}>\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<PointData>{}</PointData>\n<Points>{}</Points>\n<Cells>{}\n{}\n{}</Cells>\n</Piece>\n</UnstructuredGrid>\n",
        mesh.nodes_m.len(),
        mesh.tets.len() + 1,
        next(),
        next(),
        next(),
        next(),
        next(),
    );
    let mut bytes = text.into_bytes();
    if matches!(form, Xml::Appended | Xml::AppendedRaw) {
        let encoding = if form == Xml::AppendedRaw { "raw" } else { "base64" };
        bytes.extend(format!("<AppendedData encoding=\"{encoding}\">\n   _").bytes());
        bytes.extend(appended);
        bytes.extend(b"\n</AppendedData>\n");
    }
    bytes.extend(b"</VTKFile>\n");
    bytes
}
