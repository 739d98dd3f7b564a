//! `palpate chart --press` and `--with`: the input for other engines, and the use of their results.

use std::fmt::Write as _;

use crate::palpate_command::{Desk, palpate, repository};
use palpate_lab::chart::peers::{Peers, StandardPress, columns, compare, figures, least, same_meshes};
use palpate_lab::chart::{DEPTHS_M, Reference, Task, measure};
use palpate_lab::methods::{Block, Method};

/// A table of two fictitious engines for this press, too stiff by 25 and 60 %.
fn table(hash: &str) -> String {
    let mut text = format!("# peers = 1\n# scene = {hash}\n# machine = made up\n# date = never\n{}\n", columns().join(","));
    for (engine, mesh, nodes, times) in [("alpha", "grid-245", 245, 1.25), ("beta", "patch-130", 130, 1.6)] {
        let force = |d: &f64| format!("{:.9}", Reference::block().force_over_e_m2(*d).unwrap() * 3500.0 * times);
        let forces: Vec<String> = DEPTHS_M.iter().map(force).collect();
        let held = (times - 1.0) * 100.0;
        let _ =
            writeln!(text, "{engine},1.0,model,none,{mesh},{nodes},600,3500,2,yes,1e5,2e5,{},{held},3,4,5,6,a", forces.join(","));
    }
    text
}

#[test]
fn ours_stands_beside_theirs() {
    let desk = Desk::default();
    desk.put("peers.csv", table(&StandardPress::new().unwrap().hash().unwrap()));
    let peers = Peers::load(&desk.folder().join("peers.csv")).unwrap();
    let task = Task { method: Method::Palpate, nodes: 57, youngs_modulus_pa: 3500.0, refinement: 1 };
    let reference = Reference::block();
    let runs = measure(&[task], &Block::standard(57, 3500.0).unwrap(), &reference, false).unwrap();
    let ours = runs[0].survived().unwrap();
    let on_grids = same_meshes(&peers.rows, &reference, false).unwrap();
    assert_eq!(on_grids.iter().map(|run| run.size.nodes).collect::<Vec<_>>(), [245]);

    let rows = compare(&peers.rows, &runs, &on_grids);
    let [alpha, beta] = rows.as_slice() else { panic!("{rows:?}") };
    let (us, pct) = (ours.time.min_us, ours.accuracy.rms_pct().unwrap());
    for (row, held_pct) in [(alpha, 25.0), (beta, 60.0)] {
        assert!((row.held.cheaper.unwrap() * us / 1e5 - 1.0).abs() < 1e-9, "{row:?}");
        assert!((row.held.nearer.unwrap() * pct / held_pct - 1.0).abs() < 1e-3, "{row:?}");
        // the product's moving error was not measured here
        assert_eq!(row.moving, None);
    }
    assert!(alpha.same_mesh.is_some() && beta.same_mesh.is_none());
    assert_eq!(least(&rows, |row| Some(row.held)).nearer, alpha.held.nearer);
    assert!(compare(&peers.rows, &[], &on_grids).is_empty());

    let [figure] = &figures(&peers, &runs, &on_grids, &[])[..] else { panic!("one picture") };
    assert_eq!(figure.name, "peers_held_3.5kpa");
    figure.draw(desk.folder()).unwrap();
    let svg = std::fs::read_to_string(desk.folder().join("peers_held_3.5kpa.svg")).unwrap();
    for name in ["alpha model", "beta model", "ours, uncalibrated", "ours, on their grids"] {
        assert!(svg.contains(name), "{name} is not in the legend");
    }
}

#[test]
fn a_table_of_another_press_is_refused_before_anything_is_run() {
    let desk = Desk::default();
    let whole = table(&StandardPress::new().unwrap().hash().unwrap());
    for (text, says) in [
        (table("0123456789abcdef"), ["press 0123456789abcdef", "palpate chart --press"]),
        (whole.replace("# peers = 1\n", ""), ["no table of peers", "run.py"]),
        (whole.replace(",600,3500,", ",0,3500,"), ["line 6: tets is \"0\"", "whole number"]),
        (whole.replace(",25,3,", ",2.5,3,"), ["line 6: held_rms_pct is \"2.5\"", "25.00"]),
        (whole.replace(",2e5,", ",NaN,"), ["line 6: tick_median_us is \"NaN\"", "above 0"]),
        (whole.replace("tets,", ""), ["column 7", "\"tets\""]),
    ] {
        desk.put("peers.csv", &text);
        let before = desk.listing();
        let outcome = palpate(env!("CARGO_TARGET_TMPDIR"), desk.folder(), &["chart", "--quick", "--with", "peers.csv"]);
        assert_eq!((outcome.code, outcome.stderr.lines().count(), outcome.stdout.as_str()), (Some(2), 1, ""), "{outcome:?}");
        assert!(says.iter().all(|words| outcome.stderr.contains(words)), "{outcome:?}");
        assert_eq!(desk.listing(), before);
    }
}

#[test]
fn press_json_is_the_press() {
    let desk = Desk::default();
    let outcome = palpate(env!("CARGO_TARGET_TMPDIR"), desk.folder(), &["chart", "--press", "--out", "out"]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    let text = std::fs::read_to_string(desk.folder().join("out/press.json")).unwrap();
    let press: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(press["hash"], StandardPress::new().unwrap().hash().unwrap());
    let numbers = |value: &serde_json::Value| value.as_array().unwrap().iter().map(|v| v.as_f64().unwrap()).collect::<Vec<_>>();
    assert_eq!(numbers(&press["held"]["depths_m"]), DEPTHS_M);
    assert_eq!(press["held"]["force_over_e_m2"].as_array().unwrap().len(), DEPTHS_M.len());
    for ramp in press["moving"].as_array().unwrap() {
        let (depths, truths) = (numbers(&ramp["depths_m"]), numbers(&ramp["judged_force_over_e_m2"]));
        let touch = depths.iter().position(|d| *d > 0.0).unwrap();
        assert!(touch > 0 && touch + truths.len() <= depths.len() && depths.iter().all(|d| *d <= 0.004), "{ramp}");
        assert!(truths.iter().all(|f| *f > 0.0), "{ramp}");
    }
    let names: Vec<_> = press["meshes"].as_array().unwrap().iter().map(|mesh| mesh["name"].as_str().unwrap()).collect();
    assert_eq!(names, ["patch-130", "patch-410", "patch-1020", "grid-245", "grid-726", "grid-2025"]);
}

#[test]
fn the_table_that_ships_is_of_this_press() {
    let peers = Peers::load(&repository().join("host-sim/lab/peers/peers.csv")).unwrap();
    let engines: std::collections::BTreeSet<_> = peers.rows.iter().map(|row| row.engine.as_str()).collect();
    assert_eq!(engines.into_iter().collect::<Vec<_>>(), ["MuJoCo", "Newton", "pypbd", "rapier3d"]);
}
