//! Command line of `palpate fit`.

use std::path::PathBuf;

use clap::Args;
use palpate_tissue::Error as TissueError;
use serde::{Deserialize, Serialize};

use crate::command::Common;
use crate::command::campaign::Shards;
use crate::command::length::metres;
use crate::error::Error;

/// Range of the number of probe places.
const PLACES: std::ops::RangeInclusive<usize> = 20..=2000;

#[derive(Args, Clone, Debug)]
pub struct FitArgs {
    #[command(flatten)]
    pub common: Common,
    #[command(flatten)]
    pub options: FitOptions,
    /// Instead, fit every scene (.toml) of a folder, each into a folder of its own below --out, and
    /// collect the results in one table (fits.csv, summary.json, trials.json in --out/table). For a
    /// scene that cannot be fitted the row says why, and the exit code is 1.
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["scene", "changes"])]
    pub scenes: Option<PathBuf>,
    #[command(flatten)]
    pub shards: Shards,
}

/// Options of a fit.
#[derive(Args, Clone, Debug, Serialize, Deserialize)]
pub struct FitOptions {
    /// Nodes of the patch [default: the scene's for a block, 100 for a piece of an organ].
    #[arg(long, value_name = "COUNT")]
    pub nodes: Option<usize>,
    /// Radius of the patch around the site, for an organ or a mesh (16mm, 1.6cm, 0.016) [default:
    /// 2.125 probe radii].
    #[arg(long = "radius", alias = "radius-m", value_name = "LENGTH", value_parser = metres, allow_negative_numbers = true)]
    pub radius_m: Option<f64>,
    /// Places of the probe to fit, besides the centre [default: 33 000 divided by the nodes, within
    /// 80 to 250].
    #[arg(long, value_name = "COUNT")]
    pub places: Option<usize>,
    /// Foundation points per surface triangle: 4, 9 or 16 [default: for a block 16 where elements
    /// are larger than 1.85 radii of the shallowest contact; else 9 where they are larger than 0.4
    /// of the probe's radius, else 4]. No board supports 16.
    #[arg(long, value_name = "COUNT")]
    pub points: Option<usize>,
    /// Largest force error, at places and depths that the fit never saw [%]: root mean square; a
    /// single press may be off by 2.5 times as much.
    #[arg(long, value_name = "PERCENT", default_value_t = 2.0, allow_negative_numbers = true)]
    pub tolerance_pct: f64,
    /// Coarse finite elements and few rounds, to try the command: do not rely on the patch.
    #[arg(long)]
    pub quick: bool,
}

impl FitArgs {
    /// Checks whatever needs no finite elements.
    ///
    /// # Errors
    /// The scene, or an option, cannot be used.
    pub fn check(&self) -> Result<(), Error> {
        if self.scenes.is_none() {
            if self.shards.any() {
                let why = "--shard: one scene is fitted in one piece: leave it out, or give a folder of scenes with --scenes";
                return Err(TissueError::Usage(why.into()).into());
            }
            self.common.load()?;
        }
        self.options.check()
    }
}

impl FitOptions {
    /// Checks the numbers.
    ///
    /// # Errors
    /// A number is out of its range.
    pub fn check(&self) -> Result<(), Error> {
        self.places.map(check_places).transpose()?;
        if let Some(points) = self.points.filter(|points| ![4, 9, 16].contains(points)) {
            return Err(TissueError::Usage(format!("--points {points}: a triangle has 4, 9 or 16 points")).into());
        }
        check_tolerance(self.tolerance_pct)
    }
}

/// Checks the number of probe places.
pub(super) fn check_places(places: usize) -> Result<(), Error> {
    if PLACES.contains(&places) {
        return Ok(());
    }
    let why = format!("--places {places}: take {} to {}", PLACES.start(), PLACES.end());
    Err(TissueError::Usage(why).into())
}

/// Checks a tolerance [%].
pub(super) fn check_tolerance(tolerance_pct: f64) -> Result<(), Error> {
    if tolerance_pct > 0.0 && tolerance_pct <= 100.0 {
        return Ok(());
    }
    Err(TissueError::Usage(format!("--tolerance-pct {tolerance_pct}: give a percentage above 0, at most 100")).into())
}
