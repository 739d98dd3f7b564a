//! The patch that this machine runs beside the board: the board's own if its file is known.

use std::path::Path;

use palpate::PatchFile;
use palpate_loop::live::{Choice, LiveTissue};
use palpate_tissue::session::packed::unpack;

/// Patches that ship for boards.
const SHIPPED: [(&str, &[u8]); 4] = [
    ("block-m4f-168", include_bytes!("../../../../firmware/patches/block-m4f-168.patch")),
    ("block-m7-480", include_bytes!("../../../../firmware/patches/block-m7-480.patch")),
    ("liver-m4f-168", include_bytes!("../../../../firmware/patches/liver-m4f-168.patch")),
    ("nodule-m7-480", include_bytes!("../../../../firmware/patches/nodule-m7-480.patch")),
];

/// The patch that the user named.
#[derive(Clone, Debug)]
pub enum Given {
    /// No patch was named: the board's own patch is used, if it is one that ships.
    Nothing,
    /// The patch of a scene.
    Scene(Choice),
    /// A patch file: name and content.
    File(String, Vec<u8>),
}

impl Given {
    /// Reads and checks the scene or patch that the command line names.
    ///
    /// # Errors
    /// Returns one line that names the file, the reason and the fix.
    pub fn of(scene: Option<&str>, patch: Option<&Path>) -> Result<Self, String> {
        if let Some(path) = patch {
            let place = path.display();
            let bytes = std::fs::read(path).map_err(|why| format!("cannot read {place}: {why}: check the path"))?;
            unpack(&bytes).map_err(|why| format!("{place}: {why}"))?;
            let name = path.file_stem().map_or_else(|| place.to_string(), |name| name.to_string_lossy().into_owned());
            return Ok(Self::File(name, bytes));
        }
        let Some(scene) = scene else { return Ok(Self::Nothing) };
        let choice = Choice::preset(scene);
        choice.scene().map_err(|why| why.to_string())?;
        Ok(Self::Scene(choice))
    }

    /// Prepares the patch to show for a board whose patch has this checksum.
    ///
    /// # Errors
    /// The scene cannot be used; the reason is one line.
    pub fn chosen(&self, board: u32) -> Result<Chosen, String> {
        match self {
            Self::File(name, bytes) => Chosen::packed(name, bytes),
            Self::Scene(choice) => Chosen::built(choice),
            Self::Nothing => {
                let own = SHIPPED.iter().find(|(_, bytes)| PatchFile::checksum(bytes) == Some(board));
                own.map_or_else(|| Chosen::built(&Choice::preset("block")), |(name, bytes)| Chosen::packed(name, bytes))
            }
        }
    }
}

/// A patch to show.
#[derive(Clone, Debug)]
pub struct Chosen {
    /// The tissue with this patch.
    pub tissue: LiveTissue,
    /// Scene from which the patch was made, if any.
    pub choice: Option<Choice>,
    /// Name for the user.
    pub name: String,
    /// Checksum of the patch file; `None` for the patch of a scene.
    pub checksum: Option<u32>,
}

impl Chosen {
    fn packed(name: &str, bytes: &[u8]) -> Result<Self, String> {
        let why = |why: palpate::BuildError| format!("{name}: {why}");
        let (patch, params) = unpack(bytes).map_err(why)?;
        let tissue = LiveTissue::new(patch, params).map_err(why)?;
        Ok(Self { tissue, choice: None, name: name.into(), checksum: PatchFile::checksum(bytes) })
    }

    fn built(choice: &Choice) -> Result<Self, String> {
        let tissue = choice.tissue().map_err(|why| why.to_string())?;
        let name = crate::controls::short(&choice.scene).to_owned();
        Ok(Self { tissue, choice: Some(choice.clone()), name, checksum: None })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn nodes(chosen: &Chosen) -> usize {
        chosen.tissue.nodes().len()
    }

    #[test]
    fn a_shipped_patch_of_the_board_is_found_by_its_checksum() {
        for (name, bytes) in SHIPPED {
            let board = PatchFile::checksum(bytes).unwrap();
            let chosen = Given::Nothing.chosen(board).unwrap();
            assert_eq!((chosen.name.as_str(), chosen.checksum), (name, Some(board)));
        }
        let other = Given::Nothing.chosen(1).unwrap();
        assert_eq!((other.name.as_str(), other.checksum, nodes(&other)), ("block", None, 410));
    }

    #[test]
    fn a_file_and_a_scene_are_taken_whatever_the_board_has() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mine.patch");
        std::fs::write(&path, SHIPPED[2].1).unwrap();
        let mine = Given::of(None, Some(&path)).unwrap().chosen(1).unwrap();
        assert_eq!((mine.name.as_str(), mine.checksum, nodes(&mine)), ("mine", PatchFile::checksum(SHIPPED[2].1), 42));
        let scene = Given::of(Some("block"), None).unwrap().chosen(1).unwrap();
        assert_eq!((scene.name.as_str(), scene.checksum), ("block", None));
    }

    #[test]
    fn a_damaged_patch_and_an_unknown_scene_are_refused_in_a_line() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("cut.patch");
        std::fs::write(&path, &SHIPPED[0].1[..5_000]).unwrap();
        let why = Given::of(None, Some(&path)).unwrap_err();
        assert!(why.contains("cut.patch: patch checksum") && why.lines().count() == 1, "{why}");
        let why = Given::of(None, Some(&folder.path().join("none.patch"))).unwrap_err();
        assert!(why.contains("cannot read") && why.ends_with("check the path"), "{why}");
        assert_eq!(Given::of(Some("blok"), None).unwrap_err().lines().count(), 1);
    }
}
