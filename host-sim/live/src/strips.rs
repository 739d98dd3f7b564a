//! Strips of the last seconds: force, depth, energy, and tick time with its budget.

use std::collections::VecDeque;

use eframe::egui::{self, Color32, RichText, Ui};
use egui_plot::{HLine, Line, Plot, PlotPoints};

use crate::message::Sample;

/// Time span of a strip [s].
pub const SPAN_S: f64 = 8.0;
/// Threshold below which a part is not drawn [N].
const LEAST_PART_N: f64 = 1e-3;
/// Budget of a tick [us].
pub const BUDGET_US: f64 = 1000.0;

/// Plots of the last seconds.
#[derive(Debug, Default)]
pub struct Strips {
    samples: VecDeque<Sample>,
}

struct Strip {
    title: &'static str,
    value: fn(&Sample) -> f64,
    /// A component of the value, drawn thin in the same colour if it is not zero.
    part: Option<fn(&Sample) -> f64>,
    colour: Color32,
    /// Least upper end of the scale.
    least: f64,
    /// Largest upper end of the scale, so that one late tick does not hide all others.
    most: f64,
    digits: usize,
}

const STRIPS: [Strip; 4] = [
    Strip {
        title: "force N (thin: along), 8 s",
        value: |s| s.force_n.into(),
        part: Some(|s| s.along_n.into()),
        colour: Color32::from_rgb(205, 70, 45),
        least: 0.1,
        most: f64::MAX,
        digits: 2,
    },
    Strip {
        title: "depth mm",
        value: |s| f64::from(s.depth_m) * 1e3,
        part: None,
        colour: Color32::from_rgb(31, 111, 180),
        least: 4.0,
        most: f64::MAX,
        digits: 1,
    },
    Strip {
        title: "work of the hand mJ",
        // energy taken is the negative of energy given; 0.0 minus zero has no sign
        value: |s| 0.0 - f64::from(s.energy_j) * 1e3,
        part: None,
        colour: Color32::from_rgb(50, 140, 90),
        least: 0.1,
        most: f64::MAX,
        digits: 2,
    },
    Strip {
        title: "tick us, budget 1000",
        value: |s| s.tick_us.into(),
        part: None,
        colour: Color32::from_rgb(140, 100, 180),
        least: 1050.0,
        most: 3000.0,
        digits: 0,
    },
];

impl Strips {
    /// Adds the samples that came with a frame.
    pub fn add(&mut self, samples: &[Sample]) {
        self.samples.extend(samples);
        let newest_s = self.samples.back().map_or(0.0, |s| s.t_s);
        while self.samples.front().is_some_and(|s| s.t_s < newest_s - SPAN_S || s.t_s > newest_s) {
            self.samples.pop_front();
        }
    }

    /// Clears the strips, because another loop begins.
    pub fn clear(&mut self) {
        self.samples.clear();
    }

    /// Draws the strips side by side.
    pub fn show(&self, ui: &mut Ui) {
        let newest_s = self.samples.back().map_or(0.0, |s| s.t_s);
        let (width, height) = (ui.available_width() / STRIPS.len() as f32 - 8.0, ui.available_height());
        if width < 40.0 || height < 40.0 {
            return;
        }
        ui.horizontal_top(|ui| {
            for strip in &STRIPS {
                ui.vertical(|ui| {
                    ui.set_width(width);
                    let last = self.samples.back().map_or(0.0, strip.value);
                    ui.label(RichText::new(format!("{}   {last:.*}", strip.title, strip.digits)).color(strip.colour).strong());
                    self.strip(ui, strip, newest_s, height - 24.0);
                });
            }
        });
    }

    fn strip(&self, ui: &mut Ui, strip: &Strip, newest_s: f64, height: f32) {
        let most = self.samples.iter().map(strip.value).fold(strip.least, f64::max).min(strip.most) * 1.08;
        let points = self.points(strip.value, newest_s);
        // without friction the force along the surface is only rounding error, which is not drawn
        let part = strip.part.map(|part| self.points(part, newest_s)).filter(|points| points.iter().any(|p| p[1] > LEAST_PART_N));
        still_plot(strip.title, height).show(ui, |plot| {
            plot.set_plot_bounds_x(-SPAN_S..=0.0);
            plot.set_plot_bounds_y(0.0..=most);
            if strip.least > BUDGET_US {
                plot.hline(HLine::new("budget", BUDGET_US).color(Color32::from_rgb(200, 40, 40)).width(1.0));
            }
            plot.line(Line::new(strip.title, PlotPoints::from(points)).color(strip.colour).width(1.6));
            if let Some(part) = part {
                plot.line(Line::new("along", PlotPoints::from(part)).color(strip.colour).width(0.8));
            }
        });
    }

    /// One point per pixel: each is the largest value of its bin, so that peaks remain.
    fn points(&self, value: fn(&Sample) -> f64, newest_s: f64) -> Vec<[f64; 2]> {
        let bin = (self.samples.len() / 300).max(1);
        let mut points = Vec::with_capacity(300);
        let mut at = self.samples.iter();
        while let Some(first) = at.next() {
            let rest = at.by_ref().take(bin - 1);
            points.push([first.t_s - newest_s, rest.map(value).fold(value(first), f64::max)]);
        }
        points
    }
}

/// A plot of the last seconds, `height` points high, which the pointer can neither move nor scale.
pub fn still_plot(title: &str, height: f32) -> Plot<'_> {
    Plot::new(title)
        .height(height)
        .show_x(false)
        .show_y(false)
        .allow_zoom(false)
        .allow_drag(false)
        .allow_scroll(false)
        .allow_boxed_zoom(false)
        .allow_double_click_reset(false)
        .x_axis_formatter(|mark, _| format!("{:.0} s", mark.value))
        .set_margin_fraction(egui::vec2(0.0, 0.0))
}
