//! Motion of a patch that nothing has touched since its reset.
//!
//! This motion depends on the number of substeps only: rounding and gravity move the nodes
//! identically after every reset. It is computed once and copied afterwards, bit for bit. A
//! campaign resets its patch before each run, and many of its ticks come before the first touch.

use palpate::method::{Method, Product};
use palpate::stages::force::foundation::{self, Load};
use palpate::{Fault, Model, State, Tuned, Vector3};

/// Largest number of substeps that is stored, enough for arming and the slowest approach.
const KEPT: usize = 2048;

/// State of the nodes after a substep.
#[derive(Debug)]
struct Moved {
    /// Number of free nodes that moved.
    active: u16,
    /// Position [m] and velocity [m/s] of each node.
    nodes: Vec<[Vector3<f32>; 2]>,
}

/// Records the substeps of an untouched patch, and replays them after the next reset.
#[derive(Debug, Default)]
pub(super) struct Untouched {
    known: Vec<Moved>,
    /// Substeps since the reset, while nothing has touched the patch.
    substeps: Option<usize>,
}

impl Untouched {
    /// Starts again with a patch at rest. Tissue that relaxes is not replayed, since its relaxation
    /// state is not stored.
    pub(super) fn reset(&mut self, tuned: &Tuned) {
        self.substeps = (!tuned.relaxes()).then_some(0);
    }

    /// Notes that nodes were moved or the tissue was changed: until the next reset every substep is
    /// computed.
    pub(super) fn disturb(&mut self) {
        self.substeps = None;
    }

    /// The recorded nodes after the next substep, if there are any and nothing has touched the
    /// patch.
    fn next(&self) -> Option<&Moved> {
        self.known.get(self.substeps?)
    }
}

impl Method for Untouched {
    fn force(&mut self, model: &Model, tuned: &Tuned, state: &mut State, tip_m: Vector3<f32>, m_per_s: Vector3<f32>) -> Load {
        if self.next().is_some() {
            // this changes no node unless a point of the surface is inside the probe; in that case
            // the surface is pressed again below
            let load = foundation::press(model, tuned, state, tip_m, m_per_s);
            if load.strongest.0 == 0.0 {
                return load;
            }
            self.disturb();
        }
        let load = Product.force(model, tuned, state, tip_m, m_per_s);
        if load.strongest.0 != 0.0 {
            self.disturb();
        }
        load
    }

    fn advance(&mut self, model: &Model, tuned: &Tuned, state: &mut State) -> Result<u16, Fault> {
        let Some(substep) = self.substeps else { return Product.advance(model, tuned, state) };
        self.substeps = Some(substep + 1);
        if let Some(moved) = self.known.get(substep) {
            for (n, [position_m, velocity_m_per_s]) in moved.nodes.iter().enumerate() {
                state.place(n, *position_m, *velocity_m_per_s);
            }
            return Ok(moved.active);
        }
        let active = Product.advance(model, tuned, state)?;
        if substep == self.known.len() && substep < KEPT {
            let nodes = state.nodes().iter().map(|n| [n.position_m(), n.velocity_m_per_s()]).collect();
            self.known.push(Moved { active, nodes });
        }
        Ok(active)
    }
}

#[cfg(test)]
mod tests {
    use palpate::haptic::cycle::Renderer;
    use palpate::stages::probe::ProbePose;
    use palpate::{Output, Params, tick};
    use palpate_tissue::patch::{Memory, Patch};

    use crate::closed_loop::surface::{Surface, TissueSurface, with_tissue};

    /// Depth of the tip in each tick [m]: above the surface for `above` ticks, then to 3 mm at 0.1
    /// m/s and out again.
    fn depths_m(above: u16) -> impl Iterator<Item = f32> {
        let press = (0..70).map(|n: u16| 1e-4 * f32::from(n.min(70 - n)) - 5e-4);
        std::iter::repeat_n(-5e-4, above.into()).chain(press)
    }

    /// Outputs and state hashes of the tick without recording or replay.
    fn plain(patch: &Patch, params: &Params, above: u16) -> Vec<(Output, u64)> {
        let model = patch.wide_model();
        let mut memory = Memory::for_model(&model);
        let (tuned, mut state) = memory.start(&model, params).unwrap();
        let mut go = |depth_m: f32| {
            let output = tick(&model, &tuned, &mut state, pose(patch, params, depth_m));
            (output, state.hash())
        };
        depths_m(above).map(&mut go).collect()
    }

    fn pose(patch: &Patch, params: &Params, depth_m: f32) -> ProbePose {
        ProbePose { tip_m: patch.site_m() - params.probe.axis * depth_m }
    }

    fn on(surface: &mut TissueSurface, patch: &Patch, params: &Params, above: u16) -> Vec<(Output, u64)> {
        depths_m(above).map(|depth_m| (surface.render(pose(patch, params, depth_m)), surface.state.hash())).collect()
    }

    #[test]
    fn replayed_substeps_are_those_of_the_tick() {
        let (patch, one) = palpate_tissue::session::calibrated::sized(130).unwrap();
        for params in [Params { substeps: 1, ..one }, Params { substeps: 2, ..one }] {
            with_tissue(&patch, &params, |surface| {
                // the motion is recorded, replayed, replayed and recorded further, replayed as far
                // as the touch
                for above in [20, 20, 60, 5] {
                    surface.reset();
                    assert!(on(surface, &patch, &params, above) == plain(&patch, &params, above), "{above} ticks above");
                }
                assert!(!surface.untouched.known.is_empty());
                // a node that is displaced continues from its new place
                surface.reset();
                let still = on(surface, &patch, &params, 3).split_off(3);
                surface.reset();
                for _ in 0..3 {
                    surface.render(pose(&patch, &params, -5e-4));
                }
                surface.strike(None, Some(0.1), true);
                surface.render(pose(&patch, &params, -5e-4));
                assert!(surface.state.hash() != still[0].1);
            })
            .unwrap();
        }
    }
}
