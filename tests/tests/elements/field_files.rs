//! Files of other programs, each with the body that independent readers find in it.

use std::path::PathBuf;

use palpate_tests::cube_mesh::cube;
use palpate_tests::press_run::{SMALL_BLOCK, edited};
use palpate_tests::surface_text::{Triangles, ball, cuboid};
use palpate_tissue::mesh::import::{MeshFile, open};
use palpate_tissue::scene::Scene;
use palpate_tissue::session::Session;
use palpate_tissue::session::coarse::missing_pct;

fn case(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data/field").join(name)
}

#[test]
fn every_file_holds_its_body() {
    // volume [cm^3], tets or triangles, number of notes
    for (name, volume_cm3, elements, notes) in [
        ("binary-vtk-with-a-blank-line/blank.vtk", 10.667, 1, 0),
        ("cavity-roof-is-fixed/hollow.stl", 106.612, 512, 0),
        ("closed-surface-as-vtk-polydata/surface.vtk", 10.667, 4, 0),
        ("concave-polygon-in-obj/l-prism.obj", 81.0, 20, 0),
        ("mixed-solids-lose-half-the-body/mixed.msh", 72.0, 648, 1),
        ("obj-lines-of-other-programs/comment.obj", 10.667, 4, 0),
        ("obj-lines-of-other-programs/continued.obj", 10.667, 4, 0),
        ("obj-lines-of-other-programs/faces-first.obj", 10.667, 4, 0),
        ("one-triangle-twice/twice.stl", 109.27, 320, 1),
        ("tet-in-two-physical-groups/two-groups.msh", 10.667, 1, 1),
        ("thin-body-nearest-has-0/two.stl", 20.0, 12, 0),
    ] {
        let (found_m3, found, found_notes) = match open(&case(name), 1e-3).unwrap() {
            MeshFile::Tets(imported) => (imported.report.volume_m3, imported.report.tets, imported.report.notes()),
            MeshFile::Surface(imported) => (imported.report.volume_m3, imported.report.triangles, imported.report.notes()),
        };
        assert!((found_m3 * 1e6 - volume_cm3).abs() < 1e-3, "{name}: {} cm^3", found_m3 * 1e6);
        assert_eq!((found, found_notes.len()), (elements, notes), "{name}: {found_notes:?}");
    }
}

fn prepared(name: &str) -> Result<Session, String> {
    let scene = Scene::load(case(name).to_str().unwrap()).unwrap();
    Session::prepare(&scene).map_err(|error| error.to_string())
}

#[test]
fn no_support_lies_on_the_roof_of_a_cavity() {
    let session = prepared("cavity-roof-is-fixed/hollow.toml").unwrap();
    let mesh = session.patch.mesh();
    for anchor in session.patch.wide_model().anchors {
        let [x, y, z] = mesh.nodes_m[usize::from(*anchor)];
        let off_mm = 1e3 * (x * x + y * y + (z + 0.015) * (z + 0.015)).sqrt();
        assert!(off_mm > 7.5 && z < -0.02, "a support {off_mm} mm from the middle of the cavity, {z} m high");
    }
    assert_eq!(palpate_tissue::mesh::surface::hollows(&mesh), Some(1));
    // two elements through the roof of 8 mm
    assert!(session.report.element_mm < 4.8, "{} mm", session.report.element_mm);
}

#[test]
fn a_pointed_place_keeps_its_point_and_gets_fine_elements() {
    let session = prepared("pointed-place-gets-coarse-elements/case.toml").unwrap();
    assert!(session.report.element_mm < 4.0, "{} mm", session.report.element_mm);
    let top_m = session.patch.mesh().nodes_m.iter().map(|x| x[2]).fold(f64::MIN, f64::max);
    assert!((top_m - 0.068).abs() < 1e-6, "{top_m}");
}

#[test]
fn what_no_mesh_can_hold_is_refused_with_what_works() {
    let coarse = prepared("coarse-organ-no-force/case.toml").unwrap_err();
    assert!(coarse.contains("has elements of 21.5 mm at the site") && coarse.contains("palpate fit --scene "), "{coarse}");
    let thin = prepared("thin-body-nearest-has-0/sheet.toml").unwrap_err();
    assert!(thin.contains("0.6 mm thick") && !thin.contains("nodes = "), "{thin}");
    let sheet = prepared("thin-body-nearest-has-0/two.toml").unwrap_err();
    let about = sheet.split("would take about ").nth(1).and_then(|rest| rest.split(' ').next());
    let nodes: f64 = about.and_then(|nodes| nodes.parse().ok()).unwrap_or_else(|| panic!("{sheet}"));
    // 100 x 100 x 2 mm in elements of 0.66 mm, two nodes in a cube of the lattice, growing to 1 mm
    assert!((4e4..1.4e5).contains(&nodes) && sheet.contains("2.0 mm thick"), "{sheet}");
}

/// A scene whose tissue is a file, pressed at `site_m`; the file is gone when the folder is.
fn scene_of((name, content): (&str, String), unit: &str, site_m: [f64; 3]) -> (Scene, tempfile::TempDir) {
    let dir = tempfile::tempdir().unwrap();
    std::fs::write(dir.path().join(name), content).unwrap();
    let source = format!("mesh = \"{name}\"\nlength_unit = \"{unit}\"");
    let scene = edited(SMALL_BLOCK, "block_m = [0.08, 0.08, 0.04]", &source);
    let scene = edited(&edited(&scene, "nodes = 129", ""), "position_m = [0.0, 0.0]", &format!("site = {site_m:?}"));
    std::fs::write(dir.path().join("a.toml"), scene).unwrap();
    (Scene::load(dir.path().join("a.toml").to_str().unwrap()).unwrap(), dir)
}

/// Prepares a press on a surface, at `site` in millimetres.
fn pressed(surface: &Triangles, site_mm: [f64; 3]) -> Result<Session, String> {
    let (scene, _dir) = scene_of(("a.obj", surface.obj()), "mm", site_mm.map(|x| x * 1e-3));
    Session::prepare(&scene).map_err(|error| error.to_string())
}

#[test]
fn coarse_tets_are_refused_or_say_how_soft_they_are() {
    let tets = |nodes| scene_of(("a.msh", cube(nodes, 0.06)), "m", [0.03, 0.03, 0.06]);
    let (scene, _dir) = tets(6);
    let coarse = Session::prepare(&scene).map(|_| ()).unwrap_err().to_string();
    for words in ["has elements of 12.9 mm at the site", "palpate fit --scene ", "at most 10.8 mm there"] {
        assert!(coarse.contains(words), "{coarse}");
    }
    let (scene, _dir) = tets(8);
    let session = Session::prepare(&scene).unwrap();
    let missing_pct = missing_pct(&scene, &session.patch).unwrap();
    assert!((20.0..25.0).contains(&missing_pct), "{missing_pct} % with elements of {} mm", session.report.element_mm);
}

#[test]
fn a_place_without_tissue_is_named_and_a_body_that_crosses_itself_is_filled() {
    // a hollow of 8 mm that touches the top of a block from below
    let mut hollow = ball(8.0, 2).moved([30.0, 30.0, 32.0]);
    hollow.triangles.iter_mut().for_each(|t| t.swap(0, 1));
    let mut block = cuboid([60.0, 60.0, 40.0]);
    // with a corner of the top at the place
    block.triangles.retain(|t| !t.iter().all(|n| block.corners_mm[*n][2] == 40.0));
    block.corners_mm.push([30.0, 30.0, 40.0]);
    block.triangles.extend([[4, 5, 8], [5, 7, 8], [7, 6, 8], [6, 4, 8]]);
    let touching = block.and(&hollow);
    let bare = pressed(&touching, [30.0, 30.0, 40.0]).map(|_| ()).unwrap_err();
    assert!(bare.contains("probe.site") && bare.contains("a hollow, or another side, touches the surface"), "{bare}");
    // beside the place, a corner is drawn far through the triangles around it
    let mut crossed = ball(30.0, 5);
    let from_mm = |at: &[f64; 3]| (at[0] - 10.0).powi(2) + at[1].powi(2) + (at[2] - 28.0).powi(2);
    let mut order: Vec<usize> = (0..crossed.corners_mm.len()).collect();
    order.sort_by(|a, b| from_mm(&crossed.corners_mm[*a]).total_cmp(&from_mm(&crossed.corners_mm[*b])));
    let (at, beside) = (crossed.corners_mm[order[0]], crossed.corners_mm[order[6]]);
    crossed.corners_mm[order[0]] = [0, 1, 2].map(|k| at[k] + 3.0 * (beside[k] - at[k]));
    let session = pressed(&crossed, [0.0, 0.0, 30.0]).unwrap();
    assert!(
        session.report.notes.iter().any(|note| note.contains("triangles cross, the first near (")),
        "{:?}",
        session.report.notes
    );
}

#[test]
fn a_mesh_far_from_the_origin_is_refused_with_the_way_back() {
    let text = std::fs::read_to_string(case("obj-lines-of-other-programs/comment.obj")).unwrap();
    let far = text.replace("v 0 0 0", "v 0 0 20000").replace("v 40 0 0", "v 40 0 20000").replace("v 0 40 0", "v 0 40 20000");
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("far.obj");
    std::fs::write(&path, far.replace("v 0 0 40", "v 0 0 20040")).unwrap();
    let refusal = open(&path, 1e-3).map(|_| ()).unwrap_err().to_string();
    assert!(
        refusal.contains("lies up to 20 m from the origin") && refusal.contains("move it by (-20, -20, -20020)"),
        "{refusal}"
    );
}
