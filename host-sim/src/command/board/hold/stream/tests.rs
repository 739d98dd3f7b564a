use palpate_loop::board_trace::Columns;

use super::example::{RECORD, identity};
use super::*;

#[test]
fn a_growing_file_has_every_row_at_once_and_reads_back_as_it_was_written() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("new/felt.csv");
    let mut growing = Growing::begin(&path).unwrap();
    let lines = || std::fs::read_to_string(&path).unwrap().lines().map(String::from).collect::<Vec<_>>();
    assert_eq!(lines(), [COLUMNS.join(",")]);
    for tick in [20, 40, 4_000_000_000] {
        growing.add(&Record { tick, ..RECORD }, &identity()).unwrap();
        assert!(lines().last().unwrap().starts_with(&format!("{tick},")), "not yet there: {:?}", lines());
    }
    let text = lines();
    let row = Columns::of(&text[0]).unwrap().row(text.last().unwrap()).unwrap();
    assert_eq!((row.tick, row.mode, row.fault, row.outputs_on), (RECORD.tick, 4, 8, true));
    assert_eq!((row.tip_m, row.depth_m), (RECORD.position_m, RECORD.depth_m));
    assert_eq!((row.model_n, row.applied_n), (RECORD.model_n, RECORD.applied_n));
    assert_eq!((row.limiters, row.energy_given_j, row.tick_us), (65, -1e-6, Some(2.0)));
    assert_eq!((row.patch_checksum, row.youngs_modulus_pa), (0x0bad_cafe, 3500.0));
    // another run starts the file again
    drop(growing);
    let _again = Growing::begin(&path).unwrap();
    assert_eq!(lines().len(), 1);
}

#[test]
fn a_whole_file_is_not_there_before_it_is_done() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("felt.csv");
    let mut rows = Rows::begin(&path).unwrap();
    rows.add(&RECORD, &identity()).unwrap();
    assert!(!path.exists());
    rows.publish().unwrap();
    assert_eq!(std::fs::read_to_string(&path).unwrap().lines().count(), 2);
}

#[test]
fn both_files_have_the_same_rows_and_may_not_be_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let [whole, growing] = ["whole.csv", "growing.csv"].map(|name| folder.path().join(name));
    let mut files = Files::begin(Some(&whole), Some(&growing)).unwrap();
    files.add(&RECORD, &identity()).unwrap();
    files.publish().unwrap();
    assert_eq!(std::fs::read(&whole).unwrap(), std::fs::read(&growing).unwrap());
    let permissions = |path| std::fs::metadata(path).unwrap().permissions();
    assert_eq!(permissions(&whole), permissions(&growing), "others read both or none");
    let why = Files::begin(Some(&whole), Some(&whole)).err().unwrap().to_string();
    assert!(why.ends_with("--out and --stream name the same file: give them two"), "{why}");
    assert_eq!(std::fs::read_to_string(&whole).unwrap().lines().count(), 2, "what was there stays");
}

#[test]
fn a_folder_in_place_of_a_file_is_refused_with_the_option() {
    let folder = tempfile::tempdir().unwrap();
    for (option, refused) in [("--out", Rows::begin(folder.path()).err()), ("--stream", Growing::begin(folder.path()).err())] {
        let why = refused.unwrap().to_string();
        assert!(why.contains("this is a folder") && why.ends_with(option), "{why}");
    }
}
