//! Paper 004's figures: their components, and a report that contains all of them.

use std::sync::OnceLock;

use crate::bench::Noise;
use nalgebra::Vector3;
use palpate_lab::methods::{Block, Law, Meshless, Method, NeoHookean, Volume};
use palpate_lab::paper::local_compression::fit::{Target, distance_mm};
use palpate_lab::paper::local_compression::hausdorff::{directed, hausdorff};
use palpate_lab::paper::local_compression::methods::{Fitted, StudyMethod};
use palpate_lab::paper::local_compression::scene::{PRESETS, PressScene};
use palpate_lab::paper::local_compression::schedule::{Schedule, Verdict, Walk};
use palpate_lab::paper::local_compression::site::Site;
use palpate_lab::paper::local_compression::truth::Truth;
use palpate_lab::paper::local_compression::{Options, run};
use serde_json::Value;

/// Spring stiffness that corresponds to 20 kPa on these blocks [N/m].
const STIFFNESS_N_PER_M: f64 = 180.0;

fn block() -> Block {
    let mut block = Block::standard(60, 20e3).unwrap();
    block.tissue.depth_limit_m = 0.024;
    block
}

fn points(seed: u64, count: usize) -> Vec<Vector3<f64>> {
    let mut noise = Noise::new(seed);
    (0..count).map(|_| noise.vector()).collect()
}

#[test]
fn hausdorff_is_the_plain_maximum_of_minima() {
    let (a, b) = (points(1, 40), points(2, 25));
    let plain = |a: &[Vector3<f64>], b: &[Vector3<f64>]| {
        a.iter().map(|x| b.iter().map(|y| (x - y).norm()).fold(f64::INFINITY, f64::min)).fold(0.0, f64::max)
    };
    assert!((directed(&a, &b) - plain(&a, &b)).abs() < 1e-12);
    assert!((hausdorff(&a, &b) - plain(&a, &b).max(plain(&b, &a))).abs() < 1e-12);
    assert_eq!(hausdorff(&a, &b).to_bits(), hausdorff(&b, &a).to_bits());
    // the directed distance from a subset to the whole set is zero, the reverse is not
    assert_eq!(directed(&a[..10], &a), 0.0);
    assert!(directed(&a, &a[..10]) > 0.0);
    // one of several distant points is moved by (3, 4, 0)
    let far: Vec<_> = (0..5).map(|n| Vector3::new(100.0 * f64::from(n), 0.0, 0.0)).collect();
    let mut moved = far.clone();
    moved[2] += Vector3::new(3.0, 4.0, 0.0);
    assert!((hausdorff(&far, &moved) - 5.0).abs() < 1e-12);
}

#[test]
fn the_schedule_is_the_papers() {
    let paper = Schedule::PAPER;
    // 100 * 0.98^n <= 0.001
    let wanted = ((0.001_f64 / 100.0).ln() / 0.98_f64.ln()).ceil() as usize;
    assert_eq!((paper.temperatures(), paper.length()), (wanted, wanted * 200));
    let all = paper.length();
    assert_eq!(paper.temperature(0, all), 100.0);
    assert_eq!(paper.temperature(199, all), 100.0);
    assert!((paper.temperature(200, all) - 98.0).abs() < 1e-9);
    assert!((0.001..0.001 / 0.98).contains(&paper.temperature(all - 1, all)));
}

/// A valley with ripples whose local minima are 0.3 deep.
fn rippled(place: &[f64]) -> f64 {
    let ripple = |x: f64| 0.15 * (1.0 - (8.0 * x).cos());
    (place[0] - 1.5).powi(2) + (place[1] + 0.7).powi(2) + ripple(place[0] - 1.5) + ripple(place[1] + 0.7)
}

#[test]
fn annealing_finds_the_minimum_of_a_rippled_valley_and_goes_on_where_it_stopped() {
    let start = vec![-4.0, 5.0];
    let mut walk = Walk::start(Schedule::PAPER, 20_000, 3, start.clone(), rippled(&start));
    let (mut hot_refused, mut written) = (0, None);
    while !walk.is_done() {
        if walk.trials().0 == 7_000 {
            written = Some(serde_json::to_string(&walk).unwrap());
        }
        let there = walk.propose();
        let cost = rippled(&there);
        let hot = walk.temperature() > 50.0;
        hot_refused += usize::from(walk.judge(there, Some(cost)) == Verdict::Refused && hot);
    }
    let (best, cost) = walk.best();
    assert!((best[0] - 1.5).abs() < 0.02 && (best[1] + 0.7).abs() < 0.02, "{best:?} at {cost}");
    assert!(hot_refused < 200, "{hot_refused} trials refused above 50");
    // a trial without a cost is never accepted
    let mut other = Walk::start(Schedule::PAPER, 10, 3, start.clone(), 1.0);
    let there = other.propose();
    assert_eq!(other.judge(there, None), Verdict::Refused);
    assert_eq!(other.here().0, start);
    // continued from the saved state, the walk is identical to the last bit
    let mut again: Walk = serde_json::from_str(&written.unwrap()).unwrap();
    assert!(again.is_same(&walk));
    while !again.is_done() {
        let there = again.propose();
        let cost = rippled(&there);
        again.judge(there, Some(cost));
    }
    assert_eq!(again, walk);
}

#[test]
fn a_fit_is_at_no_distance_from_itself_and_further_from_stiffer_springs() {
    let target = Target::new(&block(), 0.8, 2.5e-4).unwrap();
    let mut simulator = target.simulator();
    let mut trajectory = |k| simulator.trajectory(k, 1e-3).unwrap();
    let [soft, same, stiff, stiffer] = [100.0, 100.0, 150.0, 225.0].map(&mut trajectory);
    assert_eq!(distance_mm(&soft, &same), 0.0);
    assert!(distance_mm(&soft, &stiff) > 0.05);
    assert!(distance_mm(&soft, &stiffer) > distance_mm(&soft, &stiff));
    // a stiffness far beyond the limit of the step
    assert!(simulator.trajectory(1e6, 0.0).is_none());
}

/// A press to a force ends at that force, and at a depth that does not depend on the step.
#[test]
fn a_press_ends_at_its_force_and_at_one_depth() {
    let block = block();
    for contestant in [
        StudyMethod::Charted(Method::Palpate),
        StudyMethod::Charted(Method::NeoHookeanNodal),
        StudyMethod::LocalCompression(Fitted { node_damping_per_s: 40.0, ..Fitted::new(STIFFNESS_N_PER_M, 1e-3) }),
    ] {
        let step_s = contestant.step_s(&block, 0.8).unwrap().unwrap().unwrap();
        let rest = contestant.press(&block, step_s, 0.8, 1).unwrap().unwrap().unwrap();
        assert!((rest.force_n / 0.8 - 1.0).abs() < 0.01, "{}: {} N", contestant.name(), rest.force_n);
        // the final state does not depend on the step
        let finer =
            contestant.press(&block, if step_s < 1e-3 { step_s / 2.0 } else { step_s }, 0.8, 1).unwrap().unwrap().unwrap();
        assert!((finer.depth_m / rest.depth_m - 1.0).abs() < 0.02, "{}: {} m", contestant.name(), finer.depth_m);
    }
}

#[test]
fn layers_push_back_as_their_stiffness_says() {
    let text = PRESETS[1].1;
    let depth_m = |text: &str, force_n: f64| {
        let site = Site::of(&PressScene::parse("test", text).unwrap(), 1.8).unwrap();
        Truth::layered(&site).press(&[force_n], |_| ()).unwrap()[0].depth_m
    };
    let plain = depth_m(text, 0.8);
    // twice the stiffness under twice the force gives the same depth
    let doubled = text.replace("48.0e3", "96.0e3").replace("80.0e3", "160.0e3");
    assert!((depth_m(&doubled, 1.6) / plain - 1.0).abs() < 1e-3);
    // with only one layer stiffer, the depth is in between
    let deep = depth_m(&text.replace("80.0e3", "160.0e3"), 0.8);
    let all = depth_m(&doubled, 0.8);
    assert!(all < deep && deep < plain, "{all} < {deep} < {plain}");
}

/// Forces of methods are linear in the stiffness of the tissue, for all tets together and for each
/// tet.
#[test]
fn methods_take_uneven_tissue() {
    let even = block();
    let rest: Vec<Vector3<f32>> = even.tissue.mesh.nodes_m.iter().map(|x| Vector3::from(*x).cast()).collect();
    let mut noise = Noise::new(5);
    let x: Vec<Vector3<f32>> = rest.iter().map(|x| x + (noise.vector() * 2e-4).cast()).collect();
    let ratio: Vec<f64> = (0..even.tissue.mesh.tets.len()).map(|n| if n % 3 == 0 { 2.5 } else { 0.5 }).collect();
    let with = |ratio: Vec<f64>| {
        let mut block = even.clone();
        block.tissue.stiffness_ratio = ratio;
        block
    };
    let forces = |law: &mut dyn Law| {
        let mut force = vec![Vector3::zeros(); x.len()];
        law.forces(&x, &mut force);
        force
    };
    type Build = fn(&Block) -> Box<dyn Law>;
    let build: [Build; 3] = [
        |b| Box::new(NeoHookean::new(b, Volume::PerTet)),
        |b| Box::new(NeoHookean::new(b, Volume::Nodal)),
        |b| Box::new(Meshless::new(b).unwrap()),
    ];
    for (which, build) in build.into_iter().enumerate() {
        let one = forces(&mut *build(&even));
        let three = forces(&mut *build(&with(vec![3.0; ratio.len()])));
        let mixed = forces(&mut *build(&with(ratio.clone())));
        let rest_of_three: Vec<f64> = ratio.iter().map(|r| 3.0 - r).collect();
        let other = forces(&mut *build(&with(rest_of_three)));
        let size = one.iter().map(Vector3::norm).fold(0.0, f32::max);
        for n in 0..x.len() {
            assert!((three[n] - one[n] * 3.0).norm() < 1e-3 * size, "law {which}, node {n}");
            assert!((mixed[n] + other[n] - three[n]).norm() < 1e-3 * size, "law {which}, node {n}: layers do not add up");
        }
        assert!(mixed.iter().zip(&one).any(|(m, o)| (m - o).norm() > 0.1 * size));
    }
}

/// Report, summary and folder of a quick run.
fn quick_run() -> &'static (String, Value, tempfile::TempDir) {
    static RUN: OnceLock<(String, Value, tempfile::TempDir)> = OnceLock::new();
    RUN.get_or_init(|| {
        let desk = tempfile::tempdir().unwrap();
        run(&Options { quick: true, scene: Some("foot-press".into()), provenance: Value::Null }, desk.path(), &()).unwrap();
        let report = std::fs::read_to_string(desk.path().join("report.md")).unwrap();
        let summary = std::fs::read_to_string(desk.path().join("summary.json")).unwrap();
        (report, serde_json::from_str(&summary).unwrap(), desk)
    })
}

#[test]
#[ignore = "long: the whole report"]
fn the_report_has_every_figure() {
    let (report, summary, desk) = quick_run();
    let shown: Vec<&str> = report.split("](").skip(1).filter_map(|rest| rest.split_once(')').map(|(name, _)| name)).collect();
    for figure in ["fig5_6_foot-press_3", "fig7_stiffness", "fig7_damping", "fig8_block", "fig8_foot-press", "fig9_block"] {
        assert!(shown.contains(&format!("{figure}.png").as_str()), "{figure} is not in the report");
    }
    for name in &shown {
        for kind in ["png", "svg"] {
            let path = desk.path().join(name).with_extension(kind);
            assert!(std::fs::metadata(&path).is_ok_and(|m| m.len() > 1000), "{} is missing", path.display());
        }
    }
    for curve in ["fig7_stiffness", "fig8_block", "fig9_block", "presses"] {
        let text = std::fs::read_to_string(desk.path().join(curve).with_extension("csv")).unwrap();
        assert!(text.lines().count() > 2 && !text.contains("NaN"), "{curve}.csv: {text}");
    }
    assert!(!report.contains("NaN") && !report.contains("inf "), "{report}");
    let claims = summary["claims"].as_array().unwrap();
    assert!(claims.len() >= 5 && report.contains("| does not hold |"));
    // the fits are finished, so no notes for continuing them remain
    let hidden = format!(".{}.", desk.path().file_name().unwrap().to_string_lossy());
    let beside = std::fs::read_dir(desk.path().parent().unwrap()).unwrap().flatten();
    assert!(beside.into_iter().all(|e| !e.file_name().to_string_lossy().starts_with(&hidden)));
}

#[test]
#[ignore = "long: the whole report"]
fn the_report_says_what_was_measured() {
    let (.., desk) = quick_run();
    let table = |name: &str| -> Vec<std::collections::BTreeMap<String, String>> {
        let mut rows = csv::Reader::from_path(desk.path().join(name)).unwrap();
        rows.deserialize().map(Result::unwrap).collect()
    };
    let presses = table("presses.csv");
    for scene in ["block", "foot-press"] {
        let depths = |name: &str| -> Vec<f64> {
            let own = presses.iter().filter(|p| p["scene"] == scene && p["method"] == name);
            own.map(|p| p["depth_m"].parse().unwrap()).collect()
        };
        let (truth, product) = (depths("fem-static"), depths("palpate"));
        assert_eq!(truth.len(), 3, "{scene}");
        assert!(truth.windows(2).all(|w| w[0] < w[1]));
        // the scenes' layers are chosen for this range of depths
        assert!(truth[0] > 1.5e-3 && truth[2] < 10e-3, "{truth:?}");
        // the product, uncalibrated, on a coarse mesh
        assert!((product[0] / truth[0] - 1.0).abs() < 0.2, "{product:?} beside {truth:?}");
    }
}
