//! Runs 1 000 ticks of the haptic loop in a program of your own, with a scene and a device's
//! profile that are given by name or by file.

use palpate_loop::haptic_session::{HapticSession, Input};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let given: Vec<String> = std::env::args().skip(1).collect();
    let word = |n: usize, default| given.get(n).map_or(default, String::as_str);
    // `None`: no patch other than the one that the scene names
    let mut session = HapticSession::open(word(0, "nodule"), None, word(1, "touch"))?;
    let (site_m, outward) = (session.tissue().patch().site_m(), session.tissue().params().probe.axis);
    session.cautions().iter().for_each(|caution| eprintln!("{caution}"));
    session.arm()?;
    for tick in 0..1000_u16 {
        // put the position of your device here [m]; this one waits outside for 700 ticks, then goes
        // 3 mm deep
        let depth_m = 4e-3 * f32::from(tick.saturating_sub(700)) / 300.0 - 1e-3;
        let telemetry = *session.tick(&Input::at(site_m - outward * depth_m));
        // send this force to the motors of your device [N], then wait for the next millisecond
        let force_n = session.drive_n();
        if tick % 100 == 99 {
            println!("{tick:>4} ms: {:?}, {:.2} mm deep, {:.3} N", telemetry.mode, depth_m.max(0.0) * 1e3, force_n.norm());
        }
    }
    Ok(())
}
