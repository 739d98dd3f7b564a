//! The command `palpate reference`.

use serde::Serialize;

use super::options::reference::ReferenceArgs;
use super::progress::{Spinner, Status};
use super::verdict::Verdict;
use crate::error::Error;
use palpate_charts::{self as charts, Refinement, RefinementLevel};
use palpate_fit::reference::shipped::SHIPPED;
use palpate_fit::reference::study::{Estimate, Level, Study, extrapolate, study};
use palpate_tissue::Error as TissueError;
use palpate_tissue::answer::{Answer, AnswerProbe, AnswerTissue, HoldAnswer};
use palpate_tissue::output::OutputFolder;
use palpate_tissue::scene::{Drive, Scene};

impl ReferenceArgs {
    pub(super) fn run(&self) -> Result<(), Error> {
        if self.shipped {
            return ship(OutputFolder::add_to(&self.common.folder("reference"))?);
        }
        let scene = self.common.load()?;
        let folder = self.common.open("reference", &scene)?;
        let status = Status::start();
        status.say("meshing the tissue");
        let study = study(&scene, self.quick, |level, depth_m| {
            status.say(format!("mesh {} of 3, {:.2} mm deep", level + 1, depth_m * 1e3));
        })?;
        status.clear();
        let report = Report::new(&scene, &study);
        let verdict = Verdict::of(judge(&scene, &study), || in_words(&study, &report))?.first();
        report.print();
        write(&folder, &scene, &study, &report)?;
        let out = folder.publish()?;
        println!("\nwrote {}: answer.json, summary.json, forces.csv, surface_*.csv, picture as SVG and PNG", out.display());
        verdict.last()
    }
}

/// Checks that every hold converged on every mesh.
fn judge(scene: &Scene, study: &Study) -> Result<(), Error> {
    match study.levels.iter().find_map(|level| level.stopped.map(|s| (level, s))) {
        None => Ok(()),
        Some((level, stalled)) => Err(TissueError::Check(format!(
            "scene {}: on the mesh of {} nodes {} of {} holds converged, the deepest equilibrium is at {:.5} m; what converged is written: press less deep",
            scene.name,
            level.nodes,
            level.holds.len(),
            scene.drive.targets().len(),
            stalled.reached_m
        )).into()),
    }
}

fn in_words(study: &Study, report: &Report) -> String {
    let finest = study.levels.last();
    let error = match report.worst_error_pct() {
        pct if pct.is_nan() => "how far they are off is not known".into(),
        pct => format!("their {} are off by {pct:.2} % at most (estimate)", report.solved_for()),
    };
    format!(
        "all {} holds converged on {} meshes; {error}, on the finest of {} nodes",
        finest.map_or(0, |level| level.holds.len()),
        study.levels.len(),
        finest.map_or(0, |level| level.nodes)
    )
}

fn ship(folder: OutputFolder) -> Result<(), Error> {
    for shipped in &SHIPPED {
        let mut spinner = Spinner::default();
        let answer = shipped.solve(|place_m, depth_m| {
            spinner.show(|| {
                format!("{}: ({:.1}, {:.1}) mm, {:.2} mm deep", shipped.file, place_m[0] * 1e3, place_m[1] * 1e3, depth_m * 1e3)
            });
        })?;
        spinner.clear();
        answer.save(&folder, shipped.file)?;
        println!("{}: {} holds", shipped.file, answer.holds.len());
    }
    println!("wrote {}", folder.publish()?.display());
    Ok(())
}

#[derive(Serialize)]
struct Report<'a> {
    scene: &'a str,
    youngs_modulus_pa: f64,
    poisson_ratio: f64,
    place_m: [f64; 3],
    /// Whether the depths were solved for given forces.
    #[serde(skip)]
    by_force: bool,
    levels: Vec<LevelReport>,
    holds: Vec<HoldReport>,
}

#[derive(Serialize)]
struct LevelReport {
    nodes: usize,
    tets: usize,
    /// Share of the tissue that is computed; the rest is its mirror images.
    share: f64,
    newton_iterations: usize,
    holds_converged: usize,
    /// Depth at which the press stopped, if it did [m].
    reached_m: Option<f64>,
}

#[derive(Serialize)]
struct HoldReport {
    target: f64,
    /// Depth on every level that has the hold [m].
    depth_m: Vec<f64>,
    force_n: Vec<f64>,
    penetration_share_of_depth: f64,
    /// Force (depth, for a force drive) extrapolated to vanishing element size, and estimated error
    /// of the finest level.
    extrapolated: Option<f64>,
    estimated_error_pct: Option<f64>,
}

impl<'a> Report<'a> {
    fn new(scene: &'a Scene, study: &Study) -> Self {
        let modulus_pa = scene.tissue.youngs_modulus_pa;
        let by_force = matches!(scene.drive, Drive::Force { .. });
        let most = study.levels.iter().map(|level| level.holds.len()).max().unwrap_or(0);
        let holds = scene.drive.targets().iter().take(most).enumerate().map(|(k, target)| {
            let solved: Vec<_> = study.levels.iter().filter_map(|level| Some((level.nodes, level.holds.get(k)?))).collect();
            let value =
                |h: &palpate_fit::reference::study::LevelHold| if by_force { h.depth_m } else { h.force_over_e_m2 * modulus_pa };
            let values: Vec<_> = solved.iter().map(|(nodes, h)| (*nodes, value(h))).collect();
            let estimate = extrapolate(&values);
            let share = |e: Estimate| 100.0 * e.error / values.last().map_or(f64::NAN, |v| v.1);
            HoldReport {
                target: *target,
                depth_m: solved.iter().map(|(_, h)| h.depth_m).collect(),
                force_n: solved.iter().map(|(_, h)| h.force_over_e_m2 * modulus_pa).collect(),
                penetration_share_of_depth: solved.last().map_or(0.0, |(_, h)| h.penetration_m / h.depth_m),
                extrapolated: estimate.map(|e| e.limit),
                estimated_error_pct: estimate.map(share),
            }
        });
        let level = |level: &Level| LevelReport {
            nodes: level.nodes,
            tets: level.tets,
            share: 1.0 / level.copies,
            newton_iterations: level.iterations,
            holds_converged: level.holds.len(),
            reached_m: level.stopped.map(|s| s.reached_m),
        };
        Self {
            scene: &scene.name,
            youngs_modulus_pa: modulus_pa,
            poisson_ratio: scene.tissue.poisson_ratio,
            place_m: study.place_m,
            by_force,
            holds: holds.collect(),
            levels: study.levels.iter().map(level).collect(),
        }
    }

    fn print(&self) {
        println!(
            "scene {}: E {:.4} kPa, nu {}; finite elements, 10-node tets",
            self.scene,
            self.youngs_modulus_pa * 1e-3,
            self.poisson_ratio
        );
        for (n, level) in self.levels.iter().enumerate() {
            println!(
                "  mesh {}    {} nodes, {} tets on 1/{} of the tissue; {} Newton iterations",
                n + 1,
                level.nodes,
                level.tets,
                (1.0 / level.share).round(),
                level.newton_iterations
            );
        }
        println!(
            "\nthe same holds on each mesh, each finer than the one before; extrapolated: the {} at vanishing element size; est. error: how far mesh 3 may be off",
            if self.by_force { "depth in metres" } else { "force in newtons" }
        );
        println!(
            "{:>9} {:>10} {:>10} {:>10} {:>13} {:>12}",
            "depth mm", "mesh 1 N", "mesh 2 N", "mesh 3 N", "extrapolated", "est. error %"
        );
        for hold in &self.holds {
            let force = |n: usize| hold.force_n.get(n).map_or("-".into(), |f| format!("{f:.5}"));
            println!(
                "{:>9.4} {:>10} {:>10} {:>10} {:>13} {:>12}",
                hold.depth_m.last().unwrap_or(&f64::NAN) * 1e3,
                force(0),
                force(1),
                force(2),
                hold.extrapolated.map_or("-".into(), |v| format!("{v:.5}")),
                hold.estimated_error_pct.map_or("-".into(), |v| format!("{v:.3}"))
            );
        }
    }

    /// Largest estimated error of the finest mesh [%]; NaN without an estimate.
    fn worst_error_pct(&self) -> f64 {
        self.holds.iter().filter_map(|h| h.estimated_error_pct).fold(f64::NAN, f64::max)
    }

    /// Name of the quantity for which the holds were solved.
    fn solved_for(&self) -> &'static str {
        if self.by_force { "depths" } else { "forces" }
    }

    fn caption(&self) -> String {
        let worst = self.worst_error_pct();
        let kpa = self.youngs_modulus_pa * 1e-3;
        format!("neo-Hookean, E {kpa} kPa, nu {}; estimated error of the finest mesh at most {worst:.2} %", self.poisson_ratio)
    }
}

fn write(folder: &OutputFolder, scene: &Scene, study: &Study, report: &Report) -> Result<(), Error> {
    folder.write_summary(report)?;
    let modulus_pa = scene.tissue.youngs_modulus_pa;
    let rows = study.levels.iter().enumerate().flat_map(|(n, level)| {
        let row = move |(k, h): (usize, &palpate_fit::reference::study::LevelHold)| {
            let force_n = h.force_over_e_m2 * modulus_pa;
            [(n + 1) as f64, level.nodes as f64, k as f64, h.depth_m, force_n, h.force_over_e_m2, h.penetration_m]
        };
        level.holds.iter().enumerate().map(row)
    });
    let header = ["mesh", "nodes", "hold", "depth_m", "force_n", "force_over_e_m2", "penetration_m"];
    folder.write_csv("forces.csv", header, rows)?;
    // the finest level that solved any hold
    let finest = study.levels.iter().rev().find(|level| !level.holds.is_empty());
    let holds = finest.map_or(&[][..], |level| &level.holds);
    for (k, hold) in holds.iter().enumerate() {
        let header = ["rest_x_m", "rest_y_m", "rest_z_m", "displacement_x_m", "displacement_y_m", "displacement_z_m"];
        let rows = hold.surface.iter().map(|(x, u)| [x.x, x.y, x.z, u.x, u.y, u.z]);
        folder.write_csv(&format!("surface_{k}.csv"), header, rows)?;
    }
    let answer = Answer {
        tissue: AnswerTissue {
            block_m: scene.tissue.block_m,
            mesh: scene.tissue.mesh.as_ref().map(|path| path.display().to_string()),
            poisson_ratio: scene.tissue.poisson_ratio,
            stiffening_b: scene.tissue.stiffening_b,
            inclusion: scene.tissue.inclusion.clone(),
        },
        probe: AnswerProbe { shape: scene.probe.shape, radius_m: scene.probe.radius_m },
        holds: holds
            .iter()
            .map(|h| HoldAnswer {
                place_m: study.place_m,
                depth_m: h.depth_m,
                force_over_e_m2: h.force_over_e_m2,
                surface: h.grid.clone(),
            })
            .collect(),
        glued: Vec::new(),
    };
    answer.save(folder, "answer.json")?;
    let levels: Vec<_> = study
        .levels
        .iter()
        .map(|level| RefinementLevel {
            nodes: level.nodes,
            holds: level.holds.iter().map(|h| (h.depth_m, h.force_over_e_m2 * modulus_pa)).collect(),
        })
        .collect();
    if levels.iter().any(|level| !level.holds.is_empty()) {
        let caption = report.caption();
        charts::refinement(folder.draft(), "refinement", &Refinement { scene: &scene.name, caption: &caption, levels: &levels })?;
    }
    Ok(())
}
