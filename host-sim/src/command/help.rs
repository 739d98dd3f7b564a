//! `palpate --help` in two lists: commands for use, and commands that check the project's claims.

use std::fmt::Write;

use clap::Command;

/// Commands that check claims; all others are for use.
const CHECKS: [&str; 6] = ["accept", "chart", "far-field", "faults", "paper", "stability"];

/// The command with its subcommands listed in two groups.
pub(super) fn grouped(command: Command) -> Command {
    let template = format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\nUse it:\n{}\nCheck its claims:\n{}\nOptions:\n{{options}}{{after-help}}",
        list(&command, |name| !CHECKS.contains(&name)),
        list(&command, |name| CHECKS.contains(&name)),
    );
    command.help_template(template)
}

/// A line per subcommand that is `chosen`.
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
            let expected = CHECKS.contains(&command.get_name());
            assert_eq!((usage.contains(&line), checks.contains(&line)), (!expected, expected), "{help}");
        }
        assert!(help.contains("Usage: palpate [COMMAND]") && help.contains("Exit code"), "{help}");
        for name in CHECKS {
            assert!(Cli::command().find_subcommand(name).is_some(), "{name} is no command");
        }
    }
}
