//! The book's page of scene keys is generated from the code's own doc comments. They are complete
//! and correct: every key that the parser accepts is listed, with the ranges and defaults of the
//! parser.

mod page;
mod ranges;

use std::collections::BTreeSet;

use palpate_tests::palpate_command::repository;
use palpate_tissue::scene::{Drive, Inclusion, ProbeScene, RegionScene, RelaxationScene, Scene, Solver, TissueScene};
use serde::de::DeserializeOwned;

use page::tables;

const PAGE: &str = "host-sim/book/src/scene-reference.md";

#[test]
fn the_page_is_what_the_code_says() {
    let written = std::fs::read_to_string(repository().join(PAGE)).unwrap_or_default();
    assert!(
        written == page::page(),
        "{PAGE} is out of date: cargo test --release -p palpate-tests --test command_line -- --ignored rewrite_the_scene_reference"
    );
}

#[test]
#[ignore = "writes the page"]
fn rewrite_the_scene_reference() {
    std::fs::write(repository().join(PAGE), page::page()).unwrap();
}

/// Keys of a table, as its parser lists them in the error for an unknown key.
fn accepted<T: DeserializeOwned>() -> BTreeSet<String> {
    let error = toml::from_str::<T>("no_such_key = 1").err().expect("it is refused").to_string();
    let (_, expected) = error.split_once("expected ").expect("the keys that are known");
    expected.split('`').skip(1).step_by(2).map(str::to_owned).collect()
}

#[test]
fn every_key_that_the_parser_accepts_is_on_the_page_and_no_other() {
    let accepted = [
        ("top", accepted::<Scene>()),
        ("[tissue]", accepted::<TissueScene>()),
        ("[[tissue.region]]", accepted::<RegionScene>()),
        ("[[tissue.inclusion]]", accepted::<Inclusion>()),
        ("[[tissue.relaxation]]", accepted::<RelaxationScene>()),
        ("[probe]", accepted::<ProbeScene>()),
        ("[drive]", accepted::<Drive>()),
        ("[solver]", accepted::<Solver>()),
    ];
    let tables = tables();
    assert_eq!(tables.len(), accepted.len());
    for (name, keys) in accepted {
        let table = tables.iter().find(|table| table.name == name).expect(name);
        let described: BTreeSet<String> = table.keys.iter().map(|key| key.name.clone()).collect();
        assert_eq!(described, keys, "{name}");
        assert!(keys.len() > 1, "{name}: {keys:?}");
        for key in &table.keys {
            assert!(key.meaning.len() > 10, "{name} {}: say what it is", key.name);
        }
    }
}
