//! Whole periods of the flashed images, which the register models trace at the end of a press: how
//! much of its millisecond a board needs, and what the times at which it writes its force change.

use palpate_tests::block_bound::{self, Flash, constant, instructions};
use palpate_tests::firmware_image::FirmwareImage;
use palpate_tests::pipeline_model::Listing;
use palpate_tests::register_model::{Flashed, Journal, Period};

/// Periods at the end of a press whose instructions are traced: they send twenty records and a
/// piece of the log.
pub const TRACED: usize = 40;
/// Cycles to enter and leave an interrupt (Arm DDI 0439B: 12 each).
const INTERRUPT_CYCLES: f64 = 24.0;
/// Largest share of a period that a board with a slow flash may need [%].
const PERIOD_PERCENT: f64 = 75.0;
/// Most instructions of a whole period of the Pico 2, in which a heartbeat comes and a record goes:
/// 85 % of the 72 391 that it took when this target was set.
const PICO_2_INSTRUCTIONS: usize = 61_532;
/// Largest change of a held force's mean by the times at which its ticks write it [%].
const JITTER_PERCENT: f64 = 0.1;

/// Checks the periods of a press.
pub fn judge(board: Flashed, journal: &Journal, periods: &[Period]) {
    match board {
        Flashed::F446 => {
            keeps_its_period(journal, &Flash::F446, 180e6);
            pulses_keep_the_mean(journal, periods, 180e6);
        }
        Flashed::G474 => {
            keeps_its_period(journal, &Flash::G474, 170e6);
            pulses_keep_the_mean(journal, periods, 170e6);
        }
        Flashed::Pico2 => keeps_its_instructions(journal),
        Flashed::H743 => {} // its tick runs from memory that needs no waits
    }
}

/// Checks that no traced period of a Pico 2 takes more instructions than it may. Its tick runs from
/// RAM, whose waits are unknown.
fn keeps_its_instructions(journal: &Journal) {
    let image = FirmwareImage::parse(&std::fs::read(&journal.image).unwrap()).unwrap();
    let longest = journal.rows.iter().map(|row| instructions(&image, &row.trace).len()).max().unwrap();
    println!("the longest of {TRACED} whole periods: {longest} instructions");
    assert!((40_000..=PICO_2_INSTRUCTIONS).contains(&longest), "{longest} instructions");
}

/// Checks that no traced period of a board with a slow flash takes more of its millisecond than it
/// may: interrupts, tick, record, log and link, whichever code waits for the flash.
fn keeps_its_period(journal: &Journal, flash: &Flash, clock_hz: f64) {
    let image = FirmwareImage::parse(&std::fs::read(&journal.image).unwrap()).unwrap();
    let listing = Listing::of(&journal.image);
    let in_flash = |address: &u32| (0x0800_0000..0x0900_0000).contains(address);
    let (mut longest, mut traced) = ([0.0; 3], 0);
    for row in journal.rows.iter().filter(|row| !row.trace.is_empty()) {
        let executed = instructions(&image, &row.trace);
        let interrupts = row.trace.iter().filter(|block| block[1] == 0).count() as f64;
        let core = block_bound::cycles(&image, std::slice::from_ref(&executed))
            + listing.result_stalls(&executed) as f64
            + INTERRUPT_CYCLES * interrupts;
        let constants = executed.iter().filter_map(|address| constant(&image, *address)).filter(in_flash);
        let waits = flash.waited(executed.iter().copied().filter(in_flash)) + flash.waited_for_constants(constants);
        let period = [executed.len() as f64, core, core + waits];
        longest = if period[2] > longest[2] { period } else { longest };
        traced += 1;
    }
    let [instructions, core, all] = longest;
    let share = |cycles: f64| 100.0 * cycles * 1e3 / clock_hz;
    println!(
        "the longest of {traced} whole periods: {instructions} instructions, {core:.0} cycles ({:.1} % of 1 ms), with waits for every line of the \
         flash that is not cached {all:.0} ({:.1} %)",
        share(core),
        share(all)
    );
    assert!(traced == TRACED && instructions > 50_000.0, "{traced} periods, {instructions} instructions");
    assert!(share(all) <= PERIOD_PERCENT, "{:.1} % of the period", share(all));
}

/// Checks that the pulses give the force that was written, whenever in its tick each of them was
/// written. Without a restart of the timer, the one pulse during which a force is written lies
/// between the old force and the new one, and all others have the written length.
fn pulses_keep_the_mean(journal: &Journal, periods: &[Period], clock_hz: f64) {
    let pulses_per_tick = clock_hz / 1e3 / f64::from(journal.period_steps);
    let percent = |held: bool| {
        let (mut changes, mut sum) = (0.0, 0.0);
        for (rows, counts) in journal.rows.windows(2).zip(periods.windows(2)) {
            if !held || counts[0].counts == counts[1].counts {
                let [old, new] = [0, 1].map(|n| rows[n].steps[2] as f64);
                (changes, sum) = (changes + (new - old).abs(), sum + new);
            }
        }
        100.0 * changes / (pulses_per_tick * sum)
    };
    let [all, held] = [false, true].map(percent);
    println!("jitter of the writes changes the mean force by at most {held:.3} % in the hold, {all:.3} % with the tap before it");
    assert!(journal.rows.iter().all(|row| row.restarts == 0) && held <= JITTER_PERCENT, "{held} %");
}
