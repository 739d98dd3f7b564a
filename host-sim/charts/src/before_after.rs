//! Draws the values of groups before and after a training: one dot per person and phase, a line
//! between the two dots of a person, and the means as bars.

use std::path::Path;

use plotters::element::{Circle, PathElement};
use plotters::prelude::DrawingBackend;
use plotters::style::Color;
use plotters::style::text_anchor::{HPos, VPos};

use super::axis::Axis;
use super::canvas::Area;
use super::canvas::Drawn;
use super::layout::{Labels, axes, builder, cut, title};
use super::picture::{Picture, save};
use super::speed_accuracy::marker::distinct;
use super::style::{INK, LABEL_PX, MUTED, TICK_PX, line, px, text};
use super::{ChartError, check_series};

/// Phase in which a value was measured, relative to the training.
#[derive(Clone, Copy, Debug, Eq, PartialEq)]
pub enum Phase {
    /// Measured before the training.
    Before,
    /// Measured after the training.
    After,
}

impl Phase {
    const ALL: [Self; 2] = [Self::Before, Self::After];

    fn name(self) -> &'static str {
        match self {
            Self::Before => "before",
            Self::After => "after",
        }
    }
}

/// Value of one person in one phase.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PersonValue<'a> {
    /// Label of the group.
    pub group: &'a str,
    /// Label of the person, unique in the group.
    pub person: &'a str,
    /// Phase in which the value was measured.
    pub phase: Phase,
    /// Training score of eq 14 (1), from 0 to 1.
    pub value: f64,
}

/// Writes `NAME.svg` and `NAME.png` into `folder`; `below` is the line below the title.
///
/// # Errors
/// Fails if there are no values, if one of them cannot be drawn, or if the folder cannot be
/// written.
pub fn before_after(folder: &Path, name: &str, below: &str, values: &[PersonValue]) -> Result<(), ChartError> {
    if values.is_empty() {
        return Err(ChartError::Empty { what: "values" });
    }
    for value in values {
        check_series(value.group, "value", [value.value], false)?;
    }
    let mut groups: Vec<&str> = Vec::new();
    for value in values {
        if !groups.contains(&value.group) {
            groups.push(value.group);
        }
    }
    let axis = Axis::over(0.0..values.iter().map(|v| v.value).fold(1.0, f64::max) * 1.03, 11);
    save(folder, name, &Drawing { below, values, groups, axis })
}

struct Drawing<'a> {
    below: &'a str,
    values: &'a [PersonValue<'a>],
    groups: Vec<&'a str>,
    axis: Axis,
}

/// Horizontal position of each phase, as a fraction of the width of its group (0 to 1).
fn place(phase: Phase) -> f64 {
    match phase {
        Phase::Before => 0.28,
        Phase::After => 0.72,
    }
}

impl Picture for Drawing<'_> {
    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Drawn<DB> {
        title(area, "Training score, before and after", self.below)?;
        let count = self.groups.len() as f64;
        let mut chart = builder(area).build_cartesian_2d(0.0..count, self.axis.range.clone())?;
        axes(
            &mut chart,
            Labels { title: "", ticks: 0, of: &|_| String::new() },
            Labels { title: "value by eq (14) [1]", ticks: self.axis.ticks, of: &|v| self.axis.label(*v) },
        )?;
        let at = |x: f64, y: f64| chart.backend_coord(&(x, y));
        let room = at(1.0, 0.0).0 - at(0.0, 0.0).0 - px(8.0);
        for (n, group) in self.groups.iter().enumerate() {
            let color = distinct(n).color;
            let left = n as f64;
            let dots = |phase| self.dots(group, phase);
            for (before, from) in dots(Phase::Before) {
                let Some((_, to)) = dots(Phase::After).into_iter().find(|(after, _)| after.person == before.person) else {
                    continue;
                };
                let to = at(left + to, self.value_of(group, before.person, Phase::After));
                area.draw(&PathElement::new([at(left + from, before.value), to], line_of(color)))?;
            }
            for phase in Phase::ALL {
                self.mean(area, &at, n, group, phase)?;
                for (one, x) in dots(phase) {
                    area.draw(&Circle::new(at(left + x, one.value), px(4.6), color.filled()))?;
                }
                let (x, y) = at(left + place(phase), self.axis.range.start);
                let style = text(TICK_PX, MUTED, (HPos::Center, VPos::Center));
                area.draw_text(phase.name(), &style, (x, y + px(16.0)))?;
            }
            let (x, y) = at(left + 0.5, self.axis.range.start);
            let style = text(LABEL_PX, INK, (HPos::Center, VPos::Center));
            let label = cut(area, &format!("group {group}"), &style, room)?;
            area.draw_text(&label, &style, (x, y + px(38.0)))?;
        }
        Ok(())
    }
}

fn line_of(color: plotters::style::RGBColor) -> plotters::style::ShapeStyle {
    plotters::style::ShapeStyle::from(color.mix(0.28)).stroke_width(line(color, 1.2).stroke_width)
}

impl Drawing<'_> {
    /// All values of a group in a phase, each with its horizontal position; nearly equal values are
    /// drawn side by side.
    fn dots(&self, group: &str, phase: Phase) -> Vec<(&PersonValue<'_>, f64)> {
        let here: Vec<_> = self.values.iter().filter(|v| v.group == group && v.phase == phase).collect();
        let near = |a: &PersonValue, b: &PersonValue| (a.value - b.value).abs() < 0.011;
        let step = 0.022 * self.groups.len() as f64 / 2.0;
        (here.iter().enumerate())
            .map(|(n, one)| {
                let earlier = here.iter().take(n).filter(|v| near(v, one)).count();
                let all = here.iter().filter(|v| near(v, one)).count();
                (*one, place(phase) + step * (earlier as f64 - 0.5 * (all as f64 - 1.0)))
            })
            .collect()
    }

    fn value_of(&self, group: &str, person: &str, phase: Phase) -> f64 {
        let found = self.values.iter().find(|v| v.group == group && v.person == person && v.phase == phase);
        found.map_or(0.0, |v| v.value)
    }

    fn mean<DB: DrawingBackend>(
        &self,
        area: &Area<DB>,
        at: &impl Fn(f64, f64) -> (i32, i32),
        n: usize,
        group: &str,
        phase: Phase,
    ) -> Drawn<DB> {
        let here: Vec<f64> = self.values.iter().filter(|v| v.group == group && v.phase == phase).map(|v| v.value).collect();
        if here.is_empty() {
            return Ok(());
        }
        let mean = here.iter().sum::<f64>() / here.len() as f64;
        let x = n as f64 + place(phase);
        let (left, right) = (at(x - 0.11, mean), at(x + 0.11, mean));
        area.draw(&PathElement::new([left, right], line(INK, 3.0)))?;
        // the label is on the outer side, where no line to the other phase runs
        let (corner, side) = match phase {
            Phase::Before => ((left.0 - px(5.0), left.1), HPos::Right),
            Phase::After => ((right.0 + px(5.0), right.1), HPos::Left),
        };
        area.draw_text(&format!("{mean:.3}"), &text(LABEL_PX, INK, (side, VPos::Center)), corner)
    }
}
