//! Runs cargo and rustup in a package's folder, so that the settings in it apply.

use std::ffi::OsString;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, ExitStatus, Stdio};
use std::time::Instant;

use serde_json::Value;

use super::progress::Progress;
use crate::error::Error;
use palpate_tissue::Error as TissueError;

const INSTALL: &str = "install the toolchain from https://rustup.rs";

/// Tools of the toolchain that is in use.
pub(super) struct Tools {
    pub package: PathBuf,
    cargo: OsString,
    rustc: OsString,
    rustup: OsString,
}

impl Tools {
    pub fn in_use(package: PathBuf) -> Self {
        let named = |variable: &str, usual: &str| std::env::var_os(variable).unwrap_or_else(|| usual.into());
        Self { package, cargo: named("CARGO", "cargo"), rustc: named("RUSTC", "rustc"), rustup: "rustup".into() }
    }

    /// Adds the standard library for `target` if it is missing. A toolchain that rustup does not
    /// manage may have it as well.
    pub fn add_target(&self, target: &str) -> Result<(), Error> {
        let mut ask = self.command(&self.rustc);
        if let Ok(output) = ask.args(["--print", "target-libdir", "--target", target]).output()
            && Path::new(String::from_utf8_lossy(&output.stdout).trim()).is_dir()
        {
            return Ok(());
        }
        eprintln!("adding {target} to the toolchain");
        let refused = |why: &str, fix: &str| {
            TissueError::Usage(format!("the page is built for {target}, which could not be added to the toolchain: {why}: {fix}"))
        };
        match self.command(&self.rustup).args(["target", "add", target]).output() {
            Ok(added) if added.status.success() => Ok(()),
            Ok(added) => {
                let output = String::from_utf8_lossy(&added.stderr);
                let why = output.lines().find_map(|l| l.strip_prefix("error: ")).unwrap_or("rustup does not say why");
                let package = self.package.display();
                Err(Error::Tissue(refused(why, &format!("run `rustup target add {target}` in {package}, with a network"))))
            }
            Err(why) => Err(Error::Tissue(refused(&format!("rustup: {why}"), INSTALL))),
        }
    }

    /// Builds, and asks cargo for the path of the output of `target`, since settings may choose any
    /// folder. Announces the build of `program` once cargo compiles something.
    pub fn build(&self, arguments: &[&str], target: &str, program: &str) -> Result<PathBuf, Error> {
        let what = format!("cargo build {} in {}", arguments.join(" "), self.package.display());
        let failed = |why: std::io::Error| TissueError::Usage(format!("{what}: {why}: {INSTALL}"));
        let mut cargo = self.command(&self.cargo);
        cargo.args(["build", "--message-format", "json-render-diagnostics"]).args(arguments);
        let mut building = cargo.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().map_err(failed)?;
        let told = building.stderr.take();
        let built = std::thread::scope(|scope| {
            scope.spawn(|| told.map(|told| tell(BufReader::new(told), program, &mut |line| eprintln!("{line}"))));
            building.wait_with_output()
        });
        let built = built.map_err(failed)?;
        ended(built.status, &what)?;
        let output = String::from_utf8_lossy(&built.stdout);
        Ok(output.lines().find_map(|line| file_of(target, line)).ok_or_else(|| {
            TissueError::Usage(format!("{what}: it names no file of {target}: {INSTALL} that rust-toolchain.toml names"))
        })?)
    }

    fn command(&self, program: &OsString) -> Command {
        let mut command = Command::new(program);
        command.current_dir(&self.package);
        // these paths are relative to the user's working folder, not to the package
        for variable in ["CARGO_TARGET_DIR", "CARGO_BUILD_TARGET_DIR"] {
            if let Some(folder) = std::env::var_os(variable).filter(|f| !f.is_empty())
                && let Ok(folder) = std::path::absolute(folder)
            {
                command.env(variable, folder);
            }
        }
        command
    }
}

/// Repeats cargo's messages, such as that it waits for another cargo; counts the packages that it
/// compiles, and announces the first.
fn tell(messages: impl BufRead, program: &str, say: &mut dyn FnMut(&str)) {
    let mut compiling: Option<(Progress, Instant)> = None;
    for line in messages.lines().map_while(Result::ok) {
        match line.trim_start().split(' ').next() {
            Some("Compiling") => {
                let (packages, _) = compiling.get_or_insert_with(|| {
                    say(&format!("building {program}: the first time takes some minutes"));
                    (Progress::new(0, "packages"), Instant::now())
                });
                packages.one(line.trim_start());
            }
            Some("Finished") => {}
            _ => say(&line),
        }
    }
    if let Some((packages, started)) = compiling {
        packages.finish();
        say(&format!("built in {:.0} s", started.elapsed().as_secs_f64()));
    }
}

/// Path of the program or module in a line of cargo's messages; `None` for other lines.
fn file_of(target: &str, line: &str) -> Option<PathBuf> {
    let output: Value = serde_json::from_str(line).ok()?;
    if output["reason"] != "compiler-artifact" || output["target"]["name"] != target {
        return None;
    }
    let module = || output["filenames"].as_array()?.iter().filter_map(Value::as_str).find(|f| f.ends_with(".wasm"));
    output["executable"].as_str().or_else(module).map(PathBuf::from)
}

/// Runs a program that reports its own errors.
pub(super) fn run(command: &mut Command, what: &str) -> Result<ExitStatus, Error> {
    Ok(command.status().map_err(|why| TissueError::Usage(format!("{what} does not start: {why}: build it anew")))?)
}

/// Turns an exit status other than success into an error.
pub(super) fn ended(status: ExitStatus, what: &str) -> Result<(), Error> {
    if status.success() {
        Ok(())
    } else {
        Err(TissueError::Usage(format!("{what}: {status}: what it said above tells why")).into())
    }
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    const WASM: &str = "wasm32-unknown-unknown";

    /// Tools that are scripts with these lines; a script without lines is not created.
    fn scripts(rustc: &str, rustup: &str, cargo: &str) -> (tempfile::TempDir, Tools) {
        let folder = tempfile::tempdir().unwrap();
        let put = |name: &str, lines: &str| {
            let path = folder.path().join(name);
            if !lines.is_empty() {
                let text = path.with_extension("text");
                std::fs::write(&text, format!("#!/bin/sh\n{lines}\n")).unwrap();
                // written by another program: a file that a test in parallel inherits open for
                // writing cannot be executed
                let made = Command::new("install").args(["-m", "755"]).args([&text, &path]).status().unwrap();
                assert!(made.success());
            }
            path.into_os_string()
        };
        let tools = Tools {
            package: folder.path().into(),
            cargo: put("cargo", cargo),
            rustc: put("rustc", rustc),
            rustup: put("rustup", rustup),
        };
        (folder, tools)
    }

    #[test]
    fn a_target_that_is_there_needs_no_rustup() {
        let (_folder, tools) = scripts("[ $4 = wasm32-unknown-unknown ] && pwd", "", "");
        tools.add_target(WASM).unwrap();
    }

    #[test]
    fn a_target_that_is_missing_is_added() {
        let (folder, tools) = scripts("echo /nowhere", "echo $* > asked", "");
        tools.add_target(WASM).unwrap();
        assert_eq!(std::fs::read_to_string(folder.path().join("asked")).unwrap(), "target add wasm32-unknown-unknown\n");
    }

    #[test]
    fn a_target_that_cannot_be_added_gets_one_line() {
        let no_net = "echo 'info: downloading' >&2; echo 'error: could not download' >&2; echo 'Caused by: dns' >&2; exit 1";
        for (rustup, says) in [("", "https://rustup.rs"), (no_net, "could not download: run `rustup target add")] {
            let (_folder, tools) = scripts("echo /nowhere", rustup, "");
            let error = tools.add_target(WASM).unwrap_err();
            let output = error.to_string();
            assert!(
                output.contains(says) && output.contains(WASM) && !output.contains('\n') && error.exit_code() == 2,
                "{output}"
            );
        }
    }

    #[test]
    fn cargo_says_where_it_put_what_it_built() {
        let program = r#"echo '{"reason":"compiler-artifact","target":{"name":"other"},"executable":"/x/other"}'
            echo 'no message'
            echo '{"reason":"compiler-artifact","target":{"name":"palpate-live"},"executable":"/x/release/palpate-live"}'"#;
        let (_folder, tools) = scripts("", "", program);
        assert_eq!(tools.build(&[], "palpate-live", "").unwrap(), Path::new("/x/release/palpate-live"));
        let module = r#"echo '{"reason":"compiler-artifact","target":{"name":"palpate_live"},"executable":null,"filenames":["/x/a.rlib","/x/a.wasm"]}'"#;
        let (_folder, tools) = scripts("", "", module);
        assert_eq!(tools.build(&[], "palpate_live", "").unwrap(), Path::new("/x/a.wasm"));
    }

    #[test]
    fn a_build_is_announced_only_if_something_is_compiled() {
        let announced = |messages: &str| {
            let mut said = Vec::new();
            tell(messages.as_bytes(), "palpate-full", &mut |line| said.push(line.to_owned()));
            said
        };
        let waited = "    Blocking waiting for file lock on build directory\n";
        let done = "    Finished `release` profile [optimized] target(s) in 0.10s\n";
        assert_eq!(announced(&format!("{waited}{done}")), [waited.trim_end()]);
        let said = announced(&format!("   Compiling palpate v0.1.0\n   Compiling palpate-sim v0.1.0\nwarning: odd\n{done}"));
        assert_eq!(said[..2], ["building palpate-full: the first time takes some minutes", "warning: odd"]);
        assert!(said.len() == 3 && said[2].starts_with("built in "), "{said:?}");
    }

    #[test]
    fn what_is_wrong_with_a_build_is_told_apart() {
        for (cargo, says) in [("", INSTALL), ("exit 101", "what it said above"), ("echo {}", "no file of palpate-live")] {
            let (_folder, tools) = scripts("", "", cargo);
            let output = tools.build(&["--release"], "palpate-live", "").unwrap_err().to_string();
            assert!(output.contains(says) && output.contains("cargo build --release"), "{output}");
        }
    }
}
