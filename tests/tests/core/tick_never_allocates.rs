//! Once its memory is reserved, a patch allocates nothing: not when parameters are built, not in a
//! tick, not on reset. The other methods do not allocate in a tick either; allocations would make
//! them slower on the chart.
#![allow(unsafe_code)] // reason: only the allocator can count, and `GlobalAlloc` is an unsafe trait

use std::alloc::{GlobalAlloc, Layout, System};
use std::cell::Cell;

use palpate::stages::probe::ProbePose;
use palpate::{ContactMap, NodeStep, State, TetShapes, Vector3, tick};
use palpate_lab::methods::{Block, Method};
use palpate_tests::bench::{Bench, at_depth};

thread_local! {
    static ALLOCATIONS: Cell<usize> = const { Cell::new(0) };
}

struct Counting;

// SAFETY: every call is passed unchanged to the system's allocator; the counter is a `Cell` without
// destructor, so it allocates nothing itself.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.set(ALLOCATIONS.get() + 1);
        // SAFETY: the caller's promise is passed on
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's promise is passed on
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static COUNTING: Counting = Counting;

/// Number of allocations by this thread during `run`, and its result.
fn allocations<T>(run: impl FnOnce() -> T) -> (usize, T) {
    let before = ALLOCATIONS.get();
    let result = run();
    (ALLOCATIONS.get() - before, result)
}

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

#[test]
fn other_methods_allocate_nothing_either() {
    let block = Block::standard(57, 3500.0).unwrap();
    for method in Method::ALL {
        let run = method.run(&block, 2, |running| {
            let mut pressed = 0;
            let (count, ()) = allocations(|| {
                for n in 0..200_i32 {
                    let force_n = running.tick(block.tip_m(1e-5 * f64::from((n - 20).min(150)))).unwrap();
                    pressed += usize::from(force_n.z > 0.0);
                }
            });
            (count, pressed)
        });
        // a method that is not available (no calibrated patch) cannot allocate
        if let Some((count, pressed)) = run.unwrap() {
            assert_eq!(count, 0, "allocations of {}", method.name());
            assert!(pressed > 100, "{} pressed in {pressed} ticks", method.name());
        }
    }
}
