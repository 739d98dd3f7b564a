//! Mutated patches with repaired checksums, a hundred thousand in the long form, go through the
//! code that opens an upload on the board. Each is refused with a reason, or is pressed without
//! harm. The mutations change words and bytes without knowledge of the file's fields.

use palpate::haptic::cycle::{Command, Renderer, Settings};
use palpate::haptic::device::{HapticDevice, Sensed, SensorStatus};
use palpate::haptic::mode::Mode;
use palpate::{Output, PatchFile, Probe, ProbePose, ProbeShape, Terms, Vector3};
use palpate_controller::controller::{Arming, Controller};
use palpate_controller::force_out::ActuatorCommand;
use palpate_controller::link::frame::FRAME_BYTES;
use palpate_controller::link::{Inbox, Receiver, Refusal, ToBoard, Upload, encode, inbox::Reply};
use palpate_controller::patch::{Budget, Memory, Patch};
use palpate_controller::port::Port;
use palpate_controller::script::{self, LEAD_TICKS};
use palpate_tests::packed;
use palpate_tests::share::long;
use palpate_tissue::budget::{CostModel, Counts};

fn mutants() -> usize {
    if long() { 100_000 } else { 20_000 }
}

/// Length of magic, version and checksum [bytes]. Mutations leave them alone, so that the rest is
/// read.
const CHECKED_FROM: usize = 16;
/// Number of ticks for which an accepted mutant is pressed. Of every `ONE_IN` mutants, the whole
/// controller presses one as well.
const PRESSED_TICKS: usize = 24;
const ONE_IN: usize = 100;
/// Largest force of a patch, whatever its limits are [N].
const MOST_N: f32 = 12.0;

/// A random number generator: xorshift (Marsaglia 2003).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        self.0
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() >> 16) as usize % end.max(1)
    }
}

/// CRC-32 (IEEE) by table, to repair the checksum.
fn crc(bytes: &[u8], table: &[u32; 256]) -> u32 {
    !bytes.iter().fold(!0, |sum, byte| table[usize::from(sum as u8 ^ byte)] ^ (sum >> 8))
}

fn table() -> [u32; 256] {
    std::array::from_fn(|n| (0..8).fold(n as u32, |sum, _| if sum & 1 == 1 { 0xEDB8_8320 ^ (sum >> 1) } else { sum >> 1 }))
}

const EXTREME: [f32; 14] = [
    0.0,
    -0.0,
    1.0,
    -1.0,
    f32::NAN,
    f32::INFINITY,
    f32::NEG_INFINITY,
    f32::MAX,
    f32::MIN,
    f32::MIN_POSITIVE,
    1e-45,
    1e-20,
    1e20,
    1e9,
];

/// Makes one to three changes to a patch file. `header` is the position at which its arrays begin.
fn mutate(bytes: &mut Vec<u8>, header: usize, random: &mut Random) {
    for _ in 0..=random.below(3) {
        // half of the mutations change the header, where a word has the largest effect
        let end = if random.below(2) == 0 { header } else { bytes.len() };
        let at = CHECKED_FROM + random.below(end.saturating_sub(CHECKED_FROM + 4)) / 4 * 4;
        let Some(word) = bytes.get(at..at + 4).map(|word| u32::from_le_bytes(word.try_into().unwrap())) else { continue };
        let real = f32::from_bits(word);
        let changed = match random.below(10) {
            0 => word ^ 1 << random.below(32),
            1 => random.next() as u32,
            2 => EXTREME[random.below(EXTREME.len())].to_bits(),
            3 => (real * [0.0, 0.5, 0.9, 0.99, 1.01, 1.1, 2.0, 10.0, -1.0, 1e3][random.below(10)]).to_bits(),
            4 => word.wrapping_add([1, 2, u32::MAX, 0x1_0000, 1_000][random.below(5)]),
            5 => word.rotate_left(16),
            6 => word & 0xFFFF_0000 | random.below(700) as u32,
            7 => {
                // two words are swapped
                let other = CHECKED_FROM + random.below(bytes.len() - CHECKED_FROM - 4) / 4 * 4;
                let there: [u8; 4] = bytes[other..other + 4].try_into().unwrap();
                bytes[other..other + 4].copy_from_slice(&word.to_le_bytes());
                u32::from_le_bytes(there)
            }
            8 => {
                // a section becomes shorter or longer
                match random.below(3) {
                    0 => bytes.truncate(bytes.len() - random.below(64).min(bytes.len() - at - 4)),
                    1 => bytes.extend((0..random.below(64)).map(|_| random.next() as u8)),
                    _ => drop(bytes.splice(at..at, [0; 4])),
                }
                continue;
            }
            _ => {
                // a run of bytes is copied to another place
                let length = random.below(48).min(bytes.len() - at);
                let to = CHECKED_FROM + random.below(bytes.len() - CHECKED_FROM - length);
                bytes.copy_within(at..at + length, to);
                continue;
            }
        };
        bytes[at..at + 4].copy_from_slice(&changed.to_le_bytes());
    }
}

/// Results of all mutants.
#[derive(Debug, Default)]
struct Seen {
    refused: std::collections::BTreeMap<String, usize>,
    pressed: usize,
    faulted: usize,
    by_controller: usize,
    costliest_share: f64,
}

/// Presses an accepted mutant from outside its site to twice its depth limit and sideways, faster
/// than any hand could.
fn press(patch: &mut Patch<'_>, depth_limit_m: f32) -> bool {
    let mut faulted = false;
    for tick in 0..PRESSED_TICKS {
        let share = tick as f32 / PRESSED_TICKS as f32;
        let tip_m = Vector3::new(4e-3 * share, -2e-3 * share, 1e-3 - 3.0 * depth_limit_m * share);
        let output: Output = patch.render(ProbePose { tip_m });
        let force_n = output.force_n;
        assert!(force_n.iter().all(|axis| axis.is_finite()) && force_n.norm() <= MOST_N * 1.000_1, "{output:?}");
        assert!(output.depth_m.is_finite() && output.normal.iter().chain(&output.point_m).all(|c| c.is_finite()), "{output:?}");
        assert!(!(faulted && output.fault.is_none()), "a fault is latched");
        faulted |= output.fault.is_some();
        assert!(!faulted || force_n == Vector3::zeros(), "{output:?}");
    }
    faulted
}

/// Runs the whole controller under the scripted hand: the actuators receive no more than the loop's
/// limit, and nothing after a fault.
fn press_by_controller(mut patch: Patch<'_>) {
    let mut controller = Controller::build(&Settings::safe(&Port::DESKTOP.limits()), Port::DESKTOP, Arming::ByItself).unwrap();
    for tick in 0..LEAD_TICKS + 200 {
        let record = controller.tick(&mut patch, script::sensed(tick, LEAD_TICKS), Command::HEARD, true);
        assert!(controller.sound(&record));
        assert!(record.applied_n.norm() <= controller.limits().max_force_n * 1.000_1);
        assert!(record.mode != Mode::Fault || controller.drive() == ActuatorCommand::Off);
    }
}

/// A shipped patch, with another probe shape if one is given.
fn patch_of(name: &str, shape: Option<ProbeShape>) -> Vec<u8> {
    let Some(shape) = shape else { return std::fs::read(packed::shipped(name)).unwrap() };
    let file = PatchFile::open(packed::on_words(&packed::shipped(name))).unwrap();
    let probe = Probe { shape, ..file.params.probe };
    let mut bytes = Vec::new();
    PatchFile { params: palpate::Params { probe, ..file.params }, ..file }.write(|part| bytes.extend_from_slice(part));
    bytes
}

fn run(name: &str, shape: Option<ProbeShape>, mutants: usize, seed: u64) -> Seen {
    let original = patch_of(name, shape);
    let nodes = PatchFile::open(packed::on_words(&packed::shipped(name))).unwrap().model.nodes;
    // the first array begins with the rest position of the first node
    let first = bytemuck::bytes_of(&nodes[0]);
    let header = original.windows(first.len()).position(|window| window == first).unwrap();
    let (mut random, mut seen, table) = (Random(seed), Seen::default(), table());
    let (mut memory, mut upload) = (Box::new(Memory::RESERVED), Box::new(Upload::RESERVED));
    let machine = CostModel::named("m7-480").unwrap();
    for n in 0..mutants {
        let mut bytes = original.clone();
        mutate(&mut bytes, header, &mut random);
        let sum = crc(&bytes[CHECKED_FROM..], &table).to_le_bytes();
        bytes[12..16].copy_from_slice(&sum);
        upload.begin(bytes.len() as u32).unwrap();
        for (piece, at) in bytes.chunks(192).zip((0..).step_by(192)) {
            upload.part(at, piece).unwrap();
        }
        let whole = upload.whole().unwrap();
        match Patch::open_within(&Budget::M7_480, whole, &mut memory, None, &mut || {}) {
            Err(error) => *seen.refused.entry(format!("{:?}", Refusal::from(error))).or_default() += 1,
            Ok(mut patch) => {
                // the cost is computed from the host's figures, independently of the board's own
                let file = PatchFile::open(whole).unwrap();
                assert_eq!(file.params.tick_s, 1e-3);
                let touched =
                    palpate_tissue::budget::triangles_in_reach(&file.model, file.site_m.into(), file.params.probe.reach_m());
                let Terms { relative_mass, smooth_mass, .. } = file.params.terms;
                let terms = Terms { relative_mass, smooth_mass, ..Terms::ALL };
                let cost = machine.cost_of(
                    &Counts::of(&file.model, touched),
                    &palpate::Params { terms, ..file.params },
                    file.params.substeps,
                );
                let share = cost.units / (cost.budget / machine.load);
                assert!(share <= 0.75, "{share} of a tick");
                seen.costliest_share = seen.costliest_share.max(share);
                seen.pressed += 1;
                seen.faulted += usize::from(press(&mut patch, file.model.depth_limit_m));
                if n % ONE_IN == 0 {
                    let patch = Patch::open_within(&Budget::M7_480, whole, &mut memory, None, &mut || {}).unwrap();
                    press_by_controller(patch);
                    seen.by_controller += 1;
                }
            }
        }
    }
    println!("{name} {shape:?}: {seen:?}");
    seen
}

#[test]
fn mutants_are_refused_or_harmless() {
    let along = Vector3::x();
    let capsule = Some(ProbeShape::Capsule { length_m: 0.01, along });
    let ellipsoid = Some(ProbeShape::Ellipsoid { semi_axes_m: [0.012, 0.006], along });
    let runs = [
        ("block-m4f-168.patch", None, 3),
        ("block-m4f-168.patch", capsule, 1),
        ("liver-m4f-168.patch", None, 4),
        ("block-m7-480.patch", None, 1),
        ("nodule-m7-480.patch", ellipsoid, 1),
    ];
    let seen: Vec<Seen> = std::thread::scope(|scope| {
        let seed = 0x9E37_79B9_7F4A_7C15;
        let runs = runs.map(|(name, shape, tenths)| scope.spawn(move || run(name, shape, mutants() / 10 * tenths, seed)));
        runs.into_iter().map(|run| run.join().unwrap()).collect()
    });
    let pressed: usize = seen.iter().map(|seen| seen.pressed).sum();
    let refused: usize = seen.iter().flat_map(|seen| seen.refused.values()).sum();
    assert_eq!(pressed + refused, mutants());
    assert!(pressed > mutants() / 100 && refused > mutants() / 4, "{pressed} pressed and {refused} refused prove little");
    assert!(seen.iter().all(|seen| seen.by_controller > 0));
}

/// Changes a field that is found by its value: the only word in the header with the value `from`.
fn with_field(bytes: &[u8], from: f32, to: f32) -> Vec<u8> {
    let mut changed = bytes.to_vec();
    let at = bytes[..256].windows(4).position(|word| word == from.to_le_bytes()).expect("a field of this value");
    changed[at..at + 4].copy_from_slice(&to.to_le_bytes());
    let sum = crc(&changed[CHECKED_FROM..], &table()).to_le_bytes();
    changed[12..16].copy_from_slice(&sum);
    changed
}

/// Uploads a patch frame by frame and returns the link's result.
fn upload_by_frames(bytes: &[u8], memory: &mut Memory) -> Result<usize, Refusal> {
    let mut controller = Controller::build(&Settings::safe(&Port::DESKTOP.limits()), Port::DESKTOP, Arming::OnRequest).unwrap();
    for sequence in 0..9 {
        let sensed = Sensed { position_m: Vector3::zeros(), sequence, status: SensorStatus::Good };
        controller.tick(&mut palpate_controller::patch::PatchSlot(None), sensed, Command::HEARD, true);
    }
    assert_eq!(controller.mode(), Mode::Idle);
    let (mut receiver, mut inbox, mut upload) = (Receiver::NEW, Inbox::default(), Box::new(Upload::RESERVED));
    upload.begin(bytes.len() as u32)?;
    let parts = bytes.chunks(192).zip((0..).step_by(192)).map(|(bytes, at)| ToBoard::PatchPart { at, bytes });
    for (sequence, message) in parts.chain([ToBoard::PatchEnd]).enumerate() {
        let mut out = [0; FRAME_BYTES];
        for byte in encode(sequence as u16, &message, &mut out).unwrap() {
            let Some(message) = receiver.push::<ToBoard<'_>>(*byte) else { continue };
            if let Reply::Refused(refusal) = inbox.take(&message.unwrap(), &mut controller, Some(&mut upload)) {
                return Err(refusal);
            }
        }
    }
    let patch = Patch::open_within(&Budget::M7_480, upload.whole()?, memory, None, &mut || {})?;
    Ok(patch.model().nodes.len())
}

#[test]
fn another_tick_more_substeps_and_lighter_masses_are_refused_with_their_reason() {
    let original = std::fs::read(packed::shipped("block-m4f-168.patch")).unwrap();
    let mut memory = Box::new(Memory::RESERVED);
    assert_eq!(upload_by_frames(&original, &mut memory), Ok(56));
    // the field for stable_dt_s is raised too, so that the file claims to be stable
    let vouched = with_field(
        &original,
        PatchFile::open(packed::on_words(&packed::shipped("block-m4f-168.patch"))).unwrap().stable_dt_s,
        1.0,
    );
    assert_eq!(upload_by_frames(&vouched, &mut memory), Ok(56));
    // soft tissue needs no more mass than it has
    let stiff = with_field(&vouched, 3500.0, 35_000.0);
    assert_eq!(upload_by_frames(&stiff, &mut memory), Ok(56));
    assert_eq!(upload_by_frames(&with_field(&vouched, 1e-3, 1e-2), &mut memory), Err(Refusal::PatchStep), "ticks of 10 ms");
    assert_eq!(upload_by_frames(&with_field(&stiff, 5.0, 0.5), &mut memory), Err(Refusal::PatchStep), "a tenth of the floor");
    assert_eq!(
        upload_by_frames(&with_field(&vouched, 8e-3, 0.05), &mut memory),
        Ok(56),
        "a probe that touches all triangles but one fits the M7; all of them have no outward side"
    );
    assert_eq!(upload_by_frames(&with_field(&vouched, 6e-3, 1.0), &mut memory), Err(Refusal::PatchSite), "a metre deep");
    let many = {
        let file = PatchFile::open(packed::on_words(&packed::shipped("block-m4f-168.patch"))).unwrap();
        let params = palpate::Params { substeps: 1_000, ..file.params };
        let mut bytes = Vec::new();
        PatchFile { params, ..file }.write(|part| bytes.extend_from_slice(part));
        bytes
    };
    assert_eq!(upload_by_frames(&many, &mut memory), Err(Refusal::PatchCost), "a thousand substeps");
    let board = Budget::M4F_168;
    let large = packed::on_words(&packed::shipped("block-m7-480.patch"));
    assert_eq!(
        Patch::open_within(&board, large, &mut memory, None, &mut || {}).map(|_| ()).map_err(Refusal::from),
        Err(Refusal::PatchCost)
    );
}
