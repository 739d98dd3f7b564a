//! Draws the deformed surface, seen obliquely from the side of the probe and coloured by
//! displacement.

pub(super) mod facets;
mod probe;
pub(super) mod scales;
pub(super) mod view;

use std::path::Path;

use plotters::element::{PathElement, Polygon};
use plotters::prelude::{DrawingBackend, RGBColor};
use plotters::style::{BLACK, Color, ShapeStyle};

use super::axis::{Axis, Unit};
use super::canvas::Area;
use super::canvas::Drawn;
use super::layout::{MARGIN_PX, TITLE_HEIGHT_PX, title};
use super::picture::{Picture, save};
use super::style::{FINE, INK, line, px};
use super::{ChartError, check};
use facets::{Face, Facet, Skin, faces, low_lamp};
pub use probe::{Probe, ProbeShape};
use scales::{BAR_PX, colour, colour_bar, scale_bar, shaded};
use view::{V3, View};

/// A closed surface, at rest and deformed by a press.
#[derive(Clone, Copy, Debug)]
pub struct Surface<'a> {
    /// Name of the scene, which is the title.
    pub scene: &'a str,
    /// Line below the title: number of nodes, depth and force.
    pub caption: &'a str,
    /// Node positions at rest [m], shape [nodes][3].
    pub rest_m: &'a [[f64; 3]],
    /// Deformed node positions [m], shape [nodes][3].
    pub deformed_m: &'a [[f64; 3]],
    /// Nodes of each triangle, counter-clockwise seen from outside, shape [triangles][3].
    pub triangles: &'a [[u32; 3]],
    /// Probe that presses on the surface.
    pub probe: Probe,
}

/// Writes `NAME.svg` and `NAME.png` into `folder`.
pub fn surface(folder: &Path, name: &str, surface: &Surface) -> Result<(), ChartError> {
    surface.check()?;
    let moved_m: Vec<f64> =
        (surface.rest_m.iter().zip(surface.deformed_m)).map(|(a, b)| (V3::from(*b) - V3::from(*a)).norm()).collect();
    let used = surface.triangles.iter().flatten();
    let most_m = used.filter_map(|n| moved_m.get(*n as usize)).fold(0.0, |most: f64, m| most.max(*m));
    let unit = Unit::of_length([most_m]);
    let picture = SurfacePicture { surface, moved_m, unit, scale: Axis::to_a_tick(most_m * unit.per_si, 6) };
    save(folder, name, &picture)
}

impl Surface<'_> {
    fn check(&self) -> Result<(), ChartError> {
        if self.triangles.is_empty() {
            return Err(ChartError::Empty { what: "triangles" });
        }
        let node_count = self.rest_m.len().min(self.deformed_m.len());
        for (item, nodes) in self.triangles.iter().enumerate() {
            if let Some(&node) = nodes.iter().find(|n| **n as usize >= node_count) {
                return Err(ChartError::NoSuchNode { what: "triangles", item, node, node_count });
            }
        }
        check("rest_m (x, y, z in turn)", self.rest_m.iter().flatten().copied())?;
        check("deformed_m (x, y, z in turn)", self.deformed_m.iter().flatten().copied())?;
        check("probe tip_m", self.probe.tip_m)?;
        check("probe axis", self.probe.axis)?;
        check("probe radius_m", [self.probe.radius_m])
    }
}

struct SurfacePicture<'a> {
    surface: &'a Surface<'a>,
    /// Magnitude of the displacement of each node [m].
    moved_m: Vec<f64>,
    unit: Unit,
    /// Colour scale, in `unit`.
    scale: Axis,
}

impl SurfacePicture<'_> {
    fn view<DB: DrawingBackend>(&self, area: &Area<DB>) -> View {
        let probe = &self.surface.probe;
        let axis = probe.direction();
        let used = (self.surface.triangles.iter().flatten())
            .filter_map(|n| self.surface.deformed_m.get(*n as usize))
            .map(|x| V3::from(*x));
        let (width, height) = area.dim_in_pixel();
        let frame = super::place::Frame {
            low: (px(MARGIN_PX + 10.0), px(TITLE_HEIGHT_PX + 6.0)),
            high: (width.cast_signed() - px(BAR_PX + MARGIN_PX + 20.0), height.cast_signed() - px(60.0)),
        };
        View::onto(axis, &used.chain(probe.hull()), frame)
    }

    fn paint<DB: DrawingBackend>(&self, area: &Area<DB>, face: &Face) -> Drawn<DB> {
        let fill = |facet: &Facet| {
            let share = facet.moved_m * self.unit.per_si / self.scale.range.end;
            shaded(colour(share), facet.light)
        };
        // the whole face is first filled and outlined in its mean colour, so that no white shows
        // between the polygons
        let ground = fill(&face.whole);
        let corners = face.whole.corners.map(whole_units);
        let [a, b, c] = corners;
        area.draw(&Polygon::new(corners, ground.filled()))?;
        area.draw(&PathElement::new([a, b, c, a], line(ground, 0.4)))?;
        for facet in &face.parts {
            let corners = facet.grown(0.5 * f64::from(FINE)).map(whole_units);
            area.draw(&Polygon::new(corners, fill(facet).filled()))?;
        }
        let edge = ShapeStyle::from(BLACK.mix(0.16)).stroke_width(line(BLACK, 0.8).stroke_width);
        area.draw(&PathElement::new([a, b, c, a], edge))
    }
}

pub(super) fn whole_units((x, y): (f64, f64)) -> (i32, i32) {
    (x.round() as i32, y.round() as i32)
}

impl Picture for SurfacePicture<'_> {
    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Drawn<DB> {
        title(area, self.surface.scene, self.surface.caption)?;
        let view = self.view(area);
        let scale_m = self.scale.range.end / self.unit.per_si;
        let skin = Skin {
            places_m: self.surface.deformed_m,
            triangles: self.surface.triangles,
            moved_m: &self.moved_m,
            scale_m,
            lamp: low_lamp(&view),
            largest_px: f64::INFINITY,
        };
        for face in faces(&skin, &view) {
            self.paint(area, &face)?;
        }
        let wires = self.surface.probe.wire(&view);
        // a pale halo under every line keeps the wire readable on any colour
        for (color, extra) in [(RGBColor(255, 255, 255), 1.6), (INK, 0.0)] {
            for wire in &wires {
                let points: Vec<_> = wire.points.iter().map(|p| view.spot(*p)).collect();
                let width = if wire.outline { 1.7 } else { 0.8 };
                area.draw(&PathElement::new(points, line(color, width + extra)))?;
            }
        }
        colour_bar(area, &self.scale, "displacement", self.unit)?;
        scale_bar(area, &view)
    }
}
