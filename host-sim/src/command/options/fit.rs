//! Command line of `palpate fit`.

use std::path::PathBuf;

use clap::Args;
use palpate_tissue::Error as TissueError;
use palpate_tissue::budget::CostModel;
use serde::Serialize;

use super::pack::{DeviceArg, machine};
use crate::command::Common;
use crate::command::campaign::CaseArgs;
use crate::command::length::metres;
use crate::error::Error;

/// Allowed number of probe places; a fit to 20 places already over-fits.
const PLACES: std::ops::RangeInclusive<usize> = 20..=2000;

#[derive(Args, Clone, Debug)]
pub struct FitArgs {
    #[command(flatten)]
    pub common: Common,
    #[command(flatten)]
    pub options: FitOptions,
    /// Fit a piece with rim springs whose tick is within the budget of a board: m4f-168
    /// (Cortex-M4F, 168 MHz), m4f-170, m4f-180, m7-480 (Cortex-M7, 480 MHz), m7-400, m33-150 or
    /// desktop; nucleo-f446re, nucleo-g474re, nucleo-h743zi and pico2 select their own budget. With
    /// --scenes it may be given several times.
    #[arg(long, value_name = "BOARD")]
    pub board: Vec<String>,
    /// Instead, fit every scene (.toml) of a folder, for every board that is given, each into a
    /// folder of its own below --out, and collect the results in one table (fits.csv, summary.json,
    /// trials.json in --out/table). For a scene that cannot be fitted the row says why, and the
    /// exit code is 1.
    #[arg(long, value_name = "FOLDER", conflicts_with_all = ["scene", "changes"])]
    pub scenes: Option<PathBuf>,
    #[command(flatten)]
    pub cases: CaseArgs,
}

/// Options of a fit.
#[derive(Args, Clone, Debug, Serialize)]
pub struct FitOptions {
    /// Nodes of the patch [default: the scene's for a block, 100 for a piece, and with --board as
    /// many as it runs].
    #[arg(long, value_name = "COUNT")]
    pub nodes: Option<usize>,
    /// Fit a piece of this radius around the site, 1.25 to 4 probe radii (16mm, 1.6cm, 0.016),
    /// with rim springs for the rest [default: the whole for a block without --board, else 2.125
    /// probe radii].
    #[arg(long = "radius", alias = "radius-m", value_name = "LENGTH", value_parser = metres, allow_negative_numbers = true)]
    pub radius_m: Option<f64>,
    /// Edge length of the elements at the site of a piece, instead of --nodes.
    #[arg(long = "element", alias = "element-m", value_name = "LENGTH", value_parser = metres, allow_negative_numbers = true, conflicts_with = "nodes")]
    pub element_m: Option<f64>,
    /// Search for the smallest piece that keeps --tolerance-pct on the board: over radius, element
    /// size, foundation points, substeps and terms.
    #[arg(long, requires = "board", conflicts_with_all = ["nodes", "radius_m", "element_m", "places", "points"])]
    pub smallest: bool,
    /// Fit a law instead: the force over place, depth and speed, without nodes. It needs about 60
    /// operations a tick, and answers one tip on one site; friction, a nodule that moves, a contact
    /// map and a second tip need a patch.
    #[arg(long, conflicts_with_all = ["nodes", "radius_m", "element_m", "smallest", "places", "points"])]
    pub law: bool,
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
    /// single press may be off by 2.5 times as much. 20 with --quick.
    #[arg(
        long,
        value_name = "PERCENT",
        default_value_t = 2.0,
        default_value_if("quick", "true", "20"),
        allow_negative_numbers = true
    )]
    pub tolerance_pct: f64,
    /// Coarse finite elements and few rounds, and fewer candidates with --smallest, to try the
    /// command: do not rely on the patch.
    #[arg(long)]
    pub quick: bool,
    #[command(flatten)]
    #[serde(flatten)]
    pub device: DeviceArg,
}

/// Largest number of foundation points per triangle for which a board's image is built.
pub const MOST_POINTS: usize = 9;

impl FitArgs {
    /// Checks whatever needs no finite elements.
    pub fn check(&self) -> Result<(), Error> {
        self.options.check()?;
        let boards = self.boards()?;
        if self.options.points.is_some_and(|points| points > MOST_POINTS) && boards.iter().any(|board| board.is_board()) {
            let why = format!(
                "--points: the image of a board has room for {MOST_POINTS}: give --points {MOST_POINTS}, or leave it out"
            );
            return Err(TissueError::Usage(why).into());
        }
        if self.scenes.is_some() {
            return Ok(());
        }
        if self.cases.are_some() {
            let why = "--cases: one scene is fitted in one piece: leave it out, or give a folder of scenes with --scenes";
            return Err(TissueError::Usage(why.into()).into());
        }
        if self.board.len() > 1 {
            let boards = self.board.join(" --board ");
            let why = format!("--board {boards}: one scene is fitted for one board: give one, or --scenes");
            return Err(TissueError::Usage(why).into());
        }
        self.common.load().map(drop)
    }

    /// The budgets of the boards.
    pub fn boards(&self) -> Result<Vec<&'static CostModel>, Error> {
        boards(&self.board)
    }
}

/// The budgets of some boards.
pub fn boards(names: &[String]) -> Result<Vec<&'static CostModel>, Error> {
    let board = |(n, name): (usize, &String)| {
        if names[..n].contains(name) {
            return Err(TissueError::Usage(format!("--board {name}: given twice: give each board once")).into());
        }
        machine(name)
    };
    names.iter().enumerate().map(board).collect()
}

impl FitOptions {
    /// Checks the numbers, and the device.
    pub fn check(&self) -> Result<(), Error> {
        let refuse = |why: String| Err(TissueError::Usage(why).into());
        if let Some(places) = self.places.filter(|places| !PLACES.contains(places)) {
            return refuse(format!("--places {places}: take {} to {}", PLACES.start(), PLACES.end()));
        }
        if let Some(points) = self.points.filter(|points| ![4, 9, 16].contains(points)) {
            return refuse(format!("--points {points}: a triangle has 4, 9 or 16 points"));
        }
        let tolerance_pct = self.tolerance_pct;
        if !(tolerance_pct > 0.0 && tolerance_pct <= 100.0) {
            return refuse(format!("--tolerance-pct {tolerance_pct}: give a percentage above 0, at most 100"));
        }
        self.device.ceiling_n_per_m().map(drop)
    }
}
