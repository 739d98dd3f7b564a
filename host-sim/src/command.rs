//! The command line.

#[cfg(not(feature = "full"))]
mod absent;
#[cfg(feature = "full")]
mod board;
#[cfg(feature = "full")]
mod boards;
pub mod campaign;
mod closed_loop;
mod completions;
#[cfg(feature = "full")]
mod emulate;
#[cfg(feature = "full")]
mod fit;
mod hardware_in_loop;
mod help;
#[cfg(feature = "full")]
mod identify;
mod length;
mod live;
mod merge;
mod mesh;
mod on_demand;
pub mod options;
#[cfg(feature = "full")]
mod pack;
mod press;
pub mod progress;
mod replay;
mod scene;
#[cfg(feature = "full")]
mod scene_list;
mod stop;
mod tools;
pub mod verdict;

use std::path::PathBuf;

use clap::error::ErrorKind;
use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand};

use crate::error::Error;
use crate::provenance;
use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;
use palpate_tissue::scene::{Change, Scene};

use self::on_demand::{Program, build_and_run};
use self::options::accept::AcceptArgs;
use self::options::board::BoardCommand;
use self::options::chart::ChartArgs;
use self::options::emulate::EmulateArgs;
use self::options::faults::FaultsArgs;
use self::options::fit::FitArgs;
use self::options::identify::IdentifyArgs;
use self::options::pack::PackArgs;
use self::options::paper::PaperCommand;
use self::options::stability::StabilityArgs;
use self::options::suite::SuiteArgs;
use self::options::unseen::UnseenArgs;

/// Soft tissue for haptic devices: press it, measure it, pack it for a board.
///
/// Without a command, presses the default block and writes the results to out/press.
#[derive(Debug, Parser)]
#[command(name = "palpate", bin_name = "palpate", version, max_term_width = 110, after_help = AFTER_HELP)]
pub struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Press a scene at 1 kHz in virtual time: force-depth curve, tick times, trace, picture of the
    /// dent.
    ///
    /// Writes summary.json, trace.csv (one row per tick), surface_<k>.csv (the surface at the end
    /// of hold k) and pictures as SVG and PNG. Fails a check (exit code 1) on a fault, a tick over
    /// 1 ms, an inverted tet, or a force that is lost or does not rise with depth.
    Press(press::PressArgs),
    /// Print a scene to start from, or list those that ship.
    ///
    /// `palpate scene nodule > mine.toml` makes a file to change; every command with --scene
    /// accepts it.
    Scene(scene::SceneArgs),
    /// Fit a patch to finite elements of a scene, and measure its error at unseen places.
    ///
    /// A block is fitted whole; of an organ or a mesh file the patch is the piece around the site,
    /// with rim springs for the rest, and so it is of a block with --radius. With --board the piece
    /// fills the budget of a board; with --smallest it is the smallest that keeps --tolerance-pct
    /// there. A stopped run continues where it was when it is started again, except a search for
    /// the smallest, which reuses the finite elements. Writes <scene>-<nodes>.patch
    /// (<scene>-<board>.patch for a board), a record of the fit and its errors beside it
    /// (.patch.json), answer.json, summary.json, accuracy.csv, convergence.csv and pictures as SVG
    /// and PNG; a search writes searched.csv and its chart instead. Fails (exit code 1) if the
    /// error is larger than --tolerance-pct, and suggests a remedy or a board that would do.
    Fit(FitArgs),
    /// Identify a tissue from measured forces: modulus, stiffening and relaxation, with intervals
    /// and what the data cannot say.
    ///
    /// Reads tests in which a ball presses a slab, perhaps is held, and retreats. Columns are known
    /// by name and unit, in four languages. The model of the test is our own finite elements.
    /// Writes identified.toml (a scene with comments), fit.csv (data and model), a picture as SVG
    /// and PNG, and summary.json. Values that the data do not determine are given as intervals,
    /// with the measurement that would determine them.
    Identify(IdentifyArgs),
    /// Merge ranges of a campaign's cases, from one machine or several: writes the result that one
    /// run of all cases writes.
    ///
    /// `palpate faults --runs 200 --cases 0..100 --out out/parts` runs the first half of the cases
    /// and writes their rows to out/parts/cases-0-100/rows.csv, and `--cases 100..200` runs the
    /// other half, perhaps on another machine. `palpate merge out/parts` reports both as one
    /// result, and prints what `palpate faults --runs 200` prints. accept, chart, faults, loop,
    /// stability, suite, unseen, and fit with --scenes have the option --cases. Fails (exit code 2)
    /// if cases are missing or there twice, or a file is damaged or comes from another program,
    /// scene or command line, and says what to run again; nothing is removed. The command's own
    /// checks are made here, on the merged result.
    Merge(merge::MergeArgs),
    /// Check a mesh or surface file, fill a surface with tets.
    #[command(subcommand)]
    Mesh(mesh::MeshCommand),
    /// Build a scene's patch and write it as a patch file for a board.
    ///
    /// Writes <scene>-<board>.patch. The firmware can load the file, and a scene presses it with
    /// patch = "FILE" under [solver].
    Pack(PackArgs),
    /// Close the loop over an emulated hand and device, and report what a person would feel besides
    /// the tissue.
    ///
    /// Runs every hand with every stimulus, checks every tick against the invariants, and evaluates
    /// limit cycles, energy, vibration and static error. Writes summary.json, runs.csv and, for the
    /// run that shakes most, trace.csv and pictures as SVG and PNG. Fails (exit code 1) if anything
    /// but the tissue is felt, energy is created or an invariant is broken; above the encoder's
    /// ceiling a toggling count is reported and is not a failure.
    Loop(closed_loop::LoopArgs),
    /// Use a flashed board on a serial port: find it, arm, stop, record, send patches.
    #[command(subcommand)]
    Board(BoardCommand),
    /// Run the firmware's image in the emulator, driven in lock-step by the scene's finger, and
    /// compare it with this machine bit for bit.
    ///
    /// The scene's patch is uploaded to the board and pressed; random presses, faults and recovery
    /// follow. Writes what `press` writes, with the force on the device and estimated times of a
    /// Cortex-M4F, and emulated.json. Fails (exit code 1) at the first bit that differs, and if
    /// `press` fails. Needs qemu-system-arm, and the repository unless --image and --patch are
    /// given.
    Emulate(EmulateArgs),
    /// Press tissue with the mouse: in a window, or in a browser.
    ///
    /// Shows how the tissue yields, the force, and the state of the loop. Stiffness, a nodule,
    /// device and hand can be changed; the key N hides a nodule to search for and starts a scored
    /// search. Records traces. Window and page are a package of their own, host-sim/live, which is
    /// built at first use. With --replay a trace is run once more: writes summary.json and
    /// trace.csv (one row per tick), and fails (exit code 1) at the first bit that differs.
    Live(live::LiveArgs),
    /// Check the project's claims: chart, stability, paper, accept, faults, unseen.
    ///
    /// Each is a command by its own name too: `palpate chart` is `palpate check chart`.
    #[command(subcommand)]
    Check(StudyCommand),
    #[command(flatten)]
    Short(StudyCommand),
    /// Print a script with which a shell completes the words of this command.
    Completions(completions::CompletionsArgs),
}

/// The studies of the evidence's workspace.
#[derive(Debug, Subcommand)]
enum StudyCommand {
    /// Chart speed against accuracy: all methods at four sizes and two stiffnesses, under the same
    /// press.
    ///
    /// Writes chart.csv (one row per run), fronts.csv (the Pareto fronts), report.md, summary.json
    /// and pictures as SVG and PNG. For a method that does not survive the press, the row says how
    /// it fails.
    Chart(ChartArgs),
    /// Run every method on twelve scenes that differ from the plain block in one thing each, and
    /// say which is the cheapest that each scene needs: the law without nodes, a patch, or another.
    ///
    /// Writes suite.csv (one row per scene), rows.csv (one per scene, method and mesh), a picture
    /// and summary.json.
    Suite(SuiteArgs),
    /// Find where methods and loops fail, and the margin to failure.
    ///
    /// Models: every method at stiffnesses from 1 to 200 kPa, pressed, tapped, jittered, with an
    /// inclusion, released. Loops: hand by delay by device, with the largest stiffness that our
    /// controller and nine others keep stable, and the limit of the encoder. Writes summary.json,
    /// its tables as CSV and pictures as SVG and PNG. Fails (exit code 1) if the product does not
    /// withstand 8 mm, a tap of 0.5 m/s, jitter, a ten times stiffer inclusion and a release from
    /// 3.5 to 100 kPa, or if our loop is not stable at 400 N/m with every hand.
    Stability(StabilityArgs),
    /// Regenerate the tables and figures of a paper that this project implements, and say which of
    /// its claims held: takes minutes, with --quick half a minute.
    #[command(subcommand)]
    Paper(PaperCommand),
    /// Compare the model with raw measurements of tissue and with closed forms: what is fitted,
    /// what is predicted, and the prediction without the term that is tested.
    ///
    /// Writes summary.json, accept.csv (one row per figure), <data set>.csv and a picture of every
    /// data set as SVG and PNG. Fails (exit code 1) if a figure is outside its measured range, or
    /// if all figures of a row would be accepted without the term that it tests.
    Accept(AcceptArgs),
    /// Inject every kind of fault into the haptic loop, with every hand, at every moment of a
    /// touch, and check the reaction.
    ///
    /// Writes faults.csv (one row per kind of fault), summary.json and a picture as SVG and PNG.
    /// Fails (exit code 1) if a run breaks an invariant of the loop, or if the reaction is missing,
    /// late or wrong.
    Faults(FaultsArgs),
    /// Draw random scenes, fit each, and compare its patch with finite elements that the fit has
    /// not seen: in how many does the stated error hold.
    ///
    /// The scenes are blocks, domes, wedges, steps and ridges, pressed beside their edges too.
    /// Writes unseen.csv (one row per scene), report.md and summary.json. Fails (exit code 1) if
    /// the stated error is too small in more than one scene in twenty, or by more than half in any.
    Unseen(UnseenArgs),
}

const AFTER_HELP: &str = "\
Built when first used, which takes some minutes: fit, identify, pack, board, emulate, check, and the option --emulated. Not in the lists:
`palpate completions SHELL` prints a script with which a shell completes these words, and each check is a command by its own name too.

Times in the help of a command are processor time, all cores together: an idle machine with two cores may take half as long, a busy one takes
longer. A long run prints its progress from time to time.

Exit code: 0 if what the command promises held, 1 if a check failed, 2 on bad input. A verdict that begins with `warning:`
is a result that should not be relied on: it says why, and the exit code is 0.

Output: a result appears in its folder whole, in place of an earlier one, when the run is done, also if a check failed. A run that is stopped, or
meets a full disk, leaves the earlier result as it was. A second run into the same folder is refused, and so is a folder with files but without
a result (pack adds its files to any folder). Patches, and files that you put beside a result, stay.";

/// Options of most commands.
#[derive(Args, Clone, Debug)]
pub struct Common {
    /// A preset (block, block-deep, block-20kpa, nodule, abdomen, foot, organ-liver, beef,
    /// pig-liver) or the path of a scene file (.toml, see host-sim/scenes).
    #[arg(long, value_name = "NAME|FILE", default_value = "block")]
    pub scene: String,
    /// Change a key of the scene, such as `tissue.youngs_modulus_pa=5000` or
    /// `tissue.inclusion.0.radius_m=0.004`. May be given several times.
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub changes: Vec<Change>,
    /// Output folder, created if missing; a finished run replaces an earlier result in it.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
}

impl Common {
    /// Options for a scene without changes of its keys.
    fn of(scene: &str, out: Option<PathBuf>) -> Self {
        Self { scene: scene.to_owned(), changes: Vec::new(), out }
    }

    /// Loads the requested scene with the changes of its keys.
    fn load(&self) -> Result<Scene, Error> {
        Ok(Scene::load_with(&self.scene, &self.changes)?)
    }

    /// Opens and locks the output folder of a command, for a result of a scene.
    fn open(&self, command: &str, scene: &Scene) -> Result<OutputFolder, Error> {
        let folder = self.folder(command);
        stop::says_what_stays(&folder);
        Ok(OutputFolder::open(&folder)?.made_by(provenance::of(Some(scene))))
    }

    fn folder(&self, command: &str) -> PathBuf {
        self.out.clone().unwrap_or_else(|| PathBuf::from("out").join(command))
    }
}

impl Cli {
    /// Reads the command line.
    pub fn read() -> Result<Self, clap::Error> {
        let mut command = help::grouped(Self::command());
        // `palpate NAME`, `palpate help NAME` and `palpate check NAME`
        let mut words = std::env::args_os()
            .skip(1)
            .map(|word| word.to_string_lossy().into_owned())
            .skip_while(|word| word == "help" || word == "check");
        if let Some(why) =
            words.next().and_then(|name| help::gone(&name)).or_else(|| words.find_map(|word| help::gone_option(&word)))
        {
            return Err(command.error(ErrorKind::InvalidSubcommand, why));
        }
        let mut matches = command.try_get_matches_from_mut(std::env::args_os())?;
        Self::from_arg_matches_mut(&mut matches).map_err(|error| error.format(&mut command))
    }

    /// Runs the command.
    pub fn run(&self) -> Result<(), Error> {
        match &self.command {
            None => press::PressArgs::default().run(),
            Some(Command::Press(args)) => args.run(),
            Some(Command::Board(command)) => checked(command.check(), || command.run()),
            Some(Command::Completions(args)) => args.run(),
            Some(Command::Emulate(args)) => checked(args.check(), || args.run()),
            Some(Command::Fit(args)) => checked(args.check(), || args.run()),
            Some(Command::Identify(args)) => checked(args.check(), || args.run()),
            Some(Command::Live(args)) => args.run(),
            Some(Command::Loop(args)) => args.run(),
            Some(Command::Merge(args)) => args.command()?.run(),
            Some(Command::Mesh(command)) => command.run(),
            Some(Command::Pack(args)) => checked(args.check(), || args.run()),
            Some(Command::Scene(args)) => args.run(),
            Some(Command::Check(_) | Command::Short(_)) => build_and_run(Program::Lab),
        }
    }

    /// Runs the command, which must be one that the evidence's workspace executes, with `study`.
    pub fn run_study(&self, study: impl FnOnce(Study<'_>) -> Result<(), Error>) -> Result<(), Error> {
        let asked = match &self.command {
            Some(Command::Merge(args)) => return args.command()?.run_study(study),
            Some(Command::Check(asked) | Command::Short(asked)) => asked,
            _ => return Err(TissueError::Usage("this program has the studies alone: run palpate".into()).into()),
        };
        study(match asked {
            StudyCommand::Accept(args) => Study::Accept(args),
            StudyCommand::Chart(args) => Study::Chart(args),
            StudyCommand::Faults(args) => Study::Faults(args),
            StudyCommand::Paper(command) => Study::Paper(command),
            StudyCommand::Stability(args) => Study::Stability(args),
            StudyCommand::Suite(args) => Study::Suite(args),
            StudyCommand::Unseen(args) => Study::Unseen(args),
        })
    }
}

/// Runs a command whose arguments are sound.
fn checked(check: Result<(), Error>, run: impl FnOnce() -> Result<(), Error>) -> Result<(), Error> {
    check.and_then(|()| run())
}

/// A command that the evidence's workspace (`host-sim/lab`) executes.
#[derive(Clone, Copy, Debug)]
pub enum Study<'a> {
    /// `palpate accept`
    Accept(&'a AcceptArgs),
    /// `palpate chart`
    Chart(&'a ChartArgs),
    /// `palpate faults`
    Faults(&'a FaultsArgs),
    /// `palpate paper`
    Paper(&'a PaperCommand),
    /// `palpate stability`
    Stability(&'a StabilityArgs),
    /// `palpate suite`
    Suite(&'a SuiteArgs),
    /// `palpate unseen`
    Unseen(&'a UnseenArgs),
}
