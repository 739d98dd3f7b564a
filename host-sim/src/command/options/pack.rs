//! Command line of `palpate pack`: a board, and the device on it.

use clap::Args;
use palpate_loop::closed_loop::device::DeviceProfile;
use palpate_tissue::Error as TissueError;
use palpate_tissue::budget::{CHIPS, CostModel, MACHINES};
use palpate_tissue::scene::TICK_S;
use serde::Serialize;

use crate::command::Common;
use crate::error::Error;

/// A board and the budget of its chip.
pub const BOARDS: [(&str, &str); 4] =
    [("nucleo-f446re", "m4f-180"), ("nucleo-g474re", "m4f-170"), ("nucleo-h743zi", "m7-480"), ("pico2", "m33-150")];

/// The budget of a board with this name, or the budget with this name.
pub fn machine(board: &str) -> Result<&'static CostModel, Error> {
    let budget = BOARDS.iter().find(|(name, _)| *name == board).map_or(board, |(_, budget)| budget);
    Ok(CostModel::named(budget).ok_or_else(|| {
        let budgets = MACHINES.iter().chain(&CHIPS).map(|m| m.name.to_owned());
        let boards = BOARDS.iter().map(|(name, budget)| format!("{name} (takes {budget})"));
        let names: Vec<String> = budgets.chain(boards).collect();
        TissueError::Usage(format!("no board \"{board}\": choose one of {}", names.join(", ")))
    })?)
}

#[derive(Args, Clone, Debug)]
pub struct PackArgs {
    #[command(flatten)]
    pub common: Common,
    #[command(flatten)]
    pub board: BoardArg,
    /// Nodes of the block's mesh [default: the most that fit the board, but no more than the
    /// scene's].
    #[arg(long, value_name = "COUNT")]
    pub nodes: Option<usize>,
}

impl PackArgs {
    /// Checks whatever needs no patch.
    pub fn check(&self) -> Result<(), Error> {
        let machine = self.board.machine()?;
        self.board.ceiling_n_per_m()?;
        let scene = self.common.load()?;
        if machine.is_board() {
            scene.refuse_what_boards_lack(machine.name)?;
        }
        Ok(scene.refuse_what_no_file_has()?)
    }
}

#[derive(Args, Clone, Debug)]
pub struct BoardArg {
    /// Board, or budget, for a tick of the patch: m4f-168 (Cortex-M4F, 168 MHz), m4f-170, m4f-180,
    /// m7-480 (Cortex-M7, 480 MHz), m7-400, m33-150 or desktop; nucleo-f446re, nucleo-g474re,
    /// nucleo-h743zi and pico2 select their own budget.
    #[arg(long, value_name = "BOARD", default_value = "m4f-168")]
    pub board: String,
    #[command(flatten)]
    pub device: DeviceArg,
}

/// Device for which a patch is made.
#[derive(Args, Clone, Debug, Default, Serialize)]
pub struct DeviceArg {
    /// Device on the board, by name or profile (.toml): a contact stiffer than its stiffness
    /// ceiling is refused, with what is accepted instead, as by the board itself.
    #[arg(long, value_name = "DEVICE")]
    pub device: Option<String>,
}

impl DeviceArg {
    /// Largest contact stiffness of the device [N/m]; no limit without a device.
    pub fn ceiling_n_per_m(&self) -> Result<f32, Error> {
        let Some(device) = &self.device else { return Ok(f32::MAX) };
        Ok(DeviceProfile::load(device)?.limits(palpate::Vector3::zeros()).ceiling_n_per_m(TICK_S as f32))
    }
}

impl BoardArg {
    /// Largest contact stiffness of the device [N/m].
    pub fn ceiling_n_per_m(&self) -> Result<f32, Error> {
        self.device.ceiling_n_per_m()
    }

    /// The budget of the board.
    pub fn machine(&self) -> Result<&'static CostModel, Error> {
        machine(&self.board)
    }
}
