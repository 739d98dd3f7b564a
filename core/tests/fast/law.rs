//! A law, which answers without nodes: passive in every motion, the same tissue at every tick rate,
//! and never an extrapolation.

use palpate::{Branch, BuildError, ClampFlags, Law, LawShape, MOST_TERMS, Model, PatchFile, PronyTerm, Terms, Vector3};

use super::guard::Tissue;
use super::relaxation::TERMS;

/// A law of the shipped block.
const PLAIN: LawShape = LawShape {
    origin_m: [0.0; 3],
    along: [1.0, 0.0, 0.0],
    reach_m: 12e-3,
    side: 1,
    branches: [
        Branch { c: 6.5e-4, length_m: 48e-3 },
        Branch { c: 1e-5, length_m: f32::INFINITY },
        Branch { c: 19e-3, length_m: 48e-3 },
        Branch { c: 0.0, length_m: f32::INFINITY },
    ],
};
const HELD: [f32; 5] = [0.0, 0.153, 3.3, -764.0, 35_800.0];

/// The block's rest shape with a law and nothing else.
fn with(shape: LawShape, table: &'static [[f32; 5]], tick_s: f32, terms: [PronyTerm; MOST_TERMS]) -> Tissue {
    let mut file = Tissue::new().file;
    let origin_m = file.site_m.into();
    let law = Some(Law { shape: Box::leak(Box::new(LawShape { origin_m, ..shape })), table });
    let none = Model { springs: &[], spring_rows: &[], foundation: &[], rim_nodes: &[], rim_edges: &[], ..file.model };
    file.model = Model { law, ..none };
    (file.params.tick_s, file.params.substeps, file.params.relaxation) = (tick_s, 1, terms);
    file.params.limits.max_sink_m_per_s = 1.0;
    Tissue::of_file(file)
}

/// A bumpy table that rises and stiffens towards one side.
fn bumpy() -> &'static [[f32; 5]] {
    let row = |n: usize| {
        let [x, y] = [n % 7, n / 7].map(|n| n as f32 - 3.0);
        let [height_m, a0, a1, a2, a3] = HELD;
        let ratio = 1.0 + 0.06 * x + 0.03 * y * y;
        [height_m + 0.4e-3 * x - 0.1e-3 * y * y, a0 * ratio, a1 + 4.0 * y, a2, a3]
    };
    (0..49).map(row).collect::<Vec<_>>().leak()
}

/// Smooth random path of the tip over the disc and beyond, in and out of contact [m].
fn path(seed: u16, t_s: f32) -> Vector3<f32> {
    let wave = |n: u16, hz: f32| libm::sinf(std::f32::consts::TAU * (hz * t_s + 0.137 * f32::from(seed * n)));
    let aside = |n| 8e-3 * wave(n, 0.9) + 4e-3 * wave(n + 1, 2.3) + 1e-3 * wave(n + 2, 7.1);
    let high_m = 0.3e-3 + 3e-3 * wave(5, 1.7) + 1e-3 * wave(6, 6.1) + 0.4e-3 * wave(7, 19.0);
    Vector3::new(aside(1), aside(11), if high_m < -4.5e-3 { -4.5e-3 } else { high_m })
}

/// Least work that the hand has done at any time of a random motion, and all work it did [J].
fn work(tissue: &mut Tissue, seed: u16, tick_s: f32) -> (f32, f32) {
    let start = path(seed, 0.0) + Vector3::new(0.0, 0.0, 10e-3);
    let (mut done, mut least, mut gross) = (0.0_f32, 0.0_f32, 0.0_f32);
    let mut last = (start, tissue.at(start).force_n);
    for n in 0..(8.0 / tick_s) as u32 {
        let t_s = n as f32 * tick_s;
        // comes down in the first half second
        let at_m = path(seed, t_s) + Vector3::new(0.0, 0.0, 10e-3 * (1.0 - 2.0 * t_s).max(0.0));
        let output = tissue.at(at_m);
        assert_eq!(output.fault, None);
        let joule = -(last.1 + output.force_n).dot(&(at_m - last.0)) * 0.5;
        done += joule;
        gross += joule.abs();
        least = least.min(done);
        last = (at_m, output.force_n);
    }
    (least, gross)
}

#[test]
fn no_motion_gets_more_work_out_than_went_in() {
    let tick_s = 0.125e-3;
    for relaxation in [[PronyTerm::NONE; MOST_TERMS], TERMS] {
        for (shape, table) in [(PLAIN, &[HELD][..]), (LawShape { side: 7, ..PLAIN }, bumpy())] {
            for seed in 0..6 {
                let (least, gross) = work(&mut with(shape, table, tick_s, relaxation), seed, tick_s);
                assert!(gross > 2e-3 && least > -1e-5 * gross, "{seed}: {least} J of {gross} J, {} rows", shape.side);
            }
        }
    }
}

#[test]
fn the_force_is_the_gradient_of_a_potential_and_tilts_with_the_surface() {
    let mut tissue =
        with(LawShape { side: 7, branches: [Branch { c: 0.0, length_m: 1.0 }; 4], ..PLAIN }, bumpy(), 1e-3, [PronyTerm::NONE; 3]);
    // round a closed way in contact, partly beyond the disc, the work is zero
    let at = |n: u32| {
        let angle = std::f32::consts::TAU * n as f32 / 4000.0;
        Vector3::new(-4e-3 + 10e-3 * libm::cosf(angle), 6e-3 * libm::sinf(angle), -3e-3 + 1e-3 * libm::sinf(2.0 * angle))
    };
    tissue.at(at(0) + Vector3::new(0.0, 0.0, 10e-3));
    (0..1000).for_each(|n| _ = tissue.at(at(0) + Vector3::new(0.0, 0.0, 10e-6 * (1000 - n) as f32)));
    let mut last = (at(0), tissue.at(at(0)).force_n);
    let (mut net, mut gross, mut beyond) = (0.0, 0.0, 0);
    for n in 1..=4000 {
        let output = tissue.at(at(n));
        let joule = -(last.1 + output.force_n).dot(&(at(n) - last.0)) * 0.5;
        beyond += u32::from(output.limiters.contains(ClampFlags::DEPTH));
        (net, gross, last) = (net + joule, gross + joule.abs(), (at(n), output.force_n));
    }
    assert!((500..3500).contains(&beyond), "{beyond}");
    assert!(gross > 1e-4 && net.abs() < 2e-4 * gross, "{net} of {gross} J");
    let tilt = last.1.x / last.1.z;
    assert!((-0.11..-0.05).contains(&tilt), "the surface rises by 0.067 along x: {tilt}");
}

#[test]
fn beyond_its_places_and_depths_it_answers_as_at_their_edge_and_says_so() {
    let table = bumpy();
    let mut tissue = with(LawShape { side: 7, ..PLAIN }, table, 1e-3, [PronyTerm::NONE; MOST_TERMS]);
    let mut force = |x_m: f32| {
        tissue.state.reset(&tissue.file.model);
        tissue.at(Vector3::new(x_m, 0.0, 8e-3));
        (0..200).for_each(|n| _ = tissue.at(Vector3::new(x_m, 0.0, 8e-3 - 50e-6 * n as f32)));
        let output = (0..300).map(|_| tissue.at(Vector3::new(x_m, 0.0, -2e-3))).last().unwrap();
        (output.force_n, output.limiters.contains(ClampFlags::DEPTH))
    };
    let [(edge_n, inside), (beyond_n, outside)] = [11.999e-3, 14e-3].map(&mut force);
    assert_eq!((inside, outside), (false, true));
    assert!((edge_n.z - beyond_n.z).abs() < 1e-4 && beyond_n.x.abs() < 1e-6, "{edge_n} {beyond_n}");
    let mut deep = with(PLAIN, &[HELD], 1e-3, [PronyTerm::NONE; MOST_TERMS]);
    let limit_m = deep.file.model.depth_limit_m;
    let (at, past) = (deep.press(limit_m), deep.press(limit_m + 1e-3));
    assert!(!at.limiters.contains(ClampFlags::DEPTH) && past.limiters.contains(ClampFlags::DEPTH));
    let per_m = (past.force_n.z - at.force_n.z) / 1e-3 / deep.file.params.youngs_modulus_pa;
    let probe = &deep.file.params.probe;
    let expected = palpate::stages::probe::continuation_m(probe, deep.file.params.poisson_ratio, limit_m);
    assert!((per_m / expected - 1.0).abs() < 0.02, "{per_m} for {expected}");
}

#[test]
fn a_hold_fades_as_the_prony_series_and_ticks_of_any_length_give_one_tissue() {
    let held = |terms, tick_s: f32| {
        let mut tissue = with(PLAIN, &[HELD], tick_s, terms);
        let steps = (0.02 / tick_s) as u32;
        tissue.high(1e-3);
        (0..=steps).for_each(|n| _ = tissue.high(1e-3 - 4e-3 * n as f32 / steps as f32));
        let fast = tissue.high(-3e-3).force_n.z;
        (0..(1.0 / tick_s) as u32).for_each(|_| _ = tissue.high(-3e-3));
        (fast, tissue.high(-3e-3).force_n.z)
    };
    let (_, elastic) = held([PronyTerm::NONE; MOST_TERMS], 1e-3);
    for tick_s in [1e-3, 0.5e-3, 0.125e-3] {
        let (_, relaxed) = held(TERMS, tick_s);
        let left = TERMS.iter().fold(1.0, |left, term| left - term.share * (1.0 - libm::expf(-1.01 / term.time_s)));
        assert!((relaxed / elastic / left - 1.0).abs() < 0.01, "{tick_s} s: {}, for {left}", relaxed / elastic);
    }
}

#[test]
fn a_patch_file_carries_a_law_and_the_terms_choose_between_it_and_the_nodes() {
    let mut tissue = with(LawShape { side: 7, ..PLAIN }, bumpy(), 1e-3, [PronyTerm::NONE; MOST_TERMS]);
    let mut bytes = Vec::new();
    tissue.file.write(|piece| bytes.extend_from_slice(piece));
    let mut words = vec![0_u32; bytes.len() / 4];
    bytemuck::cast_slice_mut(&mut words).copy_from_slice(&bytes);
    let mut again = Tissue::of_file(PatchFile::open(bytemuck::cast_slice(words.leak())).unwrap());
    assert_eq!(again.press(3e-3).force_n, tissue.press(3e-3).force_n);

    let patch = Tissue::new().press(3e-3).force_n;
    let mut both = Tissue::new().file;
    both.model.law = tissue.file.model.law;
    let by_law = Tissue::of_file(both).press(3e-3).force_n;
    both.params.terms = Terms { law: false, ..both.params.terms };
    assert_eq!(Tissue::of_file(both).press(3e-3).force_n, patch);
    assert_eq!(by_law, tissue.press(3e-3).force_n);
}

#[test]
fn a_law_that_would_create_energy_is_refused() {
    let refused = |shape: LawShape, table: &'static [[f32; 5]]| {
        let law = Law { shape: &shape, table };
        law.check(&Vector3::z()).unwrap_err()
    };
    let mut pushing = PLAIN;
    pushing.branches[2].c = -1e-3;
    assert!(matches!(refused(pushing, &[HELD]), BuildError::OutOfRange { parameter: "law.branches.c", .. }));
    let mut backward = PLAIN;
    backward.branches[2].length_m = -1e-3;
    assert!(matches!(refused(backward, &[HELD]), BuildError::OutOfRange { parameter: "law.branches.length_m", .. }));
    assert!(matches!(refused(LawShape { side: 3, ..PLAIN }, &[HELD]), BuildError::OutOfRange { parameter: "law.side", .. }));
    assert!(matches!(refused(LawShape { side: 7, ..PLAIN }, &[HELD]), BuildError::LengthMismatch { .. }));
    assert!(matches!(refused(PLAIN, &[[f32::NAN; 5]]), BuildError::NotFinite { .. }));
}
