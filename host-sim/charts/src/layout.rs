//! Draws title, axes and legend at the same place on every chart.

use plotters::chart::ChartContext;
use plotters::coord::cartesian::Cartesian2d;
use plotters::coord::ranged1d::{Ranged, ValueFormatter};
use plotters::drawing::DrawingAreaErrorKind;
use plotters::prelude::{ChartBuilder, DrawingBackend};
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{TRANSPARENT, TextStyle};

use super::canvas::{Area, Drawn};
use super::style::{GRID, INK, LABEL_PX, MUTED, TICK_PX, TITLE_PX, heading, line, px, text};

/// A chart with two numeric axes.
pub type Chart<'a, DB, X, Y> = ChartContext<'a, DB, Cartesian2d<X, Y>>;

/// Minimum distance of everything drawn from the edges of the picture [px].
pub const MARGIN_PX: f64 = 24.0;

/// Height that [`title`] occupies at the top [px].
pub const TITLE_HEIGHT_PX: f64 = 78.0;

/// Draws a heading and a line below it at the top left.
pub fn title<DB: DrawingBackend>(area: &Area<DB>, top: &str, below: &str) -> Drawn<DB> {
    let left = px(MARGIN_PX);
    let style = heading(TITLE_PX, INK);
    area.draw_text(&fitted(area, top, &style)?, &style, (left, px(18.0)))?;
    let style = text(LABEL_PX, MUTED, (HPos::Left, VPos::Top));
    area.draw_text(&fitted(area, below, &style)?, &style, (left, px(45.0)))
}

/// Returns `words`, cut with an ellipsis if they would extend beyond the picture.
pub fn fitted<DB: DrawingBackend>(
    area: &Area<DB>,
    words: &str,
    style: &TextStyle,
) -> Result<String, DrawingAreaErrorKind<DB::ErrorType>> {
    cut(area, words, style, area.dim_in_pixel().0.cast_signed() - 2 * px(MARGIN_PX))
}

/// Returns `words`, cut with an ellipsis to a width of at most `room` [canvas units].
pub fn cut<DB: DrawingBackend>(
    area: &Area<DB>,
    words: &str,
    style: &TextStyle,
    room: i32,
) -> Result<String, DrawingAreaErrorKind<DB::ErrorType>> {
    let mut cut = words.to_owned();
    while !cut.is_empty() && width(area, &cut, style)? > room {
        cut.pop();
        cut.truncate(cut.trim_end_matches(['…', ' ', ',']).len());
        cut.pop();
        cut.push('…');
    }
    Ok(cut)
}

/// Width of `words` [canvas units].
pub fn width<DB: DrawingBackend>(
    area: &Area<DB>,
    words: &str,
    style: &TextStyle,
) -> Result<i32, DrawingAreaErrorKind<DB::ErrorType>> {
    // the plotting library measures text by the line height (1.362 em for this font) but draws it
    // by 1.24 em
    let measured = f64::from(area.estimate_text_size(words, style)?.0);
    Ok((measured * 1.362 / 1.24).ceil() as i32)
}

/// Returns a chart builder with the common margins and room for a title.
pub fn builder<'b, DB: DrawingBackend>(area: &Area<DB>) -> ChartBuilder<'_, 'b, DB> {
    let mut builder = ChartBuilder::on(area);
    builder
        .margin(px(MARGIN_PX))
        .margin_top(px(TITLE_HEIGHT_PX))
        .margin_left(px(MARGIN_PX - 8.0))
        .margin_bottom(px(MARGIN_PX - 8.0))
        .x_label_area_size(px(54.0))
        .y_label_area_size(px(76.0));
    builder
}

/// Title and tick labels of one axis.
#[derive(Clone, Copy)]
pub struct Labels<'a> {
    /// Quantity and unit of the axis.
    pub title: &'a str,
    /// Maximum number of ticks.
    pub ticks: usize,
    /// Function that returns the label of the tick at a value.
    pub of: &'a dyn Fn(&f64) -> String,
}

/// Draws grid, ticks and axis titles.
pub fn axes<'a, DB, X, Y>(chart: &mut Chart<'a, DB, X, Y>, x: Labels, y: Labels) -> Drawn<DB>
where
    DB: DrawingBackend + 'a,
    X: Ranged<ValueType = f64> + ValueFormatter<f64>,
    Y: Ranged<ValueType = f64> + ValueFormatter<f64>,
{
    let center = (HPos::Center, VPos::Center);
    chart
        .configure_mesh()
        .light_line_style(TRANSPARENT)
        .bold_line_style(line(GRID, 1.0))
        .axis_style(line(INK, 1.2))
        .set_all_tick_mark_size(px(5.0))
        .label_style(text(TICK_PX, INK, center))
        .axis_desc_style(text(LABEL_PX, INK, center))
        .x_labels(x.ticks)
        .y_labels(y.ticks)
        .x_label_formatter(x.of)
        .y_label_formatter(y.of)
        .x_desc(x.title)
        .y_desc(y.title)
        .draw()
}
