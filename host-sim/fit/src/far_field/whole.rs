//! Meshes the whole organ, with small elements at the site and large ones far away.
//!
//! The lattice of [`palpate_tissue::organ`] is aligned with the surface at the site and grows away
//! from it. It is cut to the shape of the organ: a built-in one, or the surface of a mesh file,
//! whose own elements may be larger than the patch. Surface nodes are exactly on the shape.

use nalgebra::Vector3;

use super::Sizes;
use palpate_tissue::error::Error;
use palpate_tissue::mesh::{TetMesh, block_with_rim};
use palpate_tissue::organ::{Fine, MEAN_EDGE, OrganError, Turned};
use palpate_tissue::scene::{Scene, SceneError};
use palpate_tissue::tissue::organ::THROUGH;
use palpate_tissue::tissue::organ_source::{OrganSource, Site};
use palpate_tissue::tissue::{Placed, on_shape, place_block};

/// Factor by which the size of the coarsest elements is reduced if the lattice tears the organ, or
/// the organ is thinner than they are, and the maximum number of such attempts.
const LESS: f64 = 0.7;
const TRIES: u32 = 8;
/// Largest allowed share of the organ's volume in the patch (1).
const MOST_SHARE: f64 = 0.5;

/// Meshes the tissue of a scene around its site. Edges are about `fine_m` long within
/// `fine_radius_m` of the site, grow to the length that `growth` gives at the edge of the patch,
/// and are everywhere short enough for two elements through the organ under the site. If the mesh
/// would still tear where the organ is thin, the coarsest elements are made smaller, and in the end
/// those of `fine_m` too. A block has the mesh of [`block_with_rim`].
///
/// # Errors
/// Fails, with a remedy, if the scene has no tissue, if the sizes are invalid, if the site is
/// further than a probe radius from the surface, if the patch would contain more than half of the
/// organ or all of its supports, or if the organ has no support.
pub fn whole(scene: &Scene, tips_m: &[[f32; 3]], sizes: &Sizes) -> Result<Placed, Error> {
    if let Some(size_m) = scene.tissue.block_m {
        check(scene, sizes)?;
        let mesh = block_with_rim(size_m, scene.probe.position_m.unwrap_or_default(), sizes, 0)
            .map_err(|cause| Error::Usage(format!("{}: {cause}", scene.file)))?;
        return place_block(scene, tips_m, mesh);
    }
    whole_of(scene, tips_m, sizes, &shape_of(scene)?)
}

/// The shape of a scene's organ. A large file takes seconds to read, so that a search for the right
/// sizes reads it once.
///
/// # Errors
/// Fails if the scene has no organ, or if its file is refused.
pub fn shape_of(scene: &Scene) -> Result<OrganSource, Error> {
    match OrganSource::of(scene)? {
        Some(shape) => Ok(shape),
        None => Ok(scene.bad("solver.patch", "has no organ behind it: give tissue.block_m, tissue.mesh or tissue.organ")?),
    }
}

/// Meshes a shape as [`whole`] does.
///
/// # Errors
/// Errors of [`whole`].
pub fn whole_of(scene: &Scene, tips_m: &[[f32; 3]], sizes: &Sizes, shape: &OrganSource) -> Result<Placed, Error> {
    check(scene, sizes)?;
    let site = shape.near_site(scene)?;
    let mesh = graded(scene, shape, &site, sizes)?;
    let placed = on_shape(scene, tips_m, shape, mesh, (site.at_m, site.axis))?;
    refuse_swallowed(scene, &placed, sizes)?;
    Ok(placed)
}

/// Distance between two points [m].
#[must_use]
pub fn distance_m(a_m: [f64; 3], b_m: [f64; 3]) -> f64 {
    (Vector3::from(b_m) - Vector3::from(a_m)).norm()
}

fn check(scene: &Scene, sizes: &Sizes) -> Result<(), Error> {
    let lengths = [("radius", sizes.radius_m), ("fine edge", sizes.fine_m), ("fine radius", sizes.fine_radius_m)];
    for (what, value) in lengths {
        if !(1e-4..=1.0).contains(&value) {
            return Err(Error::Usage(format!("{}: the patch's {what} is {value} m: give 0.0001 to 1 m", scene.file)));
        }
    }
    if !(0.0..=10.0).contains(&sizes.growth) {
        return Err(Error::Usage(format!("{}: the growth around the patch is {}: give 0 to 10", scene.file, sizes.growth)));
    }
    Ok(())
}

fn graded(scene: &Scene, shape: &OrganSource, site: &Site, sizes: &Sizes) -> Result<TetMesh, Error> {
    let mut spacing_m = sizes.fine_m / MEAN_EDGE;
    let mut coarsest_m = (shape.thickness_m(site) / THROUGH).max(spacing_m);
    let mut tries = 0;
    loop {
        let fine = Fine { at_m: site.at_m, radius_m: sizes.fine_radius_m, spacing_m, growth: lattice_growth(sizes) };
        let turned = Turned { fine, axis: site.axis, coarsest_m };
        match shape.mesh(&turned) {
            Err(OrganError::Empty { .. } | OrganError::TooCoarse { .. } | OrganError::Inverted { .. }) if tries < TRIES => {
                coarsest_m *= LESS;
                spacing_m = spacing_m.min(coarsest_m);
                tries += 1;
            }
            other => return other.map_err(|cause| Error::Usage(format!("{}: {cause}", scene.file))),
        }
    }
}

/// Growth of the lattice, as [`Fine`] defines it, for which an element at the edge of the patch has
/// the volume of an element whose edges have grown by `growth` per distance. The two growths differ
/// because the lattice grows more along a ray than across it.
fn lattice_growth(sizes: &Sizes) -> f64 {
    let ratio = (sizes.radius_m / sizes.fine_radius_m).max(1.5);
    let wanted = 1.0 + sizes.growth * sizes.fine_radius_m * (ratio - 1.0) / sizes.fine_m;
    let stretch = |growth: f64| {
        // w is the solution of 1 + w + g (w^2 + w^3/3) = ratio
        let (mut low, mut high) = (0.0, ratio - 1.0);
        for _ in 0..60 {
            let w = 0.5 * (low + high);
            if 1.0 + w + growth * w * w * (1.0 + w / 3.0) < ratio { low = w } else { high = w }
        }
        let along = 1.0 + growth * low * (2.0 + low);
        (along * (ratio / (1.0 + low)).powi(2)).cbrt()
    };
    let (mut low, mut high) = (0.0, 100.0);
    for _ in 0..60 {
        let growth = 0.5 * (low + high);
        if stretch(growth) < wanted { low = growth } else { high = growth }
    }
    low
}

fn refuse_swallowed(scene: &Scene, placed: &Placed, sizes: &Sizes) -> Result<(), SceneError> {
    let (mesh, site_m) = (&placed.tissue.mesh, placed.tissue.site_m);
    let from_site_m = |x: [f64; 3]| distance_m(site_m, x);
    let mut parts: Vec<(f64, f64)> = mesh
        .tets
        .iter()
        .map(|tet| {
            let [a, b, c, d] = tet.map(|n| Vector3::from(mesh.nodes_m[n as usize]));
            (from_site_m(((a + b + c + d) / 4.0).into()), (b - a).cross(&(c - a)).dot(&(d - a)) / 6.0)
        })
        .collect();
    parts.sort_by(|a, b| a.0.total_cmp(&b.0));
    let whole_m3: f64 = parts.iter().map(|p| p.1).sum();
    let mut sum_m3 = 0.0;
    let fits = parts.iter().take_while(|p| {
        sum_m3 += p.1;
        sum_m3 <= MOST_SHARE * whole_m3
    });
    let by_volume_m = fits.last().map_or(0.0, |p| p.0);
    // at least one support of the organ must remain outside the patch
    let furthest_m = placed.tissue.anchors.iter().map(|n| from_site_m(mesh.nodes_m[*n as usize])).fold(0.0, f64::max);
    let largest_m = by_volume_m.min(furthest_m);
    if sizes.radius_m < largest_m {
        return Ok(());
    }
    let why = format!(
        "around the site would be cut out of an organ of {:.1} cm^3, {}: give a radius of at most {:.4} m",
        whole_m3 * 1e6,
        if by_volume_m <= furthest_m { "more than half of it" } else { "with all that holds it" },
        // the mesh, and with it the limit, changes slightly with the radius
        0.95 * largest_m
    );
    scene.bad(&format!("a patch of {:.4} m", sizes.radius_m), &why)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_lattices_growth_gives_the_volume_asked_for_at_the_edge_of_the_patch() {
        for growth in [0.0, 0.1, 0.45, 1.0] {
            let sizes = Sizes { radius_m: 0.017, fine_m: 0.0046, fine_radius_m: 0.008, growth };
            let g = lattice_growth(&sizes);
            // distance after the growth, as the documentation of the lattice defines it
            let after = |rho: f64| {
                let w = rho / 0.008 - 1.0;
                0.008 * (1.0 + w + g * (w * w + w * w * w / 3.0))
            };
            let (mut low, mut high) = (0.008, 0.017);
            for _ in 0..60 {
                let rho = 0.5 * (low + high);
                if after(rho) < 0.017 { low = rho } else { high = rho }
            }
            let slope = (after(low + 1e-7) - after(low - 1e-7)) / 2e-7;
            let edge = (slope * (0.017 / low).powi(2)).cbrt();
            assert!((edge - 1.0 - growth * 0.009 / 0.0046).abs() < 1e-5, "{growth}: {edge}");
        }
    }
}
