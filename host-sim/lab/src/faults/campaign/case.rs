//! One run of the campaign, derived from a number.

use palpate::Vector3;
use rand_xoshiro::SplitMix64;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use crate::faults::faulty::list::FAULTS;
use crate::faults::faulty::{FaultType, Injection, Needs, TissueFault};
use palpate_loop::closed_loop::hand::{HANDS, Hand};
use palpate_loop::closed_loop::stimulus::Stimulus;

/// Motion of the hand: a stimulus and the speed of its approach.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Id of one of [`palpate_loop::closed_loop::stimulus::STIMULI`].
    pub id: &'static str,
    /// Speed of the approach [m/s].
    m_per_s: f64,
}

/// The motions: two taps, a slow press, a hold, a sine, a drag, and a hand that lets go.
pub const MOTIONS: [Motion; 7] = [
    Motion { id: "S1-0.2", m_per_s: 0.2 },
    Motion { id: "S1-0.5", m_per_s: 0.5 },
    Motion { id: "S2", m_per_s: 5e-3 },
    Motion { id: "S4", m_per_s: 0.05 },
    Motion { id: "S5", m_per_s: 0.05 },
    Motion { id: "S6", m_per_s: 0.05 },
    Motion { id: "S7", m_per_s: 0.05 },
];

impl Motion {
    /// The stimulus with this id.
    pub fn stimulus(&self) -> Option<Stimulus> {
        Stimulus::named(self.id)
    }

    /// Time in the trajectory at which the run begins [s]: most of a slow approach is skipped.
    pub fn from_s(&self) -> f64 {
        (4.0e-3 / self.m_per_s - 0.02).max(0.0)
    }
}

/// Moment at which the fault begins.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Moment {
    /// Before the probe touches the tissue.
    Free,
    /// At the first touch.
    Touch,
    /// After 40 ticks of contact.
    Deep,
    /// During the retreat, or when the hand lets go.
    Release,
}

const MOMENTS: [Moment; 4] = [Moment::Free, Moment::Touch, Moment::Deep, Moment::Release];

/// Description of one run.
#[derive(Clone, Debug)]
pub struct Case {
    /// Number of the run in the campaign.
    pub number: u64,
    /// Index of the planted fault in [`FAULTS`].
    pub fault: usize,
    /// Hand that holds the device.
    pub hand: Hand,
    /// Motion of the hand.
    pub motion: Motion,
    /// Moment at which the fault begins.
    pub moment: Moment,
    /// Delay of the fault after that moment [ticks].
    pub after_ticks: u32,
    /// Whether the run is on the patch; otherwise it is on the wall.
    pub on_patch: bool,
    /// Random number (0 .. 1) that sets the depth and the sideways offset of a probe that is in the
    /// tissue, or is waved about, during start-up.
    pub share: f64,
    /// Seed of the noise.
    pub noise: u64,
}

impl Case {
    /// Outward normal of the wall, which is tilted so that it is parallel to no axis.
    pub const WALL_NORMAL: Vector3<f32> = Vector3::new(0.48, 0.6, 0.64);

    /// Draws the run with this number.
    pub fn draw(number: u64, seed: u64) -> Self {
        let types = FAULTS.len() as u64;
        let mut random = SplitMix64::seed_from_u64(seed ^ number.wrapping_mul(0x9e37_79b9_7f4a_7c15));
        let mut below = |n: usize| (random.next_u64() % n as u64) as usize;
        let fault = (number % types) as usize;
        let moment = MOMENTS[below(4)];
        let motion = MOTIONS[below(MOTIONS.len())];
        let span = match moment {
            Moment::Free | Moment::Touch => 12,
            Moment::Deep => 150,
            Moment::Release => 25,
        };
        let mut case = Self {
            number,
            fault,
            hand: HANDS[below(HANDS.len())],
            motion,
            moment,
            after_ticks: below(span) as u32,
            on_patch: below(2) == 0,
            share: below(1 << 20) as f64 / f64::from(1_u32 << 20),
            noise: 0,
        };
        case.noise = random.next_u64();
        if case.kind().needs == Needs::FastForce {
            (case.motion, case.moment, case.after_ticks) = (MOTIONS[1], Moment::Touch, case.after_ticks % 4);
        }
        if case.kind().needs == Needs::NobodysForce {
            case.hand = HANDS[0];
        }
        // a wall has no nodes, so a fault in a node needs the patch
        let nodes = matches!(
            case.kind().injection,
            Injection::Tissue(TissueFault::NodeAt(_) | TissueFault::NodeSpeed(_) | TissueFault::Denormal(_))
        );
        case.on_patch |= nodes;
        case
    }

    /// Kind of the fault that this run injects.
    pub fn kind(&self) -> &'static FaultType {
        FAULTS.get(self.fault).unwrap_or(&FAULTS[0])
    }
}
