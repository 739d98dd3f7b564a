//! An emulated board on a pseudo-terminal, which a host uses like a board on a serial port.
//!
//! ```text
//! host ─ pseudo-terminal ─ this module ─ FIFOs ─ image (`paced`) in the emulator
//! ```
//!
//! The image runs its own tick timer, sensors, host timeout and records. Its clock stops until it
//! receives the next tick's link bytes and hand position. Its time therefore cannot jump, and no
//! tick is late however busy this machine is.

use std::fs::{File, OpenOptions};
use std::io::{Read, Write};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use palpate::haptic::mode::Mode;
use palpate_board::EmulatedBoard;
use palpate_controller::force_out::{DacCode, Outputs};
use palpate_controller::kinematics::MechanismProfile;
use palpate_controller::link::{FromBoard, Receiver, Record};
use palpate_controller::script::{self, LEAD_TICKS, sensed};
use palpate_controller::serve;

use crate::disassembly::variable;
use crate::free_handle::FreeHandle;
use crate::joint_hand::counts_at;
use crate::pseudo_terminal::PseudoTerminal;

/// Ticks of a round of the script: it starts outside the tissue, stays there until the board is
/// armed, and ends after the presses.
const ROUND_TICKS: u32 = LEAD_TICKS + 2_000;
/// Ticks between records.
const RECORD_TICKS: u64 = serve::RECORD_TICKS as u64;
/// Number of ticks of input that may be sent to the emulator ahead of its records.
const AHEAD_TICKS: u64 = 60;
/// Largest number of link bytes that reach the board per tick; its link transfers 92.
const LINK_BYTES: usize = 40;
/// Time of silence after which a disarmed board treats the host as gone.
const AWAY: Duration = Duration::from_millis(400);
/// Time of silence after which an armed board treats the host as gone. It is longer because on a
/// busy machine a host may be delayed by half a second.
const AWAY_FROM_FORCE: Duration = Duration::from_secs(10);
/// Such a time for a board that is commissioned: shorter than the two seconds for which the next
/// host waits for a board, if the last one ended without the board hearing of it.
const AWAY_FROM_COMMISSIONING: Duration = Duration::from_millis(1_500);
/// Time limit for an event. Events take a second or two; a missing one must not hang the tests.
const LONGEST: Duration = Duration::from_secs(300);
/// Values in the memory that a reset does not clear, as `firmware/controller/src/resets.rs` and
/// `firmware/src/board/resets.rs` write them.
const RESETS_MAGIC: u32 = 0x5A1E_0B07;
const CRASHED: u32 = 0xC4A5_4ED0;
/// A position outside every workspace, too far away to be reached within a tick.
const ASTRAY_M: [f32; 3] = [1.0, 0.0, 0.0];
/// Largest number of unread bytes on the host's side: half of a terminal's buffer.
const LINE: u64 = 2048;
const TICK: Duration = Duration::from_millis(1);

/// Flag in a packet's length byte: the hand is given in encoder counts.
const COUNTED: u8 = 0x80;
/// Encoder counts at power-on, in the home pose.
const POWER_ON_COUNTS: [i32; 3] = [1_234, -567, 89];
/// Ticks of the motion from the home pose to the script's first position.
const APPROACH_TICKS: u32 = 500;

/// Source of the board's sensor readings.
#[derive(Clone, Debug)]
pub enum Hand {
    /// The script's tip position, from the first tick on.
    Tip,
    /// Encoder counts of a mechanism whose tip follows the script. It stays in its home pose while
    /// no force is allowed.
    Joints(MechanismProfile),
    /// Encoder counts of a handle that the board's own motors and the test's user move.
    Free(Arc<Mutex<FreeHandle>>),
}

impl Hand {
    /// Returns the three words of a packet and the flag that marks them as counts. `felt_ticks` is
    /// the number of ticks for which a force has been allowed; `pins` are those of a board with a
    /// free handle.
    fn words(&self, tick: u32, felt_ticks: u32, pins: Outputs) -> ([u32; 3], u8) {
        let mechanism = match self {
            Self::Tip => {
                let tip_m: [f32; 3] = sensed(tick % ROUND_TICKS, LEAD_TICKS).position_m.into();
                return (tip_m.map(f32::to_bits), 0);
            }
            Self::Free(handle) => return (held(handle).tick(pins).map(i32::cast_unsigned), COUNTED),
            Self::Joints(mechanism) => mechanism,
        };
        let script_tick = felt_ticks.saturating_sub(APPROACH_TICKS) % ROUND_TICKS;
        let place_m = script::counts(script_tick, LEAD_TICKS).map(|axis| f64::from(axis.0) * 1e-5);
        let there = counts_at(mechanism, place_m.into());
        let (share, whole) = (i64::from(felt_ticks.min(APPROACH_TICKS)), i64::from(APPROACH_TICKS));
        let counts = there.map(|joint| (i64::from(joint) * share / whole) as i32);
        (std::array::from_fn(|joint| (POWER_ON_COUNTS[joint] + counts[joint]).cast_unsigned()), COUNTED)
    }
}

/// Speed of the board's clock.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Pace {
    /// At most as fast as this machine's clock.
    RealTime,
    /// After each byte from a host, up to this many ticks run without a pause; then the board waits
    /// for the next byte, as long as the host is connected. On a busy machine the run takes longer,
    /// but the board does not time out.
    ByHost(u32),
}

/// State of the board from its own records, independent of what the host sees.
#[derive(Clone, Copy, Debug)]
pub struct Truth {
    /// Newest record that the board sent.
    pub record: Record,
    /// Largest force since the start [N].
    pub largest_n: f32,
    /// Number of records received; there is one every second tick.
    pub records: u64,
}

/// A running board; dropping the value stops it.
pub struct BoardOnAPort {
    child: Child,
    port: String,
    plug: Arc<Mutex<Option<PseudoTerminal>>>,
    truth: Arc<Mutex<Option<Truth>>>,
    switches: Arc<Switches>,
    threads: Vec<JoinHandle<()>>,
    _folder: tempfile::TempDir,
    // held because several emulators at once would delay each other's hosts
    _one_at_a_time: MutexGuard<'static, ()>,
}

/// Flags shared with the thread that drives the board.
#[derive(Default)]
struct Switches {
    ended: AtomicBool,
    /// The hand is far outside the workspace.
    astray: AtomicBool,
    /// The host process has ended, so the board does not wait for it.
    host_gone: AtomicBool,
    /// The board is arming or may exert a force.
    armed: AtomicBool,
    /// A commissioning is in progress.
    commissioned: AtomicBool,
    /// The board may exert a force now.
    felt: AtomicBool,
    records: AtomicU64,
    /// Last tick in which a byte of the host arrived.
    heard_tick: AtomicU64,
}

impl BoardOnAPort {
    /// Starts an image with a scripted tip.
    ///
    /// # Panics
    /// Panics if there is no emulator or no pseudo-terminal.
    pub fn start(elf: &Path, machine: EmulatedBoard, pace: Pace) -> Self {
        Self::start_with(elf, machine, pace, Hand::Tip)
    }

    /// Starts an image whose retained memory says that three crashes in a row have reset the board.
    ///
    /// # Panics
    /// Panics if there is no emulator or no pseudo-terminal.
    pub fn start_after_crashes(elf: &Path, machine: EmulatedBoard, pace: Pace) -> Self {
        let [resets, cause] = ["resets::RESETS", "resets::CAUSE"].map(|name| variable(elf, name));
        let words = |at: u64, words: &[u32]| -> Vec<(u64, u32)> { (at..).step_by(4).zip(words.iter().copied()).collect() };
        let check = RESETS_MAGIC ^ 3_u32.rotate_left(3);
        let kept = [words(resets, &[RESETS_MAGIC, 0, 0, 0, 0, 3, check]), words(cause, &[CRASHED])].concat();
        Self::launch(elf, machine, pace, Hand::Tip, &kept)
    }

    /// Starts an image with a given source of sensor readings.
    ///
    /// # Panics
    /// Panics if there is no emulator or no pseudo-terminal.
    pub fn start_with(elf: &Path, machine: EmulatedBoard, pace: Pace, hand: Hand) -> Self {
        Self::launch(elf, machine, pace, hand, &[])
    }

    /// `kept`: addresses and values of the words that the memory retained over a reset.
    fn launch(elf: &Path, machine: EmulatedBoard, pace: Pace, hand: Hand, kept: &[(u64, u32)]) -> Self {
        static RUNNING: Mutex<()> = Mutex::new(());
        let one_at_a_time = held(&RUNNING);
        let folder = tempfile::tempdir().expect("a temporary folder");
        let [to, from, pins] = ["to", "from", "pins"].map(|name| folder.path().join(name));
        assert!(Command::new("mkfifo").args([&to, &from, &pins]).status().expect("mkfifo").success());
        let (name, cpu) = machine.names();
        let mut words = format!("arg=palpate-firmware,arg=paced,arg={},arg={}", to.display(), from.display());
        let pins = matches!(hand, Hand::Free(_)).then_some(pins);
        words.extend(pins.iter().map(|pins| format!(",arg={}", pins.display())));
        // opened for reading and writing, since opening one end of a FIFO waits for the other
        let input = OpenOptions::new().read(true).write(true).open(&to).expect("the FIFO that was just made");
        let child = Command::new("qemu-system-arm")
            .args(["-machine", name, "-cpu", cpu, "-nographic", "-monitor", "none", "-serial", "null"])
            .args(["-semihosting-config", &format!("enable=on,target=native,{words}"), "-icount", "shift=2,sleep=off"])
            .args(kept.iter().flat_map(|(at, word)| ["-device".into(), format!("loader,addr={at:#x},data={word:#x},data-len=4")]))
            .arg("-kernel")
            .arg(elf)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .expect("qemu-system-arm starts");
        let terminal = PseudoTerminal::open().expect("a pseudo-terminal");
        let port = terminal.name().to_owned();
        let plug = Arc::new(Mutex::new(Some(terminal)));
        let (truth, switches) = (Arc::new(Mutex::new(None)), Arc::new(Switches::default()));
        let board = Self {
            threads: vec![
                std::thread::spawn({
                    let (plug, truth, switches) = (plug.clone(), truth.clone(), switches.clone());
                    move || tell(&from, &plug, &truth, &switches)
                }),
                std::thread::spawn({
                    let (plug, switches) = (plug.clone(), switches.clone());
                    move || drive(input, pins.as_deref(), &plug, &switches, pace, &hand)
                }),
            ],
            child,
            port,
            plug,
            truth,
            switches,
            _folder: folder,
            _one_at_a_time: one_at_a_time,
        };
        board.wait_for("the first record", |_| true);
        board
    }

    /// Path of the port.
    pub fn port(&self) -> &str {
        &self.port
    }

    /// Disconnects the port while the board runs on.
    pub fn unplug(&self) {
        *held(&self.plug) = None;
        self.host_is_gone();
    }

    /// Tells the board's driver that the host process has ended, so that the board's clock runs on.
    pub fn host_is_gone(&self) {
        self.switches.host_gone.store(true, Ordering::Relaxed);
    }

    /// Moves the hand a metre away within one tick, which is a fault, or back to the script.
    pub fn hand_astray(&self, astray: bool) {
        self.switches.astray.store(astray, Ordering::Relaxed);
    }

    /// State of the board from its newest record.
    ///
    /// # Panics
    /// Panics if the board has not sent a record yet.
    pub fn truth(&self) -> Truth {
        held(&self.truth).expect("a record has come")
    }

    /// Waits until the board's state meets the condition `is`.
    ///
    /// # Panics
    /// Panics if it does not within five minutes.
    pub fn wait_for(&self, what: &str, is: impl Fn(&Truth) -> bool) -> Truth {
        let begun = Instant::now();
        loop {
            let truth = *held(&self.truth);
            if let Some(truth) = truth.filter(|truth| is(truth)) {
                return truth;
            }
            assert!(begun.elapsed() < LONGEST, "not within {} s: {what}; {truth:?}", LONGEST.as_secs());
            std::thread::sleep(TICK);
        }
    }

    /// Waits for a force above 0.1 N.
    pub fn wait_for_force(&self) -> Truth {
        self.wait_for("a force", |truth| truth.force_n() > 0.1)
    }

    /// Waits until no force acts. Returns the number of the board's ticks since the call, or since
    /// the last byte from the host if that arrived later: on a busy machine, bytes may still be in
    /// transit when the host ends.
    ///
    /// # Panics
    /// Panics if that number is larger than `ticks`.
    pub fn wait_for_no_force(&self, ticks: u64) -> u64 {
        let begun = self.truth().records;
        let truth = self.wait_for("an end of the force", |truth| truth.force_n() == 0.0 && !truth.record.enabled);
        let begun = begun.max(self.switches.heard_tick.load(Ordering::Relaxed) / RECORD_TICKS);
        let took = truth.records.saturating_sub(begun) * RECORD_TICKS;
        assert!(took <= ticks, "the force lasted {took} ticks, {ticks} are allowed");
        took
    }
}

impl Truth {
    /// Magnitude of the force on the device [N].
    pub fn force_n(&self) -> f32 {
        self.record.applied_n.iter().map(|n| n * n).sum::<f32>().sqrt()
    }

    /// Mode in the record; `None` if its number is unknown.
    pub fn mode(&self) -> Option<Mode> {
        self.record.mode()
    }
}

impl Drop for BoardOnAPort {
    fn drop(&mut self) {
        self.switches.ended.store(true, Ordering::Relaxed);
        let _ = self.child.kill(); // the process that `launch` started
        let _ = self.child.wait();
        for thread in self.threads.drain(..) {
            let _ = thread.join();
        }
    }
}

/// Locks a mutex; a poisoned one still holds a valid value.
fn held<T>(shared: &Mutex<T>) -> MutexGuard<'_, T> {
    shared.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Copies the board's output to the port and updates the board's state from it.
fn tell(from: &Path, plug: &Mutex<Option<PseudoTerminal>>, truth: &Mutex<Option<Truth>>, switches: &Switches) {
    let Ok(mut from) = File::open(from) else { return };
    let (mut receiver, mut bytes) = (Receiver::NEW, [0; 4096]);
    while let Ok(came @ 1..) = from.read(&mut bytes) {
        for byte in &bytes[..came] {
            let message = receiver.push(*byte);
            if let Some(Ok(FromBoard::Commissioning(progress))) = message {
                switches.commissioned.store(progress.stage().is_some_and(|stage| !stage.ended()), Ordering::Relaxed);
            }
            if let Some(Ok(FromBoard::Record(record))) = message {
                let mut truth = held(truth);
                let before = truth.map_or((0.0, 0), |truth| (truth.largest_n, truth.records));
                let mut now = Truth { record, largest_n: 0.0, records: before.1 + 1 };
                now.largest_n = before.0.max(now.force_n());
                *truth = Some(now);
                switches.records.store(now.records, Ordering::Relaxed);
                let armed = record.mode().is_some_and(|mode| mode == Mode::Arming || mode.allows_force());
                switches.armed.store(armed, Ordering::Relaxed);
                switches.felt.store(record.mode().is_some_and(Mode::allows_force), Ordering::Relaxed);
            }
        }
        // if the host does not read, bytes are lost, as on a real serial line
        if let Some(plug) = &mut *held(plug)
            && plug.unread_bytes().is_ok_and(|waiting| waiting < LINE)
        {
            let _ = plug.ours.write_all(&bytes[..came]);
        }
    }
}

/// Sends the board its input, tick by tick.
fn drive(
    mut input: File,
    pins: Option<&Path>,
    plug: &Mutex<Option<PseudoTerminal>>,
    switches: &Switches,
    pace: Pace,
    hand: &Hand,
) {
    // opening the file waits for the image
    let (mut pins, mut packets_read) = (pins.and_then(|path| File::open(path).ok()), 1);
    let is = |switch: &AtomicBool| switch.load(Ordering::Relaxed);
    let (mut due, mut heard) = (Instant::now(), None::<Instant>);
    let (mut since_heard, mut waiting, mut felt_ticks) = (0, Vec::new(), 0_u32);
    for tick in 1_u32.. {
        felt_ticks = if is(&switches.felt) { felt_ticks.saturating_add(1) } else { 0 };
        let Ok(levels) = pins.as_mut().map_or(Ok(Outputs::OFF), |pins| levels(pins, packets_read)) else { return };
        let (words, counted) = hand.words(tick, felt_ticks, levels);
        let (words, counted) = if is(&switches.astray) { (ASTRAY_M.map(f32::to_bits), 0) } else { (words, counted) };
        let words: Vec<u8> = words.into_iter().flat_map(u32::to_le_bytes).collect();
        let there = || {
            let away = match (is(&switches.armed), is(&switches.commissioned)) {
                (true, _) => AWAY_FROM_FORCE,
                (false, true) => AWAY_FROM_COMMISSIONING,
                (false, false) => AWAY,
            };
            !is(&switches.host_gone) && heard.is_some_and(|heard| heard.elapsed() < away)
        };
        let in_real_time = pace == Pace::RealTime || !there();
        loop {
            if is(&switches.ended) {
                return;
            }
            if waiting.len() < LINK_BYTES {
                waiting.extend(came(plug));
            }
            let told_ahead = u64::from(tick).saturating_sub(switches.records.load(Ordering::Relaxed) * RECORD_TICKS);
            let waits = match pace {
                Pace::ByHost(most) if !in_real_time => waiting.is_empty() && since_heard >= most && there(),
                _ => due.elapsed() < TICK,
            };
            if !waits && told_ahead < AHEAD_TICKS {
                break;
            }
            std::thread::sleep(Duration::from_micros(200));
        }
        due = if in_real_time && due.elapsed() < 20 * TICK { due + TICK } else { Instant::now() };
        since_heard += 1;
        let bytes: Vec<u8> = waiting.drain(..waiting.len().min(LINK_BYTES)).collect();
        if !bytes.is_empty() {
            (heard, since_heard) = (Some(Instant::now()), 0);
            switches.host_gone.store(false, Ordering::Relaxed);
            switches.heard_tick.store(tick.into(), Ordering::Relaxed);
        }
        packets_read = 1 + usize::from(!bytes.is_empty());
        let mut packets = Vec::new();
        for piece in [&bytes[..], &[]].into_iter().skip(usize::from(bytes.is_empty())) {
            packets.extend(&words);
            packets.push(piece.len() as u8 | counted);
            packets.extend(piece);
        }
        if input.write_all(&packets).is_err() {
            return;
        }
    }
}

/// Levels of the pins after the last tick. The board writes them before each packet that it reads;
/// waits for those of the last `packets`.
fn levels(pins: &mut File, packets: usize) -> std::io::Result<Outputs> {
    let mut bytes = [0; 7];
    (0..packets).try_for_each(|_| pins.read_exact(&mut bytes))?;
    let [enabled, codes @ ..] = bytes;
    let codes: &[[u8; 2]; 3] = bytemuck::cast_ref(&codes);
    Ok(Outputs { enabled: enabled != 0, codes: codes.map(|code| DacCode(i16::from_le_bytes(code))) })
}

/// Bytes from the host that have arrived.
fn came(plug: &Mutex<Option<PseudoTerminal>>) -> Vec<u8> {
    held(plug).as_mut().and_then(|plug| plug.take().ok()).unwrap_or_default()
}
