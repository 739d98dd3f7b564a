//! The model half of the stability matrix: verdicts follow their definitions, methods fail where
//! expected, and the product withstands the cases for which it promises to do so.
//!
//! `--nocapture` prints the figures.

use crate::share::Share;
use palpate::ClampFlags;
use palpate_lab::methods::Method;
use palpate_lab::stability::model::{
    Axis, Build, BuiltMethod, CASES, CaseTissue, Figures, LoadCase, Loading, Matrix, Promise, ROWS, Row, Scope, Stimulus, Trace,
    Verdict, judge, largest, margin, promises, report, run,
};
use palpate_lab::study::Findings;
use palpate_tissue::patch::{Material, Patch};
use palpate_tissue::stable_step::StableStep;

const NODES: usize = 130;
const PALPATE: Row = Row { method: Method::Palpate, build: Build::Derived };

fn case(name: &str) -> LoadCase {
    CASES.into_iter().find(|c| c.name == name).expect("a case of this name")
}

fn built(method: Method, youngs_modulus_pa: f64) -> BuiltMethod {
    let row = Row { method, build: Build::Derived };
    BuiltMethod::new(row, NODES, youngs_modulus_pa, CaseTissue::Plain).expect("built").expect("to be had")
}

fn stand(method: &BuiltMethod, name: &str) -> Figures {
    let figures = method.stand(&case(name).stimulus).expect("built");
    println!("{}, {} substeps, {name}: {figures:?}", method.row.name(), method.substeps);
    figures
}

type Spoil = fn(&mut Trace);

/// A press without defects: 1 N at 8 mm.
fn sound() -> Trace {
    Trace {
        loading: (0..100).map(|n| Loading { depth_m: f64::from(n) * 8e-5, force_n: f64::from(n) * 0.01 }).collect(),
        diverged_at_m: None,
        lowest_j: 0.4,
        held_j: 0.5,
        peak_n: 1.0,
        held_n: 1.0,
        moved_m: 1e-6,
        force_change: 1e-3,
        residual_m: 1e-6,
        limiters: ClampFlags::DEFAULT,
    }
}

#[test]
fn verdicts_say_what_is_wrong_first() {
    let held = ClampFlags::DEPTH;
    // each entry spoils such a press in one way, from the mildest to the worst
    let spoilt: [(Verdict, Spoil); 7] = [
        (Verdict::Pass, |_| {}),
        (Verdict::NonMonotone, |t| t.loading[60].force_n -= 0.04),
        (Verdict::Deformed, |t| t.residual_m = 6e-5),
        (Verdict::Restless, |t| t.moved_m = 6e-5),
        (Verdict::Pierced, |t| t.held_n = 0.0),
        (Verdict::Inverted, |t| t.lowest_j = 0.04),
        (Verdict::Diverged, |t| t.diverged_at_m = Some(4e-3)),
    ];
    let mut all = sound();
    for (verdict, spoil) in spoilt {
        let mut one = sound();
        spoil(&mut one);
        assert_eq!(judge(&one, true).verdict, verdict);
        spoil(&mut all);
        assert_eq!(judge(&all, true).verdict, verdict, "the worst of several is said");
    }
    assert_eq!(judge(&Trace { limiters: held, ..sound() }, true).verdict, Verdict::Held);
    assert_eq!(
        judge(&Trace { limiters: held, residual_m: 1e-3, ..sound() }, true).verdict,
        Verdict::Deformed,
        "held is no excuse"
    );
    assert_eq!(judge(&Trace { limiters: ClampFlags::SPEED, ..sound() }, true).verdict, Verdict::Pass);
    assert_eq!(judge(&Trace { force_change: 0.06, ..sound() }, true).verdict, Verdict::Restless);
    // an unmeasured value does not pass
    assert_eq!(judge(&Trace { residual_m: f64::NAN, ..sound() }, true).verdict, Verdict::Deformed);
    assert_eq!(judge(&Trace { lowest_j: f64::NAN, ..sound() }, true).verdict, Verdict::Inverted);
    // the force of a tap may fall during loading, by inertia
    let mut tap = sound();
    tap.loading[60].force_n = 0.3;
    let figures = judge(&tap, false);
    assert_eq!(figures.verdict, Verdict::Pass);
    assert!((figures.drop_pct - 100.0 * 0.29 / 0.99).abs() < 1e-9, "{}", figures.drop_pct);
}

#[test]
fn a_search_ends_at_what_passes() {
    for limit in [0.36, 1.0, 1.37, 1.99] {
        let mut trials = 0;
        let found = largest([0.35, 2.0], 1.0, |value| {
            trials += 1;
            Ok(if value <= limit { Verdict::Pass } else { Verdict::Restless })
        });
        let found = found.expect("no trial fails");
        let passes = found.passes.expect("the smallest passes");
        assert!(passes <= limit && passes * 1.05 >= limit, "{passes} of {limit}");
        assert_eq!(found.beyond, Some(Verdict::Restless));
        assert!(trials <= 9, "{trials} trials");
    }
    let all = largest([1.0, 8.0], 2.0, |_| Ok(Verdict::Pass)).expect("no trial fails");
    assert_eq!((all.passes, all.beyond), (Some(8.0), None));
    let none = largest([1.0, 8.0], 2.0, |_| Ok(Verdict::Held)).expect("no trial fails");
    assert_eq!((none.passes, none.beyond), (None, Some(Verdict::Held)), "held is not passed");
}

#[test]
fn methods_fail_where_they_are_known_to() {
    // plain springs have nothing that prevents a tet from inverting
    assert_eq!(stand(&built(Method::Springs, 3.5e3), "press-20").verdict, Verdict::Inverted);
    // a matrix factored at rest: stiffer tissue needs more substeps, and with one substep too few
    // it diverges
    let implicit = built(Method::Implicit, 100e3);
    assert!(implicit.substeps > 1, "{} substeps", implicit.substeps);
    let mut too_few = implicit.clone();
    too_few.substeps -= 1;
    assert_ne!(stand(&implicit, "press-20").verdict, Verdict::Diverged);
    let diverged = stand(&too_few, "press-20");
    assert_eq!(diverged.verdict, Verdict::Diverged);
    assert!(diverged.diverged_at_mm.is_some_and(|mm| mm > 1.0 && mm <= 8.0), "{diverged:?}");
    // without the guard even the product does not withstand 16 mm
    let row = Row { method: Method::Palpate, build: Build::Unguarded };
    let unguarded = BuiltMethod::new(row, NODES, 3.5e3, CaseTissue::Plain).expect("built").expect("to be had");
    assert!(stand(&unguarded, "press-40").verdict > Verdict::Held);
    assert_eq!(stand(&unguarded, "press-20").verdict, Verdict::Pass);
}

/// A matrix with all columns, so that every promise is checked.
fn promised() -> Matrix {
    let scope = Scope {
        nodes: NODES,
        rows: vec![PALPATE, Row { method: Method::Calibrated, build: Build::Derived }],
        moduli_pa: vec![3.5e3, 100e3],
        cases: CASES.into_iter().filter(|c| c.promise != Promise::None).collect(),
        margins_at_pa: vec![],
    };
    let part = run(&scope, 0..scope.places(), &|| ()).expect("built");
    Matrix { cells: part.cells, margins: part.margins, scope }
}

#[test]
fn the_product_stands_what_it_promises() {
    let matrix = promised();
    assert_eq!(matrix.cells.len(), 2 * 2 * 14);
    for cell in &matrix.cells {
        println!("{} {} Pa {}: {:?}", cell.row.name(), cell.youngs_modulus_pa, cell.case.name, cell.figures);
    }
    assert_eq!(promises(&matrix), Vec::<String>::new());

    // a broken promise is reported in one line that names it
    for (name, spoil) in [
        ("tap-0.5", (|f| f.lowest_j = 0.19) as fn(&mut Figures)),
        ("release", |f| f.verdict = Verdict::Deformed),
        ("press-40", |f| f.verdict = Verdict::Pass),
        ("press-20", |f| f.verdict = Verdict::Held),
    ] {
        let mut worse = matrix.clone();
        let cell = worse.cells.iter_mut().find(|c| c.case.name == name).expect("a cell of this case");
        spoil(&mut cell.figures);
        let broken = promises(&worse);
        assert_eq!(broken.len(), 1, "{broken:?}");
        assert!(broken[0].contains(name) && broken[0].contains("palpate at 3.5 kPa") && !broken[0].contains('\n'), "{broken:?}");
    }

    let mut findings = Findings::default();
    report(&matrix, &mut findings);
    let csv = findings.tables.iter().map(|table| table.csv()).collect::<Vec<_>>();
    assert_eq!(csv[1].lines().count(), 1 + matrix.cells.len());
    assert_eq!(csv[2].lines().count(), 1, "no margins were asked for");
    assert!(findings.claims[0].promised && findings.claims[0].holds == Some(true));
    let folder = tempfile::tempdir().expect("a temporary folder");
    findings.figures[0].draw(folder.path()).expect("drawn");
    let svg = std::fs::read_to_string(folder.path().join("stability_model.svg")).expect("a picture");
    assert!(svg.contains("palpate-calibrated"));
}

/// Every method's tissue contains the inclusion: at 1.5 mm depth, where no method has failed yet,
/// it adds some per cent to the force.
#[test]
fn every_method_feels_the_inclusion() {
    let press = Stimulus { depth_m: 1.5e-3, ..case("press-20").stimulus };
    let mut share = Share::one_in(3);
    for row in ROWS.into_iter().filter(|_| share.takes()) {
        let [plain_n, stiffer_n] = [CaseTissue::Plain, CaseTissue::Inclusion].map(|tissue| {
            let method = BuiltMethod::new(row, NODES, 3.5e3, tissue).expect("built").expect("to be had");
            method.press(&press).expect("built").held_n
        });
        let ratio = stiffer_n / plain_n;
        println!("{}: {plain_n} N, with the inclusion {ratio} of it", row.name());
        assert!((1.01..1.3).contains(&ratio), "{}: {ratio}", row.name());
    }
}

/// Only the product has friction and stiffening, and they change its force.
#[test]
fn terms_are_felt_by_the_product_and_had_by_no_other() {
    let held_n = |tissue| {
        let row = Row { method: Method::Calibrated, build: Build::Derived };
        let method = BuiltMethod::new(row, NODES, 3.5e3, tissue).expect("built").expect("to be had");
        let figures = method.stand(&case("press-20").stimulus).expect("built");
        assert_eq!(figures.verdict, Verdict::Pass, "{tissue:?}: {figures:?}");
        figures.held_n
    };
    let [plain, rubs, stiffens] = [CaseTissue::Plain, CaseTissue::Frictional, CaseTissue::Stiffening].map(held_n);
    println!("{plain} N, {rubs} N with friction, {stiffens} N where it stiffens");
    assert!(rubs > 1.02 * plain && stiffens > 2.0 * plain, "{plain}, {rubs}, {stiffens} N");
    let other = Row { method: Method::NeoHookean, build: Build::Derived };
    assert!(BuiltMethod::new(other, NODES, 3.5e3, CaseTissue::Frictional).expect("built").is_none());
}

/// Jitter changes the times of the poses but not their order.
#[test]
fn jitter_moves_the_poses_and_keeps_their_order() {
    let palpate = built(Method::Palpate, 3.5e3);
    let ways = ["press-20", "jitter-press"].map(|name| palpate.press(&case(name).stimulus).expect("built").loading);
    let steps = ways.map(|way| way.windows(2).map(|w| w[1].depth_m - w[0].depth_m).collect::<Vec<f64>>());
    let extremes = |steps: &[f64]| steps.iter().fold((f64::MAX, f64::MIN), |(l, h), s| (l.min(*s), h.max(*s)));
    let ((even_least, even_most), (least, most)) = (extremes(&steps[0]), extremes(&steps[1]));
    assert!((even_least - 4e-5).abs() < 1e-9 && (even_most - 4e-5).abs() < 1e-9, "{even_least} to {even_most} m a tick");
    assert!((0.0..1e-5).contains(&least) && (7e-5..8e-5).contains(&most), "{least} to {most} m a tick");
}

/// A margin below one is searched with ticks down to a third of a millisecond.
#[test]
fn every_tick_of_the_search_can_be_built() {
    for method in [Method::Palpate, Method::Calibrated] {
        let method = built(method, 20e3);
        for value in Axis::Tick.range() {
            let shallow = Stimulus { depth_m: 1e-3, ..case("press-20").stimulus };
            let stood = method.with_tick((value * 1e-3) as f32).stand(&shallow);
            assert!(stood.is_ok(), "{value} ms: {stood:?}");
        }
    }
}

/// The product's margins agree with independent bounds: its depth limit, and the highest frequency
/// of its stiffness when pressed.
#[test]
fn the_products_margins_are_where_its_bounds_are() {
    let palpate = built(Method::Palpate, 3.5e3);
    let depth = margin(&palpate, Axis::Depth).expect("built");
    let passes_m = depth.passes.expect("shallow presses pass");
    println!("depth {depth:?}");
    assert!(passes_m <= 10e-3 && passes_m * 1.05 >= 10e-3 && depth.beyond == Some(Verdict::Held), "limit 10 mm: {depth:?}");

    // with lighter nodes the bound lies within the range of ticks that are tried
    for relative_mass in [false, true] {
        let mut light = palpate.clone();
        (light.block.params.mass_floor, light.block.params.terms.relative_mass) = (1.0, relative_mass);
        (light.block.params.substeps, light.substeps) = (1, 1);
        let press = case("press-20").stimulus;
        let tick = largest(Axis::Tick.range(), 1.0, |value| Ok(light.with_tick((value * 1e-3) as f32).stand(&press)?.verdict));
        let tick = tick.expect("built");
        let mut patch = Patch::build(&light.block.tissue, &Material::default(), None);
        patch.set_depth_limit_m(8e-3);
        let stable =
            StableStep::measure(&patch.wide_model(), &light.block.params, patch.site_m()).expect("built").expect("survives");
        let bound_ms = stable.pressed_s * 1e3;
        println!("relative mass {relative_mass}: tick {tick:?} ms, bound {bound_ms} ms");
        let over = tick.passes.expect("short ticks pass") / bound_ms;
        assert!((0.93..=1.15).contains(&over), "a press fails at {over} of the bound, {bound_ms} ms");
    }
}
