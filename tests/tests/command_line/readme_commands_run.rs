//! Every command shown in the README and the book runs, each once.

use std::path::Path;
use std::process::Command;
use std::sync::Mutex;
use std::time::Instant;

use palpate_tests::palpate_command::repository;

use crate::readme_and_book::own_pages;

/// Commands in the fenced `sh` blocks: lines that call cargo or a script of the repository, with
/// their continuation lines. `./test` is left out because it would run this test again. No command
/// that fetches or changes the repository starts with these words.
fn commands(text: &str) -> Vec<String> {
    let (mut found, mut in_sh, mut whole) = (Vec::new(), false, String::new());
    for line in text.lines().map(str::trim) {
        if let Some(language) = line.strip_prefix("```") {
            in_sh = !in_sh && ["sh", "bash", "console"].contains(&language.split([',', ' ']).next().unwrap_or_default());
            continue;
        }
        if !in_sh {
            continue;
        }
        let line = line.strip_prefix("$ ").unwrap_or(line);
        if let Some(begun) = line.strip_suffix('\\') {
            whole.push_str(begun);
            continue;
        }
        whole.push_str(line);
        let command = std::mem::take(&mut whole);
        if command.starts_with("cargo ") || command.starts_with("./") && command.split([' ', '#']).next() != Some("./test") {
            found.push(command);
        }
    }
    found
}

/// The command as this test runs it: its output goes outside the repository unless it names a
/// folder itself, and long commands run in their quick form.
fn as_run(command: &str, out: &Path) -> String {
    // an option appended after a comment would be lost
    let command = command.split(" #").next().unwrap_or(command).trim_end();
    if command.starts_with("cargo bench") && !command.contains(" -- ") {
        // seconds instead of minutes: same code, fewer samples
        return format!("{command} -- --quick");
    }
    let writes =
        ["press", "pack"].iter().any(|c| command.contains(&format!("-- {c}"))) || command.ends_with("cargo run --release");
    let has_folder = command.contains("--out");
    match (writes && !has_folder, command.contains(" -- ")) {
        (false, _) => command.to_owned(),
        (true, true) => format!("{command} --out '{}'", out.display()),
        (true, false) => format!("{command} -- press --out '{}'", out.display()),
    }
}

/// Whether a command runs tests of the repository that exist. They run with the others, or in the
/// long form, and a build of their package alone would not share the libraries that are built for
/// all packages.
fn runs_tests(command: &str) -> bool {
    let Some((cargo, test)) = command.strip_prefix("cargo test ").and_then(|rest| rest.split_once("--test ")) else {
        return false;
    };
    let (program, rest) = test.split_once(" -- ").unwrap_or((test, ""));
    let packages = ["--release --workspace ", "--release -p palpate-tests "];
    let (flags, filters): (Vec<&str>, Vec<&str>) =
        rest.split_whitespace().partition(|word| word.starts_with("--") || *word == "1");
    let known = flags.iter().all(|flag| ["--nocapture", "--test-threads", "1"].contains(flag));
    let folder = repository().join("tests/tests").join(program);
    let text = |path| std::fs::read_to_string(path).unwrap_or_default();
    let main = text(folder.join("main.rs"));
    let files = std::fs::read_dir(&folder).into_iter().flatten().flatten().map(|entry| text(entry.path()));
    let all: String = files.collect();
    let exists = |name: &&str| main.contains(&format!("\nmod {name};")) || all.contains(&format!("#[test]\nfn {name}()"));
    packages.contains(&cargo) && known && !main.is_empty() && filters.iter().all(exists)
}

/// Runs a command line; returns the error, if any.
fn failure(line: &str) -> Option<String> {
    if runs_tests(line) {
        return None;
    }
    let begun = Instant::now();
    let run = Command::new("sh").args(["-c", line]).current_dir(repository()).output().expect("sh starts");
    println!("$ {line}: {:.1} s", begun.elapsed().as_secs_f64());
    let message = || format!("$ {line}\n{}\n{}", run.status, String::from_utf8_lossy(&run.stderr));
    (!run.status.success()).then(message)
}

/// Commands that take minutes on one core. Other tests run a quick form of each except the
/// benchmark.
const LONG: [&str; 11] = [
    "accept",
    "bench",
    "chart",
    "faults",
    "fit --scene",
    "fit --smallest",
    "loop --emulated",
    "loop --quick",
    "paper",
    "stability",
    "suite",
];

#[test]
fn every_short_command_of_readme_and_book_exits_with_0() {
    run(|command| !LONG.iter().any(|long| command.contains(long)), 14);
}

#[test]
#[ignore = "minutes: the commands that check our claims"]
fn every_long_command_of_readme_and_book_exits_with_0() {
    run(|command| LONG.iter().any(|long| command.contains(long)), 15);
}

/// Commands in README and book, without comments and without duplicates.
fn all_commands() -> Vec<String> {
    let mut all = Vec::new();
    for (_, text) in own_pages() {
        for command in commands(&text) {
            let command = command.split(" #").next().unwrap_or_default().trim_end().to_owned();
            if !all.contains(&command) {
                all.push(command);
            }
        }
    }
    all
}

/// Runs the commands for which `chosen` is true, of which there must be at least `least`.
fn run(chosen: impl Fn(&str) -> bool, least: usize) {
    let mut commands = all_commands();
    commands.retain(|command| chosen(command));
    assert!(commands.len() >= least, "README and book show only {commands:?}");
    let out = tempfile::tempdir().unwrap();
    let lines = commands.iter().enumerate().map(|(n, command)| as_run(command, &out.path().join(n.to_string())));
    // two commands run at a time, except those that link or start the board's image, which run one
    // after the other because the image is a single file
    let (board, others): (Vec<String>, Vec<String>) =
        lines.partition(|line| line.contains("cargo fw") || line.contains("emulate"));
    let (others, failed) = (Mutex::new(others), Mutex::new(Vec::new()));
    let run = |line: String| failed.lock().unwrap().extend(failure(&line));
    // the last commands of the list take longest, so they start first
    let next = || others.lock().unwrap().pop();
    std::thread::scope(|scope| {
        scope.spawn(|| board.into_iter().for_each(run));
        scope.spawn(|| std::iter::from_fn(next).for_each(run));
        std::iter::from_fn(next).for_each(run);
    });
    let failed = failed.into_inner().unwrap();
    assert!(failed.is_empty(), "{}", failed.join("\n"));
}

#[test]
fn commands_are_found_in_sh_blocks_only() {
    let text = "cargo no\n```sh\n# words\ncargo run --release\n$ cargo run -- press \\\n  --scene nodule   # longer\n./test\ngit clone x\n./.ci/run\n```\n```toml\ncargo = 1\n```\n";
    assert_eq!(commands(text), ["cargo run --release", "cargo run -- press --scene nodule   # longer", "./.ci/run"]);
    let out = Path::new("/o");
    assert_eq!(as_run("cargo run --release", out), "cargo run --release -- press --out '/o'");
    assert_eq!(as_run("cargo run -- press --vtu  # words", out), "cargo run -- press --vtu --out '/o'");
    assert_eq!(as_run("cargo run -- press --out mine", out), "cargo run -- press --out mine");
    let of = |rest: &str| runs_tests(&format!("cargo test --release -p palpate-tests --test {rest}"));
    assert!(of("board -- board_cost --nocapture --test-threads 1") && of("bindings"));
    assert!(of("command_line -- commands_are_found_in_sh_blocks_only"));
    assert!(!of("board -- no_such") && !of("no_such") && !of("board && false") && !of("board --no-such"));
    assert!(!of("command_line -- as_run") && !runs_tests("cargo test -p no-such --test board"));
    assert_eq!(as_run("cargo bench -p x", out), "cargo bench -p x -- --quick");
}

/// Two commands that write to the same folder would refuse each other.
#[test]
fn no_two_commands_write_one_folder() {
    let all = all_commands();
    let folder =
        |command: &String| command.split_once("--out ").map(|(_, rest)| rest.split(' ').next().unwrap_or_default().to_owned());
    let mut folders: Vec<String> = all.iter().filter_map(folder).collect();
    let count = folders.len();
    folders.sort();
    folders.dedup();
    assert!(count > 20 && folders.len() == count, "{all:#?}");
}
