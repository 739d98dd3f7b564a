//! Colour and shape of the marker of each method; the size of a marker grows with the mesh.

use plotters::element::{PathElement, Polygon};
use plotters::prelude::DrawingBackend;
use plotters::style::{Color, RGBColor};

use super::canvas::{Area, Drawn};
use super::style::line;

/// Marker and colour of a method's points.
#[derive(Clone, Copy)]
pub struct Look {
    pub color: RGBColor,
    pub shape: Marker,
}

/// Shape of a marker.
#[derive(Clone, Copy)]
pub enum Marker {
    Disc,
    Square,
    Diamond,
    Up,
    Down,
    Star,
    Plus,
    Cross,
}

const LOOKS: [Look; 15] = [
    Look { color: RGBColor(0x8c, 0x95, 0x9e), shape: Marker::Disc },
    Look { color: RGBColor(0x5f, 0x68, 0x70), shape: Marker::Up },
    Look { color: RGBColor(0xb0, 0xa0, 0x60), shape: Marker::Diamond },
    Look { color: RGBColor(0x4f, 0x9e, 0xd9), shape: Marker::Square },
    Look { color: RGBColor(0x2a, 0x6f, 0xb0), shape: Marker::Diamond },
    Look { color: RGBColor(0x12, 0x3f, 0x7d), shape: Marker::Disc },
    Look { color: RGBColor(0x0b, 0x1f, 0x4a), shape: Marker::Star },
    Look { color: RGBColor(0xe8, 0x1e, 0x3c), shape: Marker::Star },
    Look { color: RGBColor(0xd9, 0x82, 0x1b), shape: Marker::Up },
    Look { color: RGBColor(0xc2, 0x3b, 0x2b), shape: Marker::Square },
    Look { color: RGBColor(0xe0, 0x5f, 0x9a), shape: Marker::Diamond },
    Look { color: RGBColor(0x1f, 0xa8, 0xa0), shape: Marker::Square },
    Look { color: RGBColor(0x2f, 0x93, 0x57), shape: Marker::Down },
    Look { color: RGBColor(0x8a, 0x5a, 0xb8), shape: Marker::Disc },
    Look { color: RGBColor(0x7a, 0x52, 0x36), shape: Marker::Up },
];

/// Looks of the series that follow the methods in the legend: first our own models again, then
/// other engines, which are drawn as crosses and in bright shapes that no method has.
const FURTHER: [Look; 11] = [
    Look { color: RGBColor(0x5b, 0xa3, 0xe0), shape: Marker::Square },
    Look { color: RGBColor(0x96, 0x4b, 0x20), shape: Marker::Cross },
    Look { color: RGBColor(0xd6, 0x2a, 0x2a), shape: Marker::Cross },
    Look { color: RGBColor(0xf0, 0x8c, 0x1d), shape: Marker::Cross },
    Look { color: RGBColor(0x17, 0x7a, 0x35), shape: Marker::Plus },
    Look { color: RGBColor(0x86, 0xb8, 0x1b), shape: Marker::Plus },
    Look { color: RGBColor(0xc0, 0x2a, 0x9c), shape: Marker::Up },
    Look { color: RGBColor(0x6a, 0x35, 0xb5), shape: Marker::Down },
    Look { color: RGBColor(0xb0, 0x8a, 0xe0), shape: Marker::Down },
    Look { color: RGBColor(0xd9, 0xa4, 0x00), shape: Marker::Down },
    Look { color: RGBColor(0x7a, 0x7a, 0x7a), shape: Marker::Disc },
];

/// Look of the series at position `index` of the legend of methods.
pub fn look(index: usize) -> Look {
    LOOKS.iter().chain(FURTHER.iter().cycle()).nth(index).copied().unwrap_or(LOOKS[0])
}

/// Looks for a small number of series: neighbours differ in hue, lightness and shape.
pub const DISTINCT: [Look; 8] = [
    Look { color: RGBColor(0x1f, 0x6f, 0xb4), shape: Marker::Disc },
    Look { color: RGBColor(0xe3, 0x8b, 0x1d), shape: Marker::Square },
    Look { color: RGBColor(0x2f, 0x93, 0x57), shape: Marker::Up },
    Look { color: RGBColor(0xb3, 0x26, 0x4e), shape: Marker::Diamond },
    Look { color: RGBColor(0x6d, 0x4a, 0xa8), shape: Marker::Down },
    Look { color: RGBColor(0x4a, 0x53, 0x5c), shape: Marker::Star },
    Look { color: RGBColor(0x5b, 0xb8, 0xcf), shape: Marker::Square },
    Look { color: RGBColor(0x8a, 0x5f, 0x3a), shape: Marker::Disc },
];

/// Look of the series at position `index` of the legend, for charts of a few series.
pub fn distinct(index: usize) -> Look {
    DISTINCT[index % DISTINCT.len()]
}

/// Radius of a marker [px]: proportional to the fourth root of the number of nodes; that of a
/// method without nodes is one that is easily seen.
pub fn radius_px(nodes: usize) -> f64 {
    if nodes == 0 {
        return 6.0;
    }
    (1.45 * (nodes as f64).powf(0.25)).clamp(3.0, 10.0)
}

/// Draws a marker, filled or as an outline.
pub fn draw<DB: DrawingBackend>(area: &Area<DB>, look: Look, center: (i32, i32), radius: i32, hollow: bool) -> Drawn<DB> {
    let mut corners = outline(look.shape, center, radius);
    if !hollow {
        return area.draw(&Polygon::new(corners, look.color.filled()));
    }
    corners.extend_from_within(..1);
    area.draw(&PathElement::new(corners, line(look.color, 1.8)))
}

/// Corners of a marker on the canvas [canvas units].
pub fn outline(shape: Marker, (x, y): (i32, i32), radius: i32) -> Vec<(i32, i32)> {
    if let Marker::Plus | Marker::Cross = shape {
        return bars(matches!(shape, Marker::Cross), (x, y), f64::from(radius.max(0)));
    }
    // (number of corners, first angle in turns from the right, factor by which shapes appear
    // equally large, inner radius of a star)
    let (corners, first, size, inner) = match shape {
        Marker::Disc | Marker::Plus | Marker::Cross => (32, 0.0, 1.0, 1.0),
        Marker::Square => (4, 0.125, 1.25, 1.0),
        Marker::Diamond => (4, 0.0, 1.3, 1.0),
        Marker::Up => (3, 0.25, 1.4, 1.0),
        Marker::Down => (3, 0.75, 1.4, 1.0),
        Marker::Star => (10, 0.25, 1.75, 0.45),
    };
    (0..corners)
        .map(|k| {
            let angle = std::f64::consts::TAU * (first + f64::from(k) / f64::from(corners));
            let r = f64::from(radius.max(0)) * size * if k % 2 == 1 { inner } else { 1.0 };
            (x + (r * angle.cos()).round() as i32, y - (r * angle.sin()).round() as i32)
        })
        .collect()
}

/// Outline of two crossed bars: upright, or turned by an eighth of a turn.
fn bars(turned: bool, (x, y): (i32, i32), radius: f64) -> Vec<(i32, i32)> {
    let (long, half) = (1.45 * radius, 0.45 * radius);
    let quarter = [(half, long), (half, half), (long, half)];
    let angle = if turned { std::f64::consts::FRAC_PI_4 } else { 0.0 };
    let corner = |turns: usize, (a, b): (f64, f64)| {
        let (sin, cos) = (angle - turns as f64 * std::f64::consts::FRAC_PI_2).sin_cos();
        (x + (a * cos - b * sin).round() as i32, y - (a * sin + b * cos).round() as i32)
    };
    (0..4).flat_map(|turns| quarter.map(|at| corner(turns, at))).collect()
}
