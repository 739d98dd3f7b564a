//! The machine's C and C++ compilers, for programs that use the library of `host-sim/bindings`.

use std::ffi::OsStr;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::palpate_command::repository;

/// Language of a source file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Language {
    /// C99.
    C,
    /// C++17.
    Cpp,
}

impl Language {
    /// Language of a file, by its extension.
    pub fn of(file: &Path) -> Self {
        if file.extension() == Some(OsStr::new("c")) { Self::C } else { Self::Cpp }
    }

    /// Command of the compiler: the value of `CC` or `CXX`, or the system's default.
    pub fn compiler(self) -> String {
        let (variable, name) = match self {
            Self::C => ("CC", "cc"),
            Self::Cpp => ("CXX", "c++"),
        };
        std::env::var(variable).unwrap_or_else(|_| name.into())
    }

    /// Whether the compiler is installed; prints a message if not.
    pub fn is_here(self) -> bool {
        has(&self.compiler(), "--version", "programs of that language are not tested")
    }
}

/// Whether `tool` starts and succeeds with the argument `asked`; if not, prints what is skipped.
pub fn has(tool: &str, asked: &str, skipped: &str) -> bool {
    let started = Command::new(tool).arg(asked).output().is_ok_and(|output| output.status.success());
    if !started {
        println!("skipped: {tool} is not on this machine, so {skipped}");
    }
    started
}

/// Path of the static library, which cargo built beside this test.
///
/// # Panics
/// Panics if the library was not built.
pub fn library() -> PathBuf {
    let own = std::env::current_exe().expect("a test knows its own program");
    let path = own.with_file_name("libpalpate_c.a");
    assert!(path.exists(), "{} was not built with the tests", path.display());
    path
}

/// Compiles a file with all warnings as errors: to a program linked with the library if `linked`,
/// otherwise to an object. Contraction to fused multiply-add is off, because results are compared
/// exactly.
///
/// # Panics
/// Panics if the compiler reports an error.
pub fn compile(file: &Path, folder: &Path, name: &str, linked: bool, more: &[&str]) -> PathBuf {
    let (language, made) = (Language::of(file), folder.join(name));
    let bindings = repository().join("host-sim/bindings");
    let standard = if language == Language::C { "-std=c99" } else { "-std=c++17" };
    let mut command = Command::new(language.compiler());
    command.args([standard, "-O1", "-g", "-Wall", "-Wextra", "-pedantic", "-Werror", "-ffp-contract=off"]);
    command.arg("-I").arg(bindings.join("include")).arg("-I").arg(bindings.join("examples/adapters/stubs"));
    command.args(more).arg(file).arg("-o").arg(&made);
    match linked {
        true => command.arg(library()).args(["-lpthread", "-ldl", "-lm"]),
        false => command.arg("-c"),
    };
    let output = command.output().expect("the compiler was asked for its version before");
    assert!(output.status.success(), "{}: {}", file.display(), text(&output.stderr));
    made
}

/// Runs a program to its end and returns its standard output.
///
/// # Panics
/// Panics if the program cannot be started or fails.
pub fn run(command: &mut Command) -> String {
    let Output { status, stdout, stderr } = command.output().expect("the program was just built");
    assert!(status.success(), "{command:?}: {status}\n{}{}", text(&stdout), text(&stderr));
    text(&stdout)
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}
