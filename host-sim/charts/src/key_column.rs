//! Draws the legend beside a plot in a column of its own, so that it cannot cover data.

use plotters::drawing::DrawingAreaErrorKind;
use plotters::element::{Circle, DashedPathElement, PathElement, Rectangle};
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{Color, RGBColor};

use super::canvas::Area;
use super::canvas::Drawn;
use super::layout::{MARGIN_PX, cut, width};
use super::marker::{self, Look};
use super::style::{INK, MUTED, TICK_PX, line, px, text};

/// Graphic in front of a name in the legend.
#[derive(Clone, Copy)]
pub enum Sign {
    /// A line if the points are `joined`, a marker if they are `marked`, or both.
    Line { look: Look, joined: bool, marked: bool, hollow: bool },
    /// A filled square.
    Patch(RGBColor),
    /// A thin outline.
    Wire(RGBColor),
    /// A disc of this radius [px].
    Disc(f64),
    /// A dashed line.
    Dashes(RGBColor),
}

/// Width of a sign with the gap after it [px].
const SIGN_PX: f64 = 34.0;
/// Maximum width of the column [px]; longer names are cut.
const WIDEST_PX: f64 = 280.0;
/// Height of an entry [px].
const ENTRY_PX: f64 = 22.0;

/// Width that the column needs, including its margin [canvas units]; 0 without entries.
pub fn room<DB: DrawingBackend>(area: &Area<DB>, entries: &[(Sign, &str)]) -> Result<i32, DrawingAreaErrorKind<DB::ErrorType>> {
    let style = text(TICK_PX, INK, (HPos::Left, VPos::Center));
    let mut widest = 0;
    for (_, name) in entries {
        widest = widest.max(width(area, name, &style)?);
    }
    if entries.is_empty() { Ok(0) } else { Ok((widest + px(SIGN_PX + MARGIN_PX + 16.0)).min(px(WIDEST_PX))) }
}

/// Draws the column, `taken` wide [canvas units], at the right edge of the area from `top`
/// downward.
pub fn draw<DB: DrawingBackend>(area: &Area<DB>, entries: &[(Sign, &str)], taken: i32, top: i32) -> Drawn<DB> {
    let left = area.dim_in_pixel().0.cast_signed() - taken + px(16.0);
    let bottom = area.dim_in_pixel().1.cast_signed() - px(MARGIN_PX);
    // many entries are spaced more closely so that they stay inside the picture
    let step = px(ENTRY_PX).min((bottom - top) / i32::try_from(entries.len().max(1)).unwrap_or(i32::MAX));
    let style = text(TICK_PX, INK, (HPos::Left, VPos::Center));
    for (n, (sign, name)) in entries.iter().enumerate() {
        let y = top + px(ENTRY_PX / 2.0) + step * n as i32;
        draw_sign(area, *sign, left, y)?;
        let name = cut(area, name, &style, taken - px(SIGN_PX + MARGIN_PX + 10.0))?;
        area.draw_text(&name, &style, (left + px(SIGN_PX), y))?;
    }
    Ok(())
}

fn draw_sign<DB: DrawingBackend>(area: &Area<DB>, sign: Sign, left: i32, y: i32) -> Drawn<DB> {
    let stroke = [(left, y), (left + px(26.0), y)];
    let corners = [(left + px(6.0), y - px(7.0)), (left + px(20.0), y + px(7.0))];
    match sign {
        Sign::Line { look, joined, marked, hollow } => {
            if joined {
                area.draw(&PathElement::new(stroke, line(look.color, 2.2)))?;
            }
            if marked {
                marker::draw(area, look, (left + px(13.0), y), px(4.6), hollow)?;
            }
            Ok(())
        }
        Sign::Patch(color) => area.draw(&Rectangle::new(corners, color.filled())),
        Sign::Wire(color) => area.draw(&Rectangle::new(corners, line(color, 1.6))),
        Sign::Disc(radius_px) => area.draw(&Circle::new((left + px(13.0), y), px(radius_px), MUTED.filled())),
        Sign::Dashes(color) => area.draw(&DashedPathElement::new(stroke, px(5.0), px(4.0), line(color, 1.6))),
    }
}
