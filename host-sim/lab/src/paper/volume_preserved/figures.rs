//! Pictures of the report.

use nalgebra::Vector3;

use super::measured::Measured;
use super::scene::HangingScene;
use super::steps::{PRINTED_LAWS, Steps};
use super::{METHODS, Resolution};
use crate::error::Error;
use crate::paper::report::Report;
use palpate_charts::{
    BoxCluster, BoxPlot, LabelledValues, Landmark, Layer, LineSeries, Lines, Look, Scale, ScaledAxis, Superposed, box_plot,
    lines, superposed,
};
use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;

/// Short names of [`METHODS`] for legends.
const SHORT: [&str; 4] = ["palpate", "paper, (12) with l0 in mm", "paper, 0.1 critical", "no length correction"];
/// Indices in [`METHODS`] of the methods that are drawn.
const DRAWN: [usize; 2] = [0, 2];

/// Fig. 2: organs at rest and deformed, superposed; one picture for each move and method.
pub fn fig_2(scene: &HangingScene, resolution: &Resolution, folder: &OutputFolder, report: &mut Report) -> Result<(), Error> {
    report.say("Fig. 2: rest (wire) and lifted organs, markers 1 to 7.");
    for (n, name) in scene.attachment.names.iter().enumerate() {
        for m in DRAWN {
            let (_, rests) = &resolution.runs[m];
            let Some(Ok(rest)) = rests.get(n) else { continue };
            let file = format!("fig2_{}_{name}_{}", resolution.name, ["palpate", "", "paper"][m]);
            let title = format!("{}, {name} move: {}", scene.name, SHORT[m]);
            draw(resolution, &rest.measured, &title, folder, &file)?;
            report.picture(&file, &title);
        }
    }
    Ok(())
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

/// Fig. 3: box plot of the surface errors.
pub fn fig_3(scene: &HangingScene, resolution: &Resolution, folder: &OutputFolder, report: &mut Report) -> Result<(), Error> {
    let mut errors = Vec::new();
    for (n, truth) in resolution.truth.moves.iter().enumerate() {
        let of = resolution.runs.iter().map(|(_, rests)| {
            let rest = rests.get(n).and_then(|r| r.as_ref().ok());
            rest.map(|rest| rest.measured.surface_errors_m(truth).into_iter().map(|e| 1e3 * e).collect::<Vec<f64>>())
        });
        errors.push(of.collect::<Vec<_>>());
    }
    let labels: Vec<String> = scene.attachment.names.iter().map(|name| format!("{name} move")).collect();
    let clusters: Vec<BoxCluster> = labels
        .iter()
        .zip(&errors)
        .map(|(label, of)| BoxCluster {
            label,
            boxes: of
                .iter()
                .zip(SHORT)
                .filter_map(|(values, name)| values.as_ref().map(|values| LabelledValues { name, values }))
                .collect(),
        })
        .collect();
    let points = resolution.assembly.surface.len();
    let title = format!("{}: surface error of {points} points, {} resolution", scene.name, resolution.name);
    let below = "distance to finite elements of the same scene (13)";
    let file = format!("fig3_{}", resolution.name);
    box_plot(folder.draft(), &file, &BoxPlot { title: &title, below, quantity: "error [mm]", clusters: &clusters })?;
    report.say(format!("Fig. 3: surface error of {points} points of the lifted part's upper surface."));
    report.picture(&file, &title);
    debug_assert_eq!(SHORT.len(), METHODS.len());
    Ok(())
}

/// Draws the force of a press over the time step.
pub fn force_against_step(steps: &Steps, folder: &OutputFolder, report: &mut Report) -> Result<(), Error> {
    const NAMES: [&str; 3] = ["corrections, tau = 0", "corrections, tau = 0.1", "compensation as an energy"];
    let series: Vec<LineSeries> = NAMES
        .into_iter()
        .zip(&steps.force)
        .map(|(name, curve)| LineSeries {
            name,
            points: curve.iter().map(|(dt_s, force_n)| (1e3 * dt_s, 1e3 * force_n)).collect(),
            joined: true,
            marked: true,
        })
        .collect();
    let title = "A correction of positions makes the force depend on the time step";
    let chart = Lines {
        title,
        below: "block of 130 nodes pressed 2 mm deep; finite elements say 49.2 mN",
        x: ScaledAxis { title: "time step [ms]", scale: Scale::Log },
        y: ScaledAxis { title: "force [mN]", scale: Scale::Linear },
        series: &series,
        levels: &[palpate_charts::Level { name: "finite elements", y: 49.2 }],
    };
    lines(folder.draft(), "force_against_step", &chart)?;
    report.picture("force_against_step", title);
    Ok(())
}

/// Draws the largest stable time step over the damping, with those of the printed forms as
/// horizontal lines.
pub fn stable_step(steps: &Steps, folder: &OutputFolder, report: &mut Report) -> Result<(), Error> {
    let points = steps.damped.iter().map(|(share, dt_s)| (*share, 1e3 * dt_s)).collect();
    let series = [LineSeries { name: "a share of critical", points, joined: true, marked: true }];
    let level = |name: &'static str| {
        let found = steps.stable.iter().find(|(law, _)| *law == name);
        found.map(|(name, dt_s)| palpate_charts::Level { name, y: 1e3 * f64::from(*dt_s) })
    };
    let levels: Vec<_> = PRINTED_LAWS.into_iter().filter_map(level).collect();
    let title = "The damper (12) as printed leaves no step that a tick could take";
    let chart = Lines {
        title,
        below: "largest step of the sparse scene, springs (11); a tick is 1 ms",
        x: ScaledAxis { title: "damping of each spring over critical [1]", scale: Scale::Log },
        y: ScaledAxis { title: "largest step [ms]", scale: Scale::Log },
        series: &series,
        levels: &levels,
    };
    lines(folder.draft(), "stable_step", &chart)?;
    report.picture("stable_step", title);
    Ok(())
}
