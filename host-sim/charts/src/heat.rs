//! Draws a table for a quick overview: a coloured cell with a sign for every row and column. The
//! columns are divided into groups.
//!
//! The tones differ in lightness as well as in hue, and every cell contains its sign, so that the
//! picture remains readable in greyscale.

use std::path::Path;

use plotters::element::Rectangle;
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{Color, RGBColor, WHITE};

use super::ChartError;
use super::canvas::Area;
use super::canvas::Drawn;
use super::layout::{MARGIN_PX, TITLE_HEIGHT_PX, cut, title, width};
use super::picture::{Picture, save};
use super::style::{INK, MUTED, TICK_PX, px, text};

/// Rating of a cell from good to bad, which sets its colour: a worse fault is darker. `Empty` is
/// not a rating.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tone {
    /// The value is as required.
    Good,
    /// A second good outcome, drawn in another colour.
    Calm,
    /// The value just meets the requirement.
    Thin,
    /// A small fault.
    Slight,
    /// A fault between small and large.
    Fault,
    /// A large fault.
    Serious,
    /// A still larger fault.
    Severe,
    /// The value misses the requirement.
    Failure,
    /// The worst outcome, such as a run that diverged.
    Lost,
    /// Nothing was measured here.
    Empty,
    /// Ratio to what is wanted: orange below one, blue from one on, darker the farther from one.
    Ratio(f64),
}

impl Tone {
    /// Cell with this rating and this text.
    pub fn cell(self, sign: impl Into<String>) -> HeatCell {
        HeatCell { tone: self, sign: sign.into() }
    }
}

/// One cell of the matrix.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatCell {
    /// Rating that sets the colour of the cell.
    pub tone: Tone,
    /// Text drawn in the cell.
    pub sign: String,
}

/// Adjacent columns under a common heading.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatGroup {
    /// Two lines of heading above the columns.
    pub label: [String; 2],
    /// Text below each column, one per column; empty where a column has none.
    pub feet: Vec<String>,
}

/// One row of the matrix.
#[derive(Clone, Debug, PartialEq)]
pub struct HeatRow {
    /// Name at the left of the row.
    pub name: String,
    /// Whether a gap separates the row from the one above.
    pub apart: bool,
    /// One cell per column, over all groups.
    pub cells: Vec<HeatCell>,
}

/// A table of coloured cells.
#[derive(Clone, Debug)]
pub struct Heat {
    /// Groups of columns from left to right.
    pub groups: Vec<HeatGroup>,
    /// Rows from top to bottom.
    pub rows: Vec<HeatRow>,
    /// Entries of the key: a cell and its meaning.
    pub key: Vec<(HeatCell, String)>,
    /// Label to the left of the texts below the columns.
    pub foot: String,
}

/// Space for the names of the rows, between groups, and for the lines around the matrix [px].
const NAMES_PX: f64 = 236.0;
const GAP_PX: f64 = 7.0;
const HEAD_PX: f64 = 40.0;
const FEET_PX: f64 = 22.0;
const KEY_PX: f64 = 46.0;
const KEY_LINE_PX: f64 = 21.0;
/// Text size in cells and below the columns [px].
const SIGN_PX: f64 = 11.5;
const FOOT_PX: f64 = 10.0;
/// Maximum height of a row [px].
const HIGHEST_PX: f64 = 40.0;

impl Heat {
    pub(super) fn save(&self, folder: &Path, name: &str, title: [&str; 2]) -> Result<(), ChartError> {
        let columns: usize = self.groups.iter().map(|g| g.feet.len()).sum();
        if columns == 0 || self.rows.is_empty() {
            return Err(ChartError::Empty { what: "rows" });
        }
        if let Some(row) = self.rows.iter().find(|row| row.cells.len() != columns) {
            return Err(ChartError::EmptySeries { series: row.name.clone() });
        }
        save(folder, name, &Drawing { matrix: self, title, columns })
    }
}

struct Drawing<'a> {
    matrix: &'a Heat,
    title: [&'a str; 2],
    columns: usize,
}

/// Half of the span of the colours of ratios [octaves].
const OCTAVES: f64 = 3.0;

/// Colour of a ratio, and colour of the text on it.
fn shade(ratio: f64) -> (RGBColor, RGBColor) {
    let share = (ratio.max(1e-3).log2().abs() / OCTAVES).min(1.0);
    let (pale, deep) = if ratio < 1.0 { ([252, 226, 205], [201, 84, 20]) } else { ([219, 233, 246], [28, 90, 152]) };
    let mix = |n: usize| (f64::from(pale[n]) + (f64::from(deep[n]) - f64::from(pale[n])) * share) as u8;
    (RGBColor(mix(0), mix(1), mix(2)), if share > 0.6 { WHITE } else { INK })
}

/// Fill colour of a cell and colour of the text on it.
fn colors(tone: Tone) -> (RGBColor, RGBColor) {
    match tone {
        Tone::Good => (RGBColor(0xa8, 0xdb, 0xc5), INK),
        Tone::Calm => (RGBColor(0x8d, 0xbd, 0xe6), INK),
        Tone::Thin => (RGBColor(0xdd, 0xe9, 0xa4), INK),
        Tone::Slight => (RGBColor(0xf7, 0xe3, 0x8c), INK),
        Tone::Fault => (RGBColor(0xf0, 0xac, 0x4e), INK),
        Tone::Serious => (RGBColor(0xdb, 0x73, 0x2f), WHITE),
        Tone::Severe => (RGBColor(0x8a, 0x5a, 0xb8), WHITE),
        Tone::Failure => (RGBColor(0xad, 0x2b, 0x32), WHITE),
        Tone::Lost => (RGBColor(0x2b, 0x2b, 0x33), WHITE),
        Tone::Empty => (RGBColor(0xf1, 0xf2, 0xf4), MUTED),
        Tone::Ratio(ratio) => shade(ratio),
    }
}

impl Picture for Drawing<'_> {
    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Drawn<DB> {
        let matrix = self.matrix;
        title(area, self.title[0], self.title[1])?;
        let (wide, high) = area.dim_in_pixel();
        let (wide, high) = (f64::from(wide) / f64::from(px(1.0)), f64::from(high) / f64::from(px(1.0)));
        let left = MARGIN_PX + NAMES_PX;
        let top = TITLE_HEIGHT_PX + HEAD_PX;
        let gaps = GAP_PX * (matrix.groups.len() - 1) as f64;
        let cell_wide = (wide - MARGIN_PX - left - gaps) / self.columns as f64;
        let apart = GAP_PX * matrix.rows.iter().skip(1).filter(|r| r.apart).count() as f64;
        let cell_high = ((high - top - FEET_PX - KEY_PX - apart) / matrix.rows.len() as f64).min(HIGHEST_PX);

        let centered = |size, color| text(size, color, (HPos::Center, VPos::Center));
        let mut x = left;
        let mut starts = Vec::with_capacity(self.columns);
        let bottom = top + apart + cell_high * matrix.rows.len() as f64;
        for group in &matrix.groups {
            let middle = x + cell_wide * group.feet.len() as f64 / 2.0;
            for (line, y) in group.label.iter().zip([top - 29.0, top - 12.0]) {
                area.draw_text(line, &centered(TICK_PX - 1.0, INK), (px(middle), px(y)))?;
            }
            for foot in &group.feet {
                area.draw_text(foot, &centered(FOOT_PX, MUTED), (px(x + cell_wide / 2.0), px(bottom + 10.0)))?;
                starts.push(x);
                x += cell_wide;
            }
            x += GAP_PX;
        }
        let to_the_right = |size, color| text(size, color, (HPos::Right, VPos::Center));
        area.draw_text(&matrix.foot, &to_the_right(FOOT_PX + 1.0, MUTED), (px(left - 10.0), px(bottom + 10.0)))?;

        let mut y = top;
        for (n, row) in matrix.rows.iter().enumerate() {
            if row.apart && n > 0 {
                y += GAP_PX;
            }
            let style = to_the_right(TICK_PX, INK);
            let name = cut(area, &row.name, &style, px(NAMES_PX - 10.0))?;
            area.draw_text(&name, &style, (px(left - 10.0), px(y + cell_high / 2.0)))?;
            for (cell, x) in row.cells.iter().zip(&starts) {
                self.cell(area, cell, [*x, y], [cell_wide, cell_high])?;
            }
            y += cell_high;
        }
        self.key(area, high - KEY_PX / 2.0)
    }
}

impl Drawing<'_> {
    fn cell<DB: DrawingBackend>(&self, area: &Area<DB>, cell: &HeatCell, [x, y]: [f64; 2], [wide, high]: [f64; 2]) -> Drawn<DB> {
        let (fill, ink) = colors(cell.tone);
        let corners = [(px(x + 0.5), px(y + 0.5)), (px(x + wide - 0.5), px(y + high - 0.5))];
        area.draw(&Rectangle::new(corners, fill.filled()))?;
        let style = text(SIGN_PX, ink, (HPos::Center, VPos::Center));
        area.draw_text(&cell.sign, &style, (px(x + wide / 2.0), px(y + high / 2.0)))
    }

    /// Draws the key, sample cells with their meaning, and continues on a further line when one is
    /// full.
    fn key<DB: DrawingBackend>(&self, area: &Area<DB>, y: f64) -> Drawn<DB> {
        let style = text(TICK_PX - 1.0, INK, (HPos::Left, VPos::Center));
        let most_px = f64::from(area.dim_in_pixel().0) / f64::from(px(1.0)) - MARGIN_PX;
        let mut places = Vec::with_capacity(self.matrix.key.len());
        let (mut x, mut line) = (MARGIN_PX, 0.0);
        for (_, meaning) in &self.matrix.key {
            let wide = 23.0 + f64::from(width(area, meaning, &style)?) / f64::from(px(1.0));
            if x + wide > most_px && x > MARGIN_PX {
                (x, line) = (MARGIN_PX, line + 1.0);
            }
            places.push((x, line));
            x += wide + 12.0;
        }
        let first = y - 0.5 * KEY_LINE_PX * line;
        for ((cell, meaning), (x, line)) in self.matrix.key.iter().zip(places) {
            let y = first + KEY_LINE_PX * line;
            self.cell(area, cell, [x, y - 9.0], [18.0, 18.0])?;
            area.draw_text(meaning, &style, (px(x + 23.0), px(y)))?;
        }
        Ok(())
    }
}
