//! The image fits the board's flash, RAM and stack. `unsafe` code is confined to the board's
//! folder, to the functions that C programs call, and to the tick's assembly, and every use states
//! its reason.

use std::path::{Path, PathBuf};

use palpate_board::EmulatedBoard;
use palpate_controller::script::LEAD_TICKS;
use palpate_tests::disassembly::sections;
use palpate_tests::emulator::{Run, build_firmware};
use palpate_tests::flash_patch::in_flash;

/// Largest size of the image in flash, without the patch [bytes]. It contains the paths of seven
/// files in cargo's folder, so it grows by 7 bytes with each letter of that folder's path.
const FLASH: u64 = 132 * 1024;
/// RAM of the board, which has to hold all reserved memory and the stack [bytes].
const RAM: u64 = 128 * 1024;

fn image() -> PathBuf {
    build_firmware(Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap(), &[]).unwrap()
}

#[test]
fn flash_and_ram_are_kept() {
    let all = sections(&image());
    let sum =
        |names: &[&str]| all.iter().filter(|(name, ..)| names.contains(&name.as_str())).map(|(_, bytes, _)| bytes).sum::<u64>();
    let flash = sum(&[".vector_table", ".text", ".rodata", ".data"]) - in_flash().len() as u64;
    let (statics, stack) = (sum(&[".data", ".bss", ".uninit"]), 16 * 1024);
    println!("flash {flash} bytes without the patch; RAM {statics} bytes of statics and {stack} of stack");
    assert!(statics > 60_000 && flash > 40_000, "sections are not read: {all:?}");
    assert!(flash <= FLASH, "{flash} bytes of flash");
    assert!(statics + stack <= RAM, "{} bytes of RAM", statics + stack);
}

#[test]
fn the_stack_lies_below_the_statics_and_half_of_it_is_free() {
    let elf = image();
    let lowest = sections(&elf)
        .into_iter()
        .filter(|(_, bytes, address)| *bytes > 0 && *address >= 0x2000_0000)
        .map(|(.., address)| address)
        .min();
    assert!(
        lowest.is_some_and(|address| address >= 0x2000_4000),
        "statics begin at {lowest:x?}: an overflow would overwrite them"
    );
    let run = Run {
        machine: EmulatedBoard::M4f,
        shift: 3,
        ticks: 2_000,
        lead_ticks: LEAD_TICKS,
        crash: None,
        restart: false,
        exec_log: None,
    };
    let outcome = run.start(&elf).unwrap();
    let [used, bytes] = ["stack_used", "stack_bytes"].map(|key| outcome.number(key).unwrap());
    println!("stack: {used} of {bytes} bytes");
    assert!(used > 500 && 2 * used <= bytes, "{used} of {bytes} bytes of stack");
}

#[test]
fn unsafe_code_is_the_board_s_and_the_boundary_s_to_c() {
    let folder = |name: &str| Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name);
    let (source, bindings) = (folder("firmware/src"), folder("host-sim/bindings/src"));
    let assembly = folder("core/src/stages/force/armv7em.rs");
    let others =
        ["core/src", "firmware/controller/src", "host-sim/bindings/python/src", "host-sim/loop/src", "host-sim/tissue/src"];
    let (mut files, mut bad) = (vec![source.clone(), bindings.clone()], Vec::new());
    files.extend(others.map(folder));
    let (mut read, mut blocks) = (0, 0);
    while let Some(path) = files.pop() {
        if path.is_dir() {
            files.extend(std::fs::read_dir(&path).unwrap().map(|entry| entry.unwrap().path()));
            continue;
        }
        let text = std::fs::read_to_string(&path).unwrap();
        read += 1;
        let uses =
            text.lines().filter(|l| l.contains("unsafe {") || l.contains("unsafe impl") || l.contains("unsafe fn")).count();
        let reasons = text.matches("// SAFETY:").count();
        let of_board = path.starts_with(source.join("board"));
        let of_boundary = ["ffi.rs", "pointers.rs"].map(|file| bindings.join(file)).contains(&path);
        if of_boundary {
            let blocks = text.matches("unsafe {").count();
            assert!(blocks > 4 && reasons >= blocks, "{}: {blocks} blocks, {reasons} reasons", path.display());
            let functions = text.matches("unsafe fn ").count() + text.matches("unsafe extern \"C\" fn ").count();
            assert_eq!(text.matches("/// # Safety").count(), functions, "{}", path.display());
        }
        if path == assembly {
            let blocks = text.matches("unsafe {").count();
            assert!(blocks == 3 && reasons == blocks, "{}: {blocks} blocks, {reasons} reasons", path.display());
        } else if uses > 0 && !of_board && !of_boundary {
            bad.push(path.display().to_string());
        }
        if of_board {
            blocks += uses;
            // exception handlers are `unsafe fn` because their crate requires it, so they need no
            // reason
            let handlers = text.matches("exception]").count() + text.matches("#[interrupt]").count();
            assert!(reasons + handlers >= uses, "{}: {uses} uses, {reasons} reasons", path.display());
        }
    }
    assert_eq!(bad, [""; 0], "unsafe outside of board/ and of the boundary to C");
    assert!(read > 25 && blocks > 10, "{read} files, {blocks} blocks: nothing was looked at");
}
