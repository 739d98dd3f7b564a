//! Chart that compares measurements with the tissue of their preset: the prediction of `palpate
//! accept`, and the prediction without the term that is tested.

use eframe::egui::{Align2, Color32, FontId, Painter, Rect, Shape as Drawn, Stroke, pos2, vec2};

/// Chart of a preset's tissue.
struct Chart {
    preset: &'static str,
    title: &'static str,
    dots: &'static str,
    across: &'static str,
    /// Curves of the picture that `accept` draws, as lines `curve,x,y`, thinned and rounded.
    curves: &'static str,
}

const CHARTS: [Chart; 2] = [
    Chart {
        preset: "beef",
        title: "force left in a hold: 72 tests of topside",
        dots: "dots: measured, median and 10-90 % (T1)",
        across: "s after a ramp of 4 s",
        curves: include_str!("../accepted/beef_topside.csv"),
    },
    Chart {
        preset: "pig-liver",
        title: "force in N under a ball of 4 mm: 72 sites",
        dots: "dots: measured, median (T2)",
        across: "mm deep",
        curves: include_str!("../accepted/liver_region_1.csv"),
    },
];

/// Size of the chart [points].
const SIZE: [f32; 2] = [250.0, 150.0];
/// Smallest picture in which the chart fits beside the other charts [points].
const LEAST: [f32; 2] = [560.0, 330.0];

/// Points of a curve by its name.
type Curve = (&'static str, Vec<[f32; 2]>);

/// Curves in the order of the file; lines without numbers are left out.
fn curves(text: &'static str) -> Vec<Curve> {
    let mut all: Vec<Curve> = Vec::new();
    for line in text.lines().skip(1) {
        let mut cells = line.split(',');
        let (Some(name), Some(x), Some(y)) = (cells.next(), cells.next(), cells.next()) else { continue };
        let (Ok(x), Ok(y)) = (x.parse(), y.parse()) else { continue };
        match all.last_mut() {
            Some((last, points)) if *last == name => points.push([x, y]),
            _ => all.push((name, vec![[x, y]])),
        }
    }
    all
}

/// Draws the chart of this preset into a corner of the picture, if the preset has a chart and it
/// fits.
pub fn draw(painter: &Painter, picture: Rect, dark: bool, preset: &str) {
    let Some(chart) = CHARTS.iter().find(|chart| chart.preset == preset) else { return };
    if picture.width() < LEAST[0] || picture.height() < LEAST[1] {
        return;
    }
    let ink = if dark { Color32::from_gray(225) } else { Color32::from_gray(50) };
    let ground = if dark { Color32::from_black_alpha(120) } else { Color32::from_white_alpha(190) };
    let red = if dark { Color32::from_rgb(255, 110, 90) } else { Color32::from_rgb(190, 30, 20) };
    let size = vec2(SIZE[0], SIZE[1]);
    let frame = Rect::from_min_size(picture.right_bottom() - vec2(10.0, 10.0) - size, size);
    painter.rect_filled(frame, 4.0, ground);
    let write = |at, align, text: &str, colour| painter.text(at, align, text, FontId::proportional(12.0), colour);
    write(frame.left_top() + vec2(6.0, 3.0), Align2::LEFT_TOP, chart.title, ink);
    let all = curves(chart.curves);
    let most = |axis: usize| all.iter().flat_map(|(_, points)| points).map(|p| p[axis]).fold(0.0, f32::max);
    let (most_x, most_y) = (most(0), most(1));
    let plot = Rect::from_min_max(frame.left_top() + vec2(30.0, 60.0), frame.right_bottom() - vec2(12.0, 20.0));
    let at = |[x, y]: [f32; 2]| pos2(plot.left() + plot.width() * x / most_x, plot.bottom() - plot.height() * y / most_y);
    let axis = Stroke::new(1.0, ink.gamma_multiply(0.6));
    painter.line_segment([plot.left_bottom(), plot.right_bottom()], axis);
    painter.line_segment([plot.left_bottom(), plot.left_top()], axis);
    write(plot.left_top() - vec2(4.0, 0.0), Align2::RIGHT_CENTER, &format!("{most_y:.1}"), ink);
    write(plot.left_bottom() - vec2(4.0, 0.0), Align2::RIGHT_CENTER, "0", ink);
    write(plot.right_bottom() + vec2(0.0, 3.0), Align2::RIGHT_TOP, &format!("{most_x:.1} {}", chart.across), ink);
    write(frame.left_top() + vec2(6.0, 19.0), Align2::LEFT_TOP, chart.dots, ink);
    for (name, points) in &all {
        let line: Vec<_> = points.iter().map(|p| at(*p)).collect();
        match *name {
            "ours" => _ = painter.add(Drawn::line(line, Stroke::new(1.8, red))),
            without if without.starts_with("ours") => {
                painter.extend(Drawn::dashed_line(&line, Stroke::new(1.2, ink), 4.0, 3.0));
                write(frame.left_top() + vec2(60.0, 35.0), Align2::LEFT_TOP, &without.replace("ours", "dashed:"), ink);
            }
            _ => line.into_iter().for_each(|at| _ = painter.circle_filled(at, 2.5, ink)),
        }
    }
    write(frame.left_top() + vec2(6.0, 35.0), Align2::LEFT_TOP, "red: ours", red);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_chart_has_measurements_ours_and_ours_without_the_term() {
        for chart in &CHARTS {
            let all = curves(chart.curves);
            let without = all.iter().filter(|(name, _)| name.starts_with("ours without")).count();
            let ours = all.iter().filter(|(name, _)| *name == "ours").count();
            assert_eq!((ours, without), (1, 1), "{}: {all:?}", chart.preset);
            assert!(all.iter().any(|(name, points)| name.starts_with("measured") && points.len() >= 5), "{}", chart.preset);
        }
    }
}
