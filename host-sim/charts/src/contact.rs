//! Draws the pressure over a contact, seen along the probe's axis, with the centre of pressure and
//! the ellipse of the contact.

use std::path::Path;

use plotters::element::{Circle, PathElement, Polygon};
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{Color, WHITE};

use super::axis::{Axis, Unit};
use super::canvas::{Area, Drawn};
use super::layout::{MARGIN_PX, TITLE_HEIGHT_PX, title};
use super::picture::{Picture, save};
use super::place::Frame;
use super::style::{GRID, INK, MUTED, TICK_PX, line, px, text};
use super::surface::scales::{BAR_PX, colour, colour_bar, scale_bar};
use super::surface::view::{V3, View};
use super::{ChartError, check};

/// A contact map in the form in which it is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Contact<'a> {
    /// Name of the scene, with which the title begins.
    pub scene: &'a str,
    /// Line below the title.
    pub caption: &'a str,
    /// Corners of every surface triangle [m], shape [triangles][3][3].
    pub corners_m: &'a [[[f64; 3]; 3]],
    /// Pressure on each surface triangle [Pa], shape \[triangles\].
    pub pressure_pa: &'a [f64],
    /// Direction from the tissue to the eye, of any non-zero length.
    pub axis: [f64; 3],
    /// Centre of pressure [m].
    pub centre_m: [f64; 3],
    /// Half-axes of the ellipse of the contact [m].
    pub half_axes_m: [[f64; 3]; 2],
}

/// Writes `NAME.svg` and `NAME.png` into `folder`.
pub fn contact(folder: &Path, name: &str, contact: &Contact) -> Result<(), ChartError> {
    check("corners_m (x, y, z in turn)", contact.corners_m.iter().flatten().flatten().copied())?;
    check("pressure_pa", contact.pressure_pa.iter().copied())?;
    check("axis, centre and half-axes", [contact.axis, contact.centre_m].into_iter().chain(contact.half_axes_m).flatten())?;
    let most_pa = contact.pressure_pa.iter().copied().fold(0.0, f64::max);
    if most_pa <= 0.0 {
        return Err(ChartError::Empty { what: "triangles with pressure" });
    }
    let unit = Unit::of_pressure([most_pa]);
    save(folder, name, &ContactPicture { contact, unit, scale: Axis::to_a_tick(most_pa * unit.per_si, 6) })
}

struct ContactPicture<'a> {
    contact: &'a Contact<'a>,
    unit: Unit,
    /// Colour scale, in `unit`.
    scale: Axis,
}

/// Radius of the tissue that is shown around the contact, divided by the longer half-axis (1).
const AROUND: f64 = 2.0;

impl Picture for ContactPicture<'_> {
    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Drawn<DB> {
        let contact = self.contact;
        title(area, &format!("{}: pressure under the finger", contact.scene), contact.caption)?;
        let (centre, [a, b]) = (V3::from(contact.centre_m), contact.half_axes_m.map(V3::from));
        let eye = V3::from(contact.axis).try_normalize(0.0).unwrap_or_else(V3::z);
        let reach = AROUND * a.norm().max(b.norm());
        let across = |x: &[f64; 3]| {
            let d = V3::from(*x) - centre;
            d - eye * d.dot(&eye)
        };
        let near =
            |(corners, pressure): &(&[[f64; 3]; 3], &f64)| **pressure > 0.0 || corners.iter().all(|x| across(x).norm() < reach);
        let shown: Vec<_> = contact.corners_m.iter().zip(contact.pressure_pa).filter(near).collect();
        let (width, height) = area.dim_in_pixel();
        let frame = Frame {
            low: (px(MARGIN_PX), px(TITLE_HEIGHT_PX + 6.0)),
            high: (width.cast_signed() - px(BAR_PX + MARGIN_PX + 20.0), height.cast_signed() - px(60.0)),
        };
        let points = shown.iter().flat_map(|(corners, _)| corners.iter().map(|x| V3::from(*x)));
        let view = View::from_eye(eye, eye, &points, frame);
        for (corners, pressure) in &shown {
            let [p, q, r] = corners.map(|x| view.spot(V3::from(x)));
            if **pressure > 0.0 {
                let fill = colour(**pressure * self.unit.per_si / self.scale.range.end);
                area.draw(&Polygon::new(vec![p, q, r], fill.filled()))?;
            }
            area.draw(&PathElement::new(vec![p, q, r, p], line(if **pressure > 0.0 { WHITE } else { GRID }, 0.8)))?;
        }
        let ellipse = (0..=96).map(|k| (f64::from(k) * std::f64::consts::TAU / 96.0).sin_cos());
        let ellipse: Vec<_> = ellipse.map(|(s, c)| view.spot(centre + a * c + b * s)).collect();
        let axes = [a, b].map(|half| vec![view.spot(centre - half), view.spot(centre + half)]);
        // a pale halo keeps the lines visible on any colour
        for (color, extra) in [(WHITE, 1.6), (INK, 0.0)] {
            area.draw(&PathElement::new(ellipse.clone(), line(color, 1.7 + extra)))?;
            for axis in &axes {
                area.draw(&PathElement::new(axis.clone(), line(color, 0.8 + extra)))?;
            }
            area.draw(&Circle::new(view.spot(centre), px(4.0 + 0.5 * extra), color.filled()))?;
        }
        colour_bar(area, &self.scale, "pressure", self.unit)?;
        let words = "dot: centre of pressure; ellipse: extent of the contact with its axes; white: not touched";
        let style = text(TICK_PX, MUTED, (HPos::Left, VPos::Center));
        area.draw_text(words, &style, (px(MARGIN_PX + 220.0), height.cast_signed() - px(34.0)))?;
        scale_bar(area, &view)
    }
}
