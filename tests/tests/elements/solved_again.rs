//! Stored finite-element results are reused, and no other file is accepted in their place.

use std::fs;
use std::path::PathBuf;

use palpate_fit::solved::Solved;
use palpate_tests::palpate_command::Desk;

const PROBLEM: &str = "a block\nof tissue";
/// Numbers whose shortest decimal form a careless parser would round.
const NUMBERS: [f64; 4] = [1.0 / 3.0, 5e-324, -0.0, 1.740_175_926_661_093e-6];

fn solved(desk: &Desk) -> Solved {
    Solved::beside(&desk.folder().join("cut"))
}

fn files(desk: &Desk) -> Vec<PathBuf> {
    fs::read_dir(desk.folder().join(".solved")).unwrap().map(|entry| entry.unwrap().path()).collect()
}

/// Requests an answer; returns whether it was computed, and the messages.
fn ask(desk: &Desk, problem: &str) -> (bool, String) {
    let (solved, mut computed) = (solved(desk), false);
    let numbers = solved.answer(problem, NUMBERS.len(), || {
        computed = true;
        Ok::<_, ()>(NUMBERS.to_vec())
    });
    assert_eq!(numbers.unwrap().iter().map(|n| n.to_bits()).collect::<Vec<_>>(), NUMBERS.map(f64::to_bits));
    (computed, solved.said().join("\n"))
}

#[test]
fn an_answer_is_found_again_to_the_last_bit_and_says_how_to_compute_anew() {
    let desk = Desk::default();
    assert_eq!(ask(&desk, PROBLEM), (true, String::new()));
    let [file] = &files(&desk)[..] else { panic!("{:?}", files(&desk)) };
    let (computed, said) = ask(&desk, PROBLEM);
    assert!(!computed && said.contains(file.to_str().unwrap()) && said.contains("delete it to compute anew"), "{said}");
    assert!(ask(&desk, "another").0);
    fs::remove_file(file).unwrap();
    assert!(ask(&desk, PROBLEM).0);
}

#[test]
fn a_damaged_or_foreign_file_is_refused_and_replaced() {
    let desk = Desk::default();
    ask(&desk, PROBLEM);
    let file = files(&desk).remove(0);
    let whole = fs::read(&file).unwrap();
    for at in 0..whole.len() {
        let mut damaged = whole.clone();
        damaged[at] ^= 1;
        fs::write(&file, &damaged).unwrap();
        let (computed, said) = ask(&desk, PROBLEM);
        assert!(computed && said.contains("computed anew"), "byte {at}: {said}");
        assert_eq!(fs::read(&file).unwrap(), whole);
    }
    for length in 0..whole.len() {
        fs::write(&file, &whole[..length]).unwrap();
        assert!(ask(&desk, PROBLEM).0, "the first {length} bytes");
    }
    // a valid file, but of another problem
    ask(&desk, "another");
    let other = files(&desk).into_iter().find(|path| *path != file).unwrap();
    fs::copy(&other, &file).unwrap();
    let (computed, said) = ask(&desk, PROBLEM);
    assert!(computed && said.contains("answers another problem"), "{said}");
    // a valid file, but with another number of values
    let mut computed = false;
    let more = solved(&desk).answer(PROBLEM, 1, || {
        computed = true;
        Ok::<_, ()>(vec![1.0])
    });
    assert!(computed && more == Ok(vec![1.0]));
}

#[test]
fn an_error_and_a_folder_that_cannot_be_written_leave_nothing() {
    let desk = Desk::default();
    assert_eq!(solved(&desk).answer(PROBLEM, 1, || Err("no equilibrium")), Err("no equilibrium"));
    assert!(!desk.folder().join(".solved").exists());
    // a file in place of the folder
    fs::write(desk.folder().join(".solved"), "").unwrap();
    assert_eq!(ask(&desk, PROBLEM), (true, String::new()));
}
