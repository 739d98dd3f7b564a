//! Whether shards make up a campaign.

use std::cmp::Reverse;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use super::{FILE, Heading, Part, PartError, Shard};
use crate::error::Error;

/// Shards that a message names one by one.
const NAMED: usize = 8;

/// Reads every shard in these folders, each a shard's or a folder of them, and returns them in the
/// order of their cases.
///
/// # Errors
/// One line that names what cannot be used, what is there twice and what is missing, in a form that
/// can be given back to the command.
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
    // one odd shard among many is the odd one, wherever it stands
    let Some(usual) = usual(&parts) else {
        return Err(Error::Usage(format!("nothing to merge: {}: run the shards again", listed(&bad))));
    };
    let mut found: BTreeMap<u64, (PathBuf, Part)> = BTreeMap::new();
    for (path, part) in parts {
        if let Some(difference) = part.heading.differs(&usual) {
            bad.push(format!("{}: {difference} as of the others", path.display()));
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
        (!missing.is_empty()).then(|| format!("{} of {of} shards are missing: {}", missing.len(), again(&missing, of))),
    ]
    .into_iter()
    .flatten()
    .collect();
    if lines.is_empty() {
        return Ok(found.into_values().map(|(_, part)| part).collect());
    }
    Err(Error::Usage(lines.join("; ")))
}

/// A heading of the campaign that most of the parts are of; of equally many, the first.
fn usual(parts: &[(PathBuf, Part)]) -> Option<Heading> {
    let mut campaigns: BTreeMap<String, (usize, usize)> = BTreeMap::new();
    for (n, (_, part)) in parts.iter().enumerate() {
        campaigns.entry(part.heading.campaign()).or_insert((0, n)).0 += 1;
    }
    let (_, first) = campaigns.into_values().max_by_key(|(count, first)| (*count, Reverse(*first)))?;
    Some(parts.get(first)?.1.heading.clone())
}

/// Every shard's file in a folder or one below it, sorted.
fn files(folders: &[PathBuf]) -> Result<Vec<PathBuf>, Error> {
    let mut files = Vec::new();
    for folder in folders {
        let refuse = |source| Error::Read { path: folder.clone(), source };
        let before = files.len();
        if folder.join(FILE).exists() {
            files.push(folder.join(FILE));
        } else {
            for entry in std::fs::read_dir(folder).map_err(refuse)? {
                let file = entry.map_err(refuse)?.path().join(FILE);
                if file.exists() {
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
    format!("{} {why}", path.display())
}

fn listed(bad: &[String]) -> String {
    let more = bad.len().saturating_sub(NAMED);
    let named = bad.iter().take(NAMED).map(String::as_str).collect::<Vec<_>>().join("; ");
    if more > 0 { format!("{named}; and {more} more") } else { named }
}

/// Shards as options to give back, and as the tasks of an array.
fn again(missing: &[u64], of: u64) -> String {
    let options: Vec<String> = missing.iter().take(NAMED).map(|n| format!("--shard {n}/{of}")).collect();
    let more = if missing.len() > NAMED { " ..." } else { "" };
    format!("{}{more} (as an array: --array={})", options.join(" "), ranges(missing))
}

/// `1,3-5` of 1, 3, 4, 5.
fn ranges(numbers: &[u64]) -> String {
    let runs = numbers.chunk_by(|a, b| a + 1 == *b);
    let said = |run: &[u64]| match run {
        [first, .., last] => format!("{first}-{last}"),
        [one] => one.to_string(),
        [] => String::new(),
    };
    runs.map(said).collect::<Vec<_>>().join(",")
}
