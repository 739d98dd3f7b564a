//! ParaView files in ASCII: tets with displacements and supports at the nodes, and the volume ratio
//! in the cells.

use std::fmt::Write;

use crate::error::Error;
use palpate_tissue::output::OutputFolder;
use palpate_tissue::press::Hold;
use palpate_tissue::session::Session;

/// Writes `press_<k>.vtu`; ParaView opens the numbered files as a series.
pub fn write(folder: &OutputFolder, session: &Session, k: usize, hold: &Hold) -> Result<(), Error> {
    let model = session.patch.wide_model();
    let position = |n: usize| {
        let (x, u) = (model.nodes[n].rest_m, hold.displacement_m[n]);
        [0, 1, 2].map(|c| f64::from(x[c]) + f64::from(u[c]))
    };
    let points: Vec<[f64; 3]> = (0..model.nodes.len()).map(position).collect();
    let tets: Vec<[u32; 4]> = model.tets.iter().map(|tet| tet.node.map(u32::from)).collect();
    let mut is_fixed = vec![0_u8; points.len()];
    for anchor in model.anchors {
        is_fixed[usize::from(*anchor)] = 1;
    }
    let ratio = |tet: &palpate::Tet| {
        let [a, b, c, d] = tet.node.map(|n| palpate::Vector3::from(points[usize::from(n)].map(|c| c as f32)).cast::<f64>());
        (b - a).cross(&(c - a)).dot(&(d - a)) * f64::from(tet.six_volume_reciprocal)
    };
    let moved = Array::of("Float64", "displacement_m", hold.displacement_m.iter().map(|u| [u.x, u.y, u.z]));
    let face = Array::of("Float64", "surface_displacement_m", hold.surface_displacement_m.iter().map(|u| [u.x, u.y, u.z]));
    let fixed = Array::of("UInt8", "fixed", is_fixed.iter().map(|fixed| [fixed]));
    let ratios = Array::of("Float64", "volume_ratio", model.tets.iter().map(|tet| [ratio(tet)]));
    let text = document(&points, &tets, &[moved, face, fixed], &[ratios]);
    Ok(folder.write(&format!("press_{k}.vtu"), text.as_bytes())?)
}

/// A `DataArray` in ASCII.
pub struct Array {
    text: String,
}

impl Array {
    /// Writes a data array of rows with equal numbers of components.
    pub fn of<T: std::fmt::Display, const N: usize>(kind: &str, name: &str, rows: impl IntoIterator<Item = [T; N]>) -> Self {
        let mut text = format!("<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{N}\" format=\"ascii\">\n");
        for row in rows {
            for (k, value) in row.iter().enumerate() {
                // writing to a string does not fail
                let _ = write!(text, "{}{value}", if k > 0 { " " } else { "" });
            }
            text.push('\n');
        }
        text.push_str("</DataArray>\n");
        Self { text }
    }
}

/// The text of a `.vtu` file of tets, with positions in metres.
pub fn document(points_m: &[[f64; 3]], tets: &[[u32; 4]], at_points: &[Array], in_cells: &[Array]) -> String {
    let text = |arrays: &[Array]| arrays.iter().map(|array| array.text.as_str()).collect::<String>();
    format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<Points>\n{}</Points>\n<Cells>\n{}{}{}</Cells>\n<PointData>\n{}</PointData>\n<CellData>\n{}</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n",
        points_m.len(),
        tets.len(),
        Array::of("Float64", "points", points_m.iter().copied()).text,
        Array::of("Int64", "connectivity", tets.iter().copied()).text,
        Array::of("Int64", "offsets", (1..=tets.len()).map(|t| [4 * t])).text,
        Array::of("UInt8", "types", tets.iter().map(|_| [10])).text,
        text(at_points),
        text(in_cells),
    )
}
