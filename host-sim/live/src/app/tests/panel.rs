//! Panel and picture: the sentences that are shown and for how long, and the contents of a cut.

use palpate_loop::live::Inside;

use super::*;

#[test]
fn dropped_time_is_told_and_then_forgotten() {
    let folder = tempfile::tempdir().unwrap();
    let mut screen = Screen::block(folder.path());
    screen.frames(3);
    let before = screen.app.said.0.clone();
    assert!(screen.shows(&before) && !screen.shows("dropped"), "{:?}", screen.texts);
    // the machine sleeps for a second
    screen.now_s.set(screen.now_s.get() + 1.0);
    screen.frames(2);
    let told = "ms of the tissue's time were dropped";
    assert!(screen.shows(told) && screen.shows("ms dropped") && !screen.shows(&before), "{:?}", screen.texts);
    screen.frames(150);
    assert!(screen.shows(told), "forgotten after 3 s: {:?}", screen.texts);
    screen.frames(150);
    assert!(screen.shows(&before) && !screen.shows("dropped"), "{:?}", screen.texts);
    assert!(screen.app.numbers()["dropped"].as_u64() > Some(900), "scripts still read it");
}

#[test]
fn the_time_that_a_patch_took_to_prepare_was_not_dropped() {
    let choice = Choice { nodes: Some(130), ..Choice::preset("block") };
    let mut physics = Physics::new(&choice, &Holding::default(), 0.0).unwrap();
    let mut ticks = Vec::new();
    for now_s in [5.0, 5.0205] {
        physics.advance(&|| now_s, &mut |_| {});
        physics.take(Request::Aim(None), &|| now_s, &mut |answer| {
            if let Answer::Frame(frame) = answer {
                ticks.push((frame.ticks, frame.dropped));
            }
        });
    }
    assert_eq!(ticks, [(0, 0), (20, 0)]);
}

#[test]
fn the_panel_knows_the_nodule_of_a_preset() {
    let folder = tempfile::tempdir().unwrap();
    let mut screen = Screen::of(Choice::preset("nodule"), folder.path());
    screen.frames(3);
    let pressed_n = |screen: &mut Screen| {
        screen.until_active();
        screen.over_the_site();
        screen.button(true);
        screen.frames(80);
        let force_n = screen.force_n();
        screen.button(false);
        screen.frames(30);
        force_n
    };
    assert!(screen.shows("the scene's own nodule"), "{:?}", screen.texts);
    let own = screen.app.controls.nodules().to_vec();
    assert!(own.len() == 1 && own[0].depth_m == 0.012 && own[0].ratio == 10.0, "{own:?}");
    let with_n = pressed_n(&mut screen);
    // the nodule is removed, then put back
    screen.key(Key::O, Modifiers::NONE);
    screen.frames(3);
    assert!(screen.app.controls.nodules().is_empty() && screen.shows("nodule inside"), "{:?}", screen.texts);
    let without_n = pressed_n(&mut screen);
    assert!(with_n > 1.02 * without_n, "{with_n} N with the nodule, {without_n} N without");
    screen.key(Key::O, Modifiers::NONE);
    screen.frames(3);
    assert_eq!((screen.app.controls.inside, screen.app.controls.nodules()), (Inside::Own, own.as_slice()));
    assert!(screen.app.panel_fits && (pressed_n(&mut screen) - with_n).abs() < 1e-3 * with_n);
    // a search uses the plain block, and shows no nodule
    screen.key(Key::N, Modifiers::NONE);
    screen.frames(3);
    assert!(screen.app.controls.nodules().is_empty() && screen.shows("hidden in the plain block"), "{:?}", screen.texts);
    assert_eq!(screen.app.controls.choice.scene, "block");
}

#[test]
fn every_control_of_the_panel_says_what_it_does() {
    use egui::accesskit::Role;

    let folder = tempfile::tempdir().unwrap();
    let mut screen = Screen::block(folder.path());
    // a screen reader reads the tooltip of a control as its description
    screen.ctx.enable_accesskit();
    let mut tips = std::collections::BTreeMap::new();
    // the controls differ with a device, a nodule, a recording, and a search
    for key in [Key::D, Key::O, Key::R, Key::R, Key::N] {
        screen.key(key, Modifiers::NONE);
        screen.frames(5);
        for (id, node) in &screen.described.as_ref().unwrap().nodes {
            // the number beside a slider has the slider's tooltip
            let reacts = matches!(node.role(), Role::Button | Role::CheckBox | Role::ComboBox | Role::Slider | Role::RadioButton);
            let name = node.label().or(node.value()).unwrap_or_default().to_owned();
            if reacts && !node.is_hidden() {
                tips.insert((format!("{id:?}"), format!("{:?}", node.role()), name), node.description().map(str::to_owned));
            }
        }
    }
    let silent: Vec<_> = tips.iter().filter(|(_, tip)| tip.is_none()).map(|(control, _)| control).collect();
    assert!(silent.is_empty(), "controls without a tooltip: {silent:?}, with: {tips:#?}");
    assert!(tips.values().flatten().all(|tip| tip.ends_with('.') && tip.len() < 110), "{tips:#?}");
    assert!(tips.len() >= 30, "{tips:#?}");
}

#[test]
fn a_cut_draws_what_lies_behind_the_tip_and_the_nodule() {
    let folder = tempfile::tempdir().unwrap();
    let mut screen = Screen::of(Choice::preset("nodule"), folder.path());
    screen.over_the_site();
    screen.button(true);
    screen.frames(80);
    let shapes = |screen: &Screen| screen.texts.iter().filter(|text| *text == "nodule").count();
    // the title of the window contains that name as well
    let before = shapes(&screen);
    screen.key(Key::V, Modifiers::NONE);
    assert!(shapes(&screen) == before + 1 && screen.app.controls.shown.cut, "{:?}", screen.texts);
    screen.key(Key::V, Modifiers::NONE);
    assert_eq!(shapes(&screen), before);
    // the nodule must not be visible while it is searched for
    screen.key(Key::V, Modifiers::NONE);
    screen.key(Key::N, Modifiers::NONE);
    screen.frames(5);
    assert!(!screen.app.controls.shown.cut && screen.app.controls.exercise.is_some());
    screen.key(Key::V, Modifiers::NONE);
    screen.frames(5);
    assert!(screen.app.controls.shown.cut && shapes(&screen) == 0, "{:?}", screen.texts);
}
