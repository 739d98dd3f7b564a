//! `identify` refuses a file that is no test of a tissue with one line, and writes nothing.

use palpate_tests::palpate_command::{Desk, palpate};

use crate::bad_input_says_what_where_how::refused;

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");
const PHANTOM: &str = include_str!("../../../host-sim/book/src/guide/phantom.csv");
const NAMES: &str = "time_s,depth_mm,force_mN";

/// The phantom's rows of time [s], depth [mm] and force [mN], changed by a function of their index;
/// `None` leaves a row out.
fn changed(names: &str, change: impl Fn(usize, [f64; 3]) -> Option<[f64; 3]>) -> String {
    let rows = PHANTOM.lines().skip_while(|line| *line != NAMES).skip(1).enumerate().filter_map(|(n, line)| {
        let mut cells = line.split(',').map(|cell| cell.parse().unwrap());
        change(n, std::array::from_fn(|_| cells.next().unwrap()))
    });
    let rows = rows.map(|[t, d, f]| format!("{t:.3},{d:.4},{f:.3}\n"));
    rows.fold(format!("{names}\n"), |text, row| text + &row)
}

#[test]
fn every_fault_of_a_test_is_named_with_its_remedy() {
    let same = |_: usize, row: [f64; 3]| Some(row);
    let cases: [(&str, String, &[&str]); 17] = [
        ("swapped", changed("time_s,force_N,depth_cm", |_, [t, d, f]| Some([t, d * 0.1, f * 1e-3])), &["swapped", "names"]),
        ("newtons", changed("time_s,depth_mm,force_N", same), &["modulus would be", "mN", "units"]),
        ("metres", changed("time_s,depth_m,force_mN", same), &["unit of the depth", "--thickness"]),
        (
            "backwards",
            changed(NAMES, |n, [t, d, f]| Some([if n > 300 { t - 3.0 } else { t }, d, f])),
            &["time runs backwards", "row 301", "sort"],
        ),
        ("no contact", changed(NAMES, |n, row| (n < 25).then_some(row)), &["no contact", "press deeper"]),
        (
            "saturated",
            changed(NAMES, |_, [t, d, f]| Some([t, d, f.min(300.0)])),
            &["exactly 0.3 N", "saturated", "press less deep"],
        ),
        ("half", changed(NAMES, |_, [t, d, f]| Some([t, d, f.min(180.0)])), &["exactly 0.18 N", "saturated"]),
        ("drift", changed(NAMES, |_, [t, d, f]| Some([t, d, f + 120.0 * t])), &["while the depth is held", "drifts", "warm up"]),
        ("one point", changed(NAMES, |n, row| (n == 100).then_some(row)), &["different times is 1", "at least 20"]),
        ("upwards", changed(NAMES, |_, [t, d, f]| Some([t, -d, f])), &["positive into the tissue", "sign"]),
        ("pulling", changed(NAMES, |_, [t, d, f]| Some([t, d, -f])), &["force is negative", "positive"]),
        ("decimal comma", changed(NAMES, same).replace('.', ","), &["line 2", "decimal commas", "semicolons"]),
        ("names", changed("a,b,c", same), &["no column of time and depth and force", "profondeur", "depth_mm"]),
        (
            "no such unit",
            changed("Time (weeks),depth_mm,force_mN", same),
            &["\"Time (weeks)\" has no unit that is known", "time_s"],
        ),
        ("no unit", changed("time_s,depth,force_mN", same), &["\"depth\" has no unit", "depth_mm"]),
        ("word", changed(NAMES, same).replacen("5.", "x.", 1), &["is no number", "leave the row out"]),
        ("empty", String::new(), &["empty"]),
    ];
    for (what, text, says) in cases {
        let desk = Desk::default();
        desk.put("test.csv", text);
        println!("{what}");
        let says = [&["test.csv"], says].concat();
        refused(&desk, &["identify", "test.csv", "--tip", "sphere:4mm", "--thickness", "10mm", "--out", "out"], &says);
    }
}

#[test]
fn more_tests_left_out_than_there_are_is_refused() {
    let desk = Desk::default();
    std::fs::create_dir(desk.folder().join("tests")).unwrap();
    for name in ["tests/a.csv", "tests/b.csv", "tests/c.csv", "one.csv"] {
        desk.put(name, PHANTOM);
    }
    for (data, count, says) in [("tests", "3", "3 tests given: give at most 2"), ("one.csv", "2", "1 test given: give at most 1")]
    {
        let run = ["identify", data, "--tip", "sphere:4mm", "--thickness", "10mm", "--leave-out", count, "--out", "out"];
        refused(&desk, &run, &["--leave-out", says]);
    }
}

#[test]
fn a_speed_that_nothing_has_is_a_warning_and_a_spreadsheets_text_is_read() {
    let desk = Desk::default();
    let slow = changed(NAMES, |_, [t, d, f]| Some([1e3 * t, d, f]));
    let wide = |text: &str, bytes: fn(u16) -> [u8; 2]| {
        [0xfeff].into_iter().chain(text.replace(',', "\t").encode_utf16()).flat_map(bytes).collect()
    };
    let cases: [(Vec<u8>, &[&str]); 3] = [
        (slow.into_bytes(), &["warning: test.csv: the tip moves in at 0.00200 mm/s: check the units of time and depth; "]),
        (wide(PHANTOM, u16::to_le_bytes), &["ok: modulus E, instantaneous 11.9"]),
        (wide(PHANTOM, u16::to_be_bytes), &["ok: modulus E, instantaneous 11.9"]),
    ];
    for (text, says) in cases {
        std::fs::write(desk.folder().join("test.csv"), text).unwrap();
        let run = ["identify", "test.csv", "--tip", "sphere:4mm", "--thickness", "10mm", "--block", "50x50mm", "--out", "out"];
        let outcome = palpate(SCRATCH, desk.folder(), &run);
        assert!(outcome.code == Some(0) && says.iter().all(|words| outcome.stdout.contains(words)), "{outcome:?}");
    }
}

/// A folder of tests contains other files too; without any test it is refused.
#[test]
fn notes_beside_tests_are_left_out() {
    let desk = Desk::default();
    std::fs::create_dir(desk.folder().join("tests")).unwrap();
    desk.put("tests/notes.txt", "Gel of May\nthe room was warm\n");
    let run = ["identify", "tests", "--tip", "sphere:4mm", "--thickness", "10mm", "--out", "out"];
    refused(&desk, &run, &["tests", "no file has a line that names time, depth and force", "depth_mm"]);
    desk.put("tests/one.csv", PHANTOM);
    let outcome = palpate(SCRATCH, desk.folder(), &run);
    assert!(outcome.code == Some(0) && outcome.stdout.contains("notes.txt: left out, as no line names"), "{outcome:?}");
}

#[test]
fn a_wrong_option_is_refused_before_anything_is_read() {
    let desk = Desk::default();
    let with = |more: &[&'static str]| [&["identify", "none.csv"], more].concat();
    refused(&desk, &with(&["--tip", "sphere:4mm", "--thickness", "10mm"]), &["none.csv", "check the path"]);
    refused(&desk, &with(&["--tip", "sphere:4", "--thickness", "10mm"]), &["--tip 4 m", "such as 4mm"]);
    refused(&desk, &with(&["--tip", "sphere:4mm", "--thickness", "10mm", "--nu", "0.5"]), &["--nu 0.5", "0.49"]);
    refused(
        &desk,
        &with(&["--tip", "sphere:4mm", "--thickness", "20..5mm"]),
        &["--thickness", "ends before it begins", "5..20mm"],
    );
    refused(&desk, &with(&["--tip", "sphere:4mm", "--thickness", "10mm", "--block", "5x5mm"]), &["--block", "width of the tip"]);
}

/// The phantom's hold, in which the tip slides for eight seconds against a known friction.
#[test]
fn a_slide_tells_the_friction_of_the_scene() {
    let desk = Desk::default();
    let rows = PHANTOM.lines().skip_while(|line| *line != NAMES).skip(1).map(|line| {
        let [t, _, f]: [f64; 3] = std::array::from_fn(|k| line.split(',').nth(k).unwrap().parse().unwrap());
        let at_mm = 2.0 * (t - 4.0).clamp(0.0, 8.0);
        format!("{line},{at_mm:.3},{:.3}\n", if (4.0..12.0).contains(&t) { 0.4 * f } else { 0.0 })
    });
    desk.put("slid.csv", rows.fold(format!("{NAMES},slide_mm,lateral_force_mN\n"), |text, row| text + &row));
    let found =
        palpate(SCRATCH, desk.folder(), &["identify", "slid.csv", "--tip", "sphere:4mm", "--thickness", "10mm", "--out", "out"]);
    assert!(found.code == Some(0) && found.stdout.contains("slid 16.0 mm at 2.0 mm/s: friction 0.400"), "{found:?}");
    assert!(!found.stdout.contains("slide along the surface"), "{found:?}");
    let scene = std::fs::read_to_string(desk.folder().join("out/identified.toml")).unwrap();
    let friction = scene.lines().find_map(|line| line.strip_prefix("friction = ")?.split(' ').next()?.parse().ok());
    // the zero of the force in air, which is noise here, is taken off
    assert!(friction.is_some_and(|friction: f64| (friction - 0.4).abs() < 2e-3), "{scene}");
}

#[test]
fn the_first_lines_say_what_the_data_cannot_and_the_scene_is_pressed() {
    let desk = Desk::default();
    // German names, a byte order mark, semicolons and decimal commas; no rows before contact
    let text = changed("Zeit [s],Eindringtiefe [mm],Kraft [mN]", |n, row| (n >= 26).then_some(row));
    desk.put("versuch.csv", format!("\u{feff}{}", text.replace(',', ";").replace('.', ",")));
    let arguments =
        ["identify", "versuch.csv", "--tip", "sphere:4mm", "--thickness", "10mm", "--block", "50x50mm", "--out", "out"];
    let found = palpate(SCRATCH, desk.folder(), &arguments);
    assert_eq!(found.code, Some(0), "{found:?}");
    let first: Vec<&str> = found.stdout.lines().take(10).collect();
    let first = first.join("\n");
    assert!(first.contains("not known from these data") && first.contains("start recording 1 mm above"), "{first}");
    assert!(found.stdout.contains("palpate fit --scene out/identified") && found.stdout.contains("decimal marks"));
    let pressed = palpate(SCRATCH, desk.folder(), &["press", "--scene", "out/identified.toml", "--set", "drive.hold_s=0.3"]);
    assert_eq!(pressed.code, Some(0), "{pressed:?}");
}
