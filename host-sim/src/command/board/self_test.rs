//! `palpate board self-test`: compares the report of a self-test image with the same run on this
//! machine.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use palpate::PatchFile;
use palpate_tissue::Error as TissueError;

use crate::command::options::board::SelfTest;
use crate::error::Error;
use crate::port::self_test::Report;
use crate::port::{Line, PortError};

/// Longest wait for a report: the run lasts four seconds, and the report is sent every other
/// second.
const PATIENCE: Duration = Duration::from_secs(12);
/// Folder of the patches that ship, relative to the repository.
const SHIPPED: &str = "firmware/patches";

impl SelfTest {
    pub(super) fn run(&self) -> Result<(), Error> {
        let (report, line) = match (&self.report, &self.port) {
            (Some(path), _) => kept(path)?,
            (None, Some(port)) => heard(port)?,
            (None, None) => return Err(TissueError::Usage("give --port or --report".into()).into()),
        };
        if let Some(out) = &self.out {
            let source = std::fs::write(out, line + "\n");
            source.map_err(|source| TissueError::Write { path: out.clone(), source })?;
        }
        print!("{}", report.words());
        if !report.error.is_empty() {
            return Err(TissueError::Check(format!("the board ran nothing: {}", report.error)).into());
        }
        let words = self.patch_of(&report)?;
        let patch = bytemuck::cast_slice(&words);
        let Some(difference) = report.compare(patch).map_err(TissueError::Build)? else {
            println!(
                "bits    the same as this machine's: state and forces, {} times in {} ticks",
                report.checks.len(),
                report.ticks
            );
            return match report.passed {
                true => Ok(()),
                false => Err(TissueError::Check(format!("the board's run did not pass: fault {}", report.fault)).into()),
            };
        };
        Err(TissueError::Check(format!(
            "the board's bits are not this machine's: after {} ticks the {} is {}, here {}; is the image of this version and built with this patch?",
            difference.tick, difference.word, difference.board, difference.here
        ))
        .into())
    }

    /// Words of the patch file on which the board's run was made.
    fn patch_of(&self, report: &Report) -> Result<Vec<u32>, Error> {
        let wanted = u32::from_str_radix(&report.patch_checksum, 16).ok();
        let candidates = match &self.patch {
            Some(path) => vec![path.clone()],
            None => shipped(),
        };
        for path in &candidates {
            let words = on_words(path)?;
            if PatchFile::checksum(bytemuck::cast_slice(&words)) == wanted {
                return Ok(words);
            }
        }
        Err(TissueError::Usage(match &self.patch {
            Some(path) => format!(
                "{}: this is not the patch of the report, whose checksum is {}: give the file that PALPATE_PATCH named",
                path.display(),
                report.patch_checksum
            ),
            None => format!(
                "no patch in {SHIPPED} has the checksum {} of the report: give the file that PALPATE_PATCH named with --patch",
                report.patch_checksum
            ),
        })
        .into())
    }
}

/// Patches of the repository around the working folder.
fn shipped() -> Vec<PathBuf> {
    let here = std::env::current_dir().unwrap_or_default();
    let folder = here.ancestors().map(|path| path.join(SHIPPED)).find(|path| path.is_dir());
    let entries = folder.and_then(|folder| std::fs::read_dir(folder).ok());
    let mut paths: Vec<PathBuf> = entries.into_iter().flatten().flatten().map(|entry| entry.path()).collect();
    paths.retain(|path| path.extension().is_some_and(|extension| extension == "patch"));
    paths.sort();
    paths
}

/// Reads a file into memory that is aligned to words.
fn on_words(path: &Path) -> Result<Vec<u32>, Error> {
    let bytes = std::fs::read(path).map_err(|source| TissueError::Read { path: path.into(), source })?;
    let mut words = vec![0_u32; bytes.len().div_ceil(4)];
    bytemuck::cast_slice_mut::<_, u8>(&mut words)[..bytes.len()].copy_from_slice(&bytes);
    Ok(words)
}

fn kept(path: &Path) -> Result<(Report, String), Error> {
    let bytes = std::fs::read(path).map_err(|source| TissueError::Read { path: path.into(), source })?;
    let text = String::from_utf8_lossy(&bytes);
    let found = Report::find(&text).map(|(report, line)| (report, line.to_owned()));
    found.ok_or_else(|| {
        let says = "no report of a self-test image stands in it, or none that is whole: keep one with --port PORT --out FILE";
        TissueError::Usage(format!("{}: {says}", path.display())).into()
    })
}

/// Listens until a complete report has arrived.
fn heard(port: &str) -> Result<(Report, String), Error> {
    let mut line = Line::open(port)?;
    let (begun, mut text) = (Instant::now(), String::new());
    while begun.elapsed() < PATIENCE {
        let gone = |_| PortError::Missing(port.into());
        text.push_str(&line.text(Duration::from_millis(100)).map_err(gone)?);
        // the last line may be incomplete until it has ended
        let whole = text.rfind('\n').and_then(|end| text.get(..end));
        if let Some((report, line)) = whole.and_then(Report::find) {
            return Ok((report, line.to_owned()));
        }
    }
    Err(match text.len() {
        0 => PortError::Mute(port.into()).into(),
        bytes => TissueError::Usage(format!(
            "{port}: {bytes} bytes came and no report of a self-test image among them: flash one (`cargo fw-selftest-f446` and its sisters); `palpate board list {port}` tells who speaks"
        ))
        .into(),
    })
}
