//! Disassembly of an image by the toolchain's own disassembler.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Path of a program of the toolchain's `llvm-tools`.
fn tool(name: &str) -> PathBuf {
    let rustc = |what: &[&str]| {
        let output = Command::new("rustc").args(what).output().expect("rustc runs");
        String::from_utf8(output.stdout).expect("rustc prints text")
    };
    let version = rustc(&["-vV"]);
    let host = version.lines().find_map(|line| line.strip_prefix("host: ")).expect("rustc names its host");
    Path::new(rustc(&["--print", "sysroot"]).trim()).join(format!("lib/rustlib/{host}/bin/{name}"))
}

/// Listing of an image's code, with demangled names. Code that is copied to RAM has a section of
/// its own, which is no code to the disassembler.
///
/// # Panics
/// Panics if the toolchain has no `llvm-tools`; `rust-toolchain.toml` asks for them.
pub fn of(elf: &Path) -> String {
    let what = ["-D", "-C", "--section=.text", "--section=.fast_code", "--mcpu=cortex-m7"];
    let output = Command::new(tool("llvm-objdump")).args(what).arg(elf).output().expect("llvm-objdump runs");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

/// Sections of an image: name, size [bytes], address.
///
/// # Panics
/// Panics if the toolchain has no `llvm-tools`.
pub fn sections(elf: &Path) -> Vec<(String, u64, u64)> {
    let output = Command::new(tool("llvm-size")).args(["-A", "-d"]).arg(elf).output().expect("llvm-size runs");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let row = |line: &str| {
        let mut words = line.split_whitespace();
        Some((words.next()?.to_owned(), words.next()?.parse().ok()?, words.next()?.parse().ok()?))
    };
    text.lines().filter_map(row).collect()
}

/// Address of the variable whose path ends with `end`.
///
/// # Panics
/// Panics if the toolchain has no `llvm-tools` or the image has no such variable.
pub fn variable(elf: &Path, end: &str) -> u64 {
    let output = Command::new(tool("llvm-nm")).arg("-C").arg(elf).output().expect("llvm-nm runs");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let row = text.lines().find(|line| line.split("::h").any(|path| path.ends_with(end))).expect("the variable is in the image");
    let address = row.split_whitespace().next().and_then(|digits| u64::from_str_radix(digits, 16).ok());
    address.expect("its row begins with its address")
}
