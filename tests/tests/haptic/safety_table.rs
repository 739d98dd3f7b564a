//! Everything that SAFETY.md names exists: files, tests, faults, commands, and third-party software
//! in the versions that are built.

use std::collections::BTreeMap;
use std::path::Path;

use palpate::Fault;
use palpate_tests::palpate_command::repository;

fn read(path: impl AsRef<Path>) -> String {
    let path = repository().join(path);
    std::fs::read_to_string(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()))
}

/// Cells of the tables below a heading, without table heads and rules.
fn rows(text: &str, heading: &str) -> Vec<Vec<String>> {
    let section = text.split(&format!("\n## {heading}\n")).nth(1).unwrap_or_else(|| panic!("no section {heading}"));
    let lines = section.split("\n## ").next().unwrap_or_default().lines().filter(|line| line.starts_with('|'));
    let cells = |line: &str| line.trim_matches('|').split(" | ").map(|cell| cell.trim().to_owned()).collect();
    lines.skip(2).map(cells).collect()
}

/// Texts between backquotes.
fn quoted(text: &str) -> impl Iterator<Item = &str> {
    text.split('`').skip(1).step_by(2)
}

/// Appends all Rust sources below a folder to `into`.
fn sources(folder: &Path, into: &mut String) {
    for entry in std::fs::read_dir(folder).unwrap().flatten() {
        let path = entry.path();
        if path.ends_with("target") {
            continue;
        }
        if path.is_dir() {
            sources(&path, into);
        } else if path.extension().is_some_and(|e| e == "rs") {
            *into += &std::fs::read_to_string(path).unwrap();
        }
    }
}

/// Returns an error message if the item named in backquotes does not exist.
fn missing(name: &str, code: &str) -> Option<String> {
    let words: Vec<&str> = name.split(' ').collect();
    let there = match words[..] {
        ["palpate", command, ..] => {
            let commands = read("host-sim/src/command.rs");
            let module = command.split('-').map(|part| part[..1].to_uppercase() + &part[1..]).collect::<String>();
            commands.contains(&format!("    {module}("))
        }
        ["./test"] => repository().join("test").is_file(),
        ["./test", option] => read("test").contains(option),
        [one] if one.starts_with("Fault::") => {
            let fault = &one["Fault::".len()..];
            Fault::ALL.iter().any(|f| format!("{f:?}") == fault)
        }
        [one] if one.contains('/') => repository().join(one).exists(),
        [one] if one.contains('.') || one.starts_with(char::is_uppercase) => {
            repository().join(one).exists() || code.contains(one)
        }
        [one] if one.contains('_') || one == "soak" => {
            let folders = ["tests/tests", "firmware/controller/tests", "core/tests"];
            let programs = folders.iter().flat_map(|folder| std::fs::read_dir(repository().join(folder)).unwrap().flatten());
            programs.into_iter().any(|program| program.path().join(format!("{one}.rs")).is_file())
                || code.contains(&format!("fn {one}("))
        }
        _ => true,
    };
    (!there).then(|| name.to_owned())
}

#[test]
fn every_file_test_fault_and_command_is_there() {
    let text = read("SAFETY.md");
    let mut code = String::new();
    ["core", "firmware", "host-sim", "tests"].iter().for_each(|folder| sources(&repository().join(folder), &mut code));
    let gone: Vec<String> = quoted(&text).filter_map(|name| missing(name, &code)).collect();
    assert!(gone.is_empty(), "SAFETY.md names what is not there: {gone:?}");
    for wrong in ["core/src/none.rs", "no_such_test", "Fault::Nothing", "palpate dance", "./test --dance"] {
        assert!(missing(wrong, &code).is_some(), "{wrong}");
    }
}

#[test]
fn every_hazard_has_a_control_a_remainder_and_evidence() {
    let text = read("SAFETY.md");
    let hazards = rows(&text, "Hazards");
    assert!(hazards.len() >= 30, "{}", hazards.len());
    for (n, row) in hazards.iter().enumerate() {
        let [number, hazard, cause, severity, control, remains, shown] = &row[..] else { panic!("seven columns: {row:?}") };
        assert_eq!(*number, (n + 1).to_string());
        assert!(["serious", "moderate", "minor"].contains(&severity.as_str()), "{hazard}: {severity}");
        assert!([cause, control, remains].iter().all(|cell| cell.len() > 8), "{hazard}");
        assert!(quoted(control).next().is_some() && quoted(shown).next().is_some(), "{hazard}: control and evidence are named");
    }
    for said in ["no medical device", "not certified", "nothing here was run on hardware", "force is zero on any doubt"] {
        assert!(text.contains(said), "SAFETY.md does not say: {said}");
    }
    assert!(rows(&text, "Commands").len() >= 8);
}

#[test]
fn third_party_software_is_that_of_the_lock_file() {
    let text = read("SAFETY.md");
    let lock = read("Cargo.lock");
    let mut built: BTreeMap<&str, Vec<&str>> = BTreeMap::new();
    for package in lock.split("[[package]]").skip(1) {
        let value = |key: &str| package.split(&format!("\n{key} = \"")).nth(1).and_then(|rest| rest.split('"').next()).unwrap();
        built.entry(value("name")).or_default().push(value("version"));
    }
    let mut listed = Vec::new();
    for section in ["Third-party software in the board's image", "Third-party software in the desktop's loop"] {
        let software = rows(&text, section);
        assert!(software.len() > 10, "{section}");
        for row in software {
            let [name, version, licence, does, fails] = &row[..] else { panic!("five columns: {row:?}") };
            assert!(
                built.get(name.as_str()).is_some_and(|v| v.contains(&version.as_str())),
                "{name} {version} is not in Cargo.lock"
            );
            assert!(licence.len() > 2 && !does.is_empty() && !fails.is_empty(), "{name}");
            listed.push(name.clone());
        }
    }
    // every dependency named in the manifests of core and image is in the list
    for manifest in ["core/Cargo.toml", "firmware/Cargo.toml", "firmware/controller/Cargo.toml"] {
        let text = read(manifest);
        for part in text.split("\n[").filter(|part| part.lines().next().is_some_and(|head| head.ends_with("dependencies]"))) {
            for name in part.lines().skip(1).filter_map(|line| line.split([' ', '.', '=']).next()) {
                let own = name.is_empty() || name.starts_with(['#', '[']) || name.starts_with("palpate");
                let dev = part.starts_with("dev-") || part.starts_with("build-");
                assert!(own || dev || listed.iter().any(|l| l == name), "{manifest} names {name}, which SAFETY.md does not list");
            }
        }
    }
}
