//! Runs an emulated board until Ctrl-C: the image of `cargo fw` in the emulator, on a
//! pseudo-terminal that `palpate board` uses as its serial port.
//!
//! ```text
//! cargo run --release -p palpate-tests --example emulated_board -- my-paddle.toml
//! ```
//!
//! With the profile of a mechanism, a scripted hand moves the mechanism's encoders: it waits in the
//! home pose while no force is allowed, then makes a press of 4 mm. The port is linked as
//! `target/board`.

use std::process::ExitCode;
use std::time::Duration;

#[cfg(unix)]
fn main() -> ExitCode {
    use palpate_board::EmulatedBoard;
    use palpate_sim::port::device_file;
    use palpate_tests::board_on_a_port::{BoardOnAPort, Hand, Pace};
    use palpate_tests::emulator::build_firmware;
    use palpate_tests::palpate_command::repository;

    let hand = match std::env::args().nth(1).as_deref().map(device_file::load) {
        Some(Err(error)) => {
            eprintln!("emulated_board: {error}");
            return ExitCode::from(2);
        }
        Some(Ok((_, profile))) => profile.mechanism.map_or(Hand::Tip, Hand::Joints),
        None => Hand::Tip,
    };
    let target = repository().join("target");
    let image = std::env::var_os("PALPATE_IMAGE").map_or_else(|| build_firmware(&target, &[]), |image| Ok(image.into()));
    let image = match image {
        Ok(image) => image,
        Err(error) => {
            eprintln!("emulated_board: {error}");
            return ExitCode::from(2);
        }
    };
    let board = BoardOnAPort::start_with(&image, EmulatedBoard::M4f, Pace::RealTime, hand);
    let link = target.join("board");
    let _absent = std::fs::remove_file(&link);
    if let Err(error) = std::os::unix::fs::symlink(board.port(), &link) {
        eprintln!("emulated_board: {}: {error}", link.display());
        return ExitCode::from(2);
    }
    println!("a board on {}, also target/board; Ctrl-C ends it", board.port());
    loop {
        std::thread::sleep(Duration::from_secs(1));
    }
}

#[cfg(not(unix))]
fn main() -> ExitCode {
    eprintln!("emulated_board: a pseudo-terminal is needed, and this system has none");
    ExitCode::from(2)
}
