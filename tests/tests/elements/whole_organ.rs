//! A whole organ remeshed around a site keeps its shape, is fine where required, and gives the same
//! forces as an independent mesh.

use std::fmt::Write;

use nalgebra::Vector3;
use palpate_fit::far_field::Sizes;
use palpate_fit::far_field::organ_reference::organ_reference;
use palpate_fit::far_field::whole::{distance_m, whole};
use palpate_fit::scene_fit::element_for;
use palpate_tests::palpate_command::Desk;
use palpate_tests::press_run::{SMALL_BLOCK, edited};
use palpate_tests::surface_text::cuboid;
use palpate_tissue::answer::Answer;
use palpate_tissue::mesh::surface::{edges, pieces, surface};
use palpate_tissue::mesh::{BlockSpec, TetMesh, block};
use palpate_tissue::organ::Organ;
use palpate_tissue::scene::Scene;
use palpate_tissue::tissue::Placed;

type V3 = Vector3<f64>;

const SMALL: Sizes = Sizes { radius_m: 0.017, fine_m: 0.0046, fine_radius_m: 0.008, growth: 0.45 };
const SIDES_M: [f64; 3] = [0.08, 0.08, 0.04];

fn msh(mesh: &TetMesh) -> String {
    let mut text = format!("$NOD\n{}\n", mesh.nodes_m.len());
    for (n, [x, y, z]) in mesh.nodes_m.iter().enumerate() {
        writeln!(text, "{} {x} {y} {z}", n + 1).unwrap();
    }
    writeln!(text, "$ENDNOD\n$ELM\n{}", mesh.tets.len()).unwrap();
    for (t, [a, b, c, d]) in mesh.tets.iter().enumerate() {
        writeln!(text, "{} 4 1 1 4 {} {} {} {}", t + 1, a + 1, b + 1, c + 1, d + 1).unwrap();
    }
    text + "$ENDELM\n"
}

/// A scene with tissue from `source`, pressed at a site.
fn scene_of(desk: &Desk, source: &str, site: [f64; 3]) -> Scene {
    let scene = edited(SMALL_BLOCK, "block_m = [0.08, 0.08, 0.04]", source);
    let scene = edited(&edited(&scene, "nodes = 129", ""), "position_m = [0.0, 0.0]", &format!("site = {site:?}"));
    desk.put("scene.toml", scene);
    Scene::load(desk.folder().join("scene.toml").to_str().unwrap()).unwrap()
}

/// A scene of the standard block, read from a mesh file.
fn block_file(desk: &Desk, site: [f64; 3]) -> Scene {
    let mesh = block(&BlockSpec { size_m: SIDES_M, nodes: 300, fine_at_m: [0.0; 2], fine_radius_m: 0.01 }).unwrap();
    desk.put("block.msh", msh(&mesh));
    scene_of(desk, "mesh = \"block.msh\"\nlength_unit = \"m\"", site)
}

/// Distance to the block's surface, by a formula [m].
fn from_block_m(x: &[f64; 3]) -> f64 {
    let half = 0.5 * V3::from(SIDES_M);
    let q = (V3::from(*x) + V3::new(0.0, 0.0, half.z)).abs() - half;
    q.map(|c| c.max(0.0)).norm() + q.max().min(0.0)
}

fn volumes_m3(mesh: &TetMesh) -> Vec<f64> {
    let six = |t: &[u32; 4]| {
        let [a, b, c, d] = t.map(|n| V3::from(mesh.nodes_m[n as usize]));
        (b - a).cross(&(c - a)).dot(&(d - a))
    };
    mesh.tets.iter().map(|t| six(t) / 6.0).collect()
}

fn surface_nodes(mesh: &TetMesh) -> Vec<u32> {
    let mut nodes: Vec<u32> = surface(&mesh.tets).into_iter().flatten().collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

/// Mean distance of the facets within `reach_m` of the site from an organ's surface [m], negative
/// inside, and that of the facets whose corners are on the surface.
fn facets_off_m(placed: &Placed, organ: &Organ, reach_m: f64) -> (f64, f64) {
    let mesh = &placed.tissue.mesh;
    let own = |n: u32| V3::from(mesh.nodes_m[n as usize]);
    let near = |t: &[u32; 3]| (t.map(own).iter().sum::<V3>() / 3.0 - V3::from(placed.tissue.site_m)).norm() < reach_m;
    let mean_m = |place: &dyn Fn(u32) -> V3| {
        let of = |t: [u32; 3]| {
            let [a, b, c] = t.map(place);
            // exact to degree 2
            let middles = [(a + b) * 0.5, (b + c) * 0.5, (c + a) * 0.5];
            let distance_m = middles.iter().map(|x| organ.near_m((*x).into()).0).sum::<f64>() / 3.0;
            let area_m2 = (b - a).cross(&(c - a)).norm();
            (area_m2 * distance_m, area_m2)
        };
        let facets = surface(&mesh.tets).into_iter().filter(near).map(of);
        let (sum_m3, area_m2) = facets.fold((0.0, 0.0), |all, own| (all.0 + own.0, all.1 + own.1));
        sum_m3 / area_m2
    };
    (mean_m(&own), mean_m(&|n| organ.nearest_m(own(n).into()).into()))
}

/// Number of nodes of the tets whose centroids are in the patch.
fn patch_nodes(placed: &Placed, sizes: &Sizes) -> usize {
    let mesh = &placed.tissue.mesh;
    let middle = |t: &&[u32; 4]| [0, 1, 2].map(|k| t.iter().map(|n| mesh.nodes_m[*n as usize][k]).sum::<f64>() / 4.0);
    let inside = |t: &&[u32; 4]| distance_m(placed.tissue.site_m, middle(t)) <= sizes.radius_m;
    let mut nodes: Vec<u32> = mesh.tets.iter().filter(inside).flatten().copied().collect();
    nodes.sort_unstable();
    nodes.dedup();
    nodes.len()
}

/// Mean length of the edges within `reach_m` of the site [m].
fn mean_edge_m(placed: &Placed, reach_m: f64) -> f64 {
    let mesh = &placed.tissue.mesh;
    let near = |n: u32| distance_m(placed.tissue.site_m, mesh.nodes_m[n as usize]) <= reach_m;
    let place = |n: u32| V3::from(mesh.nodes_m[n as usize]);
    let lengths: Vec<f64> =
        edges(&mesh.tets).into_iter().filter(|[i, j]| near(*i) && near(*j)).map(|[i, j]| (place(i) - place(j)).norm()).collect();
    assert!(lengths.len() > 20, "{}", lengths.len());
    lengths.iter().sum::<f64>() / lengths.len() as f64
}

#[track_caller]
fn sound(placed: &Placed) {
    let mesh = &placed.tissue.mesh;
    assert!(volumes_m3(mesh).iter().all(|v| *v > 0.0));
    assert_eq!(pieces(&mesh.tets), 1);
    let site = V3::from(placed.tissue.site_m);
    assert!(mesh.nodes_m.iter().any(|x| (V3::from(*x) - site).norm() < 1e-9), "no node at the site");
    assert!(!placed.tissue.anchors.is_empty() && placed.tissue.anchors.len() < mesh.nodes_m.len() / 2);
}

#[test]
fn a_block_from_a_file_keeps_its_shape_and_is_fine_at_the_site() {
    let desk = Desk::default();
    let placed = whole(&block_file(&desk, [0.004, -0.003, 0.001]), &[], &SMALL).unwrap();
    sound(&placed);
    let mesh = &placed.tissue.mesh;
    assert_eq!(placed.axis, [0.0, 0.0, 1.0]);
    assert!(placed.import.as_ref().is_some_and(|i| i.nodes == 300));
    let off_m = surface_nodes(mesh).iter().map(|n| from_block_m(&mesh.nodes_m[*n as usize]).abs()).fold(0.0, f64::max);
    let volume_share = volumes_m3(mesh).iter().sum::<f64>() / SIDES_M.iter().product::<f64>();
    let (fine_m, nodes) = (mean_edge_m(&placed, 0.009), patch_nodes(&placed, &SMALL));
    println!(
        "{} nodes, patch {nodes}; {off_m:e} m off; volume {volume_share:.4}; edges {:.3} mm",
        mesh.nodes_m.len(),
        fine_m * 1e3
    );
    assert!(off_m < 1e-12);
    // where the mesh is coarse, it cuts off edges and corners of the block
    assert!((0.94..1.0).contains(&volume_share));
    assert!((fine_m / SMALL.fine_m - 1.0).abs() < 0.1);
    assert!((50..=125).contains(&nodes));
    // elements are coarser far away: the block filled with the finest would have thousands of nodes
    assert!(mesh.nodes_m.len() < 900);
    // the whole bottom is fixed, and nothing else
    let heights = placed.tissue.anchors.iter().map(|n| mesh.nodes_m[*n as usize][2]);
    assert!(heights.fold(-1.0, f64::max) < -0.03);
    assert!((0_u32..).zip(&mesh.nodes_m).all(|(n, x)| x[2] > -0.04 + 1e-9 || placed.tissue.anchors.contains(&n)));
}

#[test]
fn a_plate_thinner_than_the_elements_gets_smaller_ones() {
    let desk = Desk::default();
    desk.put("plate.obj", cuboid([60.0, 60.0, 4.0]).obj());
    let scene = scene_of(&desk, "mesh = \"plate.obj\"\nlength_unit = \"mm\"", [0.03, 0.03, 0.004]);
    let sizes = Sizes { fine_m: 0.008, growth: 0.0, ..SMALL };
    let placed = whole(&scene, &[], &sizes).unwrap();
    sound(&placed);
    assert!((volumes_m3(&placed.tissue.mesh).iter().sum::<f64>() / 14.4e-6 - 1.0).abs() < 0.1);
    // a number of nodes is found although the largest elements that are tried do not fit
    let element_m = element_for(&scene, 0.017, 485).unwrap();
    assert!(element_m > 0.001 && element_m < 0.008, "{element_m}");
}

#[test]
#[ignore = "long: finite elements of a whole mesh"]
fn a_block_from_a_file_presses_as_the_reference_of_the_block() {
    presses_as_the_block(0.004);
}

#[test]
#[ignore = "long: minutes of finite elements"]
fn a_block_from_a_file_presses_at_its_centre_as_the_reference_of_the_block() {
    presses_as_the_block(0.0);
}

fn presses_as_the_block(x: f64) {
    let desk = Desk::default();
    let scene = block_file(&desk, [0.0; 3]);
    let placed = whole(&scene, &[], &SMALL).unwrap();
    let found = organ_reference(&scene, &placed, &[[x, 0.0]], &[0.002], None, |_, _| {}).unwrap();
    let [place] = &found.places[..] else { panic!("{} places", found.places.len()) };
    let expected = Answer::block().hold([x, 0.0, 0.0], 0.002).unwrap().force_over_e_m2;
    let off = place.force_over_e_m2[0] / expected - 1.0;
    println!(
        "at {:?}: {:.4} mm^2, {:+.2} % off; own estimate {:.2} %",
        place.place_m,
        place.force_over_e_m2[0] * 1e6,
        off * 100.0,
        found.error[0] * 100.0
    );
    assert!(off.abs() < 0.02, "{off}");
    assert!((V3::from(place.place_m) - V3::new(x, 0.0, 0.0)).norm() < 1e-9);
}

#[test]
fn organs_of_our_own_lie_on_their_shape_with_layers_and_bones() {
    for (name, site) in [("abdomen", [0.03, 0.0, 0.104]), ("foot", [-0.075, 0.0, 0.031]), ("liver", [0.0, 0.044, 0.046])] {
        let organ = Organ::named(name).unwrap();
        let desk = Desk::default();
        let region = organ.regions()[0].name;
        let source = format!("organ = \"{name}\"\nregion = [{{ name = \"{region}\", youngs_modulus_pa = 35000.0 }}]");
        let placed = whole(&scene_of(&desk, &source, site), &[], &SMALL).unwrap();
        sound(&placed);
        let mesh = &placed.tissue.mesh;
        let (nodes, patch) = (mesh.nodes_m.len(), patch_nodes(&placed, &SMALL));
        // what a press feels; chords lie up to 0.11 mm below the surface here
        let (mean_m, chords_m) = facets_off_m(&placed, &organ, SMALL.radius_m);
        println!("{name}: {nodes} nodes, patch {patch}, facets {mean_m:e} m off, chords {chords_m:e} m");
        assert!(mean_m.abs() < 2e-5, "{name}");
        // ten times as stiff where all corners of a tet are in the region by their depths; a thin
        // skin takes up only a part of any tet
        let ratios = &placed.tissue.stiffness_ratio;
        assert!(ratios.iter().all(|r| (1.0 - 1e-12..=10.0 + 1e-12).contains(r)));
        assert!(ratios.iter().any(|r| *r > 1.05));
        let in_bone = (0_u32..).zip(&mesh.nodes_m).filter(|(_, x)| organ.bone_m(**x).is_some_and(|d| d <= 0.0));
        let bones: Vec<u32> = in_bone.map(|(n, _)| n).collect();
        assert_eq!(bones.is_empty(), name != "foot");
        assert!(bones.iter().all(|n| placed.tissue.anchors.contains(n)));
    }
}

#[track_caller]
fn refused(scene: &Scene, sizes: &Sizes, says: &[&str]) -> String {
    let error = whole(scene, &[], sizes).map(|p| p.tissue.mesh.nodes_m.len()).unwrap_err().to_string();
    assert_eq!(error.lines().count(), 1, "{error}");
    for words in says {
        assert!(error.contains(words), "not a word of `{words}`: {error}");
    }
    error
}

#[test]
fn what_cannot_be_cut_out_is_refused_with_what_would_do() {
    let desk = Desk::default();
    let away = refused(&block_file(&desk, [0.01, 0.0, 0.02]), &SMALL, &["probe.site", "20.0 mm from the surface", "site = ["]);
    let site: Vec<f64> =
        away.split("site = [").nth(1).unwrap().trim_end_matches(']').split(", ").map(|c| c.parse().unwrap()).collect();
    let scene = block_file(&desk, [site[0], site[1], site[2]]);
    whole(&scene, &[], &SMALL).unwrap();

    let wide = refused(&scene, &Sizes { radius_m: 0.06, ..SMALL }, &["0.0600 m", "cm^3", "more than half", "at most"]);
    let most: f64 = wide.split("at most ").nth(1).unwrap().trim_end_matches(" m").parse().unwrap();
    // a sphere that contains half of the block has a radius between half its height and half its
    // width
    assert!((0.025..0.045).contains(&most), "{wide}");
    whole(&scene, &[], &Sizes { radius_m: most, ..SMALL }).unwrap();

    // a slender pyramid pressed on its base has no surface that faces away from the probe
    let nodes_m = vec![[0.03, 0.0, 0.0], [-0.02, 0.03, 0.0], [-0.02, -0.03, 0.0], [0.0, 0.0, -0.12]];
    desk.put("pyramid.msh", msh(&TetMesh { nodes_m, tets: vec![[0, 1, 2, 3]], regions: vec![0] }));
    let pyramid = scene_of(&desk, "mesh = \"pyramid.msh\"\nlength_unit = \"m\"", [0.0; 3]);
    refused(&pyramid, &SMALL, &["probe.site", "to rest on", "another side"]);

    for (sizes, says) in [
        (Sizes { radius_m: f64::NAN, ..SMALL }, "radius is NaN"),
        (Sizes { fine_m: 0.0, ..SMALL }, "fine edge is 0"),
        (Sizes { growth: -1.0, ..SMALL }, "growth"),
        (Sizes { fine_m: 2e-4, fine_radius_m: 0.1, ..SMALL }, "larger spacing"),
    ] {
        refused(&scene, &sizes, &[says]);
    }
    let placed = whole(&scene, &[], &SMALL).unwrap();
    for (offset_m, depths_m, says) in
        [([0.2, 0.0], [0.001, 0.002], "press nearer"), ([0.0; 2], [0.002, 0.001], "rising"), ([0.0; 2], [0.0, 0.001], "rising")]
    {
        let error = organ_reference(&scene, &placed, &[offset_m], &depths_m, None, |_, _| {}).unwrap_err().to_string();
        assert!(error.contains(says), "{error}");
    }
}
