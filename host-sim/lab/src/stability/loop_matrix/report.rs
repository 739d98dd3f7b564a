//! Tables and pictures of the loop matrix.

use crate::stability::controller::{CONTROLLERS, Controller};
use palpate_charts::{Bar, Bars, Figure, Form, Heat, HeatCell, HeatGroup, HeatRow, ScaledAxis, Tone};
use palpate_loop::closed_loop::device::{DeviceProfile, PROFILES};
use palpate_loop::closed_loop::hand::HANDS;
use palpate_sim::error::Error;

use super::{Cell, HELD_N_PER_M, LoopSummary, MOST_CREATED_J, MOST_STATIC_ERROR, STEP, SWEPT, walls_n_per_m};
use crate::study::{Claim, Findings, Table};

/// Delays at which the swept devices are run [ticks].
const DELAYS: [u8; 3] = [0, 1, 2];
/// Delay for which the created energy is drawn [ticks], which is that of the shipped devices.
const DRAWN_DELAY: u8 = 1;
/// Error of a held wall of 400 N/m from which a control does not render the wall (1).
const DRAWN_ERROR: f64 = 0.05;
/// Smallest energy that is drawn [mJ].
const LEAST_MJ: f64 = 1e-3;

/// Adds the tables, the pictures and the claim of the matrix.
pub fn report(summary: &LoopSummary, findings: &mut Findings) -> Result<(), Error> {
    let cells = Table::rows("stability_loop", &summary.cells)
        .col("device", |c| c.device.clone())
        .col("delay_ticks", |c| c.delay_ticks)
        .col("hand", |c| c.hand)
        .col("control", |c| c.control.clone())
        .col("stiffest_n_per_m", |c| c.climb.n_per_m)
        .col("at_least", |c| c.climb.at_least)
        .col("passive_n_per_m", |c| c.passive_n_per_m)
        .col("at_400_holds", |c| c.held.holds())
        .col("at_400_created_mj", |c| c.held.created_mj)
        .col("at_400_static_error", |c| c.held.static_error)
        .only(|c| c.control == Controller::Ours.name());
    let slopes = summary.ceilings.iter().flat_map(|c| c.slopes.iter().map(move |slope| (c, slope)));
    let mut slopes = Table::rows("ceilings", slopes)
        .col("device", |(c, _)| c.device.clone())
        .csv("count_m", |(c, _)| c.count_m)
        .csv("friction_n", |(c, _)| c.friction_n)
        .csv("limit_n", |(c, _)| c.limit_n)
        .col("felt_n_per_m", |(c, _)| c.felt_n_per_m)
        .col("youngs_modulus_pa", |(_, slope)| slope.youngs_modulus_pa)
        .col("depth_m", |(_, slope)| slope.depth_m)
        .col("force_n", |(_, slope)| slope.force_n)
        .col("slope_n_per_m", |(_, slope)| slope.n_per_m);
    for (n, (hand, _)) in summary.ceilings.first().map_or(&[][..], |c| &c.held_pa).iter().enumerate() {
        slopes = slopes.col(&format!("{}_holds_pa", hand.to_lowercase()), |(c, _)| c.held_pa.get(n).map(|(_, pa)| *pa));
    }
    let found = match summary.broken.as_slice() {
        [] => "all".to_owned(),
        broken => broken.join("; "),
    };
    findings.claims.push(Claim::promise(
        format!("hands in which our loop holds a wall of {HELD_N_PER_M} N/m without shaking"),
        format!("all seven; at most {:.2} mJ given and {:.1} % static error", MOST_CREATED_J * 1e3, MOST_STATIC_ERROR * 100.0),
        found,
        summary.broken.is_empty(),
    ));
    findings.tables.extend([
        cells.about(
            "stiffest wall that is tapped at 0.2 m/s and held without shaking, in steps of 12 % from 50 N/m; a wall of 400 N/m",
        ),
        slopes
            .all()
            .about("limit of the encoder: the stiffness from which a count is felt, slopes of tissues, the stiffest held"),
    ]);
    findings.notes.push(format!("hands: {}", HANDS.map(|h| format!("{} {}", h.id, h.name)).join(", ")));
    for device in SWEPT.into_iter().filter(|d| summary.cells.iter().any(|c| c.device == *d)) {
        findings.figures.push(swept(summary, device)?);
    }
    if summary.cells.iter().any(|c| !SWEPT.contains(&c.device.as_str())) {
        findings.figures.push(profiles(summary)?);
    }
    findings.figures.push(energy(summary));
    Ok(())
}

/// Cell of a stiffness, coloured by its ratio to what the maker of the device names.
fn heat(n_per_m: f64, at_least: bool, named_n_per_m: f64) -> HeatCell {
    let said = match n_per_m {
        0.0 => "–".into(),
        k if k >= stiffest_tried_n_per_m() => "all".into(),
        k if at_least => format!(">{k:.0}"),
        k => format!("{k:.0}"),
    };
    Tone::Ratio(n_per_m / named_n_per_m).cell(said)
}

fn stiffest_tried_n_per_m() -> f64 {
    walls_n_per_m().last().unwrap_or(f64::NAN)
}

fn climbed(cell: &Cell, named_n_per_m: f64) -> HeatCell {
    heat(cell.climb.n_per_m, cell.climb.at_least, named_n_per_m)
}

/// Row of a control, with how far off the force of a wall is that it does not render.
fn control_row<'a>(name: String, cells: impl Iterator<Item = &'a Cell>, heats: Vec<HeatCell>) -> HeatRow {
    let errors = cells.filter_map(|c| c.held.static_error);
    let worst = errors.fold(0.0, |worst: f64, error| if error.abs() > worst.abs() { error } else { worst });
    let name = if worst.abs() < DRAWN_ERROR { name } else { format!("{name} ({:+.0} %)", worst * 100.0) };
    HeatRow { name, apart: false, cells: heats }
}

/// A matrix of stiffnesses; `unit` says what one is for a ratio to what the maker names.
fn matrix(
    name: String,
    title: String,
    groups: Vec<HeatGroup>,
    rows: Vec<HeatRow>,
    foot: &str,
    unit: impl Fn(f64) -> String,
) -> Figure {
    let key = [0.125, 0.5, 1.0, 2.0, 8.0].map(|ratio| (Tone::Ratio(ratio).cell(""), unit(ratio)));
    let below = format!(
        "Largest [N/m] without a limit cycle, tap at 0.2 m/s and hold; >: none shook; all: to {:.0}; –: 50 shakes; (%): force off at 400",
        stiffest_tried_n_per_m()
    );
    Figure { name, title, below, form: Form::Heat(Heat { groups, rows, key: key.into(), foot: foot.into() }) }
}

fn swept(summary: &LoopSummary, device: &str) -> Result<Figure, Error> {
    let named = DeviceProfile::load(device)?.stiffness_ceiling_n_per_m;
    let late = ["no delay", "1 tick late", "2 ticks late"];
    let group = |late: &str| HeatGroup { label: [String::new(), late.to_owned()], feet: HANDS.map(|h| h.id.to_owned()).to_vec() };
    let cells = |control: &str| DELAYS.iter().flat_map(|d| summary.row(device, *d, control)).collect::<Vec<_>>();
    let of = |name: String| {
        let cells = cells(&name);
        let heats = cells.iter().map(|c| climbed(c, named)).collect();
        control_row(name, cells.into_iter(), heats)
    };
    let passive = cells(&CONTROLLERS[0].name()).into_iter().map(|c| heat(c.passive_n_per_m, false, named));
    let passive = HeatRow { name: "passive (closed form)".into(), apart: true, cells: passive.collect() };
    let rows = CONTROLLERS.iter().map(|c| of(c.name())).chain([passive]).collect();
    let title = format!("Stiffest wall that does not shake the hand: {device} (its maker names {named:.0} N/m)");
    let unit = |ratio: f64| match ratio {
        1.0 => format!("{named:.0} N/m, as its maker names"),
        _ => format!("{:.0} N/m", ratio * named),
    };
    Ok(matrix(format!("stiffness_{device}"), title, late.map(group).into(), rows, "hand", unit))
}

/// Every profile at its own delay, with the hand that has the lowest limit.
fn profiles(summary: &LoopSummary) -> Result<Figure, Error> {
    let devices = PROFILES.iter().map(|(name, _)| Ok((*name, DeviceProfile::load(name)?)));
    let devices = devices.collect::<Result<Vec<_>, Error>>()?;
    // lowest limit among the hands with which the loop shakes; a lower bound if it shakes with none
    let worst = |control: &str, (name, device): &(&str, DeviceProfile)| {
        let cells: Vec<&Cell> = summary.row(name, device.delay_ticks, control).collect();
        let least = |bounds: bool| {
            let of = cells.iter().filter(|c| c.climb.at_least == bounds);
            of.min_by(|a, b| a.climb.n_per_m.total_cmp(&b.climb.n_per_m))
        };
        let named = device.stiffness_ceiling_n_per_m;
        least(false).or(least(true)).map_or(heat(0.0, false, named), |cell| climbed(cell, named))
    };
    let row = |name: String| HeatRow { cells: devices.iter().map(|d| worst(&name, d)).collect(), name, apart: false };
    let first = CONTROLLERS[0].name();
    let passive = devices.iter().filter_map(|(name, device)| {
        let cell = summary.row(name, device.delay_ticks, &first).next()?;
        Some(heat(cell.passive_n_per_m, false, device.stiffness_ceiling_n_per_m))
    });
    let passive = HeatRow { name: "passive (closed form)".into(), apart: true, cells: passive.collect() };
    let rows = CONTROLLERS.iter().map(|c| row(c.name())).chain([passive]).collect();
    let group = |(name, device): &(&str, DeviceProfile)| HeatGroup {
        label: [(*name).to_owned(), format!("{:.0}", device.stiffness_ceiling_n_per_m)],
        feet: vec![String::new()],
    };
    let title = "Stiffest wall that does not shake the worst of seven hands: every device, and what its maker names";
    Ok(matrix("stiffness_profiles".into(), title.into(), devices.iter().map(group).collect(), rows, "", |ratio| {
        format!("{ratio} x what its maker names")
    }))
}

/// Energy that each controller gives to the worst hand, with its static error and the hands that it
/// shakes.
fn energy(summary: &LoopSummary) -> Figure {
    let devices: Vec<&str> = SWEPT.into_iter().filter(|d| summary.cells.iter().any(|c| c.device == *d)).collect();
    let bar = |name: &str, device: &str| {
        let cells: Vec<&Cell> = summary.row(device, DRAWN_DELAY, name).collect();
        let created_mj = cells.iter().map(|c| c.held.created_mj).fold(0.0, f64::max);
        let larger = |worst: f64, error: f64| if error.abs() > worst.abs() { error } else { worst };
        let error = cells.iter().filter_map(|c| c.held.static_error).fold(0.0, larger);
        let shaken = cells.iter().filter(|c| !c.held.quiet).count();
        Bar {
            name: name.to_owned(),
            kind: device.to_owned(),
            span: [LEAST_MJ, created_mj.max(LEAST_MJ)],
            whiskers: None,
            mark: None,
            allowed: (name == Controller::Ours.name()).then_some(MOST_CREATED_J * 1e3),
            text: format!("{:+.0} %, {shaken} of {} shaken", error * 100.0 + 0.0, cells.len()),
        }
    };
    let bars =
        CONTROLLERS.iter().flat_map(|control| devices.iter().map(|device| bar(&control.name(), device)).collect::<Vec<_>>());
    Figure {
        name: "created_energy".into(),
        title: format!("Energy that the loop gives to the hand at {HELD_N_PER_M:.0} N/m"),
        below: "Tap at 0.2 m/s, one tick late, worst of seven hands; beside: static error, hands shaken; stroke: promised".into(),
        form: Form::Bars(Bars { axis: ScaledAxis::log("energy created in the worst contact [mJ]"), bars: bars.collect() }),
    }
}

const _: () = assert!(STEP == 1.12, "captions say 12 %");
