//! Marks the end of each hold on a curve and labels it where there is room for the label.

use plotters::coord::ranged1d::Ranged;
use plotters::element::Circle;
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{Color, WHITE};

use super::canvas::Area;
use super::canvas::Drawn;
use super::layout::{Chart, width};
use super::place::{Frame, Page};
use super::style::{INK, LABEL_PX, px, text};

/// Mark of a hold: its position on the chart and its label.
pub struct Mark {
    /// Position (x, y) in the units of the axes.
    pub at: (f64, f64),
    /// Label text; not drawn if it would cover something.
    pub label: String,
}

/// Draws `marks` on `chart` and keeps their labels clear of `curve`, of each other and of `taken`.
pub fn draw<'a, DB, X, Y>(
    area: &Area<DB>,
    chart: &mut Chart<'a, DB, X, Y>,
    marks: &[Mark],
    curve: &[(f64, f64)],
    taken: Option<Frame>,
) -> Drawn<DB>
where
    DB: DrawingBackend + 'a,
    X: Ranged<ValueType = f64>,
    Y: Ranged<ValueType = f64>,
{
    for mark in marks {
        chart.draw_series([Circle::new(mark.at, px(6.4), INK.filled()), Circle::new(mark.at, px(4.8), WHITE.filled())])?;
    }
    let (xs, ys) = chart.plotting_area().get_pixel_range();
    let mut page = Page::new(Frame { low: (xs.start, ys.start), high: (xs.end, ys.end) });
    let dots: Vec<_> = marks.iter().map(|m| chart.backend_coord(&m.at)).collect();
    page.add_curve(curve.iter().map(|p| chart.backend_coord(p)), px(3.0));
    if let Some(taken) = taken {
        page.add_box(taken);
    }
    for dot in &dots {
        page.add_dot(*dot, px(6.4));
    }
    let base = area.get_base_pixel();
    for (mark, dot) in marks.iter().zip(dots) {
        let plain = text(LABEL_PX, INK, (HPos::Left, VPos::Center));
        let size = (width(area, &mark.label, &plain)?, px(LABEL_PX * 1.1));
        if let Some((corner, anchor)) = page.place(dot, size, px(8.0)) {
            let corner = (corner.0 - base.0, corner.1 - base.1);
            area.draw_text(&mark.label, &text(LABEL_PX, INK, anchor), corner)?;
        }
    }
    Ok(())
}
