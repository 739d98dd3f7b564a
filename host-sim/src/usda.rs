//! USD text (`.usda`) with one `TetMesh`, for engines that simulate or draw tets.

use std::fmt::{Display, Write};

use palpate_tissue::mesh::surface::surface;
use palpate_tissue::output::OutputFolder;
use palpate_tissue::press::Hold;
use palpate_tissue::session::Session;

use crate::error::Error;

/// Writes `press.usda`: the tissue at rest, and at time code `k + 1` as it is at the end of hold
/// `k`.
pub fn write(folder: &OutputFolder, session: &Session, holds: &[Hold]) -> Result<(), Error> {
    let model = session.patch.wide_model();
    let rest: Vec<[f32; 3]> = model.nodes.iter().map(|node| node.rest_m).collect();
    let held = holds.iter().map(|hold| {
        let moved = rest.iter().zip(&hold.displacement_m);
        moved.map(|(x, u)| [x[0] + u.x, x[1] + u.y, x[2] + u.z]).collect()
    });
    let frames: Vec<Vec<[f32; 3]>> = std::iter::once(rest.clone()).chain(held).collect();
    let tets: Vec<[u32; 4]> = model.tets.iter().map(|tet| tet.node.map(u32::from)).collect();
    Ok(folder.write("press.usda", document(&rest, &tets, &frames).as_bytes())?)
}

/// The text of a `.usda` file: points at rest in metres, and at each time code from 0 in `frames`,
/// which may be empty.
pub fn document<T: Display>(points_m: &[[T; 3]], tets: &[[u32; 4]], frames: &[Vec<[T; 3]>]) -> String {
    let last = frames.len().saturating_sub(1);
    let mut text = format!(
        "#usda 1.0\n(\n    defaultPrim = \"tissue\"\n    metersPerUnit = 1\n    upAxis = \"Z\"\n    startTimeCode = 0\n    endTimeCode = {last}\n    timeCodesPerSecond = 1\n)\n\ndef TetMesh \"tissue\"\n{{\n    point3f[] points = {}\n",
        rows(points_m)
    );
    if !frames.is_empty() {
        text.push_str("    point3f[] points.timeSamples = {\n");
        for (k, frame) in frames.iter().enumerate() {
            // writing to a string does not fail
            let _ = writeln!(text, "        {k}: {},", rows(frame));
        }
        text.push_str("    }\n");
    }
    let (tets, faces) = (rows(tets), rows(&surface(tets)));
    text + &format!("    int4[] tetVertexIndices = {tets}\n    int3[] surfaceFaceVertexIndices = {faces}\n}}\n")
}

fn rows<T: Display, const N: usize>(rows: &[[T; N]]) -> String {
    let row = |row: &[T; N]| format!("({})", row.each_ref().map(ToString::to_string).join(", "));
    format!("[{}]", rows.iter().map(row).collect::<Vec<_>>().join(", "))
}
