//! The loop against a mock of the Inverse Service's socket: a first frame with the device's
//! configuration, then states; each command is answered by the next state, so no test waits for
//! time.

use std::time::Duration;

use futures_util::{SinkExt, StreamExt};
use haply::HaplyDevice;
use palpate::{Fault, Vector3};
use palpate_haply::{SILENCE, START_ABOVE_M, ServiceError, run};
use palpate_loop::haptic_session::{HapticSession, Input};
use serde_json::{Value, json};
use tokio::net::TcpListener;
use tokio::task::JoinHandle;
use tokio_tungstenite::accept_async;
use tokio_tungstenite::tungstenite::Message;

const TICKS: u16 = 2500;
const START_M: [f32; 3] = [0.1, 0.2, 0.3];

/// Way of the tip from the start [m], in Haply's axes: 15 mm down, a wait until the force is ready,
/// then 4 mm into the tissue and out.
fn way_m(tick: u16) -> [f32; 3] {
    let steps = if tick < 1200 { 0 } else { (tick - 1200).min(TICKS - tick + 500) };
    [0.0, 0.0, -3e-5 * f32::from(tick.min(500)) - 1e-5 * f32::from(steps)]
}

fn position_m(tick: u16) -> [f32; 3] {
    let way = way_m(tick);
    std::array::from_fn(|k| START_M[k] + way[k])
}

fn frame([x, y, z]: [f32; 3], with_config: bool) -> Message {
    let mut device = json!({
        "device_id": "04C3",
        "state": { "cursor_position": { "x": x, "y": y, "z": z }, "mode": "idle" },
        "status": { "calibrated": true, "in_use": true, "power_supply": true, "ready": true, "started": true },
    });
    if with_config {
        device["config"] = json!({ "type": "inverse3", "port": "COM15", "handedness": "right" });
    }
    Message::Text(json!({ "session_id": 176, "inverse3": [device] }).to_string().into())
}

/// Starts a service for one client. Returns its address, and the forces that it was told.
async fn service(frames: u16, devices: bool) -> (String, JoinHandle<Vec<[f32; 3]>>) {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap().to_string();
    let told = tokio::spawn(async move {
        let mut socket = accept_async(listener.accept().await.unwrap().0).await.unwrap();
        let first = if devices { frame(START_M, true) } else { Message::Text(r#"{"session_id":176,"inverse3":[]}"#.into()) };
        socket.send(first).await.unwrap();
        let (mut forces, mut tick) = (Vec::new(), 0);
        while let Some(Ok(message)) = socket.next().await {
            let Message::Text(text) = message else { break };
            let said: Value = serde_json::from_str(&text).unwrap();
            let device = &said["inverse3"][0];
            let force = &device["commands"]["set_cursor_force"];
            assert_eq!((&device["device_id"], &force["execute"]), (&json!("04C3"), &json!(true)), "{text}");
            forces.push(["x", "y", "z"].map(|axis| force["vector"][axis].as_f64().unwrap() as f32));
            if tick < frames && socket.send(frame(position_m(tick), false)).await.is_err() {
                break;
            }
            tick += 1;
        }
        forces
    });
    (address, told)
}

async fn pressed(
    frames: u16,
    devices: bool,
    late_from: u32,
    ends_at: u32,
) -> (Result<Option<Fault>, ServiceError>, Vec<[f32; 3]>, HapticSession) {
    let mut session = HapticSession::open("block", None, "inverse3").unwrap();
    let (address, told) = service(frames, devices).await;
    let mut device = HaplyDevice::new(&format!("http://{address}"), &format!("ws://{address}/")).await.unwrap();
    let (mut ticks, mut ms, mut asked) = (0, 0, 0);
    let clock = || {
        ticks += 1;
        ms += if ticks > late_from { 5 } else { 1 };
        Duration::from_millis(ms)
    };
    let ends = || {
        asked += 1;
        asked >= ends_at
    };
    // a service that sends all frames may be as slow as the machine that runs the test
    let silence = if frames == TICKS { Duration::from_secs(60) } else { SILENCE };
    let ended = run(&mut device, &mut session, clock, ends, silence).await;
    device.shutdown().await.unwrap();
    drop(device);
    (ended, told.await.unwrap(), session)
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn forces_on_the_socket_equal_the_session_to_the_bit() {
    let last = u32::from(TICKS) - 201;
    let (ended, told, mut found) = pressed(TICKS, true, u32::MAX, last).await;
    assert_eq!(ended.unwrap(), None);
    let mut own = HapticSession::open("block", None, "inverse3").unwrap();
    own.arm().unwrap();
    let above_m = own.tissue().patch().site_m() + Vector3::z() * START_ABOVE_M;
    let (mut felt, mut ticks) = (0, 0_u16);
    assert_eq!(told[0], [0.0; 3]);
    for force in &told[1..] {
        let position = position_m(ticks);
        let way: [f32; 3] = std::array::from_fn(|k| position[k] - START_M[k]);
        own.tick(&Input::at(above_m + Vector3::new(-way[1], way[0], way[2])));
        let n = own.drive_n();
        assert_eq!(force.map(f32::to_bits), [n.y, -n.x, n.z].map(f32::to_bits), "tick {ticks}");
        felt += u16::from(n.z > 0.01);
        ticks += 1;
        if u32::from(ticks) == last {
            own.stop();
        }
    }
    assert!(felt > 500 && ticks == TICKS && told[usize::from(TICKS)] == [0.0; 3], "{felt} of {ticks}");
    assert_eq!(found.hash(), own.hash());
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_slow_service_is_a_fault_and_the_last_force_is_zero() {
    let (ended, told, _) = pressed(TICKS, true, 2100, u32::MAX).await;
    assert!(ended.unwrap().unwrap().to_string().contains("too late"));
    assert!(told[2090][2] > 0.05 && told.last() == Some(&[0.0; 3]), "{:?}", &told[2090..]);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_service_without_device_or_without_states_is_one_sentence() {
    let (ended, ..) = pressed(0, false, u32::MAX, u32::MAX).await;
    assert_eq!(ended.unwrap_err().to_string(), "the service has no Inverse3: plug it in");
    let (ended, ..) = pressed(10, true, u32::MAX, u32::MAX).await;
    assert_eq!(ended.unwrap_err().to_string(), "the service sends no more states: start it again");
}
