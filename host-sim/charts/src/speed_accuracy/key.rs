//! Draws the column beside the plot: methods, sizes, and the points of the Pareto front by name.

use plotters::drawing::DrawingAreaErrorKind;
use plotters::element::{PathElement, Polygon};
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{Color, WHITE};

use super::marker::{Marker, look, outline, radius_px};
use super::{FRONT, SpeedAccuracy, label};
use crate::canvas::Area;
use crate::canvas::Drawn;
use crate::layout::width;
use crate::style::{DEPTH, INK, MUTED, TICK_PX, heading, line, px, text};

/// Height of a line [px].
const LINE_PX: f64 = 20.0;
/// Minimum width of the column [px], which the signs of the sizes need.
const LEAST_PX: f64 = 232.0;
/// Width of a sign with the gap after it [px].
const SIGN_PX: f64 = 34.0;
/// Sum of the free width on both sides of the column [px].
const MARGINS_PX: f64 = 28.0;

/// Width of the column, as required by its longest name [canvas units].
pub fn room<DB: DrawingBackend>(area: &Area<DB>, data: &SpeedAccuracy) -> Result<i32, DrawingAreaErrorKind<DB::ErrorType>> {
    let style = text(TICK_PX, INK, (HPos::Left, VPos::Center));
    let mut room = px(LEAST_PX);
    for method in data.methods.iter().filter(|m| !m.points.is_empty()) {
        room = room.max(width(area, method.name, &style)? + px(SIGN_PX + MARGINS_PX));
    }
    Ok(room)
}

/// Draws the column with its upper left corner at (`left`, `top`).
pub fn draw<DB: DrawingBackend>(area: &Area<DB>, data: &SpeedAccuracy, left: i32, top: i32) -> Drawn<DB> {
    let mut y = top + px(8.0);
    let say = |words: &str, x: f64, y: i32, color| {
        area.draw_text(words, &text(TICK_PX, color, (HPos::Left, VPos::Center)), (left + px(x), y))
    };
    for (index, method) in data.methods.iter().enumerate() {
        if method.points.is_empty() {
            continue;
        }
        let look = look(index);
        area.draw(&PathElement::new([(left, y), (left + px(26.0), y)], line(look.color, 1.2)))?;
        area.draw(&Polygon::new(outline(look.shape, (left + px(13.0), y), px(5.5)), look.color.filled()))?;
        say(method.name, SIGN_PX, y, INK)?;
        y += px(LINE_PX);
    }
    y += px(0.6 * LINE_PX);
    let mut sizes: Vec<usize> = data.methods.iter().flat_map(|m| m.points.iter().map(|p| p.nodes)).collect();
    sizes.sort_unstable();
    sizes.dedup();
    say("nodes of the mesh", 0.0, y, INK)?;
    y += px(1.1 * LINE_PX);
    for (n, nodes) in sizes.iter().take(4).enumerate() {
        let x = 6.0 + 50.0 * n as f64;
        let center = (left + px(x), y);
        area.draw(&Polygon::new(outline(Marker::Disc, center, px(radius_px(*nodes))), DEPTH.filled()))?;
        say(&nodes.to_string(), x + 12.0, y, MUTED)?;
    }
    y += px(LINE_PX);
    if data.methods.iter().any(|m| m.points.iter().any(|p| !p.survived)) {
        let center = (left + px(8.0), y);
        area.draw(&Polygon::new(outline(Marker::Disc, center, px(5.5)), DEPTH.filled()))?;
        area.draw(&Polygon::new(outline(Marker::Disc, center, px(3.7)), WHITE.filled()))?;
        say("did not survive the press", 20.0, y, MUTED)?;
        y += px(LINE_PX);
    }
    y += px(0.6 * LINE_PX);
    area.draw(&PathElement::new([(left, y), (left + px(26.0), y)], line(FRONT, 6.0)))?;
    area.draw_text("unbeaten in both", &heading(TICK_PX, INK), (left + px(SIGN_PX), y - px(9.0)))?;
    y += px(LINE_PX);
    let bottom = area.dim_in_pixel().1.cast_signed() - px(LINE_PX);
    for &(m, p) in data.front {
        let Some((method, point)) = data.methods.get(m).and_then(|m| Some((m, m.points.get(p)?))) else { continue };
        if y > bottom {
            break;
        }
        let center = (left + px(8.0), y);
        let look = look(m);
        area.draw(&Polygon::new(outline(look.shape, center, px(4.5)), look.color.filled()))?;
        say(&format!("{} {}", method.name, label(point)), 20.0, y, MUTED)?;
        y += px(LINE_PX);
    }
    Ok(())
}
