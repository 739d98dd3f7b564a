//! Command line of `palpate cut`.

use clap::Args;

use super::fit::check_places;
use super::pack::{BoardArg, check_board};
use crate::command::Common;
use crate::command::length::metres;
use crate::error::Error;

#[derive(Args, Clone, Debug)]
pub struct CutArgs {
    #[command(flatten)]
    pub common: Common,
    #[command(flatten)]
    pub board: BoardArg,
    /// Radius of the patch around the site (16mm, 1.6cm, 0.016), 1.5 to 2.5 probe radii; rim
    /// springs replace the rest of the organ.
    #[arg(long = "radius", alias = "radius-m", value_name = "LENGTH", value_parser = metres, allow_negative_numbers = true)]
    pub radius_m: f64,
    /// Edge length of the elements at the site [default: the smallest that fits the board].
    #[arg(long = "element", alias = "element-m", value_name = "LENGTH", value_parser = metres, allow_negative_numbers = true)]
    pub element_m: Option<f64>,
    /// Stroke of the probe along x and y, centred on the site: the patch is lengthened for it. Only
    /// for the default block.
    #[arg(long = "stroke", alias = "stroke-m", value_names = ["X", "Y"], value_delimiter = ',', num_args = 2, value_parser = metres, allow_negative_numbers = true)]
    pub stroke_m: Option<Vec<f64>>,
    /// Number of places to calibrate over, 20 to 2000.
    #[arg(long, value_name = "COUNT", default_value_t = 100)]
    pub places: usize,
}

impl CutArgs {
    /// Checks whatever needs no finite elements.
    ///
    /// # Errors
    /// The board, the device, the scene or the number of places cannot be used.
    pub fn check(&self) -> Result<(), Error> {
        check_board(&self.common, &self.board)?;
        check_places(self.places)
    }
}
