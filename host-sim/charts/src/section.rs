//! Draws the tissue cut open through the probe, at rest and at one or two holds, with dent, mesh
//! and force.

mod cut;
mod tip;

use std::path::Path;

use plotters::element::{PathElement, Polygon};
use plotters::prelude::{DrawingBackend, RGBColor};
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{Color, FontStyle, WHITE};

use super::axis::{Axis, Unit};
use super::canvas::{Area, Drawn};
use super::layout::{MARGIN_PX, TITLE_HEIGHT_PX, title};
use super::picture::{Picture, save};
use super::place::Frame;
use super::style::{INK, LABEL_PX, MUTED, REFERENCE, TICK_PX, TITLE_PX, WARN, line, px, styled, text};
use super::surface::Probe;
use super::surface::facets::{Skin, high_lamp};
use super::surface::scales::{BAR_PX, colour, colour_bar, scale_bar, shaded};
use super::surface::view::{V3, View};
use super::{ChartError, check};
use cut::{Corner, Window};

/// A tet mesh of tissue that is cut open.
#[derive(Clone, Copy, Debug)]
pub struct Section<'a> {
    /// Name of the scene, with which the title begins.
    pub scene: &'a str,
    /// Line below the title.
    pub caption: &'a str,
    /// Node positions at rest [m], shape [nodes][3].
    pub rest_m: &'a [[f64; 3]],
    /// Nodes of each tet, shape [tets][4].
    pub tets: &'a [[u32; 4]],
    /// Nodes of each surface triangle, counter-clockwise seen from outside, shape [triangles][3].
    pub triangles: &'a [[u32; 3]],
    /// Whether each node is fixed, shape \[nodes\].
    pub fixed: &'a [bool],
    /// Balls whose stiffness differs from the tissue around them: centre at rest [m] and radius
    /// [m].
    pub balls_m: &'a [([f64; 3], f64)],
    /// Direction of the press, out of the tissue, of any non-zero length: it is up in the picture.
    pub up: [f64; 3],
    /// One to three moments of the press, from left to right.
    pub moments: &'a [Moment<'a>],
}

/// State of the tissue at one moment of a press.
#[derive(Clone, Copy, Debug)]
pub struct Moment<'a> {
    /// Node positions [m], shape [nodes][3].
    pub deformed_m: &'a [[f64; 3]],
    /// Probe that presses on the tissue.
    pub probe: Probe,
    /// Depth of the tip below the surface at rest [m].
    pub depth_m: f64,
    /// Force on the probe along the press [N]; positive pushes the probe out of the tissue.
    pub force_n: f64,
}

/// Writes `NAME.svg` and `NAME.png` into `folder`.
pub fn section(folder: &Path, name: &str, section: &Section) -> Result<(), ChartError> {
    section.check()?;
    let Some(last) = section.moments.last() else { return Err(ChartError::Empty { what: "moments" }) };
    let moved = section.moments.iter().flat_map(|m| moved_m(section.rest_m, m.deformed_m));
    let most_m = moved.fold(0.0, f64::max);
    let unit = Unit::of_length([most_m]);
    let force = Unit::of_force(section.moments.iter().map(|m| m.force_n));
    let picture = SectionPicture { section, last, scale: Axis::to_a_tick(most_m * unit.per_si, 6), unit, force };
    save(folder, name, &picture)
}

fn moved_m<'a>(rest_m: &'a [[f64; 3]], now_m: &'a [[f64; 3]]) -> impl Iterator<Item = f64> + 'a {
    rest_m.iter().zip(now_m).map(|(a, b)| (V3::from(*b) - V3::from(*a)).norm())
}

impl Section<'_> {
    fn check(&self) -> Result<(), ChartError> {
        if self.tets.is_empty() {
            return Err(ChartError::Empty { what: "tets" });
        }
        let counts = self.moments.iter().map(|m| m.deformed_m.len());
        let node_count = counts.fold(self.rest_m.len().min(self.fixed.len()), usize::min);
        let known = |what: &'static str, items: &mut dyn Iterator<Item = &[u32]>| {
            let missing = |(item, nodes): (usize, &[u32])| Some((item, *nodes.iter().find(|n| **n as usize >= node_count)?));
            match items.enumerate().find_map(missing) {
                Some((item, node)) => Err(ChartError::NoSuchNode { what, item, node, node_count }),
                None => Ok(()),
            }
        };
        known("triangles", &mut self.triangles.iter().map(|t| &t[..]))?;
        known("tets", &mut self.tets.iter().map(|t| &t[..]))?;
        check("rest_m (x, y, z in turn)", self.rest_m.iter().flatten().copied())?;
        check("up", self.up)?;
        check("balls_m radius", self.balls_m.iter().map(|ball| ball.1))?;
        for moment in self.moments {
            check("deformed_m (x, y, z in turn)", moment.deformed_m.iter().flatten().copied())?;
            check("probe tip_m", moment.probe.tip_m)?;
            check("probe axis", moment.probe.axis)?;
            check("depth_m and force_n", [moment.depth_m, moment.force_n])?;
        }
        Ok(())
    }
}

struct SectionPicture<'a> {
    section: &'a Section<'a>,
    /// The last and deepest moment, through whose tip the cut passes.
    last: &'a Moment<'a>,
    /// Colour scale, in `unit`.
    scale: Axis,
    unit: Unit,
    force: Unit,
}

/// Sine and cosine of the elevation of the eye above the surface: 22 degrees.
const RISE: (f64, f64) = (0.375, 0.927);
/// Half of the width, the depth below the site and the height above the site that are shown, and
/// the distance behind the cut that is shown, each divided by the half-width of the probe (1).
const SHOWN: [f64; 4] = [2.4, 5.2, 3.1, 2.0];
/// Length of the longest arrow, divided by the half-width of the probe (1).
const ARROW: f64 = 2.4;
/// Share of white that is mixed into the colours of the tissue, so that the mesh is visible on them
/// (1).
const PALE: f64 = 0.25;
/// Colour that is mixed into the tissue's colour inside a ball of another stiffness.
const BALL: RGBColor = WARN;

impl SectionPicture<'_> {
    /// Cut plane and visible part that are common to all moments.
    fn window(&self) -> Window {
        let probe = &self.last.probe;
        let up = V3::from(self.section.up).try_normalize(0.0).unwrap_or_else(V3::z);
        let right = tip::cut_direction(probe, up);
        let front = right.cross(&up);
        let size_m = tip::half_width_m(probe);
        let middle_m = probe.direction() * probe.radius_m;
        Window {
            // in the plane through the middle of the tip, which a tilt moves off that of the press
            site_m: V3::from(probe.tip_m) + up * self.last.depth_m + front * middle_m.dot(&front),
            right,
            up,
            front,
            half_width_m: SHOWN[0] * size_m,
            depth_m: SHOWN[1] * size_m,
            behind_m: SHOWN[3] * size_m,
        }
    }

    /// Projection of moment `k` into its part of the picture.
    fn view(&self, window: &Window, area: (u32, u32), k: usize) -> View {
        let (width, height) = (f64::from(area.0), f64::from(area.1));
        let left = f64::from(px(MARGIN_PX));
        let each = (width - left - f64::from(px(BAR_PX + MARGIN_PX + 16.0))) / self.section.moments.len() as f64;
        let edge = |n: f64| (left + n * each) as i32;
        let frame = Frame {
            low: (edge(k as f64) + px(5.0), px(TITLE_HEIGHT_PX + 8.0)),
            high: (edge(k as f64 + 1.0) - px(5.0), height as i32 - px(150.0)),
        };
        let (sine, cosine) = RISE;
        let (size_m, w) = (tip::half_width_m(&self.last.probe), window);
        // the picture ends where the tissue ends
        let low_m = self.lowest_m(window).min(w.depth_m);
        let corner = |x: f64, up: f64| w.site_m + w.right * (x * w.half_width_m) + w.up * up;
        let corners =
            [corner(-1.0, -low_m), corner(1.0, -low_m), corner(-1.0, SHOWN[2] * size_m), corner(1.0, SHOWN[2] * size_m)];
        View::from_eye(w.front * cosine + w.up * sine, w.up, &corners.into_iter(), frame)
    }

    /// Largest depth of the tissue below the site at rest, along the press [m].
    fn lowest_m(&self, w: &Window) -> f64 {
        let below = self.section.rest_m.iter().map(|x| (w.site_m - V3::from(*x)).dot(&w.up));
        below.fold(0.0, f64::max)
    }

    /// Draws the surface behind the cut, farthest pieces first.
    fn behind<DB: DrawingBackend>(&self, area: &Area<DB>, window: &Window, view: &View, moment: &Moment) -> Drawn<DB> {
        let moved: Vec<f64> = moved_m(self.section.rest_m, moment.deformed_m).collect();
        let skin = Skin {
            places_m: moment.deformed_m,
            triangles: self.section.triangles,
            moved_m: &moved,
            scale_m: self.scale.range.end / self.unit.per_si,
            lamp: high_lamp(view),
            largest_px: f64::INFINITY,
        };
        for triangle in window.behind(&skin, view) {
            let points: Vec<_> = triangle.corners.iter().map(|c| view.spot(c.at)).collect();
            let fill = shaded(self.colour(&triangle.corners), triangle.light);
            closed(area, points, fill, mixed(fill, MUTED, 0.5), 0.6)?;
        }
        Ok(())
    }

    fn colour(&self, corners: &[Corner]) -> RGBColor {
        let mean_m = corners.iter().map(|c| c.moved_m).sum::<f64>() / corners.len().max(1) as f64;
        mixed(colour(mean_m * self.unit.per_si / self.scale.range.end), WHITE, PALE)
    }

    /// Draws the cut face: one polygon for each tet that the plane cuts.
    fn face<DB: DrawingBackend>(&self, area: &Area<DB>, window: &Window, view: &View, moment: &Moment) -> Drawn<DB> {
        let section = self.section;
        let moved: Vec<f64> = moved_m(section.rest_m, moment.deformed_m).collect();
        for tet in section.tets {
            let corners = window.through(tet, moment.deformed_m, &moved);
            if corners.len() < 3 {
                continue;
            }
            let middle = tet.iter().map(|n| V3::from(section.rest_m[*n as usize])).sum::<V3>() / 4.0;
            let in_ball = section.balls_m.iter().any(|(at, radius)| (middle - V3::from(*at)).norm() <= *radius);
            let fill = self.colour(&corners);
            let fill = if in_ball { mixed(fill, BALL, 0.55) } else { fill };
            let points = corners.iter().map(|c| view.spot(c.at)).collect();
            closed(area, points, fill, INK, 0.8)?;
        }
        // surface at rest, with hatching where it is fixed
        for [a, b] in window.outline(section.triangles, section.rest_m, |_| true) {
            area.draw(&PathElement::new([view.spot(a), view.spot(b)], line(INK, 1.1)))?;
        }
        for [a, b] in window.outline(section.triangles, section.rest_m, |n| section.fixed[n]) {
            self.hatch(area, view, a, b)?;
        }
        Ok(())
    }

    /// Draws a fixed edge, with short strokes that point outward.
    fn hatch<DB: DrawingBackend>(&self, area: &Area<DB>, view: &View, a: V3, b: V3) -> Drawn<DB> {
        let (from, to) = (view.spot(a), view.spot(b));
        area.draw(&PathElement::new([from, to], line(INK, 2.2)))?;
        let length = f64::from(to.0 - from.0).hypot(f64::from(to.1 - from.1));
        let strokes = (length / f64::from(px(7.0))).ceil().max(1.0) as i32;
        for k in 0..strokes {
            let at = |c: (i32, i32)| (c.0 + (to.0 - from.0) * k / strokes, c.1 + (to.1 - from.1) * k / strokes);
            let (x, y) = at(from);
            area.draw(&PathElement::new([(x, y), (x - px(6.0), y + px(8.0))], line(INK, 1.0)))?;
        }
        Ok(())
    }

    /// Draws the arrow of the force, and writes depth and force below the frame.
    fn force<DB: DrawingBackend>(&self, area: &Area<DB>, window: &Window, view: &View, moment: &Moment) -> Drawn<DB> {
        let size_m = tip::half_width_m(&moment.probe);
        let most_n = self.section.moments.iter().map(|m| m.force_n).fold(0.0, f64::max);
        let (tip_m, up) = (V3::from(moment.probe.tip_m), window.up);
        if most_n > 0.0 && moment.force_n > 0.02 * most_n {
            let foot = tip_m + up * (0.35 * size_m);
            let head = foot + up * (ARROW * size_m * moment.force_n / most_n);
            let (from, to) = (view.spot(foot), view.spot(head));
            area.draw(&PathElement::new([from, (to.0, to.1 + px(8.0))], line(REFERENCE, 4.0)))?;
            let head = vec![(to.0, to.1), (to.0 - px(7.0), to.1 + px(13.0)), (to.0 + px(7.0), to.1 + px(13.0))];
            area.draw(&Polygon::new(head, REFERENCE.filled()))?;
        }
        let middle = view.spot(window.site_m).0;
        let bottom = area.dim_in_pixel().1.cast_signed();
        let depth = if moment.depth_m > 0.0 { format!("{} deep", self.unit.say(moment.depth_m)) } else { "at rest".to_owned() };
        let style = styled(TITLE_PX, FontStyle::Bold, INK, (HPos::Center, VPos::Top));
        area.draw_text(&depth, &style, (middle, bottom - px(130.0)))?;
        let style = styled(TITLE_PX, FontStyle::Bold, REFERENCE, (HPos::Center, VPos::Top));
        let force = if moment.depth_m > 0.0 { self.force.say(moment.force_n) } else { "no force".to_owned() };
        area.draw_text(&force, &style, (middle, bottom - px(104.0)))
    }

    /// Writes the explanation of lines and colours at the bottom.
    fn legend<DB: DrawingBackend>(&self, area: &Area<DB>) -> Drawn<DB> {
        let mut words = "polygons: tets that the cut goes through; black line: surface at rest; hatched: fixed".to_owned();
        if !self.section.balls_m.is_empty() {
            words.push_str("; red: nodule");
        }
        let style = text(TICK_PX, MUTED, (HPos::Left, VPos::Center));
        let bottom = area.dim_in_pixel().1.cast_signed();
        area.draw_text(&words, &style, (px(MARGIN_PX + 220.0), bottom - px(34.0)))?;
        let style = text(LABEL_PX, REFERENCE, (HPos::Left, VPos::Center));
        area.draw_text("arrow: force on the finger", &style, (px(MARGIN_PX + 220.0), bottom - px(58.0)))
    }
}

/// Draws a filled polygon with a line around it.
fn closed<DB: DrawingBackend>(
    area: &Area<DB>,
    mut points: Vec<(i32, i32)>,
    fill: RGBColor,
    edge: RGBColor,
    width_px: f64,
) -> Drawn<DB> {
    area.draw(&Polygon::new(points.clone(), fill.filled()))?;
    points.extend(points.first().copied());
    area.draw(&PathElement::new(points, line(edge, width_px)))
}

/// Mixes a `share` (0 to 1) of `b` into `a`.
fn mixed(a: RGBColor, b: RGBColor, share: f64) -> RGBColor {
    let mix = |a: u8, b: u8| (f64::from(a) * (1.0 - share) + f64::from(b) * share) as u8;
    RGBColor(mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
}

impl Picture for SectionPicture<'_> {
    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Drawn<DB> {
        title(area, &format!("{}: the tissue gives way", self.section.scene), self.section.caption)?;
        let window = self.window();
        for (k, moment) in self.section.moments.iter().enumerate() {
            let view = self.view(&window, area.dim_in_pixel(), k);
            self.behind(area, &window, &view, moment)?;
            for slice in tip::slices(&moment.probe, &window) {
                let points = slice.outline_m.iter().map(|p| view.spot(*p)).collect();
                let grey = (110.0 + 110.0 * slice.light) as u8;
                let fill = RGBColor(grey, grey, grey.saturating_add(6));
                closed(area, points, fill, fill, 0.5)?;
            }
            self.face(area, &window, &view, moment)?;
            let profile = tip::profile(&moment.probe, &window).iter().map(|p| view.spot(*p)).collect();
            closed(area, profile, mixed(WHITE, MUTED, 0.18), INK, 1.6)?;
            self.force(area, &window, &view, moment)?;
            if k == 0 {
                scale_bar(area, &view)?;
            }
        }
        colour_bar(area, &self.scale, "displacement", self.unit)?;
        self.legend(area)
    }
}
