use palpate::{MOST_TERMS, PronyTerm, RimEdge, RimNode};

use super::*;
use crate::patch::WordAligned;

/// Patches with four and with nine foundation points per triangle.
static FOUR: &WordAligned<[u8]> = &WordAligned(*include_bytes!("../../../../patches/block-m7-480.patch"));
static NINE: &WordAligned<[u8]> = &WordAligned(*include_bytes!("../../../../patches/block-m4f-168.patch"));

/// Cycles per tick, given those per spring, per node and per pressed triangle.
fn by_hand(file: &PatchFile<'_>, touched: f64, [spring, node, triangle]: [f64; 3]) -> f64 {
    let model = &file.model;
    let counts = [model.springs.len(), model.tets.len(), model.nodes.len(), model.rim_nodes.len(), model.rim_edges.len()];
    assert!(counts.iter().all(|count| *count > 0), "{counts:?}");
    let substep: f64 = counts.iter().zip([spring, 215.0, node, 75.0, 99.0]).map(|(count, each)| *count as f64 * each).sum();
    2300.0 + 61.0 * model.triangles.len() as f64 + f64::from(file.params.substeps) * (substep + touched * triangle)
}

#[test]
fn every_item_of_a_patch_is_counted_once_per_substep() {
    for (bytes, points) in [(FOUR, 4), (NINE, 9)] {
        let mut file = PatchFile::open(&bytes.0).unwrap();
        file.model.rim_nodes = &[RimNode { node: 0, block_m: [0.0; 6] }; 11];
        file.model.rim_edges = &[RimEdge { node: [0, 1], block_m: [0.0; 9] }; 23];
        assert_eq!(file.model.points_per_triangle(), points);
        let pressed = 840.0 + 160.0 * (points as f64 - 4.0);
        for (relative, smooth, spring, node) in
            [(true, true, 150.0, 240.0), (true, false, 150.0, 240.0), (false, true, 80.0, 164.0), (false, false, 80.0, 130.0)]
        {
            for substeps in [1, 3] {
                for (fading, rubs, more_node, more_triangle) in
                    [(0, false, 0.0, 0.0), (1, false, 80.0, 0.0), (3, true, 140.0, 240.0), (0, true, 0.0, 240.0)]
                {
                    let params = &mut file.params;
                    (params.terms.relative_mass, params.terms.smooth_mass, params.substeps) = (relative, smooth, substeps);
                    params.relaxation = [PronyTerm::NONE; MOST_TERMS];
                    params.relaxation[..fading].fill(PronyTerm { share: 0.1, time_s: 1.0 });
                    params.friction = if rubs { 0.3 } else { 0.0 };
                    for touched in [0, 9] {
                        let right = by_hand(&file, touched as f64, [spring, node + more_node, pressed + more_triangle]);
                        let said = f64::from(cycles(&file, touched));
                        assert!((said / right - 1.0).abs() < 1e-5, "{said} for {right}");
                    }
                }
            }
        }
    }
}

#[test]
fn a_budget_is_three_quarters_of_a_tick_and_what_exceeds_it_is_refused() {
    assert_eq!((Budget::M4F_168.cycles, Budget::M7_480.cycles), (126e3, 360e3));
    let file = PatchFile::open(&NINE.0).unwrap();
    let cost = cycles(&file, 9);
    assert_eq!(Budget { cycles: cost }.check(&file, 9), Ok(cost));
    let refused = BuildError::OutOfRange { parameter: COST, value: cost, min: 0.0, max: cost - 1.0 };
    assert_eq!(Budget { cycles: cost - 1.0 }.check(&file, 9), Err(refused));
}
