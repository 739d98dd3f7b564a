//! Patches of tissue whose regions stiffen with different exponents, compared with finite elements
//! of the same laws. The compared quantity is the ratio of the force to that of the same tissue
//! without stiffening. The accuracy of a patch with scaled regions and no stiffening is tested
//! elsewhere.

use palpate::Params;
use palpate_fit::reference::body::Material;
use palpate_fit::reference::domain::BlockCase;
use palpate_fit::reference::newton::Press;
use palpate_fit::reference::probe::RigidProbe;
use palpate_fit::reference::shape::TetRule;
use palpate_fit::statics::{Solver, Statics, Vector};
use palpate_tests::bench::Bench;
use palpate_tests::share::Share;
use palpate_tissue::scene::{Inclusion, Scene, Shape};
use palpate_tissue::tissue::Layout;
use serde_json::Value;

use crate::fingerprint::solved_before;

/// Exponent of the touched tissue, the region in it, and accepted rms errors of the force ratio at
/// the centre and 6 mm from it [%].
struct Case {
    name: &'static str,
    stiffening_b: f64,
    region: Inclusion,
    accepted_pct: [f64; 2],
}

/// A ball so large that its top is practically a plane at 8 mm depth.
fn below(stiffness_ratio: f64, b: f64) -> Inclusion {
    Inclusion { center_m: [0.0, 0.0, -10.008], radius_m: 10.0, stiffness_ratio, stiffening_b: Some(b) }
}

/// A ball of 12 mm diameter at 12 mm depth.
fn ball(stiffness_ratio: f64, b: f64) -> Inclusion {
    Inclusion { center_m: [0.0, 0.0, -0.012], radius_m: 0.006, stiffness_ratio, stiffening_b: Some(b) }
}

fn cases() -> [Case; 7] {
    let case = |name, stiffening_b, region, accepted_pct| Case { name, stiffening_b, region, accepted_pct };
    [
        case("a layer that stiffens more, on one four times as stiff", 10.0, below(4.0, 3.0), [5.5, 9.0]),
        case("a layer that stiffens less, on one four times as stiff", 3.0, below(4.0, 10.0), [2.5, 5.5]),
        case("a layer that stiffens more, on one a quarter as stiff", 10.0, below(0.25, 3.0), [1.5, 1.5]),
        case("a layer that stiffens less, on one a quarter as stiff", 3.0, below(0.25, 10.0), [3.5, 3.7]),
        case("a ball ten times as stiff that does not stiffen", 10.0, ball(10.0, 0.0), [1.5, 1.5]),
        case("a soft ball that stiffens more", 3.0, ball(0.3, 20.0), [4.0, 1.5]),
        case("a ball ten times as stiff", 10.0, ball(10.0, 10.0), [1.5, 1.5]),
    ]
}

struct Pressed {
    x_m: f64,
    depth_m: Vec<f64>,
    /// Ratio of the force to that without stiffening (1).
    growth: Vec<f64>,
}

fn stored(name: &str) -> Vec<Pressed> {
    let file: Value = serde_json::from_str(include_str!("../../data/stiffening_regions.json")).unwrap();
    let number = |value: &Value| value.as_f64().unwrap();
    let list = |value: &Value| -> Vec<f64> { value.as_array().unwrap().iter().map(number).collect() };
    let press = |p: &Value| Pressed { x_m: number(&p["x_m"]), depth_m: list(&p["depth_m"]), growth: list(&p["growth"]) };
    file["press"].as_array().unwrap().iter().filter(|p| p["case"] == name).map(press).collect()
}

/// Force over E of the calibrated patch of 410 nodes with the region [m^2]. If `own` is true, each
/// region stiffens by its own law; otherwise all stiffen with the larger exponent.
fn forces(case: &Case, press: &Pressed, stiffens: bool, own: bool) -> Vec<f64> {
    let text = format!(
        "name = \"regions\"\n[tissue]\nblock_m = [0.08, 0.08, 0.04]\nyoungs_modulus_pa = 3500.0\npoisson_ratio = 0.45\n\
         density_kg_per_m3 = 1060.0\nstiffening_b = {:?}\n[[tissue.inclusion]]\ncenter_m = {:?}\nradius_m = {:?}\n\
         stiffness_ratio = {:?}\nstiffening_b = {:?}\n[probe]\nshape = \"hemisphere\"\nradius_m = 0.008\n[drive]\n\
         kind = \"depth\"\nholds_m = [0.004]\nramp_m_per_s = 0.04\nhold_s = 0.5\n",
        case.stiffening_b,
        case.region.center_m,
        case.region.radius_m,
        case.region.stiffness_ratio,
        case.region.stiffening_b.unwrap()
    );
    let scene = Scene::parse("regions", &text).unwrap();
    let most_b = scene.tissue.most_stiffening_b();
    let bench = Bench::calibrated(410);
    let mut patch = bench.patch.with_inclusions(&[case.region]);
    if own {
        patch.set_steepness(Layout::of(&scene).unwrap().steepness(&patch.mesh(), most_b));
    }
    let params = Params { stiffening_b: if stiffens { most_b as f32 } else { 0.0 }, ..bench.params };
    let statics = Statics::of(&patch.model(), &params).unwrap();
    let solver = Solver::of(&statics).unwrap();
    let tip_m = |depth_m: f64| Vector::new(press.x_m, 0.0, -depth_m);
    let mut here = solver.rest(&statics, tip_m(0.0), 1e-6).unwrap();
    let at = |depth_m: &f64| {
        here = solver.press(&statics, &here, tip_m(*depth_m), *depth_m).unwrap();
        here.force
    };
    press.depth_m.iter().map(at).collect()
}

/// Errors of the ratio of the force to that without stiffening [%].
fn errors_pct(case: &Case, press: &Pressed, own: bool) -> Vec<f64> {
    let [with, without] = [true, false].map(|stiffens| forces(case, press, stiffens, own));
    let growth = with.iter().zip(without).map(|(with, without)| with / without);
    growth.zip(&press.growth).map(|(found, expected)| 100.0 * (found / expected - 1.0)).collect()
}

fn rms(errors: &[f64]) -> f64 {
    (errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64).sqrt()
}

#[test]
fn regions_stiffen_by_their_own_laws() {
    let mut share = Share::one_in(3);
    for case in cases() {
        for (press, accepted_pct) in stored(case.name).iter().zip(case.accepted_pct) {
            if !share.takes() {
                continue;
            }
            let [own, one] = [true, false].map(|own| rms(&errors_pct(&case, press, own)));
            println!("{}, {} m: {own:.1} % rms, by one law {one:.1} %", case.name, press.x_m);
            assert!(own < one, "{}, {} m: one law {one} %, their own {own} %", case.name, press.x_m);
            assert!(own <= accepted_pct, "{}, {} m: {own} %", case.name, press.x_m);
        }
    }
}

#[test]
fn the_stored_growth_is_that_of_finite_elements() {
    if solved_before() {
        return;
    }
    let cases = cases();
    let [.., soft, _] = &cases;
    let press = stored(soft.name).into_iter().find(|press| press.x_m == 0.0).unwrap();
    let forces_m2 = |stiffens: f64| -> Vec<f64> {
        let region = Inclusion { stiffening_b: soft.region.stiffening_b.map(|b| b * stiffens), ..soft.region };
        let case = BlockCase {
            size_m: [0.08, 0.08, 0.04],
            place_m: [0.0; 2],
            material: Material { poisson_ratio: 0.45, stiffening_b: soft.stiffening_b * stiffens, inclusions: vec![region] },
            nodes: 350,
            fine_radius_m: 0.01,
            rule: TetRule::Eleven,
            may_cut: [true; 2],
        };
        let block = case.build().unwrap();
        let probe = RigidProbe::new(Shape::Hemisphere, 0.008, block.place_m, Vector::z());
        let mut solving = Press::new(&block.body, probe, block.place_m).unwrap();
        let at = |depth_m: f64| {
            solving.go_to(depth_m, |_| ()).unwrap();
            solving.force_over_e_m2()
        };
        [2e-3, 4e-3].map(at).to_vec()
    };
    for ((with, without), depth_m) in forces_m2(1.0).iter().zip(forces_m2(0.0)).zip([2e-3, 4e-3]) {
        let at = press.depth_m.iter().position(|d| (d - depth_m).abs() < 1e-9).unwrap();
        let off = with / without / press.growth[at] - 1.0;
        println!("{depth_m} m: {:+.2} %", 100.0 * off);
        assert!(off.abs() < 0.01, "{depth_m} m: {off}");
    }
}
