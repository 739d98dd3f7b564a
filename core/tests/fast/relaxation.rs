//! Tissue that relaxes, on a shipped patch: a hold fades as in the closed form, a probe that leaves
//! finds a dent, and a patch file carries shares and times.

use palpate::{MOST_TERMS, PatchFile, PronyTerm};

use super::guard::Tissue;

pub const TERMS: [PronyTerm; MOST_TERMS] =
    [PronyTerm { share: 0.2, time_s: 0.02 }, PronyTerm { share: 0.26, time_s: 0.4 }, PronyTerm { share: 0.2, time_s: 4.4 }];

/// Share of a force that remains at this time after it was applied [s].
fn left(t_s: f32) -> f32 {
    TERMS.iter().fold(1.0, |left, term| left - term.share * (1.0 - libm::expf(-t_s / term.time_s)))
}

/// Presses 3 mm deep within some ticks and holds; returns the force of every tick [N].
fn held(terms: [PronyTerm; MOST_TERMS]) -> Vec<f32> {
    let mut tissue = Tissue::with(|params| params.relaxation = terms);
    tissue.high(5e-3);
    (0..2000_u16).map(|n| tissue.high((1e-3 - 2e-4 * f32::from(n)).max(-3e-3)).force_n.norm()).collect()
}

#[test]
fn a_hold_fades_as_the_closed_form() {
    let (elastic, relaxing) = (held([PronyTerm::NONE; MOST_TERMS]), held(TERMS));
    for n in [200_u16, 400, 1000, 1999] {
        // the mean time of loading is tick 15
        let expected = left((f32::from(n) - 15.0) * 1e-3);
        let found = relaxing[usize::from(n)] / elastic[usize::from(n)];
        assert!((found / expected - 1.0).abs() < 0.01, "tick {n}: {found} for {expected}");
    }
    assert!((relaxing[20] / elastic[20] - 1.0).abs() < 0.15, "at once it is the elastic force");
}

#[test]
fn a_probe_that_leaves_loses_the_tissue_before_the_surface() {
    let mut tissue = Tissue::with(|params| params.relaxation = TERMS);
    tissue.press(3e-3);
    (0..2000).for_each(|_| _ = tissue.high(-3e-3));
    let lost = (0..150_u16).find(|n| tissue.high(-3e-3 + 2e-5 * f32::from(*n)).force_n.norm() == 0.0).expect("it is lost");
    // elastic tissue stays in contact up to the surface, tick 150
    assert!((60..120).contains(&lost), "tick {lost}");
    // and the probe gets no force until it meets the dent again
    let above = tissue.high(-0.5e-3);
    assert_eq!((above.force_n.norm(), above.fault), (0.0, None));
    assert!(tissue.press(3e-3).force_n.norm() > 0.02);
}

#[test]
fn a_patch_file_carries_shares_and_times() {
    let mut file = Tissue::new().file;
    let plain = written(&file);
    file.params.relaxation = TERMS;
    let relaxing = written(&file);
    assert_eq!(relaxing.len(), plain.len() + 6, "six words more, and the others as they were");
    let bytes: &[u8] = bytemuck::cast_slice(&relaxing);
    assert_eq!(PatchFile::open(bytes).unwrap().params.relaxation, TERMS);
    assert!(PatchFile::open(&bytes[..bytes.len() - 4]).is_err(), "cut");
    file.params.terms.relaxation = false;
    assert_eq!(written(&file), plain, "a term that is off is not packed");
}

pub fn written(file: &PatchFile<'_>) -> Vec<u32> {
    let mut bytes = Vec::new();
    file.write(|piece| bytes.extend_from_slice(piece));
    bytes.chunks_exact(4).map(|word| u32::from_ne_bytes([word[0], word[1], word[2], word[3]])).collect()
}
