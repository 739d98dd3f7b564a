use std::vec::Vec;

use super::*;
use crate::patch::WordAligned;

static LIVER: &WordAligned<[u8]> = &WordAligned(*include_bytes!("../../../../patches/liver-m4f-168.patch"));

fn checked(change: impl FnOnce(&mut PatchFile<'_>)) -> Result<usize, &'static str> {
    let mut file = PatchFile::open(&LIVER.0).unwrap();
    change(&mut file);
    check(&file).map_err(|error| match error {
        BuildError::OutOfRange { parameter, .. } => parameter,
        error => panic!("{error}"),
    })
}

/// Outward normals of the triangles with a corner within reach of the site; the length of each is
/// twice the triangle's area [m^2].
fn normals_m2(file: &PatchFile<'_>) -> Vec<Vector3<f32>> {
    let at_m = |node: u16| Vector3::from(file.model.nodes[usize::from(node)].rest_m);
    let near = |node: &u16| (at_m(*node) - file.site_m).norm() < file.params.probe.radius_m;
    let triangles = file.model.triangles.iter().filter(|triangle| triangle.node.iter().any(near));
    triangles.map(|triangle| triangle.node.map(at_m)).map(|[a, b, c]| (b - a).cross(&(c - a))).collect()
}

#[test]
fn the_triangles_in_reach_are_those_with_a_corner_within_the_probes_radius() {
    let file = PatchFile::open(&LIVER.0).unwrap();
    let all = normals_m2(&file).len();
    assert_eq!(checked(|_| ()), Ok(all));
    let mut counts = std::vec![all];
    for times in [0.6, 1.5, 2.5] {
        let mut other = file;
        other.params.probe.radius_m *= times;
        counts.push(normals_m2(&other).len());
        let said = checked(|file| file.params.probe.radius_m *= times);
        assert_eq!(said, if counts.last() == Some(&0) { Err(SITE) } else { Ok(*counts.last().unwrap()) }, "{times}");
    }
    counts.dedup();
    assert!(counts.len() > 2, "{counts:?}");
    assert_eq!(checked(|file| file.site_m += file.params.probe.axis * 0.1), Err(SITE));
}

#[test]
fn an_axis_is_a_unit_vector_to_ten_parts_in_a_million() {
    for (off, taken) in [(3e-6, true), (-3e-6, true), (8e-6, false), (-8e-6, false)] {
        let said = checked(|file| file.params.probe.axis = file.params.probe.axis.normalize() * (1.0 + off));
        assert_eq!(said.err(), if taken { None } else { Some(AXIS_LENGTH) }, "{off}");
    }
}

#[test]
fn an_axis_points_out_of_the_surface() {
    let file = PatchFile::open(&LIVER.0).unwrap();
    let out: Vector3<f32> = normals_m2(&file).iter().sum::<Vector3<f32>>().normalize();
    let along = out.cross(&Vector3::x()).normalize();
    for tangent in [along, -along, out.cross(&along), along.cross(&out)] {
        for (degrees, taken) in [(0.0_f32, true), (85.0, true), (95.0, false), (180.0, false)] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let said = checked(|file| {
                file.params.probe.axis = (out * cos + tangent * sin).normalize();
                file.model.depth_limit_m = 1e-5;
            });
            assert_eq!(said.err(), if taken { None } else { Some(AXIS) }, "{degrees} degrees");
        }
    }
}

#[test]
fn the_depth_limit_stays_above_the_deepest_node() {
    let file = PatchFile::open(&LIVER.0).unwrap();
    let depth_m = |node: &palpate::NodeRest| (file.site_m - Vector3::from(node.rest_m)).dot(&file.params.probe.axis);
    let deepest_m = file.model.nodes.iter().map(depth_m).fold(0.0, f32::max);
    assert!(deepest_m > 5e-3, "{deepest_m}");
    for (limit_m, taken) in [(0.999 * deepest_m, true), (1.001 * deepest_m, false), (-1e-6, false)] {
        let said = checked(|file| file.model.depth_limit_m = limit_m);
        assert_eq!(said.err(), if taken { None } else { Some(DEPTH) }, "{limit_m} m");
    }
}

#[test]
fn elsewhere_on_the_surface_a_probe_reaches_more_triangles_than_at_the_site() {
    static BLOCK: &WordAligned<[u8]> = &WordAligned(*include_bytes!("../../../../patches/block-m4f-168.patch"));
    for (bytes, at_site, anywhere) in [(BLOCK, 12, 15), (LIVER, 20, 22)] {
        let mut file = PatchFile::open(&bytes.0).unwrap();
        let mut rounds = 0;
        assert_eq!((check(&file), most_in_reach(&file, &mut || rounds += 1)), (Ok(at_site), anywhere));
        assert_eq!(rounds, 28 * file.model.triangles.len(), "the watchdog is fed after each place");
        file.params.probe.radius_m = 1.0;
        assert_eq!(most_in_reach(&file, &mut || {}), file.model.triangles.len());
    }
}
