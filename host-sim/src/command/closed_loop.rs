//! The command `palpate loop`.

use std::collections::BTreeMap;
use std::ops::Range;
use std::path::PathBuf;

use clap::Args;
use palpate::Vector3;

use super::Common;
use super::campaign::{Campaign, CaseArgs, fingerprint};
use super::hardware_in_loop::HardwareInLoop;
use super::length::metres;
use super::on_demand::{Program, build_and_run};
use super::progress::{Progress, told};
use super::verdict::Verdict;
use crate::error::Error;
use crate::loop_figures;
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_loop::closed_loop::hand::{HANDS, Hand};
use palpate_loop::closed_loop::prepared::{DEPTH_M, Prepared, fits};
use palpate_loop::closed_loop::report::{Report, Row, Target, pairs, report, rows};
use palpate_loop::closed_loop::run::Run;
use palpate_loop::closed_loop::stimulus::{STIMULI, Site, Stimulus};
use palpate_loop::closed_loop::trace;
use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;
use palpate_tissue::scene::Scene;

#[derive(Args, Clone, Debug)]
pub(super) struct LoopArgs {
    #[command(flatten)]
    common: Common,
    #[command(flatten)]
    runs: RunOptions,
    /// The hand feels the firmware's image in the emulator, with the scene's patch for a board;
    /// every tick must agree with the desktop's to the bit.
    #[arg(long, conflicts_with_all = ["wall", "cases"])]
    emulated: bool,
    /// The firmware's image, with --emulated [default: built with `cargo fw`].
    #[arg(long, value_name = "FILE", requires = "emulated")]
    image: Option<PathBuf>,
    #[command(flatten)]
    cases: CaseArgs,
}

/// The requested runs.
#[derive(Args, Clone, Debug)]
struct RunOptions {
    /// Press a plain spring of this stiffness in N/m in place of the scene's tissue.
    #[arg(long, allow_negative_numbers = true, value_name = "N/m", conflicts_with = "scene")]
    wall: Option<f64>,
    /// A device (touch, omni, touch-x, falcon, omega3, inverse3, hapkit, frictionless) or the path
    /// of a profile (.toml, see host-sim/devices).
    #[arg(long, value_name = "NAME|FILE", default_value = "touch")]
    device: String,
    /// Delay from computing a force to its arrival at the amplifier, in whole ticks [default: the
    /// device's].
    #[arg(long, allow_negative_numbers = true, value_name = "TICKS")]
    delay_ticks: Option<u8>,
    /// Amplifier's time constant in s [default: the device's].
    #[arg(long, allow_negative_numbers = true, value_name = "s")]
    lag_s: Option<f64>,
    /// One encoder count (10um, 0.01mm, 10e-6) [default: the device's].
    #[arg(long = "count", alias = "count-m", value_name = "LENGTH", value_parser = metres, allow_negative_numbers = true)]
    count_m: Option<f64>,
    /// Depth of presses (3mm, 0.3cm, 0.003) [default: 4mm, or the depth at which 85 % of the
    /// device's force limit is reached].
    #[arg(long = "depth", alias = "depth-m", value_name = "LENGTH", value_parser = metres, allow_negative_numbers = true, conflicts_with = "wall")]
    depth_m: Option<f64>,
    /// One hand, H0 to H6 [default: all].
    #[arg(long, value_name = "ID")]
    hand: Option<String>,
    /// One stimulus [default: all]: S1-0.05, S1-0.2, S1-0.5, S1-1 tap at that speed in m/s, S2 slow
    /// press, S3 target jumps in, S4 hold, S5 sine 0.5-20 Hz, S6 drag, S7 let go, S8 chirp, S9
    /// random motion, S10 across edges of elements, S11 stiffness x2 and /2, S12 organ swapped.
    #[arg(long, value_name = "ID")]
    stimulus: Option<String>,
    /// Hold for 3 s instead of a minute.
    #[arg(long)]
    quick: bool,
}

/// The campaign of all hands and stimuli on one surface.
pub(super) struct Loop {
    device: DeviceProfile,
    hands: Vec<Hand>,
    stimuli: Vec<Stimulus>,
    name: String,
    target: Target,
    board: Option<HardwareInLoop>,
    /// Scene whose tissue is pressed; a wall has no scene.
    scene: Option<Scene>,
    inputs: BTreeMap<String, String>,
}

impl LoopArgs {
    pub(super) fn run(&self) -> Result<(), Error> {
        if self.emulated && cfg!(not(feature = "full")) {
            return build_and_run(Program::Full);
        }
        Loop::of(self)?.start(&self.cases, &self.common.folder("loop"))
    }
}

impl Loop {
    fn of(args: &LoopArgs) -> Result<Self, Error> {
        let runs = &args.runs;
        let device = args.device()?;
        let hands = one_or_all("--hand", runs.hand.as_deref(), &HANDS, Hand::named, |h| h.id)?;
        let stimuli = one_or_all("--stimulus", runs.stimulus.as_deref(), &STIMULI, Stimulus::named, |s| s.id)?;
        let stimuli: Vec<Stimulus> = stimuli.into_iter().map(|s| if runs.quick { s.short() } else { s }).collect();
        if device.axes == 1 && stimuli.iter().all(Stimulus::crosses_edges) {
            return Err(TissueError::Usage(format!(
                "--stimulus {} goes along the surface, where {} has no axis: give another stimulus or device",
                stimuli.first().map_or("-", |s| s.id),
                device.name
            ))
            .into());
        }
        let Felt { name, target, board, scene } = args.target(&device)?;
        if let Some(stimulus) = stimuli.iter().find(|s| board.as_ref().is_some_and(|board| board.cannot_follow(s))) {
            return Err(TissueError::Usage(format!(
                "--stimulus {} swaps the far field, which a board takes with a patch alone: name another with --stimulus, or leave --emulated out",
                stimulus.id
            )).into());
        }
        let mut inputs = BTreeMap::new();
        if runs.wall.is_none() {
            inputs.extend(fingerprint::scene(&args.common.scene)?.map(|sum| ("scene".to_owned(), sum)));
        }
        if let Ok(profile) = std::fs::read(&runs.device) {
            inputs.insert("device".to_owned(), fingerprint::checksum(&profile));
        }
        Ok(Self { device, hands, stimuli, name, target, board, scene, inputs })
    }

    fn pairs(&self) -> Vec<(Hand, Stimulus)> {
        pairs(&self.device, &self.hands, &self.stimuli)
    }

    fn make(&self, hand: Hand, stimulus: Stimulus) -> Result<Run, Error> {
        match &self.board {
            Some(board) => board.run(&self.target.setup(&self.device, hand, stimulus)),
            None => Ok(self.target.run(&self.device, hand, stimulus)?),
        }
    }
}

impl Campaign for Loop {
    type Row = Row;

    fn cases(&self) -> u64 {
        self.pairs().len() as u64
    }

    fn inputs(&self) -> BTreeMap<String, String> {
        self.inputs.clone()
    }

    fn scene(&self) -> Option<&Scene> {
        self.scene.as_ref()
    }

    fn run(&self, cases: Range<u64>) -> Result<Vec<(u64, Row)>, Error> {
        let pairs: Vec<(Hand, Stimulus)> = self.pairs().into_iter().take(cases.end as usize).skip(cases.start as usize).collect();
        let progress = Progress::new(pairs.len() as u64, "runs");
        let rows = rows(&self.target, &self.device, &pairs, &|hand, stimulus| {
            let run = self.make(hand, stimulus)?;
            progress.inc(1);
            Ok::<Run, Error>(run)
        });
        progress.finish();
        Ok(cases.zip(rows?).collect())
    }

    fn report(&self, folder: OutputFolder, rows: Vec<Row>, all: bool) -> Result<(), Error> {
        let Self { device, hands, stimuli, name, .. } = self;
        let report = report(name, &self.target, device, rows);
        let site = if self.board.is_some() { Site::new(Vector3::zeros(), Vector3::z()) } else { self.target.site() };
        folder.write_summary(&report)?;
        let verdict = Verdict::of(judge(&report), || in_words(&report))?;
        let verdict = self.scene.iter().fold(verdict, Verdict::about).first();
        print(&report, hands, stimuli, all);
        folder.write("runs.csv", table(&report.runs)?.as_bytes())?;
        // the run that is shown in full: the only one, or the one that shakes most
        let shown = report.runs.iter().max_by(|a, b| a.shake_mn.unwrap_or(0.0).total_cmp(&b.shake_mn.unwrap_or(0.0)));
        if let Some((row, run)) =
            shown.map(|row| again(row, stimuli, |hand, stimulus| self.make(hand, stimulus))).transpose()?.flatten()
        {
            let below = format!("{name}, {}, {} {}: {}", device.name, row.hand, row.stimulus, row.verdict);
            trace::write(&folder, &run, &site)?;
            loop_figures::draw(&folder, "loop", &below, &run, &site)?;
            println!("\nthe run in trace.csv and the pictures: {}", named(row, hands, stimuli));
        }
        if self.board.is_some() {
            println!(
                "every force was the emulated board's, equal to the desktop's to the last bit, and so was every final state"
            );
        }
        let out = folder.publish()?;
        println!("wrote {}: summary.json, runs.csv, trace.csv, pictures as SVG and PNG", out.display());
        verdict.last()
    }
}

fn judge(report: &Report) -> Result<(), Error> {
    if report.broken.is_empty() {
        return Ok(());
    }
    let more =
        if report.broken.len() > 3 { format!(" and {} more, see summary.json", report.broken.len() - 3) } else { String::new() };
    let first: Vec<&str> = report.broken.iter().take(3).map(String::as_str).collect();
    Err(TissueError::Check(format!("{}{more}", first.join("; "))).into())
}

fn in_words(report: &Report) -> String {
    let quiet = report.runs.iter().filter(|r| r.verdict == "quiet").count();
    let toggling = match report.runs.iter().filter(|r| r.verdict == "a count toggles").count() {
        0 => String::new(),
        n => format!(", in {n} one encoder count toggles"),
    };
    let created_mj = report.most(|r| Some(r.created_mj)).unwrap_or(0.0);
    format!(
        "{quiet} of {} runs quiet{toggling}: the hand feels {} and nothing of the loop; at most {created_mj:.4} mJ created",
        report.runs.len(),
        report.target
    )
}

/// Ids of hand and stimulus of a run, with their names.
fn named(row: &Row, hands: &[Hand], stimuli: &[Stimulus]) -> String {
    let hand = hands.iter().find(|h| h.id == row.hand).map_or("", |h| h.name);
    let stimulus = stimuli.iter().find(|s| s.id == row.stimulus).map_or("", |s| s.name);
    format!("hand {} ({hand}), stimulus {} ({stimulus})", row.hand, row.stimulus)
}

/// Surface that a hand feels.
struct Felt {
    name: String,
    target: Target,
    /// The emulated board that computes the force, if there is one.
    board: Option<HardwareInLoop>,
    scene: Option<Scene>,
}

impl LoopArgs {
    fn device(&self) -> Result<DeviceProfile, Error> {
        let mut device = DeviceProfile::load(&self.runs.device)?;
        device.assumed().iter().for_each(|sentence| eprintln!("{sentence}"));
        device.delay_ticks = self.runs.delay_ticks.unwrap_or(device.delay_ticks);
        device.amplifier_lag_s = self.runs.lag_s.unwrap_or(device.amplifier_lag_s);
        device.count_m = self.runs.count_m.unwrap_or(device.count_m);
        device.check(&|key| match key {
            "amplifier_lag_s" => "--lag-s: amplifier_lag_s".into(),
            "count_m" => "--count: count_m".into(),
            "delay_ticks" => "--delay-ticks: delay_ticks".into(),
            other => format!("--device {}: {other}", self.runs.device),
        })?;
        Ok(device)
    }

    /// Sets up the tissue or the wall.
    fn target(&self, device: &DeviceProfile) -> Result<Felt, Error> {
        let Some(n_per_m) = self.runs.wall else {
            let mut scene = self.common.load()?;
            if self.emulated {
                scene.refuse_what_boards_lack("a board")?;
            }
            let patch = self.emulated.then(|| HardwareInLoop::patch_for(&scene)).transpose()?;
            scene.solver.patch = patch.clone().or(scene.solver.patch);
            let mut prepared = told("meshing the tissue", || {
                if self.emulated { Prepared::as_packed(&scene, device) } else { Prepared::of(&scene, device) }
            })?;
            if let Some(depth_m) = self.runs.depth_m {
                prepared.press_to(depth_m)?;
            }
            if let Some(note) = prepared.ceiling_note() {
                println!("note: {note}");
            }
            let board = match patch {
                Some(patch) => Some(HardwareInLoop::new(self.image.as_deref(), &patch, &prepared)?),
                None => None,
            };
            let target = Target::Tissue(Box::new(prepared), scene.tissue.youngs_modulus_pa);
            return Ok(Felt { name: scene.name.clone(), target, board, scene: Some(scene) });
        };
        if !(1.0..=1e5).contains(&n_per_m) {
            return Err(TissueError::Usage(format!(
                "--wall {n_per_m} is outside 1 .. 100000 N/m: give a stiffness in that range"
            ))
            .into());
        }
        // presses on a soft wall are at most `DEPTH_M` deep, and a hand swings twice as far
        fits(device, (device.force_limit_n / n_per_m).min(2.0 * DEPTH_M))?;
        Ok(Felt { name: format!("a wall of {n_per_m} N/m"), target: Target::Wall(n_per_m), board: None, scene: None })
    }
}

fn one_or_all<T: Copy>(
    option: &str,
    name: Option<&str>,
    all: &[T],
    named: impl Fn(&str) -> Option<T>,
    id: impl Fn(&T) -> &'static str,
) -> Result<Vec<T>, Error> {
    let Some(name) = name.filter(|n| *n != "all") else { return Ok(all.to_vec()) };
    let ids: Vec<&str> = all.iter().map(id).collect();
    Ok(named(name)
        .map(|one| vec![one])
        .ok_or_else(|| TissueError::Usage(format!("{option} {name} is unknown: give one of {}", ids.join(", "))))?)
}

/// Repeats the run of a row, to show it in full.
fn again<'a>(
    row: &'a Row,
    stimuli: &[Stimulus],
    make: impl Fn(Hand, Stimulus) -> Result<Run, Error>,
) -> Result<Option<(&'a Row, Run)>, Error> {
    let stimulus = stimuli.iter().find(|s| s.id == row.stimulus);
    let (Some(hand), Some(stimulus)) = (Hand::named(row.hand), stimulus) else { return Ok(None) };
    Ok(Some((row, make(hand, *stimulus)?)))
}

fn table(rows: &[Row]) -> Result<String, Error> {
    let write = |e: csv::Error| TissueError::Write { path: "runs.csv".into(), source: std::io::Error::other(e) };
    let mut csv = csv::Writer::from_writer(Vec::new());
    for row in rows {
        csv.serialize(row).map_err(write)?;
    }
    let bytes = csv.into_inner().map_err(|e| TissueError::Write { path: "runs.csv".into(), source: e.into_error() })?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

fn print(report: &Report, hands: &[Hand], stimuli: &[Stimulus], all: bool) {
    println!(
        "{} under {}: pressed to {:.2} mm, {:.3} N, {:.0} N/m there",
        report.target, report.device, report.depth_mm, report.static_n, report.slope_n_per_m
    );
    if let Some([slow, fast]) = report.tap_error_pct {
        println!(
            "  substeps  {} per tick: taps at 0.2 and 0.5 m/s are {slow:.1} and {fast:.1} % off the same patch with its true masses (at most 2 and 7.5 allowed)",
            report.substeps
        );
    }
    let beyond = if report.slope_n_per_m > report.encoder_ceiling_n_per_m { ": holds may toggle" } else { "" };
    match report.encoder_ceiling_n_per_m {
        ceiling if ceiling.is_finite() => {
            println!("  encoder   one count of {:.0} um is felt above {ceiling:.0} N/m{beyond}", report.count_m * 1e6);
        }
        _ => println!("  encoder   ideal: no counts"),
    }
    println!(
        "  energy    at most {:.3} mJ at once ({:.3} if four periods are missed) and {:.3} mJ in ten seconds, beyond what the hand gives\n",
        report.bound_at_once_mj, report.bound_after_four_missed_mj, report.bound_in_ten_seconds_mj
    );
    if all {
        print_matrix(report, hands, stimuli);
    } else {
        for row in report.runs.iter().filter(|r| r.verdict != "quiet") {
            println!("  {}: {}", named(row, hands, stimuli), row.verdict);
        }
    }
    let weak = report.runs.iter().filter(|r| r.weakened).count();
    println!(
        "{} of {} runs quiet, {weak} weakened because the hand pushed long at the device's force limit{}",
        report.runs.iter().filter(|r| r.verdict == "quiet").count(),
        report.runs.len(),
        if all { "" } else { "; --all prints each" }
    );
    let worst = |number: Option<f64>, digits: usize| number.map_or("-".into(), |n| format!("{n:.digits$}"));
    println!(
        "worst of all runs: {} mJ created; force above 50 Hz {} mN in a slow press, {} mN in a hold; force at rest {} % off; force turns by {} degrees per tick (-: not in these runs)",
        worst(report.most(|r| Some(r.created_mj)), 4),
        worst(report.most(|r| r.buzz_mn), 1),
        worst(report.most(|r| r.hold_buzz_mn), 1),
        worst(report.most(|r| r.static_error_pct), 3),
        worst(report.most(|r| r.turn_deg), 1)
    );
}

/// Prints a mark per hand and stimulus, and explains the marks and numbers.
fn print_matrix(report: &Report, hands: &[Hand], stimuli: &[Stimulus]) {
    print!("{:<22}", "");
    for stimulus in stimuli {
        print!("{:>8}", stimulus.id);
    }
    println!();
    for hand in hands {
        print!("{:<22}", format!("{} {}", hand.id, hand.name));
        for stimulus in stimuli {
            let row = report.runs.iter().find(|r| r.hand == hand.id && r.stimulus == stimulus.id);
            print!("{:>8}", row.map_or("-", mark));
        }
        println!();
    }
    let names: Vec<String> = stimuli.iter().map(|s| format!("{} {}", s.id, s.name)).collect();
    println!("\nstimuli: {}", names.join(", "));
    println!(
        ". quiet: in the last half second the handle moves by at most two counts (or 5 um), the force above 20 Hz by at most 20 mN RMS, and nothing grows"
    );
    println!("weak: quiet, and felt weaker because the hand pushed long at the device's force limit   count: one count toggles");
    println!("CYCLE: limit cycle   ENERGY: energy created   FAULT   BROKEN: an invariant\n");
}

fn mark(row: &Row) -> &'static str {
    match row.verdict.as_str() {
        "quiet" if row.weakened => "weak",
        "quiet" => ".",
        "a count toggles" => "count",
        "limit cycle" => "CYCLE",
        "creates energy" => "ENERGY",
        verdict if verdict.starts_with("fault") => "FAULT",
        _ => "BROKEN",
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use palpate_loop::closed_loop::device::PROFILES;

    #[test]
    fn the_help_names_every_profile() {
        use clap::CommandFactory;
        #[derive(clap::Parser)]
        struct Probe {
            #[command(flatten)]
            args: LoopArgs,
        }
        let help = Probe::command().render_long_help().to_string();
        assert!(PROFILES.iter().all(|(name, _)| help.contains(name)), "{help}");
    }
}
