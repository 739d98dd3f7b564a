//! The emulated board under an emulated hand, for `loop --emulated`; only the full build contains
//! it.

use std::path::{Path, PathBuf};

#[cfg(feature = "full")]
use palpate_board::{image, in_loop::InLoop};
use palpate_loop::closed_loop::prepared::Prepared;
use palpate_loop::closed_loop::run::{Run, Setup};
use palpate_loop::closed_loop::stimulus::Stimulus;
use palpate_tissue::scene::Scene;

use crate::error::Error;

/// A board that computes the force in place of the tissue.
#[cfg(feature = "full")]
pub(super) struct HardwareInLoop(InLoop);

#[cfg(feature = "full")]
impl HardwareInLoop {
    /// Finds the scene's patch for a board.
    pub(super) fn patch_for(scene: &Scene) -> Result<PathBuf, Error> {
        Ok(image::patch_for(scene)?)
    }

    pub(super) fn new(given: Option<&Path>, patch: &Path, prepared: &Prepared) -> Result<Self, Error> {
        Ok(Self(InLoop::new(image::find(given)?, image::machine_for(patch), prepared)?))
    }

    pub(super) fn cannot_follow(&self, stimulus: &Stimulus) -> bool {
        self.0.cannot_follow(stimulus)
    }

    pub(super) fn run(&self, setup: &Setup) -> Result<Run, Error> {
        Ok(self.0.run(setup)?)
    }
}

/// Cannot exist in this build; [`super::on_demand`] starts the build that contains the board.
#[cfg(not(feature = "full"))]
pub(super) enum HardwareInLoop {}

#[cfg(not(feature = "full"))]
impl HardwareInLoop {
    pub(super) fn patch_for(_: &Scene) -> Result<PathBuf, Error> {
        Err(Self::missing())
    }

    pub(super) fn new(_: Option<&Path>, _: &Path, _: &Prepared) -> Result<Self, Error> {
        Err(Self::missing())
    }

    fn missing() -> Error {
        palpate_tissue::Error::Usage("this build has no emulated board: build palpate with `--features board`".into()).into()
    }

    pub(super) fn cannot_follow(&self, _: &Stimulus) -> bool {
        match *self {}
    }

    pub(super) fn run(&self, _: &Setup) -> Result<Run, Error> {
        match *self {}
    }
}
