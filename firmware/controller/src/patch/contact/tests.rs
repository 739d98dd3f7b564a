use std::boxed::Box;
use std::string::ToString;
use std::vec::Vec;

use palpate::{PatchFile, ProbeShape};

use super::*;
use crate::patch::{Budget, Memory, WordAligned};

static BLOCK: &WordAligned<[u8]> = &WordAligned(*include_bytes!("../../../../patches/block-m4f-168.patch"));
static FINE: &WordAligned<[u8]> = &WordAligned(*include_bytes!("../../../../patches/block-m7-480.patch"));
static NODULE: &WordAligned<[u8]> = &WordAligned(*include_bytes!("../../../../patches/nodule-m7-480.patch"));
static LIVER: &WordAligned<[u8]> = &WordAligned(*include_bytes!("../../../../patches/liver-m4f-168.patch"));

/// A patch after a change of its file, aligned to words.
fn changed(bytes: &[u8], change: impl FnOnce(&mut PatchFile<'_>)) -> (Vec<u32>, usize) {
    let mut file = PatchFile::open(bytes).unwrap();
    change(&mut file);
    let mut bytes = Vec::new();
    file.write(|part| bytes.extend_from_slice(part));
    let mut words = std::vec![0_u32; bytes.len().div_ceil(4)];
    bytemuck::cast_slice_mut(&mut words)[..bytes.len()].copy_from_slice(&bytes);
    (words, bytes.len())
}

/// Opens a patch after a change of its file, for a device with this ceiling.
fn opened(bytes: &[u8], ceiling_n_per_m: f32, change: impl FnOnce(&mut PatchFile<'_>)) -> Result<(f32, u64), Refusal> {
    let (words, length) = changed(bytes, change);
    let mut memory = Box::new(Memory::RESERVED);
    let bytes = &bytemuck::cast_slice(&words)[..length];
    let patch = Patch::open_for(&Budget::M7_480, ceiling_n_per_m, bytes, &mut memory, None, &mut || {})?;
    Ok((patch.stiffness_n_per_m(), patch.state_hash()))
}

#[test]
fn whatever_is_refused_is_accepted_with_each_remedy_that_is_named() {
    let (mut accepted, mut stiff, mut narrow, mut shallower, mut both) = (0, 0, 0, 0, 0);
    for bytes in [&BLOCK.0, &FINE.0, &NODULE.0, &LIVER.0] {
        for (shape, radius_m) in [(ProbeShape::Hemisphere, 8e-3), (ProbeShape::Sphere, 6e-3), (ProbeShape::Flat, 8e-3)] {
            for pascal in [3.5e3, 20e3, 50e3, 100e3] {
                for ceiling_n_per_m in [400.0, 1_500.0] {
                    let case = std::format!("{shape:?} {pascal} Pa {ceiling_n_per_m} N/m");
                    let tipped = |file: &mut PatchFile<'_>| {
                        (file.params.probe.shape, file.params.probe.radius_m) = (shape, radius_m);
                        // with masses for every modulus; a press at rest does not depend on them
                        (file.params.youngs_modulus_pa, file.params.mass_floor) = (pascal, 10.0);
                    };
                    let open = |change: &dyn Fn(&mut PatchFile<'_>)| {
                        opened(bytes, ceiling_n_per_m, |file| {
                            tipped(file);
                            change(file);
                        })
                    };
                    match open(&|_| {}) {
                        Ok((n_per_m, _)) => {
                            assert!(n_per_m > 0.0 && n_per_m <= ceiling_n_per_m, "{case}: {n_per_m}");
                            accepted += 1;
                        }
                        Err(Refusal::ContactStiff(why)) => {
                            assert!(why.n_per_m as f32 >= ceiling_n_per_m, "{case}: {why}");
                            let softer_pa = why.softer_pa as f32;
                            assert!(softer_pa < pascal && softer_pa > 0.9 * pascal * ceiling_n_per_m / (why.n_per_m + 1) as f32);
                            let softer = |file: &mut PatchFile<'_>| file.params.youngs_modulus_pa = softer_pa;
                            open(&softer).unwrap();
                            if why.shallower_um > 0 {
                                open(&|file| file.model.depth_limit_m = why.shallower_um as f32 * 1e-6).unwrap();
                                shallower += 1;
                            }
                            stiff += 1;
                        }
                        Err(Refusal::TipNarrow(why)) => {
                            assert!(why.contact_um < why.least_um && why.wider_um > 0, "{case}: {why}");
                            open(&|file| {
                                file.params.probe.radius_m = why.wider_um as f32 * 1e-6;
                                if why.softer_pa > 0 {
                                    file.params.youngs_modulus_pa = why.softer_pa as f32;
                                }
                            })
                            .unwrap();
                            narrow += 1;
                            both += u32::from(why.softer_pa > 0);
                        }
                        Err(other) => panic!("{case}: {other}"),
                    }
                }
            }
        }
    }
    assert!(accepted > 40 && stiff > 20 && narrow > 20 && shallower > 3 && both > 10);
}

#[test]
fn a_measurement_leaves_the_patch_at_rest_and_serves_every_later_device() {
    let mut memory = Box::new(Memory::RESERVED);
    let mut patch = Patch::open(&FINE.0, &mut memory, None).unwrap();
    let at_rest = patch.state_hash();
    let mut rounds = 0;
    patch.check_contact(400.0, &mut || rounds += 1).unwrap();
    assert!(rounds > 200, "{rounds}");
    assert_eq!(patch.state_hash(), at_rest);
    let stiffness_n_per_m = patch.stiffness_n_per_m();
    patch.check_contact(1.001 * stiffness_n_per_m, &mut || panic!("measured before")).unwrap();
    assert!(matches!(patch.check_contact(0.999 * stiffness_n_per_m, &mut || {}), Err(Refusal::ContactStiff(_))));
    assert_eq!(patch.state_hash(), at_rest);
    let pascal = patch.params.youngs_modulus_pa;
    assert_eq!(patch.check_modulus(1.5 * pascal, 1.51 * stiffness_n_per_m), Ok(()));
    assert!(matches!(patch.check_modulus(1.5 * pascal, 1.49 * stiffness_n_per_m), Err(Refusal::ContactStiff(_))));
}

#[test]
fn a_refusal_names_figure_limit_and_remedies_in_one_line() {
    let stiff = opened(&FINE.0, 400.0, |file| file.params.youngs_modulus_pa = 100e3).unwrap_err().to_string();
    assert!(stiff.contains("N/m stiff") && stiff.contains("renders 400 N/m"), "{stiff}");
    assert!(stiff.contains("take at most 24.") && stiff.contains("kPa"), "{stiff}");
    let narrow = |softer_pa| TooNarrow { contact_um: 3_000, least_um: 3_340, wider_um: 3_400, softer_pa }.to_string();
    assert!(
        narrow(0).ends_with(
            "take a tip with a radius of at least 3.40 mm, or smaller elements (more nodes, which a faster board has time for)"
        ),
        "{}",
        narrow(0)
    );
    assert!(narrow(20_050).contains("3.40 mm on at most 20.05 kPa"), "{}", narrow(20_050));
    for text in [stiff, narrow(0)] {
        assert_eq!(text.lines().count(), 1);
    }
}

#[test]
fn a_tip_that_meets_no_resistance_is_refused() {
    // a sphere that passes between the points of an element
    let through = opened(&LIVER.0, 1e5, |file| {
        (file.params.probe.shape, file.params.probe.radius_m) = (ProbeShape::Sphere, 5e-3);
        file.model.depth_limit_m = 9e-3;
    });
    assert_eq!(through, Err(Refusal::PatchSite));
}
