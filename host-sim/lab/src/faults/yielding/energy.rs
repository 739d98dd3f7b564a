//! Energy at the port between device and hand, against the printed bound.

use palpate::haptic::account::EnergyBound;
use palpate_tissue::scene::TICK_S;

/// Ticks without touch and force after which a contact is over.
const FREE_TICKS: u32 = 20;

/// Energy that a hand was given in a run.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct GivenEnergy {
    /// Energy created in each contact: the most that was given since its touch, at least zero [J].
    pub contacts_j: Vec<f64>,
    /// Largest energy that was given since any instant without contact [J].
    pub most_j: f64,
    /// Largest ratio of the energy given since an instant without contact to the bound for the time
    /// since then (1).
    pub share: f64,
}

/// Books the energy of a run, from truth.
#[derive(Clone, Debug)]
pub struct Ledger {
    bound: EnergyBound,
    given: GivenEnergy,
    now_j: f64,
    /// Least energy given in an instant without contact [J].
    least_j: f64,
    /// Energy and time of the instant without contact from which the lasting part of the bound
    /// leaves most [J, s].
    from: (f64, f64),
    touch_j: f64,
    contact_j: f64,
    free_ticks: u32,
    ticks: u32,
}

impl Ledger {
    /// A ledger for a device with this bound. The run begins without contact.
    pub fn new(bound: EnergyBound) -> Self {
        Self {
            bound,
            given: GivenEnergy::default(),
            now_j: 0.0,
            least_j: 0.0,
            from: (0.0, 0.0),
            touch_j: 0.0,
            contact_j: 0.0,
            free_ticks: FREE_TICKS,
            ticks: 0,
        }
    }

    /// Books a tick: the energy given since the start of the run [J], and whether the tip touches
    /// the tissue or a force acts.
    pub fn tick(&mut self, now_j: f64, touches: bool) {
        let before_j = std::mem::replace(&mut self.now_j, now_j);
        self.ticks += 1;
        let now_s = f64::from(self.ticks) * TICK_S;
        let lasting_w = f64::from(self.bound.lasting_w);
        if touches {
            if self.free_ticks >= FREE_TICKS {
                (self.touch_j, self.contact_j) = (before_j, 0.0);
            }
            self.free_ticks = 0;
            self.contact_j = self.contact_j.max(now_j - self.touch_j);
            self.given.most_j = self.given.most_j.max(now_j - self.least_j);
            let (from_j, from_s) = self.from;
            let share = (now_j - from_j) / f64::from(self.bound.within_j((now_s - from_s) as f32));
            self.given.share = self.given.share.max(share);
        } else {
            self.free_ticks = self.free_ticks.saturating_add(1);
            self.least_j = self.least_j.min(now_j);
            if now_j - lasting_w * now_s < self.from.0 - lasting_w * self.from.1 {
                self.from = (now_j, now_s);
            }
            if self.free_ticks == FREE_TICKS {
                self.given.contacts_j.push(self.contact_j);
            }
        }
    }

    /// Energy given since the start of the run [J].
    pub fn now_j(&self) -> f64 {
        self.now_j
    }

    /// Energy that the hand was given since the instant without contact in which it had been given
    /// least [J].
    pub fn owed_j(&self) -> f64 {
        self.now_j - self.least_j
    }

    /// Closes the ledger, and the contact that has not ended.
    pub fn close(mut self) -> GivenEnergy {
        if self.free_ticks < FREE_TICKS {
            self.given.contacts_j.push(self.contact_j);
        }
        self.given
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn contacts_and_the_share_of_the_bound_are_counted_from_the_last_instant_without_contact() {
        let mut ledger = Ledger::new(EnergyBound { at_once_j: 1e-3, lasting_w: 0.0 });
        let mut tick = |now_j: f64, touches: bool, ticks: u32| (0..ticks).for_each(|_| ledger.tick(now_j, touches));
        // a contact takes 3 mJ from the hand, and the next one gives 2 mJ of that back
        tick(0.0, false, 30);
        tick(-3e-3, true, 30);
        tick(-3e-3, false, 30);
        tick(-1e-3, true, 30);
        assert_eq!(ledger.owed_j(), 2e-3);
        let given = ledger.close();
        assert_eq!(given.contacts_j, [0.0, 2e-3]);
        assert!(given.most_j == 2e-3 && (given.share - 2.0).abs() < 1e-6, "{given:?}");
    }
}
