//! Every instruction of the firmware is assigned to the class of its mnemonic.

use std::path::Path;

use palpate_tests::{
    disassembly,
    emulator::build_firmware,
    thumb::{Class, Instruction, classify},
};

/// Class of a mnemonic, from the names in the Arm manual and independent of the encoding.
fn class_of(mnemonic: &str, operands: &str) -> Class {
    let name = mnemonic.split('.').next().unwrap_or(mnemonic);
    let starts = |names: &[&str]| names.iter().any(|n| name.starts_with(n));
    let core = |operand: Option<&str>| operand.is_some_and(|o| o.trim().starts_with(['r', 'l', 'a', 'p']) || o.trim() == "sp");
    match name {
        _ if starts(&["vldr", "vldm", "vpop"]) => Class::FpLoad,
        _ if starts(&["vstr", "vstm", "vpush"]) => Class::FpStore,
        _ if starts(&["vmla", "vmls", "vnmla", "vnmls", "vfma", "vfms", "vfnma", "vfnms"]) => Class::FpMultiplyAdd,
        _ if starts(&["vdiv"]) => Class::FpDivide,
        _ if starts(&["vsqrt"]) => Class::FpRoot,
        _ if starts(&["vmrs", "vmsr"]) => Class::FpMove,
        _ if starts(&["vmov"]) && (core(operands.split(',').next()) || core(operands.split(',').nth(1))) => Class::FpMove,
        _ if name.starts_with('v') => Class::FpOp,
        "pld" | "pli" => Class::System,
        _ if starts(&["ldr", "ldm", "pop"]) => Class::Load,
        _ if starts(&["str", "stm", "push"]) => Class::Store,
        _ if starts(&["sdiv", "udiv"]) => Class::IntegerDivide,
        _ if starts(&["cbz", "cbnz", "tbb", "tbh", "bx", "blx"]) => Class::Branch,
        _ if starts(&[
            "bkpt", "svc", "udf", "trap", "cps", "dmb", "dsb", "isb", "mrs", "msr", "nop", "wfi", "wfe", "sev", "yield", "clrex",
        ]) =>
        {
            Class::System
        }
        _ if starts(&["bic", "bfi", "bfc"]) => Class::Integer,
        _ if name.starts_with('b') => Class::Branch,
        _ if starts(&["mov", "add"]) && operands.starts_with("pc") => Class::Branch,
        _ => Class::Integer,
    }
}

#[test]
fn classes_agree_with_the_disassembler() {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    let elf = build_firmware(target, &[]).unwrap();
    let listing = disassembly::of(&elf);
    let mut checked = 0;
    for line in listing.lines() {
        // example: "  43e: ed90 0a00  \tvldr\ts0, [r0]"
        let Some((codes, text)) = line.split_once(": ").and_then(|(_, rest)| rest.split_once('\t')) else {
            continue;
        };
        let mut codes = codes.split_whitespace().map(|c| u16::from_str_radix(c, 16));
        let (Some(Ok(first)), second) = (codes.next(), codes.next()) else {
            continue;
        };
        let (mnemonic, operands) = text.split_once('\t').unwrap_or((text, ""));
        if mnemonic.starts_with('.') || mnemonic.starts_with('<') {
            continue; // data between the code
        }
        let second = second.map(Result::unwrap);
        let Some(Instruction { class, bytes, .. }) = classify(first, second.unwrap_or(0)) else { panic!("unknown: {line}") };
        assert_eq!(bytes, if second.is_some() { 4 } else { 2 }, "{line}");
        assert_eq!(class, class_of(mnemonic.trim(), operands), "{line}");
        checked += 1;
    }
    println!("{checked} instructions");
    assert!(checked > 3_000);
}
