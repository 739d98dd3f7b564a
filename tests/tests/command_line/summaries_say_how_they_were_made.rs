//! `provenance` in every summary.json: version, commit, command line, scene, machine, date. Whether
//! a summary follows the schema is checked wherever a test runs the command.

use std::process::Command;

use palpate_tests::palpate_command::{Desk, binary, palpate, repository};
use palpate_tests::press_run::SMALL_BLOCK;
use palpate_tests::schema::{defects, summaries};
use serde_json::{Value, json};

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");

fn summary(desk: &Desk, out: &str) -> Value {
    serde_json::from_slice(&std::fs::read(desk.folder().join(out).join("summary.json")).unwrap()).unwrap()
}

#[test]
fn a_summary_says_how_it_was_made() {
    let desk = Desk::default();
    desk.put("scene.toml", SMALL_BLOCK);
    let began = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap().as_secs();
    let ran = Command::new(binary(SCRATCH))
        .args(["press", "--scene", "scene.toml", "--set", "tissue.youngs_modulus_pa=5000", "--out", "a"])
        .current_dir(desk.folder())
        .output()
        .unwrap();
    assert!(ran.status.success());
    let made = summary(&desk, "a")["provenance"].clone();
    assert_eq!(made["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(made["command"], "press");
    assert_eq!(made["command_line"], json!(["press", "--scene", "scene.toml", "--set", "tissue.youngs_modulus_pa=5000"]));
    let tissue = &made["scene"]["tissue"];
    assert_eq!(
        (&tissue["youngs_modulus_pa"], &tissue["nodes"], &made["scene"]["name"]),
        (&json!(5000), &json!(129), &json!("small"))
    );
    assert!(made["machine"]["cores"].as_u64() > Some(0) && made["machine"]["processor"].is_string(), "{made}");
    let date = made["date"].as_str().unwrap();
    let now = Command::new("date").args(["-u", "-d", date, "+%s"]).output().unwrap();
    let now: u64 = String::from_utf8_lossy(&now.stdout).trim().parse().unwrap();
    assert!((began..began + 600).contains(&now), "{date}");
    let commit = Command::new("git").args(["rev-parse", "HEAD"]).current_dir(repository()).output();
    match commit.ok().filter(|output| output.status.success()) {
        // the program may have been built from an earlier commit, so its value is not compared
        Some(_) => assert!(made["commit"].as_str().is_some_and(|c| c.len() >= 12), "{made}"),
        None => assert!(made["commit"].is_null(), "{made}"),
    }
}

#[test]
fn the_date_is_the_one_that_a_reproducible_build_asks_for() {
    let desk = Desk::default();
    desk.put("scene.toml", SMALL_BLOCK);
    let _told = palpate(SCRATCH, desk.folder(), &["press", "--scene", "scene.toml"]);
    assert_eq!(summary(&desk, "out/press")["provenance"]["date"], "1970-01-01T00:00:00Z");
}

#[test]
fn the_schema_refuses_what_a_summary_may_not_be() {
    let desk = Desk::default();
    desk.put("scene.toml", SMALL_BLOCK);
    let _told = palpate(SCRATCH, desk.folder(), &["press", "--scene", "scene.toml"]);
    let good = summary(&desk, "out/press");
    assert!(defects(&good).is_empty());
    let broken = |change: &dyn Fn(&mut Value)| {
        let mut summary = good.clone();
        change(&mut summary);
        defects(&summary)
    };
    assert!(broken(&|s| s["provenance"]["commit"] = json!(3))[0].contains("/provenance/commit: 3 is no"));
    assert!(broken(&|s| drop(s.as_object_mut().unwrap().remove("provenance")))[0].contains("provenance is missing"));
    assert!(broken(&|s| drop(s.as_object_mut().unwrap().remove("holds")))[0].contains("holds is missing"));
    assert!(broken(&|s| s["holds"][1]["force_n"] = json!("much"))[0].contains("/holds/1/force_n"));
    assert!(broken(&|s| s["speed"] = json!(3))[0].contains("/speed: no such key"));
    assert!(broken(&|s| s["provenance"]["command"] = json!("knead"))[0].contains("knead"));
}

#[test]
fn the_schema_knows_every_command_that_writes_a_summary() {
    let commands = summaries()["$defs"]["provenance"]["properties"]["command"]["enum"].as_array().unwrap();
    let known: Vec<&str> = commands.iter().filter_map(Value::as_str).collect();
    let ruled: Vec<&str> = summaries()["allOf"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|rule| rule.pointer("/if/properties/provenance/properties/command/const")?.as_str())
        .collect();
    assert_eq!(known, ruled);
    let help = palpate(SCRATCH, Desk::default().folder(), &["--help"]).stdout;
    // these write no summary of their own: they print lists, write files of the user's choice, use
    // a board, or name another command
    let others = ["scene", "mesh", "pack", "merge", "check", "board", "help"];
    let listed = help.lines().skip_while(|line| *line != "Use it:").take_while(|line| *line != "Options:");
    for line in listed.filter(|line| line.starts_with("  ")) {
        let name = line.split_whitespace().next().unwrap();
        assert!(known.contains(&name) != others.contains(&name), "{name} is in the schema, or among those without a summary");
    }
}
