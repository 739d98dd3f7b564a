//! `palpate paper volume-preserved`: its files, the evidence for its results, and the input that it
//! refuses.

use crate::palpate_command::{Desk, palpate, repository};
use palpate_lab::paper::volume_preserved::assembly::Assembly;
use palpate_lab::paper::volume_preserved::measured::Measured;
use palpate_lab::paper::volume_preserved::method::{HangingMethod, Setup, hang};
use palpate_lab::paper::volume_preserved::network::{Joints, Network};
use palpate_lab::paper::volume_preserved::scene::{HangingScene, PRESET};
use palpate_lab::paper::volume_preserved::steps::largest_step_s;
use palpate_lab::paper::volume_preserved::truth::Shipped;
use palpate_lab::paper_method::damper::DampingLaw;
use palpate_tissue::patch::Material;

type Vector = palpate::Vector3<f64>;

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");

fn text() -> String {
    std::fs::read_to_string(repository().join("host-sim/scenes/hanging-liver.toml")).unwrap()
}

fn assembly(scene: &HangingScene, at: usize) -> Assembly<'_> {
    let tets: Vec<usize> = scene.organ.iter().map(|o| o.tets[at]).collect();
    Assembly::build(scene, &tets, scene.surface.points[at]).unwrap()
}

/// The finite elements are solved in the run, because these reference values are not stored
/// anywhere.
#[test]
#[ignore = "long: finite elements of two organs"]
fn a_quick_run_reports_and_the_product_is_near_finite_elements() {
    let desk = Desk::default();
    let outcome = palpate(SCRATCH, desk.folder(), &["paper", "volume-preserved", "--quick"]);
    assert_eq!(outcome.code, Some(0), "{}{}", outcome.stdout, outcome.stderr);
    let out = desk.folder().join("out/paper-volume-preserved");
    let read = |name: &str| std::fs::read_to_string(out.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
    let report = read("report.md");
    for words in ["Table 1", "Fig. 2", "Fig. 3", "3.4", "(12)", "does not hold"] {
        assert!(report.contains(words), "the report says nothing of {words}");
    }
    assert!(!report.contains("NaN") && !report.contains("inf |"));
    for picture in report.lines().filter_map(|l| l.strip_prefix("![")?.split_once("](")?.1.strip_suffix(')')) {
        assert!(out.join(picture).is_file(), "{picture} is missing");
        assert!(out.join(picture.replace(".png", ".svg")).is_file());
    }

    let csv = read("means.csv");
    let mut rows = csv::Reader::from_reader(csv.as_bytes());
    let rows: Vec<std::collections::BTreeMap<String, String>> = rows.deserialize().map(Result::unwrap).collect();
    let of = |method: &str| rows.iter().filter(|r| r["method"].starts_with(method)).collect::<Vec<_>>();
    let errors = |method: &str| of(method).iter().map(|r| r["landmarks_mm"].parse().unwrap()).collect::<Vec<f64>>();
    let (ours, theirs) = (errors("palpate"), errors("volume-preserved"));
    // landmarks move by 28 and 48 mm on average
    assert!(ours[0] < 1.2 && ours[1] < 2.4, "{ours:?} mm");
    assert!(ours[0] < theirs[0] && ours[1] < theirs[1], "{ours:?} mm, the printed method {theirs:?} mm");
    for row in of("palpate") {
        assert!(row["min_j"].parse::<f64>().unwrap() > 0.2 && row["at_rest"] == "true", "{row:?}");
        let volumes = row["volume_change_pct"].split(' ').map(|v| v.parse::<f64>().unwrap());
        assert!(volumes.into_iter().all(|v| v.abs() < 0.06), "{row:?}");
    }
}

/// Shipped results belong to the present scene and to the meshes that the generator makes now.
/// Otherwise a run would silently solve for ten minutes.
#[test]
fn shipped_answers_belong_to_the_scene() {
    let scene = HangingScene::load(PRESET).unwrap();
    let shipped = Shipped::load().expect("references/hanging-liver.json can be read");
    let (full, sparse) = (assembly(&scene, 0), assembly(&scene, 1));
    let truth = shipped.full.for_assembly(&full).expect("the full resolution's answer is another scene's");
    assert!(shipped.sparse_subdivided.for_assembly(&sparse).is_some(), "the subdivided answer is another scene's");
    assert!(shipped.full.for_assembly(&sparse).is_none());
    assert_eq!(truth.moves.len(), 2);
    assert!(truth.moves.iter().all(|m| m.min_j > 0.0 && m.landmarks_m.len() == scene.landmark.len() && m.surface_m.len() == 200));
    let tets: Vec<usize> = full.meshes.iter().chain(&sparse.meshes).map(|m| m.tets.len()).collect();
    for (found, wanted) in tets.iter().zip([12_958.0, 5_423.0, 1_698.0, 1_157.0]) {
        assert!((*found as f64 / wanted - 1.0).abs() < 0.03, "{tets:?} tets");
    }
}

/// Checks the points at which errors are measured: a known motion is reproduced at every landmark
/// and surface point, on the original and the subdivided mesh.
#[test]
fn points_of_the_organs_are_followed() {
    let scene = HangingScene::load(PRESET).unwrap();
    let assembly = assembly(&scene, 1);
    let motion = |x: &Vector| Vector::new(0.01 + 0.2 * x.y, -0.1 * x.z + 0.05 * x.x, 0.3 * x.x - 0.02);
    for assembly in [&assembly, &assembly.subdivided()] {
        let corners: Vec<Vector> = assembly.meshes.iter().flat_map(|m| &m.nodes_m).map(|x| motion(&Vector::from(*x))).collect();
        let measured = Measured::of_corners(assembly, &corners);
        let truth = Measured { landmarks_m: assembly.landmarks.iter().map(|(_, x)| motion(x)).collect(), ..measured.clone() };
        for error in measured.landmark_errors_m(&truth) {
            assert!(error < 1e-9, "{error} m");
        }
        let wanted = Measured { surface_m: assembly.surface.iter().map(motion).collect(), ..measured.clone() };
        assert!(measured.surface_errors_m(&wanted).iter().all(|e| *e < 1e-9));
        // determinant of that motion's deformation gradient
        let j = palpate_matrix([[1.0, 0.2, 0.0], [0.05, 1.0, -0.1], [0.3, 0.0, 1.0]]);
        for change in &measured.volume_change_pct {
            assert!((change - 100.0 * (j - 1.0)).abs() < 1e-6, "{change} %");
        }
        assert!((measured.min_j - j).abs() < 1e-9);
    }
}

fn palpate_matrix(m: [[f64; 3]; 3]) -> f64 {
    let [a, b, c] = m.map(Vector::from);
    a.cross(&b).dot(&c)
}

#[test]
fn subdivision_keeps_volume_supports_and_joint() {
    let scene = HangingScene::load(PRESET).unwrap();
    let coarse = assembly(&scene, 1);
    let fine = coarse.subdivided();
    let area = |a: &Assembly, of: &[usize]| -> f64 {
        let corners = |t: &usize| [0, 1, 2].map(|k| a.quadratic.nodes_m[a.quadratic.triangles[*t][k] as usize]);
        of.iter().map(corners).map(|[p, q, r]| 0.5 * (q - p).cross(&(r - p)).norm()).sum()
    };
    for (c, f) in coarse.organs.iter().zip(&fine.organs) {
        assert_eq!(8 * c.tets.len(), f.tets.len());
        let rest = |a: &Assembly, o: &palpate_lab::hanging::organs::Organ| {
            o.volume(&a.quadratic, &vec![Vector::zeros(); a.quadratic.nodes_m.len()]).rest_m3
        };
        assert!((rest(&fine, f) / rest(&coarse, c) - 1.0).abs() < 1e-9);
    }
    assert!(area(&coarse, &coarse.joined) > 1e-4);
    assert!((area(&fine, &fine.joined) / area(&coarse, &coarse.joined) - 1.0).abs() < 1e-9);
    assert_eq!(fine.joined.len(), 4 * coarse.joined.len());
    for set in [(&coarse.fixed, &fine.fixed), (&coarse.held, &fine.held)] {
        assert!(set.1.len() > 2 * set.0.len());
    }
}

/// (10) and (11) for two organs in one patch: each organ's masses follow its density and its
/// springs its modulus, and the joints are added.
#[test]
fn organs_have_their_own_mass_and_stiffness_and_are_joined() {
    let scene = HangingScene::load(PRESET).unwrap();
    let assembly = assembly(&scene, 1);
    let network = Network::build(&assembly, &Material { poisson_ratio: 0.25, ..Material::default() }, Joints::Nearest);
    let model = network.patch.model();
    let liver_nodes = assembly.meshes[0].nodes_m.len();
    let volume = |mesh: &palpate_tissue::mesh::TetMesh, tet: &[u32; 4]| {
        let [a, b, c, d] = tet.map(|n| Vector::from(mesh.nodes_m[n as usize]));
        (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0
    };
    let mass = |range: std::ops::Range<usize>| -> f64 {
        model.nodes[range].iter().map(|n| f64::from(n.volume_m3)).sum::<f64>() * 1060.0
    };
    let wanted = |n: usize| {
        assembly.meshes[n].tets.iter().map(|t| volume(&assembly.meshes[n], t)).sum::<f64>() * scene.organ[n].density_kg_per_m3
    };
    for (found, wanted) in [(mass(0..liver_nodes), wanted(0)), (mass(liver_nodes..model.nodes.len()), wanted(1))] {
        assert!((found / wanted - 1.0).abs() < 1e-5, "{found} kg, not {wanted} kg");
    }
    // (11) for one spring of each organ, in N/m
    for (n, organ) in scene.organ.iter().enumerate() {
        let (mesh, start) = (&assembly.meshes[n], if n == 0 { 0 } else { liver_nodes as u32 });
        let [i, j] = [mesh.tets[0][0].min(mesh.tets[0][1]), mesh.tets[0][0].max(mesh.tets[0][1])];
        let around = mesh.tets.iter().filter(|t| t.contains(&i) && t.contains(&j));
        let k: f64 = around
            .map(|t| 2.0 * 2f64.sqrt() / 25.0 * (12.0 * volume(mesh, t) / 2f64.sqrt()).cbrt() * organ.youngs_modulus_pa)
            .sum();
        let spring = model
            .springs
            .iter()
            .find(|s| u32::from(s.i) == i + start && u32::from(s.j) == j + start)
            .expect("a spring along every edge");
        let found = f64::from(spring.k) * scene.organ[0].youngs_modulus_pa;
        assert!((found / k - 1.0).abs() < 1e-5, "{found} N/m, (11) says {k} N/m");
    }
    let joints = model.springs.iter().filter(|s| (usize::from(s.i) < liver_nodes) != (usize::from(s.j) < liver_nodes)).count();
    assert!(joints >= 10 && joints == assembly.joints().len(), "{joints} joints");
}

/// The finding about (12): with the printed damper, the largest step is thousands of times shorter
/// than without it.
#[test]
fn the_printed_damper_cannot_keep_a_millisecond() {
    let scene = HangingScene::load(PRESET).unwrap();
    let assembly = assembly(&scene, 1);
    let step = |damping| largest_step_s(HangingMethod::VolumePreserved { rates: None, damping }, &assembly).unwrap();
    let [none, printed] = [DampingLaw::Critical(0.0), DampingLaw::PrintedMetres].map(step);
    assert!(none > 2e-4 && printed < 1e-6 && printed > 1e-8, "{none} s without, {printed} s as printed");
}

#[track_caller]
fn refused(scene: &str, says: &[&str]) {
    let desk = Desk::default();
    desk.put("scene.toml", scene);
    let outcome = palpate(SCRATCH, desk.folder(), &["paper", "volume-preserved", "--quick", "--scene", "scene.toml"]);
    assert_eq!(outcome.code, Some(2), "{outcome:?}");
    assert_eq!(outcome.stderr.lines().count(), 1, "{outcome:?}");
    for words in says {
        assert!(outcome.stderr.contains(words), "not a word of `{words}`: {outcome:?}");
    }
    assert_eq!(desk.listing(), ["scene.toml"], "{outcome:?}");
}

#[track_caller]
fn refused_edit(from: &str, to: &str, says: &[&str]) {
    let text = text();
    assert!(text.contains(from), "{from} is not in the scene");
    refused(&text.replacen(from, to, 1), says);
}

#[test]
fn organs_that_do_not_touch_are_refused() {
    refused_edit("reach_m = 0.005", "reach_m = 0.000001", &["joint.reach_m", "gallbladder and liver do not touch", "mm apart"]);
    refused_edit("facing = [0.0, 0.0, 1.0]", "facing = [0.0, 0.0, -1.0]", &["joint.reach_m", "do not touch"]);
}

#[test]
fn landmarks_outside_are_refused_by_name() {
    refused_edit("above_m = [0.020, -0.045]", "above_m = [0.3, -0.045]", &["landmark[3]", "\"4\" lies outside liver"]);
    refused_edit("inside_m = [0.005, -0.060, 0.0]", "inside_m = [0.005, -0.060, 0.2]", &["\"vessel 1\" lies outside liver"]);
}

#[test]
fn sticks_and_supports_that_hold_nothing_are_refused() {
    refused_edit("radius_m = 0.018", "radius_m = 0.0001", &["attachment.radius_m", "no mesh node of liver"]);
    refused_edit(
        "box_m = [[-0.2, 0.008, -0.2], [0.2, 0.2, 0.2]]",
        "box_m = [[0.5, 0.5, 0.5], [0.6, 0.6, 0.6]]",
        &["fixed[0].box_m", "liver"],
    );
}

/// A bad number or name is refused before anything is meshed or written.
#[test]
fn odd_numbers_and_names_are_refused() {
    refused_edit("moves_m = [[0.0,", "moves_m = [[nan,", &["attachment.moves_m[0]", "finite"]);
    refused_edit("gravity_m_per_s2 = [0.0, 0.0, 0.0]", "gravity_m_per_s2 = [0.0, 0.0, 1e30]", &["gravity_m_per_s2", "100"]);
    refused_edit("stiffness_pa_per_m = 2.0e6", "stiffness_pa_per_m = 1e300", &["joint.stiffness_pa_per_m"]);
    refused_edit("points = [200, 100]", "points = [200, 900000000000]", &["surface.points", "10000"]);
    refused_edit("names = [\"small\", \"large\"]", "names = [\"../a\", \"b\"]", &["attachment.names", "slashes"]);
    refused_edit("names = [\"small\", \"large\"]", "names = [\"a\", \"a\"]", &["attachment.names", "twice"]);
    refused_edit("onto = \"liver\"", "onto = \"gallbladder\"", &["joint.onto"]);
    refused_edit("facing = [0.0, 0.0, 1.0]", "facing = [0.0, 0.0, 0.0]", &["joint.facing"]);
}

#[test]
fn values_and_keys_that_cannot_be_are_refused() {
    refused_edit("youngs_modulus_pa = 3500.0", "youngs_modulus_pa = -1.0", &["organ[0].youngs_modulus_pa", "-1"]);
    refused_edit("youngs_modulus_pa = 3500.0", "youngs_modulus = 3500.0", &["scene.toml:", "youngs_modulus_pa"]);
    refused_edit("poisson_ratio = 0.499", "poisson_ratio = 0.5", &["poisson_ratio", "0.4995"]);
    refused_edit("shape = \"gallbladder\"", "shape = \"spleen\"", &["spleen"]);
    refused_edit("organ = \"liver\"\nfrom_m", "organ = \"heart\"\nfrom_m", &["attachment.organ", "heart", "liver, gallbladder"]);
    refused_edit("names = [\"small\", \"large\"]", "names = [\"small\"]", &["attachment.names"]);
}

/// "Position-based attachment": after the move, every held node has moved by exactly that amount,
/// and every fixed node has not moved.
#[test]
fn the_stick_takes_its_nodes_all_the_way() {
    let text = text()
        .replace("moves_m = [[0.0, 0.01148430, 0.04774740], [0.0, 0.03291362, 0.07634497]]", "moves_m = [[0.001, 0.002, 0.003]]");
    let scene = HangingScene::parse("test", &text.replace("names = [\"small\", \"large\"]", "names = [\"tiny\"]")).unwrap();
    let assembly = assembly(&scene, 1);
    let setup = Setup { method: HangingMethod::Palpate, dt_s: 5e-4, substeps: Some(2), longest_s: 0.05 };
    let rests = hang(&assembly, &setup, |_, _| {}).unwrap();
    let rest = rests[0].as_ref().unwrap();
    let moved = |n: &u32| rest.measured.displacement_m[*n as usize];
    for n in assembly.held.iter() {
        assert!((moved(n) - Vector::new(0.001, 0.002, 0.003)).norm() < 1e-8, "{:?}", moved(n));
    }
    assert!(assembly.fixed.iter().all(|n| moved(n).norm() == 0.0));
    assert!(assembly.held.len() > 20 && assembly.fixed.len() > 100);
}
