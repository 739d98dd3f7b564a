//! ParaView files, ASCII: the deformed tets with displacement at the nodes and volume ratio in the
//! cells.

use std::fmt::Write;

use crate::error::Error;
use palpate_tissue::output::OutputFolder;
use palpate_tissue::press::Hold;
use palpate_tissue::session::Session;

/// Writes `press_<k>.vtu`; ParaView opens the numbered files as a series.
///
/// # Errors
/// The folder cannot be written.
pub fn write(folder: &OutputFolder, session: &Session, k: usize, hold: &Hold) -> Result<(), Error> {
    let model = session.patch.wide_model();
    let position = |n: usize| {
        let (x, u) = (model.nodes[n].rest_m, hold.displacement_m[n]);
        [0, 1, 2].map(|c| f64::from(x[c]) + f64::from(u[c]))
    };
    let (mut points, mut moved, mut face) = (String::new(), String::new(), String::new());
    for (n, (u, s)) in hold.displacement_m.iter().zip(&hold.surface_displacement_m).enumerate() {
        let [x, y, z] = position(n);
        // writing to a string does not fail
        let _ = writeln!(points, "{x} {y} {z}");
        let _ = writeln!(moved, "{} {} {}", u.x, u.y, u.z);
        let _ = writeln!(face, "{} {} {}", s.x, s.y, s.z);
    }
    let (mut cells, mut offsets, mut types, mut ratios) = (String::new(), String::new(), String::new(), String::new());
    for (t, tet) in model.tets.iter().enumerate() {
        let [a, b, c, d] = tet.node.map(usize::from);
        let [a_m, b_m, c_m, d_m] = [a, b, c, d].map(|n| palpate::Vector3::from(position(n).map(|c| c as f32)).cast::<f64>());
        let j = (b_m - a_m).cross(&(c_m - a_m)).dot(&(d_m - a_m)) * f64::from(tet.six_volume_reciprocal);
        let _ = writeln!(cells, "{a} {b} {c} {d}");
        let _ = writeln!(offsets, "{}", 4 * (t + 1));
        let _ = writeln!(types, "10");
        let _ = writeln!(ratios, "{j}");
    }
    let array = |kind: &str, name: &str, components: usize, data: &str| {
        format!(
            "<DataArray type=\"{kind}\" Name=\"{name}\" NumberOfComponents=\"{components}\" format=\"ascii\">\n{data}</DataArray>\n"
        )
    };
    let text = format!(
        "<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\" version=\"1.0\" byte_order=\"LittleEndian\">\n<UnstructuredGrid>\n<Piece NumberOfPoints=\"{}\" NumberOfCells=\"{}\">\n<Points>\n{}</Points>\n<Cells>\n{}{}{}</Cells>\n<PointData Vectors=\"displacement_m\">\n{}{}</PointData>\n<CellData Scalars=\"volume_ratio\">\n{}</CellData>\n</Piece>\n</UnstructuredGrid>\n</VTKFile>\n",
        model.nodes.len(),
        model.tets.len(),
        array("Float64", "points", 3, &points),
        array("Int64", "connectivity", 1, &cells),
        array("Int64", "offsets", 1, &offsets),
        array("UInt8", "types", 1, &types),
        array("Float64", "displacement_m", 3, &moved),
        array("Float64", "surface_displacement_m", 3, &face),
        array("Float64", "volume_ratio", 1, &ratios),
    );
    Ok(folder.write(&format!("press_{k}.vtu"), text.as_bytes())?)
}
