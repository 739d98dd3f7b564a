//! `palpate fit`: from a scene to a calibrated patch with a judged error.

mod added_force;
mod block;
mod bump;
mod organ;
mod report;
mod stages;
mod store;
mod trials;

use std::path::PathBuf;

use clap::Args;

use super::{Common, print_warnings};
use crate::error::Error;
use palpate_fit::calibrate::{Fit, Settings};
use palpate_fit::plan::WORST_RATIO;
use palpate_fit::scene_fit::{PLACES_RANGE, Verdict, check};
use palpate_tissue::Error as TissueError;
use palpate_tissue::scene::{NO_PATCH, Scene};

/// Most nodes that a block is meshed with.
const MOST_NODES: f64 = 5000.0;
/// Places if none are given: patches of few nodes are fitted sooner and gain more by another place.
const PLACES_TIMES_NODES: usize = 33_000;
const PLACES: std::ops::RangeInclusive<usize> = 80..=250;
/// Most rounds of a fit: later ones gain little. With `--quick`.
const ROUNDS: usize = 10;
const QUICK_ROUNDS: usize = 3;
/// A round that gains less than this share of the objective is the last: five more would bring the
/// force error of 410 nodes from 0.88 to 0.84 %.
const LEAST_GAIN: f64 = 0.03;

#[derive(Args, Clone, Debug)]
pub(super) struct FitArgs {
    #[command(flatten)]
    common: Common,
    /// Nodes of the patch [default: the scene's of a block, 100 of a piece of an organ].
    #[arg(long, value_name = "COUNT")]
    nodes: Option<usize>,
    /// Of an organ or a mesh, the patch holds what lies within this of the site [m] [default: 2.125
    /// probe radii].
    #[arg(long, value_name = "METRES", allow_negative_numbers = true)]
    radius_m: Option<f64>,
    /// Places of the probe to fit over, beside the centre [default: 33 000 over the nodes, 80 to
    /// 250: the fewer nodes, the more].
    #[arg(long, value_name = "COUNT")]
    places: Option<usize>,
    /// Force error that is asked for, at places and depths that the fit never saw [%]: root mean
    /// square; a single press may be 2.5 times as far off.
    #[arg(long, value_name = "PERCENT", default_value_t = 2.0, allow_negative_numbers = true)]
    tolerance_pct: f64,
    /// Coarse finite elements and few rounds: a trial of the command, not a patch to rely on.
    #[arg(long)]
    quick: bool,
    /// Fit every scene of a folder, and put their trials together: the table that ships.
    #[arg(long, hide = true, value_name = "FOLDER", conflicts_with = "scene")]
    trials: Option<PathBuf>,
}

impl FitArgs {
    pub(super) fn run(&self) -> Result<(), Error> {
        match &self.trials {
            Some(scenes) => trials::run(self, scenes),
            None => self.fit_scene(),
        }
    }

    fn fit_scene(&self) -> Result<(), Error> {
        let scene = self.scene()?;
        match scene.tissue.block_m {
            Some(size_m) => self.fit_block(&scene, size_m),
            None => self.fit_organ(&scene),
        }
    }

    fn print_scene(&self, scene: &Scene, nodes: usize, fitted_m: &[f64]) {
        println!(
            "scene {}: {nodes} nodes, nu {}, {}, {:.2} to {:.2} mm deep",
            scene.name,
            scene.tissue.poisson_ratio,
            scene.probe.tip(),
            fitted_m.first().unwrap_or(&f64::NAN) * 1e3,
            fitted_m.last().unwrap_or(&f64::NAN) * 1e3,
        );
        print_warnings(scene);
    }

    /// The scene, if it can be fitted.
    fn scene(&self) -> Result<Scene, Error> {
        let mut scene = Scene::load(&self.common.scene)?;
        if let Some(places) = self.places.filter(|places| !PLACES_RANGE.contains(places)) {
            let (first, last) = (PLACES_RANGE.start(), PLACES_RANGE.end());
            return Err(TissueError::Usage(format!("--places {places}: take {first} to {last}")).into());
        }
        if !(self.tolerance_pct > 0.0 && self.tolerance_pct <= 100.0) {
            let why = format!("--tolerance-pct {}: give a percentage above 0, at most 100", self.tolerance_pct);
            return Err(TissueError::Usage(why).into());
        }
        check(&scene)?;
        // the scene may already name the patch that is about to be fitted
        scene.solver.patch = Some(NO_PATCH.into());
        scene.tissue.nodes = self.nodes.or(scene.tissue.nodes);
        Ok(scene)
    }

    /// How long a patch of so many nodes is fitted.
    fn settings(&self, nodes: usize, least_gain: f64) -> Settings {
        let rounds = if self.quick { QUICK_ROUNDS } else { ROUNDS };
        let places = self.places.unwrap_or((PLACES_TIMES_NODES / nodes.max(1)).clamp(*PLACES.start(), *PLACES.end()));
        Settings { places, rounds, least_gain, fit: Fit::GaussNewton }
    }

    /// Holds the verdict against the error that was asked for; where it misses, says what would do.
    fn promise(&self, nodes: usize, verdict: &Verdict) -> Result<(), Error> {
        let (asked, rms, worst) = (self.tolerance_pct, verdict.rms_pct(), verdict.worst_pct());
        let keeps = rms.max(worst.abs() / WORST_RATIO);
        if keeps <= asked {
            return Ok(());
        }
        // the error falls about with the root of the node count
        let would_do = match nodes as f64 * (keeps / asked).powi(2) {
            n if n > MOST_NODES => "more nodes than a block is meshed with would (an estimate): ask for".to_owned(),
            n => format!("try --nodes {:.0} (an estimate), or", (n / 10.0).ceil() * 10.0),
        };
        Err(TissueError::Check(format!(
            "{rms:.2} % rms and {worst:+.2} % at the worst unseen press, {asked} % rms and {:.1} % were asked for; all is written: {would_do} --tolerance-pct {:.1}",
            WORST_RATIO * asked,
            (keeps * 10.0).ceil() / 10.0
        ))
        .into())
    }
}
