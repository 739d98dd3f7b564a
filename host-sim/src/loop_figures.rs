//! Draws one run: force and depth over time, energy, spectrum.

use palpate_charts::{ChartError, Dot, Figure, Level, Plot, ScaledAxis, Series};
use palpate_loop::closed_loop::run::{Row, Run};
use palpate_loop::closed_loop::spectrum::density;
use palpate_loop::closed_loop::stimulus::Site;
use palpate_tissue::output::OutputFolder;

/// Largest number of points of a curve: more would not be visible.
const POINTS: usize = 2000;
/// Number of ticks shown before the touch, and after the handle has come to rest.
const BEFORE_TICKS: usize = 100;
const AFTER_TICKS: usize = 500;
/// The verdict's limit, 20 mN rms above 20 Hz, as a density that is constant up to half the tick
/// rate.
const FELT_FROM_HZ: f64 = 20.0;
const NYQUIST_HZ: f64 = 500.0;
/// `FELT_N` over the square root of the width of that band.
const LIMIT_MN_PER_SQRT_HZ: f64 = 0.913;
/// Distance from its final position within which a handle counts as at rest, relative to its
/// largest depth (1).
const RESTS: f64 = 0.02;

/// Draws `<name>_force`, `_depth`, `_energy` and `_spectrum` as SVG and PNG.
pub fn draw(folder: &OutputFolder, name: &str, below: &str, run: &Run, site: &Site) -> Result<(), ChartError> {
    let shown = shown(run, site);
    let stride = shown.len().div_ceil(POINTS).max(1);
    let curve =
        |name: &str, value: &dyn Fn(&Row) -> f64| Series::curve(name, shown.iter().step_by(stride).map(|r| (r.t_s, value(r))));
    let chart = |file: &str, title: &str, y: &str, series: Vec<Series>, level: Option<Level>| {
        let plot = Plot::new(ScaledAxis::linear("time [s]"), ScaledAxis::linear(y), series).levels(level);
        Figure::plot(format!("{name}_{file}"), title, below, plot).draw(folder.draft())
    };
    // from the fault on, the mode allows no force
    let fault = run.fault.and(shown.iter().find(|r| r.telemetry.fault.is_some()));
    let normal = site.normal;
    let along = |force: palpate::Vector3<f32>| f64::from(force.dot(&normal.cast()));
    let mut force = vec![
        curve("force of the tissue", &|r| along(r.telemetry.output.force_n)),
        curve("force on the hand", &|r| r.acting_n.dot(&normal)),
    ];
    force.extend(fault.map(|r| Series::dots("fault: force off", vec![Dot::from((r.t_s, 0.0))])));
    chart("force", "What the hand feels", "force along the normal [N]", force, None)?;
    let depth = vec![curve("handle", &|r| -(r.at_m - site.at_m).dot(&normal) * 1e3)];
    chart("depth", "Where the handle is", "depth below the surface [mm]", depth, Some(Level::new("surface", 0.0)))?;
    let energy = vec![curve("given since the touch", &|r| r.energy.given_j * 1e3)];
    let zero = Level::new("zero: more is created energy", 0.0);
    chart("energy", "Energy given to the hand", "energy [mJ]", energy, Some(zero))?;
    let points = density(&run.rows.iter().map(|r| along(r.telemetry.applied_n)).collect::<Vec<_>>());
    let points: Vec<(f64, f64)> = points.into_iter().map(|(hz, d)| (hz, (d * 1e3).max(1e-6))).collect();
    if points.is_empty() {
        return Ok(());
    }
    let top = points.iter().map(|p| p.1).fold(LIMIT_MN_PER_SQRT_HZ, f64::max);
    let limit = [(FELT_FROM_HZ, top), (FELT_FROM_HZ, LIMIT_MN_PER_SQRT_HZ), (NYQUIST_HZ, LIMIT_MN_PER_SQRT_HZ)];
    let series = vec![Series::curve("force on the hand", points), Series::curve("20 mN rms above 20 Hz", limit)];
    let plot = Plot::new(ScaledAxis::log("frequency [Hz]"), ScaledAxis::log("density [mN/sqrt(Hz)]"), series);
    let title = "Spectrum of the force: vibration is felt where it is near the limit";
    Figure::plot(format!("{name}_spectrum"), title, below, plot).draw(folder.draft())
}

/// Rows from shortly before the touch to shortly after the handle came to rest.
fn shown<'a>(run: &'a Run, site: &Site) -> &'a [Row] {
    let depth_m = |row: &Row| -(row.at_m - site.at_m).dot(&site.normal);
    let touch = run.rows.iter().position(|r| depth_m(r) > 0.0).unwrap_or(0);
    let deepest_m = run.rows.iter().map(depth_m).fold(0.0, f64::max);
    let rests_m = run.rows.last().map_or(site.at_m, |r| r.at_m);
    // motion along the surface counts too: a drag begins long after the press has come to rest
    let moves = |row: &Row| (row.at_m - rests_m).norm() > RESTS * deepest_m;
    let end = run.rows.iter().rposition(moves).unwrap_or(run.rows.len());
    let end = end.max(touch).saturating_add(AFTER_TICKS).min(run.rows.len());
    run.rows.get(touch.saturating_sub(BEFORE_TICKS)..end).unwrap_or(&run.rows)
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_loop::closed_loop::device::DeviceProfile;
    use palpate_loop::closed_loop::hand::HANDS;
    use palpate_loop::closed_loop::report::Target;
    use palpate_loop::closed_loop::stimulus::Stimulus;

    #[test]
    fn a_drag_is_shown_and_the_hold_after_it_is_not() {
        let (device, target) = (DeviceProfile::load("touch").unwrap(), Target::Wall(400.0));
        let (run, site) = (target.run(&device, HANDS[1], Stimulus::named("S6").unwrap()).unwrap(), target.site());
        let shown = shown(&run, &site);
        let farthest_m = shown.iter().map(|r| (r.at_m - site.at_m).dot(&site.along).abs()).fold(0.0, f64::max);
        assert!(farthest_m > 7e-3, "{farthest_m} m of 8 mm aside");
        assert!(shown.len() + 1000 < run.rows.len(), "{} of {} ticks", shown.len(), run.rows.len());
    }
}
