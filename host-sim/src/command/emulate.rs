//! The command `palpate emulate`.

mod print;

use std::time::Instant;

use palpate_controller::patch::Memory;

use self::print::{Emulated, print, write_timing};
use super::boards;
use super::options::emulate::EmulateArgs;
use super::press::{print_holds, with_progress};
use super::progress::told;
use super::verdict::Verdict;
use crate::error::Error;
use crate::press_report;
use palpate_board::one_core::OneCore;
use palpate_board::{self, Board, Lockstep, campaign, timed, timing};
use palpate_tissue::Error as TissueError;
use palpate_tissue::fit_record::press_packed;
use palpate_tissue::session::Session;

/// Ticks of contact, faults and recovery after the scene's own press.
const TICKS: u32 = 10_000;
/// Ticks of contact, faults and recovery after the press in a quick run.
const QUICK_TICKS: u32 = 2_000;

/// Number of ticks over which the jitter of their starts is measured.
const STARTED_TICKS: u32 = 10_000;

/// Depth of random presses, as a share of the patch's depth limit.
const DEEPEST: f32 = 0.9;

impl EmulateArgs {
    pub(super) fn run(&self) -> Result<(), Error> {
        let mut scene = self.common.load()?;
        scene.refuse_what_boards_lack("a board")?;
        let patch_file = match &self.patch {
            Some(path) => path.clone(),
            None => palpate_board::image::patch_for(&scene)?,
        };
        press_packed(&mut scene, &patch_file);
        let session = told("meshing the tissue", || Session::prepare(&scene))?;
        boards::refuse_points(&session.patch.model(), "a board")?;
        let bytes = session.patch.pack(&session.params, session.stable.pressed_s as f32);
        let words = words(&bytes);
        let patch = &bytemuck::cast_slice(&words)[..bytes.len()];
        let image = palpate_board::image::find(self.image.as_deref())?;
        let machine = self.board.map_or_else(|| palpate_board::image::machine_for(&patch_file), Into::into);
        let turns = OneCore::stay();
        let board = Board::start(&image, machine, None)?;
        let mut memory = Box::new(Memory::RESERVED);
        let mut twin = Lockstep::new(board, patch, &mut memory)?;
        // the folder is opened once scene, image and patch are known to be good, so that bad input
        // leaves nothing behind
        let folder = self.common.open("emulate", &scene)?;

        let started = Instant::now();
        let press = with_progress(|progress| palpate_board::press::run(&scene, &session, &mut twin, progress))?;
        let mut seen = twin.instructions.clone();
        let ticks = self.ticks.unwrap_or(if self.quick { QUICK_TICKS } else { TICKS });
        let deepest_m = DEEPEST * session.patch.model().depth_limit_m;
        let met = with_progress(|progress| campaign::run(&mut twin, ticks, deepest_m, |n| progress(n as usize)))?;
        let (_, stack_used_bytes) = twin.state_hash()?;
        let seconds = started.elapsed().as_secs_f64();
        drop(turns);

        seen.extend(&twin.instructions);
        let exchanges = seen.len();
        let (mut cycles_per_instruction, mut in_time, mut overruns) = (None, None, Vec::new());
        if self.timing {
            cycles_per_instruction = Some(timing::cycles_per_instruction(&image, machine, patch)?);
            in_time = Some(timed::run(&image, machine, timed::IN_TIME_SHIFT, STARTED_TICKS)?);
            overruns = timed::overruns(&image, machine)?;
        }
        let emulated = Emulated {
            board: machine.name().into(),
            image: image.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned()),
            patch_bytes: bytes.len(),
            exchanges,
            seconds,
            times_real_time: exchanges as f64 * 1e-3 / seconds,
            stack_used_bytes,
            instructions: timing::Spread::of(&seen),
            cycles_per_instruction,
            in_time,
            overruns,
            campaign: met,
            faults: twin.faults.iter().map(ToString::to_string).collect(),
            first_difference: twin
                .difference
                .as_ref()
                .map(|d| format!("tick {}: {} is {} on the board and {} here", d.tick, d.what, d.values[0], d.values[1])),
        };
        press_report::write(&folder, &scene, &session, &press, &[], None, false)?;
        folder.write_json("emulated.json", &emulated)?;
        if self.timing {
            write_timing(&folder, &scene, &session, machine, &seen, &emulated)?;
        }
        let broken = twin.broken.map(|(tick, broken)| format!("tick {tick} on the board breaks {}: {}", broken.id, broken.what));
        let difference = emulated.first_difference.as_ref().map(|d| format!("board and desktop part: {d}"));
        let check = match difference.or(broken) {
            Some(why) => Err(TissueError::Check(why)),
            None => press.check(&scene.drive),
        };
        let verdict = Verdict::of(check, || emulated.in_words())?.about(&scene).first();
        print_holds(&scene, &press);
        print(&emulated);
        let out = folder.publish()?;
        println!("\nwrote {}: summary.json, emulated.json, trace.csv, surface_*.csv, pictures as SVG and PNG", out.display());
        verdict.last()
    }
}

/// Copies bytes to a 4-byte boundary, where the core reads a patch in place.
fn words(bytes: &[u8]) -> Vec<u32> {
    let mut words = vec![0_u32; bytes.len().div_ceil(4)];
    bytemuck::cast_slice_mut(&mut words)[..bytes.len()].copy_from_slice(bytes);
    words
}
