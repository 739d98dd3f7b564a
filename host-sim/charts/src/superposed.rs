//! Draws several surfaces in one oblique view, such as an organ at rest and deformed. A surface is
//! drawn as a solid skin, or as a wire mesh through which the others are visible.
//!
//! It uses the painter's algorithm over pieces of a few pixels, so that surfaces may intersect. The
//! outline of a wire surface is drawn on top of everything, because it is the line that a viewer
//! compares.

mod ghost;

use std::path::Path;

use plotters::element::{Circle, PathElement, Polygon};
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{Color, RGBColor, ShapeStyle, WHITE};

use super::canvas::Area;
use super::canvas::Drawn;
use super::key_column::{self, Sign};
use super::layout::{MARGIN_PX, TITLE_HEIGHT_PX, title, width};
use super::picture::{Picture, save};
use super::place::{Frame, Page};
use super::style::{FINE, INK, TICK_PX, line, px, text};
use super::surface::facets::{Facet, Skin, faces, high_lamp};
use super::surface::scales::{scale_bar, shaded};
use super::surface::view::{V3, View};
use super::surface::whole_units;
use super::{ChartError, check, check_series};
use ghost::{Wire, outline, wires};

/// Style in which a surface is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Look {
    /// An opaque, shaded surface.
    Solid,
    /// Edges of the triangles, and the outline of the surface.
    Wire,
}

/// A surface with its name and style.
#[derive(Clone, Copy, Debug)]
pub struct Layer<'a> {
    /// Name in the legend.
    pub name: &'a str,
    /// Node positions [m], shape [nodes][3].
    pub nodes_m: &'a [[f64; 3]],
    /// Nodes of each triangle, counter-clockwise seen from outside, shape [triangles][3].
    pub triangles: &'a [[u32; 3]],
    /// Colour as red, green and blue (0 to 255).
    pub color: [u8; 3],
    /// Style in which the surface is drawn.
    pub look: Look,
}

/// A point drawn over the surfaces.
#[derive(Clone, Copy, Debug)]
pub struct Landmark<'a> {
    /// Label beside the point, where there is room; may be empty.
    pub label: &'a str,
    /// Position in the frame of the surfaces [m].
    pub at_m: [f64; 3],
}

/// Surfaces, landmarks, labels and view of one picture.
#[derive(Clone, Copy, Debug)]
pub struct Superposed<'a> {
    /// First line above the picture.
    pub title: &'a str,
    /// Second line above the picture.
    pub below: &'a str,
    /// Surfaces, in the order of the legend.
    pub layers: &'a [Layer<'a>],
    /// Points that are drawn over the surfaces; may be empty.
    pub landmarks: &'a [Landmark<'a>],
    /// Direction from the body toward the eye, of any non-zero length.
    pub eye: [f64; 3],
    /// Direction that is up in the picture, of any non-zero length.
    pub up: [f64; 3],
}

/// Writes `NAME.svg` and `NAME.png` into `folder`.
pub fn superposed(folder: &Path, name: &str, superposed: &Superposed) -> Result<(), ChartError> {
    if superposed.layers.is_empty() {
        return Err(ChartError::Empty { what: "layers" });
    }
    for layer in superposed.layers {
        if layer.triangles.is_empty() {
            return Err(ChartError::EmptySeries { series: layer.name.to_owned() });
        }
        let node_count = layer.nodes_m.len();
        for (item, nodes) in layer.triangles.iter().enumerate() {
            if let Some(&node) = nodes.iter().find(|n| **n as usize >= node_count) {
                return Err(ChartError::NoSuchNode { what: "triangles", item, node, node_count });
            }
        }
        check_series(layer.name, "nodes_m (x, y, z in turn)", layer.nodes_m.iter().flatten().copied(), false)?;
    }
    check("landmarks at_m (x, y, z in turn)", superposed.landmarks.iter().flat_map(|l| l.at_m))?;
    check("eye", superposed.eye)?;
    check("up", superposed.up)?;
    let [eye, up] = [superposed.eye, superposed.up].map(|v| V3::from(v).try_normalize(0.0));
    let (Some(eye), Some(up)) = (eye, up) else {
        return Err(ChartError::NotDrawable { what: "length of eye and up", index: 0, value: 0.0 });
    };
    save(folder, name, &Drawing { data: superposed, eye, up })
}

/// Longest side of a piece [px]; surfaces that intersect are divided into pieces of this size.
const PIECE_PX: f64 = 11.0;

struct Drawing<'a> {
    data: &'a Superposed<'a>,
    eye: V3,
    up: V3,
}

/// A piece that is painted in the order of depth.
enum Piece {
    Facet(Facet, RGBColor),
    Wire(Wire, RGBColor),
}

impl Piece {
    fn near(&self) -> f64 {
        match self {
            Self::Facet(facet, _) => facet.near,
            Self::Wire(wire, _) => wire.near,
        }
    }

    fn paint<DB: DrawingBackend>(&self, area: &Area<DB>) -> Drawn<DB> {
        match self {
            Self::Facet(facet, color) => {
                let corners = facet.grown(0.5 * f64::from(FINE)).map(whole_units);
                area.draw(&Polygon::new(corners, shaded(*color, facet.light).filled()))
            }
            Self::Wire(wire, color) => {
                let style = ShapeStyle::from(color.mix(0.75)).stroke_width(line(*color, 0.9).stroke_width);
                area.draw(&PathElement::new(wire.ends.map(whole_units), style))
            }
        }
    }
}

fn color(layer: &Layer) -> RGBColor {
    let [r, g, b] = layer.color;
    RGBColor(r, g, b)
}

impl Drawing<'_> {
    fn view(&self, frame: Frame) -> View {
        let of = |layer: &Layer<'_>| -> Vec<V3> {
            layer.triangles.iter().flatten().filter_map(|n| layer.nodes_m.get(*n as usize)).map(|x| V3::from(*x)).collect()
        };
        let mut points: Vec<V3> = self.data.layers.iter().flat_map(of).collect();
        points.extend(self.data.landmarks.iter().map(|l| V3::from(l.at_m)));
        View::from_eye(self.eye, self.up, &points.iter().copied(), frame)
    }

    /// All pieces that can hide each other, farthest first.
    fn pieces(&self, view: &View) -> Vec<Piece> {
        let mut all = Vec::new();
        for layer in self.data.layers {
            let color = color(layer);
            if layer.look == Look::Wire {
                all.extend(wires(layer, view, PIECE_PX).into_iter().map(|w| Piece::Wire(w, color)));
                continue;
            }
            let still = vec![0.0; layer.nodes_m.len()];
            let skin = Skin {
                places_m: layer.nodes_m,
                triangles: layer.triangles,
                moved_m: &still,
                scale_m: 1.0,
                lamp: high_lamp(view),
                largest_px: PIECE_PX,
            };
            for face in faces(&skin, view) {
                let parts = if face.parts.is_empty() { vec![face.whole] } else { face.parts };
                all.extend(parts.into_iter().map(|f| Piece::Facet(f, color)));
            }
        }
        all.sort_by(|a, b| a.near().total_cmp(&b.near()));
        all
    }

    fn landmarks<DB: DrawingBackend>(&self, area: &Area<DB>, view: &View, frame: Frame) -> Drawn<DB> {
        let mut page = Page::new(frame);
        let spots: Vec<_> = self.data.landmarks.iter().map(|l| view.spot(V3::from(l.at_m))).collect();
        for spot in &spots {
            page.add_dot(*spot, px(6.0));
        }
        for (landmark, spot) in self.data.landmarks.iter().zip(spots) {
            area.draw(&Circle::new(spot, px(5.4), WHITE.filled()))?;
            area.draw(&Circle::new(spot, px(4.0), INK.filled()))?;
            let plain = text(TICK_PX, INK, (HPos::Left, VPos::Center));
            let size = (width(area, landmark.label, &plain)?, px(TICK_PX * 1.1));
            if let Some((corner, anchor)) = page.place(spot, size, px(6.0)).filter(|_| !landmark.label.is_empty()) {
                // a halo keeps the letters readable on any colour
                for (dx, dy) in [(-1.2, 0.0), (1.2, 0.0), (0.0, -1.2), (0.0, 1.2)] {
                    let at = (corner.0 + px(dx), corner.1 + px(dy));
                    area.draw_text(landmark.label, &text(TICK_PX, RGBColor(255, 255, 255), anchor), at)?;
                }
                area.draw_text(landmark.label, &text(TICK_PX, INK, anchor), corner)?;
            }
        }
        Ok(())
    }
}

impl Picture for Drawing<'_> {
    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Drawn<DB> {
        title(area, self.data.title, self.data.below)?;
        let sign = |layer: &Layer| if layer.look == Look::Wire { Sign::Wire(color(layer)) } else { Sign::Patch(color(layer)) };
        let entries: Vec<_> = self.data.layers.iter().map(|l| (sign(l), l.name)).collect();
        let taken = key_column::room(area, &entries)?;
        let (right, bottom) = area.dim_in_pixel();
        let frame = Frame {
            low: (px(MARGIN_PX + 10.0), px(TITLE_HEIGHT_PX + 6.0)),
            high: (right.cast_signed() - taken - px(10.0), bottom.cast_signed() - px(60.0)),
        };
        let view = self.view(frame);
        for piece in self.pieces(&view) {
            piece.paint(area)?;
        }
        for layer in self.data.layers.iter().filter(|l| l.look == Look::Wire) {
            for ends in outline(layer, &view) {
                area.draw(&PathElement::new(ends.map(whole_units), line(color(layer), 2.0)))?;
            }
        }
        self.landmarks(area, &view, frame)?;
        key_column::draw(area, &entries, taken, px(TITLE_HEIGHT_PX))?;
        scale_bar(area, &view)
    }
}
