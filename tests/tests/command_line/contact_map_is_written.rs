//! `press --contact` writes the contact map at the deepest point; without the option no such file
//! is written.

use palpate_tests::palpate_command::Desk;
use palpate_tests::press_run::{SMALL_BLOCK, Table, edited, press_at};
use serde_json::Value;

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");

#[test]
fn table_summary_and_print_tell_one_contact() {
    let plain = press_at(SCRATCH, Desk::default(), SMALL_BLOCK, &[]);
    assert_eq!(plain.summary.get("contact"), None);
    assert!(!plain.out.join("contact.csv").exists() && !plain.outcome.stdout.contains("contact "), "{}", plain.outcome.stdout);
    let run = press_at(SCRATCH, Desk::default(), SMALL_BLOCK, &["--contact"]);
    assert_eq!(run.summary["state_hash"], plain.summary["state_hash"]);
    let contact = &run.summary["contact"];
    let number = |key: &str| contact[key].as_f64().unwrap_or_else(|| panic!("{key} in {contact}"));
    let deepest = run.holds()[2];
    let force_n = contact["force_n"][2].as_f64().unwrap();
    assert!((force_n / deepest.force_n - 1.0).abs() < 1e-3, "{force_n} N for {deepest:?}");
    assert!((number("depth_m") - deepest.target).abs() < 1e-8, "{contact}");
    let table = Table::read(&run.out.join("contact.csv"));
    assert_eq!(table.header, ["triangle", "centroid_x_m", "centroid_y_m", "centroid_z_m", "area_m2", "pressure_pa"]);
    let (area_m2, pressure_pa) = (table.column("area_m2"), table.column("pressure_pa"));
    assert_eq!(table.rows.len() as f64, number("triangles"));
    assert_eq!(pressure_pa.iter().copied().fold(0.0, f64::max) as f32, number("peak_pressure_pa") as f32);
    // forces fan out under the ball, and triangles at the contact's edge are touched in part only
    let sum_n: f64 = area_m2.iter().zip(&pressure_pa).map(|(a, p)| a * p).sum();
    assert!((1.0..1.15).contains(&(sum_n / force_n)), "{sum_n} N for {force_n}");
    assert!((0.6..1.0).contains(&(number("area_m2") / area_m2.iter().sum::<f64>())), "{contact}");
    let said = format!("{:.1} mm2 at 4.00 mm", number("area_m2") * 1e6);
    assert!(run.outcome.stdout.contains(&said), "{said} in {}", run.outcome.stdout);
    for name in ["contact.svg", "contact.png"] {
        assert!(run.out.join(name).exists(), "{name}");
    }
}

#[test]
fn a_press_that_touches_nothing_says_so() {
    let above = edited(
        SMALL_BLOCK,
        "kind = \"depth\"\nholds_m = [0.001, 0.002, 0.004]\nramp_m_per_s = 0.04\nhold_s = 0.3",
        "kind = \"trace\"\ntrace = \"tips.csv\"\ndepth_limit_m = 0.004",
    );
    let desk = Desk::default();
    let rows: String = (0..20).map(|n| format!("{n}e-3,0,0,0.002\n")).collect();
    desk.put("tips.csv", format!("t_s,probe_x_m,probe_y_m,probe_z_m\n{rows}"));
    let run = press_at(SCRATCH, desk, &above, &["--contact"]);
    assert!(run.outcome.stdout.contains("nothing was touched"), "{}", run.outcome.stdout);
    assert_eq!(run.summary.get("contact").filter(|c| **c != Value::Null), None);
    assert!(!run.out.join("contact.csv").exists());
}
