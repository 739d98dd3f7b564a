//! Checks summaries against the JSON schema. The checker knows only the keywords that the schema
//! uses.

use std::path::Path;
use std::sync::OnceLock;

use serde_json::Value;

use crate::palpate_command::repository;

/// The schema of every `summary.json`.
///
/// # Panics
/// Panics if the schema is missing or not JSON.
pub fn summaries() -> &'static Value {
    static SCHEMA: OnceLock<Value> = OnceLock::new();
    SCHEMA.get_or_init(|| {
        let text = std::fs::read_to_string(repository().join("host-sim/summary.schema.json")).expect("the schema ships");
        serde_json::from_str(&text).expect("the schema is JSON")
    })
}

/// Checks every `summary.json` in a folder and its subfolders.
///
/// # Panics
/// Panics if a summary does not follow the schema.
pub fn check_all(folder: &Path) {
    // the system's temporary folder, which some tests use, may contain other programs' files
    if std::env::temp_dir().starts_with(folder) {
        return;
    }
    for entry in std::fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        // links are not followed, because they may lead anywhere
        if entry.file_type().is_ok_and(|kind| kind.is_dir()) {
            check_all(&path);
        } else if path.file_name().is_some_and(|name| name == "summary.json")
            && let Ok(summary @ Value::Object(_)) = serde_json::from_slice(&std::fs::read(&path).unwrap_or_default())
        {
            let defects = defects(&summary);
            assert!(defects.is_empty(), "{} does not follow the schema:\n{}", path.display(), defects.join("\n"));
        }
    }
}

/// Lists where and how a summary departs from the schema.
pub fn defects(summary: &Value) -> Vec<String> {
    let mut defects = Vec::new();
    against(summaries(), summary, "", &mut defects);
    defects
}

/// Keywords that do not constrain a value.
const NOTES: [&str; 5] = ["$schema", "$id", "$defs", "title", "description"];

fn against(schema: &Value, value: &Value, at: &str, defects: &mut Vec<String>) {
    for (keyword, asked) in schema.as_object().into_iter().flatten() {
        let mut miss = |what: String| defects.push(format!("{}: {what}", if at.is_empty() { "/" } else { at }));
        match keyword.as_str() {
            "$ref" => {
                let named = asked.as_str().and_then(|path| summaries().pointer(path.strip_prefix('#')?));
                against(named.unwrap_or_else(|| panic!("{asked} is not in the schema")), value, at, defects);
            }
            "type" => {
                let types: Vec<&str> = asked
                    .as_array()
                    .map_or_else(|| asked.as_str().into_iter().collect(), |list| list.iter().filter_map(Value::as_str).collect());
                if !types.iter().any(|name| is(value, name)) {
                    miss(format!("{value} is no {}", types.join(" or ")));
                }
            }
            "const" if value != asked => miss(format!("{value} is not {asked}")),
            "enum" if !asked.as_array().is_some_and(|list| list.contains(value)) => miss(format!("{value} is none of {asked}")),
            "const" | "enum" => {}
            "minimum" if value.as_f64() < asked.as_f64() => miss(format!("{value} is below {asked}")),
            "minimum" => {}
            "required" => {
                for key in asked.as_array().into_iter().flatten().filter_map(Value::as_str) {
                    if value.as_object().is_some_and(|object| !object.contains_key(key)) {
                        miss(format!("{key} is missing"));
                    }
                }
            }
            "properties" => {
                for (key, schema) in asked.as_object().into_iter().flatten() {
                    if let Some(inner) = value.get(key) {
                        against(schema, inner, &format!("{at}/{key}"), defects);
                    }
                }
            }
            "additionalProperties" => {
                let known = schema["properties"].as_object();
                for (key, inner) in value.as_object().into_iter().flatten() {
                    if known.is_some_and(|known| known.contains_key(key)) {
                        continue;
                    }
                    match asked {
                        Value::Bool(false) => defects.push(format!("{at}/{key}: no such key is named")),
                        Value::Bool(true) => {}
                        schema => against(schema, inner, &format!("{at}/{key}"), defects),
                    }
                }
            }
            "items" => {
                for (n, inner) in value.as_array().into_iter().flatten().enumerate() {
                    against(asked, inner, &format!("{at}/{n}"), defects);
                }
            }
            "anyOf" => {
                let tried = asked.as_array().into_iter().flatten().map(|schema| {
                    let mut found = Vec::new();
                    against(schema, value, at, &mut found);
                    found
                });
                // of several alternatives, the one with the fewest defects describes the error best
                defects.extend(tried.min_by_key(Vec::len).unwrap_or_default());
            }
            "allOf" => asked.as_array().into_iter().flatten().for_each(|schema| against(schema, value, at, defects)),
            "if" => {
                let mut found = Vec::new();
                against(asked, value, at, &mut found);
                if found.is_empty() {
                    against(&schema["then"], value, at, defects);
                }
            }
            "then" => {}
            note if NOTES.contains(&note) => {}
            other => panic!("the schema has the keyword {other}, which is not checked here"),
        }
    }
}

fn is(value: &Value, name: &str) -> bool {
    match name {
        "null" => value.is_null(),
        "boolean" => value.is_boolean(),
        "integer" => value.is_u64() || value.is_i64(),
        "number" => value.is_number(),
        "string" => value.is_string(),
        "array" => value.is_array(),
        "object" => value.is_object(),
        other => panic!("the schema has the type {other}"),
    }
}
