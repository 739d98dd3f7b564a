//! A recording of `palpate live` is repeated bit for bit; a changed trace is detected; a file that
//! is not a trace is refused with an error message.

use palpate::Vector3;
use palpate::haptic::mode::Mode;
use palpate_loop::live::replay::replay;
use palpate_loop::live::trace::{Trace, TraceError, VERSION};
use palpate_loop::live::{Choice, Exercise, Holding, Inside, Live, Nodule};

const UP: f64 = 5e-3;

/// Moves for some ticks towards a point below the block's top [m] and returns the force at the end
/// [N].
fn to(live: &mut Live, x_m: f64, depth_m: f64, ticks: u32) -> f32 {
    let target_m = Vector3::new(x_m, 0.0, -depth_m);
    (0..ticks).map(|_| live.tick(target_m, true).telemetry.applied_n.norm()).last().unwrap_or_default()
}

fn small() -> Choice {
    Choice { nodes: Some(130), ..Choice::preset("block") }
}

/// Records a press, a slide, a press in stiffer tissue, and a host that falls silent.
fn recorded(holding: &Holding) -> (Vec<u8>, [f32; 2]) {
    let mut live = Live::new(&small(), holding).unwrap();
    live.record().unwrap();
    to(&mut live, 0.0, -UP, 700);
    let soft_n = to(&mut live, 0.0, 3e-3, 400);
    let stiffer = Choice { youngs_modulus_pa: Some(7000.0), ..small() };
    live.choose(&stiffer, holding).unwrap();
    let unchanged_n = to(&mut live, 0.0, 3e-3, 200);
    assert!(live.waits() && (unchanged_n / soft_n - 1.0).abs() < 0.05, "stiffer under the probe: {soft_n} N, {unchanged_n} N");
    to(&mut live, 3e-3, -UP, 400);
    assert!(!live.waits());
    let stiff_n = to(&mut live, 0.0, 3e-3, 400);
    for _ in 0..300 {
        live.tick(Vector3::new(0.0, 0.0, -3e-3), false);
    }
    assert_ne!(live.mode(), Mode::Active, "nobody is there");
    (live.finish().unwrap(), [soft_n, stiff_n])
}

#[test]
fn a_recording_repeats_bit_for_bit_with_pointer_and_with_a_hand_on_a_device() {
    let held = Holding { device: Some("touch".into()), hand: "H2".into(), delay_ticks: Some(2) };
    for holding in [Holding::default(), held] {
        let (bytes, [soft_n, stiff_n]) = recorded(&holding);
        assert!(soft_n > 0.05 && stiff_n / soft_n > 1.6, "{holding:?}: {soft_n} N, {stiff_n} N");
        let trace = Trace::read(&bytes).unwrap();
        let again = replay(&trace).unwrap();
        assert_eq!(again.differs, None, "{holding:?}");
        assert_eq!(again.telemetry.len(), trace.ticks as usize);
        let strongest_n = again.telemetry.iter().map(|t| t.applied_n.norm()).fold(0.0, f32::max);
        assert!(strongest_n >= stiff_n);
    }
}

#[test]
fn a_trace_that_was_changed_is_found() {
    let (bytes, _) = recorded(&Holding::default());
    let at = bytes.len() / 2;
    let changed = |n: usize, to: u8| {
        let mut changed = bytes.clone();
        changed[n] = to;
        Trace::read(&changed).map(|_| ())
    };
    assert_eq!(changed(at, bytes[at] ^ 1), Err(TraceError::Damaged));
    assert_eq!(changed(8, 7), Err(TraceError::Version(7)));
    assert_eq!(changed(0, b'Q'), Err(TraceError::NotATrace));
    assert_eq!(Trace::read(&bytes[..bytes.len() - 1]).map(|_| ()), Err(TraceError::Cut));
    assert_eq!(Trace::read(&bytes[..at]).map(|_| ()), Err(TraceError::Cut));
    assert!(TraceError::Version(7).to_string().contains(&VERSION.to_string()));
}

#[test]
fn another_way_of_the_probe_gives_another_force() {
    let (bytes, _) = recorded(&Holding::default());
    let mut trace = Trace::read(&bytes).unwrap();
    let rows = trace.pieces.iter_mut().find_map(|p| match p {
        palpate_loop::live::trace::Piece::Rows(rows) if rows.iter().any(|r| r.applied_n.norm() > 0.05) => Some(rows),
        _ => None,
    });
    let row = rows.unwrap().last_mut().unwrap();
    row.position_m.z -= 1e-5;
    assert!(replay(&trace).unwrap().differs.is_some(), "a replay that sees no difference proves nothing");
}

#[test]
fn a_nodule_is_felt_where_it_is() {
    let nodule = Nodule { place_m: [0.008, 0.0], depth_m: 9e-3, radius_m: 6e-3, ratio: 10.0 };
    let mut live =
        Live::new(&Choice { inside: Inside::Nodule(nodule), nodes: Some(410), ..small() }, &Holding::default()).unwrap();
    let mut force_n = |x_m: f64| {
        to(&mut live, x_m, -UP, 800);
        to(&mut live, x_m, 4e-3, 600)
    };
    let (over_n, beside_n) = (force_n(0.008), force_n(-0.012));
    assert!(over_n > 1.1 * beside_n, "{over_n} N over it, {beside_n} N beside");
    assert!(Exercise { hidden: nodule }.judge([0.009, 0.0], over_n.into(), 15.0).score > 0.9);
}

#[test]
fn what_does_not_fit_is_refused_and_the_loop_goes_on() {
    let mut live = Live::new(&small(), &Holding::default()).unwrap();
    live.record().unwrap();
    to(&mut live, 0.0, -UP, 700);
    let text = "name = \"x\"\n[tissue]\nblock_m = [0.08, 0.08]\n".to_owned();
    let broken = Choice { text, ..Choice::preset("x.toml") };
    let unknown = Holding { device: Some("teapot".into()), ..Holding::default() };
    let zero = Choice { youngs_modulus_pa: Some(0.0), ..small() };
    for (choice, holding, says) in
        [(&broken, Holding::default(), "x.toml"), (&small(), unknown, "teapot"), (&zero, Holding::default(), "youngs_modulus_pa")]
    {
        let said = live.choose(choice, &holding).unwrap_err().to_string();
        assert!(said.contains(says) && !said.contains('\n'), "{said}");
    }
    assert_eq!(live.recorded(), Some(700), "what was refused ended the recording");
    live.tick(Vector3::new(f64::NAN, 0.0, 0.0), true);
    assert!(to(&mut live, 0.0, 3e-3, 400) > 0.05, "it still answers");
    let ended = live.choose(&Choice::preset("block"), &Holding::default()).unwrap().unwrap();
    assert_eq!(Trace::read(&ended).unwrap().ticks, 1101, "another tissue ends a recording, and hands it over");
}
