//! The tables of pins that a builder wires by are those of the firmware.

use palpate_tests::palpate_command::repository;

fn text(path: &str) -> String {
    std::fs::read_to_string(repository().join(path)).unwrap()
}

/// Names of pins in a text, such as PA0 or PF10, in their order.
fn pins(text: &str) -> Vec<String> {
    let words = text.split(|c: char| !c.is_ascii_alphanumeric());
    let is_pin = |word: &&str| {
        let mut letters = word.chars();
        letters.next() == Some('P')
            && letters.next().is_some_and(|port| ('A'..='K').contains(&port))
            && matches!(word.len(), 3 | 4)
            && letters.all(|digit| digit.is_ascii_digit())
    };
    words.filter(is_pin).map(str::to_owned).collect()
}

/// The row of a table in the docs of a board's file, without the words before its pins.
fn row<'a>(board: &'a str, begins: &str) -> &'a str {
    board.lines().find_map(|line| line.strip_prefix(&format!("//! | {begins}"))).unwrap_or_else(|| panic!("no row {begins}"))
}

#[test]
fn wiring_tables_name_the_pins_that_the_image_starts() {
    let (bring_up, paddle) = (text("firmware/BRINGUP.md"), text("firmware/controller/README.md"));
    let cells = |begins: &str, column: usize| {
        let line = bring_up.lines().find(|line| line.starts_with(&format!("|{begins}"))).unwrap_or_else(|| panic!("{begins}"));
        pins(line.split('|').nth(column).unwrap())
    };
    let joint_0 = |begins: &str, names: &[String]| {
        let line = paddle.lines().find(|line| line.contains(begins)).unwrap_or_else(|| panic!("{begins}"));
        assert!(names.iter().all(|name| pins(line).contains(name)), "{names:?} of joint 0 in {line}");
    };
    for (board, column) in [("nucleo_h743zi", 2), ("nucleo_f446re", 3), ("nucleo_g474re", 3)] {
        let source = text(&format!("firmware/src/board/stm32/{board}.rs"));
        let started = |begins: &str| source.lines().filter(|l| l.contains(begins)).flat_map(pins).collect::<Vec<String>>();
        let encoders = started("encoders::start(");
        for (axis, pair) in ["encoder x", "encoder y", "encoder z"].iter().zip(encoders.chunks(2)) {
            assert_eq!(cells(axis, column), pair, "{board}: {axis}");
        }
        joint_0("encoder A, B", &encoders[..2]);
        let magnitudes = started("PwmPin::new_with_config(");
        assert_eq!(cells("magnitude", column), magnitudes, "{board}");
        joint_0("magnitude x  ", &magnitudes[..1]);
        let directions = pins(row(&source, "direction x, y, z"));
        assert_eq!(cells("direction", column), directions, "{board}");
        joint_0("direction x  ", &directions[..1]);
        let singles = pins(row(&source, "stop circuit, enable, supply, operator"));
        for (n, name) in ["stop circuit", "enable", "supply good", "operator's switch"].into_iter().enumerate() {
            assert_eq!(cells(name, column), singles[n..=n], "{board}: {name}");
        }
        for name in directions.iter().chain(&singles) {
            assert!(source.contains(&format!("p.{name}")), "{board} does not set {name} up");
        }
        joint_0(" stop, trip", &singles[..1]);
        joint_0("enable  ", &singles[1..2]);
        joint_0(" its supply", &singles[2..3]);
    }
}
