//! Result files and printed report of `palpate emulate`, in addition to those of the press.

use serde::Serialize;

use crate::error::Error;
use palpate_board::timed::{IN_TIME_SHIFT, Timed};
use palpate_board::{self, EmulatedBoard, campaign, timing};
use palpate_charts::{self as charts, TickTimes};
use palpate_tissue::output::OutputFolder;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::Session;

/// `emulated.json`: results that `press` does not have.
#[derive(Debug, Serialize)]
pub struct Emulated {
    pub board: String,
    pub image: String,
    pub patch_bytes: usize,
    pub exchanges: usize,
    pub seconds: f64,
    pub times_real_time: f64,
    pub stack_used_bytes: u32,
    pub instructions: timing::Spread,
    pub cycles_per_instruction: Option<f64>,
    /// Run of the image's own patch at the pace of the tick timer.
    pub in_time: Option<Timed>,
    pub overruns: Vec<Timed>,
    pub campaign: campaign::Met,
    pub faults: Vec<String>,
    pub first_difference: Option<String>,
}

impl Emulated {
    pub fn in_words(&self) -> String {
        format!(
            "board {} and desktop agree to the last bit in all {} ticks; the longest tick takes {} instructions",
            self.board, self.exchanges, self.instructions.max
        )
    }

    /// Duration of a tick on a slower core, relative to the period (1).
    fn tick_over_period(&self, run: &Timed) -> f64 {
        let in_time = self.in_time.as_ref().and_then(|timed| timed.longest_over_period).unwrap_or(f64::NAN);
        in_time * f64::from(run.shift.saturating_sub(IN_TIME_SHIFT)).exp2()
    }
}

/// Writes the number of ticks for each number of instructions, the picture of all ticks, and the
/// runs on slower and slower cores.
pub fn write_timing(
    folder: &OutputFolder,
    scene: &Scene,
    session: &Session,
    machine: EmulatedBoard,
    seen: &[u64],
    emulated: &Emulated,
) -> Result<(), Error> {
    folder.write_csv("instructions.csv", ["instructions", "ticks"], timing::histogram(seen))?;
    let tick_us: Vec<f32> = seen.iter().map(|n| palpate_board::press::estimated_us(*n, machine)).collect();
    let (node_count, machine) = (session.report.nodes, machine.timed_on());
    let times = TickTimes { scene: &scene.name, node_count, machine, tick_us: &tick_us };
    charts::tick_time(folder.draft(), "tick_time_all", &times)?;
    folder.write("board.log", emulated.in_time.as_ref().map_or("", |run| &run.log).as_bytes())?;
    let head = ["shift", "tick_over_period", "ticks", "late_ticks", "missed_periods", "uncounted_periods", "watchdog_us"];
    let number = |emulated: Option<u64>| emulated.map_or(f64::NAN, |n| n as f64);
    Ok(folder.write_csv(
        "overruns.csv",
        head,
        emulated.overruns.iter().map(|run| {
            let times = [f64::from(run.shift), emulated.tick_over_period(run)];
            let counts = [run.ticks, run.late_ticks, run.missed_periods, run.uncounted(), run.watchdog_us].map(number);
            [times[0], times[1], counts[0], counts[1], counts[2], counts[3], counts[4]]
        }),
    )?)
}

pub fn print(emulated: &Emulated) {
    println!(
        "\nboard {} in lock-step: {} exchanges in {:.1} s, {:.1} times real time; patch of {} bytes uploaded; stack {} bytes",
        emulated.board,
        emulated.exchanges,
        emulated.seconds,
        emulated.times_real_time,
        emulated.patch_bytes,
        emulated.stack_used_bytes
    );
    let met = &emulated.campaign;
    println!(
        "{} ticks of contact, faults and recovery: force felt in {}, fault in {}, falling force in {}, recovered {} times; {} faults met",
        met.ticks,
        met.felt,
        met.faulted,
        met.ramping,
        met.recovered,
        emulated.faults.len()
    );
    let took = &emulated.instructions;
    println!(
        "a tick that runs the patch takes {} instructions (median; exact) and {} at most, {:.3} times as many; {} ticks had no force to compute and skipped it",
        took.median, took.max, took.worst_over_median, took.without_patch
    );
    if let Some(cycles) = emulated.cycles_per_instruction {
        let worst = took.max as f64 * cycles;
        println!(
            "estimated by the M4F's table: {cycles:.3} cycles an instruction, worst tick {worst:.0} cycles, {:.1} % of 1 ms at 168 MHz, {:.1} % at 480 MHz; not hardware timing",
            worst / 1.68e3,
            worst / 4.8e3
        );
    }
    print_timed(emulated);
    match &emulated.first_difference {
        None => println!("equal to the desktop's run to the last bit, in every tick and in the final state"),
        Some(difference) => println!("NOT equal to the desktop's run: {difference}"),
    }
}

/// Prints start times and late ticks of the image at the pace of its timer.
fn print_timed(emulated: &Emulated) {
    let Some(in_time) = &emulated.in_time else { return };
    println!("\nthe image's own patch, paced by the tick timer (emulated counts, not hardware time):");
    if let Some([first, last]) = in_time.start_instructions {
        println!(
            "a tick starts {first:.0} to {last:.0} instructions after the timer's edge over {} ticks: jitter {:.0}, to five instructions (a count of the clock)",
            in_time.ticks.unwrap_or(0),
            last - first
        );
    }
    if let Some(last) = in_time.log.lines().last() {
        println!("its log ends (all of it: board.log): {last}");
    }
    println!("{:>14} {:>7} {:>6} {:>15} {:>10}  end", "tick / period", "ticks", "late", "missed periods", "uncounted");
    let number = |n: Option<u64>| n.map_or("-".into(), |n| n.to_string());
    for run in &emulated.overruns {
        println!(
            "{:>14.1} {:>7} {:>6} {:>15} {:>10}  {}",
            emulated.tick_over_period(run),
            number(run.ticks),
            number(run.late_ticks),
            number(run.missed_periods),
            number(run.uncounted()),
            run.ended
        );
    }
}
