//! The command `palpate press`.

use clap::Args;
use palpate::ClampFlags;

use super::Common;
use super::mesh::box_mm;
use super::progress::{Spinner, told};
use super::verdict::Verdict;
use crate::error::Error;
use crate::{contact_report, gltf, press_report, usda};
use palpate_tissue::budget::MACHINES;
use palpate_tissue::machine::{PROFILE, processor};
use palpate_tissue::moving::{Ramp, RampError};
use palpate_tissue::press::contact::DeepestContact;
use palpate_tissue::press::{self, Hold, Press};
use palpate_tissue::reference_values;
use palpate_tissue::scene::{Drive, Scene};
use palpate_tissue::session::Session;
use palpate_tissue::session::coarse;
use palpate_tissue::session::moving::{DEFAULT_ERROR_PCT, MovingReport};
use palpate_tissue::session::standing::Standing;
use palpate_tissue::tissue::filled;

#[derive(Args, Clone, Debug)]
pub(super) struct PressArgs {
    #[command(flatten)]
    common: Common,
    /// Also write press_<k>.vtu for ParaView: the tissue at the end of hold k.
    #[arg(long)]
    vtu: bool,
    /// Also write press.glb (glTF): the surface with a morph target for the end of each hold, the
    /// pressure as colour.
    #[arg(long)]
    gltf: bool,
    /// Also write press.usda: a USD `TetMesh` with a time sample for the end of each hold.
    #[arg(long)]
    usd: bool,
    /// Also write the contact map at the deepest position of the tip: contact.csv (pressure on each
    /// surface triangle), a picture, and area, centre, axes and peak in summary.json.
    #[arg(long)]
    contact: bool,
}

impl Default for PressArgs {
    fn default() -> Self {
        Self { common: Common::of("block", None), vtu: false, gltf: false, usd: false, contact: false }
    }
}

impl PressArgs {
    pub(super) fn run(&self) -> Result<(), Error> {
        let scene = self.common.load()?;
        let session = told("meshing the tissue", || Session::prepare(&scene)?.for_motion(&MACHINES[0], &scene))?;
        let dented = press_report::has_surface(&session);
        let options = [(self.contact, "--contact"), (self.vtu, "--vtu"), (self.gltf, "--gltf"), (self.usd, "--usd")];
        if let Some((_, option)) = options.iter().find(|(asked, _)| *asked && !dented) {
            let why = "a law has no surface that is pressed: leave it out, or fit a patch with `palpate fit` without --law";
            return Err(palpate_tissue::Error::Usage(format!("{option}: {why}")).into());
        }
        let ramps = Ramp::of_scene(&scene).map_err(palpate_tissue::Error::from)?;
        // the folder is opened once the scene has been checked, so that bad input leaves no files
        let folder = self.common.open("press", &scene)?;
        let mut deepest = None;
        let press = with_progress(|progress| {
            press::run_seen(&scene, &session, progress, |model, tuned, state, row| {
                if self.contact {
                    DeepestContact::see(&mut deepest, model, tuned, state, row);
                }
            })
        })?;
        let moving = judge_ramps(&ramps, &session)?;
        press_report::write(&folder, &scene, &session, &press, &moving, deepest.as_ref(), self.vtu)?;
        if self.gltf {
            gltf::write(&folder, &session, &press.holds)?;
        }
        if self.usd {
            usda::write(&folder, &session, &press.holds)?;
        }
        let verdict = Verdict::of(press.check(&scene.drive), || in_words(&scene, &session, &press))?;
        let verdict = verdict.warning_if(is_doubtful(&scene, &session, &press)).about(&scene).first();
        print_report(&scene, &session);
        print_holds(&scene, &press);
        print_moving(&moving);
        if self.contact {
            println!("\ncontact   {}", contact_report::sentence(deepest.as_ref()));
        }
        let out = folder.publish()?;
        let surface = if dented { " surface_*.csv," } else { "" };
        let map = if deepest.is_some() { " contact.csv," } else { "" };
        println!("\nwrote {}: summary.json, trace.csv,{surface}{map} pictures as SVG and PNG", out.display());
        verdict.last()
    }
}

/// Force error from which the verdict calls a press off instead of within [%].
const FAR_PCT: f64 = 10.0;

/// Largest force error against stored finite elements [%].
fn furthest_pct(scene: &Scene, press: &Press) -> Option<f64> {
    let pct = |hold: &Hold| Some(((hold.force_n / reference_values::at(scene, hold.target)? - 1.0) * 100.0).abs());
    press.holds.iter().filter_map(pct).reduce(f64::max)
}

/// Whether the force is known to be far off, or often too late for a device.
fn is_doubtful(scene: &Scene, session: &Session, press: &Press) -> bool {
    let moving = session.report.moving.is_some_and(|moving| moving.rms_pct > moving.allowed_pct);
    let coarse = coarse::missing_pct(scene, &session.patch).is_some_and(|pct| pct > FAR_PCT);
    press.often_late() || moving || coarse || furthest_pct(scene, press).is_some_and(|pct| pct > FAR_PCT)
}

/// Describes accuracy and speed of a press.
fn in_words(scene: &Scene, session: &Session, press: &Press) -> String {
    let right = match furthest_pct(scene, press) {
        Some(pct) if pct > FAR_PCT => format!("{pct:.1} % off finite elements"),
        Some(pct) => format!("within {pct:.1} % of finite elements"),
        None => Standing::of(scene, session).short(),
    };
    let moving = match session.report.moving {
        Some(MovingReport { rms_pct, allowed_pct, .. }) if rms_pct > allowed_pct => {
            format!(", {rms_pct:.1} % off while it moves")
        }
        _ => String::new(),
    };
    let soft = match coarse::missing_pct(scene, &session.patch) {
        Some(pct) => format!(
            ", up to {pct:.0} % too soft with elements of {:.1} mm under a probe of radius {:.1} mm",
            session.report.element_mm,
            scene.probe.radius_m * 1e3
        ),
        None => String::new(),
    };
    let limited = match press.limiters.contains(ClampFlags::DEPTH) {
        true => format!(
            ", continued by a straight line below {:.2} mm, where the patch ends and the guard holds its tip",
            session.report.depth_limit_mm
        ),
        false => String::new(),
    };
    let late = match press.often_late() {
        true => format!("; {} of {} ticks took longer than 1 ms", press.deadline_misses, press.ticks.len()),
        false => String::new(),
    };
    let [_, _, slowest_us] = press.tick_us();
    format!("{right}{soft}{limited}{moving}{late}; the slowest tick took {:.1} % of its millisecond", f64::from(slowest_us) * 0.1)
}

pub(super) fn with_progress<T>(run: impl FnOnce(&mut dyn FnMut(usize)) -> T) -> T {
    let mut spinner = Spinner::default();
    let result = run(&mut |ticks| {
        if ticks % 64 == 0 {
            spinner.show(|| format!("{:.1} s of tissue time", ticks as f64 * 1e-3));
        }
    });
    spinner.clear();
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
    if let Some(surface_cm3) = r.surface_cm3 {
        let off_pct = (r.volume_cm3 / surface_cm3 - 1.0) * 100.0;
        println!("  surface   {surface_cm3:.3} cm^3; the tets made from it {:.3} cm^3 ({off_pct:+.1} %)", r.volume_cm3);
    }
    for note in &r.notes {
        println!("  note      {note}");
    }
    if let Some(fixed_mm) = r.fixed_mm {
        println!("  supports  {}", supports(scene, r.anchors, fixed_mm));
    }
    for (n, ball) in scene.tissue.inclusion.iter().enumerate() {
        let (tets, volume_m3) = filled(&session.patch.mesh(), ball);
        let whole_m3 = 4.0 / 3.0 * std::f64::consts::PI * ball.radius_m.powi(3);
        println!(
            "  inclusion {} is in {tets} tets: {:.3} of its {:.3} cm^3, {} times as stiff",
            n + 1,
            volume_m3 * 1e6,
            whole_m3 * 1e6,
            ball.stiffness_ratio
        );
    }
    print!("  worst tet {} (quality {:.3}; 1 is regular, 0 is flat)", r.worst_tet, r.worst_tet_quality);
    match r.flipped_tets {
        0 => println!(),
        n => println!("; {n} inverted tets corrected on import"),
    }
    println!(
        "  step      stable to {:.2} ms at rest, {:.2} ms pressed to {:.1} mm: {} substep(s) in a tick of 1 ms",
        r.stable_rest_ms, r.stable_pressed_ms, r.depth_limit_mm, r.substeps
    );
    println!(
        "  mass      nodes that move carry {:.2} times their share of the mass, so that the tick is stable; a force held still is the same",
        r.mass_floor_ratio
    );
    if let Some(moving) = r.moving {
        let MovingReport { speed_m_per_s, motion, rms_pct, allowed_pct, .. } = moving;
        println!(
            "  moving    {rms_pct:.1} % off at up to {:.0} mm/s in the worst motion tried ({motion}), the 20 ms after it included",
            speed_m_per_s * 1e3
        );
        if rms_pct > allowed_pct {
            println!(
                "  warning   more than the {allowed_pct} % that are aimed at, and more substeps do not fit or do not help: take fewer nodes or move more slowly"
            );
        }
    }
    if !scene.probe.is_tilted() {
        println!("  expected  about {:.4} N at 1 mm (a half-space under this probe)", r.half_space_force_at_1mm_n);
    }
    if let Some(pct) = coarse::missing_pct(scene, &session.patch) {
        println!(
            "  warning   elements under the probe ({:.1} mm) are coarse for its radius ({:.1} mm): the force may be up to {pct:.0} % too low; take more nodes, or fit the scene (palpate fit --scene {})",
            r.element_mm,
            scene.probe.radius_m * 1e3,
            scene.file
        );
    }
    println!("  model     {}", Standing::of(scene, session).sentence(scene));
}

/// Describes the supports of the tissue.
fn supports(scene: &Scene, nodes: usize, fixed_mm: [[f64; 3]; 2]) -> String {
    let whichever = match &scene.tissue {
        tissue if tissue.block_m.is_some() => "the bottom of the block",
        tissue if tissue.organ.is_some() => "where the surface faces more than 120 degrees away from the press, and in bone",
        tissue if tissue.mesh.is_some() => "where the surface faces more than 120 degrees away from the press",
        _ => "those of the patch file",
    };
    format!("{nodes} nodes, {whichever}: {}", box_mm(fixed_mm))
}

/// Errors of the session's patch on every ramp with a stored reference; a ramp on which the patch
/// fails is left out.
fn judge_ramps(ramps: &[Ramp], session: &Session) -> Result<Vec<RampError>, Error> {
    let mut errors = Vec::new();
    for ramp in ramps {
        errors.extend(ramp.judge_patch(&session.patch, &session.params, session.patch.site_m())?.ok());
    }
    Ok(errors)
}

fn print_moving(errors: &[RampError]) {
    if errors.is_empty() {
        return;
    }
    println!(
        "\non ramps down to 4 mm: how far the force is off finite elements that move, in % (rms with the 20 ms after the stop, in % of the peak force, at most {DEFAULT_ERROR_PCT} is good)"
    );
    println!("{:>10} {:>8} {:>8} {:>8} {:>8} {:>9} {:>8}", "mm/s", "at 1 mm", "at 2 mm", "at 3 mm", "at 4 mm", "rms", "at peak");
    for e in errors {
        let [a, b, c, d] = e.at_pct;
        println!("{:>10} {a:>+8.1} {b:>+8.1} {c:>+8.1} {d:>+8.1} {:>9.1} {:>+8.1}", e.speed_mm_per_s, e.rms_pct, e.peak_pct);
    }
    if errors.iter().any(|e| e.rms_pct > DEFAULT_ERROR_PCT) {
        println!(
            "these ramps ran with this scene's substeps; a scene with a faster drive takes more (moving_error_pct under [solver])"
        );
    }
}

pub(super) fn print_holds(scene: &Scene, press: &Press) {
    let target = match scene.drive {
        Drive::Force { .. } => "target N",
        _ => "target mm",
    };
    if !press.holds.is_empty() {
        println!(
            "\nheld still; FEM: finite elements and how far ours is off; J: volume over that at rest, of the tet squeezed most (0 is flat)"
        );
        println!("{target:>10} {:>9} {:>9} {:>8} {:>9} {:>18}", "depth mm", "force N", "min J", "volume %", "FEM force N");
    }
    for hold in &press.holds {
        let shown = match scene.drive {
            Drive::Force { .. } => hold.target,
            _ => hold.target * 1e3,
        };
        let fem = reference_values::at(scene, hold.target)
            .map_or("-".into(), |f| format!("{f:.4} ({:+.1} %)", (hold.force_n / f - 1.0) * 100.0));
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
        "\n{} ticks, {} took more than their 1 ms{}; half take at most {p50:.1} us, 99 % at most {p99:.1} us, the slowest took {max:.1} us, {:.1} % of 1 ms ({}{})",
        press.ticks.len(),
        press.deadline_misses,
        if press.timed_on == processor() { " (half may)" } else { " (none may)" },
        f64::from(max) * 0.1,
        if press.timed_on == processor() { "CPU time, " } else { "" },
        timed_on(press)
    );
    println!(
        "after release a dent of {:.4} mm is left; checksum of every node's state at the end {:016x}, equal on every machine",
        press.residual_m * 1e3,
        press.state_hash
    );
}

/// Names the machine, and the build unless it is the one of published times, `--profile measure`.
fn timed_on(press: &Press) -> String {
    let machine = &press.timed_on;
    match PROFILE {
        "measure" => machine.clone(),
        _ if *machine != processor() => machine.clone(),
        profile => format!("{machine}, profile {profile}; `--profile measure` is faster"),
    }
}
