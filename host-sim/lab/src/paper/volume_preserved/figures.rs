//! Pictures of the report.

use nalgebra::Vector3;

use super::Resolution;
use super::measured::Measured;
use super::scene::HangingScene;
use crate::error::Error;
use palpate_charts::{Bar, Bars, Figure, Form, Landmark, Layer, Look, ScaledAxis, Superposed, superposed};
use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;

/// Short names of [`METHODS`] for legends.
const SHORT: [&str; 4] = ["palpate", "paper, (12) with l0 in mm", "paper, 0.1 critical", "no length correction"];
/// Indices in [`METHODS`] of the methods that are drawn.
const DRAWN: [usize; 2] = [0, 2];

/// Fig. 2: organs at rest (wire) and deformed, superposed; one picture for each move and method.
/// Returns the name and the title of each.
pub fn fig_2(scene: &HangingScene, resolution: &Resolution, folder: &OutputFolder) -> Result<Vec<(String, String)>, Error> {
    let mut drawn = Vec::new();
    for (n, name) in scene.attachment.names.iter().enumerate() {
        for m in DRAWN {
            let (_, rests) = &resolution.runs[m];
            let Some(Ok(rest)) = rests.get(n) else { continue };
            let file = format!("fig2_{}_{name}_{}", resolution.name, ["palpate", "", "paper"][m]);
            let title = format!("Fig. 2, {}, {name} move: {}", scene.name, SHORT[m]);
            draw(resolution, &rest.measured, &title, folder, &file)?;
            drawn.push((file, title));
        }
    }
    Ok(drawn)
}

/// CPU time to draw and write one picture of Fig. 2 [s]; NaN if every method diverged.
pub fn time_of_one_s(resolution: &Resolution) -> Result<f64, Error> {
    let Some(rest) = resolution.runs.iter().find_map(|(_, rests)| rests.iter().find_map(|r| r.as_ref().ok())) else {
        return Ok(f64::NAN);
    };
    let failed = |source| TissueError::Write { path: std::env::temp_dir(), source };
    let desk = tempfile::tempdir().map_err(failed)?;
    let folder = OutputFolder::open(desk.path())?;
    let started = palpate_tissue::clock::thread_time();
    draw(resolution, &rest.measured, "one", &folder, "one")?;
    Ok((palpate_tissue::clock::thread_time() - started).as_secs_f64())
}

fn draw(resolution: &Resolution, measured: &Measured, title: &str, folder: &OutputFolder, file: &str) -> Result<(), Error> {
    let assembly = &resolution.assembly;
    let rest: Vec<[f64; 3]> = assembly.quadratic.nodes_m.iter().map(|x| (*x).into()).collect();
    let moved: Vec<[f64; 3]> = assembly
        .quadratic
        .nodes_m
        .iter()
        .zip(&measured.displacement_m)
        .map(|(x, u): (&Vector3<f64>, _)| (x + u).into())
        .collect();
    let triangles = |organ: usize| -> Vec<[u32; 3]> {
        let range = assembly.organs[organ].triangles.clone();
        assembly.quadratic.triangles[range].iter().map(|t| [t[0], t[1], t[2]]).collect()
    };
    let all: Vec<Vec<[u32; 3]>> = (0..assembly.organs.len()).map(triangles).collect();
    // the colours follow the paper's, in which lifted organs are red and black, those at rest pink
    // and white
    const LIFTED: [[u8; 3]; 2] = [[178, 58, 48], [74, 92, 60]];
    const REST: [[u8; 3]; 2] = [[222, 150, 145], [150, 160, 150]];
    let names: Vec<[String; 2]> =
        assembly.scene.organ.iter().map(|o| [format!("{}, lifted", o.shape), format!("{}, at rest", o.shape)]).collect();
    let mut layers = Vec::new();
    for (organ, triangles) in all.iter().enumerate() {
        let color = organ.min(1);
        layers.push(Layer { name: &names[organ][0], nodes_m: &moved, triangles, color: LIFTED[color], look: Look::Solid });
        layers.push(Layer { name: &names[organ][1], nodes_m: &rest, triangles, color: REST[color], look: Look::Wire });
    }
    let landmarks: Vec<Landmark> = assembly
        .landmarks
        .iter()
        .zip(&measured.landmarks_m)
        .zip(&assembly.scene.landmark)
        .filter(|(_, l)| l.above_m.is_some())
        .map(|(((label, x), u), _)| Landmark { label, at_m: (x + u).into() })
        .collect();
    let below = format!("{} tets", assembly.quadratic.tets.len());
    let picture =
        Superposed { title, below: &below, layers: &layers, landmarks: &landmarks, eye: [1.0, -0.45, 0.5], up: [0.0, 0.0, 1.0] };
    Ok(superposed(folder.draft(), file, &picture)?)
}

/// Fig. 3: quartiles of the surface errors, with the smallest and the largest.
pub fn fig_3(scene: &HangingScene, resolution: &Resolution) -> Figure {
    let mut bars = Vec::new();
    for (n, (name, truth)) in scene.attachment.names.iter().zip(&resolution.truth.moves).enumerate() {
        for ((_, rests), short) in resolution.runs.iter().zip(SHORT) {
            let Some(Ok(rest)) = rests.get(n) else { continue };
            let mut errors_mm: Vec<f64> = rest.measured.surface_errors_m(truth).into_iter().map(|e| 1e3 * e).collect();
            errors_mm.sort_by(f64::total_cmp);
            let at = |share: f64| errors_mm[(share * (errors_mm.len() - 1) as f64).round() as usize];
            bars.push(Bar {
                name: format!("{name} move"),
                kind: short.to_owned(),
                span: [at(0.25), at(0.75)],
                whiskers: Some([at(0.0), at(1.0)]),
                mark: Some(at(0.5)),
                allowed: None,
                text: String::new(),
            });
        }
    }
    let points = resolution.assembly.surface.len();
    Figure {
        name: format!("fig3_{}", resolution.name),
        title: format!("Fig. 3, {}: surface error of {points} points, {} resolution", scene.name, resolution.name),
        below: "distance to finite elements of the same scene (13): median, quartiles, smallest and largest".into(),
        form: Form::Bars(Bars { axis: ScaledAxis::linear("error [mm]"), bars }),
    }
}
