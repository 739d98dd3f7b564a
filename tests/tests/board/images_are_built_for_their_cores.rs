//! The compiler knows the core of each flashed image: on a Cortex-M4F and a Cortex-M33 a chained
//! multiply-add costs more cycles than a product and a sum, so the tick has none. Code and patch
//! are where the core does not wait for them, as far as the chip has such memory.

use std::path::Path;

use palpate_tests::disassembly::{self, sections};
use palpate_tests::emulator::build_flashed;
use palpate_tests::register_model::Flashed;

#[test]
fn no_tick_multiplies_and_adds_in_one_instruction() {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    for board in [Flashed::F446, Flashed::G474, Flashed::Pico2] {
        let listing = disassembly::of(&build_flashed(target, board.name()).unwrap());
        let header = |text: &str| text.lines().find(|line| line.ends_with(">:")).unwrap_or_default().to_owned();
        let functions = |of: &[&str]| -> String {
            listing.split("\n\n").filter(|text| of.iter().any(|name| header(text).contains(&format!("{name}::h")))).collect()
        };
        let tick = functions(&["palpate::tick::tick", "palpate::stages::force::foundation::press", "integrate::advance"]);
        let count = |kind: &str| tick.matches(kind).count();
        let (chained, products) = (count("\tvmla.f32") + count("\tvmls.f32"), count("\tvmul.f32"));
        println!("{board:?}: {products} products, {chained} chained");
        assert!(products > 300, "{board:?}: the tick is not in the listing");
        assert_eq!(chained, 0, "{board:?} is built for another core");
        assert!(functions(&["armv7em::push_tets"]).contains("vldmia"), "{board:?}: the tets are not in assembly");
    }
}

#[test]
fn tick_and_patch_are_in_fast_memory() {
    const RAM: u64 = 0x2000_0000;
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    // ITCM; none, since code in the RAM of this chip is no faster; CCM; the RAM itself
    let places =
        [(Flashed::H743, Some(0)), (Flashed::F446, None), (Flashed::G474, Some(0x1000_0000)), (Flashed::Pico2, Some(RAM))];
    for (board, code_from) in places {
        let all = sections(&build_flashed(target, board.name()).unwrap());
        let section =
            |name: &str| all.iter().find(|(own, bytes, _)| own == name && *bytes > 10_000).map(|(.., address)| *address);
        assert!(section(".patch").is_some_and(|address| address > RAM), "{board:?}: {all:?}");
        let code = section(".fast_code");
        assert_eq!(code.map(|address| address & 0xF000_0000), code_from, "{board:?}: {all:?}");
    }
}
