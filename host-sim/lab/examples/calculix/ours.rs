//! Runs the presses of the decks with our own finite elements and with the shipped patch of 410
//! nodes.

use nalgebra::Vector3;
use palpate::stages::probe::ProbePose;
use palpate::{MOST_TERMS, Model, Params, PronyTerm, State, Tuned};
use palpate_fit::reference::newton::Press;
use palpate_fit::reference::probe::RigidProbe;
use palpate_tissue::patch::{Memory, Patch};
use palpate_tissue::scene::Shape;
use palpate_tissue::session::calibrated;
use palpate_tissue::stable_step::limits;

use super::Failure;
use super::deck::{self, DEPTHS_MM, DRAG_DEPTH_MM, DRAGS_MM, FRICTION, HOLDS_S, MODULUS_KPA, RADIUS_MM, TERMS};

const NODES: usize = 410;
/// Number of ticks that the probe rests before a force is read.
const RESTED: usize = 1000;
/// Number of ticks per millimetre of a press, of a drag, and of the press before a hold.
const PRESS: f64 = 50.0;
const DRAG: f64 = 500.0;
const QUICK: f64 = 10.0;

/// Forces [mN] of frictionless presses by finite elements, on the mesh of a deck.
pub fn elements_mn(nodes: usize, poisson_ratio: f64, depths_mm: &[f64]) -> Result<Vec<f64>, Failure> {
    let block = deck::block(nodes, [true; 2], poisson_ratio)?;
    let probe = RigidProbe::new(Shape::Sphere, RADIUS_MM * 1e-3, block.place_m, Vector3::z());
    let mut press = Press::new(&block.body, probe, block.place_m).ok_or("not enough memory for our finite elements")?;
    let mut force_mn = |depth_mm: &f64| {
        let stalled = press.go_to(depth_mm * 1e-3, |_| ());
        stalled.map_err(|at| format!("our finite elements stop at {:.2} mm", at.reached_m * 1e3))?;
        // 1 kPa m^2 is a million millinewtons
        Ok(press.force_over_e_m2() * MODULUS_KPA * 1e6)
    };
    depths_mm.iter().map(&mut force_mn).collect()
}

/// Share of the force that remains at each time of a hold (1), as solved by finite elements. Only
/// their shear modulus has relaxed, and its value at that time is used from the start.
pub fn elements_left() -> Result<Vec<f64>, Failure> {
    let depth_mm = [DRAG_DEPTH_MM];
    let at_once = elements_mn(deck::NODES[2], deck::POISSON_RATIO, &depth_mm)?[0];
    let later = |t_s: &f64| {
        let left = left(*t_s);
        let nu = deck::POISSON_RATIO;
        // bulk modulus divided by the shear modulus at that time
        let bulk = 2.0 * (1.0 + nu) / (3.0 * (1.0 - 2.0 * nu)) / left;
        let later = (3.0 * bulk - 2.0) / (2.0 * (3.0 * bulk + 1.0));
        let modulus = left * (1.0 + later) / (1.0 + nu);
        Ok(elements_mn(deck::NODES[2], later, &depth_mm)?[0] * modulus / at_once)
    };
    HOLDS_S.iter().map(later).collect()
}

/// Remaining share of the shear modulus after `t_s` (1).
pub fn left(t_s: f64) -> f64 {
    TERMS.iter().fold(1.0, |left, [share, time_s]| left - share * (1.0 - (-t_s / time_s).exp()))
}

/// The patch under a probe that is moved tick by tick.
struct Run<'a> {
    model: &'a Model<'a>,
    tuned: Tuned<'a>,
    state: State<'a>,
}

impl Run<'_> {
    /// Runs one tick with the tip at `tip_mm` and returns the force on the probe [mN].
    fn at(&mut self, tip_mm: Vector3<f64>) -> Result<Vector3<f64>, Failure> {
        let output = palpate::tick(self.model, &self.tuned, &mut self.state, ProbePose { tip_m: (tip_mm * 1e-3).cast() });
        match output.fault {
            None => Ok(output.force_n.cast::<f64>() * 1e3),
            Some(fault) => Err(format!("the patch stops: {fault}")),
        }
    }

    /// Moves straight to a place, rests there for `rest` ticks, and returns the last force [mN].
    fn go(
        &mut self,
        from_mm: Vector3<f64>,
        to_mm: Vector3<f64>,
        ticks_per_mm: f64,
        rest: usize,
    ) -> Result<Vector3<f64>, Failure> {
        let ticks = ((to_mm - from_mm).norm() * ticks_per_mm).round().max(1.0) as usize;
        for n in 1..ticks {
            self.at(from_mm + (to_mm - from_mm) * (n as f64 / ticks as f64))?;
        }
        let mut force_mn = self.at(to_mm)?;
        for _ in 0..rest {
            force_mn = self.at(to_mm)?;
        }
        Ok(force_mn)
    }
}

/// The shipped patch of 410 nodes.
pub struct Shipped {
    patch: Patch,
    params: Params,
}

impl Shipped {
    pub fn new() -> Result<Self, Failure> {
        let (patch, packed) = calibrated::sized(NODES).ok_or_else(|| format!("no patch of {NODES} nodes ships"))?;
        let youngs_modulus_pa = MODULUS_KPA as f32 * 1e3;
        let params = Params { limits: limits(&patch, f64::from(packed.tick_s)), substeps: 1, youngs_modulus_pa, ..packed };
        Ok(Self { patch, params })
    }

    fn run<T>(&self, params: &Params, go: impl FnOnce(&mut Run) -> Result<T, Failure>) -> Result<T, Failure> {
        let model = self.patch.wide_model();
        let mut memory = Memory::for_model(&model);
        let (tuned, state) = memory.start(&model, params).map_err(|cause| format!("the patch: {cause}"))?;
        go(&mut Run { model: &model, tuned, state })
    }

    /// Forces of frictionless presses [mN].
    pub fn presses_mn(&self) -> Result<Vec<f64>, Failure> {
        self.run(&self.params, |run| {
            let mut before = Vector3::z();
            let press = |depth_mm: &f64| {
                let to = Vector3::z() * -depth_mm;
                Ok(run.go(std::mem::replace(&mut before, to), to, PRESS, RESTED)?.z)
            };
            DEPTHS_MM.iter().map(press).collect()
        })
    }

    /// Forces [mN] opposite to the drag and upward, before the drag and at each of its lengths: the
    /// mean over four headings, since the mesh is not isotropic.
    pub fn drags_mn(&self) -> Result<Vec<[f64; 2]>, Failure> {
        let params = Params { friction: FRICTION as f32, ..self.params };
        let mut mean = vec![[0.0; 2]; DRAGS_MM.len() + 1];
        for heading in [Vector3::x(), Vector3::y(), -Vector3::x(), -Vector3::y()] {
            self.run(&params, |run| {
                let deep = Vector3::z() * -DRAG_DEPTH_MM;
                let mut force_mn = run.go(Vector3::z(), deep, PRESS, RESTED)?;
                let mut before = deep;
                for (n, sum) in mean.iter_mut().enumerate() {
                    if n > 0 {
                        let to = deep + heading * DRAGS_MM[n - 1];
                        force_mn = run.go(before, to, DRAG, RESTED)?;
                        before = to;
                    }
                    sum[0] -= 0.25 * force_mn.dot(&heading);
                    sum[1] += 0.25 * force_mn.z;
                }
                Ok(())
            })?;
        }
        Ok(mean)
    }

    /// Remaining shares of the force of a hold after a press with friction (1).
    pub fn left(&self) -> Result<Vec<f64>, Failure> {
        let mut relaxation = [PronyTerm::NONE; MOST_TERMS];
        for (term, [share, time_s]) in relaxation.iter_mut().zip(TERMS) {
            *term = PronyTerm { share: share as f32, time_s: time_s as f32 };
        }
        let rough = Params { friction: FRICTION as f32, ..self.params };
        let deep = Vector3::z() * -DRAG_DEPTH_MM;
        let tick_s = f64::from(self.params.tick_s);
        let held = |params: &Params| {
            self.run(params, |run| {
                let mut before_s = 0.0;
                run.go(Vector3::z(), deep, QUICK, 0)?;
                let hold = |t_s: &f64| {
                    let ticks = ((t_s - before_s) / tick_s).round() as usize;
                    before_s = *t_s;
                    Ok(run.go(deep, deep, QUICK, ticks - 1)?.z)
                };
                HOLDS_S.iter().map(hold).collect::<Result<Vec<f64>, Failure>>()
            })
        };
        let (elastic, relaxed) = (held(&rough)?, held(&Params { relaxation, ..rough })?);
        Ok(relaxed.iter().zip(elastic).map(|(now, once)| now / once).collect())
    }
}
