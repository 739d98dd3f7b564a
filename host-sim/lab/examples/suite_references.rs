//! Computes what the suite stores of its own scenes: presses that no fit saw with the law that is
//! fitted to the others, two ramps, and a press that relaxes, slides and returns.
//!
//! Run `cargo run --release --example suite_references -- FOLDER WHAT NAME...`, where WHAT is held,
//! patch, ramps or return. Laws and patches are those of `palpate fit` with elements of 4.48 mm
//! within 17 mm. It refuses a law for a nodule or a stiff layer, since they could be changed, and
//! some of the patches, since no board runs them.

use std::error::Error;
use std::path::Path;
use std::time::Instant;

use nalgebra::Vector3;
use palpate_fit::calibrate::Settings;
use palpate_fit::far_field::prepared::{Prepared, Recipe};
use palpate_fit::force_map::BlockForces;
use palpate_fit::law_fit::{LawPresses, block_shape, fit};
use palpate_fit::reference::body::Material;
use palpate_fit::reference::domain::BlockCase;
use palpate_fit::reference::newton::Press;
use palpate_fit::reference::probe::RigidProbe;
use palpate_fit::reference::shape::TetRule;
use palpate_fit::scene_fit::{Level, PIECE_RADII, PiecePresses, tissue_of};
use palpate_fit::solved::Solved;
use palpate_lab::dynamic::history::History;
use palpate_lab::dynamic::motion::{Motion, Pose};
use palpate_lab::dynamic::settings::Settings as Resolution;
use palpate_lab::dynamic::{compute, fading};
use palpate_lab::suite::{DEPTH_M, RETURN, SPEEDS_MM_PER_S, folder};
use palpate_tissue::answer::{Answer, AnswerProbe, HoldAnswer};
use palpate_tissue::budget::MACHINES;
use palpate_tissue::moving::Table;
use palpate_tissue::moving::table::Row;
use palpate_tissue::output::OutputFolder;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::Session;

/// Edge length of the elements at the site [probe radii], as in `fit --law`.
const ELEMENT_RADII: f64 = 0.56;
/// Radius of the disc of places of a law [probe radii], as in `fit --law`.
const REACH_RADII: f64 = 1.15;
/// Depths of a layered block for the fit and for its evaluation [m], and corner nodes of a quarter
/// of it.
const FITTED_M: [f64; 4] = [1e-3, 1.6e-3, 2.5e-3, DEPTH_M];
const UNSEEN_M: [f64; 3] = [1.3e-3, 2e-3, 3.2e-3];
const LAYERED_NODES: [usize; 2] = [700, 1400];
/// Rounds of the fit of a patch.
const ROUNDS: usize = 6;
/// Corner nodes of a motion, hold after a ramp [s], and time between rows [s].
const CORNER_NODES: usize = 700;
const HOLD_S: f64 = 0.02;
const SPACING_S: f64 = 1e-3;
/// Longest step of the press that relaxes [s].
const RETURN_STEP_S: f64 = 0.025;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [out, what, names @ ..] = arguments.as_slice() else { return Err("give a folder, what, and names".into()) };
    let out = Path::new(out);
    std::fs::create_dir_all(out)?;
    if what == RETURN {
        return returned(out);
    }
    for name in names {
        let scene = Scene::load(&folder().join(format!("{name}.toml")).display().to_string())?;
        match what.as_str() {
            "held" => held(out, name, &scene)?,
            "patch" => patch(out, name, &scene)?,
            _ => ramps(out, name, &scene)?,
        }
    }
    Ok(())
}

fn held(out: &Path, name: &str, scene: &Scene) -> Result<(), Box<dyn Error>> {
    let radius_m = scene.probe.radius_m;
    let (unseen, error, (patch, params)) = if let Some(size_m) = scene.tissue.block_m {
        let (known, unseen, error) = layered(scene, size_m)?;
        let known = BlockForces::of(&known).ok_or("four depths at the centre")?;
        let rest = block_shape(size_m, [0.0; 3], DEPTH_M);
        let law = LawPresses { known: &known, depths_m: [FITTED_M[0], DEPTH_M], reach_radii: REACH_RADII };
        (unseen, error, fit(scene, &rest, [0.0, 0.0, 1.0], &law)?)
    } else {
        let prepared = Prepared::of(scene, &Recipe::new(PIECE_RADII * radius_m, ELEMENT_RADII * radius_m, radius_m))?;
        let presses = PiecePresses::of(scene, &prepared.placed, (Level::Quick, true), &Solved::beside(out), |_, _| {})?;
        let depths_m = [presses.fitted_m.first().copied().unwrap_or(DEPTH_M), DEPTH_M];
        let law = LawPresses { known: presses.known.reference(), depths_m, reach_radii: REACH_RADII };
        let fitted = fit(scene, &prepared.far.cut.patch, prepared.placed.axis, &law)?;
        (presses.unseen, presses.error, fitted)
    };
    let stable_s = Session::of_fitted(&MACHINES[0], patch.clone(), params)?.stable.pressed_s;
    println!("{name}: {} presses, the elements within {:.2} %", unseen.holds.len(), 100.0 * error);
    let folder = OutputFolder::open(&out.join(name))?;
    unseen.save(&folder, &format!("{name}.json"))?;
    folder.write(&format!("{name}-law.patch"), &patch.pack(&params, stable_s as f32))?;
    folder.publish()?;
    Ok(())
}

/// Presses at the centre of a block whose layers are the same everywhere, for the fit and for its
/// evaluation, and the relative change of the force between the two meshes (1).
fn layered(scene: &Scene, size_m: [f64; 3]) -> Result<(Answer, Answer, f64), Box<dyn Error>> {
    let mut depths_m = [FITTED_M.as_slice(), UNSEEN_M.as_slice()].concat();
    depths_m.sort_by(f64::total_cmp);
    let forces = LAYERED_NODES.map(|nodes| -> Result<Vec<f64>, Box<dyn Error>> {
        let case = BlockCase {
            size_m,
            place_m: [0.0; 2],
            material: Material {
                poisson_ratio: scene.tissue.poisson_ratio,
                stiffening_b: 0.0,
                inclusions: scene.tissue.inclusion.clone(),
            },
            nodes,
            fine_radius_m: scene.probe.radius_m,
            rule: TetRule::Eleven,
            may_cut: [true; 2],
        };
        let built = case.build()?;
        let probe = RigidProbe::new(scene.probe.shape, scene.probe.radius_m, built.place_m, Vector3::z());
        let mut press = Press::new(&built.body, probe, built.place_m).ok_or("not enough memory")?;
        let mut forces = Vec::new();
        for depth_m in &depths_m {
            press.go_to(*depth_m, |_| {}).map_err(|_| "no equilibrium")?;
            forces.push(press.force_over_e_m2());
        }
        Ok(forces)
    });
    let [coarse, fine] = forces;
    let (coarse, fine) = (coarse?, fine?);
    // convergence is of third order in the edge under the probe
    let gain = LAYERED_NODES[1] as f64 / LAYERED_NODES[0] as f64 - 1.0;
    let error = coarse.iter().zip(&fine).map(|(c, f)| (f - c).abs() / f).fold(0.0, f64::max);
    let hold = |(depth_m, (c, f)): (&f64, (&f64, &f64))| HoldAnswer {
        place_m: [0.0; 3],
        depth_m: *depth_m,
        force_over_e_m2: f + (f - c) / gain,
        surface: None,
    };
    let holds: Vec<HoldAnswer> = depths_m.iter().zip(coarse.iter().zip(&fine)).map(hold).collect();
    let tip = AnswerProbe { shape: scene.probe.shape, radius_m: scene.probe.radius_m };
    let of = |own: &[f64], places_m: &[f64]| {
        let at = |x_m: f64| {
            let of_depth = holds.iter().filter(|hold| own.contains(&hold.depth_m));
            of_depth.map(move |hold| HoldAnswer { place_m: [x_m, 0.0, 0.0], ..hold.clone() })
        };
        let holds = places_m.iter().flat_map(|x_m| at(*x_m)).collect();
        Answer { tissue: tissue_of(scene), probe: tip, holds, glued: Vec::new() }
    };
    Ok((of(&FITTED_M, &[0.0, 0.006, 0.012]), of(&UNSEEN_M, &[0.0]), error))
}

/// The calibrated patch, as `fit --quick` makes it.
fn patch(out: &Path, name: &str, scene: &Scene) -> Result<(), Box<dyn Error>> {
    let radius_m = scene.probe.radius_m;
    let prepared = Prepared::of(scene, &Recipe::new(PIECE_RADII * radius_m, ELEMENT_RADII * radius_m, radius_m))?;
    let presses = PiecePresses::of(scene, &prepared.placed, (Level::Quick, true), &Solved::beside(out), |_, _| {})?;
    let settings = Settings { places: 80, rounds: ROUNDS, least_gain: 0.01 };
    let fit = presses.fit_piece(&prepared, &settings, &mut |_| {})?;
    let stable_s = Session::of_fitted(&MACHINES[0], fit.patch.clone(), fit.params)?.stable.pressed_s;
    std::fs::write(out.join(format!("{name}.patch")), fit.patch.pack(&fit.params, stable_s as f32))?;
    println!("{name}: {} nodes", fit.patch.model().nodes.len());
    Ok(())
}

fn ramps(out: &Path, name: &str, scene: &Scene) -> Result<(), Box<dyn Error>> {
    for speed in SPEEDS_MM_PER_S {
        let began = Instant::now();
        let motion = Motion::ramp(f64::from(speed) * 1e-3, DEPTH_M, HOLD_S);
        let step_s = if speed < 100 { 4e-3 } else { 1e-3 };
        let settings = Resolution { corner_nodes: CORNER_NODES, fine_radius_m: Some(0.004), step_s, ..Resolution::default() };
        let history = compute(scene, &motion, &settings)?;
        let head = [
            format!("version = {}, scene = {name}, ramp of {speed} mm/s", Table::VERSION),
            format!("corner_nodes = {CORNER_NODES}, quadratic_nodes = {}, step_s = {step_s}", history.nodes),
        ];
        let text = table(&motion, &history).to_csv(&head);
        std::fs::write(out.join(format!("{name}-{speed}.csv")), text)?;
        println!("{name}-{speed}: {} nodes, {:.0} s", history.nodes, began.elapsed().as_secs_f64());
    }
    Ok(())
}

/// A table of forces along the press, which need not be along z.
fn table(motion: &Motion, history: &History) -> Table {
    let count = (motion.duration_s() / SPACING_S).round() as u32;
    let normal_m2 = |t_s: f64| {
        let samples = &history.samples;
        let next = samples.partition_point(|sample| sample.t_s < t_s).clamp(1, samples.len() - 1);
        let (a, b) = (&samples[next - 1], &samples[next]);
        let share = ((t_s - a.t_s) / (b.t_s - a.t_s)).clamp(0.0, 1.0);
        (a.normal_n + (b.normal_n - a.normal_n) * share) / history.youngs_modulus_pa
    };
    let row = |n: u32| {
        let t_s = f64::from(n) * SPACING_S;
        Row { t_s, depth_m: motion.pose(t_s).depth_m, across_m: 0.0, force_over_e_m2: [0.0, 0.0, normal_m2(t_s)] }
    };
    Table { rows: (0..=count).map(row).collect() }
}

fn returned(out: &Path) -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::load("block")?;
    scene.tissue.relaxation = Scene::load("beef")?.tissue.relaxation;
    let at = |x_m: f64| Pose { depth_m: 3e-3, across_m: [x_m, 0.0] };
    let motion = Motion::at_touch().go(at(0.0), 0.04).hold(1.0).go(at(0.008), 0.04).hold(0.3).go(at(0.0), 0.04).hold(0.5);
    let settings = Resolution { corner_nodes: CORNER_NODES, step_s: RETURN_STEP_S, ..Resolution::default() };
    let table = fading::compute(&scene, &motion, &settings)?;
    let head = format!("version = {}, the preset block with the relaxation of beef: press, relax, slide, return", Table::VERSION);
    std::fs::write(out.join(format!("{RETURN}.csv")), table.to_csv(&[head]))?;
    Ok(())
}
