//! Draws the pictures of every command, each written as `NAME.svg` and `NAME.png` in the same
//! style.
//!
//! ```text
//! numbers ─ one file per picture ─ layout, style ─ canvas ─ picture ─┬─ NAME.svg
//!                                                             raster ┴─ NAME.png
//! ```
//!
//! One drawing routine serves both formats, and the font is compiled in, so that a machine without
//! fonts or a display produces the same pictures. Input is in SI units; millimetres appear only in
//! the pictures.

mod axis;
mod bars;
mod canvas;
mod contact;
mod convergence;
mod decimate;
mod figure;
mod heat;
mod key_column;
mod layout;
mod marker;
mod picture;
mod place;
mod plot;
mod press;
mod raster;
mod section;
mod style;
mod superposed;
mod surface;
mod tick_time;

pub use bars::{Bar, Bars};
pub use contact::{Contact, contact};
pub use convergence::{ConvergencePoint, convergence};
pub use figure::{Figure, Form};
pub use heat::{Heat, HeatCell, HeatGroup, HeatRow, Tone};
pub use marker::radius_px;
pub use plot::{Dot, Level, Plot, Scale, ScaledAxis, Series};
pub use press::{force_depth, force_time};
pub use section::{Moment, Section, section};
pub use superposed::{Landmark, Layer, Look, Superposed, superposed};
pub use surface::{Probe, ProbeShape, Surface, surface};
pub use tick_time::{TickTimes, tick_time};

use std::path::PathBuf;

use axis::Unit;

/// A press run in the form in which the charts read it.
#[derive(Clone, Copy, Debug)]
pub struct Press<'a> {
    /// Name of the scene, with which every title begins.
    pub scene: &'a str,
    /// Number of nodes of the patch that was pressed.
    pub node_count: usize,
    /// Samples of the run in time order, one per tick.
    pub trace: &'a [Sample],
    /// Last sample of each hold, in time order; may be empty.
    pub holds: &'a [Sample],
    /// Answer of the finite elements as (depth [m], force [N]); may be empty.
    pub reference: &'a [(f64, f64)],
}

/// One instant of a press run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Time since the run began [s].
    pub t_s: f64,
    /// Travel of the probe beyond first contact [m]; negative before the probe touches.
    pub depth_m: f64,
    /// Force on the probe along its handle [N]; positive pushes the probe out of the tissue.
    pub force_n: f64,
}

/// Reason why a picture was not written. In each of these cases no file is left in the folder.
#[derive(Debug, thiserror::Error)]
pub enum ChartError {
    /// There is no data to draw.
    #[error("{what} is empty: run at least one tick before drawing it")]
    Empty {
        /// The list that was empty.
        what: &'static str,
    },
    /// A value is NaN, infinite, or larger than any value of a tissue experiment.
    #[error("{what}[{index}] is {value}, which cannot be drawn: cut the run before it, or find why it diverged")]
    NotDrawable {
        /// The list that holds the value.
        what: &'static str,
        /// Index in the list.
        index: usize,
        /// The value found.
        value: f64,
    },
    /// A named series has no values.
    #[error("series \"{series}\" has no values: leave it out, or find why nothing was measured")]
    EmptySeries {
        /// Name of the series.
        series: String,
    },
    /// A value of a named series lies outside the domain of the axes.
    #[error("series \"{series}\": {what}[{index}] is {value}, which cannot be drawn: {fix}")]
    InSeries {
        /// Name of the series.
        series: String,
        /// The list that holds the value.
        what: &'static str,
        /// Index in the list.
        index: usize,
        /// The value found.
        value: f64,
        /// Remedy to suggest.
        fix: &'static str,
    },
    /// A surface triangle or a tet names a node that does not exist.
    #[error("{what}[{item}] names node {node}, but there are {node_count} nodes: take it from the mesh that the nodes belong to")]
    NoSuchNode {
        /// The list that names the node.
        what: &'static str,
        /// Index of the triangle or tet.
        item: usize,
        /// The node that the list names.
        node: u32,
        /// Number of nodes for which both a rest position and a deformed position are known.
        node_count: usize,
    },
    /// The file system refused to write the picture.
    #[error("cannot write {}: {source}; choose a folder that exists and that you may write to", path.display())]
    Write {
        /// The picture that was to be written.
        path: PathBuf,
        /// Error that the system returned.
        source: std::io::Error,
    },
    /// The plotting library refused to draw the picture.
    #[error("cannot draw {}: {message}; the data is saved beside it as CSV", path.display())]
    Draw {
        /// The picture that was to be drawn.
        path: PathBuf,
        /// Message of the plotting library.
        message: String,
    },
}

/// Largest magnitude that is drawn. Above it the plotting library's search for ticks runs out of
/// digits; no SI value in these charts comes near it.
const LARGEST_DRAWABLE: f64 = 1e12;

fn check(what: &'static str, values: impl IntoIterator<Item = f64>) -> Result<(), ChartError> {
    for (index, value) in values.into_iter().enumerate() {
        if !value.is_finite() || value.abs() > LARGEST_DRAWABLE {
            return Err(ChartError::NotDrawable { what, index, value });
        }
    }
    Ok(())
}

/// Checks one series of several like [`check`]; `positive` also rejects values that a logarithmic
/// axis cannot show.
fn check_series(
    series: &str,
    what: &'static str,
    values: impl IntoIterator<Item = f64>,
    positive: bool,
) -> Result<(), ChartError> {
    for (index, value) in values.into_iter().enumerate() {
        let drawable = value.is_finite() && value.abs() <= LARGEST_DRAWABLE;
        if !drawable || positive && value <= 0.0 {
            let fix =
                if drawable { "a logarithmic axis has room above zero only" } else { "leave it out, or find why it diverged" };
            return Err(ChartError::InSeries { series: series.to_owned(), what, index, value, fix });
        }
    }
    Ok(())
}

impl Press<'_> {
    /// Line below the title: number of nodes, largest depth and largest force.
    fn summary(&self, length: Unit, force: Unit) -> String {
        let most = |of: fn(&Sample) -> f64| {
            let all = self.trace.iter().map(of);
            all.fold(f64::NEG_INFINITY, f64::max)
        };
        format!(
            "{} nodes, deepest {}, largest force {}",
            self.node_count,
            length.say(most(|s| s.depth_m)),
            force.say(most(|s| s.force_n)),
        )
    }

    fn check(&self) -> Result<(), ChartError> {
        if self.trace.is_empty() {
            return Err(ChartError::Empty { what: "trace" });
        }
        check("trace t_s", self.trace.iter().map(|s| s.t_s))?;
        check("trace depth_m", self.trace.iter().map(|s| s.depth_m))?;
        check("trace force_n", self.trace.iter().map(|s| s.force_n))?;
        check("holds t_s", self.holds.iter().map(|s| s.t_s))?;
        check("holds depth_m", self.holds.iter().map(|s| s.depth_m))?;
        check("holds force_n", self.holds.iter().map(|s| s.force_n))?;
        check("reference depth_m", self.reference.iter().map(|r| r.0))?;
        check("reference force_n", self.reference.iter().map(|r| r.1))
    }
}
