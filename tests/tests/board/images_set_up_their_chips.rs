//! Registers that the flashed images leave as they have to be, where nothing else in a model shows
//! it.

use palpate_tests::register_model::{Flashed, Scenario, run};
use serde_json::Value;

use super::flashed_image_runs::{axes, target};

/// A patch takes longer to open than the UART's queue of 32 bytes takes to fill.
#[test]
fn the_pico_2_takes_bytes_by_an_interrupt() {
    const UART_MASK: u32 = 0x4007_0038;
    const RECEIVED_OR_WAITING: u64 = 1 << 4 | 1 << 6;
    let Some(journal) = run(target(), Flashed::Pico2, &Scenario { periods: &axes(3), more: Value::Null }) else { return };
    assert_eq!(journal.register(UART_MASK).map(|mask| mask & RECEIVED_OR_WAITING), Some(RECEIVED_OR_WAITING));
}

/// A Cortex-M7 reads ahead from external memory by its default map, which hangs the bus only if a
/// controller of such memory runs.
#[test]
fn the_h743_runs_no_controller_of_external_memory() {
    const AHB3_CLOCKS: u32 = 0x5802_44D4;
    const EXTERNAL: u64 = 1 << 12 | 1 << 14; // FMC, QUADSPI
    let Some(journal) = run(target(), Flashed::H743, &Scenario { periods: &axes(3), more: Value::Null }) else { return };
    assert_eq!(journal.register(AHB3_CLOCKS).unwrap_or(0) & EXTERNAL, 0);
    assert!(journal.register(0x5802_44E0).is_some_and(|clocks| clocks != 0), "the clocks of the pins are among these registers");
}
