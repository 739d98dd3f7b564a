//! The command `palpate paper`.

use std::path::PathBuf;

use crate::paper::{Progress, local_compression, volume_preserved};
use palpate_sim::command::options::paper::PaperCommand;
use palpate_sim::command::progress;
use palpate_sim::error::Error;
use palpate_sim::provenance;

pub(super) fn run(command: &PaperCommand) -> Result<(), Error> {
    match command {
        PaperCommand::VolumePreserved(args) => {
            let (scene, quick, solve) = (args.scene.clone(), args.quick, args.solve);
            let options = volume_preserved::Options { scene, quick, solve, provenance: provenance::of(None) };
            let folder = folder(args.out.as_ref(), "volume-preserved");
            volume_preserved::run(&options, &folder, &progress::Progress::start())
        }
        PaperCommand::LocalCompression(args) => {
            let (scene, quick) = (args.scene.clone(), args.quick);
            let options = local_compression::Options { quick, scene, provenance: provenance::of(None) };
            let folder = folder(args.out.as_ref(), "local-compression");
            local_compression::run(&options, &folder, &progress::Progress::start())
        }
    }
}

impl Progress for progress::Progress {
    fn say(&self, doing: String) {
        Self::say(self, doing);
    }

    fn clear(&self) {
        self.finish();
    }
}

fn folder(out: Option<&PathBuf>, paper: &str) -> PathBuf {
    out.cloned().unwrap_or_else(|| PathBuf::from("out").join(format!("paper-{paper}")))
}
