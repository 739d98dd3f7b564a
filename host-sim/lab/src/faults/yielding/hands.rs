//! The campaign of yielding hands: its numbered cases, and running them.

use std::ops::Range;

use palpate::BuildError;
use palpate::haptic::cycle::Settings;
use palpate_tissue::scene::TICK_S;
use rayon::prelude::*;

use super::case::{Bounds, YieldingCase};
use super::family::family;
use super::genes::Genes;
use super::motion::MotionKind;
use super::run::RunLength;
use super::table::{FAMILY, HandsTable, LATENESSES, MINUTES};
use crate::faults::campaign::batches;
use crate::faults::paths::PathGround;
use palpate_loop::closed_loop::device::{DeviceProfile, PROFILES};

/// Number of runs that a thread executes at a time.
const BATCH: u64 = 4;

/// A campaign of yielding hands.
#[derive(Clone, Debug)]
pub struct Hands<'a> {
    ground: &'a PathGround,
    base: &'a DeviceProfile,
    runs: u64,
    seed: u64,
    length: RunLength,
    family: Vec<YieldingCase>,
    minutes: Vec<YieldingCase>,
}

impl<'a> Hands<'a> {
    /// This many random runs, every second one on a shipped device, the family of light hands on
    /// stiff tissue, and a minute of every motion on every shipped device; with `quick` shorter
    /// runs, an eighth of the family and no minutes.
    pub fn new(ground: &'a PathGround, runs: u64, seed: u64, quick: bool) -> Self {
        let base = &ground.devices[0];
        let (length, share) = if quick { (RunLength::QUICK, 8) } else { (RunLength::FULL, 1) };
        let minutes = if quick { Vec::new() } else { minutes(ground, seed) };
        Self { ground, base, runs, seed, length, family: family(ground, base, share), minutes }
    }

    /// Number of cases: the random runs, then the family, then the minutes.
    pub fn cases(&self) -> u64 {
        self.runs + (self.family.len() + self.minutes.len()) as u64
    }

    /// Name of the row and the case with this number.
    pub fn case(&self, number: u64) -> (&'static str, YieldingCase) {
        if let Some(n) = number.checked_sub(self.runs) {
            return match self.family.get(n as usize) {
                Some(case) => (FAMILY, case.clone()),
                None => (MINUTES, self.minutes[n as usize - self.family.len()].clone()),
            };
        }
        let genes = Genes::draw(number, self.seed);
        if number % 2 == 1 {
            let device = (number / 2) as usize % PROFILES.len();
            let name = PROFILES[device].0;
            return (name, YieldingCase::on_device(self.ground, &genes, &self.ground.devices[device], name));
        }
        let case = YieldingCase::of(self.ground, &genes, self.base, Bounds::Person);
        let late_s = f64::from(case.device.delay_ticks) * TICK_S + case.device.amplifier_lag_s;
        let group = LATENESSES.iter().find(|group| late_s < group.most_s);
        (group.map_or("", |group| group.name), case)
    }

    /// Runs the cases with these numbers; `change` may change the loop's settings, `done` is called
    /// after every batch. The tables of parts of a range add up to the table of the whole range.
    pub fn run(
        &self,
        cases: Range<u64>,
        change: impl Fn(&mut Settings) + Sync,
        done: impl Fn(u64) + Sync,
    ) -> Result<HandsTable, BuildError> {
        let part = |numbers: Range<u64>| {
            let mut table = HandsTable::default();
            for number in numbers.clone() {
                let (name, case) = self.case(number);
                let length = match name {
                    FAMILY => RunLength { motion_s: RunLength::FULL.motion_s, ..self.length },
                    MINUTES => RunLength::LONG,
                    _ => self.length,
                };
                table.count(self.ground, number, name, &case, &case.run(self.ground, length, &change)?);
            }
            done(numbers.end - numbers.start);
            Ok(table)
        };
        batches(cases, BATCH).map(part).try_reduce(HandsTable::default, |mut table, more| {
            table.add(more);
            Ok(table)
        })
    }
}

/// Every motion on every shipped device, by a random hand on random tissue.
fn minutes(ground: &PathGround, seed: u64) -> Vec<YieldingCase> {
    let mut cases = Vec::new();
    for (device, (name, _)) in ground.devices.iter().zip(PROFILES) {
        for kind in MotionKind::ALL {
            // from the end of the numbers, which the random runs begin with
            let genes = Genes::draw(u64::MAX - cases.len() as u64, seed);
            let mut case = YieldingCase::on_device(ground, &genes, device, name);
            case.motion.kind = kind;
            cases.push(case);
        }
    }
    cases
}
