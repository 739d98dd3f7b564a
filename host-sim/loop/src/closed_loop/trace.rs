//! Writes one run as a table.

use super::run::Run;
use super::stimulus::Site;
use palpate_tissue::error::Error;
use palpate_tissue::output::OutputFolder;

/// Writes `trace.csv`: one row per tick. Each number is the shortest decimal that reads back as the
/// same value; depth and force on the device have single precision.
///
/// # Errors
/// The folder cannot be written.
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
        let force = telemetry.applied_n;
        [
            r.t_s.to_string(),
            at.x.to_string(),
            at.y.to_string(),
            at.z.to_string(),
            target.x.to_string(),
            target.y.to_string(),
            target.z.to_string(),
            telemetry.output.depth_m.to_string(),
            telemetry.output.force_n.cast::<f64>().dot(&normal).to_string(),
            force.x.to_string(),
            force.y.to_string(),
            force.z.to_string(),
            r.acting_n.dot(&normal).to_string(),
            r.energy.given_j.to_string(),
            r.energy.created_j.to_string(),
            (telemetry.mode as u8).to_string(),
            telemetry.limiters.bits().to_string(),
            telemetry.fault.map_or(0, |f| f as u8).to_string(),
        ]
    });
    folder.write_table("trace.csv", header, rows)
}
