//! The command `palpate scene`.

use clap::Args;

use super::verdict::Verdict;
use crate::error::Error;
use palpate_tissue::scene::{Change, PRESETS, Scene};

#[derive(Args, Clone, Debug)]
pub(super) struct SceneArgs {
    /// Preset or scene file (.toml) to print; without it the presets are listed.
    #[arg(value_name = "NAME|FILE")]
    scene: Option<String>,
    /// Change a key of the scene, such as `tissue.youngs_modulus_pa=5000`. May be given several
    /// times; the printed scene then has no comments.
    #[arg(long = "set", value_name = "KEY=VALUE", requires = "scene")]
    changes: Vec<Change>,
}

impl SceneArgs {
    pub(super) fn run(&self) -> Result<(), Error> {
        let Some(name) = &self.scene else { return list() };
        let scene = Scene::load_with(name, &self.changes)?;
        // prints only the text of the file, since it is redirected into the user's own file
        print!("{}", scene.text);
        Ok(())
    }
}

fn list() -> Result<(), Error> {
    for (name, text) in PRESETS {
        println!("{name:<12} {}", about(text));
    }
    Verdict::ok(format!("{} presets; palpate scene NAME > mine.toml makes one yours", PRESETS.len())).last()
}

/// The first sentence of the comment at the head of a preset.
fn about(text: &str) -> String {
    let comment = text.lines().map_while(|line| line.strip_prefix('#')).map(str::trim).collect::<Vec<_>>().join(" ");
    comment.split_inclusive(". ").next().unwrap_or_default().trim().to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_preset_says_in_a_sentence_what_it_is() {
        for (name, text) in PRESETS {
            let about = about(text);
            assert!(about.ends_with('.') && about.len() > 20 && about.len() < 120, "{name}: {about}");
        }
    }
}
