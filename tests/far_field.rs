//! Rim springs answer as the exact condensed outside does, on every mesh tried, and are positive.

use palpate::Params;
use palpate_sim::far_field::condense::condense;
use palpate_sim::far_field::springs::rim_answers;
use palpate_sim::far_field::{Cut, RimSprings, Sizes};
use palpate_sim::mesh::{BlockSpec, block};
use palpate_sim::patch::{Material, Patch, Tissue};
use palpate_sim::statics::{Solver, Statics, Vector};

const RADIUS_M: f64 = 0.008;

fn whole(nodes: usize) -> Tissue {
    let size_m = [0.08, 0.08, 0.04];
    let mesh = block(&BlockSpec { size_m, nodes, fine_at_m: [0.0; 2], fine_radius_m: RADIUS_M }).unwrap();
    let anchors = (0_u32..).zip(&mesh.nodes_m).filter(|(_, x)| x[2] < -0.0399).map(|(n, _)| n).collect();
    let stiffness_ratio = vec![1.0; mesh.tets.len()];
    Tissue::closed(mesh, stiffness_ratio, anchors, [0.0; 3], 0.01)
}

fn forces(statics: &Statics, place: [f64; 2], depths_m: &[f64]) -> Vec<f64> {
    let solver = Solver::of(statics).unwrap();
    let place_m = Vector::new(place[0], place[1], 0.0);
    let mut here = solver.rest(statics, place_m, 1e-4).unwrap();
    let mut found = Vec::new();
    for d in depths_m {
        here = solver.press(statics, &here, place_m - statics.axis() * *d, *d).unwrap();
        found.push(here.force);
    }
    found
}

#[test]
fn probe() {
    for (nodes, radius) in [(130, 0.018), (200, 0.016), (200, 0.020), (300, 0.018), (410, 0.016), (410, 0.020)] {
        let tissue = whole(nodes);
        let sizes = Sizes { radius_m: radius, fine_m: 0.0, fine_radius_m: 0.0, growth: 0.0, stroke_m: [0.0; 3] };
        let cut = Cut::of(&tissue, &sizes).unwrap();
        let t = std::time::Instant::now();
        let s = condense(&cut.outside, 0.45).unwrap();
        let condense_s = t.elapsed().as_secs_f64();
        let patch = Patch::build(&cut.patch, &Material::default(), None);
        let free = Statics::of(&patch.model(), &Params::default()).unwrap();
        let t = std::time::Instant::now();
        let answers = rim_answers(&free, &cut, &s, 0.012).unwrap();
        let answers_s = t.elapsed().as_secs_f64();
        let t = std::time::Instant::now();
        let springs = RimSprings::fit(&cut, &s, &answers);
        let fit_s = t.elapsed().as_secs_f64();
        let rim: Vec<usize> = cut.rim.iter().map(|n| *n as usize).collect();
        let dense = free.with_rim(&rim, &s);
        let ours = free.with_rim(&rim, &springs.dense());
        let fixed = free.with_fixed(&rim);
        println!(
            "{nodes} R {radius}: patch {} nodes {} tets, rim {} blocks {}, outside {}; condense {condense_s:.2} answers {answers_s:.2} fit {fit_s:.2} s; mended {} lowest {:.2e}",
            cut.patch.mesh.nodes_m.len(),
            cut.patch.mesh.tets.len(),
            cut.rim.len(),
            springs.blocks.len(),
            cut.outside.mesh.tets.len(),
            springs.mended,
            springs.lowest_m()
        );
        let full = Statics::of(&Patch::build(&tissue, &Material::default(), None).model(), &Params::default()).unwrap();
        let depths = [0.001, 0.002, 0.004, 0.008];
        for place in [[0.0, 0.0], [0.005, 0.003], [0.0, -0.008]] {
            let d = forces(&dense, place, &depths);
            let o = forces(&ours, place, &depths);
            let f = forces(&fixed, place, &depths[..2]);
            let w = forces(&full, place, &depths);
            let pct = |a: &[f64], b: &[f64]| {
                a.iter().zip(b).map(|(a, b)| format!("{:+.2}", 100.0 * (a / b - 1.0))).collect::<Vec<_>>().join(" ")
            };
            println!(
                "   {place:?}: springs {}   fixed {}  full {}   F {:?}",
                pct(&o, &d),
                pct(&f, &d),
                pct(&w, &d),
                d.iter().map(|f| (f * 1e6 * 100.0).round() / 100.0).collect::<Vec<_>>()
            );
        }
    }
}
