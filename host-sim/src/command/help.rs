//! `palpate --help` in two lists: commands for use, and commands that check the project's claims.
//! The help of each command has an example and the default folder.

use std::fmt::Write;

use clap::Command;

/// Commands that check claims; all others are for use.
const CHECKS: [&str; 3] = ["check", "emulate", "merge"];

/// Commands that are in no list: short names of the checks, and what a shell needs once.
const UNLISTED: [&str; 8] = ["accept", "chart", "completions", "faults", "paper", "stability", "suite", "unseen"];

/// An example of each command, with its effect.
const EXAMPLES: [(&str, &str, &str); 20] = [
    ("press", "palpate press --scene nodule --set probe.position_m=[0.01,0]", "press 10 mm beside the nodule"),
    ("scene", "palpate scene nodule > mine.toml", "a scene of your own to change"),
    ("fit", "palpate fit --scene mine.toml --nodes 130", "a calibrated patch of your scene, and how wrong it is"),
    (
        "identify",
        "palpate identify phantom.csv --tip sphere:4mm --thickness 10mm",
        "a scene of the tissue, and what the data cannot say",
    ),
    ("merge", "palpate merge out/parts", "after `palpate loop --quick --out out/parts --cases 0..50`, and `--cases 50..999`"),
    ("mesh", "palpate mesh check liver.msh --unit mm", "the size of a mesh, its worst tet, and what the import changed"),
    ("pack", "palpate pack --board nucleo-f446re", "the block as a patch file for that board"),
    ("paper", "palpate paper volume-preserved --quick", "the sparse rows of paper 000"),
    ("check", "palpate check chart --quick", "every method on two small meshes"),
    ("chart", "palpate chart --quick", "every method on two small meshes"),
    ("loop", "palpate loop --hand H1 --quick --all", "a light fingertip with every stimulus"),
    ("faults", "palpate faults --quick", "6000 faults in the haptic loop"),
    ("board", "palpate board list", "the boards that answer on a serial port"),
    ("emulate", "palpate emulate --quick", "the firmware's image against this machine, bit for bit"),
    ("live", "palpate live --scene nodule", "press the tissue over a nodule with the mouse"),
    ("accept", "palpate accept T1", "relaxation against measured beef"),
    ("suite", "palpate suite --quick", "what each of twelve scenes needs at least"),
    ("unseen", "palpate unseen --quick --seed 7", "the stated error of one random scene"),
    ("stability", "palpate stability --quick", "where methods and controllers fail"),
    ("completions", "palpate completions bash > ~/.local/share/bash-completion/completions/palpate", "for bash"),
];

/// Names of earlier commands, and where their results are now.
const GONE: [(&str, &str); 7] = [
    ("calibrate", "use `palpate fit`, which solves the finite elements that it needs"),
    ("cut", "use `palpate fit --board BOARD`, with --radius and --element if you choose them"),
    (
        "far-field",
        "its tables are in the book, host-sim/book/src/results/far-field.md, and `palpate fit --smallest` searches over the edge of a patch",
    ),
    ("plan", "use `palpate fit --smallest --board BOARD --tolerance-pct PERCENT`"),
    ("replay", "use `palpate live --replay TRACE`"),
    ("reference", "use `palpate fit`, which writes its finite-element answer to answer.json"),
    ("score", "equation (14) and table 1 of paper 004 are in host-sim/lab/src/score.rs, where a test checks them"),
];

/// Error message for a command that is gone.
pub(super) fn gone(name: &str) -> Option<String> {
    let (name, now) = GONE.iter().find(|(gone, _)| *gone == name)?;
    Some(format!("`palpate {name}` is gone: {now}"))
}

/// Error message for an option that is gone.
pub(super) fn gone_option(word: &str) -> Option<String> {
    let shard = word == "--shard" || word.starts_with("--shard=");
    shard.then(|| "`--shard` is gone: use --cases A..B, which runs the cases from number A up to B - 1, counted from 0".into())
}

/// Lists the subcommands in two groups, and gives each an example and its own default folder.
pub(super) fn grouped(command: Command) -> Command {
    let command = command.mut_subcommands(|listed| match listed.get_name() {
        "check" => exemplified(listed.mut_subcommands(exemplified)),
        _ => exemplified(listed),
    });
    let template = format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\nUse it:\n{}\nCheck its claims:\n{}\nOptions:\n{{options}}{{after-help}}",
        list(&command, |name| !CHECKS.contains(&name) && !UNLISTED.contains(&name)),
        list(&command, |name| CHECKS.contains(&name)),
    );
    command.help_template(template)
}

/// Gives a command its example and its own default folder.
fn exemplified(command: Command) -> Command {
    let command = with_default_folder(command);
    match EXAMPLES.iter().find(|(name, ..)| *name == command.get_name()) {
        Some((_, line, what)) => command.after_help(format!("Example, {what}:\n  {line}")),
        None => command,
    }
}

/// Adds to the help of `--out` the folder that is used if none is given.
fn with_default_folder(command: Command) -> Command {
    let name = command.get_name().to_owned();
    // clap already names its own defaults, and the help names those that depend on other options
    let unsaid = command.get_arguments().any(|a| a.get_id() == "out" && a.get_default_values().is_empty());
    if !unsaid || name == "live" {
        return command;
    }
    command.mut_arg("out", |out| {
        let said = out.get_help().map(ToString::to_string).unwrap_or_default();
        out.help(format!("{said} [default: out/{name}]"))
    })
}

/// Lists the subcommands that are `chosen`, one per line.
fn list(command: &Command, chosen: impl Fn(&str) -> bool) -> String {
    let width = command.get_subcommands().map(|c| c.get_name().len()).max().unwrap_or(0);
    let mut lines = String::new();
    for listed in command.get_subcommands().filter(|c| chosen(c.get_name())) {
        let about = listed.get_about().map(ToString::to_string).unwrap_or_default();
        let _infallible = writeln!(lines, "  {:width$}  {about}", listed.get_name());
    }
    lines
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::command::Cli;
    use clap::CommandFactory;

    #[test]
    fn every_command_stands_in_one_of_the_lists() {
        let help = grouped(Cli::command()).render_help().to_string();
        let (usage, checks) = help.split_once("Check its claims:").unwrap();
        let (checks, _) = checks.split_once("Options:").unwrap();
        for command in Cli::command().get_subcommands() {
            let line = format!("\n  {} ", command.get_name());
            let (check, listed) = (CHECKS.contains(&command.get_name()), !UNLISTED.contains(&command.get_name()));
            assert_eq!((usage.contains(&line), checks.contains(&line)), (!check && listed, check), "{help}");
        }
        let rows = |list: &str| list.lines().filter(|line| line.starts_with("  ")).count();
        assert!(rows(usage) <= 9 && rows(usage) + rows(checks) <= 12, "{help}");
        assert!(help.contains("Usage: palpate [COMMAND]") && help.contains("Exit code"), "{help}");
        for command in grouped(Cli::command()).get_subcommands() {
            let (_, line, _) = EXAMPLES.iter().find(|(name, ..)| *name == command.get_name()).unwrap();
            let mut words = line.split(" > ").next().unwrap().split(' ');
            grouped(Cli::command()).try_get_matches_from(words.clone()).unwrap();
            assert_eq!(words.nth(1), Some(command.get_name()), "{line}");
            if command.get_arguments().any(|a| a.get_id() == "out") && command.get_name() != "live" {
                let help = command.clone().render_help().to_string();
                assert!(help.contains("[default: out/"), "{help}");
            }
        }
        for line in ["palpate check chart --quick", "palpate chart --quick"] {
            grouped(Cli::command()).try_get_matches_from(line.split(' ')).unwrap();
        }
        for name in CHECKS.into_iter().chain(UNLISTED) {
            assert!(Cli::command().find_subcommand(name).is_some(), "{name} is no command");
        }
    }
}
