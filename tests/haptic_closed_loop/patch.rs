//! The product's patch in the loop: shipped, calibrated, 410 nodes.

use palpate::haptic::cycle::{PatchRenderer, Settings};
use palpate::haptic::damping::DampingSettings;
use palpate::{Model, Node, Params, PatchFile, State, TetShapes};

use crate::plant::{FRICTION_N, Hand, LIGHT_FINGER, RELEASED, Run, tap};

#[repr(align(4))]
struct Aligned<T: ?Sized>(T);

static PATCH: &Aligned<[u8]> = &Aligned(*include_bytes!("../../host-sim/patches/block-410.patch"));

/// Memory of a patch.
struct Memory {
    nodes: Vec<Node>,
    candidates: Vec<u16>,
    shapes: Vec<TetShapes>,
    node_step: Vec<f32>,
    cap_m: Vec<f32>,
}

impl Memory {
    fn new(model: &Model) -> Self {
        Self {
            nodes: vec![Node::ZERO; model.nodes.len()],
            candidates: vec![0; model.triangles.len()],
            shapes: vec![TetShapes::ZERO; TetShapes::count(model)],
            node_step: vec![0.0; model.nodes.len()],
            cap_m: vec![0.0; model.triangles.len()],
        }
    }
}

/// A tap and hold on tissue of this stiffness.
fn on_tissue(youngs_modulus_pa: f32, run: impl Fn(&mut PatchRenderer) -> Run) -> Run {
    let file = PatchFile::open(&PATCH.0).unwrap();
    let params = Params { youngs_modulus_pa, substeps: 4, ..file.params };
    let Memory { mut nodes, mut candidates, mut shapes, mut node_step, mut cap_m } = Memory::new(&file.model);
    let tuned = params.build(&file.model, &mut node_step, &mut cap_m).unwrap();
    let mut state = State::new(&file.model, &mut nodes, &mut candidates, &mut shapes).unwrap();
    run(&mut PatchRenderer { model: &file.model, tuned: &tuned, state: &mut state })
}

/// Ticks.
const DELAY: u8 = 1;

#[test]
fn tissue_is_quiet_in_a_released_hand_and_under_a_finger() {
    for (youngs_modulus_pa, faithful) in [(3.5e3, true), (20e3, true), (3.5e3, false), (20e3, false)] {
        // a push that ends some 4 mm deep
        let released = Hand { push_n: 0.14 * f64::from(youngs_modulus_pa) / 3.5e3, ..RELEASED };
        for (name, hand) in [("released", released), ("light", LIGHT_FINGER)] {
            let mut settings = Settings::safe(DELAY);
            if faithful {
                settings.damping = DampingSettings::faithful(DELAY, 1e-3);
            }
            let run = on_tissue(youngs_modulus_pa, |patch| tap(patch, DELAY, FRICTION_N, settings, |_| hand));
            assert!(!run.limit_cycle(), "{youngs_modulus_pa} Pa, {name}: {run:?}");
            assert!(run.created_j <= 0.01e-3, "{youngs_modulus_pa} Pa, {name}: {run:?}");
            assert!((run.last.applied_n - run.last.output.force_n).norm() < 1e-3, "static force untouched: {run:?}");
            assert!(run.last.output.force_n.z > 0.02, "{run:?}");
        }
    }
}
