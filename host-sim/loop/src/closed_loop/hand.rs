//! Hands that hold a device: their force and their mass.
//!
//! A hand is an impedance between its own target and the handle, the same along every axis; with H0
//! nobody holds the handle. Values of H1 and H2 are of the order that Hajian and Howe (1997)
//! measured for fingertips, with stiffness and damping rising with grip as Hasser and Cutkosky
//! (2002) report; H3 is the arm of van Beek et al. (Sci. Rep. 2015, srep18004, fig. 3); H4 is a
//! soft arm of a public course model; H5's exponential pad and its relaxation have the shape of
//! Pawluk and Howe (1999). A single mass and spring describes a finger poorly above 50 Hz; H5
//! covers that range.

use palpate::Vector3;
use palpate_tissue::finger::{FINGER, Impedance};
use serde::de::Error as _;
use serde::{Deserialize, Deserializer};

/// Grip of a hand on the handle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Grip {
    /// The handle is free: only a constant push acts, without mass or damping.
    Released,
    /// The hand is an impedance.
    Firm(Impedance),
    /// The hand is a fingertip pad, which stiffens exponentially and relaxes; it pushes and never
    /// pulls. Along the surface it acts like a light fingertip.
    Pad,
    /// Two impedances alternate.
    Changing {
        /// First half of every period.
        one: Impedance,
        /// Second half of every period.
        other: Impedance,
        /// Frequency of the alternation [Hz].
        hz: f64,
    },
}

/// A named hand.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hand {
    /// Short name, H0 .. H6.
    pub id: &'static str,
    /// Name of the hand, such as `firm fingertip`.
    pub name: &'static str,
    /// Grip of the hand on the handle.
    pub grip: Grip,
}

const LIGHT: Impedance = Impedance { mass_kg: 0.006, damping_n_s_per_m: 1.0, stiffness_n_per_m: 200.0 };
const ARM: Impedance = Impedance { mass_kg: 0.554, damping_n_s_per_m: 6.45, stiffness_n_per_m: 135.0 };
const SOFT_ARM: Impedance = Impedance { mass_kg: 0.8, damping_n_s_per_m: 5.5, stiffness_n_per_m: 30.0 };

/// Every hand. Each promise must hold with all of them.
pub const HANDS: [Hand; 7] = [
    Hand { id: "H0", name: "released", grip: Grip::Released },
    Hand { id: "H1", name: "light fingertip", grip: Grip::Firm(LIGHT) },
    Hand { id: "H2", name: "firm fingertip", grip: Grip::Firm(FINGER) },
    Hand { id: "H3", name: "arm on the handle", grip: Grip::Firm(ARM) },
    Hand { id: "H4", name: "soft arm", grip: Grip::Firm(SOFT_ARM) },
    Hand { id: "H5", name: "pad that stiffens", grip: Grip::Pad },
    Hand { id: "H6", name: "grip that changes", grip: Grip::Changing { one: LIGHT, other: FINGER, hz: 4.0 } },
];

/// Id of a known hand. [`id`] reads it by looking the name up, since serde would borrow a `&'static
/// str` from the text.
pub type Id = &'static str;

/// Reads the id of a known hand.
///
/// # Errors
/// No hand has this name.
pub fn id<'de, D: Deserializer<'de>>(from: D) -> Result<Id, D::Error> {
    let name = String::deserialize(from)?;
    Hand::named(&name).map(|known| known.id).ok_or_else(|| D::Error::custom(format!("no hand is called {name}")))
}

impl Hand {
    /// Finds the hand with this id or name.
    #[must_use]
    pub fn named(name: &str) -> Option<Self> {
        HANDS.into_iter().find(|h| h.id.eq_ignore_ascii_case(name) || h.name == name)
    }

    /// Distance of the hand's target below the handle at which it pushes with this force at rest
    /// [m].
    #[must_use]
    pub fn reach_m(&self, push_n: f64) -> f64 {
        match self.grip {
            Grip::Released => 0.0,
            Grip::Firm(i) => push_n / i.stiffness_n_per_m,
            // at rest, with its first impedance
            Grip::Changing { one, .. } => push_n / one.stiffness_n_per_m,
            Grip::Pad => {
                let elastic_n = push_n / (1.0 - RELAXING.iter().map(|r| r.0).sum::<f64>());
                let at_bone_n = PAD_FORCE_N * ((BONE_M / PAD_SCALE_M).exp() - 1.0);
                if elastic_n <= at_bone_n {
                    PAD_SCALE_M * (elastic_n / PAD_FORCE_N + 1.0).ln()
                } else {
                    BONE_M + (elastic_n - at_bone_n) / bone_n_per_m()
                }
            }
        }
    }
}

/// Exponential law of the pad: `F = F0 (exp(x / s) - 1)`.
const PAD_FORCE_N: f64 = 0.2;
const PAD_SCALE_M: f64 = 0.5e-3;
/// Beyond this compression the bone is reached, and the law continues linearly [m].
const BONE_M: f64 = 1.5e-3;
/// Largest push of a finger, whatever the compression [N].
const MOST_PAD_N: f64 = 3.0;
/// Relaxation time constant above which a share of the force counts as creep [s].
const CREEP_S: f64 = 0.5;
/// Shares of the force that relax, and their time constants [s].
const RELAXING: [(f64, f64); 3] = [(0.2, 4e-3), (0.2, 70e-3), (0.3, 1.4)];

/// Slope of the pad on the bone [N/m].
fn bone_n_per_m() -> f64 {
    PAD_FORCE_N / PAD_SCALE_M * (BONE_M / PAD_SCALE_M).exp()
}

/// Target of a hand in one tick, and its further actions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aim {
    /// Position of the target [m].
    pub at_m: Vector3<f64>,
    /// Velocity of the target [m/s].
    pub velocity_m_per_s: Vector3<f64>,
    /// Additional push [N]; it is the only force of a released hand.
    pub push_n: Vector3<f64>,
    /// Whether the hand has let go.
    pub let_go: bool,
    /// Whether the grip no longer changes or creeps, as in a hold that is evaluated.
    pub steady: bool,
}

/// A hand with its state.
#[derive(Clone, Copy, Debug)]
pub struct HandState {
    hand: Hand,
    /// Normal out of the tissue; the pad pushes in the opposite direction.
    normal: Vector3<f64>,
    /// Relaxed parts of the pad's force [N].
    relaxed_n: [f64; RELAXING.len()],
}

impl HandState {
    /// A hand that presses against `normal`.
    #[must_use]
    pub fn new(hand: Hand, normal: Vector3<f64>) -> Self {
        Self { hand, normal, relaxed_n: [0.0; RELAXING.len()] }
    }

    fn impedance(&self, aim: &Aim, t_s: f64) -> Option<Impedance> {
        match self.hand.grip {
            _ if aim.let_go => None,
            Grip::Released | Grip::Pad => None,
            Grip::Firm(i) => Some(i),
            Grip::Changing { one, other, hz } => Some(if aim.steady || (t_s * hz).fract() < 0.5 { one } else { other }),
        }
    }

    /// Mass that moves with the handle [kg].
    #[must_use]
    pub fn mass_kg(&self, aim: &Aim, t_s: f64) -> f64 {
        self.impedance(aim, t_s).map_or(0.0, |i| i.mass_kg)
    }

    /// Force on the handle [N] at a position [m] and a velocity [m/s]; relaxation advances by
    /// `dt_s`.
    pub fn force_n(
        &mut self,
        aim: &Aim,
        at_m: &Vector3<f64>,
        velocity_m_per_s: &Vector3<f64>,
        t_s: f64,
        dt_s: f64,
    ) -> Vector3<f64> {
        if aim.let_go {
            return Vector3::zeros();
        }
        let pull = |i: Impedance, d: Vector3<f64>, v: Vector3<f64>| d * i.stiffness_n_per_m + v * i.damping_n_s_per_m;
        let (apart_m, apart_m_per_s) = (aim.at_m - at_m, aim.velocity_m_per_s - velocity_m_per_s);
        if let Some(impedance) = self.impedance(aim, t_s) {
            return aim.push_n + pull(impedance, apart_m, apart_m_per_s);
        }
        if self.hand.grip != Grip::Pad {
            return aim.push_n;
        }
        let squeezed_m = -apart_m.dot(&self.normal);
        let pad_n = self.pad_n(squeezed_m, dt_s, aim.steady);
        let closing = if squeezed_m > 0.0 { -apart_m_per_s.dot(&self.normal) * LIGHT.damping_n_s_per_m } else { 0.0 };
        let along = |v: Vector3<f64>| v - self.normal * v.dot(&self.normal);
        aim.push_n - self.normal * (pad_n + closing).max(0.0) + pull(LIGHT, along(apart_m), along(apart_m_per_s))
    }

    /// Force of the pad [N] at this compression.
    fn pad_n(&mut self, squeezed_m: f64, dt_s: f64, steady: bool) -> f64 {
        let soft_m = squeezed_m.clamp(0.0, BONE_M);
        // the exponential is skipped where the pad is not compressed
        let stiffened = if soft_m > 0.0 { (soft_m / PAD_SCALE_M).exp() - 1.0 } else { 0.0 };
        let elastic_n = PAD_FORCE_N * stiffened + (squeezed_m - BONE_M).max(0.0) * bone_n_per_m();
        let elastic_n = elastic_n.min(MOST_PAD_N / (1.0 - RELAXING.iter().map(|r| r.0).sum::<f64>()));
        let mut force_n = elastic_n;
        for (relaxed_n, (share, time_s)) in self.relaxed_n.iter_mut().zip(RELAXING) {
            if !(steady && time_s > CREEP_S) {
                *relaxed_n += (share * elastic_n - *relaxed_n) * (dt_s / time_s).min(1.0);
            }
            force_n -= *relaxed_n;
        }
        force_n.clamp(0.0, MOST_PAD_N)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rest_force_n(hand: Hand, push_n: f64) -> f64 {
        let normal = Vector3::new(0.0, 0.6, 0.8);
        let mut state = HandState::new(hand, normal);
        let aim = Aim {
            at_m: normal * -hand.reach_m(push_n),
            velocity_m_per_s: Vector3::zeros(),
            push_n: Vector3::zeros(),
            let_go: false,
            steady: false,
        };
        let at_rest = |state: &mut HandState| state.force_n(&aim, &Vector3::zeros(), &Vector3::zeros(), 0.0, 1e-4);
        let force_n = (0..200_000).map(|_| at_rest(&mut state)).last().unwrap_or_default();
        assert!(force_n.cross(&normal).norm() < 1e-12);
        -force_n.dot(&normal)
    }

    #[test]
    fn every_hand_that_holds_pushes_at_rest_with_what_it_reached_for() {
        for hand in &HANDS[1..] {
            for push_n in [0.1, 0.5, 1.4] {
                let found_n = rest_force_n(*hand, push_n);
                assert!((found_n / push_n - 1.0).abs() < 1e-6, "{}: {found_n} N for {push_n} N", hand.id);
            }
        }
    }

    #[test]
    fn a_hand_that_let_go_is_not_there() {
        let aim = Aim { at_m: Vector3::x(), velocity_m_per_s: Vector3::x(), push_n: Vector3::x(), let_go: true, steady: false };
        for hand in HANDS {
            let mut state = HandState::new(hand, Vector3::z());
            assert_eq!(state.force_n(&aim, &Vector3::zeros(), &Vector3::zeros(), 0.0, 1e-5), Vector3::zeros());
            assert_eq!(state.mass_kg(&aim, 0.0), 0.0);
        }
    }
}
