//! Strips of the last seconds, with one dot per record: nothing was measured between two records.

use std::collections::VecDeque;

use eframe::egui::{Color32, RichText, Ui};
use egui_plot::{Line, LineStyle, PlotPoints, Points};

use super::feed::Dot;
use crate::strips::{SPAN_S, still_plot};

/// Colour of the force of this machine's patch.
const HERE: Color32 = Color32::from_rgb(120, 120, 130);

/// Records of the last seconds before the newest record.
#[derive(Debug, Default)]
pub struct Strips {
    dots: VecDeque<Dot>,
}

struct Strip {
    title: &'static str,
    value: fn(&Dot) -> Option<f32>,
    /// Value computed on this machine, drawn as a dashed line.
    here: Option<fn(&Dot) -> Option<f32>>,
    colour: Color32,
    factor: f64,
    /// Least upper end of the scale.
    least: f64,
    digits: usize,
}

const STRIPS: [Strip; 4] = [
    Strip {
        title: "board: force applied N, 8 s",
        value: |dot| Some(dot.applied_n),
        here: None,
        colour: Color32::from_rgb(205, 70, 45),
        factor: 1.0,
        least: 0.1,
        digits: 3,
    },
    Strip {
        title: "board's patch N (dashed: here)",
        value: |dot| Some(dot.model_n),
        here: Some(|dot| dot.twin_n),
        colour: Color32::from_rgb(50, 140, 90),
        factor: 1.0,
        least: 0.1,
        digits: 3,
    },
    Strip {
        title: "board: depth mm",
        value: |dot| Some(dot.depth_m),
        here: None,
        colour: Color32::from_rgb(31, 111, 180),
        factor: 1e3,
        least: 4.0,
        digits: 2,
    },
    Strip {
        title: "board: tick us of 1000",
        value: |dot| dot.tick_us,
        here: None,
        colour: Color32::from_rgb(140, 100, 180),
        factor: 1.0,
        least: 1050.0,
        digits: 0,
    },
];

impl Strips {
    /// Adds records.
    pub fn add(&mut self, dots: &[Dot]) {
        self.dots.extend(dots);
        let newest_s = self.newest_s();
        while self.dots.front().is_some_and(|dot| dot.t_s < newest_s - SPAN_S) {
            self.dots.pop_front();
        }
    }

    /// Clears the strips, because another file begins.
    pub fn clear(&mut self) {
        self.dots.clear();
    }

    /// Number of records that are shown.
    #[must_use]
    pub fn len(&self) -> usize {
        self.dots.len()
    }

    fn newest_s(&self) -> f64 {
        self.dots.back().map_or(0.0, |dot| dot.t_s)
    }

    /// Draws the strips side by side; `live` is false if the newest value is no longer current.
    pub fn show(&self, ui: &mut Ui, live: bool) {
        let (width, height) = (ui.available_width() / STRIPS.len() as f32 - 8.0, ui.available_height());
        if width < 40.0 || height < 40.0 {
            return;
        }
        ui.horizontal_top(|ui| {
            for strip in &STRIPS {
                ui.vertical(|ui| {
                    ui.set_width(width);
                    let last = self.dots.back().filter(|_| live).and_then(strip.value).map(|last| f64::from(last) * strip.factor);
                    let last = last.map_or_else(|| "-".into(), |last| format!("{last:.*}", strip.digits));
                    ui.label(RichText::new(format!("{}   {last}", strip.title)).color(strip.colour).strong());
                    self.strip(ui, strip, height - 24.0);
                });
            }
        });
    }

    fn strip(&self, ui: &mut Ui, strip: &Strip, height: f32) {
        let points = |value: fn(&Dot) -> Option<f32>| -> Vec<[f64; 2]> {
            let newest_s = self.newest_s();
            let at = |dot: &Dot| value(dot).map(|value| [dot.t_s - newest_s, f64::from(value) * strip.factor]);
            self.dots.iter().filter_map(at).collect()
        };
        let (board, here) = (points(strip.value), strip.here.map(points).unwrap_or_default());
        let most = board.iter().chain(&here).map(|point| point[1]).fold(strip.least, f64::max) * 1.08;
        still_plot(strip.title, height).show(ui, |plot| {
            plot.set_plot_bounds_x(-SPAN_S..=0.0);
            plot.set_plot_bounds_y(0.0..=most);
            plot.points(Points::new("board", PlotPoints::from(board)).color(strip.colour).radius(1.6));
            if !here.is_empty() {
                plot.line(Line::new("here", PlotPoints::from(here)).color(HERE).width(1.0).style(LineStyle::dashed_loose()));
            }
        });
    }
}
