//! Writes input decks for `CalculiX`: the block of our own finite elements under a rigid ball.
//! Lengths are in millimetres, stresses in kilopascals, forces in millinewtons.
//!
//! `CalculiX` does not provide our energy, mu/2 (I1 - 3) - mu ln J + lambda/2 (ln J)^2, but two
//! terms of its hyperfoam come close. With alpha = 2 in both, and beta = b in one and -b in the
//! other, they add up to mu/2 (I1 - 3) plus a function of ln J whose slope and curvature at rest
//! equal ours. Its third derivative there is -4 b^2 mu, whereas ours is zero.
//!
//! `CalculiX` has no Prony terms. A hold is modelled by Maxwell elements instead, parallel to
//! elastic elements on the same nodes: the material of a Maxwell element creeps in proportion to
//! the stress. Its shear relaxes, its volume does not.

use std::fmt::Write;

use palpate_fit::reference::body::Material;
use palpate_fit::reference::domain::{BlockBody, BlockCase};
use palpate_fit::reference::shape::TetRule;

use super::{Failure, ball};

pub const RADIUS_MM: f64 = 8.0;
pub const MODULUS_KPA: f64 = 3.5;
pub const POISSON_RATIO: f64 = 0.45;
pub const FRICTION: f64 = 0.5;
/// Depths of the presses, and depth of drag and hold [mm].
pub const DEPTHS_MM: [f64; 3] = [1.0, 2.0, 4.0];
pub const DRAG_DEPTH_MM: f64 = 2.0;
/// Lengths of the drag [mm].
pub const DRAGS_MM: [f64; 4] = [0.1, 0.25, 0.5, 1.0];
/// Relaxation in a hold: pairs of a share of the shear modulus (1) and its time [s].
pub const TERMS: [[f64; 2]; 2] = [[0.3, 0.5], [0.2, 5.0]];
/// Times after the press at which the forces of a hold are read, and duration of the press [s].
pub const HOLDS_S: [f64; 2] = [1.0, 10.0];
pub const PRESSED_S: f64 = 1e-3;

/// Distance from the tip within which the elements are smallest [m].
const FINE_M: f64 = 6.2e-3;
/// Radius of the region of the top whose triangles may be in contact [mm].
const TOUCHES_MM: f64 = 10.0;
/// Pressure per penetration, and tangential stress per slip while the contact sticks, both divided
/// by Young's modulus [1/mm].
const PENALTY_PER_MM: f64 = 300.0;
const STICK_PER_MM: f64 = 30.0;
/// Value of beta in the hyperfoam terms. A smaller value would come closer to our energy, but at
/// 0.1 the two terms, 22 and 23 mu, leave so much rounding error that no equilibrium is found.
const BETA: f64 = 1.0;

/// A deck with the name of its file.
pub struct Deck {
    pub name: &'static str,
    pub text: String,
}

/// The block; `may_cut` allows cuts along the symmetry planes x = 0 and y = 0.
pub fn block(nodes: usize, may_cut: [bool; 2], poisson_ratio: f64) -> Result<BlockBody, Failure> {
    let material = Material { poisson_ratio, stiffening_b: 0.0, inclusions: Vec::new() };
    let size_m = [0.08, 0.08, 0.04];
    let case = BlockCase { size_m, place_m: [0.0; 2], material, nodes, fine_radius_m: FINE_M, rule: TetRule::Four, may_cut };
    case.build().map_err(|cause| format!("the block cannot be meshed: {cause}"))
}

/// Number of corner nodes of the piece for a press, a drag, and a hold.
pub const NODES: [usize; 3] = [350, 600, 250];

/// Builds all decks.
pub fn all() -> Result<Vec<Deck>, Failure> {
    let pressed = block(NODES[0], [true; 2], POISSON_RATIO)?;
    let dragged = block(NODES[1], [false, true], POISSON_RATIO)?;
    let held = block(NODES[2], [true; 2], POISSON_RATIO)?;
    let presses: String = DEPTHS_MM.iter().map(|d| step("STATIC", "0.5, 1., 1e-4, 0.5", &[(3, -d)])).collect();
    let drags: String = DRAGS_MM.iter().map(|x| step("STATIC", "1., 1., 1e-4, 1.", &[(1, *x), (3, -DRAG_DEPTH_MM)])).collect();
    let drags = step("STATIC", "0.5, 1., 1e-4, 0.5", &[(3, -DRAG_DEPTH_MM)]) + &drags;
    let increments_s = [0.04, 0.4];
    let mut holds =
        step("STATIC", &format!("{}, {PRESSED_S}, 1e-7, {}", 0.5 * PRESSED_S, 0.5 * PRESSED_S), &[(3, -DRAG_DEPTH_MM)]);
    // the tolerance of the creep strain is so wide that the given increments apply
    let mut before_s = 0.0;
    for (until_s, increment_s) in HOLDS_S.into_iter().zip(increments_s) {
        holds += &step(
            "VISCO, CETOL=1.",
            &format!("{increment_s}, {}, 1e-5, {increment_s}", until_s - before_s),
            &[(3, -DRAG_DEPTH_MM)],
        );
        before_s = until_s;
    }
    Ok(vec![
        Deck { name: "press", text: deck(&pressed, &ours(1.0), 0.0, &presses)? },
        Deck { name: "neo-hooke", text: deck(&pressed, &neo_hooke(1.0), 0.0, &presses)? },
        Deck { name: "drag", text: deck(&dragged, &ours(1.0), FRICTION, &drags)? },
        Deck { name: "hold", text: deck(&held, &relaxing(), FRICTION, &holds)? },
    ])
}

/// One material per set of elements; the sets share their nodes.
type Materials = Vec<String>;

/// Lamé constants, mu and lambda [kPa].
fn lame() -> [f64; 2] {
    let shear = MODULUS_KPA / (2.0 * (1.0 + POISSON_RATIO));
    [shear, 2.0 * shear * POISSON_RATIO / (1.0 - 2.0 * POISSON_RATIO)]
}

/// Material with our energy, multiplied by `share`.
fn ours(share: f64) -> Materials {
    let [shear, lambda] = lame().map(|l| l * share);
    let half = 0.25 * lambda / BETA;
    let [up, down] = [0.5 * shear + half, 0.5 * shear - half];
    let [over, under] = [BETA, -BETA].map(|b| b / (1.0 + 2.0 * b));
    vec![format!("*HYPERFOAM, N=2\n{up:.12}, 2., {down:.12}, 2., {over:.12}, {under:.12}\n")]
}

/// Neo-Hookean material of `CalculiX`, with our moduli at small strain, multiplied by `share`.
fn neo_hooke(share: f64) -> Materials {
    let [shear, lambda] = lame().map(|l| l * share);
    let bulk = lambda + 2.0 / 3.0 * shear;
    vec![format!("*HYPERELASTIC, NEO HOOKE\n{:.12}, {:.12}\n", 0.5 * shear, 2.0 / bulk)]
}

/// An elastic material, and parallel Maxwell elements whose shear creeps in proportion to the
/// stress.
fn relaxing() -> Materials {
    let mut materials = neo_hooke(1.0 - TERMS.iter().map(|term| term[0]).sum::<f64>());
    for [share, time_s] in TERMS {
        let rate = 1.0 / (3.0 * share * lame()[0] * time_s);
        materials.push(format!("*ELASTIC\n{:.12}, {POISSON_RATIO}\n*CREEP\n{rate:.12e}, 1., 0.\n", share * MODULUS_KPA));
    }
    materials
}

/// Step that moves the given components of the ball to these values [mm] and all others to zero.
fn step(procedure: &str, increments: &str, moved_mm: &[(usize, f64)]) -> String {
    let mut text = format!("*STEP, NLGEOM, INC=2000\n*{procedure}\n{increments}\n*BOUNDARY\n");
    for (component, mm) in moved_mm {
        _ = writeln!(text, "BALL, {component}, {component}, {mm}");
    }
    text + "*NODE PRINT, NSET=BALL, TOTALS=ONLY, FREQUENCY=10000\nRF\n*END STEP\n"
}

/// Faces of a tet in the order in which `CalculiX` numbers them.
const FACES: [[usize; 3]; 4] = [[0, 1, 2], [0, 1, 3], [1, 2, 3], [0, 2, 3]];

fn deck(block: &BlockBody, materials: &Materials, friction: f64, steps: &str) -> Result<String, Failure> {
    let mesh = &block.body.mesh;
    let (nodes, tets) = (mesh.nodes_m.len(), mesh.tets.len());
    let mut text = String::from("*NODE, NSET=BLOCK\n");
    for (n, x) in mesh.nodes_m.iter().enumerate() {
        _ = writeln!(text, "{}, {:.9}, {:.9}, {:.9}", n + 1, x.x * 1e3, x.y * 1e3, x.z * 1e3);
    }
    for (set, material) in materials.iter().enumerate() {
        _ = writeln!(text, "*ELEMENT, TYPE=C3D10, ELSET=TISSUE{set}");
        for (t, tet) in mesh.tets.iter().enumerate() {
            let numbers: Vec<String> = tet.iter().map(|n| (n + 1).to_string()).collect();
            _ = writeln!(text, "{}, {}", set * tets + t + 1, numbers.join(", "));
        }
        _ = write!(text, "*MATERIAL, NAME=TISSUE{set}\n{material}*SOLID SECTION, ELSET=TISSUE{set}, MATERIAL=TISSUE{set}\n");
    }
    text.push_str("*SURFACE, NAME=TOP\n");
    let touches = |n: u32| {
        let x = mesh.nodes_m[n as usize] * 1e3;
        x.z == 0.0 && x.x.hypot(x.y) < TOUCHES_MM
    };
    for (t, tet) in mesh.tets.iter().enumerate() {
        for (face, corners) in FACES.iter().enumerate() {
            if corners.iter().all(|c| touches(tet[*c])) {
                _ = writeln!(text, "{}, S{}", t + 1, face + 1);
            }
        }
    }
    ball::write(&mut text, nodes, materials.len() * tets);
    text.push_str("*SURFACE INTERACTION, NAME=TOUCH\n*SURFACE BEHAVIOR, PRESSURE-OVERCLOSURE=LINEAR\n");
    _ = writeln!(text, "{}", PENALTY_PER_MM * MODULUS_KPA);
    if friction > 0.0 {
        _ = writeln!(text, "*FRICTION\n{friction}, {}", STICK_PER_MM * MODULUS_KPA);
    }
    text.push_str("*CONTACT PAIR, INTERACTION=TOUCH, TYPE=SURFACE TO SURFACE\nTOP, OUTSIDE\n*BOUNDARY\nBALL, 1, 3\n");
    for (n, fixed) in block.body.fixed.iter().enumerate() {
        for (component, _) in fixed.iter().enumerate().filter(|(_, held)| **held) {
            _ = writeln!(text, "{}, {}", n + 1, component + 1);
        }
    }
    text.push_str(steps);
    Ok(text)
}
