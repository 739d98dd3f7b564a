//! Cycles of an executed tick by independent models: LLVM's scheduling models of the Cortex-M4 and
//! Cortex-M7 in `llvm-mca` (Debian: llvm), applied to every instruction in the order of execution;
//! and the stalls in the Cortex-M4F's manual that a sum over single instructions omits.
//!
//! **Estimates, not hardware timing**: they include neither memory waits nor interrupts. The model
//! of the Cortex-M4 charges one cycle for a load, the manual two.

use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use crate::disassembly;
use crate::exec_log::LogError;
use crate::firmware_image::FirmwareImage;
use crate::thumb::classify;

/// Pipeline refill of a taken branch [cycles], as `instruction_mix` charges it.
const REFILL: f64 = 1.5;
/// Largest number of instruction kinds for which a model may have no entry; each is found by one
/// failed run.
const MOST_KINDS: usize = 24;

/// A core for which LLVM has a model.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Core {
    /// Cortex-M4.
    M4,
    /// Cortex-M7, which issues two instructions at once.
    M7,
}

/// One instruction as text.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Line {
    mnemonic: String,
    operands: String,
}

/// Instructions of an image, by address.
pub struct Listing(BTreeMap<u32, Line>);

/// Addresses of the instructions that each call of `function` executed, callees included.
pub fn executed(
    function: &str,
    image: &FirmwareImage,
    log: impl Iterator<Item = Result<u32, LogError>>,
) -> Result<Vec<Vec<u32>>, LogError> {
    let entry = image.function_named(function).map(|function| function.address);
    let (mut calls, mut open, mut previous) = (Vec::new(), None, None);
    for address in log {
        let address = address?;
        let returned = matches!(&open, Some((back, _)) if *back == address);
        if let (true, Some((_, executed))) = (returned, open.take_if(|_| returned)) {
            calls.push(executed);
        }
        let called = previous.and_then(|from| {
            let instruction = classify(image.halfword_at(from)?, image.halfword_at(from + 2).unwrap_or(0))?;
            instruction.calls.then_some(from + instruction.bytes)
        });
        if let (None, true, Some(back)) = (&open, Some(address) == entry, called) {
            open = Some((back, Vec::new()));
        }
        if let Some((_, executed)) = &mut open {
            executed.push(address);
        }
        previous = Some(address);
    }
    Ok(calls)
}

impl Listing {
    /// Disassembles an image.
    pub fn of(elf: &Path) -> Self {
        Self(disassembly::of(elf).lines().filter_map(parse).collect())
    }

    fn lines<'a>(&'a self, executed: &'a [u32]) -> impl Iterator<Item = (u32, &'a Line)> {
        executed.iter().filter_map(|address| Some((*address, self.0.get(address)?)))
    }

    /// Cycles that a Cortex-M4F stalls because an instruction reads the result of the
    /// floating-point operation right before it (Arm DDI 0439B, table 7-1: one cycle).
    pub fn result_stalls(&self, executed: &[u32]) -> u64 {
        let mut result: Option<&str> = None;
        let mut stalls = 0;
        for (_, line) in self.lines(executed) {
            stalls += u64::from(result.is_some_and(|register| line.reads(register)));
            result = line.result();
        }
        stalls
    }

    /// Cycles of these instructions on a core; `None` if `llvm-mca` is not installed.
    ///
    /// # Panics
    /// Panics if `llvm-mca` cannot be run, or refuses its input without naming the line.
    pub fn cycles(&self, core: Core, executed: &[u32]) -> Option<f64> {
        let mut left_out: Vec<String> = Vec::new();
        for _ in 0..MOST_KINDS {
            let (text, alone) = self.text(executed, core, &left_out);
            let output = run(core, &text)?;
            let found = |key: &str| output.lines().find_map(|line| line.trim().strip_prefix(key)).map(str::trim);
            if let Some(total) = found("Total Cycles:") {
                return Some(total.parse::<f64>().expect("llvm-mca prints a number") + alone);
            }
            let unsupported = found("note: instruction:").expect("llvm-mca names what it refuses");
            left_out.push(unsupported.split_whitespace().next().expect("an instruction has a name").to_owned());
        }
        panic!("llvm-mca refuses {left_out:?}");
    }

    /// The instructions as text for the model, and the cycles of those that are left out. A jump or
    /// an instruction without a model entry counts one cycle; on a Cortex-M4 a taken jump also
    /// counts its refill.
    fn text(&self, executed: &[u32], core: Core, left_out: &[String]) -> (String, f64) {
        let mut text = String::from(".syntax unified\n.thumb\n");
        let (mut alone, mut conditional) = (0.0, 0);
        let mut follows = executed.iter().skip(1);
        for (address, line) in self.lines(executed) {
            let next = follows.next().copied().unwrap_or(address);
            if line.is_it() {
                conditional = line.mnemonic.len() - 1; // the IT instruction: it, itt, ite, ...
                alone += 1.0;
                continue;
            }
            let plain = if conditional > 0 { line.unconditional() } else { line.clone() };
            conditional = conditional.saturating_sub(1);
            let line = plain;
            if line.jumps() {
                let taken = !(address + 2..=address + 4).contains(&next);
                alone += 1.0 + if taken && core == Core::M4 { REFILL } else { 0.0 };
            } else if left_out.contains(&line.mnemonic) {
                alone += 1.0;
            } else {
                text += &format!("{} {}\n", line.mnemonic, line.operands);
            }
        }
        (text, alone)
    }
}

/// Runs the model on straight-line code that is executed once.
fn run(core: Core, text: &str) -> Option<String> {
    let cpu = match core {
        Core::M4 => "-mcpu=cortex-m4",
        Core::M7 => "-mcpu=cortex-m7",
    };
    let options = ["-mtriple=thumbv7em-none-eabihf", cpu, "-iterations=1", "-instruction-info=0", "-resource-pressure=0"];
    let mut child = Command::new("llvm-mca")
        .args(options)
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .ok()?;
    let mut input = child.stdin.take().expect("it is piped");
    let text = text.to_owned();
    let feeding = std::thread::spawn(move || {
        // a model that refuses its input closes the pipe
        let _ = input.write_all(text.as_bytes());
    });
    let output = child.wait_with_output().expect("llvm-mca ends");
    feeding.join().expect("writing does not panic");
    Some(String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr))
}

/// Parses a line such as `   1a2b: ed90 0a00 \tvldr\ts0, [r0]`.
fn parse(text: &str) -> Option<(u32, Line)> {
    let (address, rest) = text.split_once(':')?;
    let address = u32::from_str_radix(address.trim(), 16).ok()?;
    let (_, instruction) = rest.split_once('\t')?;
    let instruction = instruction.split(['@', '<', ';']).next()?.trim();
    let (mnemonic, operands) = instruction.split_once(char::is_whitespace).unwrap_or((instruction, ""));
    (!mnemonic.starts_with('.')).then(|| (address, Line { mnemonic: mnemonic.into(), operands: operands.trim().into() }))
}

impl Line {
    fn is_it(&self) -> bool {
        self.mnemonic.starts_with("it") && self.mnemonic.chars().skip(1).all(|letter| matches!(letter, 't' | 'e'))
    }

    /// The mnemonic without its condition, which is the two letters before the first dot.
    fn unconditional(&self) -> Self {
        let (name, kind) = self.mnemonic.split_once('.').map_or((&*self.mnemonic, String::new()), |(n, k)| (n, format!(".{k}")));
        let name = name.get(..name.len().saturating_sub(2)).unwrap_or_default();
        Self { mnemonic: format!("{name}{kind}"), operands: self.operands.clone() }
    }

    /// Whether the instruction may jump.
    fn jumps(&self) -> bool {
        let name = self.mnemonic.split('.').next().unwrap_or_default();
        let branch = matches!(name, "b" | "bl" | "blx" | "bx" | "cbz" | "cbnz" | "tbb" | "tbh")
            || (name.len() == 3 && name.starts_with('b') && !matches!(name, "bic" | "bfi" | "bfc"));
        branch || ((name.starts_with("pop") || name.starts_with("ld")) && self.operands.contains("pc}"))
    }

    /// The register that the instruction writes, if it is floating-point arithmetic.
    fn result(&self) -> Option<&str> {
        let name = self.mnemonic.split('.').next().unwrap_or_default();
        let arithmetic = ["vadd", "vsub", "vmul", "vnmul", "vdiv", "vsqrt", "vmla", "vmls", "vnmla", "vnmls", "vfma", "vfms"];
        let computes = arithmetic.iter().any(|kind| name.starts_with(kind));
        computes.then(|| self.operands.split(',').next().map(str::trim)).flatten()
    }

    /// Whether the instruction reads this floating-point register.
    fn reads(&self, register: &str) -> bool {
        let name = self.mnemonic.split('.').next().unwrap_or_default();
        let listed = |words: &str| words.split(|letter: char| !letter.is_ascii_alphanumeric()).any(|word| word == register);
        // a store reads all its registers, a load reads none, and arithmetic reads its first
        // operand only in order to add to it
        let reads_first = ["vst", "vpush", "vcmp", "vmla", "vmls", "vnmla", "vnmls", "vfma", "vfms"];
        match name {
            _ if name.starts_with("vld") || name.starts_with("vpop") => false,
            _ if !name.starts_with('v') => false,
            _ if reads_first.iter().any(|kind| name.starts_with(kind)) => listed(&self.operands),
            _ => self.operands.split_once(',').is_some_and(|(_, sources)| listed(sources)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{Core, Line, Listing, parse};

    fn line(text: &str) -> Line {
        parse(&format!("   10: 0000\t{text}")).expect("a line of a listing").1
    }

    #[test]
    fn lines_are_read_and_jumps_known() {
        assert_eq!(parse("    b490: 8806         \tldrh\tr6, [r0]"), Some((0xB490, line("ldrh\tr6, [r0]"))));
        assert_eq!(parse("0000b490 <palpate::tick>:"), None);
        for jump in ["bne\t0x10 <x>", "b.w\t0x10", "bl\t0x10", "bx\tlr", "pop\t{r4, pc}", "cbz\tr0, 0x10"] {
            assert!(line(jump).jumps(), "{jump}");
        }
        for straight in ["bic\tr0, r1", "bfi\tr0, r1, #1, #2", "pop\t{r4, r5}", "vmov.f32\ts0, s1"] {
            assert!(!line(straight).jumps(), "{straight}");
        }
    }

    #[test]
    fn conditions_are_taken_off() {
        assert!(line("itte\tne").is_it());
        assert!(!line("vmul.f32\ts0, s1, s2").is_it());
        assert_eq!(line("vmovge.f32\ts0, s1").unconditional(), line("vmov.f32\ts0, s1"));
        assert_eq!(line("movgt\tr0, r1").unconditional(), line("mov\tr0, r1"));
    }

    fn listing(lines: &[&str]) -> (Listing, Vec<u32>) {
        let addresses = (0..lines.len() as u32).map(|at| 4 * at);
        (Listing(addresses.clone().zip(lines.iter().map(|text| line(text))).collect()), addresses.collect())
    }

    #[test]
    fn a_stall_needs_the_very_next_instruction() {
        let (code, executed) = listing(&[
            "vmul.f32\ts0, s1, s2",
            "vadd.f32\ts3, s0, s4", // waits
            "vldr\ts5, [r0]",
            "vsub.f32\ts6, s3, s5",  // does not wait, since the load is in between
            "vstmia\tr0!, {s6, s7}", // waits
        ]);
        assert_eq!(code.result_stalls(&executed), 2);
    }

    /// In a chain of products each product waits for the one before; independent products do not
    /// wait. Without `llvm-mca` nothing is checked.
    #[test]
    fn the_model_knows_latency_and_pairs() {
        let (chain, executed) = listing(&["vmul.f32\ts0, s0, s1"; 64]);
        let (apart, _) = listing(&["vmul.f32\ts0, s2, s1", "vldr\ts4, [r0]"].repeat(32));
        let Some(waits) = chain.cycles(Core::M7, &executed) else {
            println!("skipped: there is no llvm-mca (Debian: apt-get install llvm)");
            return;
        };
        assert!(waits >= 3.0 * 64.0, "{waits}");
        assert!(apart.cycles(Core::M7, &executed).is_some_and(|cycles| cycles < waits / 2.0));
    }
}
