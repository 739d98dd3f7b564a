//! Tissue that relaxes under a slow probe: finite elements without inertia.
//!
//! The force of the tissue on each node is the elastic force minus shares of what it was:
//!
//! ```text
//! R = R_e - sum g h,  h' = (R_e - h) / tau
//! ```
//! Over a step in which `R_e` changes linearly, h is known exactly. Each step is the minimum of a
//! potential: a share of the elastic energy, and the work of forces that are known. Nothing is
//! shared with the real-time core.

use nalgebra::Vector3;
use palpate::PronyTerm;
use palpate_fit::reference::body::{Assembled, Body, Contact};
use palpate_fit::reference::minimise::{Minimiser, Potential};
use palpate_fit::reference::probe::RigidProbe;
use palpate_tissue::moving::Table;
use palpate_tissue::moving::table::Row;
use palpate_tissue::scene::Scene;

use super::error::DynamicError;
use super::motion::Motion;
use super::piece::Piece;
use super::settings::Settings;

/// Lower limit of the force with which residuals are compared, over the square of the radius (1).
const LEAST_FORCE: f64 = 1e-3;
/// Depth, over the radius, below which the penalty stiffness is constant (1).
const LEAST_DEPTH: f64 = 1e-2;

/// Remains of former forces on every node, for one term.
struct Fade {
    share: f64,
    time_s: f64,
    h_m2: Vec<Vector3<f64>>,
}

impl Fade {
    /// Factors of the former h, of the former and of the new elastic force after a step.
    fn factors(&self, step_s: f64) -> [f64; 3] {
        let x = step_s / self.time_s;
        let a = (-x).exp();
        let mean = -(-x).exp_m1() / x;
        [a, mean - a, 1.0 - mean]
    }
}

/// A share of the elastic energy, and known forces.
struct Fading<'a> {
    body: &'a Body,
    contact: &'a Contact,
    share: f64,
    known_m2: &'a [Vector3<f64>],
    least_force_m2: f64,
}

impl Fading<'_> {
    fn work_m3(&self, displacement_m: &[Vector3<f64>]) -> f64 {
        self.known_m2.iter().zip(displacement_m).map(|(f, u)| f.dot(u)).sum()
    }
}

impl Potential for Fading<'_> {
    fn body(&self) -> &Body {
        self.body
    }

    fn contact(&self) -> Option<&Contact> {
        Some(self.contact)
    }

    fn energy(&self, displacement_m: &[Vector3<f64>]) -> Option<f64> {
        Some(self.share * self.body.energy(displacement_m, None)? + self.work_m3(displacement_m))
    }

    fn assemble(&self, displacement_m: &[Vector3<f64>], tangent: bool) -> Option<Assembled> {
        let mut sum = self.body.derive(displacement_m, tangent)?;
        sum.energy_m3 = self.share * sum.energy_m3 + self.work_m3(displacement_m);
        for (residual, known) in sum.residual_m2.iter_mut().zip(self.known_m2) {
            *residual = *residual * self.share + known;
        }
        sum.tangent.iter_mut().for_each(|value| *value *= self.share);
        Some(sum)
    }

    fn force_m2(&self, displacement_m: &[Vector3<f64>], _: &Assembled) -> f64 {
        let contact = self.body.touch(displacement_m, self.contact).force_m2.norm();
        (contact / self.body.copies).max(self.least_force_m2)
    }
}

/// Computes the force on a probe that performs `motion` slowly in tissue that relaxes.
pub fn compute(scene: &Scene, motion: &Motion, settings: &Settings) -> Result<Table, DynamicError> {
    motion.check()?;
    settings.check()?;
    let piece = Piece::of(scene, motion, settings)?;
    let body = &piece.body;
    let rest = vec![Vector3::zeros(); body.mesh.nodes_m.len()];
    let mut solver = Minimiser::new(body).ok_or(DynamicError::Memory { nodes: rest.len() })?;
    let terms = scene.tissue.relaxation().into_iter().filter(|term| *term != PronyTerm::NONE);
    let mut fades: Vec<Fade> =
        terms.map(|term| Fade { share: term.share.into(), time_s: term.time_s.into(), h_m2: rest.clone() }).collect();
    let (mut displacement_m, mut elastic_m2) = (rest.clone(), rest);
    let radius_m = scene.probe.radius_m;
    let row = |t_s: f64, normal_m2: f64| {
        let pose = motion.pose(t_s);
        Row { t_s, depth_m: pose.depth_m, across_m: pose.across_m[0], force_over_e_m2: [0.0, 0.0, normal_m2] }
    };
    let mut rows = vec![row(0.0, 0.0)];
    for ends in motion.kinks_s().windows(2) {
        let mut t_s = ends[0];
        for step_s in settings.steps_s(ends[1] - ends[0]) {
            t_s += step_s;
            let pose = motion.pose(t_s);
            let softness_m = settings.softness * (radius_m * pose.depth_m.max(LEAST_DEPTH * radius_m)).sqrt();
            let probe = RigidProbe::new(scene.probe.shape, radius_m, piece.tip_m(&pose), piece.axis);
            let contact = Contact { probe, penalty_per_m: 1.0 / softness_m };
            let mut share = 1.0;
            let mut known_m2 = vec![Vector3::zeros(); elastic_m2.len()];
            for fade in &fades {
                let [a, before, now] = fade.factors(step_s);
                share -= fade.share * now;
                for ((known, h), elastic) in known_m2.iter_mut().zip(&fade.h_m2).zip(&elastic_m2) {
                    *known -= (h * a + elastic * before) * fade.share;
                }
            }
            let least_force_m2 = LEAST_FORCE * radius_m * radius_m;
            let potential = Fading { body, contact: &contact, share, known_m2: &known_m2, least_force_m2 };
            if !solver.relax(&potential, &mut displacement_m, settings.tolerance) {
                return Err(DynamicError::Stalled { t_s: t_s - step_s, depth_m: pose.depth_m });
            }
            let stalled = DynamicError::Stalled { t_s, depth_m: pose.depth_m };
            let now_m2 = body.derive(&displacement_m, false).ok_or(stalled)?.residual_m2;
            for fade in &mut fades {
                let [a, before, now] = fade.factors(step_s);
                for ((h, old), new) in fade.h_m2.iter_mut().zip(&elastic_m2).zip(&now_m2) {
                    *h = *h * a + old * before + new * now;
                }
            }
            elastic_m2 = now_m2;
            rows.push(row(t_s, body.touch(&displacement_m, &contact).force_m2.dot(&piece.axis)));
        }
    }
    Ok(Table { rows })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_force_that_stays_fades_as_the_exponential() {
        let mut fade = Fade { share: 0.5, time_s: 0.3, h_m2: Vec::new() };
        fade.h_m2.push(Vector3::zeros());
        let mut h = 0.0;
        for step_s in [0.01, 0.2, 0.05] {
            let [a, before, now] = fade.factors(step_s);
            h = h * a + before + now;
        }
        assert!((h + (-0.26_f64 / 0.3).exp_m1()).abs() < 1e-12, "{h}");
        // of a force that rises evenly from zero, tau behind
        let [_, _, now] = fade.factors(3.0);
        assert!((3.0 * now - (3.0 + 0.3 * (-10.0_f64).exp_m1())).abs() < 1e-9, "{now}");
    }
}
