//! Changes of a scene's keys on the command line: `tissue.youngs_modulus_pa=5000`.

use std::str::FromStr;

use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use super::{Scene, SceneError};

/// One changed key and its new value.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct Change {
    /// Tables and key, outermost table first; a number is an index into a list, counted from 0.
    path: Vec<String>,
    /// The change as given, for messages.
    text: String,
    value: Value,
}

impl FromStr for Change {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let form = || format!("\"{text}\" is not KEY=VALUE: give it like tissue.youngs_modulus_pa=5000");
        let (key, value) = text.split_once('=').ok_or_else(form)?;
        let path: Vec<String> = key.trim().split('.').map(str::to_owned).collect();
        if path.iter().any(String::is_empty) {
            return Err(form());
        }
        // on the command line a text value needs no quotes
        let one = |text: String| text.parse::<Table>().ok().filter(|t| t.len() == 1)?.remove("value");
        let value = one(format!("value = {value}")).unwrap_or_else(|| Value::String(value.trim().to_owned()));
        Ok(Self { path, text: text.to_owned(), value })
    }
}

impl TryFrom<String> for Change {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl From<Change> for String {
    fn from(change: Change) -> Self {
        change.text
    }
}

impl Change {
    fn apply(&self, scene: &mut Table) -> Result<(), SceneError> {
        let refuse = |what: String| SceneError::Change { changes: self.text.clone(), what };
        let Some((last, tables)) = self.path.split_last() else { return Ok(()) };
        let mut place = Place::Table(scene);
        for name in tables {
            place = place.enter(name).map_err(refuse)?;
        }
        place.put(last, self.value.clone()).map_err(refuse)
    }
}

/// A table or a list of the scene, in which a key or an entry can be changed.
enum Place<'a> {
    Table(&'a mut Table),
    List(&'a mut Vec<Value>),
}

impl<'a> Place<'a> {
    /// Enters the table or list with this name; creates a table that is missing.
    fn enter(self, name: &str) -> Result<Self, String> {
        let inner = match self {
            Self::Table(table) => table.entry(name).or_insert_with(|| Value::Table(Table::new())),
            Self::List(list) => entry(list, name)?,
        };
        match inner {
            Value::Table(table) => Ok(Self::Table(table)),
            Value::Array(list) => Ok(Self::List(list)),
            _ => Err(format!("\"{name}\" is a value and has no keys: leave out what follows it")),
        }
    }

    fn put(self, name: &str, value: Value) -> Result<(), String> {
        match self {
            Self::Table(table) => {
                table.insert(name.to_owned(), value);
            }
            Self::List(list) => *entry(list, name)? = value,
        }
        Ok(())
    }
}

fn entry<'a>(list: &'a mut [Value], name: &str) -> Result<&'a mut Value, String> {
    let count = list.len();
    let found = name.parse::<usize>().ok().and_then(|n| list.get_mut(n));
    found.ok_or_else(|| format!("\"{name}\" is no entry of a list of {count}: count from 0"))
}

impl Scene {
    /// Keys of the scene as read and changed, for the records of results.
    #[must_use]
    pub fn as_read(&self) -> serde_json::Value {
        // the text has been parsed once already, so this does not fail
        toml::from_str(&self.text).unwrap_or_default()
    }

    /// Reads a preset or a scene file as [`Self::load`] does, with some of its keys changed.
    ///
    /// # Errors
    /// Errors of [`Self::load`], and a changed key that is unknown or has an impossible value.
    pub fn load_with(name_or_path: &str, changes: &[Change]) -> Result<Self, SceneError> {
        let scene = Self::load(name_or_path)?;
        if changes.is_empty() {
            return Ok(scene);
        }
        let said = || changes.iter().map(|change| change.text.as_str()).collect::<Vec<_>>().join(" --set ");
        let refuse = |what: String| SceneError::Change { changes: said(), what };
        let mut table: Table = scene.text.parse().map_err(|e: toml::de::Error| refuse(e.message().to_owned()))?;
        changes.iter().try_for_each(|change| change.apply(&mut table))?;
        let text = toml::to_string(&table).map_err(|e| refuse(e.to_string()))?;
        let mut changed = Self::parse(name_or_path, &text).map_err(|error| match error {
            // a changed key has no line in a file
            SceneError::Toml { what, surplus, .. } => refuse(remedied(what, surplus.as_deref(), changes)),
            SceneError::Parameter { table, cause, .. } => refuse(format!("{table}{cause}")),
            SceneError::Value { key, why, .. } => {
                // one key of a table, or the table with two keys of which one has to go
                let surplus = Some(key.split_once('.').map_or("", |(_, key)| key))
                    .filter(|_| why.ends_with("remove it") || why.ends_with("keep one"));
                refuse(remedied(format!("{key} {why}"), surplus, changes))
            }
            other => other,
        })?;
        changed.resolve_paths_of(name_or_path);
        Ok(changed)
    }
}

/// A defect of the changed scene, with a remedy for a command line: it cannot remove a key of the
/// scene itself. `surplus` is the key that is too much.
fn remedied(what: String, surplus: Option<&str>, changes: &[Change]) -> String {
    let own = |key: &str| !changes.iter().any(|change| change.path.iter().any(|part| part == key));
    let table = changes.last().and_then(|change| change.path.first());
    match (surplus.filter(|key| own(key)), table, what.rsplit_once(": ")) {
        (Some(_), Some(table), Some((defect, _))) => {
            format!("{defect}: give the table whole, as --set '{table}={{KEY=VALUE, KEY=VALUE}}'")
        }
        _ => what,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn changed(changes: &[&str]) -> Result<Scene, String> {
        let changes: Result<Vec<Change>, String> = changes.iter().map(|text| text.parse()).collect();
        Scene::load_with("nodule", &changes?).map_err(|e| e.to_string())
    }

    #[test]
    fn numbers_lists_names_and_entries_of_lists_are_changed() {
        let plain = Scene::load("nodule").unwrap();
        let scene = changed(&[
            "tissue.youngs_modulus_pa=5000",
            "name=mine",
            "drive.holds_m = [0.001, 0.002]",
            "tissue.inclusion.0.radius_m=0.004",
            "solver.moving_error_pct=3",
        ])
        .unwrap();
        assert_eq!((scene.tissue.youngs_modulus_pa, scene.name.as_str()), (5000.0, "mine"));
        assert_eq!(scene.drive.targets(), [0.001, 0.002]);
        assert_eq!((scene.tissue.inclusion[0].radius_m, scene.solver.moving_error_pct), (0.004, Some(3.0)));
        assert_eq!(scene.tissue.poisson_ratio, plain.tissue.poisson_ratio);
        let whole = "probe={shape=\"ellipsoid\", semi_axes_m=[0.01, 0.006, 0.006], along=[1, 0, 0]}";
        assert!(matches!(changed(&[whole]).unwrap().probe.shape, crate::scene::Shape::Ellipsoid { .. }));
        // the recorded scene is the changed one
        assert!(scene.text.contains("youngs_modulus_pa = 5000") && scene.text.contains("\"mine\""), "{}", scene.text);
    }

    #[test]
    fn what_cannot_be_changed_is_named() {
        for (change, says) in [
            ("tissue.youngs_modulus=5000", "did you mean \"youngs_modulus_pa\"?"),
            ("tissue.youngs=5000", "did you mean \"youngs_modulus_pa\"?"),
            ("tisue.nodes=100", "did you mean \"tissue\"?"),
            ("tissue.nodes=many", "expected a whole number"),
            ("tissue.poisson_ratio=0.7", "poisson_ratio"),
            ("tissue.inclusion.3.radius_m=0.004", "no entry of a list of 1"),
            ("tissue.nodes.more=1", "has no keys"),
            ("tissue.block_m=[0.08, 0.08, 0.04, 99]", "block_m is a list of length 4: give 3 entries"),
            ("probe.position_m=[0]", "position_m is a list of length 1: give 2 entries"),
            ("tissue.inclusion.0.center_m=[0, 0, -0.01, 0]", "center_m is a list of length 4: give 3 entries"),
            (
                "tissue.inclusion=[{center_m=[0, 0, -0.01, 0], radius_m=0.001, stiffness_ratio=2}]",
                "center_m is a list of length 4: give 3 entries",
            ),
            ("tissue.up=y", "turns a mesh file: remove it"),
            // keys of the preset itself
            ("probe.shape=ellipsoid", "a tip with one radius: give the table whole, as --set 'probe={KEY"),
            ("drive.kind=force", "\"holds_m\": give the table whole, as --set 'drive={KEY"),
            ("tissue.organ=liver", "has both block_m and organ: give the table whole, as --set 'tissue={KEY"),
            ("tissue.nodes", "KEY=VALUE"),
            ("=5", "KEY=VALUE"),
        ] {
            let error = changed(&[change]).unwrap_err();
            assert!(error.contains(says) && error.contains(change), "{change}: {error}");
            assert!(!error.contains('\n'), "{error}");
        }
    }
}
