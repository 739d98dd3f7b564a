//! `trace.csv`: one row per tick.

use crate::error::Error;
use crate::output::OutputFolder;
use crate::press::Press;

/// Columns, with units.
const COLUMNS: [&str; 10] =
    ["t_s", "probe_x_m", "probe_y_m", "probe_z_m", "depth_m", "force_x_n", "force_y_n", "force_z_n", "active_nodes", "tick_us"];

/// Writes a run. Numbers read back bit for bit.
///
/// # Errors
/// The folder cannot be written.
pub fn write(folder: &OutputFolder, press: &Press) -> Result<(), Error> {
    let rows = press.ticks.iter().map(|t| {
        let (p, f) = (t.tip_m.cast::<f64>(), t.output.force_n.cast::<f64>());
        let depth = f64::from(t.output.depth_m);
        [t.t_s, p.x, p.y, p.z, depth, f.x, f.y, f.z, f64::from(t.output.active_nodes), f64::from(t.tick_us)]
    });
    folder.write_csv("trace.csv", COLUMNS, rows)
}
