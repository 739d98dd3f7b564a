//! Compares the press of the block with `CalculiX`, an independent solver.
//!
//! `cargo run --release --example calculix -- write FOLDER` in `host-sim/lab` writes the decks,
//! `ccx` solves them (`ccx -i FOLDER/press`), and `compare` in place of `write` reads the results
//! and prints them next to those of our finite elements and our patch. `tests/calculix` does all
//! three.

mod ball;
mod compare;
mod deck;
mod ours;
mod results;

use std::fmt::Display;
use std::path::Path;
use std::process::ExitCode;

const USAGE: &str = "give write or compare, and a folder";

/// An error message for the user.
type Failure = String;

/// Prefixes an error with the action that failed.
fn in_doing(what: impl Display) -> impl FnOnce(std::io::Error) -> Failure {
    move |cause| format!("{what}: {cause}")
}

fn run() -> Result<bool, Failure> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [what, folder] = arguments.as_slice() else { return Err(USAGE.into()) };
    let folder = Path::new(folder);
    match what.as_str() {
        "write" => {
            std::fs::create_dir_all(folder).map_err(in_doing(folder.display()))?;
            for deck in deck::all()? {
                let path = folder.join(format!("{}.inp", deck.name));
                std::fs::write(&path, &deck.text).map_err(in_doing(path.display()))?;
                println!("{}", deck.name);
            }
            Ok(true)
        }
        "compare" => compare::compare(folder),
        _ => Err(USAGE.into()),
    }
}

fn main() -> ExitCode {
    match run() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(why) => {
            eprintln!("calculix: {why}");
            ExitCode::from(2)
        }
    }
}
