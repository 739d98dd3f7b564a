//! Draws the colour scale and the length scale beside the surface, and maps displacement to colour.

use plotters::element::{PathElement, Rectangle};
use plotters::prelude::{ColorMap, DrawingBackend, RGBColor, ViridisRGB};
use plotters::style::Color;
use plotters::style::text_anchor::{HPos, VPos};

use super::view::View;
use crate::axis::{Axis, Unit};
use crate::canvas::Area;
use crate::canvas::Drawn;
use crate::layout::{MARGIN_PX, TITLE_HEIGHT_PX, builder};
use crate::style::{INK, LABEL_PX, MUTED, TICK_PX, line, px, text};

/// Space for the colour bar and its labels at the right [px].
pub const BAR_PX: f64 = 130.0;

/// Colour at a `share` (0 to 1) of the scale: viridis, lightened by a quarter so that it can be
/// shaded.
pub fn colour(share: f64) -> RGBColor {
    let RGBColor(r, g, b) = ViridisRGB.get_color(share.clamp(0.0, 1.0));
    let pale = |v: u8| v + (255 - v) / 4;
    RGBColor(pale(r), pale(g), pale(b))
}

/// Colour of a surface of colour `color` under a brightness `light` from 0 to 1.
pub fn shaded(color: RGBColor, light: f64) -> RGBColor {
    let lit = |v: u8| (f64::from(v) * (0.52 + 0.85 * light)).min(255.0) as u8;
    RGBColor(lit(color.0), lit(color.1), lit(color.2))
}

/// Draws the colour scale with its ticks at the right of the picture.
pub fn colour_bar<DB: DrawingBackend>(area: &Area<DB>, scale: &Axis, quantity: &str, unit: Unit) -> Drawn<DB> {
    let most = scale.range.end;
    let (width, height) = area.dim_in_pixel();
    let left = width.cast_signed() - px(BAR_PX + MARGIN_PX);
    let (_, bar) = area.split_horizontally(left);
    let spare = (height.cast_signed() - px(TITLE_HEIGHT_PX + 380.0)) / 2;
    let mut chart = builder(&bar)
        .margin_top(px(TITLE_HEIGHT_PX) + spare)
        .margin_bottom(spare)
        .margin_left(px(24.0))
        .x_label_area_size(0)
        .y_label_area_size(0)
        .right_y_label_area_size(px(62.0))
        .build_cartesian_2d(0.0..1.0, scale.range.clone())?;
    let strips = 128;
    let level = |k: i32| most * f64::from(k) / f64::from(strips);
    chart.draw_series((0..strips).map(|k| {
        let color = colour(f64::from(k) / f64::from(strips - 1));
        // each strip extends one strip beyond its share, so that no seam is visible below the next
        Rectangle::new([(0.0, level(k)), (1.0, level((k + 2).min(strips)))], color.filled())
    }))?;
    chart
        .configure_mesh()
        .disable_mesh()
        .disable_x_axis()
        .axis_style(line(INK, 1.2))
        .set_all_tick_mark_size(px(5.0))
        .label_style(text(TICK_PX, INK, (HPos::Left, VPos::Center)))
        .axis_desc_style(text(LABEL_PX, INK, (HPos::Center, VPos::Center)))
        .y_labels(scale.ticks)
        .y_label_formatter(&|v| scale.label(*v))
        .y_desc(format!("{quantity} [{}]", unit.symbol))
        .draw()
}

/// Draws a bar of a round length, about a sixth of the width of the picture, at the bottom left.
pub fn scale_bar<DB: DrawingBackend>(area: &Area<DB>, view: &View) -> Drawn<DB> {
    let wish_m = f64::from(area.dim_in_pixel().0) / 6.0 / view.scale;
    let decade = 10_f64.powf(wish_m.log10().floor());
    let length_m = [5.0, 2.0, 1.0].into_iter().map(|k| k * decade).find(|l| *l <= wish_m).unwrap_or(decade);
    let (left, y) = (px(MARGIN_PX), area.dim_in_pixel().1.cast_signed() - px(34.0));
    let right = left + (length_m * view.scale).round() as i32;
    area.draw(&PathElement::new([(left, y), (right, y)], line(INK, 2.0)))?;
    for x in [left, right] {
        area.draw(&PathElement::new([(x, y - px(5.0)), (x, y + px(5.0))], line(INK, 2.0)))?;
    }
    let unit = Unit::of_length([length_m]);
    let label = format!("{} {}", (length_m * unit.per_si * 1e6).round() / 1e6, unit.symbol);
    let style = text(LABEL_PX, MUTED, (HPos::Left, VPos::Center));
    area.draw_text(&label, &style, (right + px(10.0), y))
}
