//! The program with which a state machine of the Pico 2 counts an encoder, taken from the registers
//! that the flashed image has written, counts every edge if edges are at least eleven cycles apart.

use std::path::Path;

use palpate_tests::register_model::{Flashed, Journal, Period, Scenario, run};
use rand_xoshiro::Xoshiro256PlusPlus;
use rand_xoshiro::rand_core::{Rng, SeedableRng};
use serde_json::Value;

const PIO: u32 = 0x5020_0000;
const INSTRUCTIONS: u32 = PIO + 0x48;
const CLOCK_DIVIDER: u32 = PIO + 0xC8;
const SHIFTS: u32 = PIO + 0xD0;
/// Shifts in to the left, out to the right, and none by itself.
const OUT_TO_THE_RIGHT: u64 = 1 << 19;
/// Shortest time between two edges [cycles]: 73 ns at 150 MHz.
const LEAST_CYCLES: u64 = 11;
/// Instruction at which the image starts the machine.
const START: usize = 17;
/// Levels of the two lines, the first one in the lower bit, in the order of positive motion.
const LEVELS: [u32; 4] = [0b00, 0b01, 0b11, 0b10];

/// A state machine with the instructions that the program uses.
#[derive(Default)]
struct Machine {
    at: usize,
    y: u32,
    input: u32,
    output: u32,
    published: u32,
}

impl Machine {
    fn step(&mut self, program: &[u16], pins: u32) {
        let code = u32::from(program[self.at]);
        let (argument, low) = (code >> 5 & 7, code & 31);
        assert_eq!(code >> 8 & 31, 0, "no delay is emulated");
        self.at += 1;
        match code >> 13 {
            0b000 => {
                let jumps = match argument {
                    0 => true,
                    4 => {
                        let was = self.y;
                        self.y = was.wrapping_sub(1);
                        was != 0
                    }
                    other => panic!("condition {other}"),
                };
                self.at = if jumps { low as usize } else { self.at };
            }
            0b010 => {
                assert_eq!(argument, 0, "reads the pins");
                self.input = self.input << low | pins & ((1 << low) - 1);
            }
            0b011 => {
                assert_eq!(argument, 6, "shifts into the input register");
                self.input = self.output & ((1 << low) - 1);
                self.output >>= low;
            }
            0b100 => (self.published, self.input) = (self.input, 0),
            0b101 => {
                let source = match low & 7 {
                    2 => self.y,
                    3 => 0,
                    6 => self.input,
                    other => panic!("source {other}"),
                };
                let value = if low >> 3 == 1 { !source } else { source };
                match argument {
                    2 => self.y = value,
                    5 => self.at = value as usize,
                    6 => self.input = value,
                    7 => self.output = value,
                    other => panic!("destination {other}"),
                }
            }
            other => panic!("instruction {other:03b}"),
        }
    }
}

/// Whether the program follows a random walk of 60 edges that are at least so many cycles apart.
fn follows(program: &[u16], least_cycles: u64, seed: u64) -> bool {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut machine = Machine { at: START, ..Machine::default() };
    let mut position = 0_i32;
    for _ in 0..60 {
        let cycles = least_cycles + random.next_u64() % 4;
        for _ in 0..cycles {
            machine.step(program, LEVELS[position.rem_euclid(4) as usize]);
        }
        position += if random.next_u64().is_multiple_of(3) { -1 } else { 1 };
    }
    for _ in 0..40 {
        machine.step(program, LEVELS[position.rem_euclid(4) as usize]);
    }
    machine.published.cast_signed() == position
}

#[test]
fn every_edge_is_counted_if_edges_are_eleven_cycles_apart_and_not_below() {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    let periods = [Period { counts: [0; 3], says: None, late: 0 }];
    let scenario = Scenario { periods: &periods, more: Value::Null };
    let Some(journal) = run(target, Flashed::Pico2, &scenario) else { return };
    let program = program(&journal);
    for cycles in LEAST_CYCLES..40 {
        assert!((0..50).all(|seed| follows(&program, cycles, seed)), "{cycles} cycles apart");
    }
    let wrong = (0..50).filter(|seed| !follows(&program, LEAST_CYCLES - 1, *seed)).count();
    println!("{} instructions; with edges {} cycles apart {wrong} of 50 walks are wrong", program.len(), LEAST_CYCLES - 1);
    assert!(wrong > 0, "the limit is not the one that is stated");
}

/// The program in the instruction memory, with the settings of all three machines checked.
fn program(journal: &Journal) -> Vec<u16> {
    for machine in 0..3 {
        assert_eq!(journal.register(SHIFTS + 0x18 * machine).unwrap() & 0x000F_0000, OUT_TO_THE_RIGHT & 0x000F_0000);
        assert_eq!(journal.register(CLOCK_DIVIDER + 0x18 * machine), Some(1 << 16), "each cycle is one of the core");
    }
    let codes = (0..32).map_while(|place| journal.register(INSTRUCTIONS + 4 * place));
    codes.map(|code| u16::try_from(code).unwrap()).collect()
}
