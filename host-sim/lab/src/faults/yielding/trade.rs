//! Cost of the account's settings: the force that is felt against the energy that is given.

use palpate::BuildError;
use palpate::haptic::account::AccountSettings;
use rayon::prelude::*;

use super::case::{Bounds, YieldingCase};
use super::genes::Genes;
use super::run::RunLength;
use crate::faults::paths::PathGround;

/// Delays at which the settings are compared [ticks].
const DELAYS: [u8; 3] = [0, 2, 5];
/// Accelerations [m/s^2] and shares of the handle's acceleration (1) that are compared.
const ACCELERATIONS_M_PER_S2: [f32; 6] = [0.0, 3.0, 6.0, 12.0, 25.0, 50.0];
const HANDLE_SHARES: [f32; 6] = [0.0, 0.3, 0.5, 0.7, 0.85, 1.0];
/// Energy of a contact that counts [J].
const OVER_J: f64 = 0.1e-3;

/// Result of some runs with some settings at a delay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TradePoint {
    /// Delay [ticks].
    pub delay_ticks: u8,
    /// Settings of the account.
    pub account: AccountSettings,
    /// Share of the patch's push that is felt (1).
    pub felt: f64,
    /// Share of the ticks with a push in which more than half of it was lost for more than 20 ticks
    /// (1).
    pub lost: f64,
    /// Largest energy given since an instant without contact [J].
    pub worst_j: f64,
    /// Contacts, and those that created more than 0.1 mJ.
    pub contacts: u64,
    /// See `contacts`.
    pub over: u64,
}

impl TradePoint {
    /// Number of points.
    pub fn count() -> usize {
        DELAYS.len() * Self::settings().len()
    }

    /// Settings that vary the acceleration, and then the share, and are else the default.
    pub fn settings() -> Vec<AccountSettings> {
        let default = AccountSettings::DEFAULT;
        let by_acceleration =
            ACCELERATIONS_M_PER_S2.map(|acceleration_m_per_s2| AccountSettings { acceleration_m_per_s2, ..default });
        let by_share = HANDLE_SHARES.map(|handle_share| AccountSettings { handle_share, ..default });
        by_acceleration.into_iter().chain(by_share).collect()
    }
}

/// Runs the same `runs` hands with every setting at every delay; `done` is called with the number
/// of runs of every point.
pub fn trade(ground: &PathGround, runs: u64, seed: u64, done: impl Fn(u64) + Sync) -> Result<Vec<TradePoint>, BuildError> {
    let mut points = Vec::new();
    for delay_ticks in DELAYS {
        for account in TradePoint::settings() {
            let run = |number: u64| {
                let genes = Genes::draw(number, seed);
                let mut case = YieldingCase::of(ground, &genes, &ground.devices[0], Bounds::Person);
                case.device.delay_ticks = delay_ticks;
                case.run(ground, RunLength::QUICK, |settings| settings.account = account)
            };
            let outcomes: Result<Vec<_>, BuildError> = (0..runs).into_par_iter().map(run).collect();
            let outcomes = outcomes?;
            let sum = |of: fn(&super::run::Outcome) -> f64| outcomes.iter().map(of).sum::<f64>();
            let contacts_j = || outcomes.iter().flat_map(|o| o.given.contacts_j.iter().copied());
            points.push(TradePoint {
                delay_ticks,
                account,
                felt: sum(|o| o.felt.felt_n_s) / sum(|o| o.felt.asked_n_s).max(f64::MIN_POSITIVE),
                lost: sum(|o| o.felt.lost_ticks as f64) / sum(|o| o.felt.asked_ticks as f64).max(1.0),
                worst_j: outcomes.iter().map(|o| o.given.most_j).fold(0.0, f64::max),
                contacts: contacts_j().count() as u64,
                over: contacts_j().filter(|j| *j > OVER_J).count() as u64,
            });
            done(runs);
        }
    }
    Ok(points)
}
