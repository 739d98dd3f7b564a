//! Methods at rest under the probe: the force on the support equals the force on the probe.

use crate::bench::{Bench, at_depth};
use palpate::{ProbePose, Terms, Vector3, tick};
use palpate_lab::methods::{Block, Corotational, Law, Meshless, Method, NeoHookean, RunningMethod, Volume};

/// Force on the probe [N] and node positions [m] after a press to 3 mm.
fn at_rest(block: &Block, method: Method, substeps: u16) -> (Vector3<f32>, Vec<Vector3<f32>>) {
    let pressed = method.run(block, substeps, |running: &mut dyn RunningMethod| {
        let mut force = Vector3::zeros();
        for n in 0..3000 {
            let depth_m = (5e-5 * f64::from(n) - 2e-4).min(0.003);
            force = running.tick(block.tip_m(depth_m)).expect("stable");
        }
        (force, (0..block.tissue.mesh.nodes_m.len()).map(|n| running.position_m(n)).collect())
    });
    pressed.expect("built").expect("to be had")
}

#[test]
fn the_support_bears_what_the_probe_feels() {
    let block = Block::standard(130, 3500.0).expect("a block that can be meshed");
    fn check(block: &Block, method: Method, law: &mut impl Law) {
        let (felt, position) = at_rest(block, method, 2);
        let mut force = vec![Vector3::zeros(); position.len()];
        for _ in 0..8 {
            law.forces(&position, &mut force);
        }
        let borne: Vector3<f32> = block.tissue.anchors.iter().map(|&n| force[n as usize]).sum::<Vector3<f32>>() * 3500.0;
        // after a hold of 3 s, while the slowest motion under the mass floor takes a quarter of a
        // second; the support is pulled down as the probe is pushed up
        let gap = (borne.z / -felt.z - 1.0).abs();
        assert!(felt.z > 0.05 && gap < 2e-3, "{}: probe {} N, support {} N", method.name(), felt.z, borne.z);
    }
    check(&block, Method::Corotational, &mut Corotational::new(&block));
    check(&block, Method::NeoHookean, &mut NeoHookean::new(&block, Volume::PerTet));
    check(&block, Method::NeoHookeanNodal, &mut NeoHookean::new(&block, Volume::Nodal));
    check(&block, Method::Meshless, &mut Meshless::new(&block).expect("sound tets"));
}

/// XPBD's constraints have the energy of springs with per-tet volume, up to the quadratic volume
/// term, and the same contact. XPBD therefore converges to the same force.
#[test]
fn xpbd_converges_to_the_springs_it_stands_for() {
    let block = Block::standard(57, 3500.0).expect("a block that can be meshed");
    let springs = at_rest(&block, Method::SpringsVolumeTet, 1).0.z;
    for substeps in [1, 4] {
        let xpbd = at_rest(&block, Method::Xpbd, substeps).0.z;
        assert!((xpbd / springs - 1.0).abs() < 0.02, "{substeps} substeps: {xpbd} N, springs {springs} N");
    }
}

/// The papers' model omits the factor that the product applies to its springs. The foundation,
/// which acts in series, keeps its stiffness.
#[test]
fn printed_springs_are_stiffer_than_ours_by_less_than_their_factor() {
    let block = Block::standard(57, 3500.0).expect("a block that can be meshed");
    let (printed, _) = at_rest(&block, Method::Springs, 1);
    let bench = Bench::block(57).with(|p| p.terms = Terms::SPRINGS_ONLY);
    let (model, mut memory) = (bench.patch.wide_model(), bench.memory());
    let (tuned, mut state) = memory.start(&model, &bench.params).expect("a sound patch");
    let mut ours = Vector3::zeros();
    for n in 0..3000_u16 {
        let depth_m = (5e-5 * f32::from(n) - 2e-4).min(0.003);
        ours = tick(&model, &tuned, &mut state, ProbePose { tip_m: at_depth(depth_m) }).force_n;
    }
    let ratio = printed.z / ours.z;
    assert!(1.03 < ratio && ratio < 0.8 * 1.45, "{} N, ours {} N", printed.z, ours.z);
}
