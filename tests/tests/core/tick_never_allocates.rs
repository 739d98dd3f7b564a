//! Once its memory is reserved, a patch allocates nothing: not when parameters are built, not in a
//! tick, not on reset.

use palpate::stages::probe::ProbePose;
use palpate::{ContactMap, NodeStep, State, TetShapes, Vector3, tick};
use palpate_tests::bench::{Bench, at_depth};

use crate::allocations::allocations;

#[test]
fn the_counter_counts() {
    let (count, boxed) = allocations(|| std::hint::black_box(Box::new(1)));
    assert_eq!((count, *boxed), (1, 1));
}

#[test]
fn build_reset_and_ticks_allocate_nothing() {
    let bench = Bench::block(410).with(|p| p.gravity_m_per_s2 = [0.0, 0.0, -9.81]);
    let model = bench.patch.wide_model();
    let mut nodes = vec![palpate::Node::ZERO; model.nodes.len()];
    let mut candidates = vec![0; model.triangles.len()];
    let mut shapes = vec![TetShapes::ZERO; TetShapes::count(&model)];
    let mut pressure_pa = vec![0.0; model.triangles.len()];
    let mut node_step = vec![NodeStep::ZERO; model.nodes.len()];
    let (count, touched) = allocations(|| {
        let tuned = bench.params.build(&model, &mut node_step).unwrap();
        let mut state = State::new(&model, &mut nodes, &mut candidates, &mut shapes).unwrap();
        let mut touched = 0;
        for n in 0..5000_u16 {
            // one tap per second, deeper than the depth limit, with a retreat faster than the speed
            // limit
            let depth_m = if n % 1000 < 700 { 1e-5 * f32::from(n % 1000) - 5e-4 } else { -0.05 };
            touched +=
                usize::from(tick(&model, &tuned, &mut state, ProbePose { tip_m: at_depth(depth_m) }).normal != Vector3::zeros());
            ContactMap::read(&model, &tuned, &mut state, &mut pressure_pa);
        }
        assert!(state.fault().is_none());
        // neither faults, refusals nor a reset allocate
        assert!(tick(&model, &tuned, &mut state, ProbePose { tip_m: Vector3::repeat(f32::NAN) }).fault.is_some());
        state.reset(&model);
        let wrong = palpate::Params { tick_s: -1.0, ..bench.params };
        assert!(wrong.check().is_err());
        touched
    });
    assert_eq!(count, 0, "allocations");
    assert!(touched > 2000, "{touched} ticks in contact");
}
