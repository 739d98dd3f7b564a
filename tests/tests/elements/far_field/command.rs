//! `palpate far-field` behaves as promised for all commands.

use palpate_tests::palpate_command::{Desk, palpate};
use serde_json::Value;

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");

#[test]
#[ignore = "long: every edge at four radii"]
fn the_quick_table_is_written_and_says_what_it_promises() {
    let desk = Desk::default();
    let outcome = palpate(SCRATCH, desk.folder(), &["far-field", "--quick", "--out", "here"]);
    assert_eq!(outcome.code, Some(0), "{}\n{}", outcome.stdout, outcome.stderr);
    let folder = desk.folder().join("here");
    let text = |name: &str| std::fs::read_to_string(folder.join(name)).unwrap_or_else(|e| panic!("{name}: {e}"));
    let summary: Value = serde_json::from_str(&text("summary.json")).unwrap();
    let rows = summary["rows"].as_array().unwrap();
    let edges = ["fixed", "winkler", "truncated", "rim-springs", "modes-9", "modes-18", "low-rank-9", "low-rank-18", "dense"];
    let of = |edge: &str| rows.iter().filter(|r| r["edge"] == edge).collect::<Vec<_>>();
    for edge in edges.iter().chain(&["whole-organ-springs", "whole-organ-elements"]) {
        let found = of(edge);
        assert!(found.len() >= 4, "{edge}: a row for each of four radii");
        assert!(found.iter().all(|r| r["force_over_e_m2"][2].as_f64().unwrap() > 0.0), "{edge}: 4 mm deep");
    }
    assert!(edges.iter().all(|e| of(e).iter().all(|r| r["tick_us"].as_f64().unwrap() > 0.0)), "all of them run in the tick");
    // a fixed edge, as in the papers, compared with rim springs, for a patch of two probe radii
    let at_two = |edge: &str| {
        let row = of(edge).into_iter().find(|r| (r["radius_m"].as_f64().unwrap() - 0.016).abs() < 1e-9).unwrap().clone();
        row["against_dense"]["centred_pct"][2].as_f64().unwrap().abs()
    };
    assert!(at_two("fixed") > 20.0 && at_two("rim-springs") < 0.5, "{} and {}", at_two("fixed"), at_two("rim-springs"));
    assert_eq!(text("far_field.csv").lines().count(), 1 + rows.len());
    assert!(text("awake.csv").lines().count() > 40 && text("stress_rule.csv").lines().count() > 20);
    for name in ["error_over_radius_centred_4.0mm", "error_over_radius_aside_4.0mm", "error_over_awake_130"] {
        assert!(text(&format!("{name}.svg")).contains("<svg") && folder.join(format!("{name}.png")).is_file());
    }
    assert!(outcome.stdout.contains("rim-springs") && outcome.stdout.contains("rest stands still"));
}

#[test]
fn a_scene_without_a_block_is_refused_in_one_line() {
    let desk = Desk::default();
    desk.put("mesh.toml", "name = \"m\"\n[tissue]\nmesh = \"m.msh\"\nlength_unit = \"mm\"\nyoungs_modulus_pa = 3500.0\npoisson_ratio = 0.45\ndensity_kg_per_m3 = 1060.0\n[probe]\nshape = \"hemisphere\"\nradius_m = 0.008\nsite = [0.0, 0.0, 0.0]\n[drive]\nkind = \"depth\"\nholds_m = [0.001]\nramp_m_per_s = 0.04\nhold_s = 0.3\n");
    let outcome = palpate(SCRATCH, desk.folder(), &["far-field", "--scene", "mesh.toml", "--quick"]);
    assert_eq!(outcome.code, Some(2), "{}", outcome.stderr);
    assert_eq!(outcome.stderr.trim().lines().count(), 1, "{}", outcome.stderr);
    assert!(outcome.stderr.contains("tissue.block_m") && outcome.stderr.contains("--scene block"), "{}", outcome.stderr);
}
