//! Bars, plots and superposed surfaces are complete, labelled and correct, or do not
//! exist at all.

use std::error::Error;
use std::fs;
use std::io::BufReader;
use std::path::Path;

use palpate_charts::{
    Bar, Bars, ChartError, Figure, Form, Landmark, Layer, Level, Look, Plot, Scale, ScaledAxis, Series, Superposed, superposed,
};

type Checked = Result<(), Box<dyn Error>>;

fn bar(name: &str, kind: &str, span: [f64; 2]) -> Bar {
    let (name, kind) = (name.to_owned(), kind.to_owned());
    Bar { name, kind, span, whiskers: Some(span), mark: Some(span[0]), allowed: None, text: String::new() }
}

fn bars(name: &str, bars: Vec<Bar>) -> Figure {
    let form = Form::Bars(Bars { axis: ScaledAxis::linear("error [mm]"), bars });
    Figure { name: name.into(), title: "Error at the landmarks".into(), below: "made up".into(), form }
}

fn curve(name: &str, points: &[(f64, f64)]) -> Series {
    Series::curve(name, points.iter().copied()).marked()
}

fn chart(scale: Scale, series: Vec<Series>) -> Figure {
    let axis = |title: &str| ScaledAxis { title: title.into(), scale };
    let plot = Plot::new(axis("nodes [1]"), axis("time [ms]"), series).levels([Level::new("budget", 1.0)]);
    Figure::plot("lines", "A & B", "made up", plot)
}

/// A tetrahedron whose edges along the axes have the length `m`.
fn tet(m: f64) -> [[f64; 3]; 4] {
    [[0.0; 3], [m, 0.0, 0.0], [0.0, m, 0.0], [0.0, 0.0, m]]
}

const SIDES: [[u32; 3]; 4] = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]];

fn layer<'a>(name: &'a str, nodes_m: &'a [[f64; 3]], look: Look) -> Layer<'a> {
    let color = if look == Look::Solid { [200, 60, 40] } else { [30, 80, 180] };
    Layer { name, nodes_m, triangles: &SIDES, color, look }
}

fn scene<'a>(layers: &'a [Layer<'a>], landmarks: &'a [Landmark<'a>]) -> Superposed<'a> {
    Superposed { title: "rest & pressed", below: "made up", layers, landmarks, eye: [1.0, 0.8, 0.6], up: [0.0, 0.0, 1.0] }
}

fn pixels(path: &Path) -> Result<Vec<u8>, Box<dyn Error>> {
    let mut reader = png::Decoder::new(BufReader::new(fs::File::open(path)?)).read_info()?;
    let mut bytes = vec![0; reader.output_buffer_size().ok_or("too large")?];
    let info = reader.next_frame(&mut bytes)?;
    assert_eq!((info.width, info.height), (1000, 700));
    Ok(bytes)
}

#[track_caller]
fn whole(folder: &Path, name: &str, labels: &[&str]) -> Checked {
    let svg = fs::read_to_string(folder.join(format!("{name}.svg")))?;
    assert!(svg.trim_end().ends_with("</svg>"));
    for label in labels {
        assert!(svg.contains(label), "{name}: {label}");
    }
    let rgb = pixels(&folder.join(format!("{name}.png")))?;
    assert!(rgb.chunks(3).filter(|p| p.iter().all(|v| *v < 120)).count() > 500, "{name}");
    // nothing extends beyond the picture
    let rows: Vec<_> = rgb.chunks(3000).collect();
    assert!(rows.iter().all(|row| row.starts_with(&[255; 15]) && row.ends_with(&[255; 15])), "{name}: ink at a side");
    assert!([rows[0], rows[699]].iter().all(|row| row.iter().all(|v| *v == 255)), "{name}: ink at top or bottom");
    Ok(())
}

#[test]
fn pictures_are_whole_and_labelled() -> Checked {
    let folder = tempfile::tempdir()?;
    let folder = folder.path();
    let shown = ["small", "large"].map(|name| [bar(name, "springs", [0.8, 1.9]), bar(name, "volumes", [0.1, 0.9])]);
    bars("bars", shown.concat()).draw(folder)?;
    whole(folder, "bars", &["error [mm]", "small", "large", "springs", "volumes"])?;

    let series = vec![curve("one", &[(10.0, 0.01), (100.0, 0.2), (3000.0, 9.0)]), curve("two", &[(20.0, 3.0), (500.0, 0.5)])];
    for scale in [Scale::Linear, Scale::Log] {
        chart(scale, series.clone()).draw(folder)?;
        whole(folder, "lines", &["A &amp; B", "nodes [1]", "time [ms]", "one", "two", "budget", "1000"])?;
    }

    let (rest, pressed) = (tet(0.05), tet(0.04));
    let layers = [layer("pressed", &pressed, Look::Solid), layer("at rest", &rest, Look::Wire)];
    superposed(folder, "layers", &scene(&layers, &[Landmark { label: "tip", at_m: [0.0, 0.0, 0.05] }]))?;
    whole(folder, "layers", &["rest &amp; pressed", "pressed", "at rest", "tip", " mm"])?;
    assert_eq!(fs::read_dir(folder)?.count(), 6, "temporary files are left");
    Ok(())
}

#[test]
fn what_is_nearer_hides_what_is_behind() -> Checked {
    let folder = tempfile::tempdir()?;
    let (small, large) = (tet(0.02), tet(0.05));
    let blue = |name: &str, layers: &[Layer]| -> Result<usize, Box<dyn Error>> {
        superposed(folder.path(), name, &scene(layers, &[]))?;
        let rgb = pixels(&folder.path().join(format!("{name}.png")))?;
        let body = rgb.chunks(3000).skip(90).flat_map(|row| row.chunks(3).take(700));
        Ok(body.filter(|p| u32::from(p[2]) > u32::from(p[0]) + 60).count())
    };
    let solid = |name, nodes_m, color| Layer { color, ..layer(name, nodes_m, Look::Solid) };
    let (red_small, red_large) = (solid("red", &small, [220, 40, 30]), solid("red", &large, [220, 40, 30]));
    let blue_small = solid("blue", &small, [30, 40, 220]);
    // the same solid inside the large one is hidden, in whichever order the two are given
    assert_eq!(blue("inside", &[red_large, blue_small])?, blue("first", &[blue_small, red_large])?);
    let hidden: Vec<[f64; 3]> = small.iter().map(|p| [p[0] * 0.3 + 0.004, p[1] * 0.3 + 0.004, p[2] * 0.3 + 0.004]).collect();
    assert_eq!(blue("hidden", &[solid("blue", &hidden, [30, 40, 220]), red_large])?, 0);
    let before: Vec<[f64; 3]> = small.iter().map(|p| [p[0] + 0.05, p[1] + 0.04, p[2] + 0.03]).collect();
    assert!(blue("before", &[solid("blue", &before, [30, 40, 220]), red_small])? > 1000);
    Ok(())
}

#[test]
fn bars_stand_where_their_values_are() -> Checked {
    let folder = tempfile::tempdir()?;
    let columns_of_ink = |span: [f64; 2]| -> Result<Vec<usize>, Box<dyn Error>> {
        bars("x", vec![bar("a", "x", span), bar("b", "y", [0.0, 10.0])]).draw(folder.path())?;
        let rgb = pixels(&folder.path().join("x.png"))?;
        // a column counts if it contains the blue of the first kind, left of the legend
        let blue = |p: &[u8]| u32::from(p[2]) > u32::from(p[0]) + 60;
        let column = |x: &usize| rgb.chunks(3000).any(|row| blue(&row[3 * x..3 * x + 3]));
        Ok((0..880).filter(column).collect())
    };
    let (low, high) = (columns_of_ink([1.0, 3.0])?, columns_of_ink([7.0, 9.0])?);
    let (low, high) = ((low[0], low[low.len() - 1]), (high[0], high[high.len() - 1]));
    // 6 units farther with the same length: the axis is linear
    assert!(low.1 < high.0 && (low.1 - low.0).abs_diff(high.1 - high.0) <= 2, "{low:?} {high:?}");
    let unit = (low.1 - low.0) as f64 / 2.0;
    assert!(((high.0 - low.0) as f64 / unit - 6.0).abs() < 0.3, "{low:?} {high:?}");
    Ok(())
}

#[test]
fn what_cannot_be_drawn_is_refused_and_leaves_nothing() -> Checked {
    let folder = tempfile::tempdir()?;
    let folder = folder.path();
    let good = tet(0.05);
    let mut bad = good;
    bad[2][1] = f64::NAN;
    let shape = |nodes_m| [layer("organ", nodes_m, Look::Wire)];
    let refusals: Vec<(Result<(), ChartError>, &str)> = vec![
        (bars("x", Vec::new()).draw(folder), "bars is empty"),
        (bars("x", vec![bar("all", "ours", [1.0, f64::NAN])]).draw(folder), "\"all ours\": values[1] is NaN"),
        (chart(Scale::Linear, Vec::new()).draw(folder), "series is empty"),
        (chart(Scale::Linear, vec![curve("ours", &[])]).draw(folder), "series is empty"),
        (chart(Scale::Linear, vec![curve("ours", &[(0.0, f64::INFINITY)])]).draw(folder), "\"ours\": y[0] is inf"),
        (
            chart(Scale::Log, vec![curve("ours", &[(1.0, 1.0), (0.0, 1.0)])]).draw(folder),
            "x[1] is 0, which cannot be drawn: a log",
        ),
        (superposed(folder, "x", &scene(&[], &[])), "layers is empty"),
        (superposed(folder, "x", &scene(&shape(&good[..3]), &[])), "triangles[1] names node 3"),
        (superposed(folder, "x", &scene(&shape(&bad), &[])), "\"organ\": nodes_m (x, y, z in turn)[7] is NaN"),
        (superposed(folder, "x", &Superposed { eye: [0.0; 3], ..scene(&shape(&good), &[]) }), "length of eye and up"),
    ];
    for (result, says) in refusals {
        let line = result.err().ok_or(says)?.to_string();
        assert!(line.contains(says) && !line.contains('\n'), "{line}");
    }
    assert_eq!(fs::read_dir(folder)?.count(), 0);
    Ok(())
}

#[test]
fn extreme_data_draws() -> Checked {
    let folder = tempfile::tempdir()?;
    let folder = folder.path();
    for value in [0.0, -3.0, 1e-9, 1e11] {
        let name = "a long label that has no room beside its only bar";
        bars("x", vec![bar(name, "x", [value, value])]).draw(folder)?;
        chart(Scale::Linear, vec![curve("x", &[(value, value)])]).draw(folder)?;
    }
    let name = "a name much longer than the column beside the plot has room for";
    chart(Scale::Log, vec![curve(name, &[(1e-9, 1e9), (1e9, 1e-9)])]).draw(folder)?;
    let point = [[1.0; 3]; 4];
    for (eye, up) in [([0.0, 0.0, 1.0], [0.0, 0.0, 1.0]), ([0.0, -2.0, 0.0], [0.0, 0.0, 1.0])] {
        for nodes in [point, tet(0.05)] {
            for look in [Look::Solid, Look::Wire] {
                superposed(folder, "x", &Superposed { eye, up, ..scene(&[layer("x", &nodes, look)], &[]) })?;
            }
        }
    }
    Ok(())
}
