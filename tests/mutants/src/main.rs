//! Applies the mistakes of `list.toml` one at a time to a copy of the controller and runs the fast
//! suite against each. A mistake that no test notices is a survivor.

mod copy;
mod list;
mod suite;
mod survivors;

use std::io::Write;
use std::path::PathBuf;
use std::process::ExitCode;
use std::time::{Duration, Instant};

use copy::Copy;
use list::Mutant;
use suite::Verdict;

const USAGE: &str = "\
Applies one mistake at a time to a copy of core and firmware and runs their fast tests against it.

usage: tests/mutants/run [--list] [--shard K/N] [WORD...]

  WORD           only mistakes whose name or file contains one of the words
  --shard K/N    only every N-th of them, beginning with the K-th (0 to N-1)
  --list         prints their names and ends
  --copy DIR     makes the copy there and ends
  --compare DIR  compares a run of cargo-mutants with survivors.toml

exit: 0 every mistake was noticed, or is known to change nothing; 1 one was not; 2 bad input";

/// Time limit of the suite for one mistake; a run that exceeds it counts as noticed.
const LONGEST: Duration = Duration::from_secs(120);

/// Mutants chosen on the command line.
#[derive(Default)]
struct Choice {
    words: Vec<String>,
    shard: Option<(usize, usize)>,
    list: bool,
    copy: Option<PathBuf>,
    compare: Option<PathBuf>,
}

fn main() -> ExitCode {
    match run() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::from(1),
        Err(error) => {
            eprintln!("mutants: {error}");
            ExitCode::from(2)
        }
    }
}

/// Returns whether every chosen mistake was noticed.
fn run() -> Result<bool, String> {
    let Some(choice) = arguments()? else {
        println!("{USAGE}");
        return Ok(true);
    };
    let root = repository();
    if let Some(to) = choice.copy {
        return Copy::make(&root, to).map(|_| true);
    }
    if let Some(out) = choice.compare {
        return survivors::compare(&root, &root.join("target/mutants/all"), &out);
    }
    let mutants = choose(list::read(&root)?, &choice)?;
    if choice.list {
        mutants.iter().for_each(|mutant| println!("{:<44} {}", mutant.name, mutant.files()));
        return Ok(true);
    }
    let copy = Copy::make(&root, root.join("target/mutants/tree"))?;
    let begun = Instant::now();
    for package in suite::packages(&mutants) {
        println!("{package}: the suite without a mistake");
        match suite::judge(&copy, package, LONGEST)? {
            Verdict::Survived => {}
            verdict => return Err(format!("{package}: {verdict} without a mistake: mend the tests first")),
        }
    }
    println!("built and passed in {:.0} s", begun.elapsed().as_secs_f32());
    let mut survivors = Vec::new();
    for (index, mutant) in mutants.iter().enumerate() {
        print!("{:>3}/{} {:<44} ", index + 1, mutants.len(), mutant.name);
        _ = std::io::stdout().flush();
        let started = Instant::now();
        let verdict = copy.with(mutant, |copy| suite::judge(copy, mutant.package(), LONGEST))??;
        let note = match (&mutant.equivalent, &verdict) {
            (Some(_), Verdict::Survived) => ", as it must: it changes nothing that can be observed",
            (None, Verdict::Noticed | Verdict::Endless) => "",
            (reason, verdict) => {
                survivors.push(mutant.name.as_str());
                match (reason, verdict) {
                    (_, Verdict::Unbuilt) => " <-- mend its text in list.toml",
                    (Some(_), _) => " <-- it is no equivalent: take the reason away",
                    (None, _) => " <-- no test noticed it",
                }
            }
        };
        println!("{verdict}{note} ({:.1} s)", started.elapsed().as_secs_f32());
    }
    let equivalent = mutants.iter().filter(|mutant| mutant.equivalent.is_some()).count();
    let noticed = mutants.len() - equivalent - survivors.len();
    println!(
        "{noticed} of {} noticed, {equivalent} equivalent, {:.0} s",
        mutants.len() - equivalent,
        begun.elapsed().as_secs_f32()
    );
    survivors.iter().for_each(|name| println!("not as it should be: {name}"));
    Ok(survivors.is_empty())
}

/// Parses the command line; returns `None` if help was requested.
fn arguments() -> Result<Option<Choice>, String> {
    let mut choice = Choice::default();
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--help" | "-h" => return Ok(None),
            "--list" => choice.list = true,
            "--copy" => choice.copy = Some(arguments.next().ok_or("--copy: give a folder")?.into()),
            "--compare" => choice.compare = Some(arguments.next().ok_or("--compare: give a folder")?.into()),
            "--shard" => {
                let shard = arguments.next().unwrap_or_default();
                let numbers = shard.split_once('/').and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
                let Some((k, n)) = numbers.filter(|(k, n)| k < n) else {
                    return Err(format!("--shard {shard}: give K/N with K below N, for example 0/4"));
                };
                choice.shard = Some((k, n));
            }
            word if word.starts_with('-') => return Err(format!("{word}: no such option; try --help")),
            word => choice.words.push(word.to_owned()),
        }
    }
    Ok(Some(choice))
}

fn choose(mutants: Vec<Mutant>, choice: &Choice) -> Result<Vec<Mutant>, String> {
    let meant = |mutant: &Mutant| {
        let meets = |word: &String| mutant.name.contains(word.as_str()) || mutant.files().contains(word.as_str());
        choice.words.is_empty() || choice.words.iter().any(meets)
    };
    let chosen = mutants.into_iter().filter(meant).enumerate();
    let chosen: Vec<_> =
        chosen.filter(|(index, _)| choice.shard.is_none_or(|(k, n)| index % n == k)).map(|(_, mutant)| mutant).collect();
    match chosen.is_empty() {
        true => Err("no mistake of that name: see --list".into()),
        false => Ok(chosen),
    }
}

/// Root of the repository.
fn repository() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../..")
}
