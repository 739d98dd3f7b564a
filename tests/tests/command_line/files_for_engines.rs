//! `press --gltf --usd` writes what engines load, and it agrees with the tables.

use palpate_tests::palpate_command::{Desk, palpate};
use palpate_tests::press_run::{PressRun, SMALL_BLOCK, press_at};
use palpate_tissue::mesh::import::import;
use serde_json::Value;

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");

/// A binary glTF file: its description and its bytes.
struct Glb {
    scene: Value,
    bytes: Vec<u8>,
}

impl Glb {
    fn of(file: &[u8]) -> Self {
        let word = |at: usize| u32::from_le_bytes(file[at..at + 4].try_into().unwrap()) as usize;
        assert_eq!((&file[..4], word(4), word(8)), (&b"glTF"[..], 2, file.len()));
        let text = word(12);
        assert_eq!((&file[16..20], &file[24 + text..28 + text], text % 4), (&b"JSON"[..], &b"BIN\0"[..], 0));
        let (scene, bytes) = (serde_json::from_slice(&file[20..20 + text]).unwrap(), file[28 + text..].to_vec());
        assert_eq!(word(20 + text), bytes.len());
        Self { scene, bytes }
    }

    fn number(&self, pointer: &str) -> usize {
        let value = self.scene.pointer(pointer).unwrap_or_else(|| panic!("{pointer}: {}", self.scene));
        usize::try_from(value.as_u64().unwrap()).unwrap()
    }

    /// Words of an accessor, which ends where its view ends.
    fn words(&self, accessor: usize) -> Vec<[u8; 4]> {
        let of = |key: &str| self.number(&format!("/accessors/{accessor}/{key}"));
        let view = |key: &str| self.number(&format!("/bufferViews/{}/{key}", of("bufferView")));
        let wide = if self.scene["accessors"][accessor]["type"] == "VEC3" { 3 } else { 1 };
        assert_eq!(view("byteLength"), 4 * wide * of("count"));
        self.bytes[view("byteOffset")..][..view("byteLength")].chunks(4).map(|word| word.try_into().unwrap()).collect()
    }

    fn vectors(&self, pointer: &str) -> Vec<[f32; 3]> {
        let accessor = self.number(pointer);
        let floats: Vec<f32> = self.words(accessor).into_iter().map(f32::from_le_bytes).collect();
        let rows: Vec<[f32; 3]> = floats.chunks(3).map(|row| row.try_into().unwrap()).collect();
        for k in 0..3 {
            let end = |name: &str| self.scene["accessors"][accessor][name][k].as_f64().unwrap() as f32;
            let column = rows.iter().map(|row| row[k]);
            assert_eq!(end("min"), column.clone().fold(f32::INFINITY, f32::min), "{pointer}");
            assert_eq!(end("max"), column.fold(f32::NEG_INFINITY, f32::max), "{pointer}");
        }
        rows
    }
}

/// Whether a row of a surface table, rest and displacement in the scene's axes, is among those in
/// glTF's: x to the right, y up, z to the operator.
fn has(rest: &[[f32; 3]], moved: &[[f32; 3]], row: &[f64]) -> bool {
    let turned = |v: &[f64]| [v[1] as f32, v[2] as f32, v[0] as f32];
    rest.iter().zip(moved).any(|(x, u)| *x == turned(&row[..3]) && *u == turned(&row[3..6]))
}

fn pressed() -> PressRun {
    press_at(SCRATCH, Desk::default(), SMALL_BLOCK, &["--gltf", "--usd", "--vtu"])
}

#[test]
fn gltf_has_a_morph_target_and_a_colour_for_each_hold() {
    let run = pressed();
    let glb = Glb::of(&std::fs::read(run.out.join("press.glb")).unwrap());
    let primitive = "/meshes/0/primitives/0";
    let rest = glb.vectors(&format!("{primitive}/attributes/POSITION"));
    let skin = glb.vectors(&format!("{primitive}/attributes/COLOR_0"));
    let corners = glb.words(glb.number(&format!("{primitive}/indices"))).into_iter().map(u32::from_le_bytes);
    let corners: Vec<[f32; 3]> = corners.map(|n| rest[n as usize]).collect();
    assert_eq!((rest.len(), corners.len()), (skin.len(), 3 * run.number("/report/triangles") as usize));
    // triangles face outward in glTF's axes, which are right-handed
    let corner = |x: [f32; 3]| palpate::Vector3::from(x);
    let six: f32 = corners.chunks(3).map(|t| corner(t[0]).cross(&corner(t[1])).dot(&corner(t[2]))).sum();
    assert!(six > 0.0, "{six}");

    let (mut reddest, holds) = (1.0_f32, run.holds());
    for (k, hold) in holds.iter().enumerate() {
        let target = format!("{primitive}/targets/{k}");
        let (moved, coloured) = (glb.vectors(&format!("{target}/POSITION")), glb.vectors(&format!("{target}/COLOR_0")));
        assert!(run.surface(k).rows.iter().all(|row| has(&rest, &moved, row)), "hold {k}");
        let lowest = (0..rest.len()).min_by(|a, b| moved[*a][1].total_cmp(&moved[*b][1])).unwrap();
        // pressure only near the tip, whose radius is 8 mm, and nothing is brighter than the skin
        for (x, c) in rest.iter().zip(&coloured) {
            assert!(c.iter().all(|c| *c <= 0.0) && (c[1] == 0.0 || x[0].hypot(x[2]) < 0.02), "{x:?} {c:?}");
        }
        let green = skin[lowest][1] + coloured[lowest][1];
        assert!(green < reddest && green >= 0.0, "deeper is redder: {green} after {reddest} at {}", hold.depth_m);
        reddest = green;
        assert_eq!(glb.scene["meshes"][0]["extras"]["depth_m"][k].as_f64().unwrap() as f32, hold.depth_m as f32);
    }
    let (times, weights) = ("/animations/0/samplers/0/input", "/animations/0/samplers/0/output");
    let floats = |at| glb.words(glb.number(at)).into_iter().map(f32::from_le_bytes).collect::<Vec<_>>();
    assert_eq!(floats(times), [0.0, 1.0, 2.0, 3.0, 4.0]);
    let single = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [0.0, 0.0, 0.0]];
    assert_eq!(floats(weights), single.concat());
}

#[test]
fn usd_is_read_again_and_has_a_sample_for_each_hold() {
    let run = pressed();
    let usd = run.out.join("press.usda");
    let text = std::fs::read_to_string(&usd).unwrap();
    let imported = import(&usd, 1.0).unwrap();
    let (nodes, tets) = (run.number("/nodes") as usize, run.number("/tets") as usize);
    assert_eq!((imported.mesh.nodes_m.len(), imported.mesh.tets.len(), imported.report.flipped_tets), (nodes, tets, 0));
    // samples: rest, then the end of each hold
    let samples: Vec<&str> = text.lines().filter(|line| line.starts_with("        ")).collect();
    assert_eq!(samples.len(), 4);
    for (k, sample) in samples.iter().skip(1).enumerate() {
        let numbers: Vec<f32> = sample.split([':', '[', ']', '(', ')', ',', ' ']).filter_map(|word| word.parse().ok()).collect();
        let vtu = std::fs::read_to_string(run.out.join(format!("press_{k}.vtu"))).unwrap();
        let points = vtu.split_once("Name=\"points\"").unwrap().1.split_once("</").unwrap().0;
        let points: Vec<f32> = points.split_whitespace().filter_map(|word| word.parse().ok()).collect();
        assert_eq!((numbers[0], numbers.len(), points.len()), (k as f32 + 1.0, 1 + 3 * nodes, 3 * nodes));
        let off_m = numbers[1..].iter().zip(&points).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        assert!(off_m < 1e-8, "hold {k}: {off_m} m");
    }

    let desk = Desk::default();
    let path = desk.folder().join("press.usda");
    std::fs::copy(&usd, &path).unwrap();
    let said = palpate(SCRATCH, desk.folder(), &["mesh", "check", "press.usda"]);
    assert!(said.stdout.contains("USD text") && said.stdout.contains(&format!("{tets} tets")), "{said:?}");
}
