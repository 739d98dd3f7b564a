//! A probe with friction, on a shipped patch: the force opposes the sliding direction by mu times
//! the push and ends with the contact, and a patch file carries the coefficient.

use palpate::{MOST_TERMS, PatchFile, ProbeShape, PronyTerm, Vector3};

use super::guard::Tissue;
use super::relaxation::{TERMS, written};

#[test]
fn friction_opposes_the_way_and_ends_with_the_contact() {
    for relaxation in [[PronyTerm::NONE; MOST_TERMS], TERMS] {
        let mut tissue = Tissue::with(|params| (params.friction, params.relaxation) = (0.5, relaxation));
        let mut last = tissue.press(3e-3);
        let push_n = last.force_n.dot(&last.normal);
        assert!((last.grip_n / push_n - 0.5).abs() < 0.05, "{last:?}");
        let mut aside_m = 0.0;
        for (displacement_m, ticks) in [(1e-5_f32, 400), (-1e-5, 800)] {
            for _ in 0..ticks {
                aside_m += displacement_m;
                last = tissue.at(Vector3::new(aside_m, 0.0, -3e-3));
            }
            let push_n = last.force_n.dot(&last.normal);
            let along_n = last.force_n - last.normal * push_n;
            assert!(along_n.x * displacement_m < 0.0 && along_n.norm() > 0.45 * push_n, "by {displacement_m}: {last:?}");
            assert!(along_n.norm() <= last.grip_n * 1.0001, "{last:?}");
        }
        let away = tissue.high(2e-2);
        assert_eq!((away.force_n, away.grip_n), (Vector3::zeros(), 0.0));
    }
}

/// With an encoder the probe moves by counts: it jumps, and then rests until the next count.
#[test]
fn a_slide_by_counts_bears_what_a_smooth_one_bears() {
    for (shape, depth_m) in [(ProbeShape::Hemisphere, 2e-3), (ProbeShape::Flat, 0.5e-3)] {
        for (friction, relaxation) in [(0.1, [PronyTerm::NONE; MOST_TERMS]), (0.4, TERMS), (0.4, [PronyTerm::NONE; MOST_TERMS])] {
            for speed_m_per_s in [1e-3_f32, 3e-3, 20e-3] {
                let dragged = |count_m: f32| {
                    let mut tissue = Tissue::with(|p| (p.friction, p.relaxation, p.probe.shape) = (friction, relaxation, shape));
                    tissue.press(depth_m);
                    let (mut along_n, mut push_n) = (0.0, 0.0);
                    let ticks = (4.0 / speed_m_per_s.max(2e-3)) as u16;
                    for n in 0..ticks {
                        let aside_m = speed_m_per_s * 1e-3 * f32::from(n);
                        let seen_m = if count_m > 0.0 { libm::floorf(aside_m / count_m) * count_m } else { aside_m };
                        let felt = tissue.at(Vector3::new(seen_m, 0.0, -depth_m)).force_n;
                        if n > ticks / 2 {
                            (along_n, push_n) = (along_n - felt.x, push_n + felt.z);
                        }
                    }
                    along_n / push_n
                };
                let smooth = dragged(0.0);
                for count_m in [10e-6, 55e-6] {
                    let by_counts = dragged(count_m);
                    let case = (shape, friction, speed_m_per_s, count_m);
                    assert!((by_counts - smooth).abs() < 0.1 * friction, "{case:?}: {by_counts}, smooth {smooth}");
                }
            }
        }
    }
}

#[test]
fn the_push_is_reported_apart_from_friction() {
    let mut tissue = Tissue::with(|params| params.friction = 0.8);
    tissue.press(3e-3);
    let slid = (1..=300_u16).map(|n| tissue.at(Vector3::new(1e-5 * f32::from(n), 0.0, -3e-3))).last().expect("ticks");
    // the normal is that of the surface, and the depth is along it
    assert!(slid.normal.z > 0.96, "{slid:?}");
    assert!((slid.depth_m - 3e-3).abs() < 0.3e-3, "{slid:?}");
}

#[test]
fn the_longest_force_clamps_push_and_friction_as_one() {
    let [slid, free] = [0.05, 5.0].map(|max_force_n| {
        let mut tissue = Tissue::with(|params| (params.friction, params.limits.max_force_n) = (0.8, max_force_n));
        tissue.press(3e-3);
        (1..=300_u16).map(|n| tissue.at(Vector3::new(1e-5 * f32::from(n), 0.0, -3e-3))).last().expect("ticks")
    });
    assert!((slid.force_n.norm() - 0.05).abs() < 1e-6 && slid.force_n.x < -0.02, "{slid:?}");
    let share = 0.05 / free.force_n.norm();
    assert!(share < 0.9 && (slid.grip_n / (share * free.grip_n) - 1.0).abs() < 1e-3, "{slid:?} of {free:?}");
}

#[test]
fn a_patch_file_carries_the_coefficient() {
    let mut file = Tissue::new().file;
    let plain = written(&file);
    file.params.friction = 0.5;
    let rubs = written(&file);
    assert_eq!(rubs.len(), plain.len() + 1, "a word more, and the others as they were");
    let bytes: &[u8] = bytemuck::cast_slice(&rubs);
    let read = PatchFile::open(bytes).unwrap().params;
    assert_eq!((read.friction, read.relaxation), (0.5, [PronyTerm::NONE; MOST_TERMS]));
    assert!(PatchFile::open(&bytes[..bytes.len() - 4]).is_err(), "cut");
    file.params.relaxation = TERMS;
    let words = written(&file);
    let both = PatchFile::open(bytemuck::cast_slice(&words)).unwrap().params;
    assert_eq!((both.friction, both.relaxation), (0.5, TERMS));
    (file.params.terms.friction, file.params.terms.relaxation) = (false, false);
    assert_eq!(written(&file), plain, "a term that is off is not packed");
}
