//! Surfaces in STL and OBJ files: read, closed, refused with the reason, and filled with tets.

use palpate_tests::surface_text::{Triangles, ball, cuboid, projective_plane};
use palpate_tissue::mesh::import::{MIN_QUALITY, MeshFile, import, open};
use palpate_tissue::mesh::{ImportedSurface, MeshError, TetMesh, surface, worst};
use palpate_tissue::organ::even_mesh;
use proptest::prelude::*;

use crate::mesh_import::damage::{apply, damage};

type V3 = nalgebra::Vector3<f64>;

/// Opens a file in millimetres.
fn open_bytes(name: &str, content: &[u8]) -> Result<MeshFile, MeshError> {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join(name);
    std::fs::write(&path, content).unwrap();
    open(&path, 1e-3)
}

#[track_caller]
fn read(name: &str, content: &[u8]) -> ImportedSurface {
    match open_bytes(name, content) {
        Ok(MeshFile::Surface(surface)) => surface,
        other => panic!("{other:?}"),
    }
}

#[track_caller]
fn refusal(surface: &Triangles) -> String {
    open_bytes("a.obj", surface.obj().as_bytes()).map(|_| ()).unwrap_err().defect.to_string()
}

fn filled(surface: &ImportedSurface, spacing_m: f64) -> TetMesh {
    even_mesh("a", &|x| surface.surface.foot(x).distance_m, surface.surface.bounds_m(), spacing_m).unwrap()
}

/// Smallest and largest dihedral angle of all tets [degrees].
fn dihedral_angles(mesh: &TetMesh) -> [f64; 2] {
    let (mut least, mut most) = (180.0_f64, 0.0_f64);
    for tet in &mesh.tets {
        let corner = |n: usize| V3::from(mesh.nodes_m[tet[n % 4] as usize]);
        for (i, j, k, l) in [(0, 1, 2, 3), (0, 2, 1, 3), (0, 3, 1, 2), (1, 2, 0, 3), (1, 3, 0, 2), (2, 3, 0, 1)] {
            let along = corner(j) - corner(i);
            let [a, b] = [k, l].map(|n| along.cross(&(corner(n) - corner(i))));
            let angle = a.angle(&b).to_degrees();
            (least, most) = (least.min(angle), most.max(angle));
        }
    }
    [least, most]
}

#[test]
fn every_format_gives_the_same_surface() {
    let ball = ball(30.0, 3);
    let obj = read("a.obj", ball.obj().as_bytes());
    // the triangles of the refined octahedron, and the corners that follow by Euler's formula
    assert_eq!((obj.report.triangles, obj.report.vertices), (512, 258));
    assert_eq!((obj.report.turned_triangles, obj.report.left_out, obj.report.hollows), (0, 0, 0));
    assert!((obj.report.volume_m3 * 1e9 / ball.volume_mm3() - 1.0).abs() < 1e-12);
    // the format is recognised by the content, not by the name
    for (name, content) in
        [("a.stl", ball.stl().into()), ("b.stl", ball.binary_stl()), ("c", ball.obj().into()), ("d", ball.stl().into())]
    {
        let other = read(name, &content);
        assert_eq!((other.report.triangles, other.report.vertices), (512, 258), "{name}");
        for n in 0..400 {
            let wave = |k: f64| 0.035 * (f64::from(n) * k).sin();
            let at = [wave(1.3), wave(2.1), wave(0.7)];
            let [own, expected] = [&other, &obj].map(|s| s.surface.foot(at).distance_m);
            // half of the last of seven digits, in three coordinates
            assert!((own - expected).abs() < 9e-9, "{name}: {own} {expected}");
        }
    }
}

#[test]
fn a_ball_is_filled_to_its_volume_with_sound_tets() {
    let radius_m = 0.03;
    let facets = ball(30.0, 5);
    let imported = read("a.stl", &facets.binary_stl());
    let height_mm = |t: &[usize; 3]| {
        let [a, b, c] = t.map(|n| V3::from(facets.corners_mm[n]));
        (b - a).cross(&(c - a)).normalize().dot(&a)
    };
    let inner_m = 1e-3 * facets.triangles.iter().map(height_mm).fold(f64::INFINITY, f64::min);
    let exact_m3 = 4.0 / 3.0 * std::f64::consts::PI * f64::powi(radius_m, 3);
    let off = |spacing_m: f64| {
        let mesh = filled(&imported, spacing_m);
        for n in surface::surface(&mesh.tets).into_iter().flatten() {
            let off_m = V3::from(mesh.nodes_m[n as usize]).norm() - radius_m;
            // between the inscribed and the circumscribed sphere of the facets, to single precision
            assert!((inner_m - radius_m - 1e-8..1e-8).contains(&off_m), "{off_m}");
        }
        let [least, most] = dihedral_angles(&mesh);
        // the bounds that Labelle and Shewchuk prove
        assert!(least > 10.7 && most < 164.8, "{least} {most}");
        let volume_m3 = mesh.volume_m3();
        [1.0 - volume_m3 / exact_m3, 1.0 - volume_m3 / imported.report.volume_m3]
    };
    let ([_, coarse], [of_sphere, fine]) = (off(0.006), off(0.003));
    assert!((0.0..0.005).contains(&of_sphere), "{of_sphere}");
    // chords cut off a volume proportional to the square of their length
    assert!((3.0..5.0).contains(&(coarse / fine)), "{coarse} {fine}");
}

#[test]
fn a_box_loses_only_its_edges() {
    let imported = read("a.obj", cuboid([80.0, 60.0, 40.0]).obj().as_bytes());
    assert!((imported.report.volume_m3 - 192e-6).abs() < 1e-15);
    let mesh = filled(&imported, 0.0049);
    let [least, most] = dihedral_angles(&mesh);
    assert!(least > 10.7 && most < 164.8, "{least} {most}");
    assert!(worst(&mesh).unwrap().quality > MIN_QUALITY);
    // a chamfer of one spacing would remove half of its square along 720 mm of edges
    let lost_m3 = 192e-6 - mesh.volume_m3();
    assert!((0.0..0.5 * 0.0049 * 0.0049 * 0.72).contains(&lost_m3), "{lost_m3}");
}

#[test]
fn triangles_that_face_inward_are_turned_and_counted() {
    let sound = ball(30.0, 2);
    let volume_m3 = read("a.obj", sound.obj().as_bytes()).report.volume_m3;
    let turned = |which: &dyn Fn(usize) -> bool| {
        let mut surface = sound.clone();
        surface.triangles.iter_mut().enumerate().filter(|(n, _)| which(*n)).for_each(|(_, t)| t.swap(0, 1));
        read("a.obj", surface.obj().as_bytes())
    };
    for (which, count) in [(&(|n: usize| n.is_multiple_of(3)) as &dyn Fn(usize) -> bool, 43), (&|_| true, 128)] {
        let imported = turned(which);
        assert_eq!(imported.report.turned_triangles, count);
        assert!((imported.report.volume_m3 / volume_m3 - 1.0).abs() < 1e-12);
        assert!(imported.surface.foot([0.0; 3]).distance_m < 0.0);
    }
}

#[test]
fn a_surface_inside_is_a_hollow_if_it_faces_inward_and_else_a_label() {
    let turned = |mut surface: Triangles| {
        surface.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        surface
    };
    let (outer, inner) = (ball(30.0, 2), ball(15.0, 2));
    let hollow = outer.volume_mm3() - inner.volume_mm3();
    // what is inside out as a whole is turned as a whole
    for (file, hollows, labels, volume_mm3) in [
        (outer.clone().and(&turned(inner.clone())), 1, 0, hollow),
        (turned(outer.clone()).and(&inner), 1, 0, hollow),
        (outer.clone().and(&inner), 0, 1, outer.volume_mm3()),
        (turned(outer.clone().and(&inner)), 0, 1, outer.volume_mm3()),
    ] {
        let imported = read("a.obj", file.obj().as_bytes());
        assert_eq!((imported.report.hollows, imported.report.labels, imported.surface.hollows()), (hollows, labels, hollows));
        assert_eq!((imported.report.label_triangles, imported.report.notes().len()), (128 * labels, labels));
        assert!((imported.report.volume_m3 * 1e9 / volume_mm3 - 1.0).abs() < 1e-12);
        let at_centre = imported.surface.foot([0.0; 3]).distance_m;
        assert_eq!(at_centre > 0.0, hollows == 1);
        assert!(imported.surface.foot([0.02, 0.0, 0.0]).distance_m < 0.0);
    }
}

#[test]
fn a_sheet_that_stands_out_and_copies_are_left_out() {
    let sound = || ball(30.0, 2);
    let mut fin = sound();
    fin.corners_mm.push([0.0, 0.0, 90.0]);
    let [a, b, _] = fin.triangles[0];
    fin.triangles.extend([[a, b, 66], [b, a, 66]]);
    let mut twice = sound();
    twice.triangles.extend(sound().triangles);
    for (file, copies) in [(fin, 2), (twice, 128)] {
        let report = read("a.obj", file.obj().as_bytes()).report;
        assert_eq!((report.triangles, report.copies), (128, copies));
        assert!((report.volume_m3 * 1e9 / sound().volume_mm3() - 1.0).abs() < 1e-12);
    }
}

#[test]
fn parts_that_touch_in_an_edge_or_a_corner_stay_what_they_are() {
    // two hollows that meet in a corner; two boxes that meet in an edge or a corner
    let outer = || cuboid([40.0; 3]);
    let inner = |at: [f64; 3]| {
        let mut inner = cuboid([10.0; 3]).moved(at);
        inner.triangles.iter_mut().for_each(|t| t.swap(0, 1));
        inner
    };
    let imported = read("a.obj", outer().and(&inner([10.0; 3])).and(&inner([20.0; 3])).obj().as_bytes());
    assert_eq!((imported.report.hollows, imported.surface.hollows()), (2, 2));
    assert!((imported.report.volume_m3 * 1e9 - 62_000.0).abs() < 1e-6);
    for at in [[40.0, 40.0, 0.0], [40.0; 3]] {
        assert!(refusal(&outer().and(&outer().moved(at))).starts_with("2 separate closed surfaces"), "{at:?}");
    }
}

#[test]
fn few_crossing_triangles_are_named_and_filled_by_distance() {
    let mut dented = ball(30.0, 4);
    // one corner is pushed through its neighbours
    let at = dented.corners_mm[300];
    dented.corners_mm[300] = [0, 1, 2].map(|k| at[k] + 3.5 * (dented.corners_mm[301][k] - at[k]));
    let report = read("a.obj", dented.obj().as_bytes()).report;
    let (pairs, _) = report.crossings.clone().expect("triangles that cross");
    assert!(pairs > 0 && report.notes()[0].contains("cross, the first near ("), "{:?}", report.notes());
}

#[test]
fn corners_that_rounding_parted_are_joined_again() {
    let mut text = String::new();
    for (n, line) in ball(30.0, 2).stl().lines().enumerate() {
        // changes the last digit of some corners
        let shaken = if n.is_multiple_of(5) { line.replacen("1e1", "2e1", 1) } else { line.to_owned() };
        text.push_str(if line.contains("vertex") { &shaken } else { line });
        text.push('\n');
    }
    let imported = read("a.stl", text.as_bytes());
    assert_eq!((imported.report.triangles, imported.report.vertices), (128, 66));
}

#[test]
fn what_is_no_closed_body_is_refused_with_its_place() {
    let sound = || ball(30.0, 2);
    let mut open = sound();
    open.triangles.truncate(126);
    assert!(
        refusal(&open).starts_with("the surface is open: 4 edges belong to one triangle only, the first at ("),
        "{}",
        refusal(&open)
    );
    // an octahedron with a wall across its middle
    let mut wall = ball(30.0, 0);
    wall.triangles.extend([[0, 2, 1], [0, 1, 3]]);
    assert!(refusal(&wall).starts_with("4 edges belong to more than two triangles"), "{}", refusal(&wall));
    assert!(refusal(&sound().and(&sound().moved([100.0, 0.0, 0.0]))).starts_with("2 separate closed surfaces"));
    let crossed = sound().and(&sound().moved([30.0, 0.0, 0.0]));
    assert!(
        ["the surface passes through itself", "2 separate closed surfaces"]
            .iter()
            .any(|says| refusal(&crossed).starts_with(says))
    );
    // a dent that passes through the opposite side
    let mut pierced = sound();
    pierced.corners_mm[4][2] = -40.0;
    assert!(refusal(&pierced).starts_with("the surface passes through itself"), "{}", refusal(&pierced));
    assert!(refusal(&projective_plane()).starts_with("the surface has one side only"), "{}", refusal(&projective_plane()));
    let none = Triangles { corners_mm: sound().corners_mm, triangles: Vec::new() };
    assert!(refusal(&none).starts_with("no triangles"), "{}", refusal(&none));
}

#[test]
fn blocks_that_share_a_wall_are_two_bodies_whatever_the_diagonals_of_the_wall() {
    let left = || cuboid([30.0, 60.0, 40.0]);
    let mut right = left().moved([30.0, 0.0, 0.0]);
    let alike = refusal(&left().and(&right));
    assert!(alike.contains("edges belong to more than two triangles") && alike.contains("part the walls"), "{alike}");
    // the wall of the right block, by the other diagonal
    right.triangles.retain(|t| !t.iter().all(|n| right.corners_mm[*n][0] == 30.0));
    right.triangles.extend([[0, 4, 2], [2, 4, 6]]);
    assert!((right.volume_mm3() - left().volume_mm3()).abs() < 1e-6);
    // written triangle by triangle, so that the corners are joined
    let text = left().and(&right).stl();
    let other = open_bytes("a.stl", text.as_bytes()).map(|_| ()).unwrap_err().defect.to_string();
    assert!(other.starts_with("2 separate closed surfaces") && other.contains("unite those that touch"), "{other}");
}

#[test]
fn corners_of_left_out_triangles_add_nothing_to_the_size() {
    // a block, and a triangle that stands out from it, once for each of its sides
    let mut fin = cuboid([60.0, 60.0, 40.0]);
    fin.corners_mm.extend([[70.0, 60.0, 40.0], [60.0, 60.0, 55.0]]);
    fin.triangles.extend([[7, 8, 9], [7, 9, 8]]);
    let report = read("a.obj", fin.obj().as_bytes()).report;
    assert_eq!((report.copies, report.vertices, report.triangles), (2, 8, 12));
    assert!(report.size_m.iter().zip([0.06, 0.06, 0.04]).all(|(is, right)| (is - right).abs() < 1e-12), "{:?}", report.size_m);
}

#[test]
fn what_is_no_mesh_is_named_with_what_to_do() {
    let utf_16: Vec<u8> = [0xff, 0xfe].into_iter().chain("solid x\nfacet".encode_utf16().flat_map(u16::to_le_bytes)).collect();
    let mut counted = ball(30.0, 1).binary_stl();
    counted[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
    for (name, content, says, advises) in [
        ("a.stl", &b"version https://git-lfs.github.com/spec/v1\noid sha256:abc\nsize 9\n"[..], "Git LFS", "git lfs pull"),
        ("a.stl", b"<!DOCTYPE html><html>404</html>", "a web page", "download"),
        ("a.vtu", b"<html><body>sign in</body></html>", "a web page", "download"),
        ("a.stl", &utf_16, "UTF-16", "save it as UTF-8"),
        ("a.nas", b"$ Nastran\nBEGIN BULK\nGRID,1,,0.,0.,0.\n", "Nastran", "export as Gmsh"),
        ("a.bdf", b"$$ made by hand\nBEGIN BULK\n", "Nastran", "export as Gmsh"),
        ("a.stl", &counted, "announces 4294967295 triangles but holds 32", "re-export"),
    ] {
        let refusal = open_bytes(name, content).map(|_| ()).unwrap_err().to_string();
        assert!(refusal.contains(says) && refusal.contains(advises), "{refusal}");
    }
    let voxel = "# vtk DataFile Version 3.0\nt\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS 8 float\n0 0 0\n30 0 0\n0 30 0\n30 30 0\n0 0 30\n30 0 30\n0 30 30\n30 30 30\nCELLS 1 9\n8 0 1 2 3 4 5 6 7\nCELL_TYPES 1\n12\n";
    let folded = open_bytes("a.vtk", voxel.as_bytes()).map(|_| ()).unwrap_err().defect.to_string();
    assert!(folded.starts_with("element 0 is folded over itself") && folded.contains("voxel (type 11)"), "{folded}");
    assert!(open_bytes("a.vtk", voxel.replace("\n12\n", "\n11\n").as_bytes()).is_ok());
}

#[test]
fn a_surface_where_tets_are_wanted_is_told_apart() {
    let dir = tempfile::tempdir().unwrap();
    let path = dir.path().join("a.stl");
    std::fs::write(&path, ball(30.0, 2).binary_stl()).unwrap();
    assert!(import(&path, 1e-3).unwrap_err().defect.to_string().starts_with("a surface (binary STL), not tets"));
    let mut huge = ball(30.0, 2).binary_stl();
    huge[80..84].copy_from_slice(&i32::MAX.to_le_bytes());
    let error = open_bytes("a.stl", &huge).map(|_| ()).unwrap_err();
    // with a header that begins like a text file and a length that fits no binary file, it is read
    // as text
    assert!(error.to_string().len() < 500, "{error}");
    huge[..5].copy_from_slice(b"other");
    let error = open_bytes("a.stl", &huge).map(|_| ()).unwrap_err().defect.to_string();
    assert_eq!(error, "the STL file announces 2147483647 triangles but holds 128: re-export the mesh");
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, cases: 100, ..ProptestConfig::default() })]

    #[test]
    fn a_damaged_surface_is_refused_in_one_line_or_sound(damages in prop::collection::vec(damage(), 1..4)) {
        let sound = ball(30.0, 1);
        for (name, content) in [("a.stl", sound.binary_stl()), ("b.stl", sound.stl().into()), ("c.obj", sound.obj().into()), ("d.ply", sound.ply().into())] {
            let mut bytes = content;
            for damage in &damages {
                apply(&mut bytes, damage);
            }
            match open_bytes(name, &bytes) {
                Err(error) => {
                    let line = error.to_string();
                    prop_assert!(!line.contains(['\n', '\r']) && line.contains(": ") && line.len() < 500, "{:?}", line);
                }
                Ok(MeshFile::Surface(found)) => {
                    let far = found.surface.foot([1.0, 1.0, 1.0]).distance_m;
                    prop_assert!(found.report.volume_m3 >= 0.0 && far > 0.0, "{:?}", found.report);
                }
                Ok(MeshFile::Tets(_)) => prop_assert!(false, "tets"),
            }
        }
    }
}
