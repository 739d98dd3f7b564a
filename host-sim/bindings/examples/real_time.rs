//! The haptic loop in a thread of real-time priority, at a thousand ticks per second, and its
//! jitter: how late each tick began, and how long it took. Argument: seconds, 10 by default.
//!
//! A computed pose takes the place of a device. Read your own device where `tip_m` is set, and
//! drive it where `force_n` is.

use std::time::{Duration, Instant};

use palpate_loop::haptic_session::{HapticSession, Input};

/// Period of the loop.
const TICK: Duration = Duration::from_millis(1);
/// Real-time priority, from 1 to 99 on Linux: above everything but the kernel's own threads.
#[cfg(unix)]
const PRIORITY: u8 = 80;

/// Requests the scheduling policy under which no ordinary thread can preempt this one.
#[cfg(unix)]
fn raise_priority() -> Result<(), String> {
    use thread_priority::{
        RealtimeThreadSchedulePolicy, ThreadPriority, ThreadSchedulePolicy, set_thread_priority_and_policy, thread_native_id,
    };
    let priority = ThreadPriority::Crossplatform(PRIORITY.try_into()?);
    let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    set_thread_priority_and_policy(thread_native_id(), priority, policy).map_err(|error| error.to_string())
}

#[cfg(not(unix))]
fn raise_priority() -> Result<(), String> {
    thread_priority::set_current_thread_priority(thread_priority::ThreadPriority::Max).map_err(|error| error.to_string())
}

/// Runs the loop; returns lateness and duration of every tick [us].
fn run(session: &mut HapticSession, ticks: usize) -> Vec<[f64; 2]> {
    let (site_m, axis) = (session.tissue().patch().site_m(), session.tissue().params().probe.axis);
    let mut times_us = Vec::with_capacity(ticks);
    let mut next = Instant::now() + TICK;
    let mut most_n = 0.0_f32;
    for tick in 0..ticks {
        std::thread::sleep(next.saturating_duration_since(Instant::now()));
        let began = Instant::now();
        let late = began.saturating_duration_since(next);
        // up and down once a second, to a depth of 3 mm
        let phase = std::f32::consts::TAU * (tick % 1000) as f32 * 1e-3;
        let depth_m = if tick < 1000 { -1e-3 } else { 1e-3 - 2e-3 * phase.cos() };
        let tip_m = site_m - axis * depth_m;
        let whole_ticks = late.as_micros() / TICK.as_micros();
        let late_ticks = u16::try_from(whole_ticks).unwrap_or(u16::MAX);
        session.tick(&Input { late_ticks, ..Input::at(tip_m) });
        let force_n = session.drive_n();
        most_n = most_n.max(force_n.norm());
        times_us.push([late, began.elapsed()].map(|time| time.as_secs_f64() * 1e6));
        next += TICK * (1 + u32::from(late_ticks));
    }
    let fault = session.telemetry().and_then(|record| record.fault).map_or("no fault".into(), |fault| fault.to_string());
    println!("largest force {most_n:.3} N, mode at the end {:?}, {fault}", session.mode());
    times_us
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let seconds: usize = std::env::args().nth(1).map_or(Ok(10), |text| text.parse())?;
    let mut session = HapticSession::open("block", None, "touch")?;
    session.arm()?;
    let measured = std::thread::spawn(move || {
        match raise_priority() {
            Ok(()) => println!("real-time priority: yes"),
            Err(why) => println!(
                "real-time priority: no ({why}); run as root, or allow it: 'rtprio 90' for your user in /etc/security/limits.conf"
            ),
        }
        run(&mut session, 1000 * seconds)
    });
    let times_us = measured.join().map_err(|_| "the thread ended by a panic")?;
    for (column, what) in ["late by", "tick took"].iter().enumerate() {
        let mut sorted: Vec<f64> = times_us.iter().map(|row| row[column]).collect();
        sorted.sort_by(f64::total_cmp);
        let at = |share: f64| sorted.get(((sorted.len().max(1) - 1) as f64 * share) as usize).copied().unwrap_or(0.0);
        println!(
            "{what:>9}: median {:.1} us, 99 % {:.1} us, 99.9 % {:.1} us, worst {:.1} us",
            at(0.5),
            at(0.99),
            at(0.999),
            at(1.0)
        );
    }
    Ok(())
}
