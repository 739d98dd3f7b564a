//! Internal forces of the finite-element methods compared with their energies, which are
//! implemented again in double precision.

use crate::bench::Noise;
use nalgebra::{Matrix3, Vector3};
use palpate_lab::methods::{Block, Corotational, Law, Meshless, NeoHookean, ShapeFunctions, Share, Volume};

/// Tolerance for single precision: three digits are lost in the deformation gradient (edges of 3-30
/// mm, coordinates up to 40 mm, strains of 0.1), and the corotational rotation is accurate to 1e-5
/// rad.
const FORCE_TOLERANCE: f64 = 3e-4;

/// Faces of a tet, counter-clockwise as seen from outside.
const FACES: [[usize; 3]; 4] = [[1, 2, 3], [0, 3, 2], [0, 1, 3], [0, 2, 1]];

fn matrix(block: &Block, tet: &[u32; 4], x: &[Vector3<f64>]) -> (Matrix3<f64>, f64) {
    let rest = |n: u32| Vector3::from(block.tissue.mesh.nodes_m[n as usize]);
    let edges = |at: &dyn Fn(u32) -> Vector3<f64>| Matrix3::from_columns(&[1, 2, 3].map(|k| at(tet[k]) - at(tet[0])));
    let reference = edges(&rest);
    let f = edges(&|n| x[n as usize]) * reference.try_inverse().expect("a tet with a volume");
    (f, reference.determinant() / 6.0)
}

/// Nearest rotation, by Higham's iteration.
fn rotation(f: &Matrix3<f64>) -> Matrix3<f64> {
    (0..60).fold(*f, |r, _| (r + r.try_inverse().expect("not singular").transpose()) * 0.5)
}

fn lame() -> (f64, f64) {
    let nu = 0.45;
    (nu / ((1.0 + nu) * (1.0 - 2.0 * nu)), 0.5 / (1.0 + nu))
}

fn corotational_energy(block: &Block, x: &[Vector3<f64>]) -> f64 {
    let (lambda, mu) = lame();
    let of = |tet: &[u32; 4]| {
        let (f, volume) = matrix(block, tet, x);
        let r = rotation(&f);
        volume * (mu * (f - r).norm_squared() + 0.5 * lambda * ((r.transpose() * f).trace() - 3.0).powi(2))
    };
    block.tissue.mesh.tets.iter().map(of).sum()
}

fn neo_hookean_energy(block: &Block, x: &[Vector3<f64>], volume_term: Volume) -> f64 {
    let (lambda, mu) = lame();
    let mut nodal = vec![(0.0, 0.0); x.len()];
    let mut energy = 0.0;
    for tet in &block.tissue.mesh.tets {
        let (f, volume) = matrix(block, tet, x);
        let j = f.determinant();
        energy += volume * (0.5 * mu * (f.norm_squared() - 3.0) - mu * j.ln());
        match volume_term {
            Volume::PerTet => energy += volume * 0.5 * lambda * j.ln().powi(2),
            Volume::Nodal => tet.iter().for_each(|&n| {
                nodal[n as usize].0 += volume * j;
                nodal[n as usize].1 += volume;
            }),
        }
    }
    if volume_term == Volume::Nodal {
        energy += nodal.iter().map(|(now, rest)| 0.25 * rest * 0.5 * lambda * (now / rest).ln().powi(2)).sum::<f64>();
    }
    energy
}

/// Energy of the meshless method from mean deformation gradients. These are computed from the
/// displacements of face points, without gradients of the shape functions.
fn meshless_energy(block: &Block, means: &[[Vec<Share>; 4]], x: &[Vector3<f64>]) -> f64 {
    let (lambda, mu) = lame();
    let of = |(tet, means): (&[u32; 4], &[Vec<Share>; 4])| {
        let at = tet.map(|n| Vector3::from(block.tissue.mesh.nodes_m[n as usize]));
        let volume = (at[1] - at[0]).dot(&(at[2] - at[0]).cross(&(at[3] - at[0]))) / 6.0;
        let mut f = Matrix3::zeros();
        for (face, mean) in FACES.iter().zip(means) {
            let [a, b, c] = face.map(|k| at[k]);
            let moved: Vector3<f64> = mean.iter().map(|&(n, phi)| x[n as usize] * phi).sum();
            f += moved * ((b - a).cross(&(c - a)) / (2.0 * volume)).transpose();
        }
        let log = f.determinant().ln();
        volume * (0.5 * mu * (f.norm_squared() - 3.0) - mu * log + 0.5 * lambda * log * log)
    };
    block.tissue.mesh.tets.iter().zip(means).map(of).sum()
}

fn deformed(block: &Block, seed: u64) -> Vec<Vector3<f64>> {
    let mut noise = Noise::new(seed);
    let gradient = Matrix3::from_fn(|_, _| 0.1 * noise.uniform());
    let rest = block.tissue.mesh.nodes_m.iter().map(|x| Vector3::from(*x));
    rest.map(|x| x + gradient * x + Vector3::from_fn(|_, _| 4e-4 * noise.uniform())).collect()
}

fn forces(law: &mut impl Law, x: &[Vector3<f64>]) -> Vec<Vector3<f64>> {
    let position: Vec<_> = x.iter().map(|x| x.cast::<f32>()).collect();
    let mut force = vec![Vector3::zeros(); x.len()];
    // repeated, because the rotations converge from call to call
    for _ in 0..8 {
        law.forces(&position, &mut force);
    }
    force.into_iter().map(|f| f.cast()).collect()
}

fn force_is_minus_the_slope(law: &mut impl Law, block: &Block, energy: impl Fn(&[Vector3<f64>]) -> f64) {
    for seed in 1..=3 {
        let mut x = deformed(block, seed);
        // the energy is evaluated at positions that single precision can represent
        x.iter_mut().for_each(|x| *x = x.cast::<f32>().cast());
        let force = forces(law, &x);
        let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
        for n in 0..x.len() {
            for k in 0..3 {
                let (kept, step) = (x[n][k], 1e-7);
                x[n][k] = kept + step;
                let up = energy(&x);
                x[n][k] = kept - step;
                let down = energy(&x);
                x[n][k] = kept;
                let slope = (up - down) / (2.0 * step);
                worst = worst.max((force[n][k] + slope).abs());
                largest = largest.max(slope.abs());
            }
        }
        assert!(worst <= FORCE_TOLERANCE * largest, "seed {seed}: off by {worst:e} of {largest:e}");
    }
}

fn block() -> Block {
    Block::standard(57, 3500.0).expect("a block that can be meshed")
}

#[test]
fn corotational_force_is_minus_the_slope_of_its_energy() {
    let block = block();
    force_is_minus_the_slope(&mut Corotational::new(&block), &block, |x| corotational_energy(&block, x));
}

#[test]
fn neo_hookean_force_is_minus_the_slope_of_its_energy() {
    let block = block();
    for volume in [Volume::PerTet, Volume::Nodal] {
        force_is_minus_the_slope(&mut NeoHookean::new(&block, volume), &block, |x| neo_hookean_energy(&block, x, volume));
    }
}

#[test]
fn meshless_force_is_minus_the_slope_of_its_energy() {
    let block = block();
    let mesh = &block.tissue.mesh;
    let shape = ShapeFunctions::new(mesh, 1.05);
    let of_face = |tet: &[u32; 4], face: [usize; 3]| {
        shape.mean(&face.map(|k| Vector3::from(mesh.nodes_m[tet[k] as usize]))).expect("nodes in reach")
    };
    let means: Vec<_> = mesh.tets.iter().map(|tet| FACES.map(|face| of_face(tet, face))).collect();
    let mut law = Meshless::new(&block).expect("sound tets");
    force_is_minus_the_slope(&mut law, &block, |x| meshless_energy(&block, &means, x));
}

#[test]
fn rigid_motion_gives_no_force() {
    let block = block();
    let turn = nalgebra::Rotation3::from_euler_angles(0.4, -0.3, 0.7);
    let moved: Vec<_> =
        block.tissue.mesh.nodes_m.iter().map(|x| turn * Vector3::from(*x) + Vector3::new(0.01, -0.02, 0.03)).collect();
    let stretched: Vec<_> = moved.iter().map(|x| x * 1.01).collect();
    fn check(name: &str, law: &mut impl Law, [rigid, stretched]: [&[Vector3<f64>]; 2]) {
        let largest = |law: &mut _, x: &[Vector3<f64>]| forces(law, x).iter().map(|f| f.norm()).fold(0.0, f64::max);
        // coordinates are rounded by a strain of 1e-5, compared with strains of 1e-2
        let (rigid, strained) = (largest(law, rigid), largest(law, stretched));
        assert!(rigid <= 2e-3 * strained, "{name}: {rigid:e} against {strained:e} at 1 % of strain");
    }
    let both = [&moved[..], &stretched[..]];
    check("corotational", &mut Corotational::new(&block), both);
    check("neo-Hookean", &mut NeoHookean::new(&block, Volume::PerTet), both);
    check("nodal neo-Hookean", &mut NeoHookean::new(&block, Volume::Nodal), both);
    check("meshless", &mut Meshless::new(&block).expect("sound tets"), both);
}

#[test]
fn a_stretched_bar_pulls_with_youngs_modulus() {
    let block = block();
    let strain = 1e-3;
    let x: Vec<_> = block
        .tissue
        .mesh
        .nodes_m
        .iter()
        .map(|x| Vector3::new(x[0] * (1.0 - 0.45 * strain), x[1] * (1.0 - 0.45 * strain), x[2] * (1.0 + strain)))
        .collect();
    // E A strain, divided by E
    let wanted = 0.08 * 0.08 * strain;
    let on_end = |force: &[Vector3<f64>], z: f64| -> f64 {
        let at_end = block.tissue.mesh.nodes_m.iter().zip(force).filter(|(x, _)| (x[2] - z).abs() < 1e-9);
        at_end.map(|(_, f)| f.z).sum()
    };
    let check = |name: &str, force: Vec<Vector3<f64>>| {
        let (top, bottom) = (-on_end(&force, 0.0) / wanted, on_end(&force, -0.04) / wanted);
        // the laws differ from linear elasticity by a few times the strain; rounding leaves 1e-5 of
        // strain in 1e-3
        assert!((top - 1.0).abs() < 0.02 && (bottom - 1.0).abs() < 0.02, "{name}: {top:.4} and {bottom:.4} of E A strain");
    };
    check("corotational", forces(&mut Corotational::new(&block), &x));
    check("neo-Hookean", forces(&mut NeoHookean::new(&block, Volume::PerTet), &x));
    check("nodal neo-Hookean", forces(&mut NeoHookean::new(&block, Volume::Nodal), &x));
}
