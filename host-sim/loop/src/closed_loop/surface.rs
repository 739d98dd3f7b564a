//! Surfaces to touch: a wall of one stiffness, or the product's patch.

mod untouched;

use std::sync::Arc;

use palpate::haptic::cycle::Renderer;
use palpate::haptic::press::{self, Press};
use palpate::stages::probe::ProbePose;
use palpate::{
    BuildError, ClampFlags, GuardLimits, Model, Output, Params, RimEdge, RimNode, State, Tuned, Vector3, tick, tick_with,
};
use untouched::Untouched;

use super::stimulus::{Change, Site};
use super::watch::{HalfSpace, RestShape, RestSolid};
use palpate_tissue::patch::{Memory, Patch};

/// A surface that exerts a force at a site, and whose stiffness can change.
pub trait Surface: Renderer {
    /// Site of the press.
    fn site(&self) -> Site;

    /// Geometry at rest, for the watch.
    fn rest_shape(&self) -> Arc<dyn RestShape>;

    /// Whether it sinks under a steady push, as tissue that relaxes does.
    fn creeps(&self) -> bool;

    /// Requests a change. Softening applies at once; stiffening waits until [`Surface::settle`]
    /// reports no contact, since under the probe it would create energy.
    fn change(&mut self, change: Change);

    /// Ends a tick, in contact or not; a change that waits is applied outside contact.
    fn settle(&mut self, in_contact: bool);

    /// Sets the coordinates of one node, or of all nodes, to this value on every axis [m], or their
    /// velocity to this value on every axis [m/s]; a surface without nodes is unchanged.
    fn strike(&mut self, _at_m: Option<f32>, _speed_m_per_s: Option<f32>, _all: bool) {}

    /// Returns the defect of the surface's state, if any: not finite, or impossibly far away.
    fn unsound(&self) -> Option<&'static str> {
        None
    }
}

/// A spring below a plane: the simplest surface.
#[derive(Clone, Copy, Debug)]
pub struct Wall {
    n_per_m: f32,
    /// Largest depth at which the surface still responds, as with a patch's guard [m].
    depth_limit_m: f32,
    ratio: f32,
    wanted: f32,
    normal: Vector3<f32>,
}

impl Wall {
    /// Creates a wall of this stiffness [N/m] below the plane through the origin with this outward
    /// normal. Like a patch, it has a guard: the depth is limited to that at which the force is
    /// 1.09 times the largest permitted.
    #[must_use]
    pub fn new(n_per_m: f64, max_force_n: f64, normal: Vector3<f32>) -> Self {
        let depth_limit_m = (1.09 * max_force_n / n_per_m) as f32;
        Self { n_per_m: n_per_m as f32, depth_limit_m, ratio: 1.0, wanted: 1.0, normal }
    }
}

impl Renderer for Wall {
    fn render(&mut self, pose: ProbePose) -> Output {
        let depth_m = -pose.tip_m.dot(&self.normal);
        if depth_m <= 0.0 {
            return Output { point_m: pose.tip_m, outside: true, ..Output::NONE };
        }
        let mut limiters = ClampFlags::DEFAULT;
        let apart_m = (depth_m - self.depth_limit_m).max(0.0);
        if apart_m > 0.0 {
            limiters.set(ClampFlags::DEPTH);
        }
        let depth_m = depth_m - apart_m;
        let force_n = self.normal * (self.n_per_m * self.ratio * depth_m);
        Output { force_n, depth_m, normal: self.normal, point_m: pose.tip_m, apart_m, limiters, ..Output::NONE }
    }

    fn reset(&mut self) {}

    fn tangent_n_per_m(&self, output: &Output) -> f32 {
        if output.depth_m > 0.0 { self.n_per_m * self.ratio } else { 0.0 }
    }
}

impl Surface for Wall {
    fn site(&self) -> Site {
        Site::new(Vector3::zeros(), self.normal.cast())
    }

    fn rest_shape(&self) -> Arc<dyn RestShape> {
        Arc::new(HalfSpace { at_m: Vector3::zeros(), normal: self.normal.cast() })
    }

    fn creeps(&self) -> bool {
        false
    }

    fn change(&mut self, change: Change) {
        let (Change::Stiffness(ratio) | Change::FarField(ratio)) = change;
        self.wanted = ratio as f32;
    }

    fn settle(&mut self, in_contact: bool) {
        if self.wanted < self.ratio || !in_contact {
            self.ratio = self.wanted;
        }
    }
}

/// Stiffness and far field, as multiples of the initial ones.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Variant {
    stiffness: f64,
    far_field: f64,
}

const VARIANTS: [Variant; 5] = [
    Variant { stiffness: 1.0, far_field: 1.0 },
    Variant { stiffness: 2.0, far_field: 1.0 },
    Variant { stiffness: 0.5, far_field: 1.0 },
    Variant { stiffness: 1.0, far_field: 2.0 },
    Variant { stiffness: 1.0, far_field: 0.5 },
];

/// The product's patch in the loop.
#[derive(Debug)]
pub struct TissueSurface<'a> {
    variants: Vec<(Model<'a>, Tuned<'a>)>,
    /// Tangent stiffness of the contact at the depth limit, per pascal of Young's modulus [m].
    tangent_m: f32,
    state: State<'a>,
    untouched: Untouched,
    at: usize,
    wanted: usize,
    site: Site,
    shape: Arc<RestSolid>,
}

/// Lends a patch as a surface to `work`.
///
/// # Errors
/// Propagates errors from [`Params::build`].
pub fn with_tissue<T>(patch: &Patch, params: &Params, work: impl FnOnce(&mut TissueSurface) -> T) -> Result<T, BuildError> {
    let model = patch.wide_model();
    let rims: Vec<(Vec<RimNode>, Vec<RimEdge>)> = VARIANTS.iter().map(|v| scaled_rim(&model, v.far_field as f32)).collect();
    let models: Vec<Model> = rims.iter().map(|(rim_nodes, rim_edges)| Model { rim_nodes, rim_edges, ..model }).collect();
    let mut memories: Vec<Memory> = models.iter().map(Memory::for_model).collect();
    let (mut variants, mut states) = (Vec::new(), Vec::new());
    for ((variant, model), memory) in VARIANTS.iter().zip(&models).zip(&mut memories) {
        // without a far field, another organ means tissue of another stiffness
        let stiffness = if model.rim_nodes.is_empty() { variant.stiffness * variant.far_field } else { variant.stiffness };
        let params = Params { youngs_modulus_pa: params.youngs_modulus_pa * stiffness as f32, ..*params };
        let (tuned, state) = memory.start(model, &params)?;
        variants.push((*model, tuned));
        states.push(state);
    }
    let state = states.swap_remove(0);
    let site = Site::new(patch.touch_m(params).cast(), params.probe.axis.cast());
    let shape = Arc::new(RestSolid::of(&model, &params.turned_probe()));
    let tangent_m = tangent_m(patch, params)?;
    let mut surface =
        TissueSurface { variants, tangent_m, state, untouched: Untouched::default(), at: 0, wanted: 0, site, shape };
    surface.reset();
    Ok(work(&mut surface))
}

impl TissueSurface<'_> {
    /// Nodes of the patch, in the model's order.
    #[must_use]
    pub fn nodes(&self) -> &[palpate::Node] {
        self.state.nodes()
    }
}

fn scaled_rim(model: &Model, ratio: f32) -> (Vec<RimNode>, Vec<RimEdge>) {
    let nodes = model.rim_nodes.iter().map(|r| RimNode { block_m: r.block_m.map(|b| b * ratio), ..*r });
    let edges = model.rim_edges.iter().map(|r| RimEdge { block_m: r.block_m.map(|b| b * ratio), ..*r });
    (nodes.collect(), edges.collect())
}

impl Renderer for TissueSurface<'_> {
    fn render(&mut self, pose: ProbePose) -> Output {
        let Some((model, tuned)) = self.variants.get(self.at) else { return Output::NONE };
        tick_with(model, tuned, &mut self.state, pose, &mut self.untouched)
    }

    fn reset(&mut self) {
        let Some((model, tuned)) = self.variants.get(self.at) else { return };
        self.state.reset(model);
        match self.at {
            0 => self.untouched.reset(tuned),
            // the recorded motion is that of the initial tissue
            _ => self.untouched.disturb(),
        }
    }

    /// That of the initial far field: another organ around a patch changes it little.
    fn stiffness_n_per_m(&self) -> f32 {
        self.variants.get(self.at).map_or(0.0, |(_, tuned)| self.tangent_m * tuned.youngs_modulus_pa())
    }
}

impl Surface for TissueSurface<'_> {
    fn site(&self) -> Site {
        self.site
    }

    fn rest_shape(&self) -> Arc<dyn RestShape> {
        Arc::<RestSolid>::clone(&self.shape)
    }

    fn creeps(&self) -> bool {
        self.variants.iter().any(|(_, tuned)| tuned.relaxes())
    }

    fn change(&mut self, change: Change) {
        let variant = match change {
            Change::Stiffness(stiffness) => Variant { stiffness, far_field: 1.0 },
            Change::FarField(far_field) => Variant { stiffness: 1.0, far_field },
        };
        self.wanted = VARIANTS.iter().position(|v| *v == variant).unwrap_or(self.wanted);
    }

    fn settle(&mut self, in_contact: bool) {
        let stiffness = |n: usize| VARIANTS.get(n).map_or(1.0, |v| v.stiffness * v.far_field);
        if !in_contact || stiffness(self.wanted) < stiffness(self.at) {
            if self.at != self.wanted {
                self.untouched.disturb();
            }
            self.at = self.wanted;
        }
    }

    fn strike(&mut self, at_m: Option<f32>, speed_m_per_s: Option<f32>, all: bool) {
        let Some((model, _)) = self.variants.first() else { return };
        let far = |n: &usize| model.nodes.get(*n).map_or(f64::MAX, |r| (Vector3::from(r.rest_m).cast() - self.site.at_m).norm());
        // the node nearest to the site: it is free, and under the probe
        let count = self.state.nodes().len();
        let nearest = (0..count).min_by(|a, b| far(a).total_cmp(&far(b))).unwrap_or_default();
        let struck = if all { 0..count } else { nearest..nearest + 1 };
        self.untouched.disturb();
        for n in struck {
            let Some(node) = self.state.nodes().get(n) else { return };
            let place_m = at_m.map_or(node.position_m(), Vector3::repeat);
            let speed = speed_m_per_s.map_or(node.velocity_m_per_s(), Vector3::repeat);
            self.state.place(n, place_m, speed);
        }
    }

    fn unsound(&self) -> Option<&'static str> {
        let (model, _) = self.variants.first()?;
        let (mut low, mut high) = (Vector3::repeat(f32::MAX), Vector3::repeat(f32::MIN));
        for rest in model.nodes {
            let x = Vector3::from(rest.rest_m);
            (low, high) = (low.inf(&x), high.sup(&x));
        }
        let margin = (high - low) * 1.5;
        let inside = |x: Vector3<f32>| x >= low - margin && x <= high + margin;
        let sound =
            self.state.nodes().iter().all(|n| n.velocity_m_per_s().iter().all(|v| v.is_finite()) && inside(n.position_m()));
        (!sound).then_some("a node is not finite or outside four times the patch")
    }
}

/// Static curve of a press: (depth [m], force along the normal [N]) up to the patch's depth limit,
/// in steps of 0.25 mm, each held until the patch is at rest.
///
/// # Errors
/// Propagates errors from [`Params::build`].
pub fn static_curve(patch: &Patch, params: &Params) -> Result<Vec<(f64, f64)>, BuildError> {
    let model = patch.wide_model();
    let params = Params { limits: GuardLimits { max_force_n: GuardLimits::HIGHEST.max_force_n, ..params.limits }, ..*params };
    let mut memory = Memory::for_model(&model);
    let (tuned, mut state) = memory.start(&model, &params)?;
    let (axis, touch_m) = (params.probe.axis, patch.touch_m(&params));
    let mut press = |depth_m: f32| tick(&model, &tuned, &mut state, ProbePose { tip_m: touch_m - axis * depth_m });
    let (step_m, ticks) = (0.25e-3_f32, 60);
    press(-step_m);
    let steps = (model.depth_limit_m / step_m).floor() as u16;
    let mut curve = vec![(0.0, 0.0)];
    for n in 1..=steps {
        let depth_m = step_m * f32::from(n);
        // half of the time moving, half at rest
        for k in 1..=ticks {
            press(depth_m - step_m * (1.0 - (f32::from(k) / f32::from(ticks / 2_u16)).min(1.0)));
        }
        curve.push((f64::from(depth_m), f64::from(press(depth_m).force_n.dot(&axis))));
    }
    Ok(curve)
}

/// Tangent stiffness of the contact at the patch's depth limit, per pascal of Young's modulus [m];
/// zero for a patch that diverges under the press, which the loop then finds itself.
///
/// # Errors
/// Propagates errors from [`Params::build`].
pub fn tangent_m(patch: &Patch, params: &Params) -> Result<f32, BuildError> {
    let model = patch.wide_model();
    let mut memory = Memory::for_model(&model);
    let (mut tuned, mut state) = memory.start(&model, params)?;
    let press = Press { radius_m: params.probe.radius_m, depth_m: model.depth_limit_m };
    Ok(press::tangent_m(&model, &mut tuned, &mut state, patch.touch_m(params), press, &mut || {}).unwrap_or(0.0))
}

/// Depth at which a curve reaches a force [m]; the last depth if it never does.
#[must_use]
pub fn depth_at_m(curve: &[(f64, f64)], force_n: f64) -> f64 {
    let between = curve.windows(2).find(|w| w[1].1 >= force_n).map(|w| {
        let share = (force_n - w[0].1) / (w[1].1 - w[0].1);
        w[0].0 + share * (w[1].0 - w[0].0)
    });
    between.or(curve.last().map(|c| c.0)).unwrap_or(0.0)
}

/// Force of a curve at a depth [N].
#[must_use]
pub fn force_at_n(curve: &[(f64, f64)], depth_m: f64) -> f64 {
    let between = curve.windows(2).find(|w| w[1].0 >= depth_m).map(|w| {
        let share = (depth_m - w[0].0) / (w[1].0 - w[0].0);
        w[0].1 + share * (w[1].1 - w[0].1)
    });
    between.or(curve.last().map(|c| c.1)).unwrap_or(0.0)
}
