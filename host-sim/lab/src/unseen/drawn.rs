//! A random scene.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

use palpate_tissue::error::Error;
use palpate_tissue::scene::Scene;
use rand_xoshiro::SplitMix64;
use rand_xoshiro::rand_core::{Rng, SeedableRng};

use super::bodies::Body;

/// The numbers that describe a scene.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Drawn {
    body: Body,
    site_m: [f64; 3],
    radius_m: f64,
    poisson_ratio: f64,
    /// Deepest press [m].
    pub deepest_m: f64,
    random: SplitMix64,
}

impl Drawn {
    /// Draws the scene with this number.
    pub fn draw(number: u64, seed: u64) -> Self {
        let mut random = SplitMix64::seed_from_u64(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(number));
        let mut between = |low: f64, high: f64| low + (high - low) * share(&mut random);
        let radius_m = rounded(between(0.005, 0.009));
        let poisson_ratio = rounded(between(0.25, 0.49));
        let deepest_m = rounded(between(0.3, 0.55) * radius_m);
        // another seed begins with another kind
        let body = Body::draw(number.wrapping_add(seed), &mut between);
        let site_m = body.site_m(&mut between);
        Self { body, site_m, radius_m, poisson_ratio, deepest_m, random }
    }

    /// The scene in words.
    pub fn words(&self) -> String {
        let [x, y, z] = self.site_m.map(|m| m * 1e3);
        format!(
            "{}, at ({x:.1}, {y:.1}, {z:.1}) mm, R {:.1} mm, nu {:.2}, {:.1} mm deep",
            self.body.words(),
            self.radius_m * 1e3,
            self.poisson_ratio,
            self.deepest_m * 1e3
        )
    }

    /// The scene; the surface of its body is written to `folder`.
    pub fn scene(&self, folder: &Path) -> Result<Scene, Error> {
        let path = folder.join("body.stl");
        let mut text = String::from("name = \"unseen\"\n[tissue]\n");
        std::fs::write(&path, self.body.stl()).map_err(|source| Error::Write { path: path.clone(), source })?;
        let _ = writeln!(text, "mesh = {:?}\nlength_unit = \"mm\"", path.display().to_string());
        let site_m = self.site_m;
        let (nu, radius_m, deepest_m) = (self.poisson_ratio, self.radius_m, self.deepest_m);
        let _ = write!(
            text,
            "youngs_modulus_pa = 20000.0\npoisson_ratio = {nu}\ndensity_kg_per_m3 = 1060.0\n\
             [probe]\nshape = \"hemisphere\"\nradius_m = {radius_m}\nsite = {site_m:?}\n\
             [drive]\nkind = \"depth\"\nholds_m = [{deepest_m}]\nramp_m_per_s = 0.04\nhold_s = 0.3\n\
             [solver]\nmethod = \"palpate\"\n"
        );
        Ok(Scene::parse("unseen", &text)?)
    }

    /// Random places within a radius of the site, in its tangent plane [m].
    pub fn places_m(&self, count: usize, radius_m: f64) -> Vec<[f64; 2]> {
        let mut random = self.random.clone();
        let place = |_| {
            let (away_m, angle) = (radius_m * share(&mut random).sqrt(), TAU * share(&mut random));
            [away_m * angle.cos(), away_m * angle.sin()]
        };
        (0..count).map(place).collect()
    }
}

/// A random number from 0 to 1.
fn share(random: &mut SplitMix64) -> f64 {
    (random.next_u64() >> 11) as f64 / (1_u64 << 53) as f64
}

/// Rounds to a hundredth of a millimetre, or to two digits of a ratio.
fn rounded(value: f64) -> f64 {
    if value < 0.1 { (value * 1e5).round() / 1e5 } else { (value * 100.0).round() / 100.0 }
}
