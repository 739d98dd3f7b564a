//! `palpate press`.

use clap::Args;
use indicatif::{ProgressBar, ProgressStyle};

use super::Common;
use crate::error::Error;
use crate::summary;
use palpate_tissue::machine::{PROFILE, processor};
use palpate_tissue::output::OutputFolder;
use palpate_tissue::press::{self, Press};
use palpate_tissue::reference_values;
use palpate_tissue::scene::{Drive, Scene};
use palpate_tissue::session::Session;

/// A progress bar appears on a terminal when a run takes longer than this [ms].
const QUIET_MS: u128 = 2000;

#[derive(Args, Clone, Debug)]
pub(super) struct PressArgs {
    #[command(flatten)]
    common: Common,
    /// Also write press_<k>.vtu for ParaView: the tissue at the end of hold k.
    #[arg(long)]
    vtu: bool,
}

impl Default for PressArgs {
    fn default() -> Self {
        Self { common: Common { scene: "block".into(), out: None }, vtu: false }
    }
}

impl PressArgs {
    pub(super) fn run(&self) -> Result<(), Error> {
        let scene = Scene::load(&self.common.scene)?;
        let session = Session::prepare(&scene)?;
        // not before the scene is known to be good: bad input leaves nothing behind
        let folder = OutputFolder::open(&self.common.folder("press"))?;
        print_report(&scene, &session);
        let press = with_progress(|progress| press::run(&scene, &session, progress))?;
        summary::write(&folder, &scene, &session, &press, self.vtu)?;
        print_holds(&scene, &press);
        let out = folder.publish()?;
        println!("\nwrote {}: summary.json, trace.csv, surface_*.csv, pictures as SVG and PNG", out.display());
        Ok(press.check(&scene.drive)?)
    }
}

pub(super) fn with_progress<T>(run: impl FnOnce(&mut dyn FnMut(usize)) -> T) -> T {
    let started = std::time::Instant::now();
    let mut bar: Option<ProgressBar> = None;
    let result = run(&mut |ticks| {
        if ticks % 64 == 0 && started.elapsed().as_millis() > QUIET_MS {
            let bar = bar.get_or_insert_with(|| {
                ProgressBar::new_spinner().with_style(
                    ProgressStyle::with_template("{spinner} {msg}").unwrap_or_else(|_| ProgressStyle::default_spinner()),
                )
            });
            bar.set_message(format!("{:.1} s of tissue time", ticks as f64 * 1e-3));
            bar.tick();
        }
    });
    if let Some(bar) = bar {
        bar.finish_and_clear();
    }
    result
}

fn print_report(scene: &Scene, session: &Session) {
    let r = &session.report;
    let [x, y, z] = r.size_mm;
    println!(
        "scene {}: {x:.1} x {y:.1} x {z:.1} mm, {:.0} g, E {:.4} kPa, nu {}",
        scene.name,
        r.mass_g,
        scene.tissue.youngs_modulus_pa * 1e-3,
        scene.tissue.poisson_ratio
    );
    println!(
        "  mesh      {} nodes ({} fixed), {} springs, {} tets, {} surface triangles; {:.1} mm elements under the probe",
        r.nodes, r.anchors, r.springs, r.tets, r.triangles, r.element_mm
    );
    print!("  worst tet {} (quality {:.3}, 1 is regular)", r.worst_tet, r.worst_tet_quality);
    match r.flipped_tets {
        0 => println!(),
        n => println!("; {n} tets turned round on import"),
    }
    println!(
        "  step      stable to {:.2} ms at rest, {:.2} ms pressed to {:.1} mm: {} substep(s) a tick; mass floor x{:.2}",
        r.stable_rest_ms, r.stable_pressed_ms, r.depth_limit_mm, r.substeps, r.mass_floor_ratio
    );
    println!("  expected  about {:.4} N at 1 mm (a half-space under this probe)", r.half_space_force_at_1mm_n);
    if r.element_mm > 1e3 * scene.probe.radius_m {
        println!(
            "  warning   elements under the probe ({:.1} mm) are larger than its radius ({:.1} mm): the force is not resolved; refine the mesh there",
            r.element_mm,
            scene.probe.radius_m * 1e3
        );
    }
    match session.patch.fitted_places() {
        0 => println!(
            "  model     uncalibrated, constants from formulas alone: palpate calibrate fits a block's patch; patch = FILE under [solver] takes it"
        ),
        n => println!("  model     calibrated to finite elements over {n} places"),
    }
}

pub(super) fn print_holds(scene: &Scene, press: &Press) {
    let reference = reference_values::of(scene);
    let target = match scene.drive {
        Drive::Force { .. } => "target N",
        _ => "target mm",
    };
    if !press.holds.is_empty() {
        println!("\n{target:>10} {:>9} {:>9} {:>8} {:>9} {:>18}", "depth mm", "force N", "min J", "volume %", "FEM force N");
    }
    for hold in &press.holds {
        let shown = match scene.drive {
            Drive::Force { .. } => hold.target,
            _ => hold.target * 1e3,
        };
        let fem = reference
            .iter()
            .find(|(depth, _)| matches!(scene.drive, Drive::Depth { .. }) && (depth - hold.target).abs() < 1e-6 * depth);
        let fem = fem.map_or("-".into(), |(_, f)| format!("{f:.4} ({:+.1} %)", (hold.force_n / f - 1.0) * 100.0));
        println!(
            "{shown:>10.3} {:>9.3} {:>9.4} {:>8.3} {:>+9.3} {fem:>18}",
            hold.depth_m * 1e3,
            hold.force_n,
            hold.min_j,
            hold.volume_change_pct
        );
    }
    let [p50, p99, max] = press.tick_us();
    println!(
        "\n{} ticks, {} deadline misses; tick {p50:.1} us median, {p99:.1} us p99, {max:.1} us max ({}{})",
        press.ticks.len(),
        press.deadline_misses,
        if press.timed_on == processor() { "CPU time, " } else { "" },
        timed_on(press)
    );
    println!(
        "after release {:.4} mm left; state {:016x}; worst tick {:.1} % of 1 ms",
        press.residual_m * 1e3,
        press.state_hash,
        f64::from(max) * 0.1
    );
}

/// Machine and, for this one, the build: published times are of `--profile measure`.
fn timed_on(press: &Press) -> String {
    let machine = &press.timed_on;
    match PROFILE {
        "measure" => machine.clone(),
        _ if *machine != processor() => machine.clone(),
        profile => format!("{machine}, profile {profile}; `--profile measure` is faster"),
    }
}
