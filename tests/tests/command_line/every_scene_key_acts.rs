//! No key of a scene file is ignored: each changes the quantity that it names, and only in the
//! direction that mechanics allows.

use palpate_tests::cube_mesh::cube;
use palpate_tests::palpate_command::{Desk, palpate};
use palpate_tests::press_run::{PressRun, SMALL_BLOCK, edited, press, press_at, small_block};

const SCRATCH: &str = env!("CARGO_TARGET_TMPDIR");
const BLOCK: &str = "block_m = [0.08, 0.08, 0.04]";
const NODES: &str = "nodes = 129";
const HOLDS: &str = "holds_m = [0.001, 0.002, 0.004]";
const PLACE: &str = "position_m = [0.0, 0.0]";

fn small() -> &'static PressRun {
    small_block(SCRATCH)
}

fn changed(from: &str, to: &str) -> PressRun {
    press(SCRATCH, &edited(SMALL_BLOCK, from, to))
}

/// Ratio of the forces of one run to those of another, one per hold.
fn ratios(of: &PressRun, to: &PressRun) -> Vec<f64> {
    of.forces_n().iter().zip(to.forces_n()).map(|(a, b)| a / b).collect()
}

/// Largest difference in force between two runs of equal length [N].
fn largest_difference_n(a: &PressRun, b: &PressRun) -> f64 {
    let (a, b) = (a.trace.column("force_z_n"), b.trace.column("force_z_n"));
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Checks that a changed key does not affect the force at rest but does affect the force before
/// that.
#[track_caller]
fn dynamics_only(key: &str, from: &str, to: &str) -> PressRun {
    let (plain, other) = (small(), changed(from, to));
    let (ratios, on_the_way_n) = (ratios(&other, plain), largest_difference_n(&other, plain));
    println!("{key}: holds {ratios:.5?}, on the way up to {on_the_way_n:.5} N");
    // the tolerance covers the motion that remains after 0.3 s
    assert!(ratios.iter().all(|r| (r - 1.0).abs() < 0.005), "{key}: {ratios:?}");
    assert!(on_the_way_n > 1e-3 * plain.forces_n()[2], "{key}: {on_the_way_n} N");
    other
}

#[test]
fn name_is_in_the_summary() {
    assert_eq!(changed("\"small\"", "\"other words\"").summary["scene"], "other words");
}

#[test]
fn block_has_its_sides() {
    let thin = changed(BLOCK, "block_m = [0.06, 0.07, 0.02]");
    for (axis, side_mm) in [60.0, 70.0, 20.0].into_iter().enumerate() {
        assert!((thin.number(&format!("/report/size_mm/{axis}")) - side_mm).abs() < 1e-4);
    }
    assert!((thin.number("/report/mass_g") - 1060.0 * 0.06 * 0.07 * 0.02 * 1e3).abs() < 1e-3);
    // the fixed bottom is nearer, so the force is larger
    assert!(ratios(&thin, small())[2] > 1.05);
}

#[test]
fn node_count_is_exact() {
    assert_eq!(changed(NODES, "nodes = 200").number("/nodes"), 200.0);
    assert_eq!(changed(NODES, "").number("/nodes"), 410.0);
}

#[test]
fn force_is_proportional_to_youngs_modulus() {
    for ratio in ratios(&changed("3500.0", "7000.0"), small()) {
        assert!((ratio / 2.0 - 1.0).abs() < 0.005, "{ratio}");
    }
}

#[test]
fn lower_poisson_ratio_is_softer() {
    // contact force is proportional to 1/(1 - nu^2): 0.80/0.91 = 0.88 on a half-space, and
    // confinement is weaker
    let ratios = ratios(&changed("= 0.45", "= 0.3"), small());
    println!("nu 0.3 over 0.45: {ratios:.4?}");
    assert!(ratios.iter().all(|r| (0.75..0.95).contains(r)), "{ratios:?}");
}

#[test]
fn density_changes_mass_and_dynamics_not_statics() {
    let heavy = dynamics_only("density_kg_per_m3", "1060.0", "5300.0");
    let ratio = heavy.number("/report/mass_g") / small().number("/report/mass_g");
    assert!((ratio / 5.0 - 1.0).abs() < 1e-6, "{ratio}");
}

#[test]
fn node_damping_changes_dynamics_not_statics() {
    let _damped = dynamics_only("node_damping_per_s", NODES, "nodes = 129\nnode_damping_per_s = 200.0");
}

#[test]
fn tissue_sags_under_gravity_by_its_weight() {
    let sag = |g: f64| {
        let scene = edited(SMALL_BLOCK, NODES, &format!("{NODES}\ngravity_m_per_s2 = [0.0, 0.0, {g}]"));
        press(SCRATCH, &edited(&scene, HOLDS, "holds_m = [0.004]"))
    };
    let (full, half, up) = (sag(-9.81), sag(-4.905), sag(9.81));
    let left = |run: &PressRun| run.number("/residual_m");
    // a column of height H sags by rho g H^2 / 2M, where M is E with free sides and E
    // (1-nu)/((1+nu)(1-2nu)) with fixed sides; the block is in between
    let (free_m, none_m) = (1060.0 * 9.81 * 0.04 * 0.04 / 2.0 / 3500.0, 1060.0 * 9.81 * 0.04 * 0.04 / 2.0 / 13_276.0);
    println!("sag {:.6} m, half g {:.6} m, bounds {none_m:.6} .. {free_m:.6} m", left(&full), left(&half));
    assert!((none_m..free_m).contains(&left(&full)), "{}", left(&full));
    // nearly linear, since the strain is 5 %
    assert!((left(&half) / left(&full) * 2.0 - 1.0).abs() < 0.1);
    // the top is lower, so the probe meets it later and presses less; with reversed gravity it
    // presses more
    let plain_n = small().forces_n()[2];
    assert!(full.forces_n()[0] < half.forces_n()[0] && half.forces_n()[0] < plain_n && plain_n < up.forces_n()[0]);
    // sideways gravity shifts the top sideways
    let side = press(SCRATCH, &edited(SMALL_BLOCK, NODES, &format!("{NODES}\ngravity_m_per_s2 = [9.81, 0.0, 0.0]")));
    let top_x: Vec<f64> = side.surface(0).rows.iter().filter(|r| r[2] == 0.0).map(|r| r[3]).collect();
    assert!(top_x.iter().all(|x| *x > 1e-3), "{top_x:?}");
    assert!(small().number("/residual_m") < 1e-6, "no gravity is the default");
}

#[test]
fn friction_holds_the_surface_under_the_probe() {
    let friction = |mu: &str| ratios(&changed(PLACE, &format!("{PLACE}\nfriction = {mu}")), small());
    assert!(friction("0.0").iter().all(|r| *r == 1.0), "none is the default");
    // friction resists the sideways motion: the result is between a smooth probe and a glued one
    let [some, much] = ["0.2", "0.8"].map(friction);
    println!("{some:?} {much:?}");
    for (some, much) in some.iter().zip(&much) {
        assert!(1.0 < *some && some < much && *much < 1.1, "{some} {much}");
    }
}

#[test]
fn relaxation_fades_holds_and_the_long_term_modulus_is_what_stays() {
    let relaxing = |modulus: &str| {
        let terms = "[[tissue.relaxation]]\nshare = 0.4\ntime_s = 0.02\n[[tissue.relaxation]]\nshare = 0.1\ntime_s = 200.0\n";
        edited(&edited(SMALL_BLOCK, "[probe]", &format!("{terms}[probe]")), "youngs_modulus_pa = 3500.0", modulus)
    };
    let plain = small();
    // 15 time constants of the fast term, but almost none of the slow one
    for ratio in ratios(&press(SCRATCH, &relaxing("youngs_modulus_pa = 3500.0")), plain) {
        assert!((ratio / 0.6 - 1.0).abs() < 0.01, "{ratio}");
    }
    // half of a modulus of 7 kPa remains
    for ratio in ratios(&press(SCRATCH, &relaxing("long_term_modulus_pa = 3500.0")), plain) {
        assert!((ratio / 1.2 - 1.0).abs() < 0.01, "{ratio}");
    }
}

#[test]
fn stiffening_acts_where_the_press_is_deep() {
    let stiffening = press(SCRATCH, &edited(SMALL_BLOCK, "nodes = 129", "nodes = 129\nstiffening_b = 10.0"));
    let ratios = ratios(&stiffening, small());
    assert!(ratios.first().is_some_and(|r| *r > 1.005) && ratios.windows(2).all(|pair| pair[1] > pair[0]), "{ratios:?}");
}

#[test]
fn inclusion_acts_where_it_is() {
    let ball = |center: &str, radius: &str, ratio: &str| {
        let table = format!("[[tissue.inclusion]]\ncenter_m = {center}\nradius_m = {radius}\nstiffness_ratio = {ratio}\n[probe]");
        ratios(&changed("[probe]", &table), small())[2]
    };
    let (below, soft, small, aside) = (
        ball("[0.0, 0.0, -0.012]", "0.006", "10.0"),
        ball("[0.0, 0.0, -0.012]", "0.006", "0.1"),
        ball("[0.0, 0.0, -0.012]", "0.003", "10.0"),
        ball("[0.03, 0.03, -0.03]", "0.006", "10.0"),
    );
    println!("below {below:.4}, softer {soft:.4}, smaller {small:.4}, aside {aside:.4}");
    assert!(below > 1.07 && soft < 0.99 && small > 1.0 && small < below, "{below} {soft} {small}");
    // 50 mm away, which is six contact radii, the inclusion cannot be felt
    assert!((aside - 1.0).abs() < 0.01, "{aside}");
}

#[test]
fn inclusion_stiffens_by_an_exponent_of_its_own() {
    let ball = |b: &str| {
        let table =
            format!("[[tissue.inclusion]]\ncenter_m = [0.0, 0.0, -0.006]\nradius_m = 0.005\nstiffness_ratio = 0.5\n{b}\n[probe]");
        changed("[probe]", &table)
    };
    let ratios = ratios(&ball("stiffening_b = 20.0"), &ball(""));
    println!("a ball that stiffens by 20: {ratios:.4?}");
    assert!(ratios.first().is_some_and(|r| *r > 1.001) && ratios.windows(2).all(|pair| pair[1] > pair[0]), "{ratios:?}");
}

#[test]
fn smaller_probe_presses_less() {
    // Hertz: force is proportional to the square root of the radius
    let ratios = ratios(&changed("radius_m = 0.008", "radius_m = 0.004"), small());
    println!("radius 4 mm over 8 mm: {ratios:.4?}");
    assert!(ratios.iter().all(|r| (0.45..0.95).contains(r)), "{ratios:?}");
}

#[test]
fn a_capsule_is_as_long_as_it_says_and_lies_as_it_says() {
    let tip = |length: &str, along: &str| {
        changed("shape = \"hemisphere\"", &format!("shape = \"capsule\"\nlength_m = {length}\nalong = {along}"))
    };
    let [none, short, long] = ["0.0", "0.006", "0.012"].map(|length| tip(length, "[1.0, 0.0, 0.0]"));
    // a capsule of length zero is a sphere; pressed less deep than its radius, a sphere and a
    // hemisphere give the same force
    assert!(ratios(&none, small()).iter().all(|r| (r - 1.0).abs() < 1e-3));
    for (shorter, longer) in [(&none, &short), (&short, &long)] {
        assert!(ratios(longer, shorter).iter().all(|r| (1.1..1.8).contains(r)), "{:?}", ratios(longer, shorter));
    }
    // the dent is longer along the long axis than across it, in either orientation
    let dent = |run: &PressRun, way: usize| {
        let surface = run.surface(2);
        let deepest = surface.rows.iter().map(|row| row[5]).fold(0.0, f64::min);
        let wide = surface.rows.iter().filter(|row| row[5] < 0.5 * deepest).map(|row| row[way].abs());
        wide.fold(0.0, f64::max)
    };
    let turned = tip("0.012", "[0.0, 1.0, 0.0]");
    assert!(dent(&long, 0) > 1.2 * dent(&long, 1), "{} {}", dent(&long, 0), dent(&long, 1));
    assert!(dent(&turned, 1) > 1.2 * dent(&turned, 0), "{} {}", dent(&turned, 1), dent(&turned, 0));
}

#[test]
fn an_ellipsoid_has_its_three_semi_axes() {
    let tip = |axes: &str| {
        let scene = edited(SMALL_BLOCK, "radius_m = 0.008\n", "");
        let shape = format!("shape = \"ellipsoid\"\nsemi_axes_m = {axes}\nalong = [1.0, 0.0, 0.0]");
        press(SCRATCH, &edited(&scene, "shape = \"hemisphere\"", &shape))
    };
    let round = tip("[0.008, 0.008, 0.008]");
    assert!(ratios(&round, small()).iter().all(|r| (r - 1.0).abs() < 1e-3));
    // Hertz: approximately the square root of the mean of the two radii of curvature
    for wider in [tip("[0.012, 0.008, 0.008]"), tip("[0.008, 0.012, 0.008]"), tip("[0.008, 0.008, 0.006]")] {
        assert!(ratios(&wider, &round).iter().all(|r| (1.05..1.4).contains(r)), "{:?}", ratios(&wider, &round));
    }
}

#[test]
fn press_is_where_the_scene_says() {
    let run = changed(PLACE, "position_m = [0.02, -0.01]");
    assert!(run.trace.column("probe_x_m").iter().all(|x| *x == 0.02));
    assert!(run.trace.column("probe_y_m").iter().all(|y| *y == -0.01));
    let surface = run.surface(2);
    let lowest = surface.rows.iter().min_by(|a, b| a[5].total_cmp(&b[5])).unwrap();
    assert!((lowest[0] - 0.02).hypot(lowest[1] + 0.01) < 0.008, "{lowest:?}");
    assert_eq!(changed(PLACE, "").summary["state_hash"], small().summary["state_hash"], "the centre is the default");
}

#[test]
fn ramp_and_hold_set_the_time() {
    let ticks = |from: &str, to: &str| changed(from, to).number("/ticks");
    // 9 mm of travel at 0.04 m/s takes 225 ms; each of four legs may end in a partial step
    let plain = small().number("/ticks");
    assert!((ticks("= 0.04\n", "= 0.02\n") - plain - 225.0).abs() <= 4.0);
    assert!((ticks("hold_s = 0.3", "hold_s = 0.1") - plain + 600.0).abs() <= 3.0);
    assert!((ticks(HOLDS, "holds_m = [0.004]") - plain + 600.0).abs() <= 3.0);
}

#[test]
fn springs_alone_press_less() {
    let shallow = |solver: &str| press(SCRATCH, &edited(&format!("{SMALL_BLOCK}{solver}"), HOLDS, "holds_m = [0.001, 0.002]"));
    let (springs, all) = (shallow("[solver]\nmethod = \"springs\"\n"), shallow("[solver]\nmethod = \"palpate\"\n"));
    println!("springs alone over all: {:.4?}", ratios(&springs, &all));
    assert_eq!((&springs.summary["method"], &all.summary["method"]), (&"springs".into(), &"palpate".into()));
    // without the volume term nothing resists a change of volume
    assert!(ratios(&springs, &all).iter().all(|r| (0.3..0.85).contains(r)));
}

/// A smaller error takes more substeps, or fewer nodes on a board that has no time for more
/// substeps.
#[test]
fn moving_error_takes_substeps_or_nodes() {
    let stiff = edited(&edited(SMALL_BLOCK, "3500.0", "20000.0"), "ramp_m_per_s = 0.04", "ramp_m_per_s = 0.2");
    let asked = |pct: &str| format!("{stiff}[solver]\nmoving_error_pct = {pct}\n");
    let [loose, tight] = ["50.0", "2.0"].map(|pct| press(SCRATCH, &asked(pct)));
    assert!(tight.number("/substeps") > loose.number("/substeps"));
    assert_eq!(tight.summary["report"]["moving"]["within"], true);
    assert!(loose.number("/report/moving/rms_pct") > 2.0);
    let nodes = |pct: &str| {
        let desk = Desk::default();
        desk.put("scene.toml", asked(pct));
        let packed = palpate(SCRATCH, desk.folder(), &["pack", "--scene", "scene.toml", "--board", "m7-480", "--out", "packed"]);
        assert_eq!(packed.code, Some(0), "{}", packed.stderr);
        let (before, _) = packed.stdout.split_once(" nodes,").expect("the number of nodes");
        before.rsplit(' ').next().and_then(|n| n.parse::<u32>().ok()).expect("a number")
    };
    let (many, few) = (nodes("50.0"), nodes("3.0"));
    println!("{many} nodes, {few} for 3 %");
    assert!(few < many);
}

#[test]
fn packed_patch_presses_like_the_scene_it_came_from() {
    let desk = Desk::default();
    desk.put("scene.toml", SMALL_BLOCK);
    let pack = ["pack", "--scene", "scene.toml", "--board", "desktop", "--out", "packed"];
    assert_eq!(palpate(SCRATCH, desk.folder(), &pack).code, Some(0));
    // without the block, the scene's mesh comes from the patch alone
    let scene = edited(&edited(&edited(SMALL_BLOCK, BLOCK, ""), NODES, ""), PLACE, "");
    let run = press_at(SCRATCH, desk, &format!("{scene}[solver]\npatch = \"packed/small-desktop.patch\"\n"), &[]);
    assert_eq!(run.summary["state_hash"], small().summary["state_hash"]);
    assert_eq!(run.forces_n(), small().forces_n());
}

fn cube_scene(unit: &str, site: &str) -> String {
    let scene = edited(SMALL_BLOCK, BLOCK, &format!("mesh = \"cube.msh\"\nlength_unit = {unit}"));
    edited(&edited(&scene, NODES, ""), PLACE, &format!("site = {site}"))
}

#[test]
fn up_turns_the_mesh() {
    // 40 x 20 x 40 mm, so that a turn shows
    let flat: String = cube(6, 0.04)
        .lines()
        .map(|line| match line.split(' ').collect::<Vec<_>>()[..] {
            [node, x, y, z] => format!("{node} {x} {} {z}\n", y.parse::<f64>().unwrap() / 2.0),
            _ => format!("{line}\n"),
        })
        .collect();
    let pressed = |up: &str, site: &str| {
        let desk = Desk::default();
        desk.put("cube.msh", &flat);
        press_at(SCRATCH, desk, &edited(&cube_scene("\"m\"", site), "length_unit", &format!("{up}length_unit")), &[])
    };
    for (up, site, sides_mm) in [
        ("", "[0.02, 0.01, 0.04]", [40.0, 20.0, 40.0]),
        ("up = \"y\"\n", "[0.02, 0.02, 0.02]", [40.0, 40.0, 20.0]),
        ("up = \"-x\"\n", "[0.01, -0.02, 0.0]", [20.0, 40.0, 40.0]),
    ] {
        let run = pressed(up, site);
        for (axis, side_mm) in sides_mm.into_iter().enumerate() {
            assert!((run.number(&format!("/report/size_mm/{axis}")) - side_mm).abs() < 1e-4, "{up}");
        }
    }
}

#[test]
fn length_unit_scales_the_mesh() {
    let pressed = |n: usize, side: f64, unit: &str, site: &str| {
        let desk = Desk::default();
        desk.put("cube.msh", cube(n, side));
        press_at(SCRATCH, desk, &cube_scene(unit, site), &[])
    };
    let top = "[0.02, 0.02, 0.04]";
    let metres = pressed(6, 0.04, "\"m\"", top);
    assert!((metres.number("/report/size_mm/0") - 40.0).abs() < 1e-4);
    for (side, unit) in [(40.0, "\"mm\""), (40.0, "0.001"), (2.0, "0.02"), (0.04, "1")] {
        let same = pressed(6, side, unit, top);
        // coordinates differ in their last bit
        for ratio in ratios(&same, &metres) {
            assert!((ratio - 1.0).abs() < 1e-3, "{side} x {unit}: {ratio}");
        }
    }
    let twice = pressed(11, 0.04, "2.0", "[0.04, 0.04, 0.08]");
    assert!((twice.number("/report/size_mm/0") - 80.0).abs() < 1e-4);
    assert!((twice.number("/report/mass_g") / metres.number("/report/mass_g") / 8.0 - 1.0).abs() < 1e-5);
}

#[test]
fn site_is_pressed_along_its_normal() {
    let desk = Desk::default();
    desk.put("cube.msh", cube(9, 0.06));
    // outside the face toward the operator, a millimetre from it
    let run = press_at(SCRATCH, desk, &cube_scene("\"m\"", "[0.061, 0.03, 0.03]"), &[]);
    let forces =
        ["force_x_n", "force_y_n", "force_z_n"].map(|c| run.trace.column(c).into_iter().fold(0.0, |a: f64, f| a.max(f.abs())));
    assert!((forces[0] - run.forces_n()[2]).abs() < 0.5 * forces[0] && forces[1].max(forces[2]) < 0.3 * forces[0], "{forces:?}");
    let x = run.trace.column("probe_x_m");
    let deepest = x.iter().copied().fold(f64::INFINITY, f64::min);
    assert!((deepest - 0.056).abs() < 1e-6, "{deepest}");
}

/// Scene of an organ pressed from above, with more keys of its tissue.
fn organ_scene(name: &str, site: &str, more: &str) -> String {
    let scene = edited(SMALL_BLOCK, BLOCK, &format!("organ = \"{name}\"\n{more}"));
    edited(&edited(&scene, NODES, ""), PLACE, &format!("site = {site}"))
}

#[test]
fn organ_has_its_shape_its_nodes_and_its_regions() {
    let foot = |more: &str| press(SCRATCH, &organ_scene("foot", "[-0.075, 0.0, 0.031]", more));
    let plain = foot("nodes = 300");
    assert!((plain.number("/report/size_mm/0") / 250.0 - 1.0).abs() < 0.1);
    assert!((plain.number("/nodes") / 300.0 - 1.0).abs() < 0.15);
    // the probe comes down on the sole
    assert!(plain.trace.column("probe_z_m").into_iter().fold(1.0, f64::min) < 0.03);
    let all = ["skin", "fat pad", "deep tissue"].map(|name| format!("{{ name = \"{name}\", youngs_modulus_pa = 7000.0 }}"));
    let all = ratios(&foot(&format!("nodes = 300\nregion = [{}]", all.join(", "))), &plain);
    let fat_alone = foot("nodes = 300\nregion = [{ name = \"fat pad\", youngs_modulus_pa = 7000.0 }]");
    let fat = ratios(&fat_alone, &plain);
    let stiffening = ratios(
        &foot("nodes = 300\nregion = [{ name = \"fat pad\", youngs_modulus_pa = 7000.0, stiffening_b = 10.0 }]"),
        &fat_alone,
    );
    println!("all regions twice as stiff {all:.4?}, fat alone {fat:.4?}, that stiffens {stiffening:.4?}");
    assert!(stiffening.iter().all(|r| *r > 1.001) && stiffening.is_sorted_by(|a, b| a < b), "{stiffening:?}");
    // every stiffness is doubled except that of the contact, which follows the scene's own modulus
    // and acts in series
    assert!(all.iter().all(|r| (1.3..2.0).contains(r)) && all.is_sorted_by(|a, b| a < b));
    assert!(fat.iter().zip(&all).all(|(fat, all)| *fat > 1.1 && fat < all));
}
