//! demo
use palpate_charts::{Moment, Probe, ProbeShape, Section, section};
fn main() {
    let (nx, nz) = (17usize, 9usize);
    let h = 0.08 / (nx - 1) as f64;
    let id = |i: usize, j: usize, k: usize| ((i * nx + j) * nz + k) as u32;
    let mut rest = vec![];
    for i in 0..nx {
        for j in 0..nx {
            for k in 0..nz {
                let jig = |a: usize, n: usize, s: usize| {
                    if a == 0 || a == n - 1 { 0.0 } else { 0.3 * h * ((i * 7 + j * 13 + k * 29 + s * 5) as f64).sin() }
                };
                rest.push([
                    -0.04 + i as f64 * h + jig(i, nx, 1),
                    -0.04 + j as f64 * h + jig(j, nx, 2),
                    -(k as f64) * h + jig(k, nz, 3),
                ]);
            }
        }
    }
    let mut tets = vec![];
    let mut tris = vec![];
    for i in 0..nx - 1 {
        for j in 0..nx - 1 {
            for k in 0..nz - 1 {
                let c = |a: usize, b: usize, d: usize| id(i + a, j + b, k + d);
                for p in [
                    [[1, 0, 0], [1, 1, 0]],
                    [[1, 0, 0], [1, 0, 1]],
                    [[0, 1, 0], [1, 1, 0]],
                    [[0, 1, 0], [0, 1, 1]],
                    [[0, 0, 1], [1, 0, 1]],
                    [[0, 0, 1], [0, 1, 1]],
                ] {
                    tets.push([c(0, 0, 0), c(p[0][0], p[0][1], p[0][2]), c(p[1][0], p[1][1], p[1][2]), c(1, 1, 1)]);
                }
            }
        }
    }
    for i in 0..nx - 1 {
        for j in 0..nx - 1 {
            tris.push([id(i, j, 0), id(i + 1, j, 0), id(i + 1, j + 1, 0)]);
            tris.push([id(i, j, 0), id(i + 1, j + 1, 0), id(i, j + 1, 0)]);
            let b = nz - 1;
            tris.push([id(i, j, b), id(i + 1, j + 1, b), id(i + 1, j, b)]);
            tris.push([id(i, j, b), id(i, j + 1, b), id(i + 1, j + 1, b)]);
        }
    }
    let fixed: Vec<bool> = rest.iter().map(|x| x[2] < -0.0399).collect();
    let dent = |d: f64| -> Vec<[f64; 3]> {
        rest.iter()
            .map(|x| {
                let r = (x[0] * x[0] + x[1] * x[1]).sqrt();
                let u = d / (1.0 + (r / 0.007).powi(2)) * (1.0 + x[2] / 0.04) * (-(-x[2]) / 0.03f64).exp();
                [x[0], x[1], x[2] - u]
            })
            .collect()
    };
    let probe = |d: f64| Probe { shape: ProbeShape::Hemisphere, radius_m: 0.008, tip_m: [0.0, 0.0, -d], axis: [0.0, 0.0, 1.0] };
    let (a, b) = (dent(0.002), dent(0.004));
    let moments = [
        Moment { deformed_m: &rest, probe: probe(0.0), depth_m: 0.0, force_n: 0.0 },
        Moment { deformed_m: &a, probe: probe(0.002), depth_m: 0.002, force_n: 0.049 },
        Moment { deformed_m: &b, probe: probe(0.004), depth_m: 0.004, force_n: 0.140 },
    ];
    let s = Section {
        scene: "block",
        caption: "410 nodes; tissue and finger are cut in half through the place that is pressed",
        rest_m: &rest,
        tets: &tets,
        triangles: &tris,
        fixed: &fixed,
        balls_m: &[([0.0, 0.0, -0.018], 0.006)],
        moments: &moments,
    };
    section(std::path::Path::new("/tmp"), "section_demo", &s).unwrap();
}
