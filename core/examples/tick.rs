//! Opens a patch file, and presses the patch 2 mm deep with its ticks alone.

use palpate::{BuildError, Memory, PatchFile, ProbePose, tick};

/// Aligns the bytes of a patch file to 4 bytes, because the file is read in place as words.
#[repr(C, align(4))]
struct Words<B: ?Sized>(B);
static PATCH: &Words<[u8]> = &Words(*include_bytes!(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/block-m4f-168.patch")));

fn main() -> Result<(), BuildError> {
    let PatchFile { model, params, site_m, .. } = PatchFile::open(&PATCH.0)?;
    let mut memory = Memory::<64, 128, 0, 0>::RESERVED;
    let (tuned, mut state) = memory.start(&model, &params)?;
    // moves from 1 mm above the tissue to 2 mm below its surface at 40 mm/s, then rests there
    let mut force_n = 0.0;
    for n in 0..400_u16 {
        let depth_m = (4e-5 * f32::from(n) - 1e-3).min(2e-3);
        let tip_m = site_m - params.probe.axis * depth_m;
        let output = tick(&model, &tuned, &mut state, ProbePose { tip_m });
        assert_eq!(output.fault, None);
        force_n = output.force_n.z;
    }
    // the finite-element reference is 0.0492 N
    assert!((force_n / 0.0492 - 1.0).abs() < 0.02, "{force_n} N");
    Ok(())
}
