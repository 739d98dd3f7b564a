//! Refuses scenes that cannot be fitted, before anything is solved.

use palpate_tissue::error::Error;
use palpate_tissue::scene::{Drive, Scene};
use palpate_tissue::tissue::DEPTH_MARGIN;

/// Largest allowed Poisson's ratio; beyond it the finite elements lock.
const MOST_POISSON_RATIO: f64 = 0.495;
/// Smallest allowed Young's modulus [Pa]; fat and brain have a few hundred.
const SOFTEST_PA: f64 = 100.0;
/// Largest allowed width of the probe, as a share of the block's shorter side (1).
const WIDEST: f64 = 1.0 / 3.0;
/// Largest allowed depth of a press, as a share of the block's thickness (1).
const DEEPEST: f64 = 0.5;

/// Refuses a scene that cannot be fitted, and values that are probably given in another unit.
///
/// # Errors
/// Returns the first such value, with its key.
pub fn check(scene: &Scene) -> Result<(), Error> {
    scene.refuse_what_no_file_has()?;
    let tissue = &scene.tissue;
    if tissue.gravity_m_per_s2 != [0.0; 3] {
        return Ok(scene.bad("tissue.gravity_m_per_s2", "is not zero: a fit has no weight, leave it out here")?);
    }
    if tissue.poisson_ratio > MOST_POISSON_RATIO {
        let why =
            format!("= {}: the finite elements stay exact to {MOST_POISSON_RATIO} only: give at most that", tissue.poisson_ratio);
        return Ok(scene.bad("tissue.poisson_ratio", &why)?);
    }
    let e_pa = tissue.youngs_modulus_pa;
    if e_pa < SOFTEST_PA {
        let why = format!("= {e_pa} Pa is softer than any tissue ({SOFTEST_PA} Pa): give pascals; {e_pa} kPa is {}", e_pa * 1e3);
        return Ok(scene.bad("tissue.youngs_modulus_pa", &why)?);
    }
    // the force on a half-space, which is less than on any block
    let plane = 1.0 / (1.0 - tissue.poisson_ratio * tissue.poisson_ratio);
    refuse_beyond_the_guard(scene, |depth_m| scene.probe.tip().half_space_m2(plane, depth_m))
}

/// Refuses a block that is too small for its probe, or that is pressed too deep.
///
/// # Errors
/// Returns the first such value, with its key.
pub fn check_block(scene: &Scene, size_m: [f64; 3]) -> Result<(), Error> {
    let probe = &scene.probe;
    let [x, y, thick_m] = size_m;
    let (wide_m, side_m) = (2.0 * probe.tip().reach_m(), x.min(y));
    if wide_m > WIDEST * side_m {
        let (key, given) = match probe.shape.is_round() {
            true => ("probe.radius_m", format!("= {}", probe.radius_m)),
            false => ("probe", probe.tip().to_string()),
        };
        let why = format!(
            "{given}: the probe is wider ({wide_m} m) than a third of the block ({side_m} m): give metres, a probe of at most {:.4} m, or a wider block",
            0.5 * WIDEST * side_m
        );
        return Ok(scene.bad(key, &why)?);
    }
    // the presses of a fit use the two planes of symmetry of the block
    if let Some(along) = probe.shape.along().filter(|_| probe.shape.mirrors() != [true; 2]) {
        let why = format!("= {along:?} lies along neither side of the block: give [1.0, 0.0, 0.0] or [0.0, 1.0, 0.0]");
        return Ok(scene.bad("probe.along", &why)?);
    }
    if probe.position_m.is_some_and(|at| at != [0.0; 2]) {
        return Ok(scene.bad("probe.position_m", "is off the centre, over which a fit is spread: leave it out")?);
    }
    scene.refuse_deeper_than(DEEPEST * thick_m, "half the block is thick")?;
    if let Drive::Force { .. } = scene.drive
        && DEPTH_MARGIN * probe.radius_m > thick_m
    {
        return Ok(scene.bad("drive.kind", "gives no depth, and the block is thin for this probe: use \"depth\"")?);
    }
    Ok(())
}

/// Refuses holds with a force larger than the guard can render; `force_m2` returns the force over E
/// [m^2].
///
/// # Errors
/// Returns the first such hold.
pub fn refuse_beyond_the_guard(scene: &Scene, force_m2: impl Fn(f64) -> f64) -> Result<(), Error> {
    let (Drive::Depth { holds_m, .. } | Drive::Hand { holds_m, .. }) = &scene.drive else { return Ok(()) };
    let most_n = f64::from(palpate::GuardLimits::HIGHEST.max_force_n);
    for (n, hold_m) in holds_m.iter().enumerate() {
        let force_n = scene.tissue.youngs_modulus_pa * force_m2(*hold_m);
        if force_n > most_n {
            let why = format!(
                "= {hold_m}: the force there is {force_n:.1} N, the guard lets {most_n} N through: press less deep, or give metres and pascals"
            );
            return Ok(scene.bad(&format!("drive.holds_m[{n}]"), &why)?);
        }
    }
    Ok(())
}
