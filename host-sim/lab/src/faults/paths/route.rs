//! A polyline with a speed on every leg and stops at its corners, sharp or smoothed.

use palpate::Vector3;

use palpate_tissue::scene::TICK_S;

/// One straight leg, then a stop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Leg {
    /// End point [m].
    pub to_m: Vector3<f64>,
    /// Speed of the tip on this leg [m/s].
    pub m_per_s: f64,
    /// Ticks for which the tip stays there.
    pub stop_ticks: u32,
}

/// A path over time.
#[derive(Clone, Debug, PartialEq)]
pub struct Route {
    /// Position at the start of every tick [m].
    pub at_m: Vec<Vector3<f64>>,
}

impl Route {
    /// Builds the route from a start along its legs. It stops after `moving_ticks`, wherever it is,
    /// and rests there for `rest_ticks`. Every position is the mean over `smooth_ticks`, which
    /// rounds corners, starts and stops.
    pub fn along(start_m: Vector3<f64>, legs: &[Leg], moving_ticks: usize, rest_ticks: usize, smooth_ticks: usize) -> Self {
        let mut at_m = vec![start_m];
        'legs: for leg in legs {
            let from_m = at_m.last().copied().unwrap_or(start_m);
            let length_m = (leg.to_m - from_m).norm();
            let ticks = (length_m / (leg.m_per_s * TICK_S)).ceil().max(1.0);
            for n in 1..=ticks as usize {
                let share = (n as f64 * leg.m_per_s * TICK_S / length_m.max(f64::MIN_POSITIVE)).min(1.0);
                at_m.push(from_m + (leg.to_m - from_m) * share);
                if at_m.len() >= moving_ticks {
                    break 'legs;
                }
            }
            at_m.extend(std::iter::repeat_n(leg.to_m, leg.stop_ticks as usize));
        }
        at_m.truncate(moving_ticks);
        let end_m = at_m.last().copied().unwrap_or(start_m);
        let length = moving_ticks.max(at_m.len()) + rest_ticks;
        at_m.resize(length, end_m);
        if smooth_ticks > 1 {
            at_m = smoothed(&at_m, smooth_ticks);
        }
        Self { at_m }
    }
}

/// The running mean over `width` ticks, which lags by half of it.
fn smoothed(at_m: &[Vector3<f64>], width: usize) -> Vec<Vector3<f64>> {
    let Some(first) = at_m.first() else { return Vec::new() };
    let mut sum = first * width as f64;
    let mut mean = Vec::with_capacity(at_m.len());
    for (n, now) in at_m.iter().enumerate() {
        let leaves = n.checked_sub(width).and_then(|k| at_m.get(k)).unwrap_or(first);
        sum += now - leaves;
        mean.push(sum / width as f64);
    }
    mean
}
