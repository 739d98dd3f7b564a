//! Draws force against depth for meshes of increasing fineness.

use std::path::Path;

use plotters::element::{Circle, Cross, PathElement};
use plotters::prelude::{DrawingBackend, LineSeries};
use plotters::style::Color;

use super::axis::{Axis, Unit};
use super::canvas::Area;
use super::canvas::Drawn;
use super::layout::{Labels, axes, builder, legend, title};
use super::picture::{Picture, save};
use super::style::{PRESS, REFERENCE, RELEASE, line, px};
use super::{ChartError, check};

/// Depth [m] and force [N] of every hold on one mesh.
#[derive(Clone, Debug)]
pub struct RefinementLevel {
    /// Number of nodes of the mesh.
    pub nodes: usize,
    /// Pairs (depth \[m\], force \[N\]), in the order of increasing depth.
    pub holds: Vec<(f64, f64)>,
}

/// Results of one press on several meshes.
#[derive(Clone, Copy, Debug)]
pub struct Refinement<'a> {
    /// Name of the scene, with which the title begins.
    pub scene: &'a str,
    /// Line below the title.
    pub caption: &'a str,
    /// Levels from coarse to fine.
    pub levels: &'a [RefinementLevel],
}

/// Writes `NAME.svg` and `NAME.png` into `folder`.
///
/// # Errors
/// Fails if there is no hold, if a value cannot be drawn, or if the folder cannot be written.
pub fn refinement(folder: &Path, name: &str, refinement: &Refinement) -> Result<(), ChartError> {
    let all = || refinement.levels.iter().flat_map(|level| level.holds.iter().copied());
    if all().next().is_none() {
        return Err(ChartError::Empty { what: "holds" });
    }
    check("depth", all().map(|h| h.0))?;
    check("force", all().map(|h| h.1))?;
    let (length, force) = (Unit::of_length(all().map(|h| h.0)), Unit::of_force(all().map(|h| h.1)));
    let chart = Levels {
        refinement,
        x: Axis::from_zero(all().map(|h| h.0 * length.per_si), 0.06, 10),
        y: Axis::from_zero(all().map(|h| h.1 * force.per_si), 0.10, 9),
        length,
        force,
    };
    save(folder, name, &chart)
}

struct Levels<'a> {
    refinement: &'a Refinement<'a>,
    x: Axis,
    y: Axis,
    length: Unit,
    force: Unit,
}

impl Picture for Levels<'_> {
    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Drawn<DB> {
        title(area, &format!("{}: force against depth by finite elements", self.refinement.scene), self.refinement.caption)?;
        let mut chart = builder(area).build_cartesian_2d(self.x.range.clone(), self.y.range.clone())?;
        axes(
            &mut chart,
            Labels { title: &format!("depth [{}]", self.length.symbol), ticks: self.x.ticks, of: &|v| self.x.label(*v) },
            Labels { title: &format!("force [{}]", self.force.symbol), ticks: self.y.ticks, of: &|v| self.y.label(*v) },
        )?;
        // the finest mesh is a line and is drawn first; the others are marks of decreasing size, so
        // that none hides another
        let count = self.refinement.levels.len();
        for (n, level) in self.refinement.levels.iter().enumerate().rev() {
            let at = level.holds.iter().map(|h| (h.0 * self.length.per_si, h.1 * self.force.per_si));
            let label = format!("{} nodes", level.nodes);
            match count - 1 - n {
                0 => {
                    let curve: Vec<_> = std::iter::once((0.0, 0.0)).chain(at.clone()).collect();
                    chart
                        .draw_series(LineSeries::new(curve, line(PRESS, 1.4)))?
                        .label(label)
                        .legend(|(x, y)| PathElement::new([(x, y), (x + px(26.0), y)], line(PRESS, 2.6)));
                    chart.draw_series(at.map(|p| Circle::new(p, px(3.6), PRESS.filled())))?;
                }
                1 => {
                    let ring = |p| Circle::new(p, px(8.0), line(RELEASE, 2.0));
                    chart
                        .draw_series(at.map(ring))?
                        .label(label)
                        .legend(|(x, y)| Circle::new((x + px(13.0), y), px(6.0), line(RELEASE, 2.0)));
                }
                _ => {
                    let cross = |p| Cross::new(p, px(9.0), line(REFERENCE, 1.4));
                    chart
                        .draw_series(at.map(cross))?
                        .label(label)
                        .legend(|(x, y)| Cross::new((x + px(13.0), y), px(6.0), line(REFERENCE, 1.4)));
                }
            }
        }
        legend(&mut chart)
    }
}
