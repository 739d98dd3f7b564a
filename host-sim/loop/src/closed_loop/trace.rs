//! One run as a table.

use super::run::Run;
use super::stimulus::Site;
use palpate_tissue::error::Error;
use palpate_tissue::output::OutputFolder;

/// Writes `trace.csv`: one row per tick.
///
/// # Errors
/// A folder that cannot be written.
pub fn write(folder: &OutputFolder, run: &Run, site: &Site) -> Result<(), Error> {
    let header = [
        "t_s",
        "handle_x_m",
        "handle_y_m",
        "handle_z_m",
        "target_x_m",
        "target_y_m",
        "target_z_m",
        "depth_m",
        "tissue_force_n",
        "force_x_n",
        "force_y_n",
        "force_z_n",
        "acting_force_n",
        "given_j",
        "created_j",
        "mode",
        "limiters",
        "fault",
    ];
    let rows = run.rows.iter().map(|r| {
        let (telemetry, at, target, normal) = (&r.telemetry, r.at_m, r.target_m, site.normal);
        let force = telemetry.applied_n.cast::<f64>();
        [
            r.t_s,
            at.x,
            at.y,
            at.z,
            target.x,
            target.y,
            target.z,
            f64::from(telemetry.output.depth_m),
            telemetry.output.force_n.cast::<f64>().dot(&normal),
            force.x,
            force.y,
            force.z,
            r.acting_n.dot(&normal),
            r.energy.given_j,
            r.energy.created_j,
            f64::from(telemetry.mode as u8),
            f64::from(telemetry.limiters.bits()),
            telemetry.fault.map_or(0.0, |f| f64::from(f as u8)),
        ]
    });
    folder.write_csv("trace.csv", header, rows)
}
