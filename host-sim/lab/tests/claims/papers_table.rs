//! The table of equations in PAPERS.md names files, functions and tests that exist.

use crate::palpate_command::{files_below, repository};

/// Code of all files below `tests` and of all unit tests, as one text.
fn all_tests() -> String {
    let files = files_below(&["tests", "core/src", "host-sim"], ".rs");
    files.iter().map(|path| std::fs::read_to_string(path).unwrap()).collect()
}

/// Equation numbers in parentheses at the start of a row; "(4)-(6)" gives 4, 5, 6.
fn numbers(cell: &str) -> Vec<u32> {
    let plain: Vec<u32> = cell.split(&['(', ')']).filter_map(|part| part.parse().ok()).collect();
    match plain[..] {
        [from, to] if cell.contains(")-(") => (from..=to).collect(),
        _ => plain,
    }
}

#[test]
fn every_equation_has_a_place_and_a_test() {
    let text = std::fs::read_to_string(repository().join("PAPERS.md")).unwrap();
    let tests = all_tests();
    let mut seen: [Vec<u32>; 2] = [Vec::new(), Vec::new()];
    let mut paper = 0;
    for line in text.lines() {
        if line.starts_with("## Paper 004") {
            paper = 1;
        }
        let cells: Vec<&str> = line.split('|').map(str::trim).collect();
        let ["", equation, _, file, name, test, ""] = cells[..] else { continue };
        if equation == "equation" || equation.starts_with("---") {
            continue;
        }
        seen[paper].extend(numbers(equation));
        let source = std::fs::read_to_string(repository().join(file)).unwrap_or_else(|e| panic!("{equation}: {file}: {e}"));
        assert!(
            source.contains(&format!("fn {name}")) || source.contains(&format!("const {name}")),
            "{equation}: no {name} in {file}"
        );
        assert!(tests.contains(&format!("fn {test}(")), "{equation}: there is no test {test}");
    }
    for (of, last) in seen.iter_mut().zip([13, 14]) {
        of.sort_unstable();
        of.dedup();
        assert_eq!(*of, (1..=last).collect::<Vec<u32>>());
    }
}

#[test]
fn ranges_of_equations_are_read() {
    assert_eq!(numbers("(4)-(6)"), [4, 5, 6]);
    assert_eq!(numbers("(1), (2)"), [1, 2]);
    assert!(numbers("text").is_empty());
}
