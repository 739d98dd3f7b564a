use std::boxed::Box;
use std::vec::Vec;

use palpate::{ClampFlags, FoundationPoint};

use super::*;

/// The default patch of an image.
static BLOCK: &WordAligned<[u8]> = &WordAligned(*include_bytes!("../../../patches/block-m4f-168.patch"));
/// A patch whose mass floor acts on the motion relative to neighbours.
static RELATIVE: &WordAligned<[u8]> = &WordAligned(*include_bytes!("../../../patches/block-m7-480.patch"));
static LIVER: &WordAligned<[u8]> = &WordAligned(*include_bytes!("../../../patches/liver-m4f-168.patch"));

/// The default patch after a change of its file, in leaked memory aligned to words.
fn changed(change: impl FnOnce(&mut PatchFile<'_>)) -> &'static [u8] {
    changed_of(&BLOCK.0, change)
}

/// A patch after a change of its file, in leaked memory aligned to words.
fn changed_of(bytes: &[u8], change: impl FnOnce(&mut PatchFile<'_>)) -> &'static [u8] {
    let mut file = PatchFile::open(bytes).unwrap();
    change(&mut file);
    let mut bytes = Vec::new();
    file.write(|part| bytes.extend_from_slice(part));
    let words = Vec::leak(std::vec![0_u32; bytes.len().div_ceil(4)]);
    let on_words: &'static mut [u8] = &mut bytemuck::cast_slice_mut(words)[..bytes.len()];
    on_words.copy_from_slice(&bytes);
    on_words
}

fn opened(budget: &Budget, bytes: &[u8]) -> Result<(), Refusal> {
    let mut memory = Box::new(Memory::RESERVED);
    Patch::open_within(budget, bytes, &mut memory, None, &mut || {}).map(|_| ()).map_err(Refusal::from)
}

#[test]
fn a_step_longer_than_its_own_limit_and_a_tick_that_is_not_the_loops_are_refused() {
    assert_eq!(opened(&Budget::M4F_168, &BLOCK.0), Ok(()));
    for bad in [0.99e-3, 0.0, -1.0, f32::NAN] {
        assert_eq!(opened(&Budget::M4F_168, changed(|file| file.stable_dt_s = bad)), Err(Refusal::PatchStep), "{bad}");
    }
    let of_two = |stable_dt_s| changed(|file| (file.params.substeps, file.stable_dt_s) = (2, stable_dt_s));
    assert_eq!(opened(&Budget::M7_480, of_two(0.501e-3)), Ok(()));
    assert_eq!(opened(&Budget::M7_480, of_two(0.499e-3)), Err(Refusal::PatchStep));
    for tick_s in [1e-2, 1.001e-3, 0.999e-3, 1e-4] {
        let bytes = changed(|file| (file.params.tick_s, file.stable_dt_s) = (tick_s, 1.0));
        assert_eq!(opened(&Budget::M4F_168, bytes), Err(Refusal::PatchStep), "{tick_s}");
    }
}

#[test]
fn cost_and_mass_are_the_boards_own_word() {
    for substeps in [2, 20, 1_000] {
        let bytes = changed(|file| file.params.substeps = substeps);
        assert_eq!(opened(&Budget::M4F_168, bytes), Err(Refusal::PatchCost), "{substeps}");
    }
    assert_eq!(opened(&Budget { cycles: 5e4 }, &BLOCK.0), Err(Refusal::PatchCost));
    let light = changed(|file| {
        (file.params.mass_floor, file.stable_dt_s) = (1.0, 1.0);
        // soft tissue is heavy enough without a mass floor
        file.params.youngs_modulus_pa *= 10.0;
    });
    assert_eq!(opened(&Budget::M4F_168, light), Err(Refusal::PatchStep), "a fifth of its floor");
    for friction in [f32::NAN, -1.0, 5.1] {
        let rubs = changed(|file| file.params.friction = friction);
        assert_eq!(opened(&Budget::M7_480, rubs), Err(Refusal::PatchInvalid), "{friction}");
    }
    let stiffens = changed(|file| file.params.stiffening_b = 3.0);
    assert_eq!(opened(&Budget::M7_480, stiffens), Err(Refusal::PatchCost), "the image does not know the term");
}

fn checked(bytes: &'static [u8]) -> Result<(), BuildError> {
    let mut memory = Box::new(Memory::RESERVED);
    Patch::open_within(&Budget::M7_480, bytes, &mut memory, None, &mut || {}).map(|_| ())
}

#[test]
fn sixteen_foundation_points_on_a_triangle_are_refused() {
    let with = |points: usize| {
        let model = PatchFile::open(&BLOCK.0).unwrap().model;
        let share = model.points_per_triangle() as f32 / points as f32;
        let laws = model.foundation.chunks(model.points_per_triangle());
        let laws = laws.flat_map(|laws| std::vec![FoundationPoint { k: share * laws[0].k }; points]).collect();
        let laws = Vec::leak(laws);
        changed(|file| file.model.foundation = laws)
    };
    assert_eq!(opened(&Budget::M7_480, with(9)), Ok(()));
    assert_eq!(opened(&Budget::M7_480, with(16)), Err(Refusal::PatchTooLarge), "an image does not know sixteen");
}

#[test]
fn a_foundation_much_stiffer_than_the_tissue_is_refused() {
    let times = |factor: f32, more: f32| {
        let mut points = PatchFile::open(&BLOCK.0).unwrap().model.foundation.to_vec();
        points.iter_mut().for_each(|point| point.k *= factor);
        let points = Vec::leak(points);
        changed(|file| (file.model.foundation, file.model.stiffening_per_m) = (points, more * file.model.stiffening_per_m))
    };
    assert_eq!(checked(times(1.0, 1.0)), Ok(()));
    for (factor, more) in [(1e3, 1.0), (1.0, 1e4), (f32::MAX, 1.0)] {
        let error = checked(times(factor, more)).unwrap_err();
        assert!(matches!(error, BuildError::OutOfRange { parameter: step::CONTACT, .. }), "{factor} {more}: {error:?}");
        assert_eq!(Refusal::from(error), Refusal::PatchStep);
    }
}

/// If the springs between nodes of equal parity are almost absent, the mesh becomes bipartite: the
/// contribution of the neighbours can reverse a node's acceleration, and the two-term approximation
/// of the inverse mass matrix is no longer positive definite.
#[test]
fn neighbours_that_outweigh_a_node_are_refused() {
    let weaker = |factor: f32| {
        let mut springs = PatchFile::open(&RELATIVE.0).unwrap().model.springs.to_vec();
        for spring in springs.iter_mut().filter(|spring| (spring.i ^ spring.j) & 1 == 0) {
            (spring.k, spring.k_rest) = (factor * spring.k, factor * spring.k_rest);
        }
        // softened, since the patch would otherwise be refused first for its foundation at nodes
        // with weak springs
        let mut points = PatchFile::open(&RELATIVE.0).unwrap().model.foundation.to_vec();
        points.iter_mut().for_each(|point| point.k *= 0.5);
        let (springs, points) = (Vec::leak(springs), Vec::leak(points));
        changed_of(&RELATIVE.0, |file| (file.model.springs, file.model.foundation) = (springs, points))
    };
    assert_eq!(checked(weaker(1.0)), Ok(()));
    let error = checked(weaker(1e-4)).unwrap_err();
    assert!(matches!(error, BuildError::OutOfRange { parameter: step::SERIES, .. }), "{error:?}");
    assert_eq!(Refusal::from(error), Refusal::PatchStep);
}

#[test]
fn a_site_off_the_surface_an_axis_into_it_and_a_press_through_the_patch_are_refused() {
    let aside = changed(|file| file.site_m.x += 1.0);
    let upside_down = changed(|file| file.params.probe.axis = -file.params.probe.axis);
    let through = changed(|file| file.model.depth_limit_m = 1.0);
    for bytes in [aside, upside_down, through] {
        assert_eq!(opened(&Budget::M4F_168, bytes), Err(Refusal::PatchSite));
    }
}

#[test]
fn a_patch_without_rows_would_have_no_springs_on_the_board() {
    let bytes = changed(|file| file.model.spring_rows = &[]);
    assert_eq!(opened(&Budget::M4F_168, bytes), Err(Refusal::PatchTooLarge));
}

#[test]
fn tissue_softens_at_once_and_stiffens_when_nothing_touches() {
    let mut memory = Box::new(Memory::RESERVED);
    let mut patch = Patch::open(&BLOCK.0, &mut memory, None).unwrap();
    let packed_pa = patch.packed_pa;
    let now_pa = |patch: &Patch<'_>| (patch.params.youngs_modulus_pa, patch.tuned.youngs_modulus_pa());
    patch.ask_modulus(1.5 * packed_pa).unwrap();
    for _ in 0..3 {
        patch.settle(true);
        assert_eq!(now_pa(&patch), (packed_pa, packed_pa), "stiffened under the hand");
    }
    patch.settle(false);
    assert_eq!(now_pa(&patch), (1.5 * packed_pa, 1.5 * packed_pa));
    patch.ask_modulus(0.75 * packed_pa).unwrap();
    patch.settle(true);
    assert_eq!(now_pa(&patch), (0.75 * packed_pa, 0.75 * packed_pa));
    assert_eq!(patch.tuned.most_pressed, 15, "and the bound on its time stays");
    for beyond in [2.001 * packed_pa, 0.499 * packed_pa, f32::NAN, -packed_pa] {
        assert!(patch.ask_modulus(beyond).is_err(), "{beyond}");
    }
}

/// Anywhere on the surface, the probe reaches its depth without pressing more triangles than were
/// counted at rest.
#[test]
fn a_press_anywhere_presses_no_more_triangles_than_are_counted() {
    let deepest_m = 0.8 * PatchFile::open(&BLOCK.0).unwrap().model.depth_limit_m;
    let presses = |most| {
        let mut memory = Box::new(Memory::RESERVED);
        let mut patch = Patch::open(&BLOCK.0, &mut memory, None).unwrap();
        patch.tuned.most_pressed = most;
        let mut limited = 0;
        for place in 0..25 {
            let aside_m = Vector3::new((place % 5 - 2) as f32, (place / 5 - 2) as f32, 0.0) * 2e-3;
            patch.rest();
            let mut seen = ClampFlags::DEFAULT;
            for tick in -20..60 {
                let down_m = deepest_m * (tick.min(40) as f32 / 40.0);
                seen.set(patch.render(ProbePose { tip_m: aside_m - Vector3::z() * down_m }).limiters);
            }
            limited += u8::from(seen.contains(ClampFlags::DEPTH));
        }
        limited
    };
    assert_eq!(presses(15), 0);
    assert!(presses(5) > 10, "and with five it does");
}

#[test]
fn a_modulus_from_half_to_twice_the_packed_one_is_taken_with_the_patch() {
    let packed_pa = PatchFile::open(&BLOCK.0).unwrap().params.youngs_modulus_pa;
    let with = |pascal| {
        let mut memory = Box::new(Memory::RESERVED);
        Patch::open(&BLOCK.0, &mut memory, Some(pascal)).map(|patch| patch.tuned.youngs_modulus_pa()).map_err(Refusal::from)
    };
    for right in [0.5, 0.501, 1.5, 2.0] {
        assert_eq!(with(right * packed_pa), Ok(right * packed_pa));
    }
    for wrong in [0.499, 2.001, -1.0, f32::NAN] {
        assert_eq!(with(wrong * packed_pa), Err(Refusal::ModulusOutOfRange), "{wrong}");
    }
}

#[test]
fn a_press_is_answered_in_the_devices_frame() {
    let mut memory = Box::new(Memory::RESERVED);
    let patch = Patch::open(&LIVER.0, &mut memory, None).unwrap();
    let axis = patch.params.probe.axis;
    assert!(axis.z < 0.92 && patch.placement.to_patch(Vector3::zeros()).norm() > 10e-3, "{axis}: told apart from the device's");
    let mut tissue = PatchSlot(Some(patch));
    let mut high = |z_m: f32| tissue.render(ProbePose { tip_m: Vector3::new(0.0, 0.0, z_m) });
    (0..200_u8).for_each(|n| _ = high(6e-3 - 40e-6 * f32::from(n)));
    let pressed = (0..200).map(|_| high(-2e-3)).last().unwrap();
    assert_eq!(pressed.fault, None);
    let upwards = |v: Vector3<f32>| v.z / v.norm();
    assert!(pressed.force_n.norm() > 0.02 && upwards(pressed.force_n) > 0.97, "{pressed:?}");
    assert!(upwards(pressed.normal) > 0.97 && (pressed.normal.norm() - 1.0).abs() < 1e-3, "{pressed:?}");
    assert!(pressed.point_m.norm() < 6e-3, "{pressed:?}");
}

#[test]
fn without_a_patch_a_tick_is_a_fault_and_there_is_no_state() {
    let mut tissue = PatchSlot(None);
    let output = tissue.render(ProbePose { tip_m: Vector3::zeros() });
    assert_eq!((output.fault, output.force_n), (Some(Fault::SizeMismatch), Vector3::zeros()));
    assert_eq!(tissue.state(), (0, 0));
    assert_eq!(tissue.ask_modulus(1e3, f32::MAX), Err(Refusal::NoPatch));
}

#[test]
fn the_state_is_that_of_the_patch_and_a_press_changes_it() {
    let mut memory = Box::new(Memory::RESERVED);
    let patch = Patch::open(&BLOCK.0, &mut memory, None).unwrap();
    let (nodes, hash) = (patch.model.nodes.len(), patch.state_hash());
    let mut tissue = PatchSlot(Some(patch));
    assert_eq!(tissue.state(), (nodes, hash));
    (0..200_u8).for_each(|n| _ = tissue.render(ProbePose { tip_m: Vector3::new(0.0, 0.0, 6e-3 - 40e-6 * f32::from(n)) }));
    assert_eq!(tissue.state().0, nodes);
    assert_ne!(tissue.state().1, hash);
}

#[test]
fn a_patch_that_only_its_packed_modulus_keeps_stable_is_refused() {
    let mut refused_for_twice = 0;
    for n in 0..20_u8 {
        // only the tissue's own mass, without a mass floor
        let bytes = changed(|file| {
            (file.params.mass_floor, file.stable_dt_s) = (1e-6, 1.0);
            file.params.youngs_modulus_pa *= 8.0 * 0.7_f32.powi(n.into());
        });
        let file = PatchFile::open(bytes).unwrap();
        let stable = |share: f32| {
            let params = Params { youngs_modulus_pa: share * file.params.youngs_modulus_pa, ..file.params };
            let mut memory = Box::new(Memory::RESERVED);
            let (tuned, scratch) = memory.judge(&file.model, &params, &mut || {}).unwrap();
            step::check(&file.model, &params, &tuned, scratch, &mut || {}).is_ok()
        };
        assert_eq!(opened(&Budget::M4F_168, bytes).is_ok(), stable(2.0), "{} Pa", file.params.youngs_modulus_pa);
        refused_for_twice += usize::from(stable(1.0) && !stable(2.0));
    }
    assert!(refused_for_twice > 0);
}

#[test]
fn a_patch_comes_to_rest_in_the_tick_after_it_was_asked_to() {
    let mut memory = Box::new(Memory::RESERVED);
    let mut tissue = PatchSlot(Some(Patch::open(&BLOCK.0, &mut memory, None).unwrap()));
    let at_rest = tissue.state();
    let mut pressed = Output::NONE;
    for n in 0..200_u8 {
        pressed = tissue.render(ProbePose { tip_m: Vector3::new(0.0, 0.0, 6e-3 - 40e-6 * f32::from(n)) });
    }
    assert!(pressed.force_n.z > 0.0 && tissue.state() != at_rest);
    tissue.reset();
    let down = ProbePose { tip_m: Vector3::new(0.0, 0.0, -2e-3) };
    assert_eq!(tissue.render(down), Output::NONE, "at rest in place of an answer");
    assert_eq!(tissue.state(), at_rest);
    let next = tissue.render(down);
    assert_eq!(next.force_n, Vector3::zeros(), "inside it from the start");
    assert!(next.limiters.contains(palpate::ClampFlags::BURIED));
}

#[test]
fn a_modulus_asked_of_the_tissue_is_taken_between_two_ticks() {
    let mut memory = Box::new(Memory::RESERVED);
    let patch = Patch::open(&BLOCK.0, &mut memory, None).unwrap();
    let packed_pa = patch.packed_pa;
    let mut tissue = PatchSlot(Some(patch));
    tissue.ask_modulus(0.8 * packed_pa, f32::MAX).unwrap();
    tissue.settle(true);
    assert_eq!(tissue.0.as_ref().unwrap().tuned.youngs_modulus_pa(), 0.8 * packed_pa);
}
