//! The firmware's patches are byte-identical to the present output of `pack` for the M7's default
//! block and nodule and for the M4F's own calibrated patch, and so is the record of the latter.

use palpate_tests::palpate_command::{Desk, palpate, repository};

#[test]
fn the_firmware_ships_what_pack_makes() {
    let shipped = repository().join("firmware/patches");
    let block = std::fs::read_to_string(repository().join("host-sim/scenes/block.toml")).unwrap();
    let calibrated = block
        .replace("nodes = 410\n", "")
        .replace("[drive]", &format!("[solver]\npatch = {:?}\n[drive]", shipped.join("block-m4f-168.patch")));
    for (name, scene, board) in
        [("block", calibrated.as_str(), "m4f-168"), ("block", &block, "m7-480"), ("nodule", "nodule", "m7-480")]
    {
        let desk = Desk::default();
        let scene = match scene.lines().count() {
            1 => scene,
            _ => {
                std::fs::write(desk.folder().join("scene.toml"), scene).unwrap();
                "scene.toml"
            }
        };
        let pack = ["pack", "--scene", scene, "--board", board, "--out", "out"];
        let outcome = palpate(env!("CARGO_TARGET_TMPDIR"), desk.folder(), &pack);
        assert_eq!(outcome.code, Some(0), "{}", outcome.stderr);
        let name = format!("{name}-{board}.patch");
        let record = format!("{name}.json");
        let records = if board == "m4f-168" { &[name.clone(), record][..] } else { &[name.clone()][..] };
        for file in records {
            let made = std::fs::read(desk.folder().join("out").join(file)).unwrap();
            let ships = std::fs::read(shipped.join(file)).unwrap();
            assert!(made == ships, "pack again: cargo run --release -- pack --board {board} --out firmware/patches: {file}");
        }
    }
}
