//! Remedies for a scene whose contact a board would refuse. The refusal names those of the patch as
//! it is meshed; another tip or depth gets another mesh, so each is packed before it is offered.

use palpate_controller::link::Refusal;
use palpate_controller::refusal::contact::{TooNarrow, TooStiff};
use palpate_tissue::scene::{Drive, Scene};
use palpate_tissue::tissue::DEPTH_MARGIN;

/// Factors on a wider radius that are tried in turn (1): elements grow with the radius.
const WIDER: [f64; 5] = [1.0, 1.25, 1.6, 2.0, 2.5];
/// Factors on a softer modulus that are tried in turn (1).
const SOFTER: [f64; 3] = [1.0, 0.97, 0.9];

/// The refusal with those remedies alone for which `packs` accepts the changed scene.
pub(super) fn tried(refusal: Refusal, scene: &Scene, packs: &dyn Fn(&Scene) -> bool) -> Refusal {
    let changed = |change: &dyn Fn(&mut Scene)| {
        let mut scene = scene.clone();
        change(&mut scene);
        packs(&scene)
    };
    match refusal {
        Refusal::ContactStiff(why) => {
            let softer = SOFTER.map(|factor| (factor * f64::from(why.softer_pa)) as u32);
            let softer_pa = softer.into_iter().find(|pa| *pa > 0 && changed(&|scene| soften(scene, *pa))).unwrap_or(0);
            let deepest_m = f64::from(why.shallower_um) * 1e-6 / DEPTH_MARGIN;
            let shallower = deepest_m > 0.0 && hold_at_most(&mut scene.clone(), deepest_m);
            let shallower = shallower && changed(&|scene| _ = hold_at_most(scene, deepest_m));
            Refusal::ContactStiff(TooStiff { softer_pa, shallower_um: if shallower { why.shallower_um } else { 0 }, ..why })
        }
        Refusal::TipNarrow(why) => {
            let wider = WIDER.map(|factor| {
                let wider_um = (factor * f64::from(why.wider_um) * 1e-2).ceil() as u32 * 100;
                // a contact becomes stiffer at most in proportion to its width
                let softer_pa = (f64::from(why.softer_pa) / factor) as u32;
                TooNarrow { wider_um, softer_pa, ..why }
            });
            let packs = |tip: &TooNarrow| {
                let widen = |scene: &mut Scene| {
                    scene.probe.radius_m = f64::from(tip.wider_um) * 1e-6;
                    if tip.softer_pa > 0 {
                        soften(scene, tip.softer_pa);
                    }
                };
                tip.wider_um > 0 && changed(&widen)
            };
            let found = wider.into_iter().find(packs);
            Refusal::TipNarrow(found.unwrap_or(TooNarrow { wider_um: 0, softer_pa: 0, ..why }))
        }
        other => other,
    }
}

fn soften(scene: &mut Scene, pascal: u32) {
    scene.tissue.youngs_modulus_pa = f64::from(pascal);
}

/// Limits the holds; false if the scene's drive has no depths.
fn hold_at_most(scene: &mut Scene, deepest_m: f64) -> bool {
    let (Drive::Depth { holds_m, .. } | Drive::Hand { holds_m, .. }) = &mut scene.drive else { return false };
    holds_m.iter_mut().for_each(|hold_m| *hold_m = hold_m.min(deepest_m));
    true
}
