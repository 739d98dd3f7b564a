//! Pressed slides: fast, strong, in many directions.

use palpate::Fault;

use crate::rig::{CLEAR_M, Rig};

/// Patches, and for each the largest distance from the site at which a slide begins on its top [m].
const PATCHES: [(&str, f32); 5] = [
    ("firmware/patches/block-m4f-168.patch", 10e-3),
    ("firmware/patches/liver-m4f-168.patch", 10e-3),
    ("firmware/patches/block-m7-480.patch", 30e-3),
    ("firmware/patches/nodule-m7-480.patch", 30e-3),
    ("host-sim/patches/block-410.patch", 30e-3),
];

/// A slide through the site: depth [m], speed [m/s], acceleration [m/s^2], angle to the tangent
/// [rad], and the distances from the site at which it begins and ends [m].
#[derive(Clone, Copy, Debug)]
struct Slide {
    depth_m: f32,
    m_per_s: f32,
    m_per_s2: f32,
    turned: f32,
    from_m: f32,
    to_m: f32,
}

/// Presses at one end, slides to the other, lifts off, and returns the largest force of the slide
/// [N].
fn slide(rig: &mut Rig, slide: &Slide) -> Result<f32, Fault> {
    let (site_m, normal, heading) = (rig.site_m, rig.normal, rig.heading(slide.turned));
    let at = |along_m: f32, out_m: f32| site_m + heading * along_m + normal * out_m;
    rig.m_per_s2 = 60.0;
    rig.go(at(-slide.from_m, CLEAR_M), 1.0)?;
    rig.go(at(-slide.from_m, -slide.depth_m), 0.2)?;
    rig.m_per_s2 = slide.m_per_s2;
    let most_n = rig.go(at(slide.to_m, -slide.depth_m), slide.m_per_s)?;
    rig.go(at(slide.to_m, CLEAR_M), 0.3)?;
    Ok(most_n)
}

#[test]
fn pressed_slides_up_to_the_speed_limit_are_no_fault() {
    let (mut runs, mut felt, mut stopped) = (0, 0, Vec::new());
    for (patch, top_m) in PATCHES {
        for youngs_modulus_pa in [20e3, 50e3, 100e3] {
            let armed = || Rig::armed(patch, youngs_modulus_pa, 55e-6);
            let mut rig = armed();
            for m_per_s in [0.5, 1.0, 1.45] {
                for depth_m in [2e-3, 4e-3, 7e-3] {
                    // to the other end of the top, and over its edge
                    for (to_m, m_per_s2) in [(top_m, 60.0), (top_m, 20.0), (50e-3, 60.0), (50e-3, 20.0)] {
                        for turned in [0.0, 2.0, 4.1] {
                            let tried = Slide { depth_m, m_per_s, m_per_s2, turned, from_m: top_m, to_m };
                            runs += 1;
                            match slide(&mut rig, &tried) {
                                Ok(most_n) => felt += i32::from(most_n > 0.5),
                                Err(fault) => {
                                    stopped.push(format!("{patch}, {youngs_modulus_pa} Pa, {tried:?}: {fault}"));
                                    rig = armed();
                                }
                            }
                        }
                    }
                }
            }
        }
    }
    assert!(stopped.is_empty(), "{} of {runs}: {:#?}", stopped.len(), &stopped[..stopped.len().min(20)]);
    assert!(felt > 3 * runs / 4, "{felt} of {runs} slides were felt");
}
