use eframe::egui::{Event, Modifiers, RawInput};
use palpate::ClampFlags;
use palpate::haptic::mode::Mode;

use super::super::patches::Given;
use super::super::twin::{Answer, Apart};
use super::*;
use crate::message::Body;

/// A window without a file: every state is given by the test.
struct Screen {
    ctx: egui::Context,
    follow: Follow,
    texts: Vec<String>,
    _folder: tempfile::TempDir,
}

impl Screen {
    fn new() -> Self {
        let (folder, ctx) = (tempfile::tempdir().unwrap(), egui::Context::default());
        let path = folder.path().join("none.csv");
        let mut follow = Follow::new(&ctx, Feed::start(&path, Given::Nothing), "out/felt.csv".into(), folder.path().into());
        // the thread must not send messages in between
        follow.feed = Feed::start(&path, Given::Nothing).silenced();
        Self { ctx, follow, texts: Vec::new(), _folder: folder }
    }

    fn frame(&mut self, events: Vec<Event>) {
        let input =
            RawInput { screen_rect: Some(Rect::from_min_size(Pos2::ZERO, vec2(1280.0, 720.0))), events, ..RawInput::default() };
        let follow = &mut self.follow;
        let mut drawn = self.ctx.run_ui(input, |ui| follow.show(ui));
        drawn.textures_delta.clear();
        self.texts = drawn.shapes.iter().filter_map(|clipped| text_of(&clipped.shape)).collect();
        assert!(follow.panel_fits, "{:?}", self.texts);
    }

    /// Draws a state as if it had arrived just now.
    fn given(&mut self, state: State) {
        self.follow.heard_s = self.follow.now_s();
        self.follow.take(Heard::State(Box::new(state)));
        (0..2).for_each(|_| self.frame(Vec::new()));
    }

    fn shows(&self, text: &str) -> bool {
        self.texts.iter().any(|shown| shown.contains(text))
    }
}

fn text_of(shape: &egui::Shape) -> Option<String> {
    match shape {
        egui::Shape::Text(text) => Some(text.galley.text().to_owned()),
        egui::Shape::Vec(all) => Some(all.iter().filter_map(text_of).collect::<Vec<_>>().join("\n")).filter(|t| !t.is_empty()),
        _ => None,
    }
}

fn row() -> Row {
    Row {
        tick: 400,
        mode: Mode::Active as u8,
        tip_m: [0.001, 0.0, -0.0023],
        depth_m: 0.0023,
        model_n: [0.0, 0.0, 0.2],
        applied_n: [0.0, 0.0, 0.123],
        outputs_on: true,
        limiters: ClampFlags::GAIN.bits(),
        patch_checksum: 0x0bad_cafe,
        youngs_modulus_pa: 3500.0,
        ..Row::default()
    }
}

fn live() -> State {
    let answer = Answer { force_n: Some([0.0, 0.0, 0.198]), differs_n: Ok(0.002) };
    let frame = Frame { force_n: [0.0, 0.0, 0.123], ..Frame::default() };
    State { phase: Phase::Live, row: Some(row()), answer: Some(answer), frame: Some(frame), records: [20, 1], ..State::default() }
}

#[test]
fn the_boards_figures_are_named_as_its_own_and_beside_them_this_machines() {
    let mut screen = Screen::new();
    screen.follow.take(Heard::Body(Box::<Body>::default(), "block-m4f-168".into()));
    screen.given(live());
    for says in [
        "Measured by the board",
        "Nothing is sent to it",
        "0.123 N",
        "0.200 N",
        "2.30 mm",
        "1.00, 0.00, -2.30 mm",
        "active: the force is felt",
        "scaled: ramp-in, relief, or stiffer than the device renders",
        "0badcafe, 3500 Pa",
        "not timed",
        "Computed on this machine",
        "patch block-m4f-168",
        "its force at the board's tip: 0.198 N",
        "differs by 2.0 mN, 1.0 %",
        "20 records, 1 lost",
    ] {
        assert!(screen.shows(says), "\"{says}\" is not in {:?}", screen.texts);
    }
    assert_eq!(screen.follow.drawn().force_n, [0.0, 0.0, 0.123]);
}

#[test]
fn a_file_that_stops_has_no_force_on_the_screen() {
    let mut screen = Screen::new();
    screen.given(live());
    assert!(screen.shows("0.123 N"));
    screen.given(State { phase: Phase::Silent, silent_s: 12.0, frame: None, ..live() });
    assert!(screen.shows("No record for 12 s: no force is shown."), "{:?}", screen.texts);
    for gone in ["0.123 N", "0.200 N", "0.198 N", "active", "2.30 mm"] {
        assert!(!screen.shows(gone), "{gone} is in {:?}", screen.texts);
    }
    assert_eq!((screen.follow.drawn().force_n, screen.follow.numbers()["force_n"].is_null()), ([0.0; 3], true));
    // a thread that is too busy to read the file has the same effect
    screen.given(live());
    screen.follow.heard_s -= 2.0 * SILENCE_S;
    screen.frame(Vec::new());
    assert!(screen.shows("No record for 1.5 s") && !screen.shows("0.123 N"), "{:?}", screen.texts);
}

#[test]
fn every_absence_is_said_over_the_picture() {
    let mut screen = Screen::new();
    screen.given(State::default());
    assert!(screen.shows("No file yet") && screen.shows("palpate board arm --stream out/felt.csv"), "{:?}", screen.texts);
    screen.given(State { phase: Phase::Begun, ..State::default() });
    assert!(screen.shows("No record yet"), "{:?}", screen.texts);
    screen.given(State { phase: Phase::Bad("felt.csv:1: no record of a board".into()), ..State::default() });
    assert!(screen.shows("felt.csv:1: no record of a board"), "{:?}", screen.texts);
}

#[test]
fn a_fault_and_a_comparison_that_cannot_be_are_in_words_and_fit() {
    let mut screen = Screen::new();
    screen.follow.take(Heard::Body(Box::<Body>::default(), "a patch with a long name of its own".into()));
    let faulty = Row { mode: Mode::Fault as u8, fault: 8, applied_n: [0.0; 3], ..row() };
    let answer = Answer { force_n: None, differs_n: Err(Apart::Rests) };
    screen.given(State { row: Some(faulty), answer: Some(answer), ..live() });
    for says in ["fault 8: the probe moved too fast", "fault: no force", "not compared: the board's patch rests"] {
        assert!(screen.shows(says), "{:?}", screen.texts);
    }
    screen.follow.take(Heard::NoPatch("it cannot run".into()));
    screen.given(State { answer: None, ..live() });
    assert!(screen.shows("no patch: it cannot run") && screen.shows("0.123 N"), "{:?}", screen.texts);
}

#[test]
fn keys_change_the_view_alone() {
    let mut screen = Screen::new();
    screen.given(live());
    let down = |key| Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers: Modifiers::NONE };
    screen.frame([Key::V, Key::S, Key::E, Key::J, Key::T].map(down).to_vec());
    let shown = &screen.follow.shown;
    assert!(shown.cut && shown.springs && shown.rim && shown.dark && shown.colour == Colour::J, "{shown:?}");
}
