//! Draws horizontal bars, in two columns if there are many: a span of values with a mark inside,
//! whiskers, the largest allowed value, and a text.

use std::path::Path;

use plotters::element::{Circle, PathElement, Rectangle};
use plotters::prelude::DrawingBackend;
use plotters::style::Color;
use plotters::style::text_anchor::{HPos, VPos};

use super::canvas::Area;
use super::canvas::Drawn;
use super::key_column::{self, Sign};
use super::layout::{MARGIN_PX, TITLE_HEIGHT_PX, cut, title};
use super::marker::distinct;
use super::picture::{Picture, save};
use super::plot::{Ruler, Scale, ScaledAxis};
use super::style::{GRID, INK, LABEL_PX, MUTED, REFERENCE, TICK_PX, WARN, line, px, text};
use super::{ChartError, check_series};

/// Number of bars above which there are two columns.
const ONE_COLUMN: usize = 36;
/// Space for the names, for the texts, and between two columns [px].
const NAME_PX: f64 = 232.0;
const TEXT_PX: f64 = 150.0;
const GAP_PX: f64 = 18.0;
/// Height of the axis below the bars, and largest height of a bar [px].
const AXIS_PX: f64 = 52.0;
const HIGHEST_PX: f64 = 50.0;

/// One bar.
#[derive(Clone, Debug)]
pub struct Bar {
    /// Name at the left; a name equal to that of the bar above is not repeated.
    pub name: String,
    /// Kind of the bar in the legend; all bars of a kind have the same colour.
    pub kind: String,
    /// Both ends of the bar, in the unit of the axis.
    pub span: [f64; 2],
    /// Both ends of a thin line behind the bar.
    pub whiskers: Option<[f64; 2]>,
    /// Value marked by a dot.
    pub mark: Option<f64>,
    /// Largest value allowed, drawn as a stroke; a bar beyond it is drawn in red.
    pub allowed: Option<f64>,
    /// Text at the right; may be empty.
    pub text: String,
}

/// Bars from top to bottom over one axis.
#[derive(Clone, Debug)]
pub struct Bars {
    /// Axis of the values.
    pub axis: ScaledAxis,
    /// Bars from top to bottom.
    pub bars: Vec<Bar>,
}

impl Bars {
    pub(super) fn save(&self, folder: &Path, name: &str, title: [&str; 2]) -> Result<(), ChartError> {
        if self.bars.is_empty() {
            return Err(ChartError::Empty { what: "bars" });
        }
        let values = |b: &Bar| -> Vec<f64> {
            b.span.into_iter().chain(b.whiskers.into_iter().flatten()).chain(b.mark).chain(b.allowed).collect()
        };
        for bar in &self.bars {
            let series = format!("{} {}", bar.name, bar.kind);
            check_series(series.trim_end(), "values", values(bar), self.axis.scale == Scale::Log)?;
        }
        let mut kinds: Vec<&str> = Vec::new();
        for bar in &self.bars {
            if !kinds.contains(&bar.kind.as_str()) {
                kinds.push(&bar.kind);
            }
        }
        let ruler = Ruler::new(self.axis.scale, self.bars.iter().flat_map(values));
        save(folder, name, &Drawing { bars: self, title, kinds, ruler })
    }
}

struct Drawing<'a> {
    bars: &'a Bars,
    title: [&'a str; 2],
    kinds: Vec<&'a str>,
    ruler: Ruler,
}

impl Picture for Drawing<'_> {
    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Drawn<DB> {
        title(area, self.title[0], self.title[1])?;
        let signs = self.kinds.iter().enumerate().map(|(n, kind)| (Sign::Patch(distinct(n).color), *kind));
        // a legend with a single entry would explain nothing
        let entries: Vec<_> = if self.kinds.len() > 1 { signs.collect() } else { Vec::new() };
        let taken = key_column::room(area, &entries)?;
        let (width, height) = area.dim_in_pixel();
        let (width, height) = (width.cast_signed() - taken, height.cast_signed());
        let (top, foot) = (px(TITLE_HEIGHT_PX), height - px(MARGIN_PX + AXIS_PX));
        let sides = if self.bars.bars.len() > ONE_COLUMN { 2 } else { 1 };
        let rows = self.bars.bars.len().div_ceil(sides);
        let column = (width - 2 * px(MARGIN_PX) - (sides as i32 - 1) * px(GAP_PX)) / sides as i32;
        let step = ((foot - top) / rows as i32).min(px(HIGHEST_PX));
        for (side, bars) in self.bars.bars.chunks(rows).enumerate() {
            let left = px(MARGIN_PX) + side as i32 * (column + px(GAP_PX));
            self.column(area, bars, [left, left + column], top, step)?;
        }
        key_column::draw(area, &entries, taken, px(TITLE_HEIGHT_PX))
    }
}

impl Drawing<'_> {
    /// Draws bars with their axis between two edges.
    fn column<DB: DrawingBackend>(
        &self,
        area: &Area<DB>,
        bars: &[Bar],
        [left, right]: [i32; 2],
        top: i32,
        step: i32,
    ) -> Drawn<DB> {
        let said = bars.iter().any(|bar| !bar.text.is_empty());
        let (from, to) = (left + px(NAME_PX), right - px(if said { TEXT_PX } else { 6.0 }));
        let range = &self.ruler.range;
        let place = |even: f64| from + (f64::from(to - from) * (even - range.start) / (range.end - range.start)) as i32;
        let x = |value: f64| place(self.ruler.at(value));
        let end = top + step * bars.len() as i32;
        for tick in &self.ruler.ticks {
            area.draw(&PathElement::new([(place(*tick), top), (place(*tick), end)], line(GRID, 1.2)))?;
            let style = text(TICK_PX, INK, (HPos::Center, VPos::Top));
            area.draw_text(&self.ruler.label(*tick), &style, (place(*tick), end + px(4.0)))?;
        }
        let style = text(LABEL_PX, MUTED, (HPos::Center, VPos::Top));
        area.draw_text(&self.bars.axis.title, &style, ((from + to) / 2, end + px(24.0)))?;
        let style = text(TICK_PX, INK, (HPos::Right, VPos::Center));
        let mut above = "";
        for (n, bar) in bars.iter().enumerate() {
            let y = top + step * n as i32 + step / 2;
            if bar.name != above {
                let name = cut(area, &bar.name, &style, px(NAME_PX - 14.0))?;
                area.draw_text(&name, &style, (from - px(10.0), y))?;
            }
            above = &bar.name;
            area.draw(&PathElement::new([(from, y), (to, y)], line(GRID, 0.6)))?;
            let kind = self.kinds.iter().position(|kind| *kind == bar.kind).unwrap_or(0);
            let color = if bar.allowed.is_some_and(|most| bar.span[1] > most) { WARN } else { distinct(kind).color };
            if let Some([low, high]) = bar.whiskers {
                area.draw(&PathElement::new([(x(low), y), (x(high), y)], line(color, 1.6)))?;
            }
            let half = px(5.0).min(step / 3);
            let corners = [(x(bar.span[0]) - px(2.0), y - half), (x(bar.span[1]) + px(2.0), y + half)];
            area.draw(&Rectangle::new(corners, color.mix(0.4).filled()))?;
            if let Some(mark) = bar.mark {
                area.draw(&Circle::new((x(mark), y), px(3.4), color.filled()))?;
            }
            if let Some(allowed) = bar.allowed.map(x) {
                let stroke = [(allowed + px(3.0), y - step / 3), (allowed + px(3.0), y + step / 3)];
                area.draw(&PathElement::new(stroke, line(REFERENCE, 2.0)))?;
            }
            area.draw_text(&bar.text, &style, (right, y))?;
        }
        Ok(())
    }
}
