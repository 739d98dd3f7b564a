//! `trace.csv`: one row per tick.

use crate::error::Error;
use crate::output::OutputFolder;
use crate::press::Press;

/// Columns, with units.
const COLUMNS: [&str; 10] =
    ["t_s", "probe_x_m", "probe_y_m", "probe_z_m", "depth_m", "force_x_n", "force_y_n", "force_z_n", "active_nodes", "tick_us"];

/// Writes a run. Each number is the shortest decimal that reads back as the same number, in single
/// precision except for the time.
///
/// # Errors
/// The folder cannot be written.
pub fn write(folder: &OutputFolder, press: &Press) -> Result<(), Error> {
    let rows = press.ticks.iter().map(|t| {
        let (p, f) = (t.tip_m, t.output.force_n);
        let single = [p.x, p.y, p.z, t.output.depth_m, f.x, f.y, f.z].map(|v| v.to_string());
        let [x, y, z, depth, force_x, force_y, force_z] = single;
        let (active, us) = (t.output.active_nodes.to_string(), t.tick_us.to_string());
        [t.t_s.to_string(), x, y, z, depth, force_x, force_y, force_z, active, us]
    });
    folder.write_table("trace.csv", COLUMNS, rows)
}
