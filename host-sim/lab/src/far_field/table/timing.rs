//! Times the ticks of one patch with every rim treatment, and those of the whole organ, in
//! alternating batches.
//!
//! Treatments that are not springs run with the code in [`crate::methods`]. Because batches are
//! short and alternate, disturbances of a shared machine affect all treatments alike, and the
//! fastest batch of each ran undisturbed.

use faer::Mat;
use palpate::method::Product;
use palpate::{Model, Params, State, Terms, Tuned, Vector3};

use super::Setting;
use crate::error::Error;
use crate::far_field::rim_method::{RimMethod, RimMethods};
use crate::methods::{DenseRim, LowRankRim, ModeRim, OnCore, RunningMethod};
use palpate_fit::statics::CLEAR_M;
use palpate_tissue::clock::thread_time;
use palpate_tissue::patch::RimSprings;
use palpate_tissue::patch::{Memory, Patch};
use palpate_tissue::stable_step::limits;

/// Depth about which the tip moves [probe radii].
const DEPTH_RADII: f64 = 0.5;
/// Displacement of the tip per tick [m], which is 20 mm/s, and during loading, which is 50 mm/s.
const STEP_M: f64 = 2e-5;
const WAY_IN_M: f64 = 5e-5;
/// Number of ticks of a batch, of which half move down and half up, and number of batches.
const BATCH_TICKS: usize = 10;
const BATCHES: usize = 25;
/// Number of ticks for which the press settles before timing starts.
const SETTLE_TICKS: usize = 40;

/// Time of a tick with each treatment, in the order of [`RimMethod::ALL`], and of a tick of the
/// whole organ [us].
#[derive(Clone, Debug)]
pub struct Times {
    by_edge: Vec<Option<f64>>,
    /// Time of a tick of the whole organ [us]; `None` if its tick failed.
    pub whole_us: Option<f64>,
}

impl Times {
    /// Time of a tick with one treatment [us]; `None` if its tick failed.
    #[must_use]
    pub fn of(&self, edge: RimMethod) -> Option<f64> {
        let at = RimMethod::ALL.iter().position(|e| *e == edge)?;
        self.by_edge.get(at).copied().flatten()
    }
}

/// The patch with the treatment's stiffness at its rim nodes included in the mass floor.
fn patch_with(setting: &Setting, edges: &RimMethods, patch: &Patch, edge: RimMethod) -> Patch {
    if edge == RimMethod::Fixed {
        let mut tissue = edges.far.cut.patch.clone();
        tissue.anchors.extend(&edges.far.cut.rim);
        tissue.anchors.sort_unstable();
        return Patch::build(&tissue, &setting.material(), None);
    }
    let mut patch = patch.clone();
    patch.set_rim(&edges.sparse(edge).unwrap_or_else(|| diagonal(&edges.far.cut.rim, &edges.far.exact_m)));
    patch
}

/// Only the blocks of single rim nodes, which is the part of a stiffness that the mass floor needs.
#[must_use]
pub fn diagonal(rim: &[u32], stiffness_m: &Mat<f64>) -> RimSprings {
    let block = |k: usize| [0, 1, 2].map(|a| [0, 1, 2].map(|b| stiffness_m[(3 * k + a, 3 * k + b)]));
    RimSprings { node: rim.to_vec(), blocks: (0..rim.len()).map(|k| ([k, k], block(k))).collect(), mended: 0 }
}

/// Creates the running method of a treatment on the core.
fn running<'a>(
    edges: &RimMethods,
    edge: RimMethod,
    params: &Params,
    model: &'a Model<'a>,
    tuned: &'a Tuned<'a>,
    state: State<'a>,
) -> Result<Option<Box<dyn RunningMethod + 'a>>, Error> {
    let rim = edges.rim();
    Ok(match edge {
        RimMethod::Modes(q) => {
            let shapes = edges.modes(q);
            let method = ModeRim::new(model, tuned, params, &rim, &shapes, &edges.far.exact_m);
            method.map(|method| Box::new(OnCore { model, tuned, state, method }) as Box<dyn RunningMethod + 'a>)
        }
        RimMethod::LowRank(q) => {
            let method = LowRankRim::new(model, tuned, params, &rim, &edges.low_rank(q)?);
            Some(Box::new(OnCore { model, tuned, state, method }))
        }
        RimMethod::Dense => {
            let method = DenseRim::new(model, tuned, params, &rim, &edges.far.exact_m);
            Some(Box::new(OnCore { model, tuned, state, method }))
        }
        _ => Some(Box::new(OnCore { model, tuned, state, method: Product })),
    })
}

/// Whether the core itself computes the forces of this rim.
fn own_rim(edge: RimMethod) -> bool {
    matches!(edge, RimMethod::Fixed | RimMethod::Winkler | RimMethod::Truncated | RimMethod::RimSprings)
}

/// Runs `work` on running patches, one for each treatment, with the whole organ last.
///
/// # Errors
/// Fails if the core rejects the model or the parameters, or if a matrix cannot be factored.
pub fn ticking<T>(
    setting: &Setting,
    edges: &RimMethods,
    patch: &Patch,
    whole: &Patch,
    work: impl FnOnce(&mut [Option<Box<dyn RunningMethod + '_>>]) -> T,
) -> Result<T, Error> {
    let mut patches: Vec<Patch> = RimMethod::ALL.iter().map(|edge| patch_with(setting, edges, patch, *edge)).collect();
    patches.push(whole.clone());
    let params: Vec<Params> = patches
        .iter_mut()
        .map(|p| {
            p.set_depth_limit_m((1.25 * setting.radius_m()) as f32);
            // modes and dense matrices act against the ground, whose stiffness the relative floor
            // leaves out
            let terms = Terms { relative_mass: false, ..setting.params.terms };
            Params { limits: limits(p, f64::from(setting.params.tick_s)), terms, ..setting.params }
        })
        .collect();
    let core_runs = |n: usize| RimMethod::ALL.get(n).is_none_or(|edge| own_rim(*edge));
    let models: Vec<Model> = patches
        .iter()
        .enumerate()
        .map(|(n, p)| match p.wide_model() {
            model if core_runs(n) => model,
            model => Model { rim_nodes: &[], rim_edges: &[], ..model },
        })
        .collect();
    let mut memories: Vec<Memory> = models.iter().map(Memory::for_model).collect();
    let (mut tuned, mut states) = (Vec::new(), Vec::new());
    for ((memory, model), params) in memories.iter_mut().zip(&models).zip(&params) {
        let (t, s) = memory.start(model, params)?;
        tuned.push(t);
        states.push(s);
    }
    let mut methods = Vec::new();
    for (n, state) in states.into_iter().enumerate() {
        let edge = RimMethod::ALL.get(n).copied().unwrap_or(RimMethod::Fixed);
        methods.push(running(edges, edge, &params[n], &models[n], &tuned[n], state)?);
    }
    Ok(work(&mut methods))
}

/// Times a tick with each treatment of a patch, and a tick of the whole organ.
///
/// # Errors
/// Errors of [`ticking`].
pub fn tick_times(setting: &Setting, edges: &RimMethods, patch: &Patch, whole: &Patch) -> Result<Times, Error> {
    let mut fastest = ticking(setting, edges, patch, whole, |methods| {
        for slot in methods.iter_mut() {
            if slot.as_mut().is_some_and(|running| !settle(setting, running.as_mut())) {
                *slot = None;
            }
        }
        let mut fastest: Vec<Option<f64>> = vec![None; methods.len()];
        for _ in 0..BATCHES {
            for (slot, fastest) in methods.iter_mut().zip(&mut fastest) {
                let us = slot.as_mut().and_then(|running| batch_us(setting, running.as_mut()));
                match us {
                    Some(us) => *fastest = Some(fastest.map_or(us, |f| f.min(us))),
                    None => (*slot, *fastest) = (None, None),
                }
            }
        }
        fastest
    })?;
    let whole_us = fastest.pop().flatten();
    Ok(Times { by_edge: fastest, whole_us })
}

fn tip_m(setting: &Setting, depth_m: f64) -> Vector3<f32> {
    setting.site_m.cast() - setting.params.probe.axis * depth_m as f32
}

fn settle(setting: &Setting, running: &mut dyn RunningMethod) -> bool {
    let depth_m = DEPTH_RADII * setting.radius_m();
    let down = ((depth_m + CLEAR_M) / WAY_IN_M).ceil() as usize;
    (0..=down + SETTLE_TICKS).all(|n| running.tick(tip_m(setting, (n as f64 * WAY_IN_M - CLEAR_M).min(depth_m))).is_ok())
}

/// Mean CPU time of a tick in one batch [us]; `None` if a tick fails.
fn batch_us(setting: &Setting, running: &mut dyn RunningMethod) -> Option<f64> {
    let depth_m = DEPTH_RADII * setting.radius_m();
    let started = thread_time();
    for n in 1..=BATCH_TICKS {
        let from_start = n.min(BATCH_TICKS - n);
        running.tick(tip_m(setting, depth_m + from_start as f64 * STEP_M)).ok()?;
    }
    Some((thread_time() - started).as_secs_f64() * 1e6 / BATCH_TICKS as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::far_field::table::graded;
    use palpate_fit::far_field::{FarField, Sizes};
    use palpate_fit::statics::Statics;
    use palpate_tissue::scene::Scene;

    /// A press that settles tick by tick, with the algorithm of each treatment, reaches the
    /// equilibrium that its matrix gives.
    #[test]
    fn ticks_of_every_treatment_settle_to_its_statics() {
        let scene = Scene::load("block").unwrap();
        let mut setting = Setting::of(&scene, 1).unwrap();
        setting.params.node_damping_per_s = 120.0;
        let tissue = graded(&scene, 130).unwrap();
        let sizes = Sizes { radius_m: 0.018, fine_m: 0.0, fine_radius_m: 0.0, growth: 0.0, stroke_m: [0.0; 3] };
        let far = FarField::of(&tissue, &sizes, &setting.material(), &setting.params).unwrap();
        let patch = Patch::build(&far.cut.patch, &setting.material(), None);
        let free = Statics::of(&patch.model(), &setting.params).unwrap();
        let edges = RimMethods::of(&far, &free, setting.radius_m()).unwrap();
        let whole = Patch::build(&tissue, &setting.material(), None);
        let depth_m = 0.003;
        let forces_n: Vec<f64> = ticking(&setting, &edges, &patch, &whole, |methods| {
            let press = |running: &mut Box<dyn RunningMethod + '_>| {
                let mut force_n = Vector3::zeros();
                for n in 0..2500 {
                    force_n = running.tick(tip_m(&setting, (5e-5 * f64::from(n) - CLEAR_M).min(depth_m))).unwrap();
                }
                f64::from(force_n.z)
            };
            methods.iter_mut().map(|r| press(r.as_mut().unwrap())).collect()
        })
        .unwrap();
        let solver = |s: &Statics| super::super::presses::solver(s).unwrap();
        let mut seen = Vec::new();
        for (edge, found) in RimMethod::ALL.into_iter().zip(forces_n) {
            // the springs and tets are those of the patch that ran
            let own = patch_with(&setting, &edges, &patch, edge);
            let free = Model { rim_nodes: &[], rim_edges: &[], ..own.model() };
            let statics = edges.statics(&Statics::of(&free, &setting.params).unwrap(), edge).unwrap();
            let balanced = Setting::forces(&statics, &solver(&statics), setting.site_m, &[depth_m])[0].unwrap();
            let wanted = balanced * f64::from(setting.params.youngs_modulus_pa);
            println!("{}: {found:.5} N, statics {wanted:.5} N", edge.name());
            assert!((found / wanted - 1.0).abs() < 5e-3, "{}: {found} N, statics {wanted} N", edge.name());
            seen.push(wanted);
        }
        let spread = seen.iter().fold(0.0, |w: f64, f| w.max((f / seen[seen.len() - 1] - 1.0).abs()));
        assert!(spread > 0.05, "the treatments must differ for this to say anything: {spread}");
    }
}
