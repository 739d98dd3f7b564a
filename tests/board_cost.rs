//! What a tick costs on the board: exact instructions stage by stage, estimated Cortex-M4F cycles, and the budget that the shipped patches keep.
//!
//! `cargo test -p palpate-tests --release --test board_cost -- --nocapture` prints the tables. **Emulated instruction counts are exact; cycles are
//! estimated from the documented cycle table; neither is hardware timing.**

use std::path::Path;

use palpate_tests::emulator::{Machine, Run, build_firmware};
use palpate_tests::exec_log::ExecLog;
use palpate_tests::firmware_image::FirmwareImage;
use palpate_tests::instruction_mix::{InstructionMix, calls_of};

/// At 64 ns an instruction the 40 ns of a clock count resolve single instructions.
const COUNTING_SHIFT: u32 = 6;
/// At 4 ns an instruction the tick fits its millisecond, and the clock resolves ten instructions.
const RUNNING_SHIFT: u32 = 2;
const NS_PER_COUNT: u64 = 40;
const CLOCK: &str = "palpate_firmware::board::mps2::clock_counts";
const TICK: &str = "palpate::tick::tick";
/// The script's tap reaches 4 mm in tick 20; every triangle that it touches later is touched here.
const LOGGED_TICKS: u32 = 22;
/// 65 % of a millisecond [cycles].
const M4F_168_BUDGET: f64 = 109_000.0;
const M7_480_BUDGET: f64 = 312_000.0;

struct Logged {
    image: FirmwareImage,
    ticks: Vec<InstructionMix>,
    /// Instructions of the longest tick by the board's own clock, which includes reading the pose and writing the converters.
    by_clock_ns: u64,
    /// The same by the log: instructions between the two reads of the clock.
    by_log: u64,
}

fn logged(features: &[&str], ticks: u32, shift: u32) -> Logged {
    let scratch = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let elf = build_firmware(scratch.parent().unwrap(), features).unwrap();
    let image = FirmwareImage::parse(&std::fs::read(&elf).unwrap()).unwrap();
    let log = scratch.join(format!("{}-{ticks}.log", features.join("-")));
    let run = Run { machine: Machine::An386, shift, ticks, exec_log: Some(&log) };
    let outcome = run.start(&elf).unwrap();
    let open = || ExecLog::new(std::io::BufReader::new(std::fs::File::open(&log).unwrap()));
    let ticks = calls_of(TICK, &image, open()).unwrap();

    let clock = image.function_named(CLOCK).unwrap().address;
    let tick = image.function_named(TICK).unwrap().address;
    let (mut since_read, mut saw_tick, mut by_log) = (0, false, 0);
    for address in open().map(Result::unwrap) {
        since_read += 1;
        saw_tick |= address == tick;
        if address == clock {
            by_log = if saw_tick { by_log.max(since_read) } else { by_log };
            (since_read, saw_tick) = (0, false);
        }
    }
    std::fs::remove_file(&log).unwrap();
    Logged { image, ticks, by_clock_ns: outcome.number("longest_tick_ns").unwrap(), by_log }
}

#[test]
fn the_log_and_the_counter_agree_to_the_instruction() {
    let logged = logged(&["stage-cost"], 1, COUNTING_SHIFT);
    let by_log_ns = logged.by_log << COUNTING_SHIFT;
    println!("clock {} ns, log {by_log_ns} ns", logged.by_clock_ns);
    // less than one count of the clock, which is less than one instruction
    assert!(logged.by_clock_ns.abs_diff(by_log_ns) < NS_PER_COUNT, "clock {} ns, log {by_log_ns} ns", logged.by_clock_ns);
}

/// Checks a shipped patch: its worst tick in the logged tap and in a long run.
fn keeps_budget(features: &[&str], budget: f64, name: &str) {
    let logged = logged(&[features, &["stage-cost"]].concat(), LOGGED_TICKS, RUNNING_SHIFT);
    let worst = logged.ticks.iter().max_by(|a, b| a.total().cycles().total_cmp(&b.total().cycles())).unwrap();
    println!("{name}: the worst tick of the tap, with the stages kept apart");
    print(&logged.image, worst);

    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    let elf = build_firmware(target, features).unwrap();
    let run = Run { machine: Machine::An386, shift: RUNNING_SHIFT, ticks: 4_000, exec_log: None };
    let outcome = run.start(&elf).unwrap();
    assert_eq!(outcome.result().unwrap().overruns, 0);
    let longest = outcome.number("longest_tick_ns").unwrap() >> RUNNING_SHIFT;
    let per_instruction = worst.total().cycles() / worst.total().instructions() as f64;
    let cycles = longest as f64 * per_instruction;
    println!(
        "{name}: longest tick of 4 000, pose and converters included: {longest} instructions, about {cycles:.0} cycles of {budget:.0}\n"
    );
    assert!(cycles <= budget, "{name}: {cycles:.0} estimated cycles, {budget:.0} fit");
    assert!(worst.total().cycles() <= budget);
    // the largest patch that fits, not just one that fits
    assert!(cycles >= 0.85 * budget, "{name}: {cycles:.0} estimated cycles leave room for more nodes");
}

#[test]
fn the_default_patch_fits_a_cortex_m4f_at_168_mhz() {
    keeps_budget(&[], M4F_168_BUDGET, "block-m4f-168");
}

#[test]
fn the_larger_patch_fits_a_cortex_m7_at_480_mhz() {
    keeps_budget(&["patch-m7"], M7_480_BUDGET, "block-m7-480");
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
