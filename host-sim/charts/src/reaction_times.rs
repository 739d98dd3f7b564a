//! Draws reaction times to many faults: one bar per fault from the fastest to the slowest run on a
//! logarithmic axis, with the allowed time as a stroke.

use std::path::Path;

use plotters::element::{Circle, PathElement, Rectangle};
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{Color, RGBColor};

use super::canvas::Area;
use super::canvas::Drawn;
use super::layout::{MARGIN_PX, TITLE_HEIGHT_PX, cut, title};
use super::picture::{Picture, save};
use super::style::{GRID, INK, MUTED, TICK_PX, line, px, text};
use super::{ChartError, check_series};

/// Colours of bars whose slowest run is in time, and of late ones.
const IN_TIME: RGBColor = RGBColor(0, 114, 178);
const TOO_LATE: RGBColor = RGBColor(213, 94, 0);
/// Space for the names, and between the two columns [px].
const NAME_PX: f64 = 238.0;
const GAP_PX: f64 = 18.0;
/// Height of the axis below the bars [px].
const AXIS_PX: f64 = 44.0;

/// Reaction times to one kind of fault.
#[derive(Clone, Debug)]
pub struct ReactionBar<'a> {
    /// Name of the fault.
    pub name: &'a str,
    /// Fastest, median and slowest reaction [ticks], each at least one.
    pub ticks: [f64; 3],
    /// Longest allowed reaction [ticks], if there is a limit.
    pub allowed_ticks: Option<f64>,
}

/// Data and labels of a reaction-time chart.
#[derive(Clone, Copy, Debug)]
pub struct ReactionTimes<'a> {
    /// First line above the chart.
    pub title: &'a str,
    /// Second line above the chart.
    pub below: &'a str,
    /// Bars from top to bottom: first those of the left column, then those of the right.
    pub bars: &'a [ReactionBar<'a>],
}

/// Writes `NAME.svg` and `NAME.png` into `folder`.
///
/// # Errors
/// Fails if there is no bar, if a time is not above zero, or if the folder cannot be written.
pub fn reaction_times(folder: &Path, name: &str, times: &ReactionTimes) -> Result<(), ChartError> {
    if times.bars.is_empty() {
        return Err(ChartError::Empty { what: "bars" });
    }
    for bar in times.bars {
        check_series(bar.name, "ticks", bar.ticks.into_iter().chain(bar.allowed_ticks), true)?;
    }
    let longest = times.bars.iter().map(|b| b.ticks[2].max(b.allowed_ticks.unwrap_or(1.0))).fold(10.0, f64::max);
    save(folder, name, &Drawing { times, longest: 1.15 * longest })
}

struct Drawing<'a> {
    times: &'a ReactionTimes<'a>,
    /// End of the axis [ticks].
    longest: f64,
}

impl Picture for Drawing<'_> {
    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Drawn<DB> {
        title(area, self.times.title, self.times.below)?;
        let (width, height) = area.dim_in_pixel();
        let (width, height) = (width.cast_signed(), height.cast_signed());
        let (top, foot) = (px(TITLE_HEIGHT_PX), height - px(MARGIN_PX + AXIS_PX));
        let rows = self.times.bars.len().div_ceil(2).max(1) as i32;
        let column = (width - 2 * px(MARGIN_PX) - px(GAP_PX)) / 2;
        let step = ((foot - top) / rows).min(px(30.0));
        for (side, bars) in self.times.bars.chunks(rows as usize).enumerate() {
            let left = px(MARGIN_PX) + side as i32 * (column + px(GAP_PX));
            let (from, to) = (left + px(NAME_PX), left + column - px(6.0));
            let x = |ticks: f64| from + (f64::from(to - from) * (ticks / 0.8).ln() / (self.longest / 0.8).ln()) as i32;
            let end = top + step * bars.len() as i32;
            for ticks in [1.0, 10.0, 100.0].into_iter().filter(|t| *t < self.longest) {
                area.draw(&PathElement::new([(x(ticks), top), (x(ticks), end)], line(GRID, 1.2)))?;
                let style = text(TICK_PX, INK, (HPos::Center, VPos::Top));
                area.draw_text(&format!("{ticks}"), &style, (x(ticks), end + px(4.0)))?;
            }
            let style = text(TICK_PX, MUTED, (HPos::Center, VPos::Top));
            area.draw_text("ms to the reaction", &style, ((from + to) / 2, end + px(22.0)))?;
            let style = text(TICK_PX, INK, (HPos::Right, VPos::Center));
            for (n, bar) in bars.iter().enumerate() {
                let y = top + step * n as i32 + step / 2;
                let name = cut(area, bar.name, &style, px(NAME_PX - 14.0))?;
                area.draw_text(&name, &style, (from - px(10.0), y))?;
                area.draw(&PathElement::new([(from, y), (to, y)], line(GRID, 0.6)))?;
                let color = if bar.allowed_ticks.is_some_and(|most| bar.ticks[2] > most) { TOO_LATE } else { IN_TIME };
                let half = px(4.0).min(step / 3);
                let [fastest, middle, slowest] = bar.ticks.map(x);
                area.draw(&Rectangle::new(
                    [(fastest - px(2.0), y - half), (slowest + px(2.0), y + half)],
                    color.mix(0.35).filled(),
                ))?;
                area.draw(&Circle::new((middle, y), px(3.4), color.filled()))?;
                if let Some(allowed) = bar.allowed_ticks.map(x) {
                    area.draw(&PathElement::new(
                        [(allowed + px(5.0), y - step / 3), (allowed + px(5.0), y + step / 3)],
                        line(INK, 2.0),
                    ))?;
                }
            }
        }
        Ok(())
    }
}
