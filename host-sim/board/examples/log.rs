//! Decodes the log of a firmware image, as it comes from the emulator: `log IMAGE < frames`.

use std::io::{Read, stdin};
use std::process::ExitCode;

use palpate_board::defmt_log;

fn main() -> ExitCode {
    let decoded = std::env::args_os().nth(1).ok_or_else(|| "give the image's ELF file".to_owned()).and_then(|image| {
        let elf = std::fs::read(&image).map_err(|error| format!("{}: {error}", image.display()))?;
        let mut frames = Vec::new();
        stdin().read_to_end(&mut frames).map_err(|error| format!("standard input: {error}"))?;
        Ok(defmt_log::decode(&elf, &frames))
    });
    match decoded {
        Ok(lines) => {
            print!("{lines}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("log: {error}");
            ExitCode::from(2)
        }
    }
}
