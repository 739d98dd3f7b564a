//! Tables and pictures of the loop matrix.

use std::fmt::Write as _;

use super::ceiling::Ceiling;
use super::{Cell, Climb, HELD_N_PER_M, LoopSummary, MOST_CREATED_J, MOST_STATIC_ERROR, STEP, SWEPT};
use crate::error::Error;
use crate::stability::controller::{CONTROLLERS, Controller};
use palpate_charts::{
    CreatedEnergy, EnergyRow, MatrixCell, MatrixGroup, MatrixRow, StiffnessMatrix, created_energy, stiffness_matrix,
};
use palpate_loop::closed_loop::device::{DeviceProfile, PROFILES};
use palpate_loop::closed_loop::hand::HANDS;
use palpate_tissue::output::OutputFolder;

/// Delays at which the swept devices are run [ticks].
const DELAYS: [u8; 3] = [0, 1, 2];
/// Delay for which the created energy is drawn [ticks], which is that of the shipped devices.
const DRAWN_DELAY: u8 = 1;
/// Smallest static error that is reported (1).
const SEEN_ERROR: f64 = 5e-3;

/// Writes `stability_loop.csv` and `ceilings.csv`.
///
/// # Errors
/// The folder cannot be written.
pub fn write(folder: &OutputFolder, summary: &LoopSummary) -> Result<(), Error> {
    let mut text = String::from(
        "device,delay_ticks,hand,control,stiffest_n_per_m,at_least,passive_n_per_m,at_400_holds,at_400_created_mj,at_400_static_error\n",
    );
    for c in &summary.cells {
        let held = &c.held;
        let _ = writeln!(
            text,
            "{},{},{},{},{},{},{},{},{},{}",
            c.device,
            c.delay_ticks,
            c.hand,
            c.control,
            c.climb.n_per_m,
            c.climb.at_least,
            c.passive_n_per_m,
            held.holds(),
            held.created_mj,
            held.static_error.map_or(String::new(), |e| e.to_string())
        );
    }
    folder.write("stability_loop.csv", text.as_bytes())?;
    Ok(folder.write("ceilings.csv", ceilings_csv(&summary.ceilings).as_bytes())?)
}

/// Formats one row per device, tissue and depth; the stiffest tissues held are repeated in every
/// row of a device.
fn ceilings_csv(ceilings: &[Ceiling]) -> String {
    let mut text = String::from("device,count_m,friction_n,limit_n,felt_n_per_m,youngs_modulus_pa,depth_m,force_n,slope_n_per_m");
    let hands = ceilings.first().map(|c| c.held_pa.as_slice()).unwrap_or_default();
    for (hand, _) in hands {
        let _ = write!(text, ",{}_holds_pa", hand.to_lowercase());
    }
    text.push('\n');
    for c in ceilings {
        for s in &c.slopes {
            let (e, depth_m) = (s.youngs_modulus_pa, s.depth_m);
            let _ = write!(text, "{},{},{},{},{},{e},{depth_m}", c.device, c.count_m, c.friction_n, c.limit_n, c.felt_n_per_m);
            let _ = write!(text, ",{},{}", s.force_n, s.n_per_m);
            for (_, held_pa) in &c.held_pa {
                let _ = write!(text, ",{held_pa}");
            }
            text.push('\n');
        }
    }
    text
}

/// Prints the main results of our controller, or of all controllers.
pub fn print(summary: &LoopSummary, all: bool) {
    let shown: Vec<String> =
        CONTROLLERS.iter().filter(|c| all || **c == Controller::Ours).map(|controller| controller.name()).collect();
    let names = HANDS.map(|h| format!("{} {}", h.id, h.name)).join(", ");
    let hands = HANDS.map(|h| format!("{:>6}", h.id)).join("");
    println!(
        "by hand: the stiffest wall that is tapped at 0.2 m/s and held without shaking [N/m], in steps of 12 % from 50 (>: none shook); 400 and more is promised"
    );
    println!(
        "at 400 N/m, over all hands: mJ given to the worst (at most {:.2} promised), how many shake (none), static error % in the others (at most {:.1})",
        MOST_CREATED_J * 1e3,
        MOST_STATIC_ERROR * 100.0
    );
    println!("hands: {names}\n");
    for device in SWEPT {
        for delay in DELAYS {
            let Some(first) = summary.cells.iter().find(|c| c.device == device && c.delay_ticks == delay) else { continue };
            println!(
                "{device}, force {delay} ticks late (by theory the device holds {:.0} N/m in any hand without a controller)",
                first.passive_n_per_m
            );
            println!("  {:<18}{hands}{:>10}{:>8}{:>8}", "", "mJ given", "shaken", "error %");
            for control in &shown {
                let cells: Vec<&Cell> = summary.row(device, delay, control).collect();
                let stiffest: String = cells.iter().map(|c| said(c.climb)).collect();
                let (created_mj, shaken, error) = (worst_mj(&cells), shaken(&cells), worst_error(&cells) * 100.0 + 0.0);
                println!("  {control:<18}{stiffest}{created_mj:>10.3}{shaken:>8}{error:>8.1}");
            }
            println!();
        }
    }
    print_ceilings(&summary.ceilings);
}

fn print_ceilings(ceilings: &[Ceiling]) {
    println!("limit of the encoder, whatever the controller; felt: the contact stiffness from which one encoder count is felt;");
    println!(
        "then the stiffness of blocks under the probe at their deepest press (*: above that), and the stiffest tissue held quietly by hand"
    );
    let hands = ceilings.first().map(|c| c.held_pa.as_slice()).unwrap_or_default();
    let names: String = hands.iter().map(|(hand, _)| format!("{:>7}", format!("{hand} kPa"))).collect();
    println!(
        "  {:<14}{:>8}{:>9}{:>10}{:>14}{:>14}{:>14}  {names}",
        "", "count um", "limit N", "felt N/m", "3.5 kPa N/m", "20 kPa", "100 kPa"
    );
    for c in ceilings {
        let deepest = |e: f64| {
            let slope = c.slopes.iter().rfind(|s| s.youngs_modulus_pa == e);
            slope.map_or("-".into(), |s| {
                let over = if s.n_per_m > c.felt_n_per_m { "*" } else { "" };
                format!("{:.0}{over} {:.1} mm", s.n_per_m, s.depth_m * 1e3)
            })
        };
        let [soft, middle, stiff] = super::ceiling::TABLED_PA.map(deepest);
        let held: String = c.held_pa.iter().map(|(_, e)| format!("{:>7.0}", e * 1e-3)).collect();
        let (count, limit, felt) = (c.count_m * 1e6, c.limit_n, c.felt_n_per_m);
        println!("  {:<14}{count:>8.0}{limit:>9.1}{felt:>10.0}{soft:>14}{middle:>14}{stiff:>14}  {held}", c.device);
    }
}

fn worst_mj(cells: &[&Cell]) -> f64 {
    cells.iter().map(|c| c.held.created_mj).fold(0.0, f64::max)
}

fn said(climb: Climb) -> String {
    let more = if climb.at_least { ">" } else { "" };
    format!("{:>6}", format!("{more}{:.0}", climb.n_per_m))
}

fn shaken(cells: &[&Cell]) -> usize {
    cells.iter().filter(|c| !c.held.quiet).count()
}

/// Static error of largest magnitude among the cells that have one, with its sign (1).
fn worst_error(cells: &[&Cell]) -> f64 {
    cells
        .iter()
        .filter_map(|c| c.held.static_error)
        .fold(0.0, |worst: f64, e| if e.abs() > worst.abs().max(1e-6) { e } else { worst })
}

/// Draws `stiffness_<device>` for every swept device, `stiffness_profiles` if all profiles were
/// run, and `created_energy`.
///
/// # Errors
/// Fails if a picture cannot be drawn or written.
pub fn draw(folder: &OutputFolder, summary: &LoopSummary) -> Result<(), Error> {
    for device in SWEPT.into_iter().filter(|d| summary.cells.iter().any(|c| c.device == *d)) {
        swept(folder, summary, device)?;
    }
    if summary.cells.iter().any(|c| !SWEPT.contains(&c.device.as_str())) {
        profiles(folder, summary)?;
    }
    energy(folder, summary)
}

fn climbed(cell: &Cell) -> MatrixCell {
    MatrixCell { n_per_m: cell.climb.n_per_m, at_least: cell.climb.at_least }
}

fn passive(cell: &Cell) -> MatrixCell {
    MatrixCell { n_per_m: cell.passive_n_per_m, at_least: false }
}

fn swept(folder: &OutputFolder, summary: &LoopSummary, device: &str) -> Result<(), Error> {
    let ceiling = DeviceProfile::load(device)?.stiffness_ceiling_n_per_m;
    let late = |delay: u8| match delay {
        0 => "no delay".to_owned(),
        1 => "1 tick late".to_owned(),
        n => format!("{n} ticks late"),
    };
    let groups = DELAYS.map(|d| MatrixGroup { name: late(d), columns: HANDS.map(|h| (h.id.to_owned(), ceiling)).to_vec() });
    let mut soft = Vec::new();
    let mut rows = Vec::new();
    for name in CONTROLLERS.map(|c| c.name()) {
        let cells: Vec<&Cell> = DELAYS.iter().flat_map(|d| summary.row(device, *d, &name)).collect();
        let error = worst_error(&cells);
        let star = if error.abs() > SEEN_ERROR { "*" } else { "" };
        if error.abs() > SEEN_ERROR {
            soft.push(format!("{name} {:+.0} %", error * 100.0));
        }
        let cells = cells.iter().copied().map(climbed).collect();
        rows.push(MatrixRow { name: format!("{name}{star}"), cells, closed: false });
    }
    let first = CONTROLLERS[0].name();
    let closed = DELAYS.iter().flat_map(|d| summary.row(device, *d, &first)).map(passive).collect();
    rows.push(MatrixRow { name: "passive (closed form)".into(), cells: closed, closed: true });
    let hands = HANDS.map(|h| format!("{} {}", h.id, h.name)).join(", ");
    let notes = [
        format!("* not the wall that was asked for; at 400 N/m it feels {}", soft.join(", ")),
        hands,
        format!(
            "all: quiet to {:.0} N/m. >: none shook, stiffer ones met the force limit. –: 50 N/m shakes. passive: b/(T/2 + delay), own damping, any hand.",
            summary.stiffest_tried_n_per_m
        ),
    ];
    let title = format!("Stiffest wall that does not shake the hand: {device}");
    let caption =
        "Largest stiffness [N/m] without a limit cycle, tap at 0.2 m/s and hold; climbed in 12 % steps to the first that shakes";
    let matrix = StiffnessMatrix {
        title: &title,
        caption,
        groups: &groups,
        rows: &rows,
        stiffest_n_per_m: summary.stiffest_tried_n_per_m,
        notes: &notes,
    };
    Ok(stiffness_matrix(folder.draft(), &format!("stiffness_{device}"), &matrix)?)
}

/// Draws every profile at its own delay, with the hand that has the lowest limit.
fn profiles(folder: &OutputFolder, summary: &LoopSummary) -> Result<(), Error> {
    let mut columns = Vec::new();
    let mut devices = Vec::new();
    for (name, _) in PROFILES {
        let device = DeviceProfile::load(name)?;
        columns.push((name.to_owned(), device.stiffness_ceiling_n_per_m));
        devices.push((name, device.delay_ticks));
    }
    // lowest limit among the hands with which the loop shakes; a lower bound if it shakes with none
    let worst = |control: &str| -> Vec<MatrixCell> {
        let of = |(name, delay): &(&str, u8)| {
            let cells: Vec<MatrixCell> = summary.row(name, *delay, control).map(climbed).collect();
            let least = |bounds: bool| {
                cells.iter().filter(|c| c.at_least == bounds).copied().min_by(|a, b| a.n_per_m.total_cmp(&b.n_per_m))
            };
            least(false).or(least(true)).unwrap_or(MatrixCell { n_per_m: 0.0, at_least: false })
        };
        devices.iter().map(of).collect()
    };
    let mut rows: Vec<MatrixRow> =
        CONTROLLERS.iter().map(|c| MatrixRow { name: c.name(), cells: worst(&c.name()), closed: false }).collect();
    let first = CONTROLLERS[0].name();
    let closed = devices.iter().filter_map(|(name, delay)| summary.row(name, *delay, &first).next().map(passive)).collect();
    rows.push(MatrixRow { name: "passive (closed form)".into(), cells: closed, closed: true });
    let named: Vec<String> = columns.iter().map(|(name, ceiling)| format!("{name} {ceiling:.0}")).collect();
    let notes = [
        format!("Named by the maker or taken for it [N/m]: {}", named.join(", ")),
        format!(
            "all: quiet to {:.0} N/m. >: none shook, stiffer ones met the force limit. –: 50 N/m shakes.",
            summary.stiffest_tried_n_per_m
        ),
    ];
    let matrix = StiffnessMatrix {
        title: "Stiffest wall that does not shake the worst of seven hands: every device",
        caption: "Largest stiffness [N/m] without a limit cycle, each device at its own delay; colour: against what its maker names",
        groups: &[MatrixGroup { name: String::new(), columns }],
        rows: &rows,
        stiffest_n_per_m: summary.stiffest_tried_n_per_m,
        notes: &notes,
    };
    Ok(stiffness_matrix(folder.draft(), "stiffness_profiles", &matrix)?)
}

fn energy(folder: &OutputFolder, summary: &LoopSummary) -> Result<(), Error> {
    let devices: Vec<&str> = SWEPT.into_iter().filter(|d| summary.cells.iter().any(|c| c.device == *d)).collect();
    let rows: Vec<EnergyRow> = CONTROLLERS
        .iter()
        .map(|control| {
            let name = control.name();
            let of = |device: &&str| worst_mj(&summary.row(device, DRAWN_DELAY, &name).collect::<Vec<_>>()) * 1e-3;
            let all: Vec<&Cell> = devices.iter().flat_map(|d| summary.row(d, DRAWN_DELAY, &name)).collect();
            let error = worst_error(&all);
            let error = if error.abs() < SEEN_ERROR { "0".into() } else { format!("{:+.0} %", error * 100.0) };
            let beside = [error, format!("{} of {}", shaken(&all), all.len())];
            EnergyRow { created_j: devices.iter().map(of).collect(), name, beside }
        })
        .collect();
    let title = format!("Energy that the loop gives to the hand at {HELD_N_PER_M:.0} N/m");
    let bars = CreatedEnergy {
        title: &title,
        caption: "Tap at 0.2 m/s, one tick late, worst of seven hands; at the true port, in the worst contact",
        devices: &devices,
        rows: &rows,
        promised_j: MOST_CREATED_J,
    };
    Ok(created_energy(folder.draft(), "created_energy", &bars)?)
}

const _: () = assert!(STEP == 1.12, "captions say 12 %");
