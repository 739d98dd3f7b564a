//! Draws a matrix of the largest stable stiffness: one cell per column and row, orange below the
//! largest stiffness that the maker of the device names and blue above it.

use std::path::Path;

use plotters::drawing::DrawingAreaErrorKind;
use plotters::element::{PathElement, Rectangle};
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{Color, RGBColor, WHITE};

use super::canvas::Area;
use super::canvas::Drawn;
use super::layout::{MARGIN_PX, title};
use super::picture::{Picture, save};
use super::style::{INK, LABEL_PX, MUTED, TICK_PX, line, px, text};
use super::{ChartError, check};

/// Columns under a common heading.
#[derive(Clone, Debug)]
pub struct MatrixGroup {
    /// Heading above the columns of the group.
    pub name: String,
    /// Names of the columns, each with the largest stiffness that the maker of its device names
    /// [N/m].
    pub columns: Vec<(String, f64)>,
}

/// One cell of the matrix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MatrixCell {
    /// Largest stable stiffness [N/m].
    pub n_per_m: f64,
    /// Whether the stiffness is only a lower bound.
    pub at_least: bool,
}

/// One row of the matrix.
#[derive(Clone, Debug)]
pub struct MatrixRow {
    /// Name at the left of the row.
    pub name: String,
    /// One cell per column.
    pub cells: Vec<MatrixCell>,
    /// Whether the row is a closed form. Such a row is separated from the others, and adjacent
    /// cells with equal values are merged.
    pub closed: bool,
}

/// Data and labels of a matrix of stiffnesses.
#[derive(Clone, Copy, Debug)]
pub struct StiffnessMatrix<'a> {
    /// First line above the matrix.
    pub title: &'a str,
    /// Line below the title.
    pub caption: &'a str,
    /// Groups of columns from left to right.
    pub groups: &'a [MatrixGroup],
    /// Rows from top to bottom.
    pub rows: &'a [MatrixRow],
    /// Largest stiffness tried [N/m]; a cell that reaches it says `all`.
    pub stiffest_n_per_m: f64,
    /// Lines of text at the bottom.
    pub notes: &'a [String],
}

/// Writes `NAME.svg` and `NAME.png` into `folder`.
///
/// # Errors
/// Fails if there are no rows, if a row does not have one cell per column, if a value cannot be
/// drawn, or if the folder cannot be written.
pub fn stiffness_matrix(folder: &Path, name: &str, matrix: &StiffnessMatrix) -> Result<(), ChartError> {
    let columns: usize = matrix.groups.iter().map(|g| g.columns.len()).sum();
    if matrix.rows.is_empty() || columns == 0 {
        return Err(ChartError::Empty { what: "rows" });
    }
    for row in matrix.rows {
        check("cells", row.cells.iter().map(|c| c.n_per_m))?;
        if row.cells.len() != columns {
            return Err(ChartError::EmptySeries { series: row.name.clone() });
        }
    }
    save(folder, name, matrix)
}

/// Space left of the columns, above the rows and below them [px].
const LEFT_PX: f64 = 168.0;
const TOP_PX: f64 = 126.0;
const BELOW_PX: f64 = 66.0;
const NOTE_PX: f64 = 19.0;
const GROUP_GAP_PX: f64 = 10.0;
/// Half of the span of the colour scale [octaves].
const OCTAVES: f64 = 3.0;

/// Colour of a ratio to the named stiffness: orange below one and blue from one on; darker the
/// farther it is from one.
fn colour(ratio: f64) -> RGBColor {
    let share = (ratio.max(1e-3).log2().abs() / OCTAVES).min(1.0);
    let (pale, deep) = if ratio < 1.0 { ([252, 226, 205], [201, 84, 20]) } else { ([219, 233, 246], [28, 90, 152]) };
    let mix = |n: usize| (f64::from(pale[n]) + (f64::from(deep[n]) - f64::from(pale[n])) * share) as u8;
    RGBColor(mix(0), mix(1), mix(2))
}

/// Colour of text that is readable on the colour of `ratio`.
fn on(ratio: f64) -> RGBColor {
    if ratio.max(1e-3).log2().abs() / OCTAVES > 0.6 { WHITE } else { INK }
}

impl StiffnessMatrix<'_> {
    /// Left edges of the columns and their width [px].
    fn columns(&self, width_px: f64) -> (Vec<f64>, f64) {
        let count: usize = self.groups.iter().map(|g| g.columns.len()).sum();
        let gaps = (self.groups.len() - 1) as f64 * GROUP_GAP_PX;
        let each = (width_px - LEFT_PX - MARGIN_PX - gaps) / count as f64;
        let mut lefts = Vec::with_capacity(count);
        let mut left = LEFT_PX;
        for group in self.groups {
            for _ in &group.columns {
                lefts.push(left);
                left += each;
            }
            left += GROUP_GAP_PX;
        }
        (lefts, each)
    }

    fn says(&self, cell: MatrixCell) -> String {
        match cell.n_per_m {
            0.0 => "–".into(),
            k if k >= self.stiffest_n_per_m => "all".into(),
            k if cell.at_least => format!(">{k:.0}"),
            k => format!("{k:.0}"),
        }
    }

    fn heads<DB: DrawingBackend>(&self, area: &Area<DB>, lefts: &[f64], each: f64) -> Drawn<DB> {
        let center = (HPos::Center, VPos::Center);
        let mut first = 0;
        for group in self.groups {
            let (from, to) = (lefts[first], lefts[first + group.columns.len() - 1] + each);
            area.draw_text(&group.name, &text(LABEL_PX, INK, center), (px((from + to) * 0.5), px(TOP_PX - 34.0)))?;
            for (n, (name, _)) in group.columns.iter().enumerate() {
                let x = lefts[first + n] + each * 0.5;
                area.draw_text(name, &text(TICK_PX - 1.0, MUTED, center), (px(x), px(TOP_PX - 13.0)))?;
            }
            first += group.columns.len();
        }
        Ok(())
    }

    fn scale<DB: DrawingBackend>(&self, area: &Area<DB>, top: f64) -> Drawn<DB> {
        let ceilings: Vec<f64> = self.groups.iter().flat_map(|g| g.columns.iter().map(|c| c.1)).collect();
        let same = ceilings.windows(2).all(|w| w[0] == w[1]);
        let (left, width, steps) = (LEFT_PX, 330.0, 96);
        let at = |octave: f64| left + width * (octave + OCTAVES) / (2.0 * OCTAVES);
        for k in 0..steps {
            let octave = |k: i32| (f64::from(k) / f64::from(steps) * 2.0 - 1.0) * OCTAVES;
            let color = colour((octave(k) + 1e-9).exp2());
            area.draw(&Rectangle::new([(px(at(octave(k))), px(top)), (px(at(octave(k + 1))), px(top + 13.0))], color.filled()))?;
        }
        area.draw(&PathElement::new([(px(at(0.0)), px(top - 4.0)), (px(at(0.0)), px(top + 17.0))], line(INK, 1.6)))?;
        for octave in -3..=3 {
            let ratio = f64::from(octave).exp2();
            let label = if same { format!("{:.0}", ceilings[0] * ratio) } else { format!("x{ratio}") };
            let style = text(TICK_PX - 2.0, MUTED, (HPos::Center, VPos::Top));
            area.draw_text(&label, &style, (px(at(f64::from(octave))), px(top + 18.0)))?;
        }
        let what = if same { "N/m; line: stiffness that its maker names" } else { "of what its maker names (line)" };
        area.draw_text(what, &text(TICK_PX - 1.0, MUTED, (HPos::Left, VPos::Center)), (px(left + width + 16.0), px(top + 6.0)))
    }

    fn row<DB: DrawingBackend>(&self, area: &Area<DB>, row: &MatrixRow, lefts: &[f64], each: f64, span: (f64, f64)) -> Drawn<DB> {
        let (top, bottom) = span;
        let middle = px((top + bottom) * 0.5);
        let label = text(TICK_PX, if row.closed { MUTED } else { INK }, (HPos::Right, VPos::Center));
        area.draw_text(&row.name, &label, (px(LEFT_PX - 10.0), middle))?;
        let mut first = 0;
        for group in self.groups {
            let mut n = 0;
            while n < group.columns.len() {
                let value = row.cells[first + n];
                let run = if row.closed {
                    row.cells[first + n..first + group.columns.len()].iter().take_while(|v| **v == value).count()
                } else {
                    1
                };
                let ratio = value.n_per_m / group.columns[n].1;
                let (left, right) = (lefts[first + n], lefts[first + n + run - 1] + each);
                let corners = [(px(left + 0.75), px(top + 0.75)), (px(right - 0.75), px(bottom - 0.75))];
                area.draw(&Rectangle::new(corners, colour(ratio).filled()))?;
                let style = text(TICK_PX - 1.5, on(ratio), (HPos::Center, VPos::Center));
                area.draw_text(&self.says(value), &style, (px((left + right) * 0.5), middle))?;
                n += run;
            }
            first += group.columns.len();
        }
        Ok(())
    }
}

impl Picture for StiffnessMatrix<'_> {
    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Result<(), DrawingAreaErrorKind<DB::ErrorType>> {
        title(area, self.title, self.caption)?;
        let (width, height) = area.dim_in_pixel();
        let in_px = |units: u32| f64::from(units) / f64::from(super::style::FINE);
        let (width_px, height_px) = (in_px(width), in_px(height));
        let (lefts, each) = self.columns(width_px);
        self.heads(area, &lefts, each)?;
        let bottom = height_px - BELOW_PX - NOTE_PX * self.notes.len() as f64;
        // the rows of closed forms are separated by 0.4 of a row
        let closed = self.rows.iter().any(|r| r.closed);
        let step = (bottom - TOP_PX) / (self.rows.len() as f64 + if closed { 0.4 } else { 0.0 });
        for (n, row) in self.rows.iter().enumerate() {
            let top = TOP_PX + step * (n as f64 + if row.closed { 0.4 } else { 0.0 });
            self.row(area, row, &lefts, each, (top, top + step))?;
        }
        self.scale(area, bottom + 16.0)?;
        for (n, note) in self.notes.iter().enumerate() {
            let y = bottom + BELOW_PX - 14.0 + NOTE_PX * n as f64;
            area.draw_text(note, &text(TICK_PX - 1.0, MUTED, (HPos::Left, VPos::Top)), (px(MARGIN_PX), px(y)))?;
        }
        Ok(())
    }
}
