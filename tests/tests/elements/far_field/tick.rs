//! The tick with a rim: it settles to the equilibrium, and the force on the probe equals that on
//! the rim.

use palpate::{GuardLimits, Model, Params, ProbePose, State, tick};
use palpate_fit::far_field::Sizes;
use palpate_fit::statics::{Statics, Vector};
use palpate_tests::bench::{Bench, at_depth};
use palpate_tests::oracle::Oracle;
use palpate_tissue::mesh::block_with_rim;
use palpate_tissue::patch::{Material, Memory};

use super::{BLOCK_M, RADIUS_M, far_field, forces, on_bottom, tissue};

/// A place off the centre, so that nothing is symmetric [m].
const PLACE_M: [f64; 2] = [0.0023, -0.0017];

/// Sum of the forces of the rim springs over E [N/Pa], computed as stiffness times displacement.
/// The force on the nodes is the opposite.
fn rim_force(model: &Model, state: &State) -> Vector {
    let moved = |n: usize| state.nodes()[n].position_m().cast::<f64>() - Vector::from(model.nodes[n].rest_m.map(f64::from));
    let mut sum = Vector::zeros();
    for r in model.rim_nodes {
        let [xx, yy, zz, xy, xz, yz] = r.block_m.map(f64::from);
        let u = moved(r.node as usize);
        sum += Vector::new(xx * u.x + xy * u.y + xz * u.z, xy * u.x + yy * u.y + yz * u.z, xz * u.x + yz * u.y + zz * u.z);
    }
    for e in model.rim_edges {
        let [ui, uj] = e.node.map(|n| moved(n.into()));
        for (n, v) in e.block_m.iter().enumerate() {
            sum[n / 3] += f64::from(*v) * uj[n % 3];
            sum[n % 3] += f64::from(*v) * ui[n / 3];
        }
    }
    sum
}

/// The momentum added in a tick comes from the probe and the rim only; the patch does not push
/// itself. There is one exception: the smooth fields' motion that contact takes from pressed nodes
/// (`core/src/smooth.rs`). No force accounts for it, and it is a small share of the probe's.
#[test]
fn momentum_comes_from_the_probe_and_the_rim_alone() {
    for (youngs_modulus_pa, most_share) in [(3.5e3, 1e-3), (20e3, 1e-3), (100e3, 1e-3)] {
        let change = |p: &mut Params| (p.node_damping_per_s, p.youngs_modulus_pa) = (0.0, youngs_modulus_pa);
        let bench = Bench::far_field(200, 0.018).with(change);
        let model = bench.patch.wide_model();
        assert!(model.anchors.is_empty());
        let mut memory = bench.memory();
        let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
        let e = f64::from(bench.params.youngs_modulus_pa);
        // rounding of the sums of all internal forces in single precision: a few N over the nodes
        // at 3.5 kPa
        let rounding = 2e-8 * e / 3.5e3;
        let momenta = Oracle::new(model, bench.params).momenta();
        let momentum = |state: &State| -> Vector {
            let speeds: Vec<Vector> = state.nodes().iter().map(|node| node.velocity_m_per_s().cast()).collect();
            momenta(&speeds).iter().sum()
        };
        let (mut pulled_n, mut strongest_n, mut unaccounted) = (0.0_f64, 0.0_f64, 0.0_f64);
        let mut last_m = 0.0;
        for n in 0..200_u8 {
            // 40 mm/s to 4 mm, tilted, then a hold during which the patch oscillates
            let depth_m = (-0.5e-3 + 40e-6 * f32::from(n)).min(4e-3);
            let pose = ProbePose { tip_m: at_depth(depth_m) + Vector::new(0.1, 0.05, 0.0).cast::<f32>() * depth_m };
            let (before, rim) = (momentum(&state), rim_force(&model, &state) * e);
            let output = tick(&model, &tuned, &mut state, pose);
            assert_eq!(output.fault, None);
            let gained = momentum(&state) - before;
            let given = -(output.force_n.cast::<f64>() + rim) * 1e-3;
            pulled_n = pulled_n.max(rim.norm());
            strongest_n = strongest_n.max(f64::from(output.force_n.norm()));
            // the force on a moving probe excludes the mass that the floor adds
            if depth_m == 4e-3 && last_m == depth_m {
                unaccounted = unaccounted.max((gained - given).norm() - rounding);
            }
            last_m = depth_m;
        }
        let share = unaccounted / (strongest_n * 1e-3);
        println!("{youngs_modulus_pa} Pa: {share:.2e} of the force of {strongest_n:.3} N is not accounted for");
        assert!(share < most_share, "{youngs_modulus_pa} Pa: {share} of {strongest_n} N");
        assert!(pulled_n > 0.05, "the rim must pull for this to say anything: {pulled_n} N");
    }
}

#[test]
fn ticks_settle_to_the_statics_and_the_rim_bears_the_probe() {
    let sizes = Sizes { radius_m: 0.018, fine_m: 0.004, fine_radius_m: RADIUS_M, growth: 0.45 };
    let whole = tissue(block_with_rim(BLOCK_M, [0.0; 2], &sizes, 0).unwrap(), [0.0; 3], on_bottom);
    let far = far_field(&whole, &sizes);
    let patch = far.patch(&Material::default());
    let model = patch.wide_model();
    assert!(model.anchors.is_empty(), "nothing but the rim holds this patch");
    let params = Params {
        node_damping_per_s: 120.0,
        limits: GuardLimits { max_sink_m_per_s: 0.1, ..GuardLimits::HIGHEST },
        ..Params::default()
    };
    let statics = Statics::of(&model, &params).unwrap();
    let e = f64::from(params.youngs_modulus_pa);
    let mut memory = Memory::for_model(&model);
    let (tuned, mut state) = memory.start(&model, &params).unwrap();
    let tip = |depth_m: f64| ProbePose { tip_m: Vector::new(PLACE_M[0], PLACE_M[1], -depth_m).cast() };
    tick(&model, &tuned, &mut state, tip(-0.001));
    for depth_m in [0.001, 0.003, 0.006] {
        let mut output = tick(&model, &tuned, &mut state, tip(depth_m));
        for _ in 0..3000 {
            output = tick(&model, &tuned, &mut state, tip(depth_m));
        }
        assert_eq!(output.fault, None);
        let wanted_n = forces(&statics, Vector::new(PLACE_M[0], PLACE_M[1], 0.0), &[depth_m])[0] * e;
        let felt_n: Vector = output.force_n.cast();
        let borne_n = rim_force(&model, &state) * -e;
        let off = felt_n.z / wanted_n - 1.0;
        println!("{depth_m} m: {felt_n:?} N, statics {wanted_n:.5} N, rim {borne_n:?} N");
        assert!(off.abs() < 3e-3, "{depth_m} m: {} N, statics {wanted_n} N", felt_n.z);
        assert!((felt_n - borne_n).norm() < 3e-3 * felt_n.norm(), "{depth_m} m: {felt_n:?} N felt, {borne_n:?} N borne");
    }
}
