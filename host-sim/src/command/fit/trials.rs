//! The table of trials that ships: every scene of a folder fitted, the rows put together.

use std::path::{Path, PathBuf};

use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;
use palpate_tissue::trials::Trial;

use super::FitArgs;
use crate::error::Error;

/// Fits each scene into a folder of its own name, then writes `trials.json`, a row a line.
pub(super) fn run(args: &FitArgs, scenes: &Path) -> Result<(), Error> {
    let out = args.common.folder("trials");
    let refuse = |source| TissueError::Read { path: scenes.to_owned(), source };
    let mut files: Vec<PathBuf> = Vec::new();
    for entry in std::fs::read_dir(scenes).map_err(refuse)? {
        files.push(entry.map_err(refuse)?.path());
    }
    files.retain(|path| path.extension().is_some_and(|e| e == "toml"));
    files.sort();
    let mut rows: Vec<Trial> = Vec::new();
    for file in &files {
        let folder = out.join(file.file_stem().unwrap_or_default());
        let mut own = args.clone();
        own.trials = None;
        own.common.scene = file.display().to_string();
        own.common.out = Some(folder.clone());
        // a fit that misses its tolerance is a trial as well
        match own.fit_scene() {
            Ok(()) | Err(Error::Tissue(TissueError::Check(_))) => {}
            Err(error) => return Err(error),
        }
        let path = folder.join("trials.json");
        let text = std::fs::read_to_string(&path).map_err(|source| TissueError::Read { path, source })?;
        let read: Result<Vec<Trial>, _> = serde_json::from_str(&text);
        rows.extend(read.map_err(|cause| TissueError::Usage(format!("trials.json: {cause}: remove the folder and fit again")))?);
    }
    let lines: Vec<String> = rows.iter().filter_map(|row| serde_json::to_string(row).ok()).collect();
    let folder = OutputFolder::add_to(&out)?;
    folder.write("trials.json", format!("[\n{}\n]\n", lines.join(",\n")).as_bytes())?;
    println!("wrote {}: {} trials", folder.publish()?.join("trials.json").display(), rows.len());
    Ok(())
}
