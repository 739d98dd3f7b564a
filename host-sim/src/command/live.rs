//! `palpate live`: builds the window or the page, which are a package of their own, and starts the
//! one requested.

mod display;
mod serve;

use std::path::{Path, PathBuf};
use std::process::Command;

use clap::Args;

use super::replay::ReplayArgs;
use super::tools::{Tools, ended, run};
use crate::error::Error;
use palpate_loop::board_trace;
use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;
use palpate_tissue::scene::Scene;
use palpate_tissue::session::packed::unpack;

/// Target triple for which the page is built.
const PAGE: &str = "wasm32-unknown-unknown";

#[derive(Args, Clone, Debug)]
pub(super) struct LiveArgs {
    /// A preset or the path of a scene file (.toml) [default: block; with --follow the board's own
    /// patch, if it ships].
    #[arg(long, value_name = "NAME|FILE", conflicts_with = "page")]
    scene: Option<String>,
    /// Show what a board measured, instead of pressing with the mouse: follows the file that
    /// `palpate board arm --stream FILE.csv` is writing. Nothing is sent to the board.
    #[arg(long, value_name = "FILE.csv", conflicts_with = "page")]
    follow: Option<PathBuf>,
    /// Patch file of the board that is followed, if it is not one that ships.
    #[arg(long, value_name = "PATCH", requires = "follow", conflicts_with = "scene")]
    patch: Option<PathBuf>,
    /// Build the page instead of the window, and serve it on this machine.
    #[arg(long)]
    page: bool,
    /// Build the page and do not serve it.
    #[arg(long, requires = "page")]
    no_serve: bool,
    #[command(flatten)]
    replay: ReplayArgs,
    /// Folder for the window's recordings and pictures, for the page, or for the result of a replay
    /// [default: out/live, out/live-page, out/replay].
    #[arg(long, value_name = "FOLDER")]
    out: Option<PathBuf>,
}

impl LiveArgs {
    pub(super) fn run(&self) -> Result<(), Error> {
        if let Some(file) = &self.replay.file {
            return self.replay.run(file, self.out.as_deref().unwrap_or(Path::new("out/replay")));
        }
        // a window is not built if it cannot be shown
        let silent = if self.page {
            None
        } else {
            self.check()?;
            display::look(self.follow.is_none())?
        };
        // the package is in the repository, and not in the binary
        let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("live");
        if !package.join("Cargo.toml").is_file() {
            let place = package.display();
            return Err(TissueError::Usage(format!(
                "{place} is not there: `live` builds its window and page in the repository, start it from a build of it"
            ))
            .into());
        }
        let tools = Tools::in_use(package);
        if self.page { self.page(&tools) } else { self.window(&tools, silent) }
    }

    /// Refuses files that the window would refuse after minutes of building.
    fn check(&self) -> Result<(), Error> {
        if let Some(scene) = &self.scene {
            Scene::load(scene)?;
        }
        if let Some(path) = &self.patch {
            let bytes = std::fs::read(path).map_err(|source| TissueError::Read { path: path.clone(), source })?;
            unpack(&bytes).map_err(|cause| TissueError::Patch { path: path.clone(), cause })?;
        }
        if let Some(path) = &self.follow {
            board_trace::check_head(path).map_err(TissueError::Usage)?;
        }
        Ok(())
    }

    fn window(&self, tools: &Tools, silent: Option<&str>) -> Result<(), Error> {
        let window = tools.build(&["--release"], "palpate-live", "the window")?;
        let out = self.out.as_deref().unwrap_or(Path::new("out/live"));
        let name = window.display().to_string();
        let mut program = Command::new(&window);
        if let Some(variable) = silent {
            program.env_remove(variable);
        }
        if let Some(scene) = &self.scene {
            program.arg("--scene").arg(std::fs::canonicalize(scene).unwrap_or_else(|_| scene.into()));
        }
        for (option, file) in [("--follow", &self.follow), ("--patch", &self.patch)] {
            if let Some(file) = file {
                program.arg(option).arg(file);
            }
        }
        ended(run(program.arg("--out").arg(out), &name)?, &name)
    }

    fn page(&self, tools: &Tools) -> Result<(), Error> {
        tools.add_target(PAGE)?;
        let module = tools.build(&["--lib", "--profile", "page", "--target", PAGE], "palpate_live", "the page")?;
        let bind = tools.build(&["--release", "--package", "palpate-live-page"], "palpate-live-page", "the page's tool")?;
        let out = self.out.as_deref().unwrap_or(Path::new("out/live-page"));
        let folder = OutputFolder::open(out)?;
        eprintln!("binding and packing the page: some seconds");
        let web = tools.package.join("web");
        ended(run(Command::new(&bind).arg(&module).arg(folder.draft()).arg(&web), "binding the page")?, "binding the page")?;
        for name in ["index.html", "page.js", "worker.js"] {
            let from = web.join(name);
            let bytes = std::fs::read(&from).map_err(|source| TissueError::Read { path: from, source })?;
            folder.write(name, &bytes)?;
        }
        folder.publish()?;
        println!(
            "wrote {}: {:.2} MB, static files: any web server shows them, without a network",
            out.display(),
            serve::bytes(out) as f64 * 1e-6
        );
        println!("{}: the same as one file, which a browser opens from the disk", out.join("palpate-live.html").display());
        if self.no_serve { Ok(()) } else { serve::serve(out) }
    }
}
