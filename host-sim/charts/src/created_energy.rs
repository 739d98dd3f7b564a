//! Draws the energy that each controller creates as bars on a logarithmic axis. Two columns beside
//! the bars give the static error of the controller and the emulated hands that it shakes.

use std::path::Path;

use plotters::drawing::DrawingAreaErrorKind;
use plotters::element::{PathElement, Rectangle};
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{Color, RGBColor};

use super::canvas::Area;
use super::canvas::Drawn;
use super::layout::{MARGIN_PX, title};
use super::picture::{Picture, save};
use super::style::{BAR, GRID, INK, LABEL_PX, MUTED, REFERENCE, RELEASE, TICK_PX, line, px, text};
use super::{ChartError, check};

/// Results of one controller.
#[derive(Clone, Debug)]
pub struct EnergyRow {
    /// Name of the controller.
    pub name: String,
    /// Energy created on each device [J], in the order of the devices.
    pub created_j: Vec<f64>,
    /// Texts of the two columns beside the bars: static error, and hands that the controller
    /// shakes.
    pub beside: [String; 2],
}

/// Data and labels of a chart of the energy that the loop adds: one row per controller, one bar per
/// device.
#[derive(Clone, Copy, Debug)]
pub struct CreatedEnergy<'a> {
    /// First line above the chart.
    pub title: &'a str,
    /// Line below the title.
    pub caption: &'a str,
    /// Names of the devices, one per bar of a row; at most two.
    pub devices: &'a [&'a str],
    /// Rows from top to bottom, one per controller.
    pub rows: &'a [EnergyRow],
    /// Promised upper bound of the energy [J], drawn as a vertical line.
    pub promised_j: f64,
}

/// Writes `NAME.svg` and `NAME.png` into `folder`.
///
/// # Errors
/// Fails if there are no rows, if a row does not have one value per device, if a value cannot be
/// drawn, or if the folder cannot be written.
pub fn created_energy(folder: &Path, name: &str, bars: &CreatedEnergy) -> Result<(), ChartError> {
    if bars.rows.is_empty() || bars.devices.is_empty() {
        return Err(ChartError::Empty { what: "rows" });
    }
    for row in bars.rows {
        check("created_j", row.created_j.iter().copied())?;
        if row.created_j.len() != bars.devices.len() {
            return Err(ChartError::EmptySeries { series: row.name.clone() });
        }
    }
    save(folder, name, bars)
}

const LEFT_PX: f64 = 168.0;
const TOP_PX: f64 = 120.0;
const BELOW_PX: f64 = 70.0;
/// Width reserved for the two columns beside the bars, and width of the second one [px].
const RIGHT_PX: f64 = 210.0;
const COLUMN_PX: f64 = 72.0;
/// Both ends of the axis, as exponents of ten [mJ].
const DECADES: (i32, i32) = (-3, 3);
const COLORS: [RGBColor; 2] = [BAR, RELEASE];

fn says(mj: f64) -> String {
    match mj {
        v if v < 1e-3 => "0".into(),
        v if v < 0.0995 => format!("{v:.3}"),
        v if v < 9.95 => format!("{v:.1}"),
        v => format!("{v:.0}"),
    }
}

impl CreatedEnergy<'_> {
    fn axis<DB: DrawingBackend>(&self, area: &Area<DB>, at: &dyn Fn(f64) -> f64, bottom: f64) -> Drawn<DB> {
        for decade in DECADES.0..=DECADES.1 {
            let x = px(at(10_f64.powi(decade)));
            area.draw(&PathElement::new([(x, px(TOP_PX)), (x, px(bottom))], line(GRID, 1.0)))?;
            let style = text(TICK_PX, INK, (HPos::Center, VPos::Top));
            area.draw_text(&format!("{}", 10_f64.powi(decade)), &style, (x, px(bottom + 8.0)))?;
        }
        let middle = (at(10_f64.powi(DECADES.0)) + at(10_f64.powi(DECADES.1))) * 0.5;
        let style = text(LABEL_PX, INK, (HPos::Center, VPos::Top));
        area.draw_text("energy created in the worst contact [mJ]", &style, (px(middle), px(bottom + 32.0)))?;
        let x = px(at(self.promised_j * 1e3));
        area.draw(&PathElement::new([(x, px(TOP_PX)), (x, px(bottom))], line(REFERENCE, 1.6)))?;
        let style = text(TICK_PX - 1.0, REFERENCE, (HPos::Center, VPos::Bottom));
        area.draw_text("promised", &style, (x, px(TOP_PX - 4.0)))
    }

    fn key<DB: DrawingBackend>(&self, area: &Area<DB>, right: f64) -> Drawn<DB> {
        for (n, (device, color)) in self.devices.iter().zip(COLORS).enumerate() {
            let x = LEFT_PX + 210.0 + 120.0 * n as f64;
            area.draw(&Rectangle::new([(px(x), px(TOP_PX - 19.0)), (px(x + 12.0), px(TOP_PX - 7.0))], color.filled()))?;
            area.draw_text(device, &text(TICK_PX, INK, (HPos::Left, VPos::Center)), (px(x + 18.0), px(TOP_PX - 13.0)))?;
        }
        for (head, x) in ["static error", "shakes"].into_iter().zip([right - COLUMN_PX, right]) {
            area.draw_text(head, &text(TICK_PX, MUTED, (HPos::Right, VPos::Bottom)), (px(x), px(TOP_PX - 4.0)))?;
        }
        Ok(())
    }
}

impl Picture for CreatedEnergy<'_> {
    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Result<(), DrawingAreaErrorKind<DB::ErrorType>> {
        title(area, self.title, self.caption)?;
        let (width, height) = area.dim_in_pixel();
        let in_px = |units: u32| f64::from(units) / f64::from(super::style::FINE);
        let (right, bottom) = (in_px(width) - MARGIN_PX, in_px(height) - BELOW_PX);
        let (low, high) = (f64::from(DECADES.0), f64::from(DECADES.1));
        let at = |mj: f64| LEFT_PX + (right - RIGHT_PX - LEFT_PX) * ((mj.log10() - low) / (high - low)).clamp(0.0, 1.0);
        self.axis(area, &at, bottom)?;
        self.key(area, right)?;
        let step = (bottom - TOP_PX) / self.rows.len() as f64;
        for (n, row) in self.rows.iter().enumerate() {
            let top = TOP_PX + step * n as f64;
            let middle = px(top + step * 0.5);
            area.draw_text(&row.name, &text(TICK_PX, INK, (HPos::Right, VPos::Center)), (px(LEFT_PX - 10.0), middle))?;
            for (said, x) in row.beside.iter().zip([right - COLUMN_PX, right]) {
                area.draw_text(said, &text(TICK_PX, INK, (HPos::Right, VPos::Center)), (px(x), middle))?;
            }
            let thick = step * 0.76 / row.created_j.len() as f64;
            for ((k, created_j), color) in row.created_j.iter().enumerate().zip(COLORS) {
                let mj = created_j * 1e3;
                let from = top + step * 0.12 + thick * k as f64;
                let end = at(mj.max(1e-9));
                let corners = [(px(LEFT_PX), px(from + 0.5)), (px(end), px(from + thick - 0.5))];
                area.draw(&Rectangle::new(corners, color.filled()))?;
                let style = text(TICK_PX - 1.5, INK, (HPos::Left, VPos::Center));
                area.draw_text(&says(mj), &style, (px(end + 6.0), px(from + thick * 0.5)))?;
            }
        }
        let left = px(LEFT_PX);
        area.draw(&PathElement::new([(left, px(TOP_PX)), (left, px(bottom))], line(INK, 1.2)))
    }
}
