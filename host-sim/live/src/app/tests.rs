//! Tests of the whole screen without a display: they send events to the app, and run the physics in
//! the same thread with a clock of its own.

use std::cell::{Cell, RefCell};
use std::path::Path;
use std::rc::Rc;

use eframe::egui::{self, Event, Key, Modifiers, PointerButton, Pos2, RawInput, Rect, pos2, vec2};

use super::*;
use crate::physics::Physics;

mod panel;

/// Positions of the mouse over the site, and over the panel [points].
const MIDDLE: Pos2 = pos2(480.0, 250.0);
const PANEL: Pos2 = pos2(1150.0, 330.0);
/// Duration of a drawn frame [s].
const FRAME_S: f64 = 0.02;

struct Here {
    physics: Physics,
    now_s: Rc<Cell<f64>>,
    answers: Rc<RefCell<Vec<Answer>>>,
}

impl Link for Here {
    fn send(&mut self, request: Request) {
        let (now_s, answers) = (&self.now_s, &self.answers);
        self.physics.take(request, &|| now_s.get(), &mut |a| answers.borrow_mut().push(a));
    }

    fn poll(&mut self) -> Vec<Answer> {
        let (now_s, answers) = (&self.now_s, &self.answers);
        self.physics.advance(&|| now_s.get(), &mut |a| answers.borrow_mut().push(a));
        answers.take()
    }
}

struct Screen {
    ctx: egui::Context,
    app: App,
    now_s: Rc<Cell<f64>>,
    /// Texts drawn in the last frame.
    texts: Vec<String>,
    /// The last frame as described for a screen reader, where that is enabled.
    described: Option<egui::accesskit::TreeUpdate>,
}

impl Screen {
    /// A screen with an active loop and the pointer over the site.
    fn of(choice: Choice, folder: &Path) -> Self {
        let (ctx, now_s) = (egui::Context::default(), Rc::new(Cell::new(0.0)));
        let physics = Physics::new(&choice, &Holding::default(), 0.0).unwrap();
        let answers = Rc::new(RefCell::new(vec![physics.body()]));
        let link = Here { physics, now_s: Rc::clone(&now_s), answers };
        let app = App::new(&ctx, Box::new(link), choice, Holding::default()).into_folder(folder.into());
        let mut screen = Self { ctx, app, now_s, texts: Vec::new(), described: None };
        screen.frame(vec![Event::PointerMoved(MIDDLE)]);
        screen.until_active();
        screen
    }

    fn block(folder: &Path) -> Self {
        Self::of(Choice { nodes: Some(130), ..Choice::preset("block") }, folder)
    }

    fn frame(&mut self, events: Vec<Event>) {
        self.now_s.set(self.now_s.get() + FRAME_S);
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(Pos2::ZERO, vec2(1280.0, 720.0))),
            time: Some(self.now_s.get()),
            events,
            ..RawInput::default()
        };
        let app = &mut self.app;
        let mut drawn = self.ctx.run_ui(input, |ui| app.show(ui));
        // nothing is displayed here, but epaint asserts that the textures were taken
        drawn.textures_delta.clear();
        self.described = drawn.platform_output.accesskit_update.take();
        self.texts = drawn.shapes.iter().filter_map(|clipped| text_of(&clipped.shape)).collect();
    }

    fn shows(&self, text: &str) -> bool {
        self.texts.iter().any(|shown| shown.contains(text))
    }

    fn frames(&mut self, count: usize) {
        (0..count).for_each(|_| self.frame(Vec::new()));
    }

    fn until_active(&mut self) {
        // the force must also be ramped in, since it does not grow under a press
        let active = |app: &App| words::mode(app.frame.mode).starts_with("active") && app.frame.limiters == 0;
        for _ in 0..200 {
            self.frames(1);
            if active(&self.app) {
                return;
            }
        }
        panic!("never active: {}", self.app.numbers());
    }

    fn key(&mut self, key: Key, modifiers: Modifiers) {
        let event = |pressed| Event::Key { key, physical_key: None, pressed, repeat: false, modifiers };
        self.frame(vec![event(true)]);
        self.frame(vec![event(false)]);
    }

    fn button(&mut self, pressed: bool) {
        let pos = self.ctx.input(|i| i.pointer.latest_pos()).unwrap_or(MIDDLE);
        self.frame(vec![Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE }]);
    }

    fn force_n(&self) -> f32 {
        Vector3::from(self.app.frame.force_n).norm()
    }

    /// The pixel of the pointer over the site of the tissue, wherever the picture shows it.
    fn over_the_site(&mut self) -> Pos2 {
        let site_m = Vector3::from(self.app.shape.body.site_m);
        let mut over = MIDDLE;
        for _ in 0..5 {
            self.frame(vec![Event::PointerMoved(over)]);
            // the sizes of the panels are unknown here, but their error cancels in the difference
            let lens = self.app.camera.lens(Rect::from_min_size(Pos2::ZERO, vec2(1008.0, 500.0)));
            let pixel = |place_m: &Vector3<f32>| lens.project(place_m).unwrap().0;
            over += pixel(&site_m) - pixel(&self.app.pointer.place_m());
        }
        let apart_m = (self.app.pointer.place_m() - site_m).norm();
        assert!(apart_m < 1e-3, "{apart_m} m from the site");
        over
    }
}

fn text_of(shape: &egui::Shape) -> Option<String> {
    match shape {
        egui::Shape::Text(text) => Some(text.galley.text().to_owned()),
        egui::Shape::Vec(all) => Some(all.iter().filter_map(text_of).collect::<Vec<_>>().join("\n")).filter(|t| !t.is_empty()),
        _ => None,
    }
}

#[test]
fn nothing_is_wider_than_the_panel() {
    let folder = tempfile::tempdir().unwrap();
    let mut screen = Screen::block(folder.path());
    let fits = |screen: &Screen, when: &str| assert!(screen.app.panel_fits, "{when}: {}", screen.app.numbers());
    fits(&screen, "as it begins");
    for kpa in 0..16 {
        screen.key(Key::CloseBracket, Modifiers::NONE);
        fits(&screen, &format!("stiffened {kpa} times"));
    }
    for key in [Key::V, Key::O, Key::D, Key::R, Key::R, Key::N] {
        screen.key(key, Modifiers::NONE);
        screen.frames(5);
        fits(&screen, &format!("{key:?}"));
    }
    screen.until_active();
    screen.key(Key::Enter, Modifiers::NONE);
    screen.frames(5);
    fits(&screen, "with a score");
    let scene = folder.path().join("a scene with a long name, in a folder.toml");
    std::fs::copy(concat!(env!("CARGO_MANIFEST_DIR"), "/../scenes/block-20kpa.toml"), &scene).unwrap();
    let mut screen = Screen::of(Choice { nodes: Some(130), ..Choice::preset(scene.to_str().unwrap()) }, folder.path());
    screen.frames(3);
    fits(&screen, "a scene file");
    assert_eq!(screen.app.controls.title(), "a scene with a long name, in a folder.toml");
}

#[test]
fn the_same_preset_again_is_as_it_began() {
    let folder = tempfile::tempdir().unwrap();
    let mut screen = Screen::of(Choice::preset("block"), folder.path());
    (0..6).for_each(|_| screen.key(Key::CloseBracket, Modifiers::NONE));
    assert!(screen.app.controls.stiffness_kpa > 10.0);
    screen.key(Key::Num1, Modifiers::NONE);
    screen.frames(3);
    assert!((screen.app.controls.stiffness_kpa - 3.5).abs() < 1e-6, "{}", screen.app.numbers());
    assert_eq!(screen.app.said.0, "block is as it began.");
}

#[test]
fn an_exercise_begins_with_its_own_tissue_and_its_answer_stays() {
    let folder = tempfile::tempdir().unwrap();
    let mut screen = Screen::block(folder.path());
    screen.button(true);
    screen.frames(80);
    assert!(screen.force_n() > 0.05, "{}", screen.app.numbers());
    screen.key(Key::N, Modifiers::NONE);
    screen.button(false);
    screen.frames(30);
    assert_eq!(screen.app.controls.exercise.as_ref().unwrap().peak_n, 0.0, "a press of the tissue before counts");
    screen.until_active();
    screen.key(Key::Enter, Modifiers::NONE);
    let (body, said) = (screen.app.frame.body, screen.app.said.clone());
    screen.frames(60);
    assert!(said.0.contains("score") && screen.app.said == said && screen.app.frame.body == body, "{:?}", screen.app.said);
}

#[test]
fn a_press_right_after_a_nodule_was_hidden_is_felt() {
    let folder = tempfile::tempdir().unwrap();
    let mut screen = Screen::block(folder.path());
    screen.key(Key::N, Modifiers::NONE);
    screen.button(true);
    screen.frames(100);
    assert!(screen.force_n() > 0.08, "{}", screen.app.numbers());
    // and it is let go at once
    screen.button(false);
    screen.frames(15);
    assert_eq!(screen.force_n(), 0.0, "{}", screen.app.numbers());
}

#[test]
fn rings_around_answer_and_nodule_are_drawn_on_tissue_alone() {
    let folder = tempfile::tempdir().unwrap();
    let mut screen = Screen::block(folder.path());
    screen.key(Key::N, Modifiers::NONE);
    screen.until_active();
    screen.key(Key::Enter, Modifiers::NONE);
    screen.frames(3);
    assert!(screen.texts.iter().any(|text| text == "your answer"), "{:?}", screen.texts);
    // cut through the tip, which is behind the answer: the tissue around that is gone
    screen.key(Key::V, Modifiers::NONE);
    screen.frame(vec![Event::PointerMoved(MIDDLE - vec2(0.0, 140.0))]);
    screen.frames(20);
    assert!(screen.texts.iter().all(|text| text != "your answer"), "{:?}", screen.texts);
}

#[test]
fn with_a_modifier_a_key_is_somebody_elses() {
    let folder = tempfile::tempdir().unwrap();
    let mut screen = Screen::block(folder.path());
    for modifiers in [Modifiers::CTRL, Modifiers::ALT, Modifiers::COMMAND] {
        screen.key(Key::N, modifiers);
        assert!(screen.app.controls.exercise.is_none(), "{modifiers:?}");
    }
    screen.key(Key::N, Modifiers::NONE);
    assert!(screen.app.controls.exercise.is_some());
}

#[test]
fn beside_the_picture_or_without_a_pointer_there_is_no_force() {
    let folder = tempfile::tempdir().unwrap();
    let mut screen = Screen::block(folder.path());
    // zoomed in, so that the tissue extends behind the panel as well
    (0..12).for_each(|_| screen.key(Key::Plus, Modifiers::NONE));
    for leaves in [Event::PointerMoved(PANEL), Event::PointerGone] {
        screen.frame(vec![Event::PointerMoved(MIDDLE)]);
        screen.button(true);
        screen.frames(40);
        assert!(screen.force_n() > 0.05, "{}", screen.app.numbers());
        screen.frame(vec![leaves.clone()]);
        screen.frames(15);
        assert_eq!((screen.force_n(), screen.app.frame.depth_m), (0.0, 0.0), "{leaves:?}: {}", screen.app.numbers());
        screen.button(false);
    }
}

#[test]
fn a_recording_is_kept_whatever_ends_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str| std::fs::read(folder.path().join(name));
    let mut screen = Screen::block(folder.path());
    screen.key(Key::R, Modifiers::NONE);
    screen.frames(20);
    screen.key(Key::Num2, Modifiers::NONE);
    screen.frames(3);
    let said = screen.app.said.0.clone();
    assert!(said.starts_with("The recording ended with the change. Wrote") && said.contains("live-1.trace"), "{said}");
    let first = file("live-1.trace").unwrap();

    // another window is closed while it records
    let mut screen = Screen::block(folder.path());
    screen.key(Key::R, Modifiers::NONE);
    screen.frames(40);
    eframe::App::on_exit(&mut screen.app, None);
    assert_eq!(file("live-1.trace").unwrap(), first);
    assert!(palpate_loop::live::trace::Trace::read(&file("live-2.trace").unwrap()).unwrap().ticks > 700);

    // the table of the recording, then the recording opened by its path
    screen.key(Key::X, Modifiers::NONE);
    screen.frames(2);
    assert!(file("live-2.csv").unwrap().starts_with(b"t_s,"), "{:?}", screen.app.said);
    screen.key(Key::F, Modifiers::NONE);
    screen.frames(2);
    screen.frame(vec![Event::Text(folder.path().join("live-1.trace").display().to_string())]);
    assert_eq!(screen.app.path.as_deref(), folder.path().join("live-1.trace").to_str());
    screen.key(Key::Enter, Modifiers::NONE);
    screen.frames(3);
    assert!(screen.app.said.0.contains("every bit the same") && screen.app.path.is_none(), "{:?}", screen.app.said);
    screen.key(Key::F, Modifiers::NONE);
    screen.frames(2);
    screen.key(Key::Escape, Modifiers::NONE);
    screen.frames(2);
    assert_eq!(screen.app.path, None);
}

#[test]
fn a_recording_that_cannot_be_written_is_bad_news() {
    let folder = tempfile::NamedTempFile::new().unwrap();
    let mut screen = Screen::block(folder.path());
    screen.key(Key::R, Modifiers::NONE);
    screen.frames(5);
    screen.key(Key::R, Modifiers::NONE);
    screen.frames(2);
    assert!(screen.app.said.1 && screen.app.said.0.starts_with("Cannot write"), "{:?}", screen.app.said);
}

#[test]
fn a_hold_of_beef_fades_and_a_slide_on_skin_drags() {
    let folder = tempfile::tempdir().unwrap();
    let mut screen = Screen::of(Choice::preset("beef"), folder.path());
    screen.button(true);
    // the tip reaches a depth of 3 mm within 0.25 s after the touch; the force is largest then
    let peak_n = (0..40).map(|_| (screen.frames(1), screen.force_n()).1).fold(0.0, f32::max);
    screen.frames(150);
    let held_n = screen.force_n();
    assert!(peak_n > 0.2 && held_n < 0.4 * peak_n, "{peak_n} N, {held_n} N after 3 s: {}", screen.app.numbers());
    let touch = screen.app.touch.numbers();
    let left = touch["left"].as_f64().unwrap() as f32;
    assert!((left - held_n / peak_n).abs() < 0.05 && touch["since_s"].as_f64() > Some(3.0), "{touch}");
    assert!(screen.shows(&format!("force since touch: {:.0} % of its peak", left * 100.0)), "{:?}", screen.texts);
    screen.button(false);

    assert!(screen.shows("force left in a hold: 72 tests of topside"), "{:?}", screen.texts);

    let mut screen = Screen::of(Choice::preset("abdomen"), folder.path());
    assert!(!screen.shows("dots: measured"), "{:?}", screen.texts);
    let over = screen.over_the_site();
    screen.button(true);
    screen.frames(60);
    let along_n = |screen: &Screen| Vector3::from(screen.app.frame.along_n);
    let from_m = Vector3::from(screen.app.frame.tip_m);
    for n in 1..=20_u8 {
        screen.frame(vec![Event::PointerMoved(over + vec2(f32::from(n) * 0.5, 0.0))]);
    }
    let moved_m = Vector3::from(screen.app.frame.tip_m) - from_m;
    let drag_n = -along_n(&screen).dot(&moved_m.normalize());
    assert!(screen.app.panel_fits && drag_n > 0.3 * screen.force_n(), "{moved_m} m, {drag_n} N: {}", screen.app.numbers());
    assert!(screen.shows("along / into: "), "{:?}", screen.texts);
    screen.button(false);
    screen.frames(30);
    assert_eq!(along_n(&screen), Vector3::zeros(), "{}", screen.app.numbers());
}

#[test]
fn the_contact_map_comes_when_its_colour_is_chosen() {
    let folder = tempfile::tempdir().unwrap();
    let mut screen = Screen::block(folder.path());
    screen.over_the_site();
    screen.button(true);
    screen.frames(80);
    assert!(screen.force_n() > 0.05 && screen.app.frame.map.is_none(), "{}", screen.app.numbers());
    // J colours by volume, and J again by pressure
    (0..2).for_each(|_| screen.key(Key::J, Modifiers::NONE));
    screen.frames(2);
    let map = screen.app.frame.map.clone().unwrap();
    let mean_pa = screen.force_n() / map.area_m2;
    assert!(map.peak_pa > mean_pa && map.peak_pa < 4.0 * mean_pa, "{mean_pa} Pa on average: {}", screen.app.numbers());
    let most_pa = screen.app.shape.pressure_pa(&screen.app.frame).into_iter().fold(0.0, f32::max);
    assert!(most_pa > 0.3 * map.peak_pa && screen.app.panel_fits, "{most_pa} Pa at a node: {}", screen.app.numbers());
    screen.button(false);
    screen.frames(40);
    assert_eq!(screen.app.frame.map.as_ref().map(|map| map.area_m2), Some(0.0), "{}", screen.app.numbers());
    screen.key(Key::J, Modifiers::NONE);
    screen.frames(2);
    assert!(screen.app.frame.map.is_none());
}
