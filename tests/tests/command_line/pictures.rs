//! Every picture is complete, has the promised size and labels, or does not exist at all.

use std::error::Error;
use std::fs;
use std::io::BufReader;
use std::path::Path;

use palpate_charts::{
    ChartError, Moment, Press, Probe, ProbeShape, Sample, Section, Surface, TickTimes, force_depth, force_time, section, surface,
    tick_time,
};

use palpate_tests::palpate_command::{Desk, palpate, repository};

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");

type Checked = Result<(), Box<dyn Error>>;
type Draw<'a> = &'a dyn Fn(&Path, &str) -> Result<(), ChartError>;

const HOLD: Sample = Sample { t_s: 0.2, depth_m: 0.004, force_n: 0.139 };

fn trace(force_n: f64) -> Vec<Sample> {
    let at = |i: i32, share: f64| Sample {
        t_s: f64::from(i) * 1e-3,
        depth_m: 0.005 * share - 0.001,
        force_n: force_n * (1.25 * share - 0.25).max(0.0),
    };
    let press = (0..=200).map(|i| at(i, f64::from(i) / 200.0));
    press.chain((201..=400).map(|i| at(i, f64::from(400 - i) / 200.0))).collect()
}

fn press(trace: &[Sample]) -> Press<'_> {
    Press { scene: "gel & bone", node_count: 410, trace, holds: &[HOLD], reference: &[(0.002, 0.049)] }
}

const TET: [[f64; 3]; 4] = [[0.0; 3], [0.03, 0.0, 0.0], [0.0, 0.03, 0.0], [0.0, 0.0, 0.03]];
const PUSHED: [[f64; 3]; 4] = [[0.0; 3], [0.03, 0.0, 0.0], [0.0, 0.03, 0.0], [0.0, 0.0, 0.026]];
const TET_SIDES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn tet() -> Surface<'static> {
    Surface {
        scene: "tet at hold 1",
        caption: "4 nodes",
        rest_m: &TET,
        deformed_m: &PUSHED,
        triangles: &TET_SIDES,
        probe: Probe { shape: ProbeShape::Hemisphere, radius_m: 0.008, tip_m: [0.0, 0.0, 0.026], axis: [0.0, 0.0, 2.0] },
    }
}

fn moments() -> [Moment<'static>; 2] {
    let rest = Probe { tip_m: [0.0, 0.01, 0.03], ..tet().probe };
    [
        Moment { deformed_m: &TET, probe: rest, depth_m: 0.0, force_n: 0.0 },
        Moment { deformed_m: &PUSHED, probe: Probe { tip_m: [0.0, 0.01, 0.026], ..rest }, depth_m: 0.004, force_n: 0.139 },
    ]
}

fn cut_tet<'a>(moments: &'a [Moment<'a>]) -> Section<'a> {
    Section {
        scene: "tet",
        caption: "4 nodes",
        rest_m: &TET,
        tets: &[[0, 1, 2, 3]],
        triangles: &TET_SIDES,
        fixed: &[true, true, true, false],
        balls_m: &[([0.0, 0.0, 0.01], 0.02)],
        up: [0.0, 0.0, 1.0],
        moments,
    }
}

fn times(tick_us: &[f32]) -> TickTimes<'_> {
    TickTimes { scene: "block", node_count: 410, machine: "test machine", tick_us }
}

/// Checks the size of a picture and returns red, green and blue of every pixel.
fn pixels(path: &Path) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut reader = png::Decoder::new(BufReader::new(fs::File::open(path)?)).read_info()?;
    let mut bytes = vec![0; reader.output_buffer_size().ok_or("too large")?];
    let info = reader.next_frame(&mut bytes)?;
    assert_eq!((info.width, info.height), (1000, 700));
    Ok(bytes)
}

/// Scene and name of a picture that a press draws, and its name in README and book.
const SHOWN: [(&str, &str, &str); 4] = [
    ("block", "force_depth", "force_depth"),
    ("block", "section", "section"),
    ("nodule", "section", "section-nodule"),
    ("nodule", "contact", "contact"),
];
/// Number of bytes that another processor's last bits may change.
const MOST_CHANGED: usize = 2000;

#[test]
fn pictures_of_readme_and_book_are_those_that_press_draws() -> Checked {
    let desk = Desk::default();
    for scene in ["block", "nodule"] {
        let run = palpate(SCRATCH, desk.folder(), &["press", "--scene", scene, "--contact", "--out", scene]);
        assert_eq!(run.code, Some(0), "{run:?}");
    }
    for (scene, drawn, name) in SHOWN {
        let drawn = pixels(&desk.folder().join(scene).join(drawn).with_extension("png"))?;
        let shown = pixels(&repository().join("host-sim/pictures").join(name).with_extension("png"))?;
        let changed = drawn.iter().zip(&shown).filter(|(a, b)| a.abs_diff(**b) > 24).count();
        assert!(
            changed <= MOST_CHANGED,
            "{name}.png is out of date: {changed} bytes differ from what `palpate press --scene {scene} --contact` draws"
        );
    }
    Ok(())
}

fn dark_pixels(rgb: &[u8]) -> usize {
    rgb.chunks(3).filter(|p| p.iter().all(|v| *v < 120)).count()
}

#[test]
fn pictures_are_whole_and_labelled() -> Checked {
    let run = trace(0.139);
    let folder = tempfile::tempdir()?;
    let cases: [(&str, Draw, &[&str]); 5] = [
        (
            "force_depth",
            &|f, n| force_depth(f, n, &press(&run)),
            &[
                "gel &amp; bone: force against depth",
                "410 nodes",
                "depth [mm]",
                "force [N]",
                "4.0 mm, 0.139 N",
                "going in",
                "coming out",
                "end of a hold, at rest",
                "finite elements, at rest",
            ],
        ),
        ("force_time", &|f, n| force_time(f, n, &press(&run)), &["time [s]", "depth [mm]", "force [N]", "4.0 mm", "0.139 N"]),
        (
            "tick_time",
            &|f, n| tick_time(f, n, &times(&[20.0, 21.0, 22.0, 300.0])),
            &["time of a tick [µs]", "median 21.0 µs", "longest 300 µs", "none over", "test machine"],
        ),
        ("surface_1.5", &|f, n| surface(f, n, &tet()), &["tet at hold 1", "4 nodes", "displacement [mm]", "10 mm"]),
        (
            "section",
            &|f, n| section(f, n, &cut_tet(&moments())),
            &[
                "tet: the tissue gives way",
                "no force",
                "at rest",
                "4.0 mm deep",
                "0.139 N",
                "arrow: force on the finger",
                "red: nodule",
            ],
        ),
    ];
    for (name, draw, labels) in cases {
        draw(folder.path(), name)?;
        let svg = fs::read_to_string(folder.path().join(format!("{name}.svg")))?;
        assert!(svg.starts_with(r#"<svg width="1000" height="700" viewBox="0 0 4000 2800""#));
        assert!(svg.trim_end().ends_with("</svg>"));
        for label in labels {
            assert!(svg.contains(label), "{name}: {label}");
        }
        // axes and letters alone darken more than a thousand pixels
        let rgb = pixels(&folder.path().join(format!("{name}.png")))?;
        assert!(dark_pixels(&rgb) > 1000, "{name}");
        assert!(rgb.starts_with(&[255; 300]), "{name}: ink at the edge");
    }
    assert_eq!(fs::read_dir(folder.path())?.count(), 10, "temporary files are left");
    Ok(())
}

#[test]
fn the_same_data_gives_the_same_bytes() -> Checked {
    let folder = tempfile::tempdir()?;
    for name in ["a", "b"] {
        surface(folder.path(), name, &tet())?;
    }
    for kind in ["svg", "png"] {
        let read = |name: &str| fs::read(folder.path().join(format!("{name}.{kind}")));
        assert!(read("a")? == read("b")?, "{kind}");
    }
    Ok(())
}

#[test]
fn a_dent_shows_in_the_colours() -> Checked {
    let folder = tempfile::tempdir()?;
    surface(folder.path(), "pressed", &tet())?;
    surface(folder.path(), "rest", &Surface { deformed_m: &TET, ..tet() })?;
    // yellow, the end of the colour scale, occurs outside the colour bar only where tissue has
    // moved
    let yellow = |name: &str| -> Result<usize, Box<dyn Error>> {
        let rgb = pixels(&folder.path().join(format!("{name}.png")))?;
        let body = rgb.chunks(3000).flat_map(|row| row.chunks(3).take(830));
        Ok(body.filter(|p| p[1] > 150 && p[2] < 110).count())
    };
    assert_eq!(yellow("rest")?, 0);
    assert!(yellow("pressed")? > 100);
    Ok(())
}

#[test]
fn a_folder_that_cannot_be_written_gives_one_line_and_no_file() -> Checked {
    let run = trace(0.1);
    let folder = tempfile::tempdir()?;
    let file = folder.path().join("a_file");
    fs::write(&file, "")?;
    for target in [file, folder.path().join("missing")] {
        let Err(error) = force_depth(&target, "x", &press(&run)) else {
            return Err("wrote into nowhere".into());
        };
        let line = error.to_string();
        assert!(line.contains("x.svg") && line.contains("choose a folder"), "{line}");
        assert!(!line.contains('\n'), "{line}");
    }
    assert_eq!(fs::read_dir(folder.path())?.count(), 1);
    Ok(())
}

#[test]
fn a_png_that_cannot_be_placed_takes_its_svg_back() -> Checked {
    let run = trace(0.1);
    let folder = tempfile::tempdir()?;
    let squatter = folder.path().join("x.png");
    fs::create_dir(&squatter)?;
    fs::write(squatter.join("inside"), "")?;
    assert!(force_depth(folder.path(), "x", &press(&run)).is_err());
    assert_eq!(fs::read_dir(folder.path())?.count(), 1);
    Ok(())
}

#[test]
fn what_cannot_be_drawn_is_refused_by_place_and_leaves_nothing() -> Checked {
    let folder = tempfile::tempdir()?;
    let folder = folder.path();
    let mut run = trace(0.1);
    run[7].force_n = f64::NAN;
    let broken = [TET[0], TET[1], TET[2], [0.0, f64::INFINITY, 0.0]];
    let refusals = [
        (force_depth(folder, "x", &press(&run)), "trace force_n[7] is NaN"),
        (force_time(folder, "x", &press(&run)), "trace force_n[7] is NaN"),
        (force_depth(folder, "x", &press(&[])), "trace is empty"),
        (tick_time(folder, "x", &times(&[])), "tick_us is empty"),
        (tick_time(folder, "x", &times(&[1.0, f32::NAN])), "tick_us[1] is NaN"),
        (tick_time(folder, "x", &times(&[1.0, -2.0])), "tick_us[1] is -2"),
        (surface(folder, "x", &Surface { deformed_m: &broken, ..tet() }), "[10] is inf"),
        (surface(folder, "x", &Surface { triangles: &[[0, 1, 4]], ..tet() }), "triangles[0] names node 4"),
        (surface(folder, "x", &Surface { triangles: &[], ..tet() }), "triangles is empty"),
        (section(folder, "x", &Section { tets: &[[0, 1, 2, 4]], ..cut_tet(&moments()) }), "tets[0] names node 4"),
        (section(folder, "x", &Section { tets: &[], ..cut_tet(&moments()) }), "tets is empty"),
        (section(folder, "x", &cut_tet(&[])), "moments is empty"),
        (section(folder, "x", &Section { rest_m: &broken, ..cut_tet(&moments()) }), "[10] is inf"),
    ];
    for (result, start) in refusals {
        let line = result.err().ok_or(start)?.to_string();
        assert!(line.contains(start) && !line.contains('\n'), "{line}");
    }
    assert_eq!(fs::read_dir(folder)?.count(), 0);
    Ok(())
}

#[test]
fn extreme_data_draws() -> Checked {
    let folder = tempfile::tempdir()?;
    let folder = folder.path();
    for force_n in [0.0, 1e-300, -3.0, 1e11] {
        let run = trace(force_n);
        let bare = Press { holds: &[], reference: &[], ..press(&run) };
        force_depth(folder, "x", &bare)?;
        force_time(folder, "x", &bare)?;
    }
    let run = trace(0.1);
    let single = Press { trace: &run[..1], ..press(&run) };
    force_depth(folder, "x", &single)?;
    force_time(folder, "x", &single)?;
    for tick_us in [&[0.0_f32; 3][..], &[21.5], &[1e-6, 1e9]] {
        tick_time(folder, "x", &times(tick_us))?;
    }
    let point = [[1.0; 3]; 4];
    let probes = [
        (ProbeShape::Hemisphere, [0.0; 3], 0.0),
        (ProbeShape::Sphere, [-1.0, 0.0, 0.0], 0.02),
        (ProbeShape::Flat, [0.0, 3.0, -4.0], 1e-6),
        (ProbeShape::Capsule { length_m: 0.01, along: [0.0, 1.0, 0.2] }, [0.0, 0.0, 1.0], 0.006),
        (ProbeShape::Capsule { length_m: 0.0, along: [0.0, 0.0, 1.0] }, [0.0, 0.0, 1.0], 0.0),
        (ProbeShape::Ellipsoid { semi_axes_m: [0.012, 0.004], along: [1.0, 1.0, 0.0] }, [0.3, 0.0, 1.0], 0.006),
    ];
    for (shape, axis, radius_m) in probes {
        let probe = Probe { shape, radius_m, axis, ..tet().probe };
        let collapsed = Surface { rest_m: &point, deformed_m: &point, probe, ..tet() };
        surface(folder, "x", &Surface { probe, ..tet() })?;
        surface(folder, "x", &collapsed)?;
    }
    Ok(())
}

#[test]
fn the_budget_is_on_the_axis_only_when_near() -> Checked {
    let folder = tempfile::tempdir()?;
    let drawn = |us: f32| -> Result<bool, Box<dyn Error>> {
        tick_time(folder.path(), "x", &times(&[us, us]))?;
        Ok(fs::read_to_string(folder.path().join("x.svg"))?.contains("budget 1000 µs\n"))
    };
    assert!(!drawn(20.0)?);
    assert!(drawn(600.0)?);
    assert!(drawn(4000.0)?);
    Ok(())
}
