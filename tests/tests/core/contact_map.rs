//! The contact map: its force is that of the tick, it does not affect the tick, it is empty without
//! contact, and its centre is where the probe pushes.

use palpate::{ClampFlags, ContactMap, Output, Params, ProbePose, ProbeShape, PronyTerm, Vector3, tick};
use palpate_tests::bench::{Bench, at_depth};

/// Ticks of a press from 1 mm above the surface to `depth_m` and of the hold there.
const TICKS: usize = 700;

/// Position of the tip in tick `n` of a press to a depth.
fn tip_m(depth_m: f32, n: usize) -> Vector3<f32> {
    at_depth((2e-5 * n as f32 - 1e-3).min(depth_m))
}

/// State at the end of a hold: the tick's output, the map, the pressures, and the deformed corners
/// of every triangle.
fn held(bench: &Bench, depth_m: f32) -> (Output, ContactMap, Vec<f32>, Vec<[Vector3<f32>; 3]>) {
    let model = bench.patch.wide_model();
    let mut memory = bench.memory();
    let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
    let mut last = Output::NONE;
    for n in 0..TICKS {
        last = tick(&model, &tuned, &mut state, ProbePose { tip_m: tip_m(depth_m, n) });
        assert_eq!(last.fault, None);
    }
    let mut pressure_pa = vec![f32::NAN; model.triangles.len()];
    let map = ContactMap::read(&model, &tuned, &mut state, &mut pressure_pa);
    let corners = model.triangles.iter().map(|t| t.node.map(|n| state.nodes()[usize::from(n)].position_m())).collect();
    (last, map, pressure_pa, corners)
}

fn area_m2([a, b, c]: &[Vector3<f32>; 3]) -> Vector3<f32> {
    (b - a).cross(&(c - a)) * 0.5
}

fn relaxing(p: &mut Params) {
    p.relaxation[0] = PronyTerm { share: 0.4, time_s: 0.1 };
    p.relaxation[1] = PronyTerm { share: 0.2, time_s: 2.0 };
}

/// Combinations of tissue and probe that the foundation treats differently.
fn kinds() -> Vec<(&'static str, Bench)> {
    let damped = |p: &mut Params| (p.node_damping_per_s, p.substeps) = (60.0, 2);
    let block = || Bench::block(230).with(damped);
    vec![
        ("hemisphere", block()),
        ("nine points", Bench::with_points(230, 9).with(damped)),
        ("sixteen points", Bench::with_points(230, 16).with(damped)),
        ("calibrated", Bench::calibrated(410)),
        ("sphere", block().with(|p| p.probe.shape = ProbeShape::Sphere)),
        ("flat", block().with(|p| p.probe.shape = ProbeShape::Flat)),
        ("relaxing", block().with(relaxing)),
        ("stiffening", block().with(|p| (p.stiffening_b, p.substeps) = (5.0, 4))),
        ("both", block().with(|p| (p.stiffening_b, p.substeps) = (5.0, 4)).with(relaxing)),
        ("rubbing", block().with(|p| p.friction = 0.4).with(relaxing)),
    ]
}

#[test]
fn a_hold_has_the_ticks_force() {
    // with friction, the tick returns normal and friction force as one
    for (kind, bench) in kinds().into_iter().filter(|(_, bench)| bench.params.friction == 0.0) {
        let (output, map, pressure_pa, corners) = held(&bench, 2e-3);
        let push_n = output.force_n;
        // relaxing tissue loses force within the tick
        let share = if bench.params.relaxation[0].share > 0.0 { 2e-3 } else { 1e-4 };
        assert!((map.force_n - push_n).norm() < share * push_n.norm(), "{kind}: {} for {push_n}", map.force_n);
        assert!((map.centre_m - output.point_m).xy().norm() < 1e-3, "{kind}: {} for {}", map.centre_m, output.point_m);
        // forces fan out under a ball and at the rounded edge of a flat end
        let sum_n: f32 = pressure_pa.iter().zip(&corners).map(|(p, c)| p * area_m2(c).norm()).sum();
        assert!((0.9999..1.15).contains(&(sum_n / map.force_n.norm())), "{kind}: {sum_n} N for {}", map.force_n);
        // along the facets' normals the pressures sum to the probe's force, except for the facets'
        // angles, which are steep at the edge of a flat end
        let along_n: f32 = pressure_pa.iter().zip(&corners).map(|(p, c)| p * area_m2(c).z).sum();
        let most = if bench.params.probe.shape == ProbeShape::Flat { 0.15 } else { 0.05 };
        assert!((along_n / map.force_n.z - 1.0).abs() < most, "{kind}: {along_n} N for {}", map.force_n);
        assert_eq!(map.peak_pressure_pa, pressure_pa.iter().copied().fold(0.0, f32::max), "{kind}");
        assert_eq!(usize::from(map.triangles), pressure_pa.iter().filter(|p| **p > 0.0).count(), "{kind}");
    }
}

/// A press 3 mm deep on a surface that slopes by 5 degrees to the probe, then a slide of 1 mm down
/// the slope, and a hold. The torque is that of the forces on the anchors, which share no code with
/// the map.
#[test]
fn on_a_slope_the_wrench_is_the_ticks_force_and_the_anchors_torque() {
    let along = Vector3::new(5_f32.to_radians().cos(), 0.0, -5_f32.to_radians().sin());
    let axis = along.cross(&Vector3::y());
    let shaped = |shape| Bench::block(230).with(|p| (p.node_damping_per_s, p.substeps, p.probe.shape) = (60.0, 2, shape));
    let mut cases: Vec<_> = kinds().into_iter().filter(|(kind, _)| !["calibrated", "relaxing", "both"].contains(kind)).collect();
    cases.push(("capsule", shaped(ProbeShape::Capsule { length_m: 8e-3, along })));
    cases.push(("ellipsoid", shaped(ProbeShape::Ellipsoid { semi_axes_m: [12e-3, 6e-3], along })));
    cases.push(("rubbing capsule", cases[cases.len() - 2].1.clone().with(|p| p.friction = 0.4)));
    for (kind, bench) in cases {
        let bench = bench.with(|p| (p.probe.axis, p.relaxation) = (axis, Params::default().relaxation));
        let model = bench.patch.wide_model();
        let mut memory = bench.memory();
        let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
        let (mut output, mut at_m) = (Output::NONE, Vector3::zeros());
        for n in 0..1200 {
            at_m = axis * (2e-3 - 2e-5 * n.min(250) as f32) + along * (1e-5 * n.clamp(250, 350) as f32 - 2.5e-3);
            output = tick(&model, &tuned, &mut state, ProbePose { tip_m: at_m });
            assert_eq!((output.fault, output.limiters), (None, ClampFlags::default()), "{kind}");
        }
        let map = ContactMap::read(&model, &tuned, &mut state, &mut []);
        let (wrench, force_n) = (map.wrench(), output.force_n);
        println!("{kind}: {wrench:?}, friction {}, tick {force_n}", map.friction_n.norm());
        assert!((wrench.force_n - force_n).norm() < 2e-3 * force_n.norm(), "{kind}: {wrench:?} for {force_n}");
        let along_n = map.friction_n.dot(&along);
        assert_eq!(along_n < -0.1 * force_n.norm(), bench.params.friction > 0.0, "{kind}: {} for {force_n}", map.friction_n);
        let on_anchor = |n: &u16| {
            let node = &state.nodes()[usize::from(*n)];
            (node.position_m() - at_m).cast::<f64>().cross(&node.force_over_modulus().cast())
        };
        let torque_nm = -model.anchors.iter().map(on_anchor).sum::<Vector3<f64>>() * f64::from(tuned.youngs_modulus_pa());
        let (off_nm, least_nm) = ((wrench.torque_nm.cast() - torque_nm).norm(), 5e-4 * f64::from(force_n.norm()));
        println!("{kind}: anchors {torque_nm:?}");
        assert!(off_nm < 1e-2 * torque_nm.norm() && torque_nm.norm() > least_nm, "{kind}: {wrench:?} for {torque_nm:?}");
    }
}

#[test]
fn no_tick_differs_by_a_map() {
    for (kind, bench) in kinds() {
        let model = bench.patch.wide_model();
        let [hash, again] = [false, true].map(|maps| {
            let mut memory = bench.memory();
            let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
            let (mut touched, mut mapped) = (0, 0);
            // down, a slide, away, and back
            for n in 0..900_usize {
                let tip_m =
                    tip_m(2e-3, n.min(300)) + Vector3::x() * (1e-5 * n as f32) + Vector3::z() * if n > 600 { 4e-3 } else { 0.0 };
                let output = tick(&model, &tuned, &mut state, ProbePose { tip_m });
                touched += usize::from(output.normal != Vector3::zeros());
                if maps {
                    let map = ContactMap::read(&model, &tuned, &mut state, &mut []);
                    // tissue that the tick has thrown off the probe no longer pushes
                    assert!(map == ContactMap::NONE || state.in_contact(), "{kind}, tick {n}");
                    mapped += usize::from(map != ContactMap::NONE);
                }
            }
            assert!(touched > 300 && (!maps || mapped * 20 > touched * 19), "{kind}: {mapped} maps of {touched} ticks");
            state.hash()
        });
        assert_eq!(hash, again, "{kind}");
    }
}

#[test]
fn nothing_touched_is_an_empty_map() {
    let bench = Bench::block(130);
    let model = bench.patch.wide_model();
    let mut memory = bench.memory();
    let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
    let mut pressure_pa = vec![f32::NAN; model.triangles.len()];
    let mut empty = |state: &mut palpate::State, when: &str| {
        pressure_pa.fill(f32::NAN);
        assert_eq!(ContactMap::read(&model, &tuned, state, &mut pressure_pa), ContactMap::NONE, "{when}");
        assert!(pressure_pa.iter().all(|p| *p == 0.0), "{when}: {pressure_pa:?}");
    };
    empty(&mut state, "before the first tick");
    tick(&model, &tuned, &mut state, ProbePose { tip_m: at_depth(-1e-3) });
    empty(&mut state, "above");
    (0..200).for_each(|n| _ = tick(&model, &tuned, &mut state, ProbePose { tip_m: tip_m(2e-3, n) }));
    assert!(state.in_contact());
    tick(&model, &tuned, &mut state, ProbePose { tip_m: Vector3::repeat(f32::NAN) });
    assert!(state.fault().is_some());
    empty(&mut state, "after a fault");
}

#[test]
fn the_centre_follows_place_and_tilt() {
    let bench = Bench::block(410).with(|p| p.substeps = 2);
    let model = bench.patch.wide_model();
    let mut memory = bench.memory();
    let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
    let to_m = Vector3::new(5e-3, -3e-3, 0.0);
    (0..TICKS).for_each(|n| _ = tick(&model, &tuned, &mut state, ProbePose { tip_m: tip_m(2e-3, n) + to_m }));
    let map = ContactMap::read(&model, &tuned, &mut state, &mut []);
    assert!((map.centre_m - to_m).xy().norm() < 2e-4, "{}", map.centre_m);
    // a tilted flat end, whose edge toward +x is the deeper one
    for lean in [0.05_f32, -0.05] {
        let flat =
            bench.clone().with(|p| (p.probe.shape, p.probe.axis) = (ProbeShape::Flat, Vector3::new(lean, 0.0, 1.0).normalize()));
        let (_, map, ..) = held(&flat, 1e-3);
        assert!(map.centre_m.x * lean.signum() > 5e-4 && map.centre_m.y.abs() < 2e-4, "{lean}: {}", map.centre_m);
    }
}
