//! Time of a tick on this machine, and of a step of plain springs on the same edges in the same
//! run.
//!
//! `cargo bench -p palpate-bench` ends with a table of microseconds and ratios. Times are those of
//! one thread; the table names the machine.
#![allow(missing_docs)] // reason: criterion's macros

use std::hint::black_box;
use std::path::Path;

use criterion::{Criterion, criterion_group};
use palpate::stages::{force, integrate};
use palpate::{Params, ProbePose, Terms, tick};
use palpate_tissue::patch::Memory;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::Session;

const SIZES: [usize; 4] = [57, 144, 410, 1023];
/// Depth at which a tick is timed [m].
const DEPTH_M: f64 = 0.004;

fn session(nodes: usize) -> Session {
    let mut scene = Scene::load("block").unwrap();
    scene.tissue.nodes = Some(nodes);
    Session::prepare(&scene).unwrap()
}

/// The whole tick, pressed and held at 4 mm.
fn whole(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("tick");
    for nodes in SIZES {
        let session = session(nodes);
        let model = session.patch.wide_model();
        let mut memory = Memory::for_model(&model);
        let (tuned, mut state) = memory.start(&model, &session.params).unwrap();
        let mut depth_m = -0.001;
        let mut next = || {
            depth_m = f64::min(depth_m + 2e-5, DEPTH_M);
            tick(&model, &tuned, &mut state, ProbePose { tip_m: session.tip_m(depth_m) })
        };
        let settled = (0..1000).map(|_| next()).last();
        assert!(settled.is_some_and(|o| o.force_n.z > 0.0 && o.fault.is_none()));
        group.bench_function(format!("{nodes}"), |b| b.iter(|| black_box(next())));
    }
}

/// Springs and integration alone: the cost of the papers' plain model on the same edges, without
/// contact.
fn plain(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("plain springs");
    for nodes in SIZES {
        let session = session(nodes);
        let params = Params { terms: Terms::SPRINGS_ONLY, substeps: 1, ..session.params };
        let model = session.patch.wide_model();
        let mut memory = Memory::for_model(&model);
        let (tuned, mut state) = memory.start(&model, &params).unwrap();
        let away = session.tip_m(-1.0);
        group.bench_function(format!("{nodes}"), |b| {
            b.iter(|| {
                let load = force::accumulate(&model, &tuned, &mut state, away, palpate::Vector3::zeros());
                black_box(load);
                integrate::advance(&model, &tuned, &mut state).unwrap()
            });
        });
    }
}

criterion_group! {
    name = benches;
    config = Criterion::default().without_plots();
    targets = plain, whole
}

fn main() {
    benches();
    Criterion::default().configure_from_args().final_summary();
    print_table();
}

/// Median that criterion has just stored [us].
fn median_us(group: &str, nodes: usize) -> Option<f64> {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent()?;
    let stored = std::fs::read(target.join(format!("criterion/{group}/{nodes}/new/estimates.json"))).ok()?;
    let estimates: serde_json::Value = serde_json::from_slice(&stored).ok()?;
    Some(estimates["median"]["point_estimate"].as_f64()? * 1e-3)
}

fn print_table() {
    println!("\n{}, one thread, medians", palpate_tissue::machine::processor());
    println!("{:>6} {:>9} {:>12} {:>18} {:>7}", "nodes", "substeps", "tick us", "plain springs us", "ratio");
    for nodes in SIZES {
        let substeps = session(nodes).params.substeps;
        if let (Some(tick), Some(plain)) = (median_us("tick", nodes), median_us("plain springs", nodes)) {
            println!("{nodes:>6} {substeps:>9} {tick:>12.2} {plain:>18.2} {:>7.2}", tick / plain);
        }
    }
}
