//! Files, table and closing sentences of a fit.

use palpate::Vector3;
use palpate_charts::{self as charts, ConvergencePoint, Press, Sample};
use palpate_fit::calibrate::Round;
use palpate_fit::calibrate::targets::Reference;
use palpate_fit::scene_fit::{SurfaceVerdict, Verdict, tissue_of};
use palpate_tissue::Error as TissueError;
use palpate_tissue::answer::{Answer, AnswerProbe};
use palpate_tissue::fit_record::{FitRecord, Judged, JudgedPart, Moving, OrganRecord, checksum};
use palpate_tissue::output::OutputFolder;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::Session;
use palpate_tissue::trials::Trial;
use serde::Serialize;

use super::added_force::BumpReport;
use super::board::Load;
use super::stages::JudgedFit;
use super::store::StoredFit;
use super::{PatchFile, Written};
use crate::command::options::fit::FitOptions;
use crate::error::Error;

/// All results of a fit.
pub(super) struct Report<'a> {
    pub scene: &'a Scene,
    pub options: &'a FitOptions,
    /// Depths that were fitted [m].
    pub fitted_m: &'a [f64],
    /// Forces to which the patch was fitted.
    pub known: &'a dyn Reference,
    /// Finite-element answer with every press.
    pub answer: &'a Answer,
    /// Nodes of the finest finite-element mesh, unless its answer is stored, and estimated error of
    /// its force at the centre (1).
    pub reference_nodes: Option<usize>,
    pub reference_error: f64,
    pub fit: &'a StoredFit,
    pub judged: &'a JudgedFit,
    pub trials: &'a [Trial],
    /// Errors of the force that a block's inclusions add.
    pub bump: Option<&'a BumpReport>,
    /// Whether the fit is that of an earlier run.
    pub reused_fit: bool,
    /// Number of presses that an earlier run solved.
    pub reused_presses: usize,
    pub places: usize,
}

#[derive(Serialize)]
struct Summary<'a> {
    scene: &'a str,
    nodes: usize,
    quick: bool,
    reused_presses: usize,
    reused_fit: bool,
    tolerance_pct: f64,
    reference_nodes: Option<usize>,
    reference_error_pct: f64,
    fitted_places: usize,
    fitted_depths_m: &'a [f64],
    /// Presses that did not count in the last round, because the patch has no equilibrium there.
    lost_fit_presses: usize,
    uncalibrated: Option<&'a Verdict>,
    calibrated: &'a Verdict,
    #[serde(skip_serializing_if = "Option::is_none")]
    bump: Option<&'a BumpReport>,
    /// Cost of a tick, for a board.
    #[serde(skip_serializing_if = "Option::is_none")]
    load: Option<&'a Load>,
    record: &'a FitRecord,
    rounds: &'a [Round],
}

impl Report<'_> {
    /// Writes all files, publishes them, and prints the verdict. Returns the written patch and the
    /// trials.
    pub(super) fn write(&self, folder: OutputFolder, patch: PatchFile) -> Result<(Written, Vec<Trial>), Error> {
        let record = self.record(&patch.bytes)?;
        let PatchFile { name, bytes, load } = patch;
        folder.write(&name, &bytes)?;
        record.write(&folder, &name)?;
        self.answer.save(&folder, "answer.json")?;
        self.tables(&folder)?;
        self.pictures(&folder)?;
        folder.write_summary(&Summary {
            scene: &self.scene.name,
            nodes: record.nodes,
            quick: self.options.quick,
            reused_presses: self.reused_presses,
            reused_fit: self.reused_fit,
            tolerance_pct: self.options.tolerance_pct,
            reference_nodes: self.reference_nodes,
            reference_error_pct: 100.0 * self.reference_error,
            fitted_places: self.places,
            fitted_depths_m: self.fitted_m,
            lost_fit_presses: self.fit.lost_presses,
            uncalibrated: self.judged.before.as_ref(),
            calibrated: &self.judged.verdict,
            bump: self.bump,
            load: load.as_ref(),
            record: &record,
            rounds: &self.fit.rounds,
        })?;
        folder.write_json("trials.json", &self.trials)?;
        let file = folder.publish()?.join(&name);
        self.print(&record);
        if let Some(load) = &load {
            load.print();
        }
        println!(
            "\nwrote {}: what it was fitted to beside it, summary.json, accuracy.csv, convergence.csv, answer.json, pictures as SVG and PNG",
            file.display()
        );
        // the scene still contains the inclusions of a block, but those of a piece are in the patch
        let inside = self.scene.tissue.block_m.is_none() && !self.scene.tissue.inclusion.is_empty();
        let without = if inside { ", without its [[tissue.inclusion]], which is in the patch" } else { "" };
        println!("press it with patch = \"{}\" under [solver] of the scene{without}", file.display());
        let model = format!("{} nodes", record.nodes);
        Ok((Written { name, record, model, load }, self.trials.to_vec()))
    }

    fn record(&self, patch: &[u8]) -> Result<FitRecord, Error> {
        let mut record = record(self.scene, &self.judged.session, &self.judged.verdict, self.fitted_m, patch)?;
        record.fitted_places = self.places as u32;
        record.lost_fit_presses = self.fit.lost_presses;
        record.reference_error_pct = Some(100.0 * self.reference_error);
        record.quick = self.options.quick;
        if let Some(bump) = self.bump {
            // inclusions were fitted on top: neither of the other errors includes them
            let bump = JudgedPart { rms_pct: bump.fitted.rms_pct, worst_pct: bump.fitted.worst_pct };
            record.judged = Judged { bump: Some(bump), glued: None, surface: None, ..record.judged };
        }
        Ok(record)
    }

    fn tables(&self, folder: &OutputFolder) -> Result<(), Error> {
        let header = ["depth_mm", "fitted_depth", "centred_pct", "disc_rms_pct", "disc_worst_pct", "uncalibrated_rms_pct"];
        let rows = self.judged.verdict.depths.iter().enumerate().map(|(n, after)| {
            let fitted = f64::from(u8::from(after.fitted_depth));
            [after.depth_mm, fitted, after.centred_pct, after.rms_pct, after.worst_pct, self.before(|v| v.depths[n].rms_pct)]
        });
        folder.write_csv("accuracy.csv", header, rows)?;
        let header = ["evaluations", "cost", "force_rms_pct", "dent_mean_mm", "elapsed_s"];
        let rows = self.fit.rounds.iter().map(|r| [r.evaluations as f64, r.cost, r.force_rms_pct, r.dent_mean_mm, r.elapsed_s]);
        Ok(folder.write_csv("convergence.csv", header, rows)?)
    }

    fn pictures(&self, folder: &OutputFolder) -> Result<(), Error> {
        let points: Vec<ConvergencePoint> = self
            .fit
            .rounds
            .iter()
            .map(|r| ConvergencePoint {
                evaluations: r.evaluations,
                force_rms_pct: r.force_rms_pct,
                dent_mean_mm: r.dent_mean_mm,
                elapsed_s: r.elapsed_s,
            })
            .collect();
        charts::convergence(folder.draft(), "convergence", &self.scene.name, &points)?;
        let e_pa = self.scene.tissue.youngs_modulus_pa;
        let force_n = |depth_m: f64| self.known.force(Vector3::zeros(), depth_m).unwrap_or(0.0) * e_pa;
        let ours: Vec<Sample> = self
            .judged
            .verdict
            .depths
            .iter()
            .enumerate()
            .map(|(n, d)| {
                let depth_m = d.depth_mm * 1e-3;
                Sample { t_s: n as f64, depth_m, force_n: force_n(depth_m) * (1.0 + 0.01 * d.centred_pct) }
            })
            .collect();
        let reference: Vec<(f64, f64)> = ours.iter().map(|s| (s.depth_m, force_n(s.depth_m))).collect();
        let press = Press {
            scene: &self.scene.name,
            node_count: self.judged.session.report.nodes,
            trace: &ours,
            holds: &[],
            reference: &reference,
        };
        charts::force_depth(folder.draft(), "force_depth", &press)?;
        Ok(())
    }

    /// A figure of the patch before the fit; not a number if it cannot run.
    fn before(&self, figure: impl Fn(&Verdict) -> f64) -> f64 {
        self.judged.before.as_ref().map_or(f64::NAN, figure)
    }

    fn print(&self, record: &FitRecord) {
        println!("\nforce error against finite elements, places unknown to the fit; * depths unknown too");
        println!("{:>10} {:>10} {:>11} {:>9} {:>14}", "depth mm", "centred %", "disc rms %", "worst %", "uncalibrated %");
        for (n, after) in self.judged.verdict.depths.iter().enumerate() {
            println!(
                "{:>9.3}{} {:>+10.2} {:>11.2} {:>+9.2} {:>14.2}",
                after.depth_mm,
                if after.fitted_depth { ' ' } else { '*' },
                after.centred_pct,
                after.rms_pct,
                after.worst_pct,
                self.before(|v| v.depths[n].rms_pct)
            );
        }
        let v = &self.judged.verdict;
        println!(
            "{} presses solved at unseen places and depths: {:.2} % rms, worst {:+.2} % (uncalibrated {:.2} and {:+.2} %)",
            v.unseen_presses,
            v.unseen_rms_pct,
            v.unseen_worst_pct,
            self.before(|v| v.unseen_rms_pct),
            self.before(|v| v.unseen_worst_pct)
        );
        println!(
            "{} random places within {:.1} mm at all depths: {:.2} % rms, worst {:+.2} %; the finite elements themselves within {:.2} %",
            v.disc_places,
            v.disc_radius_m * 1e3,
            v.disc_rms_pct,
            v.disc_worst_pct,
            100.0 * self.reference_error
        );
        let surface = |s: &SurfaceVerdict| {
            let unseen = if s.fitted_depth { "" } else { "*" };
            format!("{:.2}{unseen} mm deep {:.3} mm on average, {:.2} at most", s.depth_mm, s.mean_mm, s.most_mm)
        };
        if !v.surfaces.is_empty() {
            println!("surface off at its nodes: {}", v.surfaces.iter().map(surface).collect::<Vec<_>>().join("; "));
        }
        if let Some(glued) = &v.glued {
            let before = self.before(|v| v.glued.map_or(f64::NAN, |glued| glued.rms_pct));
            println!(
                "glued discs that the fit never saw, pressed and sheared: {:.2} % rms, worst {:+.2} % (uncalibrated {before:.2} % rms)",
                glued.rms_pct, glued.worst_pct
            );
        }
        if let Some(bump) = self.bump {
            bump.print();
        }
        if v.limited_presses > 0 {
            println!(
                "{} of {} presses are beyond the depth limit of the patch, where the force is continued",
                v.limited_presses, v.presses
            );
        }
        if v.lost_presses > 0 {
            println!("{} of {} presses could not be judged: the patch does not come to rest there", v.lost_presses, v.presses);
        }
        if let Some(moving) = &record.moving {
            println!(
                "moving at up to {:.0} mm/s: {:.1} % off in the worst motion tried ({})",
                moving.speed_m_per_s * 1e3,
                moving.rms_pct,
                moving.motion.as_deref().unwrap_or("ramp")
            );
        }
    }
}

/// Record of a patch file: what the patch was fitted to, and its errors.
pub(super) fn record(
    scene: &Scene,
    session: &Session,
    verdict: &Verdict,
    fitted_m: &[f64],
    patch: &[u8],
) -> Result<FitRecord, Error> {
    let patch_crc32 = checksum(patch)
        .ok_or_else(|| TissueError::Check("the stored fit is damaged: remove the output folder and fit again".into()))?;
    Ok(FitRecord {
        patch_crc32,
        scene: scene.name.clone(),
        nodes: session.report.nodes,
        tissue: tissue_of(scene),
        organ: OrganRecord::of(scene),
        probe: AnswerProbe { shape: scene.probe.shape, radius_m: scene.probe.radius_m },
        fitted_places: session.patch.fitted_places(),
        lost_fit_presses: 0,
        fitted_depths_m: fitted_m.to_vec(),
        judged: verdict.judged(),
        moving: session.report.moving.map(|m| Moving {
            speed_m_per_s: m.speed_m_per_s,
            rms_pct: m.rms_pct,
            motion: Some(m.motion.into()),
        }),
        reference_error_pct: None,
        quick: false,
    })
}
