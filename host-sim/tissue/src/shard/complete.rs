//! Checks that shards make up a whole campaign.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::{FILE, Heading, Part, PartError, Shard};
use crate::error::Error;

/// Largest number of shards that a message names individually.
const NAMED: usize = 8;

/// Reads every shard in these folders and returns them in the order of their cases. Each folder is
/// that of a shard, or contains the folders of shards.
///
/// # Errors
/// Shards that are unusable, duplicate or missing. One line names them, in a form that can be
/// passed to the command.
pub fn complete(folders: &[PathBuf]) -> Result<Vec<Part>, Error> {
    let files = files(folders)?;
    let mut bad: Vec<String> = Vec::new();
    let mut parts: Vec<(PathBuf, Part)> = Vec::new();
    for path in files {
        match Part::read(&path) {
            Ok(part) => parts.push((path, part)),
            Err(why) => bad.push(refused(&path, &why)),
        }
    }
    // one deviating shard among many is reported, whatever its position
    let Some(usual) = usual(&parts) else {
        return Err(Error::Usage(format!("nothing to merge: {}", listed(&bad))));
    };
    let mut found: BTreeMap<u64, (PathBuf, Part)> = BTreeMap::new();
    for (path, part) in parts {
        if let Some(difference) = part.heading.differs(&usual) {
            bad.push(format!(
                "{}: {difference} as of the others: merge it with its own, and run what is missing here as the others ran",
                path.display()
            ));
        } else if let Some((earlier, _)) = found.get(&part.heading.shard.number()) {
            let shard = part.heading.shard;
            bad.push(format!("shard {shard} is there twice: {} and {}: give one", earlier.display(), path.display()));
        } else {
            found.insert(part.heading.shard.number(), (path, part));
        }
    }
    let of = usual.shard.of();
    let absent = |n: &u64| {
        let empty = Shard::new(*n, of).is_none_or(|shard| shard.cases(usual.cases).is_empty());
        !empty && !found.contains_key(n)
    };
    let missing: Vec<u64> = (1..=of).filter(absent).collect();
    let lines: Vec<String> = [
        (!bad.is_empty()).then(|| listed(&bad)),
        (!missing.is_empty()).then(|| {
            format!("{} of {of} shards are missing: {}: run the command again with each", missing.len(), again(&missing, of))
        }),
    ]
    .into_iter()
    .flatten()
    .collect();
    if lines.is_empty() {
        return Ok(found.into_values().map(|(_, part)| part).collect());
    }
    Err(Error::Usage(lines.join("; ")))
}

/// Heading of the campaign to which most of the parts belong; with a tie, that of the first.
fn usual(parts: &[(PathBuf, Part)]) -> Option<Heading> {
    let mut campaigns: BTreeMap<String, (usize, usize)> = BTreeMap::new();
    for (n, (_, part)) in parts.iter().enumerate() {
        campaigns.entry(part.heading.campaign()).or_insert((0, n)).0 += 1;
    }
    let (_, first) = campaigns.into_values().max_by_key(|(count, first)| (*count, Reverse(*first)))?;
    Some(parts.get(first)?.1.heading.clone())
}

/// The file of every shard in these folders or one level below them, sorted. A hidden folder is
/// left out: a run is still writing it, or was killed.
fn files(folders: &[PathBuf]) -> Result<Vec<PathBuf>, Error> {
    let mut files = Vec::new();
    for folder in folders {
        let refuse = |source| Error::Read { path: folder.clone(), source };
        let before = files.len();
        if folder.join(FILE).exists() {
            files.push(folder.join(FILE));
        } else {
            for entry in std::fs::read_dir(folder).map_err(refuse)? {
                let entry = entry.map_err(refuse)?;
                let file = entry.path().join(FILE);
                if file.exists() && !entry.file_name().as_encoded_bytes().starts_with(b".") {
                    files.push(file);
                }
            }
        }
        if files.len() == before {
            return Err(Error::Usage(format!(
                "{}: there is no {FILE} in it or in a folder in it: give the --out of a command with --shard",
                folder.display()
            )));
        }
    }
    files.sort();
    Ok(files)
}

fn refused(path: &Path, why: &PartError) -> String {
    format!("{} {why}: take its folder away and run its shard again", path.display())
}

fn listed(bad: &[String]) -> String {
    let more = bad.len().saturating_sub(NAMED);
    let named = bad.iter().take(NAMED).map(String::as_str).collect::<Vec<_>>().join("; ");
    if more > 0 { format!("{named}; and {more} more") } else { named }
}

/// Missing shards as options to pass on, and as the tasks of a job array.
fn again(missing: &[u64], of: u64) -> String {
    let options: Vec<String> = missing.iter().take(NAMED).map(|n| format!("--shard {n}/{of}")).collect();
    let more = if missing.len() > NAMED { " ..." } else { "" };
    format!("{}{more} (as an array: --array={})", options.join(" "), ranges(missing))
}

/// `1,3-5` for 1, 3, 4, 5.
fn ranges(numbers: &[u64]) -> String {
    let runs = numbers.chunk_by(|a, b| a + 1 == *b);
    let said = |run: &[u64]| match run {
        [first, .., last] => format!("{first}-{last}"),
        [one] => one.to_string(),
        [] => String::new(),
    };
    runs.map(said).collect::<Vec<_>>().join(",")
}

#[cfg(test)]
mod tests {
    use std::sync::LazyLock;

    use super::*;
    use serde_json::{Value, json};

    const OF: u64 = 4;

    /// A heading of the campaign of all tests: ten cases in four parts.
    fn heading(number: u64) -> Heading {
        static FIRST: LazyLock<Heading> = LazyLock::new(|| {
            let options = BTreeMap::from([("seed".to_owned(), json!(1))]);
            let inputs = BTreeMap::from([("scene.toml".to_owned(), "00aa".to_owned())]);
            Heading::new("faults", options, inputs, 10, Shard::new(1, OF).unwrap()).unwrap()
        });
        of_shard(&FIRST, Shard::new(number, OF).unwrap())
    }

    fn of_shard(heading: &Heading, shard: Shard) -> Heading {
        let cases = shard.cases(heading.cases);
        Heading { shard, range: [cases.start, cases.end], ..heading.clone() }
    }

    fn with(heading: &Heading, option: &str, value: Value) -> Heading {
        let mut with = heading.clone();
        with.options.insert(option.to_owned(), value);
        with
    }

    /// A folder of shards; each file has its heading, and its number as the results.
    struct Shelf(tempfile::TempDir);

    impl Shelf {
        fn new(headings: impl IntoIterator<Item = Heading>) -> Self {
            let shelf = Self(tempfile::tempdir().unwrap());
            for heading in headings {
                shelf.put(&format!("shard-{}", heading.shard.number()), &heading);
            }
            shelf
        }

        fn whole() -> Self {
            Self::new((1..=OF).map(heading))
        }

        fn file(&self, folder: &str) -> PathBuf {
            self.0.path().join(folder).join(FILE)
        }

        fn put(&self, folder: &str, heading: &Heading) {
            let file = self.file(folder);
            std::fs::create_dir_all(file.parent().unwrap()).unwrap();
            std::fs::write(file, Part::write(heading, &heading.shard.number()).unwrap()).unwrap();
        }

        /// Every file with its bytes.
        fn content(&self) -> Vec<(PathBuf, Vec<u8>)> {
            files(&[self.0.path().to_owned()]).unwrap().into_iter().map(|f| (f.clone(), std::fs::read(f).unwrap())).collect()
        }

        /// Checks that the folder is refused and nothing in it changed; returns the message.
        #[track_caller]
        fn refused(&self, says: &[&str]) -> String {
            let before = self.content();
            let Err(error) = complete(&[self.0.path().to_owned()]) else { panic!("it is taken for whole") };
            assert!(self.content() == before, "{error}");
            let line = error.to_string();
            assert!(!line.contains('\n'), "{line}");
            for words in says {
                assert!(line.contains(words), "not a word of `{words}`: {line}");
            }
            line
        }

        /// Checks that part 3, if it is of another campaign, is named and requested again.
        #[track_caller]
        fn odd(change: impl Fn(&mut Heading), says: &str) {
            let shelf = Self::whole();
            let mut odd = heading(3);
            change(&mut odd);
            shelf.put("shard-3", &odd);
            let file = shelf.file("shard-3").display().to_string();
            let line = shelf.refused(&[
                &file,
                says,
                "as of the others: merge it with its own",
                "1 of 4 shards are missing: --shard 3/4 ",
            ]);
            assert_eq!(line.matches(FILE).count(), 1, "the others are not named: {line}");
        }
    }

    #[test]
    fn whole_campaigns_come_in_the_order_of_their_cases() {
        let shelf = Shelf::whole();
        // parts in several folders, whatever the folders' names
        let one = Shelf::new([heading(2)]);
        std::fs::remove_dir_all(shelf.file("shard-2").parent().unwrap()).unwrap();
        let parts = complete(&[shelf.0.path().into(), one.0.path().join("shard-2")]).unwrap();
        let counts: Vec<u64> = parts.iter().map(|part| part.counts().unwrap()).collect();
        assert_eq!(counts, [1, 2, 3, 4]);
        let ranges: Vec<[u64; 2]> = parts.iter().map(|part| part.heading.range).collect();
        assert_eq!(ranges, [[0, 2], [2, 5], [5, 7], [7, 10]]);
    }

    #[test]
    fn what_a_killed_run_left_is_no_shard() {
        let shelf = Shelf::whole();
        shelf.put(".shard-3.draft", &heading(3));
        assert_eq!(complete(&[shelf.0.path().into()]).unwrap().len(), 4);
        std::fs::remove_dir_all(shelf.file("shard-3").parent().unwrap()).unwrap();
        shelf.refused(&["1 of 4 shards are missing: --shard 3/4 "]);
    }

    #[test]
    fn more_shards_than_cases_leave_none_missing() {
        let of = |number| of_shard(&heading(1), Shard::new(number, 20).unwrap());
        let full = |heading: &Heading| !heading.shard.cases(10).is_empty();
        assert_eq!(complete(&[Shelf::new((1..=20).map(of).filter(full)).0.path().into()]).unwrap().len(), 10);
    }

    #[test]
    fn what_is_missing_is_said_as_it_is_given_back() {
        let without = |gone: &[u64]| Shelf::new((1..=OF).filter(|n| !gone.contains(n)).map(heading));
        without(&[2]).refused(&["1 of 4 shards are missing: --shard 2/4 (as an array: --array=2)"]);
        without(&[1, 3, 4])
            .refused(&["3 of 4 shards are missing: --shard 1/4 --shard 3/4 --shard 4/4 (as an array: --array=1,3-4)"]);
        let of_many = Heading { cases: 1000, ..heading(1) };
        let shelf = Shelf::new([of_shard(&of_many, Shard::new(1, 1000).unwrap())]);
        shelf.refused(&["999 of 1000 shards are missing: --shard 2/1000", "--shard 9/1000 ... (as an array: --array=2-1000)"]);
    }

    #[test]
    fn a_shard_of_another_version() {
        Shelf::odd(|h| h.version = "0.0.9".into(), "its version is 0.0.9, not ");
    }

    #[test]
    fn a_shard_of_another_program() {
        Shelf::odd(|h| h.program = "00bb".into(), "its program (checksum) is 00bb, not ");
    }

    #[test]
    fn a_shard_of_another_command() {
        Shelf::odd(|h| h.command = "loop".into(), "its command is loop, not faults");
    }

    #[test]
    fn a_shard_of_another_seed() {
        Shelf::odd(|h| drop(h.options.insert("seed".into(), json!(2))), "its seed is 2, not 1");
        Shelf::odd(|h| drop(h.options.insert("quick".into(), json!(true))), "its quick is true, not left out");
        let shelf = Shelf::new([1, 2, 4].map(|n| with(&heading(n), "hand", Value::Null)));
        shelf.put("shard-3", &with(&heading(3), "hand", json!("H1")));
        shelf.refused(&["its hand is \"H1\", not left out"]);
    }

    #[test]
    fn a_shard_of_another_scene() {
        Shelf::odd(|h| drop(h.inputs.insert("scene.toml".into(), "00bb".into())), "its scene.toml (checksum) is 00bb, not 00aa");
        Shelf::odd(|h| h.inputs.clear(), "its scene.toml (checksum) is none, not 00aa");
    }

    #[test]
    fn a_shard_of_more_cases_leaves_gaps() {
        Shelf::odd(|h| (h.cases, h.range) = (20, [10, 15]), "its number of cases is 20, not 10");
    }

    #[test]
    fn a_shard_of_another_division_overlaps() {
        let overlaps = |h: &mut Heading| (h.shard, h.range) = (Shard::new(3, 5).unwrap(), [4, 6]);
        Shelf::odd(overlaps, "its number of shards is 5, not 4");
    }

    #[test]
    fn a_shard_whose_cases_are_not_those_of_its_number() {
        let shelf = Shelf::whole();
        shelf.put("shard-3", &Heading { range: [4, 7], ..heading(3) });
        let file = shelf.file("shard-3").display().to_string();
        shelf.refused(&[&format!("{file} holds other cases than its number says: take"), "again", "--shard 3/4 "]);
    }

    #[test]
    fn a_shard_that_is_there_twice() {
        let shelf = Shelf::whole();
        shelf.put("copy", &heading(2));
        let [copy, first] = ["copy", "shard-2"].map(|name| shelf.file(name).display().to_string());
        let line = shelf.refused(&[&format!("shard 2/4 is there twice: {copy} and {first}: give one")]);
        assert!(!line.contains("missing"), "{line}");
        // a folder given twice
        let shelf = Shelf::whole();
        let twice = [shelf.0.path().to_owned(), shelf.0.path().to_owned()];
        let line = complete(&twice).unwrap_err().to_string();
        assert!(line.contains("shard 1/4 is there twice"), "{line}");
    }

    #[test]
    fn a_file_that_was_cut_short_or_changed() {
        let shelf = Shelf::whole();
        let file = shelf.file("shard-3");
        let whole = std::fs::read(&file).unwrap();
        let damaged = |bytes: &[u8]| {
            std::fs::write(&file, bytes).unwrap();
            let said = format!("{} is cut short or damaged: take its folder away and run its shard again", file.display());
            shelf.refused(&[&said, "--shard 3/4 "]);
        };
        (0..whole.len()).for_each(|length| damaged(&whole[..length]));
        damaged(&[&whole[..], b"\n"].concat());
        for place in 0..whole.len() {
            let mut changed = whole.clone();
            changed[place] ^= 1;
            std::fs::write(&file, &changed).unwrap();
            shelf.refused(&[&file.display().to_string(), "run its shard again", "--shard 3/4 "]);
        }
        std::fs::write(&file, &whole).unwrap();
        assert_eq!(complete(&[shelf.0.path().into()]).unwrap().len(), 4);
    }

    #[test]
    fn a_file_that_cannot_be_read_or_is_of_another_form() {
        let shelf = Shelf::whole();
        let file = shelf.file("shard-3");
        let text = std::fs::read_to_string(&file).unwrap();
        std::fs::write(&file, text.replacen("{\"form\":1,", "{\"form\":2,", 1)).unwrap();
        shelf.refused(&[&format!("{} is no shard of this form", file.display()), "--shard 3/4 "]);
        std::fs::remove_file(&file).unwrap();
        std::fs::create_dir(&file).unwrap();
        let Err(error) = complete(&[shelf.0.path().to_owned()]) else { panic!("it is taken for whole") };
        assert!(error.to_string().contains(&format!("{} cannot be read", file.display())), "{error}");
    }

    #[test]
    fn folders_without_shards() {
        let shelf = Shelf::new([]);
        let refused = |folder: &Path| complete(&[folder.to_owned()]).unwrap_err().to_string();
        assert!(refused(shelf.0.path()).contains("there is no shard.jsonl in it or in a folder in it: give the --out"));
        assert!(refused(&shelf.0.path().join("absent")).contains("absent"));
        shelf.put("shard-1", &heading(1));
        std::fs::write(shelf.file("shard-1"), "").unwrap();
        shelf.refused(&["nothing to merge: ", "shard-1", "cut short or damaged"]);
    }
}
