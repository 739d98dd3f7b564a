//! Presses a scene with an Inverse3: `cargo run -- [SCENE [PROFILE [HOST:PORT]]]`; Ctrl-C ends.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Instant;

use haply::HaplyDevice;
use palpate_haply::{SILENCE, ServiceError, run};
use palpate_loop::haptic_session::HapticSession;

#[tokio::main]
async fn main() -> Result<(), ServiceError> {
    let given: Vec<String> = std::env::args().skip(1).collect();
    let word = |n: usize, default| given.get(n).map_or(default, String::as_str);
    let service = word(2, "localhost:10001");
    let mut session = HapticSession::open(word(0, "block"), None, word(1, "inverse3")).map_err(|error| error.to_string())?;
    session.cautions().iter().for_each(|caution| eprintln!("{caution}"));
    let mut device = HaplyDevice::new(&format!("http://{service}"), &format!("ws://{service}/"))
        .await
        .map_err(|error| format!("no Inverse Service at {service}: {error}"))?;
    let ends = Arc::new(AtomicBool::new(false));
    let asked = Arc::clone(&ends);
    tokio::spawn(async move {
        let _ended = tokio::signal::ctrl_c().await;
        asked.store(true, Ordering::Relaxed);
    });
    println!("inverse3: Ctrl-C ends; its pose now is 20 mm above the tissue");
    let begun = Instant::now();
    let fault = run(&mut device, &mut session, || begun.elapsed(), || ends.load(Ordering::Relaxed), SILENCE).await?;
    println!("inverse3: {}", fault.map_or("ended".into(), |fault| fault.to_string()));
    device.shutdown().await
}
