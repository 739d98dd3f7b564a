//! Binary glTF 2.0 (`.glb`) of the pressed surface: one morph target per hold, with the pressure as
//! colour, and an animation that goes through them at one hold per second.

use palpate_tissue::output::OutputFolder;
use palpate_tissue::press::Hold;
use palpate_tissue::session::Session;
use serde_json::{Value, json};

use crate::error::Error;

/// Linear red, green and blue without pressure, and their difference at the largest pressure.
const SKIN: [f32; 3] = [0.85, 0.62, 0.55];
const PRESSED: [f32; 3] = [-0.45, -0.61, -0.52];
/// Constants of the format: component and target types, and the words of the container.
const FLOAT: u32 = 5126;
const INDEX: u32 = 5125;
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;
const MAGIC: &[u8; 4] = b"glTF";
const VERSION: u32 = 2;

/// Writes `press.glb`.
pub fn write(folder: &OutputFolder, session: &Session, holds: &[Hold]) -> Result<(), Error> {
    Ok(folder.write("press.glb", &document(session, holds))?)
}

/// The vertices are the nodes of the surface.
fn document(session: &Session, holds: &[Hold]) -> Vec<u8> {
    let model = session.patch.wide_model();
    let mut nodes: Vec<u16> = model.triangles.iter().flat_map(|t| t.node).collect();
    nodes.sort_unstable();
    nodes.dedup();
    let vertex = |node: u16| nodes.partition_point(|n| *n < node);
    let corners: Vec<[usize; 3]> = model.triangles.iter().map(|t| t.node.map(vertex)).collect();
    let rest: Vec<[f32; 3]> = nodes.iter().map(|n| in_gltf(model.nodes[usize::from(*n)].rest_m)).collect();
    let pressures: Vec<Vec<f32>> = holds.iter().map(|hold| at_vertices(&rest, &corners, &hold.pressure_pa)).collect();
    let peak_pa = pressures.iter().flatten().copied().fold(0.0, f32::max);

    let mut file = File::default();
    let times: Vec<[f32; 1]> = (0..holds.len() + 2).map(|k| [k as f32]).collect();
    // rest, each hold alone, and rest again
    let is = |k: usize, n: usize| [f32::from(u8::from(k == n + 1))];
    let weights: Vec<[f32; 1]> = (0..times.len()).flat_map(|k| (0..holds.len()).map(move |n| is(k, n))).collect();
    let attributes = |file: &mut File, positions: &[[f32; 3]], colours: &[[f32; 3]]| json!({ "POSITION": file.floats(positions, true), "COLOR_0": file.floats(colours, true) });
    let base = attributes(&mut file, &rest, &vec![SKIN; rest.len()]);
    let mut targets = Vec::new();
    for (hold, pressure) in holds.iter().zip(&pressures) {
        let moved: Vec<[f32; 3]> = nodes.iter().map(|n| in_gltf(hold.surface_displacement_m[usize::from(*n)].into())).collect();
        let share = |p: &f32| if peak_pa > 0.0 { p / peak_pa } else { 0.0 };
        let colours: Vec<[f32; 3]> = pressure.iter().map(|p| PRESSED.map(|c| c * share(p))).collect();
        targets.push(attributes(&mut file, &moved, &colours));
    }
    let indices = file.indices(&corners);
    let names: Vec<String> = holds.iter().map(|hold| format!("{:.2} mm", hold.depth_m * 1e3)).collect();
    let depths_m: Vec<f64> = holds.iter().map(|hold| hold.depth_m).collect();
    let forces_n: Vec<f64> = holds.iter().map(|hold| hold.force_n).collect();
    let mut scene = json!({
        "asset": { "version": "2.0", "generator": concat!("palpate ", env!("CARGO_PKG_VERSION")) },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "mesh": 0, "name": "tissue" }],
        "materials": [{ "pbrMetallicRoughness": { "metallicFactor": 0.0, "roughnessFactor": 0.6 } }],
        "meshes": [{
            "name": "tissue",
            "primitives": [{ "attributes": base, "indices": indices, "material": 0 }],
            "extras": { "targetNames": names, "depth_m": depths_m, "force_n": forces_n, "full_colour_pa": peak_pa },
        }],
    });
    // an empty list is not allowed in either place
    if !targets.is_empty() {
        scene["meshes"][0]["primitives"][0]["targets"] = targets.into();
        let (input, output) = (file.floats(&times, false), file.floats(&weights, false));
        scene["animations"] = json!([{
            "name": "press",
            "samplers": [{ "input": input, "output": output, "interpolation": "LINEAR" }],
            "channels": [{ "sampler": 0, "target": { "node": 0, "path": "weights" } }],
        }]);
    }
    file.finish(scene)
}

/// A vector of the scene in glTF's axes: x to the right, y up, z to the operator.
fn in_gltf([x, y, z]: [f32; 3]) -> [f32; 3] {
    [y, z, x]
}

/// Means of the pressures around each vertex, by area at rest.
fn at_vertices(rest: &[[f32; 3]], corners: &[[usize; 3]], pressure_pa: &[f32]) -> Vec<f32> {
    let mut sums = vec![(0.0_f32, 0.0_f32); rest.len()];
    for (corners, pressure_pa) in corners.iter().zip(pressure_pa) {
        let [a, b, c] = corners.map(|n| palpate::Vector3::from(rest[n]));
        let area = (b - a).cross(&(c - a)).norm();
        for n in corners {
            sums[*n].0 += area * pressure_pa;
            sums[*n].1 += area;
        }
    }
    sums.into_iter().map(|(sum, area)| if area > 0.0 { sum / area } else { 0.0 }).collect()
}

/// The binary part of a file, with its accessors.
#[derive(Default)]
struct File {
    bytes: Vec<u8>,
    views: Vec<Value>,
    accessors: Vec<Value>,
}

impl File {
    /// Adds rows of numbers; returns the accessor's number.
    fn floats<const N: usize>(&mut self, rows: &[[f32; N]], of_vertices: bool) -> usize {
        let ends = |pick: fn(f32, f32) -> f32, from: f32| -> Vec<f32> {
            (0..N).map(|k| rows.iter().map(|row| row[k]).fold(from, pick)).collect()
        };
        let kind = if N == 1 { "SCALAR" } else { "VEC3" };
        let range = [ends(f32::min, f32::INFINITY), ends(f32::max, f32::NEG_INFINITY)];
        let mut accessor = json!({ "componentType": FLOAT, "type": kind, "count": rows.len() });
        if !rows.is_empty() {
            (accessor["min"], accessor["max"]) = (json!(range[0]), json!(range[1]));
        }
        self.add(rows.iter().flatten().flat_map(|x| x.to_le_bytes()), accessor, of_vertices.then_some(VERTICES))
    }

    fn indices(&mut self, corners: &[[usize; 3]]) -> usize {
        let accessor = json!({ "componentType": INDEX, "type": "SCALAR", "count": 3 * corners.len() });
        self.add(corners.iter().flatten().flat_map(|n| (*n as u32).to_le_bytes()), accessor, Some(INDICES))
    }

    fn add(&mut self, bytes: impl Iterator<Item = u8>, mut accessor: Value, target: Option<u32>) -> usize {
        let start = self.bytes.len();
        self.bytes.extend(bytes);
        let mut view = json!({ "buffer": 0, "byteOffset": start, "byteLength": self.bytes.len() - start });
        if let Some(target) = target {
            view["target"] = target.into();
        }
        accessor["bufferView"] = self.views.len().into();
        self.views.push(view);
        self.accessors.push(accessor);
        self.accessors.len() - 1
    }

    /// The whole file, from the description of its scene.
    fn finish(self, mut scene: Value) -> Vec<u8> {
        scene["buffers"] = json!([{ "byteLength": self.bytes.len() }]);
        scene["bufferViews"] = self.views.into();
        scene["accessors"] = self.accessors.into();
        let mut text = scene.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut file = Vec::from(MAGIC);
        let length = |bytes: &[u8]| (bytes.len() as u32).to_le_bytes();
        // header, then a chunk of JSON and one of bytes, which are all floats and 32-bit numbers
        let total = 12 + 8 + text.len() + 8 + self.bytes.len();
        file.extend(VERSION.to_le_bytes());
        file.extend((total as u32).to_le_bytes());
        for (kind, chunk) in [(b"JSON", &text), (b"BIN\0", &self.bytes)] {
            file.extend(length(chunk));
            file.extend(kind);
            file.extend(chunk);
        }
        file
    }
}
