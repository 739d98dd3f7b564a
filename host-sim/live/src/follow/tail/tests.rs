use std::io::Write;

use palpate_loop::board_trace::COLUMNS;

use super::*;

fn head() -> String {
    format!("{}\n", COLUMNS.join(","))
}

fn line(tick: u32) -> String {
    format!("{tick},4,0,0,0,0.001,0,0,0,0,0,0,0.5,1,0,0,0,0,0,0,0,12.5,0badcafe,3500\n")
}

struct Written {
    folder: tempfile::TempDir,
    tail: Tail,
}

impl Written {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let tail = Tail::of(&folder.path().join("felt.csv"));
        Self { folder, tail }
    }

    fn path(&self) -> PathBuf {
        self.folder.path().join("felt.csv")
    }

    fn put(&self, text: &str) {
        std::fs::write(self.path(), text).unwrap();
    }

    fn append(&self, text: &str) {
        std::fs::OpenOptions::new().append(true).open(self.path()).unwrap().write_all(text.as_bytes()).unwrap();
    }

    /// Whether the file has started again, and the ticks of the new rows.
    fn read(&mut self) -> (bool, Vec<u32>) {
        match self.tail.read() {
            Found::Rows(rows) => (rows.anew, rows.rows.iter().map(|row| row.tick).collect()),
            other => panic!("{other:?}"),
        }
    }

    fn bad(&mut self) -> String {
        match self.tail.read() {
            Found::Bad(why) => why,
            other => panic!("{other:?}"),
        }
    }
}

#[test]
fn a_file_is_waited_for_and_read_once_as_it_grows() {
    let mut written = Written::new();
    assert_eq!(written.tail.read(), Found::Absent);
    written.put("");
    assert_eq!(written.read(), (true, vec![]));
    written.append(&head());
    assert_eq!(written.read(), (true, vec![]), "nothing was read of it before");
    written.append(&(line(20) + &line(40)));
    assert_eq!(written.read(), (false, vec![20, 40]));
    assert_eq!(written.read(), (false, vec![]));
    written.append(&line(60));
    assert_eq!(written.read(), (false, vec![60]));
}

#[test]
fn a_line_without_an_end_is_waited_for_wherever_it_is_cut() {
    let all = head() + &line(20) + &line(40);
    for cut in 1..all.len() {
        let mut written = Written::new();
        written.put(&all[..cut]);
        let first = written.read().1;
        written.append(&all[cut..]);
        assert_eq!([first, written.read().1].concat(), [20, 40], "cut after {cut} bytes");
    }
}

#[test]
fn a_file_that_is_shortened_or_replaced_begins_anew() {
    let mut written = Written::new();
    written.put(&(head() + &line(20) + &line(40) + &line(60)));
    assert_eq!(written.read(), (true, vec![20, 40, 60]));
    written.put(&(head() + &line(80)));
    assert_eq!(written.read(), (true, vec![80]), "shorter");
    written.put(&(head() + &line(30)));
    assert_eq!(written.read(), (true, vec![30]), "as long");
    written.put(&(head() + &line(10) + &line(30) + &line(50)));
    assert_eq!(written.read(), (true, vec![10, 30, 50]), "longer");
    // replaced by another file of the same name
    let other = written.folder.path().join("other");
    std::fs::write(&other, head() + &line(5) + &line(7) + &line(9) + &line(11)).unwrap();
    std::fs::rename(other, written.path()).unwrap();
    assert_eq!(written.read(), (true, vec![5, 7, 9, 11]), "replaced");
    std::fs::remove_file(written.path()).unwrap();
    assert_eq!(written.tail.read(), Found::Absent);
    written.put(&(head() + &line(5)));
    assert_eq!(written.read(), (true, vec![5]), "gone and back");
}

#[test]
fn another_table_is_refused_with_file_and_line_until_the_file_begins_anew() {
    let mut written = Written::new();
    written.put("t_s,probe_x_m\n0,0\n");
    let why = written.bad();
    assert!(why.starts_with(&format!("{}:1: no record of a board", written.path().display())), "{why}");
    assert!(why.contains("no column tick: give the file of `palpate board arm --stream") && why.lines().count() == 1, "{why}");
    assert_eq!(written.bad(), why, "as long as it is that file");
    written.put(&head());
    assert_eq!(written.read(), (true, vec![]));
    written.append(&(line(20) + "20,4\n" + &line(40)));
    let why = written.bad();
    assert!(why.contains("felt.csv:3: 2 cells, and the first line has 24"), "{why}");
    written.append(&line(60));
    assert_eq!(written.bad(), why, "nothing is read on after it");
}

#[test]
fn a_folder_is_refused_and_a_file_has_an_age() {
    let mut written = Written::new();
    std::fs::create_dir(written.path()).unwrap();
    assert!(written.bad().contains("cannot be read: it is a folder"));
    std::fs::remove_dir(written.path()).unwrap();
    written.put(&head());
    let hour_ago = SystemTime::now() - Duration::from_secs(3600);
    File::options().append(true).open(written.path()).unwrap().set_modified(hour_ago).unwrap();
    match written.tail.read() {
        Found::Rows(rows) => assert!(rows.age >= Duration::from_secs(3599), "{:?}", rows.age),
        other => panic!("{other:?}"),
    }
}
