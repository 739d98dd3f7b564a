//! Tables, claims and pictures of what was found on the block and on the organs.

use palpate_charts::{Figure, Level, Plot, ScaledAxis, Series};
use palpate_tissue::output::OutputFolder;

use super::figures::pressed;
use super::fit::{BOUNDS, Found, PRINTED, Step};
use super::study::{FIT_N, OnBlock, OnOrgan, named, product};
use super::sweep::{Curve, STATIC};
use crate::error::Error;
use crate::methods::Method;
use crate::study::{Claim, Findings, Table};

/// Distance from the site that the close-up pictures show [finger radii].
const NEAR_RADII: f64 = 5.0;
/// Name of the paper's model.
const MODEL: &str = "local-compression";
/// Tables, claims and pictures of the block and of the organs.
pub fn findings(folder: &OutputFolder, quick: bool, block: &OnBlock, organs: &[OnOrgan]) -> Result<Findings, Error> {
    let mut findings = Findings {
        headline: format!(
            "paper 004 on the block and {} organs, against our own finite elements{}",
            organs.len(),
            if quick { " (quick run: few forces and trials, coarse organs)" } else { "" }
        ),
        ..Findings::default()
    };
    for organ in organs {
        findings.drawn.extend(pictures(folder, organ)?);
    }
    annealing(&mut findings, block, organs);
    sweeps(&mut findings, quick, block, organs);
    Ok(findings)
}

/// Figs. 5 and 6: the product at rest under each force, on a finer mesh. Returns the name and the
/// title of each picture.
fn pictures(folder: &OutputFolder, organ: &OnOrgan) -> Result<Vec<(String, String)>, Error> {
    let (scene, (site, curve)) = (organ.scene.name.as_str(), &organ.pictured);
    let before = [("whole", None), ("0", Some(NEAR_RADII))];
    let before = before.map(|(file, radii)| (file.to_owned(), format!("{scene}, before interaction"), None, radii));
    let presses = organ.scene.finger.forces_n.iter().enumerate().filter_map(|(n, force_n)| {
        Some(((n + 1).to_string(), format!("{scene}, {force_n} N"), Some(curve.at(*force_n)?), Some(NEAR_RADII)))
    });
    let mut drawn = Vec::new();
    for (file, title, press, radii) in before.into_iter().chain(presses) {
        let name = format!("fig5_6_{scene}_{file}");
        pressed(folder, &name, scene, site, press, radii)?;
        drawn.push((name, format!("Figs. 5 and 6: {title}")));
    }
    Ok(drawn)
}

/// Fig. 7.
fn annealing(findings: &mut Findings, block: &OnBlock, organs: &[OnOrgan]) {
    let walks = block.walks.iter().enumerate().map(|(n, walk)| (format!("block, walk {}", n + 1), walk, None));
    let walks = walks.chain(organs.iter().map(|o| (o.scene.name.clone(), &o.walk, o.fitted.region)));
    let walks = Table::rows("walks", walks)
        .col("fit", |(fit, ..)| fit.clone())
        .col("stiffness_n_per_m", |(_, walk, _)| walk.best.stiffness_n_per_m)
        .col("damping_n_s_per_m", |(_, walk, _)| walk.best.damping_n_s_per_m)
        .col("distance_mm", |(_, walk, _)| walk.best.distance_mm)
        .col("simulations", |(_, walk, _)| walk.simulations[0])
        .col("without_answer", |(_, walk, _)| walk.simulations[1])
        .col("least_stress_pa", |(.., region)| region.map(|region| region.least_stress_pa))
        .all();
    findings
        .tables
        .push(walks.about(
            "Fig. 7: k and d fitted by the paper's annealing to the motion of finite elements after the finger is let go",
        ));
    let below = format!("block, {} nodes; the last trial of each temperature", block.block.size().nodes);
    let figure = |name: &str, title: &str, y: &str, pick: fn(&Step) -> f64, level: Level| {
        let walk = |(n, found): (usize, &Found)| {
            Series::curve(format!("walk {}", n + 1), found.steps.iter().map(|s| (s.temperature_mm, pick(s))))
        };
        let series = block.walks.iter().enumerate().map(walk).collect();
        let plot = Plot::new(ScaledAxis::log("temperature [mm]"), ScaledAxis::log(y), series).levels([level]);
        Figure::plot(name, title, below.as_str(), plot)
    };
    findings.plotted.extend([
        figure(
            "fig7_stiffness",
            "Fig. 7: spring stiffness k against temperature",
            "k [N/m]",
            |s| s.stiffness_n_per_m,
            Level::new("the paper's 0.91 N/mm", PRINTED[0]),
        ),
        figure(
            "fig7_damping",
            "Fig. 7: damping d against temperature",
            "d [N s/m]",
            |s| s.damping_n_s_per_m,
            Level::new("the paper's 3.11", PRINTED[1]),
        ),
    ]);
    let [first, second] = [0, 1].map(|n| block.walks[n].end);
    let apart = |a: f64, b: f64| (a / b).max(b / a);
    let k_apart = apart(first.stiffness_n_per_m, second.stiffness_n_per_m);
    let d_apart = apart(first.damping_n_s_per_m, second.damping_n_s_per_m);
    findings.claims.extend([
        Claim::printed(
            "Fig. 7: k converges to its optimum",
            format!("two walks from random starts end a factor of {k_apart:.3} apart"),
            Some(k_apart < 1.05),
        ),
        Claim::printed(
            "Fig. 7: d converges to its optimum",
            format!(
                "they end a factor of {d_apart:.1} apart, at distances of {:.4} and {:.4} mm",
                first.distance_mm, second.distance_mm
            ),
            Some(d_apart < 1.1 && first.damping_n_s_per_m > 3.0 * BOUNDS[1][0]),
        ),
    ]);
}

/// Figs. 8 and 9: force against displacement, and time from load to rest.
fn sweeps(findings: &mut Findings, quick: bool, found: &OnBlock, organs: &[OnOrgan]) {
    let layered: Vec<Vec<Curve>> = organs.iter().map(|o| o.layered.iter().map(|(curve, _)| curve.clone()).collect()).collect();
    let of_organs = organs.iter().zip(&layered);
    let scenes = std::iter::once(("block", found.block.size().nodes, &found.curves, &[][..]))
        .chain(of_organs.map(|(o, layered)| (o.scene.name.as_str(), o.site.block.size().nodes, &o.curves, &layered[..])));
    let (mut best, mut tried, mut most_accurate, mut errors) = (0, 0, 0, Vec::new());
    let (mut rows, mut presses) = (Vec::new(), Vec::new());
    for (scene, nodes, curves, layered) in scenes {
        let truth = named(curves, STATIC);
        for c in curves.iter().chain(layered) {
            let (error, middle) = (truth.and_then(|t| c.depth_error(t)), c.at(FIT_N));
            if c.name == MODEL {
                errors.extend(error.map(|(rms, _)| (scene, rms)));
            }
            rows.push((scene, nodes, c, error, middle));
            presses.extend(c.points.iter().map(|p| (scene, c.name, p)));
        }
        findings.plotted.extend(force_and_time(scene, nodes, curves));
        let others = [Method::Springs.name(), Method::Meshless.name(), Method::NeoHookeanNodal.name()];
        // a method that survives fewer forces ranks below one that survives more
        let score = |name: &str| {
            named(curves, name).zip(truth).and_then(|(c, t)| c.depth_error(t)).map(|(rms, count)| (usize::MAX - count, rms))
        };
        let beats_all = |own| others.iter().filter_map(|name| score(name)).all(|other| own <= other);
        most_accurate += usize::from(score(MODEL).is_some_and(beats_all));
        for point in truth.map_or(&[][..], |t| &t.points) {
            tried += 1;
            let Some(own) = named(curves, MODEL).and_then(|c| c.at(point.force_n)) else { continue };
            let times = others.iter().chain(&[STATIC]).filter_map(|name| Some(named(curves, name)?.at(point.force_n)?.cpu_s));
            best += usize::from(times.fold(f64::INFINITY, f64::min) > own.cpu_s);
        }
    }
    let methods = Table::rows("methods", rows)
        .col("scene", |row| row.0)
        .col("nodes", |row| row.1)
        .col("method", |row| row.2.name)
        .col("step_s", |row| row.2.step_s)
        .col("depth_at_1_6_n_mm", |row| row.4.map(|p| p.depth_m * 1e3))
        .col("rms_depth_error_pct", |row| row.3.map(|(rms, _)| rms * 100.0))
        .col("forces", |row| row.3.map(|(_, forces)| forces))
        .col("virtual_ms_to_rest", |row| row.4.and_then(|p| p.virtual_s).map(|s| s * 1e3))
        .col("cpu_ms_to_rest", |row| row.4.map(|p| p.cpu_s * 1e3))
        .col("ends", |row| row.2.ended.clone().unwrap_or_else(|| "survives all".into()))
        .all();
    let presses = Table::rows("presses", presses)
        .col("scene", |row| row.0)
        .col("method", |row| row.1)
        .col("force_n", |(.., p)| p.force_n)
        .col("depth_m", |(.., p)| p.depth_m)
        .col("virtual_s", |(.., p)| p.virtual_s)
        .col("cpu_s", |(.., p)| p.cpu_s)
        .all();
    let about = "Figs. 8 and 9: one finger (20 g, 4 N s/m) let go at the surface with a constant force; depth error from static finite elements; processor time to rest";
    findings.tables.extend([methods.about(about), presses.quiet()]);
    let worst = errors.iter().map(|(_, rms)| *rms).fold(0.0, f64::max);
    let listed: Vec<String> = errors.iter().map(|(scene, rms)| format!("{scene} {:.0} %", rms * 100.0)).collect();
    // few forces on coarse organs cannot decide a claim
    let decided = |holds: bool| (!quick).then_some(holds);
    findings.claims.extend([
        Claim::printed(
            "Fig. 8: the force-displacement curve is \"highly approximate\" to 3-D finite elements",
            match listed.is_empty() {
                true => "it never comes to rest".into(),
                false => format!("rms depth error, values fitted on the same mesh: {}", listed.join(", ")),
            },
            decided(!errors.is_empty() && worst <= 0.1),
        ),
        Claim::printed(
            "Fig. 9: takes less time than meshless, mass-spring and finite-element models in most cases",
            format!("the fastest of these in {best} of {tried} presses that the reference bears; one that sinks counts as slower"),
            decided(2 * best > tried),
        ),
        Claim::printed(
            "Abstract: more accurate than the other models",
            format!(
                "of springs, meshless and explicit finite elements none is nearer to the static reference in {most_accurate} of {} scenes",
                1 + organs.len()
            ),
            decided(2 * most_accurate > 1 + organs.len()),
        ),
    ]);
    let faster = product(&found.curves).zip(named(&found.curves, MODEL));
    if let Some(ratio) = faster.and_then(|(p, l)| Some(l.at(FIT_N)?.cpu_s / p.at(FIT_N)?.cpu_s)) {
        findings.notes.push(format!("the product needs 1/{ratio:.1} of the paper's model's time at {FIT_N} N on the block"));
    }
}

/// Figs. 8 and 9 of a scene.
fn force_and_time(scene: &str, nodes: usize, curves: &[Curve]) -> [Figure; 2] {
    let drawn = || curves.iter().filter(|c| !c.points.is_empty());
    let origin = || std::iter::once((0.0, 0.0));
    let forces =
        drawn().map(|c| Series::curve(c.name, origin().chain(c.points.iter().map(|p| (p.depth_m * 1e3, p.force_n)))).marked());
    let times = drawn().map(|c| Series::curve(c.name, c.points.iter().map(|p| (p.force_n, p.cpu_s * 1e3))).marked());
    let force = || ScaledAxis::linear("force [N]");
    [
        Figure::plot(
            format!("fig8_{scene}"),
            format!("Fig. 8, {scene}: force against displacement at rest"),
            format!("{nodes} nodes; depths at rest; dots: forces asked for"),
            Plot::new(ScaledAxis::linear("displacement [mm]"), force(), forces.collect()),
        ),
        Figure::plot(
            format!("fig9_{scene}"),
            format!("Fig. 9, {scene}: CPU time from load to rest"),
            format!("{nodes} nodes; {}", palpate_tissue::machine::processor()),
            Plot::new(force(), ScaledAxis::log("CPU time [ms]"), times.collect()),
        ),
    ]
}
