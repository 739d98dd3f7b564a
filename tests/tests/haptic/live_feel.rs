//! Presets with relaxation, friction or stiffening, as rendered in `palpate live`: the force of a
//! hold falls to the scene's remaining share, a slide is resisted, and a press becomes stiffer with
//! depth.

use palpate::Vector3;
use palpate_loop::live::replay::replay;
use palpate_loop::live::trace::Trace;
use palpate_loop::live::{Choice, Holding, Live, Told};
use palpate_tissue::scene::Scene;

type V = Vector3<f64>;

/// Speed of a careful hand towards the tissue and into it [m/s].
const INTO_M_PER_S: f64 = 12e-3;
const ALONG_M_PER_S: f64 = 25e-3;

/// A preset under the pointer, and the surface point from which depths are measured.
struct Felt {
    live: Live,
    axis: V,
    place_m: V,
}

impl Felt {
    fn of(preset: &str) -> Self {
        let live = Live::new(&Choice::preset(preset), &Holding::default()).unwrap();
        let tissue = live.tissue();
        let (axis, place_m) = (tissue.params().probe.axis.cast(), tissue.patch().site_m().cast());
        let mut felt = Self { live, axis, place_m };
        // outside, until the loop is armed and its force ramped in
        felt.at(-5e-3, 800);
        felt
    }

    /// Moves towards a depth at the place for some ticks, in none of which an invariant of the loop
    /// may be violated.
    fn at(&mut self, depth_m: f64, ticks: u32) -> Told {
        let target_m = self.place_m - self.axis * depth_m;
        (0..ticks).map(|_| self.tick(target_m)).last().unwrap()
    }

    fn tick(&mut self, target_m: V) -> Told {
        let told = self.live.tick(target_m, true);
        let telemetry = &told.telemetry;
        assert!(told.broken.is_none() && telemetry.fault.is_none(), "{:?} {:?}", told.broken, telemetry.fault);
        told
    }

    /// Presses to a depth at a hand's speed and returns the records of all ticks, the last of which
    /// is at that depth.
    fn press(&mut self, depth_m: f64) -> Vec<Told> {
        self.at(0.0, 100);
        let ticks = (depth_m / INTO_M_PER_S * 1e3) as u32;
        (1..=ticks).map(|n| self.at(depth_m * f64::from(n) / f64::from(ticks), 1)).collect()
    }

    /// Slides along the surface in a direction over a distance and returns the records of all
    /// ticks.
    fn slide(&mut self, depth_m: f64, way: V, far_m: f64) -> Vec<Told> {
        let (from_m, ticks) = (self.place_m, (far_m / ALONG_M_PER_S * 1e3) as u32);
        let mut told = Vec::new();
        for n in 1..=ticks {
            self.place_m = from_m + way * (far_m * f64::from(n) / f64::from(ticks));
            told.push(self.at(depth_m, 1));
        }
        told
    }
}

fn force_n(told: &Told) -> f64 {
    told.telemetry.applied_n.norm().into()
}

#[test]
fn a_hold_of_beef_fades_to_the_share_that_its_terms_leave() {
    let scene = Scene::load("beef").unwrap();
    let mut felt = Felt::of("beef");
    let mut elastic = Felt::of("block-20kpa");
    // equal except for the relaxation terms: the expected force is the elastic loading, relaxed in
    // one dimension
    assert_eq!(felt.live.tissue().params().youngs_modulus_pa, elastic.live.tissue().params().youngs_modulus_pa);
    let loading: Vec<f64> = elastic.press(3e-3).iter().map(force_n).collect();
    let held_n = force_n(&elastic.at(3e-3, 3000));
    let ours: Vec<f64> = felt.press(3e-3).iter().map(force_n).collect();
    let left = |t_s: f64| {
        let fading = scene.tissue.relaxation.iter().map(|term| term.share * (-t_s / term.time_s).exp());
        scene.tissue.lasting_share() + fading.sum::<f64>()
    };
    let predicted = |after_s: f64| {
        let end = loading.len();
        let mut before_n = 0.0;
        let rises = loading.iter().chain([&held_n]).enumerate().map(|(n, f)| {
            let rise_n = f - before_n;
            before_n = *f;
            rise_n * left(after_s + (end as f64 - 0.5 - n.min(end - 1) as f64) * 1e-3)
        });
        rises.sum::<f64>()
    };
    let peak_n = ours.iter().copied().fold(0.0, f64::max);
    assert!(peak_n < 0.9 * held_n, "the fast term fades in the loading: {peak_n} N of {held_n} N");
    let mut at_s = 0.0;
    for (after_s, ticks) in [(0.5, 500), (1.0, 500), (3.0, 2000)] {
        let now_n = force_n(&felt.at(3e-3, ticks));
        at_s += f64::from(ticks) * 1e-3;
        let expected_n = predicted(after_s);
        println!(
            "{at_s} s: {now_n:.4} N, expected {expected_n:.4} N, elastic {held_n:.4} N, at the end of the loading {peak_n:.4} N"
        );
        assert!((now_n / expected_n - 1.0).abs() < 0.03, "{after_s} s: {now_n} N, {expected_n} N expected");
    }
    let (faded_n, lasting_n) = (force_n(&felt.at(3e-3, 30_000)), scene.tissue.lasting_share() * held_n);
    assert!((faded_n / lasting_n - 1.0).abs() < 0.02, "{faded_n} N, {lasting_n} N last");
    // without relaxation the force does not fall
    let still_n = force_n(&elastic.at(3e-3, 3000));
    assert!((still_n / held_n - 1.0).abs() < 0.005, "{still_n} N, {held_n} N");
}

#[test]
fn a_slide_on_skin_drags_against_the_motion() {
    for preset in ["abdomen", "foot"] {
        let friction = Scene::load(preset).unwrap().probe.friction;
        assert!(friction > 0.0, "{preset}");
        let mut felt = Felt::of(preset);
        let axis = felt.axis;
        let aside = if axis.x.abs() < 0.9 { V::x() } else { V::y() };
        let way = axis.cross(&aside).normalize();
        let pressed = *felt.press(2e-3).last().unwrap();
        // there and back: the friction force reverses with the motion
        for way in [way, -way] {
            let told = felt.slide(2e-3, way, 8e-3);
            for told in &told[told.len() / 2..] {
                let drag_n = -told.along_n().cast::<f64>().dot(&way);
                let push_n = f64::from(told.telemetry.applied_n.dot(&told.telemetry.output.normal));
                assert!(drag_n > 0.7 * friction * push_n && drag_n < 1.2 * friction * push_n, "{preset}: {drag_n} N, {push_n} N");
            }
            let told = told.last().unwrap();
            println!(
                "{preset}: pressed {:.4} N, slides {:.4} N, along {:.4} N",
                force_n(&pressed),
                force_n(told),
                told.along_n().norm()
            );
        }
    }
    // without friction there is no drag
    let mut smooth = Felt::of("block");
    smooth.press(2e-3);
    let told = smooth.slide(2e-3, V::x(), 8e-3);
    let along = told.iter().map(|t| f64::from(t.along_n().norm()) / force_n(t)).fold(0.0, f64::max);
    assert!(along < 1e-3, "{along}");
}

#[test]
fn pig_liver_grows_stiffer_under_the_ball() {
    let mut felt = Felt::of("pig-liver");
    let soft_n = force_n(&felt.at(1.5e-3, 600));
    let deep_n = force_n(&felt.at(3e-3, 600));
    let exponent = (deep_n / soft_n).log2();
    println!("{soft_n:.4} N at 1.5 mm, {deep_n:.4} N at 3 mm: exponent {exponent:.2}");
    // a half-space has an exponent of 1.5; a slab of this thickness without stiffening has about 2
    assert!(exponent > 2.5, "{exponent}");
}

#[test]
fn what_is_felt_of_them_repeats_bit_for_bit() {
    for preset in ["beef", "abdomen", "pig-liver"] {
        let mut felt = Felt::of(preset);
        felt.live.record().unwrap();
        felt.at(-5e-3, 800);
        felt.press(2e-3);
        let strongest_n = felt.slide(2e-3, V::y(), 4e-3).iter().map(force_n).fold(0.0, f64::max);
        let trace = Trace::read(&felt.live.finish().unwrap()).unwrap();
        assert!(strongest_n > 0.1 && replay(&trace).unwrap().differs.is_none(), "{preset}: {strongest_n} N");
    }
}
