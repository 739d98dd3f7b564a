//! Checksums by which rows of other programs and other inputs are told apart.

use std::fs::File;
use std::io::{self, Read};
use std::path::Path;

use palpate_tissue::Error;
use palpate_tissue::scene::{PRESETS, Scene};

const CHECKSUM: crc::Crc<u64, crc::Table<16>> = crc::Crc::<u64, crc::Table<16>>::new(&crc::CRC_64_XZ);

/// Checksum of bytes, as hexadecimal digits: CRC-64/XZ.
pub fn checksum(bytes: &[u8]) -> String {
    format!("{:016x}", CHECKSUM.checksum(bytes))
}

/// Checksum of the running program's file. Programs from the same sources may round differently if
/// compiler, profile or machine differ; the same program file does not.
pub fn program() -> Result<String, Error> {
    // the file that runs, even if its path has been replaced since
    let running = Path::new("/proc/self/exe");
    let open = || if running.exists() { File::open(running) } else { File::open(std::env::current_exe()?) };
    let read = |mut file: File| -> io::Result<String> {
        let mut digest = CHECKSUM.digest();
        let mut buffer = vec![0; 1 << 20];
        loop {
            match file.read(&mut buffer)? {
                0 => return Ok(format!("{:016x}", digest.finalize())),
                read => digest.update(&buffer[..read]),
            }
        }
    };
    open().and_then(read).map_err(|source| Error::Read { path: "the program's own file".into(), source })
}

/// Checksum of a scene's file and of the files that it names; `None` for a preset, which ships with
/// the program.
pub fn scene(name_or_path: &str) -> Result<Option<String>, Error> {
    if PRESETS.iter().any(|(name, _)| *name == name_or_path) {
        return Ok(None);
    }
    let read = |path: &Path| std::fs::read(path).map_err(|source| Error::Read { path: path.into(), source });
    let mut bytes = read(Path::new(name_or_path))?;
    if let Ok(scene) = Scene::load(name_or_path) {
        for file in scene.files() {
            bytes.extend(read(file).unwrap_or_default());
        }
    }
    Ok(Some(checksum(&bytes)))
}
