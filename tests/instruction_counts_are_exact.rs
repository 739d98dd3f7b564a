//! The instruction counter of the emulator and the log of executed instructions agree, and the stages add up to the tick.

use std::{
    fs::File,
    io::BufReader,
    path::{Path, PathBuf},
};

use palpate_tests::{
    emulator::{Machine, Outcome, Run, build_firmware},
    exec_log::ExecLog,
    firmware_image::FirmwareImage,
    instruction_mix::{InstructionMix, calls_of},
};

/// At 64 ns an instruction the 40 ns of a clock count resolve single instructions.
const SHIFT: u32 = 6;
const NS_PER_INSTRUCTION: u64 = 1 << SHIFT;
const NS_PER_COUNT: u64 = 40;
const CLOCK: &str = "palpate_firmware::board::mps2::clock_counts";
const TICK: &str = "palpate::tick::tick";

fn logged_run(ticks: u32, log: &str) -> (FirmwareImage, Outcome, PathBuf) {
    let scratch = Path::new(env!("CARGO_TARGET_TMPDIR"));
    let elf = build_firmware(scratch.parent().unwrap(), &["stage-cost"]).unwrap();
    let log = scratch.join(log);
    let outcome = Run {
        machine: Machine::An386,
        shift: SHIFT,
        ticks,
        exec_log: Some(&log),
    }
    .start(&elf)
    .unwrap();
    (
        FirmwareImage::parse(&std::fs::read(&elf).unwrap()).unwrap(),
        outcome,
        log,
    )
}

fn open(log: &Path) -> ExecLog<BufReader<File>> {
    ExecLog::new(BufReader::new(File::open(log).unwrap()))
}

#[test]
fn the_log_and_the_counter_agree_to_the_instruction() {
    let (image, outcome, log) = logged_run(1, "one-tick.log");
    let clock = image.function_named(CLOCK).unwrap();
    let tick = image.function_named(TICK).unwrap().address;
    // instructions between the two reads of the clock that have the tick between them
    let (mut since_read, mut saw_tick, mut counted) = (0, false, None);
    for address in open(&log) {
        let address = address.unwrap();
        since_read += 1;
        saw_tick |= address == tick;
        if address == clock.address {
            if saw_tick && counted.is_none() {
                counted = Some(since_read);
            }
            since_read = 0;
        }
    }
    let by_clock_ns = outcome.number("longest_tick_ns").unwrap();
    let by_log_ns = counted.unwrap() * NS_PER_INSTRUCTION;
    std::fs::remove_file(&log).unwrap();
    println!("clock {by_clock_ns} ns, log {by_log_ns} ns");
    // less than one count of the clock, which is less than one instruction
    assert!(
        by_clock_ns.abs_diff(by_log_ns) < NS_PER_COUNT,
        "clock {by_clock_ns} ns, log {by_log_ns} ns"
    );
}

#[test]
fn stages_add_up_to_the_tick() {
    let ticks = 140; // the script's tip is in contact from tick 135
    let (image, _, log) = logged_run(ticks, "many-ticks.log");
    let calls = calls_of(TICK, &image, open(&log)).unwrap();
    std::fs::remove_file(&log).unwrap();
    assert_eq!(calls.len(), ticks as usize);
    let worst = calls
        .iter()
        .max_by(|a, b| a.total().cycles().total_cmp(&b.total().cycles()))
        .unwrap();
    print(&image, worst);
    for stage in [
        "tickcore::path::contact",
        "tickcore::path::spring",
        "tickcore::path::integrate",
    ] {
        let calls = worst
            .by_function(&image)
            .filter(|(name, _)| *name == stage)
            .map(|(_, cost)| cost.calls)
            .sum::<u64>();
        assert_eq!(calls, 1, "{stage}");
    }
    // 126 springs of two square roots and one division each
    let total = worst.total();
    assert!(total.count(palpate_tests::thumb::Class::FpRoot) >= 252);
    assert!(total.count(palpate_tests::thumb::Class::FpDivide) >= 126);
}

fn print(image: &FirmwareImage, mix: &InstructionMix) {
    use palpate_tests::thumb::Class::{
        Branch, FpDivide, FpLoad, FpMultiplyAdd, FpOp, FpRoot, FpStore, Integer, Load, Store,
    };
    let classes = [
        FpLoad,
        FpStore,
        FpOp,
        FpMultiplyAdd,
        FpDivide,
        FpRoot,
        Load,
        Store,
        Branch,
        Integer,
    ];
    println!(
        "{:32} {:>5} {:>7} {} {:>6} {:>9}",
        "function",
        "calls",
        "instr",
        classes.map(|c| format!("{c:>13?}")).join(" "),
        "jumps",
        "M4F cycles"
    );
    let total = mix.total();
    for (name, cost) in mix.by_function(image).chain([("total", &total)]) {
        let counts = classes.map(|c| format!("{:>13}", cost.count(c))).join(" ");
        println!(
            "{name:32} {:>5} {:>7} {counts} {:>6} {:>9}",
            cost.calls,
            cost.instructions(),
            cost.jumps(),
            cost.cycles()
        );
    }
}
