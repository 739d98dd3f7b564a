//! The emulated board repeats a recording of `palpate live` to the last bit. A recording that no
//! board can repeat is refused with an error message.

use std::path::{Path, PathBuf};

use palpate::Vector3;
use palpate_board::{EmulatedBoard, live_trace};
use palpate_loop::live::trace::{Piece, Trace};
use palpate_loop::live::{Choice, Holding, Live};
use palpate_tests::emulator::build_firmware;

const UP_M: f64 = 5e-3;

fn to(live: &mut Live, x_m: f64, depth_m: f64, ticks: u32, heard: bool) {
    for _ in 0..ticks {
        live.tick(Vector3::new(x_m, 0.0, -depth_m), heard);
    }
}

fn choice(nodes: usize) -> Choice {
    Choice { nodes: Some(nodes), ..Choice::preset("block") }
}

/// Records a press, a stiffer tissue and a slide.
fn recorded(choice: &Choice, holding: &Holding, stiffer_pa: f64) -> Trace {
    let mut live = Live::new(choice, holding).unwrap();
    live.record().unwrap();
    to(&mut live, 0.0, -UP_M, 700, true);
    to(&mut live, 0.0, 3e-3, 400, true);
    live.choose(&Choice { youngs_modulus_pa: Some(stiffer_pa), ..choice.clone() }, holding).unwrap();
    to(&mut live, 0.0, 3e-3, 100, true);
    to(&mut live, 3e-3, -UP_M, 300, true);
    to(&mut live, 3e-3, 3e-3, 300, true);
    to(&mut live, 0.0, 2e-3, 300, true);
    Trace::read(&live.finish().unwrap()).unwrap()
}

fn image() -> PathBuf {
    build_firmware(Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap(), &[]).unwrap()
}

#[test]
fn pointer_and_hand_are_repeated_to_the_bit() {
    let image = image();
    let held = Holding { device: Some("touch".into()), hand: "H2".into(), delay_ticks: Some(2) };
    for (holding, machine) in [(Holding::default(), EmulatedBoard::M7), (held, EmulatedBoard::M7)] {
        let trace = recorded(&choice(130), &holding, 5000.0);
        let again = live_trace::replay(&trace, Some(&image), machine).unwrap();
        assert_eq!((again.differs, again.telemetry.len()), (None, trace.ticks as usize), "{holding:?}");
        let strongest_n = again.telemetry.iter().map(|t| t.applied_n.norm()).fold(0.0, f32::max);
        println!("{machine:?}: {} ticks, {strongest_n:.3} N at most", trace.ticks);
        assert!(strongest_n > 0.1);
    }
}

#[test]
fn another_reading_parts_board_or_trace() {
    let mut trace = recorded(&choice(130), &Holding::default(), 5000.0);
    for piece in &mut trace.pieces {
        if let Piece::Rows(rows) = piece {
            rows.iter_mut().filter(|r| r.applied_n.norm() > 0.05).take(1).for_each(|r| r.position_m.z -= 1e-5);
        }
    }
    let again = live_trace::replay(&trace, Some(&image()), EmulatedBoard::M7).unwrap();
    assert!(again.differs.is_some(), "a replay that sees no difference proves nothing");
}

#[test]
fn what_no_board_does_is_refused_in_a_sentence() {
    let image = image();
    let pointer = Holding::default();
    let silent = {
        let mut live = Live::new(&choice(130), &pointer).unwrap();
        live.record().unwrap();
        to(&mut live, 0.0, -UP_M, 300, true);
        to(&mut live, 0.0, -UP_M, 10, false);
        Trace::read(&live.finish().unwrap()).unwrap()
    };
    let aslant = {
        let mut live = Live::new(&Choice::preset("organ-liver"), &pointer).unwrap();
        live.record().unwrap();
        to(&mut live, 0.0, -UP_M, 10, true);
        Trace::read(&live.finish().unwrap()).unwrap()
    };
    // no image is given, and the refusal must come before one is built
    let larger = recorded(&choice(1020), &pointer, 5000.0);
    let said = live_trace::replay(&larger, None, EmulatedBoard::M7).unwrap_err().to_string();
    assert!(said.contains("more nodes or triangles than the board holds"), "{said}");
    let too_stiff = recorded(&choice(130), &pointer, 10_500.0);
    let large = recorded(&choice(410), &pointer, 5000.0);
    for (trace, says) in
        [(silent, "nobody was heard"), (too_stiff, "3.00 times"), (large, "costs more than"), (aslant, "along z")]
    {
        let said = live_trace::replay(&trace, Some(&image), EmulatedBoard::M7).unwrap_err().to_string();
        assert!(said.contains(says) && !said.contains('\n'), "{says}: {said}");
    }
}
