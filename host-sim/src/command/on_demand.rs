//! Commands that another program executes. It is built when one of them is first used, and then
//! runs with the same arguments. What is wrong with the arguments is said before.

use std::path::Path;
use std::process::Command;

use palpate_tissue::Error as TissueError;
use palpate_tissue::machine::PROFILE;

use super::tools::Tools;
use crate::error::Error;

/// A program that is built when it is first needed.
#[derive(Clone, Copy)]
pub(super) enum Program {
    /// `palpate` with every command that is not a study.
    Full,
    /// The studies, in a workspace of their own.
    Lab,
}

impl Program {
    fn name(self) -> &'static str {
        match self {
            Self::Full => "palpate-full",
            Self::Lab => "palpate-lab",
        }
    }

    /// Folder of its package, relative to that of this one, and how cargo builds it there.
    fn package(self) -> (&'static str, &'static [&'static str]) {
        match self {
            Self::Full => ("", &["--package", "palpate-sim", "--features", "full"]),
            Self::Lab => ("lab", &["--package", "palpate-lab"]),
        }
    }
}

/// Builds a program, which then replaces this process and receives its arguments. A user who ends
/// this process thus ends the other, and the force that it may keep on.
pub(super) fn build_and_run(program: Program) -> Result<(), Error> {
    let (folder, how) = program.package();
    let (package, name) = (Path::new(env!("CARGO_MANIFEST_DIR")).join(folder), program.name());
    if !package.join("Cargo.toml").is_file() {
        return Err(TissueError::Usage(format!(
            "this build of palpate lacks this command, and {} is not there to build {name} from: start it in the repository",
            package.display()
        ))
        .into());
    }
    let profile = if PROFILE == "debug" { "dev" } else { PROFILE };
    let build = [&["--profile", profile, "--bin", name], how].concat();
    let built = Tools::in_use(package).build(&build, name, &format!("{name}, which has this command"))?;
    Err(replaced_by(Command::new(&built).args(std::env::args_os().skip(1)), &built))
}

/// Replaces this process by a program; returns only if the program does not start.
#[cfg(unix)]
fn replaced_by(command: &mut Command, program: &Path) -> Error {
    let why = std::os::unix::process::CommandExt::exec(command);
    TissueError::Usage(format!("{} does not start: {why}: build it anew", program.display())).into()
}

/// Runs a program and exits with its exit code, since on this system a process cannot be replaced.
/// A force must not outlive the process that a user ends, so `board` is refused.
#[cfg(not(unix))]
fn replaced_by(command: &mut Command, program: &Path) -> Error {
    if std::env::args_os().nth(1).is_some_and(|name| name == "board") {
        return TissueError::Usage(format!("board is in a program of its own on this system: run {} board", program.display()))
            .into();
    }
    match super::tools::run(command, &program.display().to_string()) {
        Ok(status) => std::process::exit(status.code().unwrap_or(2)),
        Err(error) => error,
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    /// Name of the test that runs itself again as a separate process.
    const ITSELF: &str = "command::on_demand::tests::a_program_takes_the_place_of_this_process";

    #[test]
    fn a_program_takes_the_place_of_this_process() {
        const INNER: &str = "PALPATE_TEST_IS_REPLACED";
        if std::env::var_os(INNER).is_some() {
            let error = replaced_by(Command::new("sh").args(["-c", "echo I am $$; exit 7"]), Path::new("sh"));
            panic!("sh does not start: {error}");
        }
        let mut test = Command::new(std::env::current_exe().unwrap());
        test.args(["--exact", ITSELF, "--nocapture"]).env(INNER, "1").stdout(std::process::Stdio::piped());
        let child = test.spawn().unwrap();
        let own = child.id();
        let outcome = child.wait_with_output().unwrap();
        let output = String::from_utf8_lossy(&outcome.stdout);
        assert!(output.contains(&format!("I am {own}\n")) && outcome.status.code() == Some(7), "{own}: {output}");
    }

    #[test]
    fn a_program_that_does_not_start_gets_one_line() {
        let missing = Path::new("/nowhere/palpate-full");
        let error = replaced_by(&mut Command::new(missing), missing);
        assert!(error.to_string().starts_with("/nowhere/palpate-full does not start") && error.exit_code() == 2, "{error}");
    }
}
