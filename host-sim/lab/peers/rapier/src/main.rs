//! A block of rapier3d's soft body under a ball that is moved by lines on standard input.
//!
//! The input begins with `key value` pairs, `nodes N` with N lines `x y z mass fixed`, `tets T`
//! with T lines of four indices, and `go`. After that each line `t FROM TO` moves the tip between
//! two depths [m] within a millisecond; the answer is `FORCE CPU`, the force [N] and the processor
//! time of all ticks so far [s]. To the line `p` the answer is the positions of all nodes [m].
//!
//! Lengths in this program are in decimetres, because rapier drops cells of less than 1.2e-7 cubic
//! units.

use std::collections::HashMap;
use std::error::Error;
use std::io::{Lines, StdinLock, Write, stdin, stdout};

use cpu_time::ThreadTime;
use rapier3d::prelude::*;

/// Units of length per metre.
const UNITS: f32 = 10.0;

type Input = Lines<StdinLock<'static>>;
type Failure = Box<dyn Error>;

struct Press {
    world: PhysicsWorld,
    body: SoftBodyHandle,
    probe: RigidBodyHandle,
    ball: ColliderHandle,
    /// Height of the ball's centre above the tip [units].
    above: f32,
    steps: usize,
}

fn line(input: &mut Input) -> Result<String, Failure> {
    Ok(input.next().ok_or("the input ends early")??)
}

fn numbers<const N: usize>(text: &str) -> Result<[f32; N], Failure> {
    let values: Result<Vec<f32>, _> = text.split_whitespace().map(str::parse).collect();
    values?.try_into().map_err(|_| format!("{N} numbers wanted: {text}").into())
}

fn read(input: &mut Input) -> Result<Press, Failure> {
    let mut given: HashMap<String, f32> = HashMap::new();
    let (mut positions, mut masses, mut pinned, mut cells) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
    loop {
        let text = line(input)?;
        let mut words = text.split_whitespace();
        match (words.next(), words.next()) {
            (Some("go"), _) => break,
            (Some("nodes"), Some(count)) => {
                for n in 0..count.parse::<u32>()? {
                    let [x, y, z, mass, fixed] = numbers(&line(input)?)?;
                    positions.push(Vector::new(x, y, z) * UNITS);
                    masses.push(mass);
                    if fixed > 0.0 {
                        pinned.push(n);
                    }
                }
            }
            (Some("tets"), Some(count)) => {
                for _ in 0..count.parse::<u32>()? {
                    cells.push(numbers::<4>(&line(input)?)?.map(|n| n as u32));
                }
            }
            (Some(key), Some(value)) => {
                given.insert(key.into(), value.parse()?);
            }
            _ => return Err(format!("not understood: {text}").into()),
        }
    }
    let of = |key: &str| given.get(key).copied().ok_or_else(|| format!("{key} is not given"));
    let steps = of("substeps")? as usize;
    let skin = of("skin_m")? * UNITS;
    let radius = of("radius_m")? * UNITS;
    let material = SoftBodyMaterial {
        // in kg/(dm s^2), the unit of stress when lengths are in decimetres
        young_modulus: of("youngs_modulus_pa")? / UNITS,
        poisson_ratio: of("poisson_ratio")?,
        elastic_damping_ratio: of("damping_ratio")?,
        ..Default::default()
    };
    let mut world = PhysicsWorld::new();
    world.gravity = Vector::new(0.0, 0.0, 0.0);
    let settings = &mut world.integration_parameters;
    settings.dt = of("tick_s")? / steps as f32;
    settings.length_unit = of("length_unit")?;
    settings.num_solver_iterations = 1;
    settings.soft_bodies.max_extra_substeps = 0;
    settings.soft_bodies.contact_stiffening = of("contact_stiffening")?;
    settings.soft_bodies.fem.max_linear_iterations = of("cg_iterations")? as usize;
    if let Some(dofs) = given.get("dense_dofs") {
        settings.soft_bodies.fem.max_dense_dofs = *dofs as usize;
    }
    let model = if of("neo_hookean")? > 0.0 { SoftBodyCellModel::NeoHookean } else { SoftBodyCellModel::Corotational };
    let solver = if of("fem")? > 0.0 { SoftBodySolver::Fem } else { SoftBodySolver::Constraints };
    let body = SoftBodyBuilder::new(positions)
        .masses(masses)
        .cells(cells)
        .cell_model(model)
        .solver(solver)
        .material(material)
        .particle_radius(skin)
        .self_contacts(false)
        .surface_collider(ColliderBuilder::ball(skin).friction(0.0))
        .pinned_particles(pinned)
        .additional_pgs_iterations(of("pgs_iterations")? as usize)
        .can_sleep(false);
    let body = world.insert_soft_body(body);
    // the surface has a skin of this thickness, so the ball is smaller by it
    let (probe, ball) = world.insert(
        RigidBodyBuilder::kinematic_position_based().translation(Vector::new(0.0, 0.0, radius + 0.1)),
        ColliderBuilder::ball(radius - skin).friction(0.0).friction_combine_rule(CoefficientCombineRule::Min),
    );
    Ok(Press { world, body, probe, ball, above: radius, steps })
}

impl Press {
    /// Moves the tip between two depths [m]; returns the force along the press [N].
    fn tick(&mut self, from_m: f32, to_m: f32) -> f32 {
        let mut force = 0.0;
        for k in 1..=self.steps {
            let depth = (from_m + (to_m - from_m) * k as f32 / self.steps as f32) * UNITS;
            self.world.bodies[self.probe].set_next_kinematic_translation(Vector::new(0.0, 0.0, self.above - depth));
            self.world.step();
            let pairs = self.world.narrow_phase.contact_pairs_with(self.ball);
            let pushes = pairs.flat_map(|pair| pair.manifolds()).flat_map(|m| m.points.iter().map(|p| p.data.impulse * m.data.normal.z));
            force = pushes.sum::<f32>().abs() / self.world.integration_parameters.dt / UNITS;
        }
        force
    }
}

fn run() -> Result<(), Failure> {
    let mut input = stdin().lines();
    let mut press = read(&mut input)?;
    let mut out = stdout().lock();
    let mut spent = 0.0;
    while let Some(text) = input.next() {
        let text = text?;
        if let Some(way) = text.strip_prefix("t ") {
            let [from_m, to_m] = numbers(way)?;
            let started = ThreadTime::now();
            let force = press.tick(from_m, to_m);
            spent += started.elapsed().as_secs_f64();
            writeln!(out, "{force} {spent}")?;
        } else {
            let positions = press.world.soft_bodies[press.body].particle_positions();
            let words: Vec<String> = positions.map(|x| format!("{} {} {}", x.x / UNITS, x.y / UNITS, x.z / UNITS)).collect();
            writeln!(out, "{}", words.join(" "))?;
        }
        out.flush()?;
    }
    Ok(())
}

fn main() {
    if let Err(why) = run() {
        eprintln!("rapier-press: {why}");
        std::process::exit(2);
    }
}
