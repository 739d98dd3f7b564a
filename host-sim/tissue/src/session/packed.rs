//! Reads a packed patch, which replaces a patch built from the scene and must match the scene.

use std::path::Path;

use palpate::{BuildError, Params, PatchFile, Probe, ProbeShape, Vector3};

use crate::error::Error;
use crate::fit_record::{FitRecord, OrganRecord};
use crate::patch::Patch;
use crate::scene::{Scene, SceneError, Tip};

/// Largest difference between the packed tissue and the scene's, as a share of the block's side or
/// of the probe's radius (1): well above the rounding to single precision.
const ROUNDING: f64 = 1e-4;

/// Reads a patch file, with the parameters that it was packed with.
pub(super) fn open(scene: &Scene, path: &Path) -> Result<(Patch, Params), Error> {
    let bytes = std::fs::read(path).map_err(|source| Error::Read { path: path.into(), source })?;
    let in_file = |cause| Error::Patch { path: path.into(), cause };
    let words = words(&bytes);
    let file = PatchFile::open(&bytemuck::cast_slice(&words)[..bytes.len()]).map_err(in_file)?;
    file.model.check().map_err(in_file)?;
    if let Some(cause) = FitRecord::unreadable(path) {
        let why = format!(
            "= {}: the record beside it (.patch.json) cannot be read ({cause}): fit the patch again with this palpate, or remove the record",
            path.display()
        );
        scene.bad("solver.patch", &why)?;
    }
    let record = FitRecord::of_file(path);
    let mut patch = Patch::of_file(&file);
    // a patch answers at least as deep as it was judged
    let judged_m = record.as_ref().map_or(0.0, |record| record.judged.to_m);
    patch.set_depth_limit_m(file.model.depth_limit_m.max(judged_m as f32));
    let disc_m = record.as_ref().map_or(0.0, |record| record.judged.disc_radius_m);
    agree(scene, path, &file, disc_m)?;
    scene.refuse_deeper_than(f64::from(patch.model().depth_limit_m), &format!("{} answers", path.display()))?;
    if let Some([x, y]) = scene.probe.position_m {
        patch.set_site_m([x, y, file.site_m.z.into()]);
    }
    if let Some(offset_m) = offset_on_its_organ(scene, path, record.as_ref())? {
        let missed = || {
            let why = format!("= {:?} is beside the surface of {}", scene.probe.site.unwrap_or_default(), path.display());
            scene.bad::<()>("probe.site", &why).unwrap_err()
        };
        patch.set_site_m(on_surface(&file, offset_m).ok_or_else(missed)?);
    }
    agree_with_its_inclusions(scene, path, record.as_ref())?;
    if file.model.law.is_some() && file.model.springs.is_empty() {
        agree_with_its_stiffening(scene, path, record.as_ref())?;
    }
    Ok((patch, file.params))
}

/// Checks that a scene leaves the stiffening to the law, which contains that of its fit, or states
/// the same.
fn agree_with_its_stiffening(scene: &Scene, path: &Path, record: Option<&FitRecord>) -> Result<(), SceneError> {
    let (b, fitted_b) = (scene.tissue.stiffening_b, record.map_or(0.0, |record| record.tissue.stiffening_b));
    if b == 0.0 || b == fitted_b {
        return Ok(());
    }
    let why = format!("= {b}, but {} holds a law of tissue with {fitted_b}: leave it out, or fit the law again", path.display());
    scene.bad("tissue.stiffening_b", &why)
}

/// The outermost point of the patch's surface along the press, through its site shifted by
/// `offset_m` [m]; `None` beside the surface.
fn on_surface(file: &PatchFile, offset_m: Vector3<f64>) -> Option<[f64; 3]> {
    let axis: Vector3<f64> = file.params.probe.axis.cast();
    let through_m = file.site_m.cast::<f64>() + offset_m;
    let height_m = |triangle: &palpate::Triangle| {
        let [a, b, c] = triangle.node.map(|n| Vector3::from(file.model.nodes[usize::from(n)].rest_m).cast::<f64>() - through_m);
        // the line of the press passes the triangle if it is on one side of all edges
        let [u, v, w] = [(b, c), (c, a), (a, b)].map(|(p, q)| p.cross(&q).dot(&axis));
        let sum = u + v + w;
        let inside = sum > 0.0 && [u, v, w].iter().all(|part| *part >= -1e-9 * sum);
        inside.then(|| (a * u + b * v + c * w).dot(&axis) / sum)
    };
    let highest_m = file.model.triangles.iter().filter_map(height_m).reduce(f64::max)?;
    Some((through_m + axis * highest_m).into())
}

/// Reads a patch and the parameters that it was packed with, from bytes that came with the program.
pub fn unpack(bytes: &[u8]) -> Result<(Patch, Params), BuildError> {
    let words = words(bytes);
    let file = PatchFile::open(&bytemuck::cast_slice(&words)[..bytes.len()])?;
    file.model.check()?;
    Ok((Patch::of_file(&file), file.params))
}

/// Copies bytes to a 4-byte boundary, where the core reads a patch in place.
fn words(bytes: &[u8]) -> Vec<u32> {
    let mut words = vec![0_u32; bytes.len().div_ceil(4)];
    bytemuck::cast_slice_mut(&mut words)[..bytes.len()].copy_from_slice(bytes);
    words
}

/// Checks that each value that is in both the file and the scene is the same in both.
fn agree(scene: &Scene, path: &Path, file: &PatchFile, disc_m: f64) -> Result<(), SceneError> {
    let path = path.display();
    let packed = file.model.poisson_ratio;
    if scene.tissue.poisson_ratio as f32 != packed {
        let why = format!("= {}, but {path} was packed for {packed}: use that or pack it again", scene.tissue.poisson_ratio);
        return scene.bad("tissue.poisson_ratio", &why);
    }
    // a patch with a far field is smaller than the tissue that it represents
    let whole = file.model.rim_nodes.is_empty();
    for (axis, side) in scene.tissue.block_m.iter().filter(|_| whole).flatten().enumerate() {
        let (low, high) =
            file.model.nodes.iter().fold((f32::MAX, f32::MIN), |(l, h), n| (l.min(n.rest_m[axis]), h.max(n.rest_m[axis])));
        let packed = f64::from(high - low);
        if (packed - side).abs() > ROUNDING * side {
            let why = format!("= {side}, but {path} is {packed:.6} there: use that or pack it again");
            return scene.bad(&format!("tissue.block_m[{axis}]"), &why);
        }
    }
    if !whole || file.model.law.is_some() {
        agree_with_its_fit(scene, &path.to_string(), file)?;
    }
    if file.model.law.is_some() && file.model.springs.is_empty() {
        scene.refuse_what_a_law_lacks(&format!("{path} holds a law"))?;
    }
    let Some([x, y]) = scene.probe.position_m else { return Ok(()) };
    let [own_x, own_y] = [file.site_m.x, file.site_m.y].map(f64::from);
    if (x - own_x).hypot(y - own_y) > disc_m + ROUNDING * scene.probe.radius_m {
        let why = format!(
            "= [{x}, {y}], but {path} is made for [{own_x:.6}, {own_y:.6}] and {disc_m} m around it: use that or pack it again"
        );
        return scene.bad("probe.position_m", &why);
    }
    Ok(())
}

/// Checks a scene that has both an organ and a patch: by the record beside it, the patch must be a
/// piece of that organ, judged around the scene's site. Returns the offset of that site from the
/// fitted one, across the press [m].
fn offset_on_its_organ(scene: &Scene, path: &Path, record: Option<&FitRecord>) -> Result<Option<Vector3<f64>>, SceneError> {
    if let Some(mesh) = scene.tissue.mesh.as_ref().filter(|mesh| !mesh.is_file()) {
        let why = format!("= {} is not there: check the path, or leave it out, the patch needs it no more", mesh.display());
        return scene.bad("tissue.mesh", &why);
    }
    let Some(own) = OrganRecord::of(scene) else { return Ok(None) };
    let Some((record, fitted)) = record.and_then(|record| Some((record, record.organ.as_ref()?))) else {
        let why = format!(
            "= {} has no record beside it (.patch.json) that says which organ it is a piece of: remove the scene's organ or mesh, or fit it again",
            path.display()
        );
        return scene.bad("solver.patch", &why);
    };
    if let Some((key, was)) = own.first_difference(fitted, record.judged.disc_radius_m) {
        return scene.bad(key, &format!("is not what {} was fitted to ({was}): use that, or fit it again", path.display()));
    }
    let offset_m = Vector3::from(own.site_m) - Vector3::from(fitted.site_m);
    Ok((offset_m.norm() > 0.0).then_some(offset_m))
}

/// Checks the inclusions of a scene against those that its patch of a block was fitted with. They
/// are part of the patch's constants: a scene can neither leave them out nor move them.
fn agree_with_its_inclusions(scene: &Scene, path: &Path, record: Option<&FitRecord>) -> Result<(), SceneError> {
    let Some(record) = record else { return Ok(()) };
    let fitted = &record.tissue.inclusion;
    if record.judged.bump.is_none() || *fitted == scene.tissue.elastic_inclusions() {
        return Ok(());
    }
    let balls = fitted.iter().map(|ball| format!("{:?}, {} m, {} times", ball.center_m, ball.radius_m, ball.stiffness_ratio));
    let why = format!(
        "is not what {} was fitted with ({}): write that, or fit the scene anew",
        path.display(),
        balls.collect::<Vec<_>>().join("; ")
    );
    scene.bad("tissue.inclusion", &why)
}

/// Whether two probes are the same. The directions of long tips are compared with a tolerance,
/// since they were rounded together with the axis.
fn same_tip(packed: &Probe, own: &Probe) -> bool {
    let near = |a: &Vector3<f32>, b: &Vector3<f32>| (a - b).norm() < 1e-5;
    let same = match (packed.shape, own.shape) {
        (ProbeShape::Capsule { length_m, along }, ProbeShape::Capsule { length_m: length, along: way }) => {
            length_m == length && near(&along, &way)
        }
        (ProbeShape::Ellipsoid { semi_axes_m, along }, ProbeShape::Ellipsoid { semi_axes_m: axes, along: way }) => {
            semi_axes_m == axes && near(&along, &way)
        }
        (packed, own) => packed == own,
    };
    same && packed.radius_m == own.radius_m
}

/// Checks a patch with a far field against the scene. It represents the organ, the probe and the
/// inclusions that it was cut and fitted with; the organ itself is not in the file.
fn agree_with_its_fit(scene: &Scene, path: &str, file: &PatchFile) -> Result<(), SceneError> {
    let packed = file.params.probe;
    let own = scene.params(packed.axis.map(f64::from).into()).probe;
    if !same_tip(&packed, &own) {
        let why = format!("is not the one {path} was fitted with ({}): use that or pack it again", Tip::of_core(&packed));
        return scene.bad("probe", &why);
    }
    if scene.tissue.gravity_m_per_s2 != [0.0; 3] {
        return scene.bad(
            "tissue.gravity_m_per_s2",
            &format!("is not zero, but the far field of {path} carries no weight: leave it out"),
        );
    }
    if !scene.tissue.inclusion.is_empty() {
        return scene.bad(
            "tissue.inclusion",
            &format!("cannot be put into {path}, which brings those it was packed with: leave it out or pack it again"),
        );
    }
    Ok(())
}
