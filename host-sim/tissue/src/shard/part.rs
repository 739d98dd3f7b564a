//! The file of a shard: three lines of JSON. The heading names the campaign and its cases, the
//! second line holds their results, the third the checksum of both.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::Value;

use super::Shard;
use crate::machine;

/// Name of a shard's file.
pub const FILE: &str = "shard.jsonl";
/// Version of the format, which rises when the meaning of the lines changes.
const FORM: u32 = 1;
const CHECKSUM: crc::Crc<u64, crc::Table<16>> = crc::Crc::<u64, crc::Table<16>>::new(&crc::CRC_64_XZ);

/// Names the campaign and the part of its cases that a file holds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Heading {
    /// Version of the format: rises when the meaning of the lines changes.
    pub form: u32,
    /// Version of the program.
    pub version: String,
    /// Fingerprint of the program's file: see [`program`].
    pub program: String,
    /// Command, as given on the command line.
    pub command: String,
    /// Options of the command, including the seed, except those that say where and how to run.
    pub options: BTreeMap<String, Value>,
    /// Checksum of each file or scene that the cases use.
    pub inputs: BTreeMap<String, String>,
    /// Number of cases of the whole campaign.
    pub cases: u64,
    /// Number of the part, and number of parts.
    pub shard: Shard,
    /// First case of the part, and the first case after it.
    pub range: [u64; 2],
    /// Arguments with which one run computes all cases; not compared.
    #[serde(default)]
    pub command_line: Vec<String>,
    /// Processors available to the run; not compared.
    #[serde(default)]
    pub cores: usize,
    /// Processor that computed the part: a hint if bytes differ. Parts may differ in it.
    pub processor: String,
}

/// Content of a shard's file.
#[derive(Clone, Debug)]
pub struct Part {
    /// Names the campaign and the part of its cases.
    pub heading: Heading,
    counts: String,
}

/// Why a file is not a shard's file.
#[derive(Debug, thiserror::Error)]
pub enum PartError {
    /// The file is missing or cannot be read.
    #[error("cannot be read ({0})")]
    Unreadable(#[from] io::Error),
    /// The file is not a shard's file, or it has another version of the format.
    #[error("is no shard of this form")]
    NotAShard,
    /// The file was truncated or changed.
    #[error("is cut short or damaged")]
    Damaged,
    /// The cases are not those that belong to the number of the part: parts may overlap or leave a
    /// gap.
    #[error("holds other cases than its number says")]
    OtherCases,
}

impl Heading {
    /// Describes a part that this program computes on this machine.
    ///
    /// # Errors
    /// The program's own file cannot be read.
    pub fn new(
        command: &str,
        options: BTreeMap<String, Value>,
        inputs: BTreeMap<String, String>,
        cases: u64,
        shard: Shard,
    ) -> io::Result<Self> {
        let range = shard.cases(cases);
        Ok(Self {
            form: FORM,
            version: env!("CARGO_PKG_VERSION").into(),
            program: program()?,
            command: command.into(),
            options,
            inputs,
            cases,
            shard,
            range: [range.start, range.end],
            command_line: Vec::new(),
            cores: machine::cores(),
            processor: machine::processor(),
        })
    }

    /// Text of all that the parts of a campaign share.
    pub(super) fn campaign(&self) -> String {
        let Self { form, version, program, command, options, inputs, cases, shard, .. } = self;
        format!("{form} {version} {program} {command} {options:?} {inputs:?} {cases} {}", shard.of())
    }

    /// The first difference between a shard and the campaign of `other`, as "its X is A, not B".
    #[must_use]
    pub fn differs(&self, other: &Self) -> Option<String> {
        let said = |what: &str, own: &dyn std::fmt::Display, theirs: &dyn std::fmt::Display| {
            Some(format!("its {what} is {own}, not {theirs}"))
        };
        if self.version != other.version {
            return said("version", &self.version, &other.version);
        }
        if self.command != other.command {
            return said("command", &self.command, &other.command);
        }
        if let Some((key, own, theirs)) = first_difference(&self.options, &other.options) {
            // an option that was not given is null
            let given = |value: &&Value| !value.is_null();
            let or_none = |value: Option<&Value>| value.filter(given).map_or("left out".into(), Value::to_string);
            return said(key, &or_none(own), &or_none(theirs));
        }
        if let Some((key, own, theirs)) = first_difference(&self.inputs, &other.inputs) {
            let or_none = |sum: Option<&String>| sum.cloned().unwrap_or_else(|| "none".into());
            return said(&format!("{key} (checksum)"), &or_none(own), &or_none(theirs));
        }
        if self.cases != other.cases {
            return said("number of cases", &self.cases, &other.cases);
        }
        if self.shard.of() != other.shard.of() {
            return said("number of shards", &self.shard.of(), &other.shard.of());
        }
        if self.program != other.program {
            return said("program (checksum)", &self.program, &other.program);
        }
        None
    }
}

type Difference<'a, V> = (&'a str, Option<&'a V>, Option<&'a V>);

fn first_difference<'a, V: PartialEq>(
    own: &'a BTreeMap<String, V>,
    theirs: &'a BTreeMap<String, V>,
) -> Option<Difference<'a, V>> {
    let keys = own.keys().chain(theirs.keys());
    keys.map(|key| (key.as_str(), own.get(key), theirs.get(key))).find(|(_, own, theirs)| own != theirs)
}

impl Part {
    /// Text of a shard's file.
    ///
    /// # Errors
    /// The results contain numbers that JSON does not have.
    pub fn write(heading: &Heading, counts: &impl Serialize) -> serde_json::Result<String> {
        let lines = format!("{}\n{}\n", serde_json::to_string(heading)?, serde_json::to_string(counts)?);
        let sum = checksum(lines.as_bytes());
        Ok(format!("{lines}{{\"crc64\":\"{sum}\"}}\n"))
    }

    /// Reads a shard's file.
    ///
    /// # Errors
    /// The file is missing, of another form, cut short or damaged.
    pub fn read(path: &Path) -> Result<Self, PartError> {
        let text = String::from_utf8(std::fs::read(path)?).map_err(|_| PartError::Damaged)?;
        let (first, rest) = text.split_once('\n').ok_or(PartError::Damaged)?;
        let form: Value = serde_json::from_str(first).map_err(|_| PartError::Damaged)?;
        if form.get("form").and_then(Value::as_u64) != Some(FORM.into()) {
            return Err(PartError::NotAShard);
        }
        let (counts, last) = rest.split_once('\n').ok_or(PartError::Damaged)?;
        let sum = checksum(&text.as_bytes()[..text.len() - last.len()]);
        if last != format!("{{\"crc64\":\"{sum}\"}}\n") {
            return Err(PartError::Damaged);
        }
        let heading: Heading = serde_json::from_str(first).map_err(|_| PartError::NotAShard)?;
        let cases = heading.shard.cases(heading.cases);
        if heading.range != [cases.start, cases.end] {
            return Err(PartError::OtherCases);
        }
        Ok(Self { heading, counts: counts.to_owned() })
    }

    /// Reads the results of the cases.
    ///
    /// # Errors
    /// The results are of another type.
    pub fn counts<T: DeserializeOwned>(&self) -> serde_json::Result<T> {
        serde_json::from_str(&self.counts)
    }
}

/// Checksum of bytes, as hexadecimal digits: CRC-64/XZ.
#[must_use]
pub fn checksum(bytes: &[u8]) -> String {
    format!("{:016x}", CHECKSUM.checksum(bytes))
}

/// Fingerprint of the running program: the checksum of its file. Programs from the same sources may
/// round differently if compiler, profile or machine differ; the same program file does not.
///
/// # Errors
/// The file cannot be read.
pub fn program() -> io::Result<String> {
    // the file that runs, even if its path has been replaced since
    let running = Path::new("/proc/self/exe");
    let mut file = if running.exists() { File::open(running)? } else { File::open(std::env::current_exe()?)? };
    let mut digest = CHECKSUM.digest();
    let mut buffer = vec![0; 1 << 20];
    loop {
        match file.read(&mut buffer)? {
            0 => return Ok(format!("{:016x}", digest.finalize())),
            read => digest.update(&buffer[..read]),
        }
    }
}
