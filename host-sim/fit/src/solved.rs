//! Stores finite-element answers, which are found by the problem that they solve.
//!
//! A file contains the complete problem, a fingerprint of the source code of the elements that
//! solved it, and the numbers of the answer to the last bit. It is used only if its problem is the
//! requested one and its checksum is correct. The folder is beside the results, such as
//! `out/.solved` for `out/cut`, and may be deleted at any time: its answers are then computed
//! again.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Mutex;

use crc::{CRC_64_XZ, Crc};

const CRC: Crc<u64> = Crc::<u64>::new(&CRC_64_XZ);
const FIRST_LINE: &str = "palpate solved 1";
const FOLDER: &str = ".solved";

/// Source code on which an answer depends besides its problem: after a change of any line, earlier
/// answers are no longer found.
const ELEMENTS: [&str; 28] = [
    include_str!("far_field/organ_reference.rs"),
    include_str!("reference/assembly.rs"),
    include_str!("reference/body.rs"),
    include_str!("reference/cholesky.rs"),
    include_str!("reference/conform.rs"),
    include_str!("reference/domain.rs"),
    include_str!("reference/elimination.rs"),
    include_str!("reference/glued.rs"),
    include_str!("reference/glued/circle.rs"),
    include_str!("reference/minimise.rs"),
    include_str!("reference/near.rs"),
    include_str!("reference/newton.rs"),
    include_str!("reference/probe.rs"),
    include_str!("reference/quadratic.rs"),
    include_str!("reference/refine.rs"),
    include_str!("reference/shape.rs"),
    include_str!("reference/touch.rs"),
    include_str!("scene_fit/bump.rs"),
    include_str!("scene_fit/discs.rs"),
    include_str!("../../tissue/src/mesh/surface.rs"),
    include_str!("../../tissue/src/organ.rs"),
    include_str!("../../tissue/src/organ/abdomen.rs"),
    include_str!("../../tissue/src/organ/foot.rs"),
    include_str!("../../tissue/src/organ/gallbladder.rs"),
    include_str!("../../tissue/src/organ/liver.rs"),
    include_str!("../../tissue/src/organ/parts.rs"),
    include_str!("../../tissue/src/tissue/material.rs"),
    include_str!("../../tissue/src/tissue/organ_source.rs"),
];

/// A folder of stored answers.
#[derive(Debug)]
pub struct Solved {
    folder: PathBuf,
    /// Files of the answers that were reused.
    found: Mutex<Vec<PathBuf>>,
    refused: Mutex<Vec<String>>,
}

impl Solved {
    /// Opens the folder of answers beside a folder of results.
    #[must_use]
    pub fn beside(out: &Path) -> Self {
        Self {
            folder: out.parent().unwrap_or_else(|| Path::new("")).join(FOLDER),
            found: Mutex::default(),
            refused: Mutex::default(),
        }
    }

    /// Number of answers that were reused.
    #[must_use]
    pub fn found(&self) -> usize {
        lines(&self.found).len()
    }

    /// Messages on the requests so far: answers that were reused, with the way to recompute them,
    /// and files that were rejected.
    #[must_use]
    pub fn said(&self) -> Vec<String> {
        let mut said = lines(&self.refused);
        match &lines(&self.found)[..] {
            [] => {}
            [file] => said.push(format!("finite elements: solved before, {}; delete it to compute anew", file.display())),
            files => said.push(format!(
                "finite elements: {} presses solved before, in {}; delete it to compute anew",
                files.len(),
                self.folder.display()
            )),
        }
        said
    }

    /// Returns the answer of `count` numbers to a problem. If it is not stored, `solve` computes
    /// it, and it is stored.
    ///
    /// # Errors
    /// Errors of `solve`. A failure to read or store an answer is not an error.
    pub fn answer<E>(&self, problem: &str, count: usize, solve: impl FnOnce() -> Result<Vec<f64>, E>) -> Result<Vec<f64>, E> {
        let problem = format!("elements {:016x}\n{problem}", elements());
        let file = self.folder.join(format!("{:016x}.txt", checksum(&problem)));
        if let Ok(bytes) = std::fs::read(&file) {
            match read(&bytes, &problem, count) {
                Ok(numbers) => {
                    push(&self.found, file);
                    return Ok(numbers);
                }
                Err(why) => push(&self.refused, format!("finite elements: {} {why}: computed anew", file.display())),
            }
        }
        let numbers = solve()?;
        // a folder that cannot be written costs only time in the next run
        let _ = self.keep(&file, &problem, &numbers);
        Ok(numbers)
    }

    /// Writes an answer, either completely or not at all, because another run may read the file.
    fn keep(&self, file: &Path, problem: &str, numbers: &[f64]) -> std::io::Result<()> {
        let mut body = String::from("numbers");
        for number in numbers {
            // writing to a string cannot fail
            let _ = write!(body, " {:016x}", number.to_bits());
        }
        let body = format!("{body}\n{problem}");
        std::fs::create_dir_all(&self.folder)?;
        let draft = file.with_extension(format!("{}.draft", std::process::id()));
        std::fs::write(&draft, format!("{FIRST_LINE}\nchecksum {:016x}\n{body}", CRC.checksum(body.as_bytes())))?;
        std::fs::rename(draft, file)
    }
}

fn push<T>(to: &Mutex<Vec<T>>, line: T) {
    if let Ok(mut lines) = to.lock() {
        lines.push(line);
    }
}

fn lines<T: Clone>(of: &Mutex<Vec<T>>) -> Vec<T> {
    of.lock().map(|lines| lines.clone()).unwrap_or_default()
}

/// CRC-64/XZ checksum of the text of a problem, by which the answer's file is named.
#[must_use]
pub fn checksum(problem: &str) -> u64 {
    CRC.checksum(problem.as_bytes())
}

/// Fingerprint of the source code of the elements.
fn elements() -> u64 {
    let mut digest = CRC.digest();
    ELEMENTS.iter().for_each(|source| digest.update(source.as_bytes()));
    digest.finalize()
}

/// Reads the numbers of a file, or says why the file cannot be used.
fn read(bytes: &[u8], problem: &str, count: usize) -> Result<Vec<f64>, &'static str> {
    let text = std::str::from_utf8(bytes).map_err(|_| "is damaged")?;
    let rest = text.strip_prefix(FIRST_LINE).and_then(|rest| rest.strip_prefix("\nchecksum "));
    let (checksum, body) = rest.and_then(|rest| rest.split_once('\n')).ok_or("is no answer of finite elements")?;
    if u64::from_str_radix(checksum, 16) != Ok(CRC.checksum(body.as_bytes())) {
        return Err("is damaged");
    }
    let (numbers, asked) = body.split_once('\n').ok_or("is damaged")?;
    if asked != problem {
        return Err("answers another problem");
    }
    let numbers = numbers.strip_prefix("numbers").ok_or("is damaged")?.split_whitespace();
    let numbers = numbers.map(|bits| u64::from_str_radix(bits, 16).map(f64::from_bits));
    let numbers: Vec<f64> = numbers.collect::<Result<_, _>>().map_err(|_| "is damaged")?;
    if numbers.len() != count || !numbers.iter().all(|n| n.is_finite()) {
        return Err("lacks numbers");
    }
    Ok(numbers)
}
