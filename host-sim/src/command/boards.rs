//! The boards on which a patch runs.

use palpate::{Model, PatchFile};
use palpate_controller::link::Refusal;
use palpate_controller::patch::{Budget, Memory, Patch, cost, site};
use palpate_tissue::Error as TissueError;
use palpate_tissue::budget::{BOUND, CostModel, MACHINES, TIGHTNESS};

use super::options::fit::MOST_POINTS;
use super::options::pack::BOARDS;
use crate::error::Error;

/// Refuses a patch with more foundation points per triangle than the boards' images support.
pub(super) fn refuse_points(model: &Model, board: &str) -> Result<(), Error> {
    match model.points_per_triangle() {
        points if points > MOST_POINTS => {
            let why = format!(
                "solver.patch: it has {points} foundation points on a triangle, and the image of {board} has no room for more than {MOST_POINTS}: fit it with palpate fit --points {MOST_POINTS}"
            );
            Err(TissueError::Usage(why).into())
        }
        _ => Ok(()),
    }
}

/// Refuses a packed patch for its contact.
pub(super) fn refuse_contact(name: &str, refusal: Option<Refusal>) -> Result<(), Error> {
    match refusal {
        Some(why) => Err(TissueError::Usage(format!("{name}: {why}; nothing is written")).into()),
        None => Ok(()),
    }
}

/// Returns why a board would refuse the contact of a packed patch for a device with this stiffness
/// ceiling [N/m]; other reasons are not looked for.
pub(super) fn contact_refusal(packed: &[u8], ceiling_n_per_m: f32) -> Option<Refusal> {
    let words = on_words(packed);
    let bytes = &bytemuck::cast_slice(&words)[..packed.len()];
    let mut memory = Box::new(Memory::RESERVED);
    match Patch::open_for(&Budget::M7_480, ceiling_n_per_m, bytes, &mut memory, None, &mut || {}) {
        Err(why @ (Refusal::ContactStiff(_) | Refusal::TipNarrow(_))) => Some(why),
        _ => None,
    }
}

/// Copies a packed patch to where it can be read in place as words.
fn on_words(packed: &[u8]) -> Vec<u32> {
    let mut words = vec![0_u32; packed.len().div_ceil(4)];
    bytemuck::cast_slice_mut(&mut words)[..packed.len()].copy_from_slice(packed);
    words
}

/// Says how many triangles a probe presses at most and how long a board then takes; `None` if the
/// patch is not for boards.
pub(super) fn bound(packed: &[u8], machine: &CostModel) -> Option<String> {
    let words = on_words(packed);
    let file = PatchFile::open(&bytemuck::cast_slice(&words)[..packed.len()]).ok().filter(|_| machine.is_board())?;
    let most = site::most_in_reach(&file, &mut || {});
    let cycles = BOUND * f64::from(cost::cycles(&file, most));
    let waited = match machine.waits {
        1.0 => String::new(),
        waits => format!(", {:.0} with waits for the flash by a model of its cache", cycles * waits),
    };
    Some(format!(
        "at most {most} triangles pressed anywhere on the surface, which a board enforces: at most {cycles:.0} cycles per tick{waited}; for the default patch such a bound is up to {TIGHTNESS:.2} times the longest emulated tick"
    ))
}

/// Names the boards on which a patch with this budget runs: those with the same core and at least
/// the same clock.
pub(super) fn runs_on(machine: &CostModel) -> String {
    if !machine.is_board() {
        return "runs on this machine".into();
    }
    let core = |name: &str| name.split('-').next().map(str::to_owned);
    let fast_enough = |budget: &str| {
        CostModel::named(budget).is_some_and(|own| core(own.name) == core(machine.name) && own.per_ms >= machine.per_ms)
    };
    let boards: Vec<&str> = BOARDS.iter().filter(|(_, budget)| fast_enough(budget)).map(|(name, _)| *name).collect();
    let emulated = match MACHINES.iter().any(|m| m.name == machine.name) {
        true => format!(" and on the emulated board (palpate emulate --board {})", machine.name),
        false => String::new(),
    };
    format!("runs on {}{emulated}", boards.join(", "))
}

#[cfg(test)]
mod tests {
    use palpate_tissue::patch::{Material, Patch as Mesh};
    use palpate_tissue::scene::{PRESETS, Scene};
    use palpate_tissue::tissue::place;

    use super::*;
    use crate::command::options::pack::machine;

    #[test]
    fn no_board_takes_sixteen_foundation_points() {
        let mut scene = Scene::parse("block", PRESETS[0].1).unwrap();
        scene.tissue.nodes = Some(60);
        let tissue = place(&scene, &[]).unwrap().tissue;
        let refused = |points_per_triangle: usize| {
            let patch = Mesh::build(&tissue, &Material { points_per_triangle, ..Material::default() }, None);
            refuse_points(&patch.model(), "m7-480").err().map(|e| e.to_string())
        };
        assert_eq!((refused(4), refused(9)), (None, None));
        let why = refused(16).unwrap();
        assert!(why.contains("m7-480") && why.contains("--points 9"), "{why}");
    }

    #[test]
    fn a_packed_patch_has_a_bound_and_how_tight_it_is() {
        let shipped = concat!(env!("CARGO_MANIFEST_DIR"), "/../firmware/patches/block-m4f-168.patch");
        let packed = std::fs::read(shipped).unwrap();
        let said = |board: &str| bound(&packed, machine(board).unwrap());
        let cycles = |said: &str, before: &str| said.split(before).nth(1)?.split(' ').next()?.parse::<f64>().ok();
        let text = said("nucleo-f446re").unwrap();
        let (dry, waited) = (cycles(&text, "enforces: at most ").unwrap(), cycles(&text, "per tick, ").unwrap());
        assert!((1.10..1.20).contains(&(waited / dry)), "{text}");
        assert!(text.starts_with("at most 15 triangles") && text.contains("1.10 times the longest"), "{text}");
        assert!(!said("m4f-168").unwrap().contains("waits"), "no chip is known");
        assert_eq!(said("desktop"), None);
    }

    #[test]
    fn every_board_has_a_budget_and_every_budget_runs_somewhere() {
        for (name, budget) in BOARDS {
            let machine = machine(name).unwrap();
            assert_eq!(machine.name, budget);
            assert!(machine.is_board() && runs_on(machine).contains(name));
        }
        assert_eq!(runs_on(machine("desktop").unwrap()), "runs on this machine");
        let unknown = machine("nucleo").unwrap_err().to_string();
        assert!(unknown.contains("no board \"nucleo\"") && unknown.contains("nucleo-h743zi (takes m7-480)"), "{unknown}");
    }
}
