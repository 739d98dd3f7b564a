//! A picture as a specification: lines, scatter, bars or heat, with its name and heading.

use std::path::Path;

use super::ChartError;
use super::bars::Bars;
use super::heat::Heat;
use super::plot::{Plot, save_plots};

/// A picture of one of the four forms.
#[derive(Clone, Debug)]
pub struct Figure {
    /// File name without its extension.
    pub name: String,
    /// First line above the picture.
    pub title: String,
    /// Second line above the picture.
    pub below: String,
    /// Data and labels.
    pub form: Form,
}

/// Form of a picture.
#[derive(Clone, Debug)]
pub enum Form {
    /// Curves and points over one pair of axes: lines and scatter.
    Plot(Plot),
    /// Several of them, one above the other.
    Panels(Vec<Plot>),
    /// Horizontal bars.
    Bars(Bars),
    /// A table of coloured cells.
    Heat(Heat),
}

impl Figure {
    /// A picture of curves and points.
    pub fn plot(name: impl Into<String>, title: impl Into<String>, below: impl Into<String>, plot: Plot) -> Self {
        Self { name: name.into(), title: title.into(), below: below.into(), form: Form::Plot(plot) }
    }

    /// Writes `NAME.svg` and `NAME.png` into `folder`.
    pub fn draw(&self, folder: &Path) -> Result<(), ChartError> {
        let title = [self.title.as_str(), self.below.as_str()];
        match &self.form {
            Form::Plot(plot) => save_plots(std::slice::from_ref(plot), folder, &self.name, title),
            Form::Panels(plots) => save_plots(plots, folder, &self.name, title),
            Form::Bars(bars) => bars.save(folder, &self.name, title),
            Form::Heat(heat) => heat.save(folder, &self.name, title),
        }
    }
}
