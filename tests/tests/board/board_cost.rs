//! Cost of a tick on the board: exact instruction counts per stage, estimated Cortex-M4F cycles,
//! and the budget of the shipped patches.
//!
//! `cargo test -p palpate-tests --release --test board board_cost -- --nocapture` prints the
//! tables. **Emulated instruction counts are exact; cycles are estimated from the documented cycle
//! table; neither is hardware timing.**

use std::path::Path;

use palpate::{Model, PatchFile};
use palpate_board::EmulatedBoard;
use palpate_controller::patch::{cost, site};
use palpate_controller::script::LEAD_TICKS;
use palpate_tests::block_bound::{self, Flash};
use palpate_tests::emulator::{Run, build_firmware, build_firmware_with};
use palpate_tests::exec_log::ExecLog;
use palpate_tests::firmware_image::FirmwareImage;
use palpate_tests::instruction_mix::{Cost, InstructionMix, calls_of};
use palpate_tests::packed;
use palpate_tests::pipeline_model::{Core, Listing, executed};
use palpate_tissue::budget::{BOUND, CostModel as Board, TIGHTNESS, triangles_in_reach};

/// At 32 ns per instruction, one clock count of 40 ns is one or two instructions. Few ticks are
/// run, so the watchdog does not interfere.
const COUNTING_SHIFT: u32 = 5;
/// At 4 ns per instruction a tick ends within its millisecond, and a clock count is ten
/// instructions.
const RUNNING_SHIFT: u32 = 2;
const NS_PER_COUNT: u64 = 40;
const CLOCK: &str = "palpate_firmware::board::mps2::clock_counts";
const TICK: &str = "palpate::tick::tick";
const RIM: &str = "palpate::stages::force::rim::hold";
/// Functions of the tick that decide whether the sensed tip is in the tissue.
const PRESENCE: &str = "palpate::stages::presence::";
/// Function of the haptic cycle that compares the shown tip with the sensed one.
const JUDGE: &str = "<palpate::haptic::apart::Apart as palpate::haptic::seen::Monitor>::judge";
/// Ticks outside the tissue in a logged run: start-up and the first ticks of arming. The force is
/// not enabled during the tap, which does not affect the cost.
const LOGGED_LEAD: u32 = 5;
/// The script's tap reaches 4 mm in its 23rd tick; by then it has touched every triangle that it
/// touches at all.
const LOGGED_TICKS: u32 = LOGGED_LEAD + 25;
/// Ticks of boot, self-test, bringing the patch to rest, and the first tick of the patch.
const FIRST_TICK: u32 = 4;
/// Budget of a tick on a Cortex-M4F at 168 MHz: 65 % of a millisecond [cycles].
const M4F_168_BUDGET: f64 = 109_200.0;
const M7_480_BUDGET: f64 = 312_000.0;
/// Share of a millisecond from which a board refuses a patch. The most pessimistic estimate has to
/// stay below it.
const REFUSED_SHARE: f64 = 0.75;
/// Largest share of the tick's cycles that rim springs may take.
const RIM_SHARE: f64 = 0.08;
/// Largest share of the tick's cycles that the comparison of the sensed tip with the tissue and
/// with the shown tip may take.
const GUARD_SHARE: f64 = 0.01;

struct Logged {
    image: FirmwareImage,
    ticks: Vec<InstructionMix>,
    /// Comparison of the two tips in each cycle that has one.
    judged: Vec<InstructionMix>,
    /// Addresses of the instructions that each tick executed.
    executed: Vec<Vec<u32>>,
    /// Longest tick by the board's own clock [ns]; it includes the haptic cycle and writing the
    /// converters.
    by_clock_ns: u64,
    /// Instructions of the longest tick by the log, counted between the two reads of the clock.
    by_log: u64,
}

fn scratch() -> &'static Path {
    Path::new(env!("CARGO_TARGET_TMPDIR"))
}

fn target() -> &'static Path {
    scratch().parent().unwrap()
}

/// Board on which a patch runs. The M4F refuses a patch made for the M7; both execute the same
/// instructions of the same image.
fn board_of(elf: &Path) -> EmulatedBoard {
    let large = elf.file_stem().is_some_and(|stem| stem.to_string_lossy().ends_with("m7-480"));
    if large { EmulatedBoard::M7 } else { EmulatedBoard::M4f }
}

fn logged(elf: &Path, ticks: u32, shift: u32) -> Logged {
    let image = FirmwareImage::parse(&std::fs::read(elf).unwrap()).unwrap();
    let log = scratch().join(format!("{}-{ticks}.log", elf.file_stem().unwrap().display()));
    let run =
        Run { machine: board_of(elf), shift, ticks, lead_ticks: LOGGED_LEAD, crash: None, restart: false, exec_log: Some(&log) };
    let outcome = run.start(elf).unwrap();
    // read once: to parse the text takes longer than everything below
    let file = std::io::BufReader::new(std::fs::File::open(&log).unwrap());
    let mut addresses: Vec<u32> = ExecLog::new(file).collect::<Result<_, _>>().unwrap();
    std::fs::remove_file(&log).unwrap();
    let [clock, tick, judge] = [CLOCK, TICK, JUDGE].map(|name| image.function_named(name).unwrap().address);
    // opening a patch presses it; the loop begins at the last reading of the clock before its first
    // comparison of the tips
    let compared = addresses.iter().position(|address| *address == judge).unwrap();
    let begins = addresses[..compared].iter().rposition(|address| *address == clock).unwrap();
    addresses.drain(..begins);
    let replayed = || addresses.iter().copied().map(Ok);
    let ticks = calls_of(TICK, &image, replayed()).unwrap();
    let judged = calls_of(JUDGE, &image, replayed()).unwrap();
    let executed = executed(TICK, &image, replayed()).unwrap();
    assert_eq!(executed.len(), ticks.len());

    let (mut since_read, mut saw_tick, mut by_log) = (0, false, 0);
    for address in addresses {
        since_read += 1;
        saw_tick |= address == tick;
        if address == clock {
            by_log = if saw_tick { by_log.max(since_read) } else { by_log };
            (since_read, saw_tick) = (0, false);
        }
    }
    Logged { image, ticks, judged, executed, by_clock_ns: outcome.number("longest_tick_ns").unwrap(), by_log }
}

/// Cost of a patch's most expensive tick.
struct Worst {
    /// Cycles of the rim springs and of the whole tick in the logged tap, built with the stages
    /// kept apart.
    rim: f64,
    tick: f64,
    /// Cycles of a tick in which each block runs as often as in any tick of the tap.
    blocks: f64,
    /// Factors by which waits for the flash of an F446 and of a G474 lengthen the tick.
    waits: [f64; 2],
    /// Instructions and cycles of the longest tick of a long run, including haptic cycle, pose and
    /// converters.
    instructions: u64,
    cycles: f64,
    /// Cycles of that tick by the most pessimistic estimate for a Cortex-M4F.
    cautious: f64,
    /// Share of the guard in the tick.
    guard: f64,
}

/// Cycles of a tick by independent estimates.
struct Estimates {
    /// Sum over the instruction table of a Cortex-M4F.
    table: f64,
    /// That sum plus one cycle for each result that the next instruction reads.
    stalled: f64,
    /// Cycles by LLVM's models of a Cortex-M4 and M7; `None` if `llvm-mca` is not installed.
    models: Option<[f64; 2]>,
}

impl Estimates {
    fn of(elf: &Path, table: f64, executed: &[u32]) -> Self {
        let listing = Listing::of(elf);
        let stalled = table + listing.result_stalls(executed) as f64;
        let [m4, m7] = [Core::M4, Core::M7].map(|core| listing.cycles(core, executed));
        Self { table, stalled, models: m4.zip(m7).map(|(m4, m7)| [m4, m7]) }
    }

    /// Largest estimate for a Cortex-M4F as a multiple of the table's sum (1).
    fn caution(&self) -> f64 {
        self.stalled.max(self.models.map_or(0.0, |[m4, _]| m4)) / self.table
    }

    fn print(&self, name: &str) {
        let Self { table, stalled, models } = self;
        println!("{name}: estimates of that tick [cycles], none of them measured on hardware");
        println!("  Cortex-M4F, sum of the manual's table {table:>9.0}");
        println!("  the same and stalls on results        {stalled:>9.0}");
        match models {
            Some([m4, m7]) => {
                println!("  LLVM's model of a Cortex-M4           {m4:>9.0}");
                println!("  LLVM's model of a Cortex-M7           {m7:>9.0} (patch and code in its fast memory)");
            }
            None => println!("  LLVM's models were not asked: llvm-mca is missing (Debian: apt-get install llvm)"),
        }
    }
}

fn worst_tick(patch: &Path) -> Worst {
    let name = patch.file_stem().unwrap().display();
    let elf = build_firmware_with(target(), &["stage-cost"], patch).unwrap();
    let logged = logged(&elf, LOGGED_TICKS, RUNNING_SHIFT);
    let ticks = logged.ticks.iter().zip(&logged.executed);
    let (worst, executed) = ticks.max_by(|(a, _), (b, _)| a.total().cycles().total_cmp(&b.total().cycles())).unwrap();
    let estimates = Estimates::of(&elf, worst.total().cycles(), executed);
    estimates.print(&name.to_string());
    println!("{name}: the worst tick of the tap, with the stages kept apart");
    print(&logged.image, worst);
    let tick = worst.total().cycles();
    let rim = stage(worst, &logged.image, RIM).cycles();
    let guard = guard_share(&logged);
    // the patch's first tick, in which no force acts, searches the tip everywhere
    let blocks = block_bound::cycles(&logged.image, &logged.executed[1..]);
    // boards copy their patch to RAM, and a G474 the tick's own code as well
    let copied =
        |address: &u32| logged.image.function_at(*address).is_some_and(|function| function.name.starts_with("palpate::"));
    let elsewhere = executed.iter().copied().filter(|address| !copied(address));
    let waits = [Flash::F446.waited(executed.iter().copied()), Flash::G474.waited(elsewhere)].map(|waited| 1.0 + waited / tick);

    let elf = build_firmware_with(target(), &[], patch).unwrap();
    let run = Run {
        machine: board_of(&elf),
        shift: RUNNING_SHIFT,
        ticks: 4_000,
        lead_ticks: LEAD_TICKS,
        crash: None,
        restart: false,
        exec_log: None,
    };
    let outcome = run.start(&elf).unwrap();
    assert_eq!(outcome.result().unwrap().overruns, 0);
    let instructions = outcome.number("longest_tick_ns").unwrap() >> RUNNING_SHIFT;
    let cycles = instructions as f64 * tick / worst.total().instructions() as f64;
    let cautious = cycles * estimates.caution();
    let model = PatchFile::open(packed::on_words(patch)).unwrap();
    let touched = triangles_in_reach(&model.model, model.site_m.into(), model.params.probe.radius_m);
    let budgeted = Board::named("m4f-168").unwrap().cost(&model.model, touched, 1).units;
    println!("{name}: {touched} triangles in reach, the budget counts with {budgeted:.0} cycles");
    println!(
        "{name}: rim springs {:.1} % of the tick; longest tick of 4 000, haptic cycle, pose and converters included: {instructions} instructions, about {cycles:.0} cycles \
         by the M4F's table ({:.1} % of 1 ms at 168 MHz, {:.1} % at 480 MHz), {cautious:.0} by the most cautious estimate ({:.1} %, {:.1} %)\n",
        100.0 * rim / tick,
        cycles / 1.68e3,
        cycles / 4.8e3,
        cautious / 1.68e3,
        cautious / 4.8e3
    );
    Worst { rim, tick, blocks, waits, instructions, cycles, cautious, guard }
}

fn stage(mix: &InstructionMix, image: &FirmwareImage, name: &str) -> Cost {
    mix.by_function(image).find(|(function, _)| *function == name).map(|(_, cost)| *cost).unwrap()
}

/// Checks that a shipped patch fits the budget, and that no larger patch would.
fn keeps_budget(name: &str, budget: f64) -> Worst {
    let worst = worst_tick(&packed::shipped(name));
    let file = PatchFile::open(packed::on_words(&packed::shipped(name))).unwrap();
    // the tap presses the triangles in reach of the site at most, other places more
    let most = site::most_in_reach(&file, &mut || {});
    let counted = |touched| f64::from(cost::cycles(&file, touched));
    let here = triangles_in_reach(&file.model, file.site_m.into(), file.params.probe.radius_m);
    let bound = worst.blocks + counted(most) - counted(here);
    let [f446, g474] = worst.waits;
    println!(
        "{name}: at most {bound:.0} cycles, with each block as often as in any tick and {most} triangles in place of {here}: {:.3} times the \
         board's count, {:.3} times the longest tick; with the flash of an F446 {f446:.3} times as long, of a G474 {g474:.3} times",
        bound / counted(most),
        bound / worst.tick
    );
    assert!((worst.tick..=BOUND * counted(most)).contains(&bound), "{bound:.0} of {:.0}", counted(most));
    assert!(bound <= TIGHTNESS * worst.tick);
    assert!(worst.cycles <= budget, "{name}: {:.0} estimated cycles, {budget:.0} fit", worst.cycles);
    assert!(worst.tick <= budget);
    assert!(worst.guard <= GUARD_SHARE, "{name}: the guard takes {:.2} % of a tick", 100.0 * worst.guard);
    // the table's sum may take 65 %; with the costs that it omits, the tick must stay below the
    // limit at which a board refuses the patch
    let refused = budget / 0.65 * REFUSED_SHARE;
    assert!(worst.cautious <= refused, "{name}: {:.0} cycles by the most cautious estimate", worst.cautious);
    // the patch must be the largest that fits, so it has to use most of the budget
    assert!(worst.cycles >= 0.85 * budget, "{name}: {:.0} estimated cycles leave room for more nodes", worst.cycles);
    worst
}

/// Checks that the rim springs take no more than their share of the tick.
fn keeps_rim_share(patch: &Path) -> Worst {
    let worst = worst_tick(patch);
    let share = worst.rim / worst.tick;
    assert!(share > 0.01, "a rim of {:.0} cycles proves nothing", worst.rim);
    assert!(share <= RIM_SHARE, "rim springs take {:.1} % of the tick", 100.0 * share);
    worst
}

/// Cycles of the functions whose names begin so, in one call of the tick.
fn stages(mix: &InstructionMix, image: &FirmwareImage, names: &str) -> f64 {
    mix.by_function(image).filter(|(function, _)| function.starts_with(names)).map(|(_, cost)| cost.cycles()).sum()
}

/// Largest share that the guard takes of the shortest tick of a tap, in free space or in contact.
/// The guard locates the sensed tip and compares it with the shown one. In the first tick of a
/// patch the tip may be anywhere, and the search for it takes longer.
fn guard_share(logged: &Logged) -> f64 {
    let Logged { image, ticks, judged, .. } = logged;
    let located: Vec<f64> = ticks.iter().map(|mix| stages(mix, image, PRESENCE)).collect();
    let (first, later) = located.split_first().unwrap();
    assert!(later.iter().all(|cycles| *cycles > 0.0), "every tick locates its tip");
    let located = later.iter().copied().fold(0.0, f64::max);
    let compared = judged.iter().map(|mix| mix.total().cycles()).fold(0.0, f64::max);
    assert!(compared > 0.0 && judged.len() > ticks.len() / 2, "{} of {} ticks compare the tips", judged.len(), ticks.len());
    let shortest = ticks.iter().map(|mix| mix.total().cycles()).fold(f64::INFINITY, f64::min);
    let share = (located + compared) / shortest;
    println!(
        "guard: at most {located:.0} cycles to locate the tip ({first:.0} in the patch's first tick) and {compared:.0} to compare the two tips: \
         {:.2} % of the shortest tick of {shortest:.0}",
        100.0 * share
    );
    share
}

#[test]
fn the_log_and_the_counter_agree_to_the_instruction() {
    let elf = build_firmware(target(), &["stage-cost"]).unwrap();
    let logged = logged(&elf, FIRST_TICK, COUNTING_SHIFT);
    let by_log_ns = logged.by_log << COUNTING_SHIFT;
    println!("clock {} ns, log {by_log_ns} ns", logged.by_clock_ns);
    // the difference is less than one count of the clock, hence less than two instructions
    assert!(logged.by_clock_ns.abs_diff(by_log_ns) < NS_PER_COUNT, "clock {} ns, log {by_log_ns} ns", logged.by_clock_ns);
}

#[test]
fn the_default_patch_fits_a_cortex_m4f_at_168_mhz() {
    let worst = keeps_budget("block-m4f-168.patch", M4F_168_BUDGET);
    for (chip, found) in ["m4f-180", "m4f-170"].into_iter().zip(worst.waits) {
        let counted = Board::named(chip).unwrap().waits;
        assert!((counted - 0.03..=counted).contains(&found), "{chip}: {found:.3} of {counted}");
    }
}

#[test]
#[ignore = "long: a log of millions of instructions; its count is in the golden file"]
fn the_larger_patch_fits_a_cortex_m7_at_480_mhz() {
    keeps_budget("block-m7-480.patch", M7_480_BUDGET);
}

/// The lattice of an organ gives a patch of this size more rim nodes than a block does, so its rim
/// springs may take a larger share.
#[test]
#[ignore = "long: a log of millions of instructions; its count is in the golden file"]
fn a_liver_with_its_rim_fits_a_cortex_m4f_at_168_mhz() {
    let worst = worst_tick(&packed::shipped("liver-m4f-168.patch"));
    assert!(worst.cycles <= M4F_168_BUDGET, "{:.0} estimated cycles, {M4F_168_BUDGET:.0} fit", worst.cycles);
    assert!(worst.rim <= 2.0 * RIM_SHARE * worst.tick, "rim springs take {:.0} of {:.0} cycles", worst.rim, worst.tick);
}

/// The outside of one patch is refined sixteen times: its rim springs change, but the cost of its
/// tick does not.
#[test]
#[ignore = "long: four more images and their logs"]
fn a_tick_costs_the_same_whatever_lies_behind_the_rim() {
    let coarse = packed::cut_block();
    let fine = packed::with_finer_outside(&coarse, 2);
    let tets = [&coarse, &fine].map(|p| p.far.cut.outside.mesh.tets.len());
    assert_eq!(tets[1], 16 * tets[0]);
    let [coarse, fine] =
        [(coarse, "cost-coarse.patch"), (fine, "cost-fine.patch")].map(|(p, name)| packed::pack(&p, scratch(), name));
    let [c, f] = [&coarse, &fine].map(|file| PatchFile::open(packed::on_words(file)).unwrap().model);
    assert_eq!(items(&c), items(&f));
    let changed = c.rim_nodes.iter().zip(f.rim_nodes).filter(|(a, b)| a.block_m != b.block_m).count();
    assert_eq!(changed, c.rim_nodes.len(), "a rim that does not know its outside proves nothing");

    let [c, f] = [keeps_rim_share(&coarse), keeps_rim_share(&fine)];
    println!("{} and {} elements outside: {} and {} instructions", tets[0], tets[1], c.instructions, f.instructions);
    assert_eq!(c.rim, f.rim);
    // the remaining difference comes from branches in the contact, which differs slightly
    let ratio = f.instructions as f64 / c.instructions as f64;
    assert!((1.0 / 1.05..=1.05).contains(&ratio), "{ratio}");
}

/// Lengths of all lists that a tick processes.
fn items(model: &Model) -> [usize; 7] {
    [
        model.nodes.len(),
        model.springs.len(),
        model.tets.len(),
        model.triangles.len(),
        model.foundation.len(),
        model.rim_nodes.len(),
        model.rim_edges.len(),
    ]
}

/// The costs that `fit` and `pack` assume agree with the emulator's counts.
#[test]
#[ignore = "long: two more images and their logs"]
fn the_budget_knows_what_a_rim_costs() {
    let whole = packed::pack(&packed::cut_block(), scratch(), "rim-whole.patch");
    let bare = packed::without_rim_edges(&whole, "rim-bare.patch");
    let [with, without] = [&whole, &bare].map(|patch| rim_cycles(patch.as_path()));
    let model = PatchFile::open(packed::on_words(&whole)).unwrap().model;
    let (nodes, edges) = (model.rim_nodes.len() as f64, model.rim_edges.len() as f64);
    let (node, edge) = (without / nodes, (with - without) / edges);
    println!("a rim node takes about {node:.1} cycles, a rim edge {edge:.1}");

    let board = Board::named("m4f-168").unwrap();
    let none = Model { rim_nodes: &[], rim_edges: &[], ..model };
    let budgeted = board.cost(&model, 0, 1).units - board.cost(&none, 0, 1).units;
    assert!((budgeted / with - 1.0).abs() < 0.05, "the budget says {budgeted:.0} cycles for a rim of {with:.0}");
}

fn rim_cycles(patch: &Path) -> f64 {
    let logged = logged(&build_firmware_with(target(), &["stage-cost"], patch).unwrap(), FIRST_TICK, RUNNING_SHIFT);
    stage(&logged.ticks[0], &logged.image, RIM).cycles()
}

fn print(image: &FirmwareImage, mix: &InstructionMix) {
    use palpate_tests::thumb::Class::{Branch, FpDivide, FpLoad, FpMultiplyAdd, FpOp, FpRoot, FpStore, Integer, Load, Store};
    let classes = [FpLoad, FpStore, FpOp, FpMultiplyAdd, FpDivide, FpRoot, Load, Store, Branch, Integer];
    let heads = ["vldr", "vstr", "v-arith", "vmla", "vdiv", "vsqrt", "ldr", "str", "branch", "integer"];
    let head = heads.map(|h| format!("{h:>8}")).join("");
    println!("{:<44} {:>7} {head} {:>11}", "stage", "instr", "est. cycles");
    let total = mix.total();
    for (name, cost) in mix.by_function(image).chain([("total", &total)]) {
        let counts = classes.map(|c| format!("{:>8}", cost.count(c))).join("");
        let name = name.trim_start_matches("palpate::");
        println!("{name:<44} {:>7} {counts} {:>11.0}", cost.instructions(), cost.cycles());
    }
}
