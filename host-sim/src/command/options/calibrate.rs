//! Command line of `palpate calibrate`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::command::Common;
use crate::error::Error;

/// Places of the probe to fit, if no number is given.
const PLACES: usize = 80;

#[derive(Args, Clone, Debug)]
pub struct CalibrateArgs {
    #[command(flatten)]
    pub common: Common,
    /// Nodes of the mesh [default: the scene's].
    #[arg(long, value_name = "COUNT")]
    pub nodes: Option<usize>,
    /// Places of the probe to fit, besides the centre.
    #[arg(long, value_name = "COUNT", default_value_t = PLACES)]
    pub places: usize,
    /// Largest number of rounds of the fit (of evaluations of the objective, for annealing).
    #[arg(long, value_name = "COUNT")]
    pub rounds: Option<usize>,
    /// Foundation points per surface triangle: 4, 9 or 16 [default: 9 where elements are larger
    /// than 0.4 of the probe's radius, else 4]. No board supports 16.
    #[arg(long, value_name = "COUNT")]
    pub points: Option<usize>,
    /// Method of the fit; annealing minimises the same objective and is there for comparison.
    #[arg(long, value_enum, default_value_t = FitName::GaussNewton)]
    pub fit: FitName,
    /// Finite-element answer for the fit, answer.json of `palpate reference` [default: the one that
    /// ships].
    #[arg(long, value_name = "FILE")]
    pub reference: Option<PathBuf>,
    /// Fit the answer's glued discs too, pressed and sheared.
    #[arg(long, conflicts_with = "check")]
    pub glued: bool,
    /// Fit nothing: press the patches that ship, or the scene's own, at depths and places that the
    /// fit did not see.
    #[arg(long)]
    pub check: bool,
    /// A small fit: 130 nodes over 40 places, 4 s of processor time.
    #[arg(long, conflicts_with_all = ["nodes", "check", "places", "rounds"])]
    pub quick: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum FitName {
    /// Gauss-Newton with adjoint gradients, with which the shipped patches were fitted.
    GaussNewton,
    /// Simulated annealing of two scalars, the schedule of paper 004.
    Annealing,
}

impl CalibrateArgs {
    /// Checks whatever needs no fit.
    ///
    /// # Errors
    /// The scene cannot be read.
    pub fn check(&self) -> Result<(), Error> {
        self.common.load().map(drop)
    }
}
