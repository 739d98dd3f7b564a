//! `press` writes the promised files, and their contents are consistent.

use palpate::Output;
use palpate_tests::palpate_command::{Desk, palpate};
use palpate_tests::press_run::{PressRun, SMALL_BLOCK, Table, press, press_at, small_block};
use palpate_tissue::machine::processor;
use palpate_tissue::press::{Press, TickRow};
use palpate_tissue::scene::Drive;
use serde_json::Value;

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");
const TICK_S: f64 = 1e-3;
const TARGETS_M: [f64; 3] = [0.001, 0.002, 0.004];
const PICTURES: [&str; 5] = ["force_depth", "force_time", "section", "surface", "tick_time"];

fn with_vtu() -> PressRun {
    press_at(SCRATCH, Desk::default(), SMALL_BLOCK, &["--vtu"])
}

/// Row of the trace at the end of hold `k`: the last row at that depth during the descent.
fn end_of_hold(run: &PressRun, k: usize) -> usize {
    let z = run.trace.column("probe_z_m");
    let there = f64::from(-(TARGETS_M[k] as f32));
    let at = |z: &f64| (z - there).abs() <= f64::from(f32::EPSILON) * there.abs();
    let arrived = z.iter().position(at).expect("the probe was at the target");
    arrived + z[arrived..].iter().take_while(|z| at(z)).count() - 1
}

#[test]
fn summary_has_the_contract_keys_with_their_types() {
    let run = small_block(SCRATCH);
    let s = &run.summary;
    assert_eq!(s["scene"], "small");
    assert_eq!(s["method"], "palpate");
    assert_eq!(s["nodes"], 129);
    for key in ["springs", "tets", "substeps", "ticks"] {
        assert!(s[key].as_u64().is_some_and(|n| n > 0), "{key}: {s}");
    }
    assert!(s["deadline_misses"].is_u64(), "{s}");
    assert_eq!(s.get("fault"), Some(&Value::Null));
    assert_eq!(s["limiters"], Value::Array(vec![]));
    // a tick of 1 ms must be shorter than the stable step times the number of substeps
    assert!(run.number("/stable_dt_s") * run.number("/substeps") > TICK_S, "{s}");
    let [p50, p99, max] = ["/tick_us/p50", "/tick_us/p99", "/tick_us/max"].map(|key| run.number(key));
    assert!(0.0 < p50 && p50 <= p99 && p99 <= max, "{s}");
    let keys = ["target", "depth_m", "force_n", "min_j", "volume_change_pct"];
    let holds = s["holds"].as_array().unwrap();
    assert_eq!(holds.len(), TARGETS_M.len());
    assert!(holds.iter().all(|h| keys.iter().all(|key| h[key].as_f64().is_some_and(f64::is_finite))), "{s}");
    for (hold, target) in run.holds().iter().zip(TARGETS_M) {
        assert_eq!(hold.target, target);
    }
    assert!(s["state_hash"].as_str().is_some_and(|h| h.len() == 16 && u64::from_str_radix(h, 16).is_ok()));
}

#[test]
fn folder_holds_the_files_and_nothing_else() {
    let names = |run: &PressRun| {
        let mut names: Vec<String> =
            std::fs::read_dir(&run.out).unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    };
    // `.palpate` lists the files that the next run may replace
    let mut expected = vec![String::from(".palpate")];
    expected.extend(PICTURES.iter().flat_map(|p| [format!("{p}.svg"), format!("{p}.png")]));
    expected.extend(["summary.json", "trace.csv", "surface_0.csv", "surface_1.csv", "surface_2.csv"].map(String::from));
    expected.sort();
    let run = press(SCRATCH, SMALL_BLOCK);
    assert_eq!(names(&run), expected);
    expected.extend([0, 1, 2].map(|k| format!("press_{k}.vtu")));
    expected.sort();
    assert_eq!(names(&with_vtu()), expected);

    for picture in PICTURES {
        let svg = std::fs::read_to_string(run.out.join(format!("{picture}.svg"))).unwrap();
        assert!(svg.contains("<svg") && svg.contains("small"), "{picture}: no drawing titled with the scene");
        elements(&svg);
        let png = std::fs::File::open(run.out.join(format!("{picture}.png"))).unwrap();
        let info = png::Decoder::new(std::io::BufReader::new(png)).read_info().unwrap();
        assert!(info.info().width >= 600 && info.info().height >= 400, "{picture}");
    }
}

#[test]
fn trace_has_one_row_a_millisecond() {
    let run = small_block(SCRATCH);
    let columns = [
        "t_s",
        "probe_x_m",
        "probe_y_m",
        "probe_z_m",
        "depth_m",
        "force_x_n",
        "force_y_n",
        "force_z_n",
        "active_nodes",
        "tick_us",
    ];
    assert_eq!(run.trace.header, columns);
    assert_eq!(run.trace.rows.len() as f64, run.number("/ticks"));
    for (n, t_s) in run.trace.column("t_s").into_iter().enumerate() {
        assert_eq!(t_s, n as f64 * TICK_S, "row {n}");
    }
    let free = run.number("/nodes") - run.number("/report/anchors");
    assert!(run.trace.column("active_nodes").iter().all(|active| *active == free));
    // down and up at 0.04 m/s from a height of 1/16 radius, three holds, half a second at the end;
    // each leg's last step may be partial
    let expected_s = 2.0 * (0.0005 + 0.004) / 0.04 + 3.0 * 0.3 + 0.5;
    assert!((run.number("/ticks") * TICK_S - expected_s).abs() <= 4.0 * TICK_S, "{} ticks", run.number("/ticks"));
}

#[test]
fn tick_times_of_summary_and_trace_are_the_same() {
    let run = small_block(SCRATCH);
    let mut tick_us = run.trace.column("tick_us");
    assert_eq!(tick_us.iter().filter(|us| **us > 1000.0).count() as f64, run.number("/deadline_misses"));
    tick_us.sort_by(f64::total_cmp);
    let at = |share: f64| tick_us[((tick_us.len() - 1) as f64 * share) as usize] as f32;
    for (key, share) in [("/tick_us/p50", 0.5), ("/tick_us/p99", 0.99), ("/tick_us/max", 1.0)] {
        assert_eq!(run.number(key) as f32, at(share), "{key}");
    }
}

#[test]
fn holds_of_the_summary_are_rows_of_the_trace() {
    let run = small_block(SCRATCH);
    for (k, hold) in run.holds().iter().enumerate() {
        let row = end_of_hold(run, k);
        assert_eq!(hold.force_n, run.trace.column("force_z_n")[row], "hold {k}");
        assert_eq!(hold.depth_m, run.trace.column("depth_m")[row], "hold {k}");
        // frictionless contact on a flat top: the asymmetry of the mesh tilts the contact normal by
        // a few per cent, which changes the vertical component only by the square of that
        assert!((hold.depth_m / hold.target - 1.0).abs() < 0.005, "{hold:?}");
        let across = run.trace.column("force_x_n")[row].hypot(run.trace.column("force_y_n")[row]);
        assert!(across < 0.1 * hold.force_n, "hold {k}: {across} N across");
        assert!(hold.min_j > 0.5 && hold.min_j < 1.0, "{hold:?}");
    }
    let forces = run.forces_n();
    assert!(forces[0] > 0.0 && forces.is_sorted_by(|a, b| a < b), "{forces:?}");
    // outside the tissue there is no force, neither at the start nor at the end
    for column in ["force_x_n", "force_y_n", "force_z_n", "depth_m"] {
        let column = run.trace.column(column);
        assert_eq!((column[0], column[column.len() - 1]), (0.0, 0.0));
    }
}

#[test]
fn surface_is_the_closed_skin_pressed_in_under_the_probe() {
    let run = small_block(SCRATCH);
    for (k, target) in TARGETS_M.into_iter().enumerate() {
        let surface = run.surface(k);
        let columns = ["rest_x_m", "rest_y_m", "rest_z_m", "displacement_x_m", "displacement_y_m", "displacement_z_m"];
        assert_eq!(surface.header, columns);
        // a closed surface without holes: nodes = triangles / 2 + 2 (Euler)
        assert_eq!(surface.rows.len() as f64, run.number("/report/triangles") / 2.0 + 2.0);
        for row in &surface.rows {
            let on = |c: f64, face: f64| (c - face).abs() < 1e-8;
            let on_hull = on(row[0].abs(), 0.04) || on(row[1].abs(), 0.04) || on(row[2], 0.0) || on(row[2], -0.04);
            assert!(on_hull, "{row:?}");
            // the bottom is fixed
            assert!(!on(row[2], -0.04) || row[3..] == [0.0; 3], "{row:?}");
        }
        let deepest = surface.rows.iter().min_by(|a, b| a[5].total_cmp(&b[5])).unwrap();
        // the foundation takes up the indentation that elements of 5 mm do not resolve, so the
        // nodes follow by a part of the depth only
        assert!((0.2 * target..1.05 * target).contains(&-deepest[5]), "{target}: {deepest:?}");
        assert!(deepest[0].hypot(deepest[1]) < 0.008, "the deepest place is not under the probe: {deepest:?}");
    }
}

/// Elements of an XML text as (name, content up to the first child). Checks that every tag is
/// closed in its proper place.
fn elements(xml: &str) -> Vec<(String, String)> {
    let (mut open, mut found) = (Vec::<&str>::new(), Vec::new());
    for piece in xml.split('<').skip(1) {
        let (tag, text) = piece.split_once('>').expect("a tag ends");
        if let Some(name) = tag.strip_prefix('/') {
            assert_eq!(open.pop(), Some(name), "</{name}> closes another element");
        } else if !tag.starts_with(['?', '!']) {
            assert_eq!(tag.matches('"').count() % 2, 0, "an attribute of <{tag}> is not closed");
            if !tag.ends_with('/') {
                open.push(tag.split_whitespace().next().unwrap());
            }
            found.push((tag.to_owned(), text.to_owned()));
        }
    }
    assert!(open.is_empty(), "{open:?} stay open");
    found
}

#[test]
fn vtu_is_well_formed_and_agrees_with_summary_and_surface() {
    let run = with_vtu();
    for (k, hold) in run.holds().iter().enumerate() {
        let text = std::fs::read_to_string(run.out.join(format!("press_{k}.vtu"))).unwrap();
        assert!(text.starts_with("<?xml version=\"1.0\"?>\n<VTKFile type=\"UnstructuredGrid\""));
        let elements = elements(&text);
        let array = |name: &str| -> Vec<f64> {
            let (_, data) =
                elements.iter().find(|(tag, _)| tag.contains(&format!("Name=\"{name}\""))).expect("the array is there");
            data.split_whitespace().map(|word| word.parse().unwrap()).collect()
        };
        let (nodes, tets) = (run.number("/nodes") as usize, run.number("/tets") as usize);
        let piece = format!("Piece NumberOfPoints=\"{nodes}\" NumberOfCells=\"{tets}\"");
        assert!(elements.iter().any(|(tag, _)| *tag == piece), "no <{piece}>");
        let (points, moved, ratio) = (array("points"), array("displacement_m"), array("volume_ratio"));
        let face = array("surface_displacement_m");
        assert_eq!((points.len(), moved.len(), ratio.len()), (3 * nodes, 3 * nodes, tets));
        let corners = array("connectivity");
        assert!(corners.len() == 4 * tets && corners.iter().all(|n| (*n as usize) < nodes));
        assert_eq!(array("offsets"), (1..=tets).map(|t| 4.0 * t as f64).collect::<Vec<_>>());
        // VTK's number for a tet
        assert_eq!(array("types"), vec![10.0; tets]);

        // deformed coordinates are rounded to single precision before J is computed: 0.04 m x 6e-8
        // on three edges of 4 mm and more
        let least = ratio.iter().copied().fold(f64::INFINITY, f64::min);
        assert!((least - hold.min_j).abs() < 1e-5, "{least} {hold:?}");
        for row in &run.surface(k).rows {
            // single-precision values are printed as such there and converted to double precision
            // here
            let same = |n: usize| {
                (0..3).all(|c| {
                    (points[3 * n + c] - row[c] - moved[3 * n + c]).abs() < 1e-9 && face[3 * n + c] as f32 == row[3 + c] as f32
                })
            };
            assert!((0..nodes).any(same), "{row:?} is not a node of press_{k}.vtu");
        }
    }
}

#[test]
fn printed_table_is_aligned_and_agrees_with_the_summary() {
    let run = small_block(SCRATCH);
    let lines: Vec<&str> = run.outcome.stdout.lines().collect();
    let head = lines.iter().position(|l| l.contains("force N")).expect("the table has a head");
    let rows = &lines[head + 1..=head + TARGETS_M.len()];
    for (row, hold) in rows.iter().zip(run.holds()) {
        assert_eq!(row.chars().count(), lines[head].chars().count(), "\n{}\n{row}", lines[head]);
        let cells: Vec<f64> = row.split_whitespace().take(4).map(|c| c.parse().unwrap()).collect();
        let expected = [hold.target * 1e3, hold.depth_m * 1e3, hold.force_n, hold.min_j];
        for (cell, value) in cells.iter().zip(expected) {
            assert!((cell - value).abs() <= 0.0005 + 1e-9, "{row}: {value}");
        }
    }
    assert!(run.outcome.stdout.contains(&format!("{} ticks", run.number("/ticks"))));
    assert!(run.outcome.stdout.contains(run.summary["state_hash"].as_str().unwrap()));
    assert_eq!(run.outcome.stderr, "");
}

#[test]
fn same_scene_gives_the_same_files_but_for_the_clock() {
    let untimed = |run: &PressRun| {
        let mut trace: Table = run.trace.clone();
        trace.rows.iter_mut().for_each(|row| {
            row.pop();
        });
        (trace.rows, run.summary["state_hash"].clone(), run.summary["holds"].clone(), run.surface(2).rows.clone())
    };
    assert_eq!(untimed(&press(SCRATCH, SMALL_BLOCK)), untimed(small_block(SCRATCH)));
}

#[test]
fn without_a_command_the_default_block_is_pressed_into_out_press() {
    let desk = Desk::default();
    let outcome = palpate(SCRATCH, desk.folder(), &[]);
    assert_eq!(outcome.code, Some(0), "{outcome:?}");
    assert_eq!(desk.listing(), ["out"]);
    let summary = std::fs::read_to_string(desk.folder().join("out/press/summary.json")).unwrap();
    let summary: Value = serde_json::from_str(&summary).unwrap();
    assert_eq!((&summary["scene"], &summary["nodes"]), (&"block".into(), &410.into()));
}

/// A virtual machine can lose its core in some ticks, which is a warning. A patch that is too large
/// is late in half of them, and an emulated board has no such excuse.
#[test]
fn late_ticks_warn_on_a_desktop_and_fail_on_a_board() {
    let drive = Drive::Depth { holds_m: vec![], ramp_m_per_s: 0.04, hold_s: 0.3 };
    let late = |deadline_misses, timed_on: String| {
        let tick = TickRow { t_s: 0.0, tip_m: [0.0; 3].into(), command_m: 0.0, output: Output::NONE, tick_us: 30.0 };
        let press = Press { ticks: vec![tick; 1622], deadline_misses, ..Press::empty(timed_on) };
        (press.check(&drive).is_ok(), press.often_late())
    };
    let desktop = [16, 17, 811, 812].map(|misses| late(misses, processor()));
    assert_eq!(desktop, [(true, false), (true, true), (true, true), (false, true)]);
    assert!(late(0, "an emulated board".into()).0 && !late(1, "an emulated board".into()).0);
}
