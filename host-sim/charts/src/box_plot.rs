//! Draws box plots in clusters. A box shows quartiles and median; whiskers reach to the last value
//! within 1.5 interquartile ranges (Tukey); outliers are dots, and the mean is a diamond.

use std::path::Path;

use plotters::coord::types::RangedCoordf64;
use plotters::element::{Circle, PathElement, Polygon, Rectangle};
use plotters::prelude::DrawingBackend;
use plotters::style::text_anchor::{HPos, VPos};
use plotters::style::{Color, RGBColor, WHITE};

use super::axis::Axis;
use super::canvas::Area;
use super::canvas::Drawn;
use super::key_column::{self, Sign};
use super::layout::{Chart, Labels, TITLE_HEIGHT_PX, axes, builder, cut, title};
use super::picture::{Picture, save};
use super::speed_accuracy::marker::{Marker, distinct, outline};
use super::style::{INK, LABEL_PX, line, px, text};
use super::{ChartError, check_series};

/// Values that are summarised in one box.
#[derive(Clone, Copy, Debug)]
pub struct LabelledValues<'a> {
    /// Name in the legend; boxes with the same name have the same colour.
    pub name: &'a str,
    /// Values in the unit of the axis, in any order; at least one.
    pub values: &'a [f64],
}

/// Boxes side by side above a common label.
#[derive(Clone, Debug)]
pub struct BoxCluster<'a> {
    /// Text below the boxes.
    pub label: &'a str,
    /// Boxes from left to right.
    pub boxes: Vec<LabelledValues<'a>>,
}

/// Data and labels of a box plot.
#[derive(Clone, Copy, Debug)]
pub struct BoxPlot<'a> {
    /// First line above the plot.
    pub title: &'a str,
    /// Second line above the plot.
    pub below: &'a str,
    /// Quantity and unit of the vertical axis, such as `error [mm]`.
    pub quantity: &'a str,
    /// Clusters from left to right.
    pub clusters: &'a [BoxCluster<'a>],
}

/// Writes `NAME.svg` and `NAME.png` into `folder`. The axis begins at zero.
///
/// # Errors
/// Fails if there is no box, if a box has no values, if a value cannot be drawn, or if the folder
/// cannot be written.
pub fn box_plot(folder: &Path, name: &str, plot: &BoxPlot) -> Result<(), ChartError> {
    let boxes = || plot.clusters.iter().flat_map(|c| c.boxes.iter().map(move |b| (c, b)));
    if boxes().next().is_none() {
        return Err(ChartError::Empty { what: "clusters" });
    }
    for (cluster, one) in boxes() {
        let series = format!("{}, {}", cluster.label, one.name);
        if one.values.is_empty() {
            return Err(ChartError::EmptySeries { series });
        }
        check_series(&series, "values", one.values.iter().copied(), false)?;
    }
    let mut names: Vec<&str> = Vec::new();
    for (_, one) in boxes() {
        if !names.contains(&one.name) {
            names.push(one.name);
        }
    }
    let axis = Axis::from_zero(boxes().flat_map(|(_, b)| b.values.iter().copied()), 0.06, 9);
    save(folder, name, &Drawing { plot, names, axis })
}

/// Statistics that one box shows, in the unit of the axis.
#[derive(Clone, Debug, PartialEq)]
struct Summary {
    /// Lower quartile, median, upper quartile.
    quartiles: [f64; 3],
    /// Lower and upper end of the whiskers.
    whiskers: [f64; 2],
    mean: f64,
    outliers: Vec<f64>,
}

impl Summary {
    /// Computes the statistics of at least one value.
    fn of(values: &[f64]) -> Self {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        // linear interpolation between order statistics, the default of most statistics programs
        let quantile = |share: f64| {
            let place = share * (sorted.len().max(1) - 1) as f64;
            let at = |n: f64| sorted.get(n as usize).copied().unwrap_or_default();
            let low = at(place.floor());
            low + (at(place.ceil()) - low) * place.fract()
        };
        let quartiles = [0.25, 0.5, 0.75].map(quantile);
        let reach = 1.5 * (quartiles[2] - quartiles[0]);
        let inside = |v: &f64| quartiles[0] - reach <= *v && *v <= quartiles[2] + reach;
        let whiskers = [
            sorted.iter().copied().find(inside).unwrap_or(quartiles[0]).min(quartiles[0]),
            sorted.iter().copied().rfind(inside).unwrap_or(quartiles[2]).max(quartiles[2]),
        ];
        let mean = sorted.iter().sum::<f64>() / sorted.len().max(1) as f64;
        Self { quartiles, whiskers, mean, outliers: sorted.iter().copied().filter(|v| !inside(v)).collect() }
    }
}

struct Drawing<'a> {
    plot: &'a BoxPlot<'a>,
    /// Distinct names, in the order of the legend.
    names: Vec<&'a str>,
    axis: Axis,
}

type Plot<'a, DB> = Chart<'a, DB, RangedCoordf64, RangedCoordf64>;

impl Picture for Drawing<'_> {
    fn draw<DB: DrawingBackend>(&self, area: &Area<DB>) -> Drawn<DB> {
        let plot = self.plot;
        title(area, plot.title, plot.below)?;
        let colour = |name: &str| distinct(self.names.iter().position(|n| *n == name).unwrap_or(0)).color;
        let entries: Vec<_> = self.names.iter().map(|n| (Sign::Patch(colour(n)), *n)).collect();
        // a legend with a single entry would explain nothing
        let entries = if entries.len() > 1 { entries } else { Vec::new() };
        let taken = key_column::room(area, &entries)?;
        let clusters = plot.clusters.len() as f64;
        let mut chart = builder(area).margin_right(taken).build_cartesian_2d(0.0..clusters, self.axis.range.clone())?;
        axes(
            &mut chart,
            Labels { title: "", ticks: 0, of: &|_| String::new() },
            Labels { title: plot.quantity, ticks: self.axis.ticks, of: &|v| self.axis.label(*v) },
        )?;
        let foot = self.axis.range.start;
        for (n, cluster) in plot.clusters.iter().enumerate() {
            // a box is at most a quarter of a cluster wide
            let slot = 0.8 / (cluster.boxes.len().max(3) as f64);
            let left = n as f64 + 0.5 - 0.5 * slot * cluster.boxes.len() as f64;
            for (k, one) in cluster.boxes.iter().enumerate() {
                let middle = left + (k as f64 + 0.5) * slot;
                draw_box(area, &chart, middle, 0.36 * slot, &Summary::of(one.values), colour(one.name))?;
            }
            let (x, y) = chart.backend_coord(&(n as f64 + 0.5, foot));
            let style = text(LABEL_PX, INK, (HPos::Center, VPos::Center));
            let room = chart.backend_coord(&(n as f64 + 1.0, foot)).0 - chart.backend_coord(&(n as f64, foot)).0 - px(8.0);
            area.draw_text(&cut(area, cluster.label, &style, room)?, &style, (x, y + px(24.0)))?;
            let (edge, _) = chart.backend_coord(&(n as f64, foot));
            if n > 0 {
                area.draw(&PathElement::new([(edge, y), (edge, y + px(8.0))], line(INK, 1.2)))?;
            }
        }
        key_column::draw(area, &entries, taken, px(TITLE_HEIGHT_PX))
    }
}

fn draw_box<DB: DrawingBackend>(
    area: &Area<DB>,
    chart: &Plot<'_, DB>,
    middle: f64,
    half: f64,
    summary: &Summary,
    color: RGBColor,
) -> Drawn<DB> {
    let at = |x: f64, y: f64| chart.backend_coord(&(x, y));
    let [low, median, high] = summary.quartiles;
    for (quartile, end) in [low, high].into_iter().zip(summary.whiskers) {
        area.draw(&PathElement::new([at(middle, quartile), at(middle, end)], line(color, 1.6)))?;
        area.draw(&PathElement::new([at(middle - 0.5 * half, end), at(middle + 0.5 * half, end)], line(color, 1.6)))?;
    }
    let corners = [at(middle - half, high), at(middle + half, low)];
    area.draw(&Rectangle::new(corners, WHITE.filled()))?;
    area.draw(&Rectangle::new(corners, color.mix(0.3).filled()))?;
    area.draw(&Rectangle::new(corners, line(color, 1.6)))?;
    area.draw(&PathElement::new([at(middle - half, median), at(middle + half, median)], line(color, 3.2)))?;
    for outlier in &summary.outliers {
        area.draw(&Circle::new(at(middle, *outlier), px(3.0), color.filled()))?;
    }
    let mean = at(middle, summary.mean);
    area.draw(&Polygon::new(outline(Marker::Diamond, mean, px(5.2)), WHITE.filled()))?;
    area.draw(&Polygon::new(outline(Marker::Diamond, mean, px(3.9)), INK.filled()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_a_box_by_hand() {
        let s = Summary::of(&[1.0, 2.0, 3.0, 4.0, 20.0]);
        assert_eq!(s, Summary { quartiles: [2.0, 3.0, 4.0], whiskers: [1.0, 4.0], mean: 6.0, outliers: vec![20.0] });
        // R gives quantile(c(1, 2, 4, 9)) = 1, 1.75, 3, 5.25, 9
        assert_eq!(Summary::of(&[9.0, 1.0, 4.0, 2.0]).quartiles, [1.75, 3.0, 5.25]);
        let one = Summary::of(&[7.0]);
        assert_eq!((one.quartiles, one.whiskers), ([7.0; 3], [7.0; 2]));
    }
}
