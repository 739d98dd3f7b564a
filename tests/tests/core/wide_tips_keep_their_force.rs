//! A flat tip that is wide beside the elements pushes on triangles at its rim, many tets away from
//! the tip that is located: from wherever it came, its force stays.

use palpate::{ClampFlags, ProbePose, ProbeShape, Vector3, tick};
use palpate_tests::bench::Bench;
use palpate_tests::share::Share;
use palpate_tissue::patch::Memory;

const DEEP_M: f32 = 3e-3;
/// Displacement per tick [m].
const STEP_M: f32 = 25e-6;
/// Depth from which a tip is felt at every place [m].
const FELT_M: f32 = 50e-6;

#[test]
fn a_wide_flat_tip_keeps_its_force_wherever_it_came_from() {
    let mut share = Share::one_in(7);
    for nodes in [410, 1020] {
        for radius_m in [8e-3, 12e-3] {
            let bench = Bench::block(nodes).with(|p| (p.probe.shape, p.probe.radius_m) = (ProbeShape::Flat, radius_m));
            for clear_m in [0.3e-3, 1e-3, 4e-3, 8e-3, 15e-3] {
                for at_m in [[-1e-3, 4e-3], [3e-3, -2e-3], [5e-3, 5e-3], [-6e-3, 1e-3]] {
                    if share.takes() {
                        press(&bench, at_m, clear_m);
                    }
                }
            }
        }
    }
}

fn press(bench: &Bench, [x_m, y_m]: [f32; 2], clear_m: f32) {
    let model = bench.patch.wide_model();
    let mut memory = Memory::for_model(&model);
    let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
    let ticks = ((DEEP_M + clear_m) / STEP_M) as i32;
    for n in 0..=ticks {
        let depth_m = STEP_M * n as f32 - clear_m;
        let tip_m = bench.patch.site_m() + Vector3::new(x_m, y_m, -depth_m);
        let output = tick(&model, &tuned, &mut state, ProbePose { tip_m });
        let label = format!("{:?} from {clear_m} m above ({x_m}, {y_m}), {depth_m} m deep: {output:?}", bench.params.probe);
        assert_eq!(output.fault, None, "{label}");
        let felt = output.force_n.z > 0.0 && !output.outside && !output.limiters.contains(ClampFlags::BURIED);
        assert!(felt || depth_m < FELT_M, "{label}");
    }
}

/// On a slope the edge of a flat end touches first: the middle of the face is then still above the
/// surface, by more than the millimetre within which a ball is at it.
#[test]
fn a_flat_end_on_a_slope_has_a_force() {
    for degrees in [0.0_f32, 5.0, 10.0, 15.0, 25.0, 35.0] {
        let (sin, cos) = degrees.to_radians().sin_cos();
        let axis = Vector3::new(sin, 0.0, cos);
        let bench = Bench::block(410).with(|p| (p.probe.shape, p.probe.axis) = (ProbeShape::Flat, axis));
        let model = bench.patch.wide_model();
        let mut memory = Memory::for_model(&model);
        let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
        let edge_m = bench.params.probe.radius_m * sin;
        for n in 0..=280_i16 {
            let depth_m = STEP_M * f32::from(n) - 4e-3;
            let tip_m = bench.patch.site_m() + Vector3::new(0.0, 0.0, edge_m - depth_m);
            let output = tick(&model, &tuned, &mut state, ProbePose { tip_m });
            let label = format!("{degrees} degrees, the edge {depth_m} m deep: {output:?}");
            assert!(output.fault.is_none() && !output.limiters.contains(ClampFlags::BURIED), "{label}");
            // a foundation point is at most an element away from the edge
            assert!(depth_m < 1.5e-3 || output.force_n.z > 1e-3 && !output.outside, "{label}");
        }
    }
}
