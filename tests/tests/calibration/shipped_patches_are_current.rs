//! The patches in the firmware are what `pack` makes of default block and nodule today, byte for
//! byte. On the M4F, where 65 nodes would fit, the block has 61: neither is calibrated, and the
//! held force of the larger mesh is 10 % off, that of the smaller 2 %.

use palpate_tests::palpate_command::{Desk, palpate, repository};

#[test]
fn the_firmware_ships_what_pack_makes() {
    for (scene, board, nodes) in
        [("block", "m4f-168", &["--nodes", "61"][..]), ("block", "m7-480", &[]), ("nodule", "m7-480", &[])]
    {
        let desk = Desk::default();
        let pack = [&["pack", "--scene", scene, "--board", board, "--out", "out"], nodes].concat();
        let outcome = palpate(env!("CARGO_TARGET_TMPDIR"), desk.folder(), &pack);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        let name = format!("{scene}-{board}.patch");
        let made = std::fs::read(desk.folder().join("out").join(&name)).unwrap();
        let shipped = std::fs::read(repository().join("firmware/patches").join(&name)).unwrap();
        assert!(
            made == shipped,
            "pack again: cargo run --release -- pack --scene {scene} --board {board} {} --out firmware/patches",
            nodes.join(" ")
        );
    }
}
