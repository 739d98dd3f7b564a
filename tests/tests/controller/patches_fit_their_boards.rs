//! The build of an image refuses a patch that its board would refuse, and no other.

use palpate_tests::palpate_command::repository;

#[path = "../../../firmware/build/patch.rs"]
mod patch;

#[test]
fn each_shipped_patch_is_taken_for_its_boards_and_for_no_slower_one() {
    let shipped = |name: &str| std::fs::read(repository().join("firmware/patches").join(name)).unwrap();
    let all = ["mps2", "nucleo-h743zi", "nucleo-f446re", "nucleo-g474re", "pico2"];
    for (name, boards) in
        [("block-m7-480.patch", 2), ("nodule-m7-480.patch", 2), ("block-m4f-168.patch", 4), ("liver-m4f-168.patch", 5)]
    {
        for (n, board) in all.into_iter().enumerate() {
            let fits = patch::fits(board, &shipped(name));
            assert_eq!(fits.is_ok(), n < boards, "{name} on {board}: {fits:?}");
            if let Err(why) = fits {
                assert!(why.contains("cycles per tick") && why.contains(&format!("--board {board}")), "{why}");
            }
        }
    }
    let mut broken = shipped("liver-m4f-168.patch");
    broken[200] ^= 1;
    assert!(patch::fits("pico2", &broken).unwrap_err().contains("checksum"));
    assert_eq!(patch::fits("a board of another's", &broken), Ok(()));
}
