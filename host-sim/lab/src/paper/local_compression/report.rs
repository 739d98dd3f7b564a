//! The sections of the report: findings on the block and on the organs, in words, tables and
//! pictures.

use crate::paper_method::region::ContactPressure;

use super::failures::region::{Awake, least_awake};
use super::failures::{barycentre, correction};
use super::figures::{Words, curves, force_displacement, pressed, time_to_rest};
use super::fit::TIMES_MS;
use super::identifiability::{HELD_M, Loading};
use super::rest::{STILL_MS, STILL_NODE_M_PER_S, STILL_TIP_M};
use super::study::{BLOCK_PA, FIT_N, FIT_STEPS_S, OnBlock, OnOrgan, named, product};
use super::sweep::{Curve, STATIC};
use crate::error::Error;
use crate::methods::Method;
use crate::paper::report::Report;
use palpate_charts::Scale;
use palpate_tissue::output::OutputFolder;

/// Distance from the site that the close-up pictures show [finger radii].
const NEAR_RADII: f64 = 5.0;
/// Reads a quantity of a region.
type Pick = fn(&Awake) -> f64;

/// Largest accepted force error of the region (1).
pub const REGION_ERROR: f64 = 0.02;

/// Writes the section on Figs. 5 and 6 and draws them.
///
/// # Errors
/// Fails if a picture cannot be drawn or written.
pub fn pictures(report: &mut Report, folder: &OutputFolder, organs: &[OnOrgan]) -> Result<(), Error> {
    report.section("Figs. 5 and 6: the finger on the abdomen and on the foot");
    report.say("Drawn from the product on the core (`palpate`, method of the other charts), at rest under the force. Depths of the reference stand in the table.");
    for organ in organs {
        let size = organ.site.block.size();
        let layers: Vec<String> = organ.site.layers.iter().map(|(name, e)| format!("{name} {:.1} kPa", e * 1e-3)).collect();
        report.say(format!(
            "**{}**: {} nodes, {} tets; {}. Sources of the stiffnesses are in the scene file.",
            organ.scene.name,
            size.nodes,
            size.tets,
            layers.join(", ")
        ));
        let of = |name: &str| named(&organ.curves, name);
        let layered = organ.layered.as_ref();
        let mut header = vec!["force [N]".to_owned(), "product [mm]".into(), "FEM, same mesh [mm]".into()];
        if let Some((_, nodes)) = layered {
            header.push(format!("FEM, {nodes} corner nodes, layers through elements [mm]"));
        }
        let header: Vec<&str> = header.iter().map(String::as_str).collect();
        let rows = organ.scene.finger.forces_n.iter().map(|&force_n| {
            let depth =
                |c: Option<&Curve>| c.and_then(|c| c.at(force_n)).map_or("-".into(), |p| format!("{:.2}", p.depth_m * 1e3));
            let mut row = vec![format!("{force_n}"), depth(of(Method::Palpate.name())), depth(of(STATIC))];
            if let Some((curve, _)) = layered {
                row.push(depth(Some(curve)));
            }
            row
        });
        report.table(&header, rows);
        if layered.is_some_and(|(curve, _)| organ.scene.finger.forces_n.iter().any(|f| curve.at(*f).is_none())) {
            report.say("A dash: the finer finite elements found no equilibrium at that force or below it; the layers are then checked by nothing but the same mesh.");
        }
        let (site, curve) = &organ.pictured;
        let name = |n: usize| format!("fig5_6_{}_{n}", organ.scene.name);
        let whole = format!("fig5_6_{}_whole", organ.scene.name);
        report.say(format!(
            "The pictures are of a finer mesh, {} nodes: the whole organ, then the skin around the finger.",
            site.block.size().nodes
        ));
        pressed(folder, &whole, &organ.scene.name, site, None, None)?;
        report.picture(&whole, &format!("{}, whole, before interaction", organ.scene.name));
        pressed(folder, &name(0), &organ.scene.name, site, None, Some(NEAR_RADII))?;
        report.picture(&name(0), &format!("{}, before interaction", organ.scene.name));
        for (n, &force_n) in organ.scene.finger.forces_n.iter().enumerate() {
            if let Some(point) = curve.at(force_n) {
                pressed(folder, &name(n + 1), &organ.scene.name, site, Some(point), Some(NEAR_RADII))?;
                report.picture(&name(n + 1), &format!("{}, {force_n} N", organ.scene.name));
            }
        }
    }
    Ok(())
}

/// Writes the section on Fig. 7 and on the identifiability of k and d, and draws the figure.
///
/// # Errors
/// Fails if a picture cannot be drawn or written.
pub fn annealing(report: &mut Report, folder: &OutputFolder, found: &OnBlock, organs: &[OnOrgan]) -> Result<(), Error> {
    report.section("Fig. 7: k and d against temperature");
    let trials: usize = found.walks.iter().map(|w| w.simulations[0]).sum();
    report.say(format!(
        "The paper's schedule (from 100 down to 0.001, each temperature 0.98 of the one before), {trials} simulations in this run, k between 1 and 10^4 N/m and d between 10^-4 and 10 N s/m, two walks from random starts on the block of \
         {} nodes. Objective: Hausdorff distance (4)-(6) of the key points near the finger to those of finite elements, mean over {TIMES_MS:?} ms after a finger with {FIT_N} N \
         is let go, in mm; temperatures are in mm too, the paper gives no unit. So above some 10 mm every trial with an answer is taken. Step {} ms: stiffer or more damped springs \
         diverge at it and are never taken.",
        found.block.size().nodes,
        FIT_STEPS_S[0] * 1e3
    ));
    let below =
        format!("block, {} nodes, {:.0} kPa; the last trial of each temperature", found.block.size().nodes, BLOCK_PA * 1e-3);
    super::figures::annealing(folder, &below, &found.walks)?;
    report.picture("fig7_stiffness", "k against temperature");
    report.picture("fig7_damping", "d against temperature");
    let row = |name: String, walk: &super::fit::Found| {
        let [run, failed] = walk.simulations;
        [
            name,
            format!("{:.4}", walk.best.stiffness_n_per_m * 1e-3),
            format!("{:.2e}", walk.best.damping_n_s_per_m),
            format!("{:.3}", walk.best.distance_mm),
            format!("{run}"),
            format!("{failed}"),
        ]
    };
    let mut rows: Vec<[String; 6]> =
        found.walks.iter().enumerate().map(|(n, w)| row(format!("block, walk {}", n + 1), w)).collect();
    rows.extend(organs.iter().map(|o| row(o.scene.name.clone(), &o.walk)));
    rows.push(["the paper".into(), "0.91".into(), "3.11 (\"Ns/m\")".into(), "not given".into(), "-".into(), "-".into()]);
    report.table(&["fit", "k [N/mm]", "d [N s/m]", "distance left [mm]", "simulations in this run", "without an answer"], rows);

    report.say("**Steps.** The largest with which the network vibrates freely without growing, by bisection. The paper's values cannot be run at 1 ms on this mesh:");
    let what = ["fitted k, no d", "fitted k and d", "the paper's k, no d", "the paper's k and d"];
    let rows = what.iter().zip(&found.steps).map(|(what, ([k, d], step_s))| {
        [(*what).to_owned(), format!("{:.3}", k * 1e-3), format!("{d:.2e}"), format!("{:.4}", step_s * 1e3)]
    });
    report.table(&["values", "k [N/mm]", "d [N s/m]", "largest step [ms]"], rows);

    report.say(format!(
        "**What the objective sees.** Hausdorff distance in mm between the key points with the fitted values and with changed ones. A shape at rest does not feel d, whatever moves \
         the finger. With the tip held {:.0} mm deep a common factor of k changes shapes only by way of the contact, whose stiffness is not scaled along; under a force it moves \
         the tip itself. (A dash: diverges or sinks.)",
        HELD_M * 1e3
    ));
    let rows = found.seen.iter().map(|seen| {
        let name = match seen.drive {
            Loading::Held => "tip held, at rest",
            Loading::ForceAtRest => "force, at rest",
            Loading::ForceOnTheWay => "force, on the way",
        };
        let cell = |moved: f64| if moved.is_nan() { "-".into() } else { format!("{moved:.4}") };
        let [a, b, c, d] = seen.moved_mm.map(cell);
        [name.to_owned(), a, b, c, d]
    });
    report.table(&["finger", "k/2", "2k", "d/4", "4d"], rows);

    let [first, second] = [0, 1].map(|n| found.walks[n].end);
    let apart = |a: f64, b: f64| (a / b).max(b / a);
    let k_apart = apart(first.stiffness_n_per_m, second.stiffness_n_per_m);
    let d_apart = apart(first.damping_n_s_per_m, second.damping_n_s_per_m);
    report.claim(
        "Fig. 7: k converges to its optimum",
        format!("two walks from random starts end a factor of {k_apart:.3} apart"),
        Some(k_apart < 1.05),
    );
    report.claim(
        "Fig. 7: d converges to its optimum",
        format!(
            "they end a factor of {d_apart:.1} apart, at distances of {:.4} and {:.4} mm",
            first.distance_mm, second.distance_mm
        ),
        Some(d_apart < 1.1 && first.damping_n_s_per_m > 3.0 * super::fit::BOUNDS[1][0]),
    );
    Ok(())
}

/// Writes the section on Figs. 8 and 9 and draws them.
///
/// # Errors
/// Fails if a picture cannot be drawn or written.
pub fn sweeps(
    report: &mut Report,
    folder: &OutputFolder,
    machine: &str,
    found: &OnBlock,
    organs: &[OnOrgan],
) -> Result<(), Error> {
    report.section("Figs. 8 and 9: force against displacement, and time from load to deformation");
    // few forces on coarse organs cannot decide a claim
    let quick = organs.iter().all(|o| o.layered.is_none());
    report.say(format!(
        "One finger (20 g, 4 N s/m) is let go at the surface with a constant force. Every method has the same mesh, the same tissue (`local-compression` has one k for all of it), starts at rest and stops when the tip went \
         less than {:.0} um in {STILL_MS} ms and no node is faster than {:.1} mm/s. `{STATIC}` (10-node tets on the same corners, Newton on one thread) has no time: it stops at a \
         residual of 1e-8, and its time to a force includes the smaller ones. Times are CPU time on {machine}, the least of up to three runs. Damping: 40/s on the masses for every \
         method, beside d in `local-compression`; with the fitted d alone, as the paper has it, it is a row of its own. Step: the largest of 1, 1/2, 1/4 .. 1/64 ms that comes to rest under the largest force that it bears at all. Masses are true but for the product, which has its floor.",
        STILL_TIP_M * 1e6,
        STILL_NODE_M_PER_S * 1e3
    ));
    report.say(
        "`local-compression` is the paper's model with k and d fitted on the same mesh and with the region (7)-(8) at the highest threshold that costs at most 2 % in depth (none where every \
         threshold tried costs more); the volume force (2) and the correction (11)-(13) are off, see below. `springs`: paper 000's (11). `meshless`: moving least squares. \
         `neo-hookean-nodal`: explicit finite elements. `palpate`: the product, `palpate-calibrated` on the block's shipped patch.",
    );
    let scenes = std::iter::once(("block", &found.block, &found.curves))
        .chain(organs.iter().map(|o| (o.scene.name.as_str(), &o.site.block, &o.curves)));
    let (mut best, mut tried, mut most_accurate, mut errors) = (0, 0, 0, Vec::new());
    for (scene, block, curves) in scenes {
        let below = format!("{} nodes; depths at rest; dots: forces asked for", block.size().nodes);
        force_displacement(folder, scene, &below, curves)?;
        time_to_rest(folder, scene, &format!("{} nodes; {machine}", block.size().nodes), curves)?;
        report.say(format!("**{scene}**, {} nodes.", block.size().nodes));
        report.picture(&format!("fig8_{scene}"), &format!("{scene}: force against displacement"));
        report.picture(&format!("fig9_{scene}"), &format!("{scene}: time from load to rest"));
        let truth = named(curves, STATIC);
        let rows = curves.iter().map(|c| {
            let error = truth.and_then(|t| c.depth_error(t));
            if c.name == "local-compression" {
                errors.extend(error.map(|(rms, _)| (scene.to_owned(), rms)));
            }
            let middle = c.at(FIT_N);
            let number = |value: Option<f64>, digits: usize| value.map_or("-".into(), |v| format!("{v:.digits$}"));
            [
                c.name.to_owned(),
                number(c.step_s.map(|s| s * 1e3), 4),
                number(middle.map(|p| p.depth_m * 1e3), 2),
                error.map_or("-".into(), |(rms, count)| format!("{:.1} ({count})", rms * 100.0)),
                number(middle.and_then(|p| p.virtual_s).map(|s| s * 1e3), 0),
                number(middle.map(|p| p.cpu_s * 1e3), 1),
                c.ended.clone().unwrap_or_else(|| "survives all".into()),
            ]
        });
        let header = [
            "method",
            "step [ms]",
            "depth at 1.6 N [mm]",
            "depth error, rms % (forces)",
            "virtual time to rest [ms]",
            "CPU time [ms]",
            "ends",
        ];
        report.table(&header, rows.collect::<Vec<_>>());
        let methods = [Method::Springs.name(), Method::Meshless.name(), Method::NeoHookeanNodal.name(), STATIC];
        // a method that survives fewer forces ranks below one that survives more
        let score = |name: &str| {
            named(curves, name).zip(truth).and_then(|(c, t)| c.depth_error(t)).map(|(rms, count)| (usize::MAX - count, rms))
        };
        let others = methods.iter().filter(|r| **r != STATIC).filter_map(|r| score(r));
        most_accurate += usize::from(score("local-compression").is_some_and(|own| others.into_iter().all(|other| own <= other)));
        for point in truth.map_or(&[][..], |t| &t.points) {
            tried += 1;
            let Some(own) = named(curves, "local-compression").and_then(|c| c.at(point.force_n)) else { continue };
            let others = methods.iter().filter_map(|r| named(curves, r)?.at(point.force_n));
            best += usize::from(others.map(|p| p.cpu_s).fold(f64::INFINITY, f64::min) > own.cpu_s);
        }
        let rows = curves.iter().flat_map(|c| c.points.iter().map(move |p| (c.name, p)));
        let mut text = String::from("method,force_n,depth_m,virtual_s,cpu_s\n");
        for (name, p) in rows {
            let virtual_s = p.virtual_s.map_or(String::new(), |s| s.to_string());
            text.push_str(&format!("{name},{},{},{virtual_s},{}\n", p.force_n, p.depth_m, p.cpu_s));
        }
        folder.write(&format!("presses_{scene}.csv"), text.as_bytes())?;
    }
    let listed: Vec<String> = errors.iter().map(|(scene, rms)| format!("{scene} {:.0} %", rms * 100.0)).collect();
    let worst = errors.iter().map(|(_, rms)| *rms).fold(0.0, f64::max);
    report.claim(
        "Fig. 8: the force-displacement curve is \"highly approximate\" to 3-D finite elements",
        if listed.is_empty() {
            "it never comes to rest".into()
        } else {
            format!(
                "rms depth error, values fitted on the same mesh: {}{}",
                listed.join(", "),
                if quick { " (quick run: too little to say)" } else { "" }
            )
        },
        if quick { None } else { Some(!errors.is_empty() && worst <= 0.1) },
    );
    report.claim(
        "Fig. 9: takes less time than meshless, mass-spring and finite-element models in most cases",
        format!("the fastest of these in {best} of {tried} presses that the reference bears; one that sinks counts as slower"),
        if quick { None } else { Some(2 * best > tried) },
    );
    report.claim(
        "Abstract: more accurate than the other models",
        format!("of springs, meshless and explicit finite elements none is nearer to the static reference in {most_accurate} of {} scenes", 1 + organs.len()),
        if quick { None } else { Some(2 * most_accurate > 1 + organs.len()) },
    );
    let faster = product(&found.curves).zip(named(&found.curves, "local-compression"));
    let ratio = faster.and_then(|(p, l)| Some(l.at(FIT_N)?.cpu_s / p.at(FIT_N)?.cpu_s));
    if let Some(ratio) = ratio {
        report.say(format!("The product needs 1/{ratio:.1} of the paper's model's time at {FIT_N} N on the block."));
    }
    Ok(())
}

/// Writes the section on the failures of equations (11)-(13), (7)-(8) and (2).
///
/// # Errors
/// Fails if a picture cannot be drawn or written.
pub fn failures(report: &mut Report, folder: &OutputFolder, found: &OnBlock) -> Result<(), Error> {
    report.section("Where the formulas fail");
    let below = format!(
        "block, {} nodes, springs of the fitted k, {:.0} mm deep, at rest",
        found.block.size().nodes,
        correction::DEPTH_M * 1e3
    );
    let words = Words {
        name: "correction_against_step",
        title: "Over-compression correction (11)-(13): force against time step",
        below: &below,
        x: ("time step [ms]", Scale::Log),
        y: ("force [N]", Scale::Log),
    };
    let lines: Vec<(String, Vec<(f64, f64)>)> =
        found.correction.iter().map(|c| (c.compensation.name(), c.points.iter().map(|(s, f)| (s * 1e3, *f)).collect())).collect();
    curves(folder, &words, &lines, &[])?;
    report.say(
        "**(11)-(13).** Nodes go C/2 in every step, however short, and their velocities stay: a finger that is held feels a force that depends on the time step, not on the tissue; with tau_c = 0 it vanishes with \
         the step. The same compensation as an energy gives one force at every step. (Masses damped by 400/s: with less, the correction with tau_c = 0 feeds more energy than is lost and diverges.)",
    );
    report.picture("correction_against_step", "force against time step");
    let spread = |c: &correction::AgainstStep| {
        let (low, high) = c.points.iter().fold((f64::INFINITY, 0.0_f64), |(l, h), (_, f)| (l.min(*f), h.max(*f)));
        high / low
    };
    let rows = found.correction.iter().map(|c| {
        let at =
            |p: Option<&(f64, f64)>| p.map_or(["-".into(), "-".into()], |(s, f)| [format!("{:.4}", s * 1e3), format!("{f:.3}")]);
        let ([long, first], [short, last]) = (at(c.points.first()), at(c.points.last()));
        [c.compensation.name(), long, first, short, last, format!("{:.2}", spread(c))]
    });
    report.table(
        &["resists compression", "longest step [ms]", "force [N]", "shortest step [ms]", "force [N]", "largest over smallest"],
        rows,
    );
    let printed =
        found.correction.iter().find(|c| c.compensation == correction::Compensation::Printed(0.0)).map_or(f64::NAN, spread);
    let energy = found.correction.iter().find(|c| c.compensation == correction::Compensation::Energy).map_or(f64::NAN, spread);
    report.claim(
        "Section 2.4: the over-compression correction keeps the model valid under a concentrated force",
        format!("with tau_c = 0 the force changes by a factor of {printed:.1} with the time step; as an energy by {energy:.2}"),
        Some(printed < 1.1),
    );
    regions(report, folder, &found.region)?;
    volume_force(report, folder, found)
}

fn regions(report: &mut Report, folder: &OutputFolder, found: &[Awake]) -> Result<(), Error> {
    let forms =
        [(ContactPressure::UniformLoad, "(8) under a uniform load"), (ContactPressure::RigidPunch, "(8) under a rigid punch")];
    let of = |pick: fn(&Awake) -> f64| -> Vec<(String, Vec<(f64, f64)>)> {
        let line = |(form, name): (ContactPressure, &str)| {
            let points = found.iter().filter(|a| a.pressure == form).map(|a| (a.least_stress_pa, pick(a)));
            (name.to_owned(), points.collect())
        };
        forms.map(line).to_vec()
    };
    let below = "block, springs of the fitted k, 4 mm deep, at rest";
    let x = ("least vertical stress [Pa]", Scale::Log);
    let charts: [(&str, &str, &str, Pick); 3] = [
        ("region_radius", "Radius of the region (7)-(8)", "radius [mm]", |a| a.radius_m * 1e3),
        ("region_awake", "Free nodes that the region keeps awake", "share awake [%]", |a| a.share * 100.0),
        ("region_error", "Force error of the region", "force error [%]", |a| a.force_error * 100.0),
    ];
    report.say("**(7)-(8).** Stress under the finger falls as 1/h^2, displacement as 1/h: a region that ends where the stress is small still ends where the tissue moves, and standing still there is a wall.");
    for (name, title, y, pick) in charts {
        curves(folder, &Words { name, title, below, x, y: (y, Scale::Linear) }, &of(pick), &[])?;
        report.picture(name, title);
    }
    let rows = forms.map(|(form, name)| match least_awake(found, form, REGION_ERROR) {
        Some(a) => [
            name.to_owned(),
            format!("{:.1}", a.least_stress_pa),
            format!("{:.1}", a.radius_m * 1e3),
            format!("{:.0}", a.share * 100.0),
            format!("{:+.2}", a.force_error * 100.0),
        ],
        None => [name.to_owned(), "none tried".into(), "-".into(), "-".into(), "-".into()],
    });
    report.table(&["at most 2 % force error", "threshold [Pa]", "radius [mm]", "awake [%]", "force error [%]"], rows);
    let least = forms.iter().filter_map(|(form, _)| least_awake(found, *form, REGION_ERROR)).map(|a| a.share).fold(1.0, f64::min);
    report.claim(
        "Section 2.3: computing only the local region reduces the cost effectively",
        format!("with at most 2 % force error, {:.0} % of the block's free nodes must stay awake", least * 100.0),
        Some(least <= 0.5),
    );
    Ok(())
}

fn volume_force(report: &mut Report, folder: &OutputFolder, found: &OnBlock) -> Result<(), Error> {
    let ([mean, most], presses) = &found.volume;
    report.say(format!(
        "**(2).** The unit vectors from a tet's barycentre to its corners do not add up to zero: a tet that swells pushes itself with {:.0} % of a corner's force on the mean over the block's tets, {:.0} % \
         at most. The paper prints no coefficient; {:.0} mm deep, with the fitted k:",
        mean * 100.0,
        most * 100.0,
        barycentre::DEPTH_M * 1e3
    ));
    let truth = palpate_tissue::answer::Answer::block();
    let truth_n = truth
        .holds
        .iter()
        .find(|h| h.place_m == [0.0; 3] && (h.depth_m - barycentre::DEPTH_M).abs() < 1e-9)
        .map(|h| h.force_over_e_m2 * f64::from(found.block.params.youngs_modulus_pa));
    let rows = presses.iter().map(|p| {
        let error = p.force_n.zip(truth_n).map_or("-".into(), |(f, t)| format!("{:+.1}", 100.0 * (f / t - 1.0)));
        let change = if p.volume_change_pct.is_nan() { "-".into() } else { format!("{:+.3}", p.volume_change_pct) };
        [format!("{:.0e}", p.coefficient_pa_per_m), p.force_n.map_or("diverges".into(), |f| format!("{f:.3}")), error, change]
    });
    report.table(&["coefficient [Pa/m]", "force [N]", "error against FEM [%]", "volume change [%]"], rows.collect::<Vec<_>>());
    let points =
        presses.iter().filter(|p| p.coefficient_pa_per_m > 0.0).filter_map(|p| Some((p.coefficient_pa_per_m, p.force_n?)));
    let words = Words {
        name: "volume_force",
        title: "Volume force (2): force against its coefficient",
        below: "block, springs of the fitted k, 4 mm deep; the curve ends where the model diverges",
        x: ("coefficient [Pa/m]", Scale::Log),
        y: ("force [N]", Scale::Linear),
    };
    let levels: Vec<(&str, f64)> = truth_n.map(|t| ("finite elements", t)).into_iter().collect();
    curves(folder, &words, &[("(2)".to_owned(), points.collect())], &levels)?;
    report.picture("volume_force", "force against the coefficient of (2)");
    let changes = presses.iter().filter(|p| !p.volume_change_pct.is_nan());
    let best = changes.clone().min_by(|a, b| a.volume_change_pct.abs().total_cmp(&b.volume_change_pct.abs()));
    let without = changes.clone().find(|p| p.coefficient_pa_per_m == 0.0);
    if let (Some(best), Some(without)) = (best, without) {
        let [best_pct, without_pct] = [best, without].map(|p| p.volume_change_pct);
        let [with_n, without_n] = [best, without].map(|p| p.force_n.unwrap_or(f64::NAN));
        let found = format!(
            "at best, with c = {:.0e} Pa/m, the volume changes by {best_pct:+.2} % instead of {without_pct:+.2} %, and the force grows from {without_n:.2} to {with_n:.2} N; with more it diverges. \
             Momentum is not kept",
            best.coefficient_pa_per_m
        );
        report.claim(
            "Section 2.1: the volume force ensures volume conservation",
            found,
            Some(best_pct.abs() < 0.1 * without_pct.abs()),
        );
    }
    Ok(())
}
