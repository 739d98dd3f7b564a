//! The force on a hand in press, tap, hold and drag, on a wall and on the shipped patches, is
//! compared with recorded traces, so that a force cannot change or vanish unnoticed.
//!
//! To accept an intended change, run `cargo test --release --package palpate-tests --test core
//! golden_force_traces -- --ignored rewrite` and give the reason in the commit.

use std::fmt::Write;
use std::path::PathBuf;

use palpate::haptic::cycle::{Ask, Command, Cycle, Settings};
use palpate::haptic::device::{DeviceSpec, HapticDevice, Sensed, SensorStatus};
use palpate::haptic::mode::Mode;
use palpate::{Params, Vector3};
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_loop::closed_loop::surface::{Surface, Wall, with_tissue};
use palpate_tests::bench::Bench;

/// Allowed difference of a force: this share of it, or [`LEAST_N`].
const SHARE: f32 = 0.005;
const LEAST_N: f32 = 2e-4;
/// Interval between the recorded rows [ticks].
const EVERY: usize = 10;
const WALL_N_PER_M: f64 = 400.0;
/// Young's modulus of the blocks [Pa]: their contact stays below the device's stiffness ceiling,
/// above which a gain would hide a change of stiffness.
const YOUNGS_MODULUS_PA: f32 = 18e3;
/// Segment of a motion: depth [m], distance along the surface [m], and speed [m/s], or duration [s]
/// if it stands still.
type Motion = (f64, f64, f64);
const MOTIONS: [(&str, &[Motion]); 4] = [
    ("press", &[(4e-3, 0.0, 0.02), (4e-3, 0.0, 0.1), (-2e-3, 0.0, 0.02)]),
    ("tap", &[(4e-3, 0.0, 0.3), (-2e-3, 0.0, 0.3), (4e-3, 0.0, 0.5), (-2e-3, 0.0, 0.5)]),
    ("hold", &[(2e-3, 0.0, 0.1), (2e-3, 0.0, 0.4), (-2e-3, 0.0, 0.1)]),
    ("drag", &[(3e-3, 0.0, 0.1), (3e-3, 8e-3, 0.1), (3e-3, -4e-3, 0.1), (-2e-3, -4e-3, 0.1)]),
];

struct Scripted {
    reading: Sensed,
    limits: DeviceSpec,
    got_n: Vector3<f32>,
}

impl HapticDevice for Scripted {
    fn limits(&self) -> DeviceSpec {
        self.limits
    }

    fn sense(&mut self) -> Sensed {
        self.reading.sequence = self.reading.sequence.wrapping_add(1);
        self.reading
    }

    fn actuate(&mut self, force_n: Vector3<f32>) {
        self.got_n = force_n;
    }

    fn release(&mut self) {
        self.got_n = Vector3::zeros();
    }
}

/// Name of the motion, tick, force [N].
type Row = (&'static str, usize, Vector3<f32>);

fn trace(surface: &mut impl Surface) -> Vec<Row> {
    let site = surface.site();
    let profile = DeviceProfile::load("touch").unwrap();
    let limits = profile.limits(site.at_m.cast());
    let mut cycle = Cycle::build(&Settings { limits: profile.limit_values(), ..Settings::safe(&limits) }, &limits).unwrap();
    let at = |depth_m: f64, along_m: f64| site.point_m(depth_m, along_m, 0.0).cast::<f32>();
    let reading = Sensed { position_m: at(-2e-3, 0.0), sequence: 0, status: SensorStatus::Good };
    let mut device = Scripted { reading, limits, got_n: Vector3::zeros() };
    for n in 0..700 {
        let asked = [Ask::Booted, Ask::TestPassed, Ask::Arm].get(n).copied();
        cycle.tick(&mut device, surface, Command { asked, ..Command::HEARD });
    }
    assert_eq!(cycle.mode(), Mode::Active);
    let mut rows = Vec::new();
    for (name, ways) in MOTIONS {
        let (mut tick, mut from) = (0, (-2e-3_f64, 0.0_f64));
        let home = [(-2e-3, 0.0, 0.1), (-2e-3, 0.0, 0.3)];
        for (to_m, along_m, speed_or_s) in ways.iter().copied().chain(home) {
            let displacement_m = (to_m - from.0).abs() + (along_m - from.1).abs();
            let ticks = if displacement_m > 0.0 { displacement_m / speed_or_s * 1e3 } else { speed_or_s * 1e3 }.ceil().max(1.0);
            for n in 1..=ticks as u32 {
                let share = f64::from(n) / ticks;
                device.reading.position_m = at(from.0 + (to_m - from.0) * share, from.1 + (along_m - from.1) * share);
                cycle.tick(&mut device, surface, Command::HEARD);
                if tick % EVERY == 0 {
                    rows.push((name, tick, device.got_n));
                }
                tick += 1;
            }
            from = (to_m, along_m);
        }
    }
    assert_eq!(cycle.mode(), Mode::Active);
    rows
}

/// Traces on every surface, with all stiffnesses multiplied by `ratio`.
fn traces(ratio: f64) -> Vec<(String, Vec<Row>)> {
    let normal = Vector3::new(0.48, 0.6, 0.64);
    let mut all = vec![("wall".to_owned(), trace(&mut Wall::new(WALL_N_PER_M * ratio, 3.0, normal)))];
    for nodes in [130, 410, 1020] {
        let mut bench = Bench::calibrated(nodes);
        bench.patch.set_depth_limit_m(8e-3);
        let params = Params { youngs_modulus_pa: YOUNGS_MODULUS_PA * ratio as f32, ..bench.params };
        all.push((format!("block-{nodes}"), with_tissue(&bench.patch, &params, |tissue| trace(tissue)).unwrap()));
    }
    all
}

fn file(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("golden").join(format!("force-{name}.csv"))
}

fn text(rows: &[Row]) -> String {
    let mut text = String::from("motion,tick,x_n,y_n,z_n\n");
    for (motion, tick, force_n) in rows {
        writeln!(text, "{motion},{tick},{:.5},{:.5},{:.5}", force_n.x, force_n.y, force_n.z).unwrap();
    }
    text
}

/// Rows of a trace that differ from the recorded ones.
fn different(name: &str, rows: &[Row]) -> Vec<String> {
    let golden = std::fs::read_to_string(file(name)).unwrap();
    let golden: Vec<&str> = golden.lines().skip(1).collect();
    assert_eq!(golden.len(), rows.len(), "{name}: another number of rows");
    let mut found = Vec::new();
    for (line, (motion, tick, force_n)) in golden.iter().zip(rows) {
        let cells: Vec<&str> = line.split(',').collect();
        assert!(cells[0] == *motion && cells[1] == tick.to_string(), "{name}: {line} instead of {motion}, {tick}");
        let cell = |n: usize| cells[n].parse::<f32>().unwrap();
        let was_n = Vector3::new(cell(2), cell(3), cell(4));
        let apart_n = (force_n - was_n).norm();
        if apart_n.is_nan() || apart_n > SHARE * was_n.norm() + LEAST_N {
            found.push(format!("{name} {motion}, tick {tick}: {force_n:?} N instead of {was_n:?} N"));
        }
    }
    found
}

#[test]
fn no_force_changes_or_vanishes() {
    for (name, rows) in traces(1.0) {
        for (motion, _) in MOTIONS {
            let peak_n = rows.iter().filter(|r| r.0 == motion).map(|r| r.2.norm()).fold(0.0, f32::max);
            assert!(peak_n > 0.2, "{name}: {motion} is hardly felt, {peak_n} N");
        }
        let found = different(&name, &rows);
        assert!(found.is_empty(), "{} rows differ; the first: {}", found.len(), found[0]);
    }
}

#[test]
fn one_percent_is_noticed() {
    for (name, rows) in traces(1.01) {
        let found = different(&name, &rows).len();
        assert!(found > rows.len() / 4, "{name}: {found} of {} rows", rows.len());
    }
}

#[test]
#[ignore = "writes the traces down anew"]
fn rewrite() {
    for (name, rows) in traces(1.0) {
        std::fs::create_dir_all(file(&name).parent().unwrap()).unwrap();
        std::fs::write(file(&name), text(&rows)).unwrap();
    }
}
