//! The contact map compared with Hertz's theory and with the contact pressures of finite elements,
//! which share no code with it.

use palpate::{ContactMap, Params, Probe, ProbePose, Vector3, tick};
use palpate_fit::reference::body::Material;
use palpate_fit::reference::domain::BlockCase;
use palpate_fit::reference::newton::Press;
use palpate_fit::reference::probe::RigidProbe;
use palpate_fit::reference::refine::refine;
use palpate_tests::bench::Bench;
use palpate_tissue::mesh::{BlockSpec, TetMesh, block};
use palpate_tissue::patch::{Material as Law, Patch};
use palpate_tissue::scene::{Inclusion, Shape};
use palpate_tissue::stable_step::limits;
use palpate_tissue::tissue::Tissue;

use crate::fem_reference::{RADIUS_M, above, assert_within, standard_block};

/// Maps at the end of holds at these depths, at a place on the top.
fn maps(bench: &Bench, place_m: [f32; 2], depths_m: &[f32]) -> Vec<ContactMap> {
    let model = bench.patch.wide_model();
    let mut memory = bench.memory();
    let (tuned, mut state) = memory.start(&model, &bench.params).unwrap();
    let mut depth_m = -3e-3_f32;
    let mut hold = |to_m: f32| {
        for _ in 0..500 {
            depth_m = (depth_m + 2e-5).min(to_m);
            let tip_m = Vector3::new(place_m[0], place_m[1], 0.0) - bench.params.probe.axis * depth_m;
            assert_eq!(tick(&model, &tuned, &mut state, ProbePose { tip_m }).fault, None);
        }
        ContactMap::read(&model, &tuned, &mut state, &mut [])
    };
    depths_m.iter().map(|to_m| hold(*to_m)).collect()
}

/// Results of finite elements for the same contact; pressures are over Young's modulus.
#[derive(Debug)]
struct Solved {
    /// Radius of the Hertzian contact whose pressure distribution has the same second moment [m].
    /// It agrees on all meshes within 0.1 %, while an area found by counting points grows with the
    /// mesh by 8 %.
    radius_m: f64,
    /// Mean pressure over E within 1.5 mm of the centre, about the size of a triangle of the patch
    /// (1).
    middle: f64,
    /// Position of the centre of pressure relative to the tip [m].
    centre_m: Vector3<f64>,
}

/// Presses finite elements to these depths.
fn solved(case: &BlockCase, depths_m: &[f64]) -> Vec<Solved> {
    let block = case.build().unwrap();
    let mut press = above(&block, Shape::Hemisphere, RADIUS_M);
    // a quarter of the block represents the whole: by symmetry the centre of pressure is at the tip
    let cut = case.symmetry();
    let mut at = |depth_m: f64| {
        press.go_to(depth_m, |_| {}).unwrap();
        let (mut push, mut area, mut middle, mut square, mut centre_m) = (0.0, 0.0, 0.0, 0.0, Vector3::zeros());
        for p in block.body.pressed(&press.displacement_m, &press.contact(depth_m)) {
            let mut d = p.at_m - block.place_m;
            let pushed = p.area_m2 * p.pressure_over_e;
            if d.xy().norm() < 1.5e-3 {
                (middle, area) = (middle + pushed, area + p.area_m2);
            }
            (push, square) = (push + pushed, square + pushed * d.xy().norm_squared());
            (0..2).filter(|k| cut[*k]).for_each(|k| d[k] = 0.0);
            centre_m += d * pushed;
        }
        Solved { radius_m: (2.5 * square / push).sqrt(), middle: middle / area, centre_m: centre_m / push }
    };
    depths_m.iter().map(|depth_m| at(*depth_m)).collect()
}

#[test]
fn a_shallow_ball_has_hertzs_contact() {
    // elements of 0.9 mm; the block is 14 contact radii deep
    let size_m = [0.08, 0.08, 0.04];
    let mesh = block(&BlockSpec { size_m, nodes: 1800, fine_at_m: [0.0; 2], fine_radius_m: 4e-3 }).unwrap();
    let anchors = (0_u32..).zip(&mesh.nodes_m).filter(|(_, x)| x[2] < -0.0399).map(|(n, _)| n).collect();
    let ratio = vec![1.0; mesh.tets.len()];
    let patch = Patch::build(&Tissue::closed(mesh, ratio, anchors, [0.0; 3], 2e-3), &Law::default(), None);
    let params = Params { limits: limits(&patch, 1e-3), substeps: 6, node_damping_per_s: 60.0, ..Params::default() };
    let bench = Bench { patch, params };
    let depth_m = 1e-3_f64;
    let map = maps(&bench, [0.0; 2], &[depth_m as f32])[0];
    println!("{map:?}, elements of {:.2} mm", bench.patch.element_m() * 1e3);
    let a_m = (RADIUS_M * depth_m).sqrt();
    let circle_m2 = std::f64::consts::PI * a_m * a_m;
    assert_within("area", map.area_m2.into(), circle_m2, 0.10);
    for half_m in map.half_lengths_m {
        assert_within("half-length", half_m.into(), a_m, 0.05);
    }
    assert_within("peak", map.peak_pressure_pa.into(), 1.5 * f64::from(map.force_n.z) / circle_m2, 0.10);
    assert!(map.centre_m.xy().norm() < 5e-5, "{}", map.centre_m);
}

#[test]
fn areas_and_peaks_are_those_of_finite_elements() {
    // at these depths the contact includes more than ten of the patch's triangles. The peak is that
    // of one triangle, and a calibrated patch has points of uneven stiffness
    let depths_m = [2e-3, 4e-3];
    let elements = solved(&standard_block(500, 7e-3), &depths_m);
    for (name, bench, area, peak) in [
        ("calibrated", Bench::calibrated(410), 0.05, 0.40),
        ("by formulas", Bench::block(410).with(|p| p.substeps = 2), 0.08, 0.10),
    ] {
        for (map, right) in maps(&bench, [0.0; 2], &depths_m.map(|d| d as f32)).iter().zip(&elements) {
            println!("{name}: {map:?} for {right:?}");
            assert_within("area", map.area_m2.into(), std::f64::consts::PI * right.radius_m.powi(2), area);
            for half_m in map.half_lengths_m {
                assert_within("half-length", half_m.into(), right.radius_m, 0.04);
            }
            assert_within("peak", f64::from(map.peak_pressure_pa / bench.params.youngs_modulus_pa), right.middle, peak);
        }
    }
}

#[test]
#[ignore = "long: finite elements of half a block, twice"]
fn a_nodule_beside_the_probe_draws_the_centre_as_in_finite_elements() {
    // 8 mm across, ten times as stiff, with its centre 10 mm deep and 4 mm beside the press; the
    // patch's elements of 3 mm blur it
    let nodule = Inclusion { center_m: [4e-3, 0.0, -10e-3], radius_m: 4e-3, stiffness_ratio: 10.0, stiffening_b: None };
    let depths_m = [2e-3, 3e-3];
    let solve = |inclusions| {
        let material = Material { poisson_ratio: 0.45, stiffening_b: 0.0, inclusions };
        solved(&BlockCase { material, may_cut: [false, true], ..standard_block(1600, RADIUS_M) }, &depths_m)
    };
    let [without, with] = [solve(vec![]), solve(vec![nodule])];
    let (patch, params) = palpate_tissue::session::calibrated::sized(410).unwrap();
    let press = |patch: Patch| {
        maps(&Bench { params: Params { limits: limits(&patch, 1e-3), ..params }, patch }, [0.0; 2], &depths_m.map(|d| d as f32))
    };
    let [plain, lumpy] = [press(patch.clone()), press(patch.with_inclusions(&[nodule]))];
    for k in 0..2 {
        let right_m = with[k].centre_m.x - without[k].centre_m.x;
        let drawn_m = f64::from(lumpy[k].centre_m.x - plain[k].centre_m.x);
        println!(
            "{} mm: the centre moves by {:.3} mm, in finite elements {:.3}",
            depths_m[k] * 1e3,
            drawn_m * 1e3,
            right_m * 1e3
        );
        assert!(right_m > 5e-5, "{right_m}");
        assert_within("shift of the centre", drawn_m, right_m, 0.45);
    }
}

/// A probe that presses the preset block at an angle, or near its edge at x = 40 mm.
pub struct OffTheMiddle {
    pub shape: fn([f64; 3]) -> Shape,
    pub radius_m: f64,
    degrees: f64,
    place_m: [f64; 2],
    depth_m: f64,
    /// Distance from where the pressure is steep, in the plane of the top [m].
    off_m: fn(f64, f64) -> f64,
}

/// A rod that is 12 mm long between its rounded ends.
pub fn capsule(degrees: f64, place_m: [f64; 2]) -> OffTheMiddle {
    let off_m = |x: f64, y: f64| (x.abs() - 6e-3).max(0.0).hypot((y.abs() - 3e-3).max(0.0));
    let shape = |along| Shape::Capsule { length_m: 12e-3, along };
    OffTheMiddle { shape, radius_m: 6e-3, degrees, place_m, depth_m: 3e-3, off_m }
}

/// An ellipsoid, 18 mm long and 10 mm wide.
pub fn ellipsoid(degrees: f64, place_m: [f64; 2]) -> OffTheMiddle {
    let off_m = |x: f64, y: f64| (x.abs() - 6e-3).max(0.0).hypot((y.abs() - 3e-3).max(0.0));
    let shape = |along| Shape::Ellipsoid { semi_axes_m: [9e-3, 5e-3], along };
    OffTheMiddle { shape, radius_m: 6e-3, degrees, place_m, depth_m: 3e-3, off_m }
}

pub fn flat_end(degrees: f64, place_m: [f64; 2]) -> OffTheMiddle {
    OffTheMiddle {
        shape: |_| Shape::Flat,
        radius_m: RADIUS_M,
        degrees,
        place_m,
        depth_m: 2e-3,
        off_m: |x, y| x.hypot(y) - 7.8e-3,
    }
}

const AT_THE_EDGE_M: [f64; 2] = [0.036, 0.0];

impl OffTheMiddle {
    /// Direction down the slope, and axis of the probe.
    fn frame(&self) -> [Vector3<f64>; 2] {
        let (sin, cos) = self.degrees.to_radians().sin_cos();
        [Vector3::new(cos, 0.0, -sin), Vector3::new(sin, 0.0, cos)]
    }

    /// Longest element at a point, from `least_m` where the pressure is steep [m].
    fn longest_m(&self, x: [f64; 3], least_m: f64) -> f64 {
        least_m + 0.6 * (self.off_m)(x[0] - self.place_m[0], x[1]).hypot(x[2])
    }

    /// A mesh of the block, or of its half at y > 0.
    pub fn mesh(&self, half: bool, least_m: f64) -> TetMesh {
        let y_m = if half { 0.02 } else { 0.0 };
        let spec = BlockSpec {
            size_m: [0.08, if half { 0.04 } else { 0.08 }, 0.04],
            nodes: if half { 300 } else { 800 },
            fine_at_m: [self.place_m[0], -y_m],
            fine_radius_m: 12e-3,
        };
        let mut mesh = block(&spec).unwrap();
        mesh.nodes_m.iter_mut().for_each(|x| x[1] += y_m);
        refine(&mesh, |x| self.longest_m(x, least_m), 10_000)
    }

    /// Force along the axis over E [m^2] and torque around y about the tip over E [m^3], of finite
    /// elements.
    fn solved(&self) -> [f64; 2] {
        let [along, axis] = self.frame();
        let case = BlockCase { place_m: self.place_m, may_cut: [false, true], ..standard_block(0, 0.0) };
        let body = case.support(&self.mesh(true, 2.2e-3), [false, true]);
        let probe = RigidProbe::new((self.shape)(along.into()), self.radius_m, body.place_m, axis);
        let mut press = Press::new(&body.body, probe, body.place_m).unwrap();
        press.go_to(self.depth_m, |_| {}).unwrap();
        let contact = press.contact(self.depth_m);
        let (mut force_m2, mut torque_m3) = (Vector3::zeros(), Vector3::zeros());
        for p in body.body.pressed(&press.displacement_m, &contact) {
            let push = contact.probe.gap(&p.at_m).normal * (-p.area_m2 * p.pressure_over_e);
            force_m2 += push;
            torque_m3 += (p.at_m - contact.probe.tip_m).cross(&push);
        }
        [force_m2.dot(&axis), torque_m3.y]
    }

    /// Force and torque of a patch, as of [`Self::solved`].
    fn pressed(&self, bench: Bench) -> [f64; 2] {
        let [along, axis] = self.frame();
        let shape = (self.shape)(along.into()).of_core(axis.into());
        let bench = bench.with(|p| p.probe = Probe { shape, radius_m: self.radius_m as f32, axis: axis.cast() });
        let map = maps(&bench, self.place_m.map(|x| x as f32), &[self.depth_m as f32])[0];
        [map.force_n.dot(&bench.params.probe.axis), map.torque_nm.y].map(|x| f64::from(x / bench.params.youngs_modulus_pa))
    }

    /// A patch by formulas with elements of this length where the pressure is steep [m].
    pub fn by_formulas(&self, least_m: f64) -> Bench {
        let mesh = self.mesh(false, least_m);
        let anchors = (0_u32..).zip(&mesh.nodes_m).filter(|(_, x)| x[2] < -0.0399).map(|(n, _)| n).collect();
        let ratio = vec![1.0; mesh.tets.len()];
        let site_m = [self.place_m[0], self.place_m[1], 0.0];
        let patch = Patch::build(&Tissue::closed(mesh, ratio, anchors, site_m, 4e-3), &Law::default(), None);
        let params = Params { limits: limits(&patch, 1e-3), substeps: 6, node_damping_per_s: 60.0, ..Params::default() };
        Bench { patch, params }
    }
}

fn assert_torques(case: &OffTheMiddle, benches: impl IntoIterator<Item = Bench>) {
    let [force, torque] = case.solved();
    for bench in benches {
        let [f, t] = case.pressed(bench);
        println!("force {:+.2} %, torque {:+.2} % of {torque:.4e}", 100.0 * (f / force - 1.0), 100.0 * (t / torque - 1.0));
        assert_within("torque", t, torque, 0.03);
    }
}

/// The torque about the tip is that of the contact forces of finite elements, on a slope of 10
/// degrees under patches that were fitted to a hemisphere, and where a third of the tip hangs over
/// the edge of the block.
#[test]
fn a_capsules_torque_is_that_of_finite_elements() {
    let (slope, edge) = (capsule(10.0, [0.0; 2]), capsule(0.0, AT_THE_EDGE_M));
    assert_torques(&slope, [410, 1020].map(Bench::calibrated));
    assert_torques(&edge, [edge.by_formulas(1.2e-3)]);
}

/// The pressure under a flat end is steep at its rim, so the elements must be small there: on the
/// slope, the shipped patches of 410 and 1020 nodes give torques that are 15 and 10 % too low.
#[test]
#[ignore = "long: finite elements of half a block, and patches of thousands of nodes"]
fn a_flat_ends_torque_is_that_of_finite_elements_if_the_mesh_is_fine_at_its_rim() {
    for case in [flat_end(5.0, [0.0; 2]), flat_end(0.0, AT_THE_EDGE_M)] {
        assert_torques(&case, [case.by_formulas(0.9e-3)]);
    }
}
