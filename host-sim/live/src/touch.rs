//! The current touch, or else the last one: how its force decays in a hold, and how large the share
//! of the force along the surface is.

use eframe::egui::{Align2, Color32, FontId, Painter, Rect, Shape as Drawn, Stroke, pos2, vec2};

use crate::message::Sample;

/// Largest number of points that are kept; at that number every other one is dropped.
const MOST: usize = 512;
/// Duration from which on a touch is drawn [s].
const LEAST_S: f32 = 0.3;
/// Force below which the share along the surface is taken as zero [N].
const LEAST_N: f32 = 2e-3;

/// Force since the probe touched the surface.
#[derive(Clone, Debug, Default)]
pub struct Touch {
    begun_s: f64,
    touching: bool,
    points: Vec<Point>,
    /// Number of samples of which one is kept.
    every: usize,
    skipped: usize,
    peak_n: f32,
}

#[derive(Clone, Copy, Debug)]
struct Point {
    since_s: f32,
    force_n: f32,
    along_n: f32,
    depth_m: f32,
}

impl Point {
    /// Ratio of the force along the surface to the force into it (1), which friction bounds.
    fn drag(&self) -> f32 {
        let into_n = (self.force_n.powi(2) - self.along_n.powi(2)).max(0.0).sqrt();
        if into_n < LEAST_N { 0.0 } else { self.along_n / into_n }
    }
}

impl Touch {
    /// Adds the samples that came with a frame.
    pub fn add(&mut self, samples: &[Sample]) {
        for sample in samples {
            // a probe that rubs along a flank has a force, but no depth below its tip
            let touches = sample.depth_m > 0.0 || sample.force_n > LEAST_N;
            if touches && !self.touching {
                *self = Self { begun_s: sample.t_s, every: 1, ..Self::default() };
            }
            if self.touching && !touches {
                self.forget_the_lift();
            }
            self.touching = touches;
            if !touches {
                continue;
            }
            self.peak_n = self.peak_n.max(sample.force_n);
            self.skipped += 1;
            if self.skipped < self.every {
                continue;
            }
            self.skipped = 0;
            let since_s = (sample.t_s - self.begun_s) as f32;
            self.points.push(Point { since_s, force_n: sample.force_n, along_n: sample.along_n, depth_m: sample.depth_m });
            if self.points.len() >= MOST {
                self.points = self.points.iter().skip(1).step_by(2).copied().collect();
                self.every *= 2;
            }
        }
    }

    /// Drops the points of the retreat: the force that remains there is no property of the tissue.
    fn forget_the_lift(&mut self) {
        let lifts = |pair: &[Point]| matches!(pair, [.., before, last] if last.depth_m < before.depth_m);
        while lifts(&self.points) {
            self.points.pop();
        }
    }

    /// Returns the displayed touch in numbers, as JSON.
    #[must_use]
    pub fn numbers(&self) -> serde_json::Value {
        let last = self.points.last();
        serde_json::json!({
            "since_s": last.map(|p| p.since_s), "left": last.map(|p| p.force_n / self.peak_n.max(LEAST_N)),
            "drag": last.map(Point::drag),
        })
    }

    /// Draws the touch into a corner of the picture; `friction` is the coefficient, zero without
    /// friction.
    pub fn draw(&self, painter: &Painter, picture: Rect, dark: bool, friction: f32) {
        let Some(last) = self.points.last().filter(|last| last.since_s >= LEAST_S) else { return };
        let ink = if dark { Color32::from_gray(225) } else { Color32::from_gray(50) };
        let ground = if dark { Color32::from_black_alpha(120) } else { Color32::from_white_alpha(190) };
        let red = if dark { Color32::from_rgb(255, 110, 90) } else { Color32::from_rgb(190, 30, 20) };
        let blue = if dark { Color32::from_rgb(120, 180, 255) } else { Color32::from_rgb(20, 80, 170) };
        let lines = if friction > 0.0 { 2.0 } else { 1.0 };
        let size = vec2(230.0, 78.0 + 16.0 * lines);
        let frame = Rect::from_min_size(picture.left_bottom() + vec2(10.0, -10.0 - size.y), size);
        if frame.top() < picture.top() + 80.0 {
            return;
        }
        painter.rect_filled(frame, 4.0, ground);
        let write = |at, align, text: String, colour| painter.text(at, align, text, FontId::proportional(12.0), colour);
        let when = if self.touching { "force since touch" } else { "force of the last touch" };
        let left = format!("{when}: {:.0} % of its peak", 100.0 * last.force_n / self.peak_n.max(LEAST_N));
        write(frame.left_top() + vec2(6.0, 3.0), Align2::LEFT_TOP, left, red);
        if friction > 0.0 {
            let drag = format!("along / into: {:.2}, friction {friction:.2}", last.drag());
            write(frame.left_top() + vec2(6.0, 19.0), Align2::LEFT_TOP, drag, blue);
        }
        let plot = Rect::from_min_max(frame.left_top() + vec2(22.0, 5.0 + 16.0 * lines), frame.right_bottom() - vec2(8.0, 18.0));
        // the drag has the scale of the force, which is extended if friction is above 1
        let most = friction.max(1.0);
        let at = |since_s: f32, share: f32| {
            pos2(plot.left() + plot.width() * (since_s / last.since_s), plot.bottom() - plot.height() * (share / most).min(1.0))
        };
        let axis = Stroke::new(1.0, ink.gamma_multiply(0.6));
        painter.line_segment([plot.left_bottom(), plot.right_bottom()], axis);
        painter.line_segment([plot.left_bottom(), plot.left_top()], axis);
        write(at(0.0, 0.0) + vec2(-4.0, 0.0), Align2::RIGHT_CENTER, "0".into(), ink);
        write(at(0.0, most) + vec2(-4.0, 2.0), Align2::RIGHT_CENTER, format!("{most:.0}"), ink);
        write(plot.right_bottom() + vec2(0.0, 2.0), Align2::RIGHT_TOP, format!("{:.1} s", last.since_s), ink);
        if friction > 0.0 {
            let ends = [at(0.0, friction), at(last.since_s, friction)];
            painter.extend(Drawn::dashed_line(&ends, Stroke::new(1.0, blue), 4.0, 3.0));
            let drag = self.points.iter().map(|p| at(p.since_s, p.drag())).collect();
            painter.add(Drawn::line(drag, Stroke::new(1.2, blue)));
        }
        let force = self.points.iter().map(|p| at(p.since_s, p.force_n / self.peak_n.max(LEAST_N))).collect();
        painter.add(Drawn::line(force, Stroke::new(1.8, red)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_touch_begins_anew_and_a_long_one_is_thinned() {
        let sample = |tick: u32, depth_m: f32| Sample {
            t_s: f64::from(tick) * 4e-3,
            force_n: if depth_m > 0.0 { (1.0 + f64::from(tick) * 4e-3).recip() as f32 } else { 0.0 },
            along_n: 0.0,
            depth_m,
            ..Sample::default()
        };
        let mut touch = Touch::default();
        touch.add(&(0..5000).map(|tick| sample(tick, 1e-3)).collect::<Vec<_>>());
        let shown = touch.numbers();
        assert!(touch.points.len() <= MOST && (shown["since_s"].as_f64().unwrap() - 20.0).abs() < 0.3, "{shown}");
        assert!((shown["left"].as_f64().unwrap() - 1.0 / 21.0).abs() < 2e-3, "{shown}");
        let lifted =
            (0..5).map(|k: u8| Sample { force_n: 0.0, ..sample(5000 + u32::from(k), (0.8 - f32::from(k) * 0.2) * 1e-3) });
        touch.add(&lifted.collect::<Vec<_>>());
        assert!(!touch.touching);
        assert_eq!(touch.numbers(), shown, "a touch that ended is kept, without the lift");
        touch.add(&[sample(6000, 1e-3), sample(6001, 1e-3)]);
        assert_eq!(touch.points.len(), 2);
        touch.add(&[Sample { depth_m: 0.0, ..sample(6002, 1e-3) }]);
        assert_eq!(touch.points.len(), 3, "pushed from the side, it still touches");
    }
}
