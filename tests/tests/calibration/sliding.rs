//! Moving contact: a patch with rim springs that is as long as the stroke gives the same force as
//! the whole organ all along a fast slide, and methods known to be wrong are found to be wrong.

use std::sync::OnceLock;

use palpate::Params;
use palpate_fit::calibrate::reference_map::ReferenceMap;
use palpate_fit::calibrate::{Settings, Targets};
use palpate_fit::statics::Vector;
use palpate_lab::far_field::sliding::{
    Awake, Figures, Kind, Leg, Measured, STEP_N, StrokePatch, StrokeRecipe, StudyMethod, Trajectory, WORK_MJ, slide,
};
use palpate_lab::paper_method::region::{ContactPressure, StressRule};
use palpate_tissue::answer::Answer;
use palpate_tissue::patch::Patch;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::calibrated::sized;

const STROKE_M: [f64; 3] = [0.03, 0.0, 0.0];

fn trajectory(speed_m_per_s: f64) -> Trajectory {
    Trajectory { centre_m: Vector::zeros(), stroke_m: STROKE_M.into(), depth_m: 0.003, speed_m_per_s }
}

fn map() -> ReferenceMap<'static> {
    static ANSWER: OnceLock<Answer> = OnceLock::new();
    ReferenceMap::of(ANSWER.get_or_init(Answer::block)).unwrap()
}

/// A stroke patch with a short fit: it uses fewer places and rounds than the report.
fn fitted() -> &'static StrokePatch {
    static FITTED: OnceLock<StrokePatch> = OnceLock::new();
    FITTED.get_or_init(|| {
        let settings = Settings { places: 40, rounds: 5, ..Settings::default() };
        let recipe = StrokeRecipe { settings, ..StrokeRecipe::new(0.012, 0.005, STROKE_M, 0.008) };
        StrokePatch::fit(&Scene::load("block").unwrap(), &recipe, Some(&trajectory(0.1)), &map()).unwrap()
    })
}

fn contestant(patch: Patch, params: &Params, awake: Awake) -> StudyMethod {
    StudyMethod::new(Kind::Stroke, "patch".into(), patch, params, awake).unwrap()
}

fn figures(one: &StudyMethod, trajectory: &Trajectory) -> Figures {
    let model = one.patch.model();
    let free = model.nodes.len() - model.anchors.len();
    let slide = slide(&one.patch, &one.params, one.awake, trajectory).unwrap();
    slide.figures(&map(), f64::from(one.params.youngs_modulus_pa), free).unwrap()
}

#[test]
fn a_stroke_patch_is_right_all_the_way_at_100_mm_per_s() {
    let one = contestant(fitted().patch.clone(), &fitted().params, Awake::All);
    assert_eq!(one.params.substeps, 1);
    let found = figures(&one, &trajectory(0.1));
    assert!(found.worst_pct.abs() <= 5.0, "{found:?}");
    assert!(found.step_n <= STEP_N, "{found:?}");
    assert!(found.work_mj <= WORK_MJ, "{found:?}");
    // every node is awake, so no change of the active region can cause a step
    assert!(found.region_step_n == 0.0 && found.awake_pct == [100.0; 2], "{found:?}");
    // a depth that was not fitted, on a line 3 mm beside the one that was
    let aside = Trajectory { centre_m: Vector::new(0.0, 0.003, 0.0), depth_m: 0.0025, ..trajectory(0.05) };
    let found = figures(&one, &aside);
    assert!(found.worst_pct.abs() <= 6.0, "{found:?}");
}

#[test]
fn speed_takes_energy_and_never_gives_any() {
    let one = contestant(fitted().patch.clone(), &fitted().params, Awake::All);
    let found = [0.02, 0.1, 0.4].map(|speed| figures(&one, &trajectory(speed)));
    assert!(found.iter().all(|f| f.work_mj <= 0.0 && f.lateral_pct <= 0.0), "{found:?}");
    assert!(found.windows(2).all(|f| f[1].work_mj < f[0].work_mj && f[1].lateral_pct < f[0].lateral_pct), "{found:?}");
}

#[test]
fn a_rim_twice_as_stiff_or_fixed_is_seen() {
    let good = figures(&contestant(fitted().patch.clone(), &fitted().params, Awake::All), &trajectory(0.05));
    let mut doubled = fitted().far.springs.clone();
    doubled.blocks.iter_mut().for_each(|(_, block)| block.iter_mut().flatten().for_each(|entry| *entry *= 2.0));
    let mut patch = fitted().patch.clone();
    patch.set_rim(&doubled);
    let broken = figures(&contestant(patch, &fitted().params, Awake::All), &trajectory(0.05));
    let fixed = figures(&contestant(fitted().with_fixed_rim(), &fitted().params, Awake::All), &trajectory(0.05));
    assert!(good.worst_pct.abs() <= 5.0 && broken.worst_pct > 10.0 && fixed.worst_pct > 40.0);
}

#[test]
fn a_frozen_outside_misses_with_half_of_the_nodes_awake() {
    let (patch, params) = sized(410).unwrap();
    let awake = figures(&contestant(patch.clone(), &params, Awake::All), &trajectory(0.05));
    let rule = StressRule::new(200.0, params.poisson_ratio, ContactPressure::UniformLoad);
    let frozen = figures(&contestant(patch, &params, Awake::Stressed(rule)), &trajectory(0.05));
    assert!(awake.worst_pct.abs() <= 5.0, "{awake:?}");
    assert!(frozen.awake_pct[1] > 40.0 && frozen.mean_pct > 10.0, "{frozen:?}");
}

#[test]
fn rim_springs_answer_as_the_dense_outside_all_along_the_stroke() {
    let StrokePatch { far, patch, params, .. } = fitted();
    let rim: Vec<usize> = far.cut.rim.iter().map(|n| *n as usize).collect();
    let exact = palpate_fit::statics::Statics::of(&patch.model(), params).unwrap().with_rim(&rim, &far.exact_m);
    let one = StudyMethod { exact: Some(exact), ..contestant(patch.clone(), params, Awake::All) };
    let found = Measured::of(&one, &trajectory(0.1), &[0.1], &map()).unwrap();
    assert!(found.rim_pct.unwrap().abs() <= 0.5, "{:?}", found.rim_pct);
    assert!(found.rest_pct.unwrap()[0].abs() <= 5.0, "{:?}", found.rest_pct);
    // at higher speeds the force departs from the reference, which is static
    assert!(found.leaves_at_mm_per_s.is_some_and(|v| v > 100.0), "{:?}", found.leaves_at_mm_per_s);
    assert!(found.trace.ways().all(|r| matches!(r.pose.leg, Leg::Forth | Leg::Back)));
}

#[test]
fn places_of_a_fit_cover_the_stroke_evenly() {
    let stroke = Vector::new(0.02, 0.01, 0.0);
    let targets = Targets::over_a_stroke(&map(), Vector::new(0.001, 0.0, 0.0), stroke.into(), 0.005, 0.008, 90).unwrap();
    assert_eq!(targets.places.len(), 91);
    let along = stroke.normalize();
    let offsets = targets.places.iter().map(|p| p.place_m - Vector::new(0.001, 0.0, 0.0));
    let (mut cells, half) = ([[0; 2]; 6], 0.5 * stroke.norm() + 0.001);
    for d in offsets.skip(1) {
        let (s, t) = (d.dot(&along), d.dot(&Vector::z().cross(&along)));
        assert!(s.abs() <= half && t.abs() <= 0.005 && d.z == 0.0, "{d}");
        let part = |x: f64, parts: usize| ((x * parts as f64) as usize).min(parts - 1);
        cells[part(0.5 * (s / half + 1.0), 6)][part(0.5 * (t / 0.005 + 1.0), 2)] += 1;
    }
    assert!(cells.iter().flatten().all(|n| (6..=9).contains(n)), "{cells:?}");
    // the calibrated region contains every place that the probe touches
    assert!(targets.reach_m() >= half + 0.008);
}
