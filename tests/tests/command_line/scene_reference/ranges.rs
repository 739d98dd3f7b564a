//! The parser uses the ranges and defaults that the page states.

use palpate_tissue::scene::Scene;
use palpate_tissue::tissue::{DEFAULT_NODES, DEFAULT_ORGAN_NODES};
use toml::{Table, Value};

use super::page::{Key, tables};

/// A valid scene in which a key of the given table may be set.
fn base(table: &str, key: &str) -> Table {
    let drive = match key {
        "holds_n" => "kind = \"force\"\nholds_n = [0.1]\nramp_m_per_s = 0.04\nhold_s = 0.3",
        "depth_limit_m" => "kind = \"trace\"\ntrace = \"trace.csv\"",
        _ => "kind = \"depth\"\nholds_m = [0.004]\nramp_m_per_s = 0.04\nhold_s = 0.3",
    };
    let probe = match key {
        "length_m" => "shape = \"capsule\"\nradius_m = 0.008\nalong = [1.0, 0.0, 0.0]",
        "semi_axes_m" => "shape = \"ellipsoid\"\nalong = [1.0, 0.0, 0.0]",
        _ => "shape = \"hemisphere\"\nradius_m = 0.008",
    };
    let (source, site) = match table {
        "[[tissue.region]]" => {
            ("organ = \"foot\"\nregion = [{ name = \"skin\", youngs_modulus_pa = 7e3 }]", "site = [-0.075, 0.0, 0.032]")
        }
        "[[tissue.inclusion]]" => (
            "block_m = [0.08, 0.08, 0.04]\ninclusion = [{ center_m = [0.0, 0.0, -0.012], radius_m = 0.006, stiffness_ratio = 10.0 }]",
            "",
        ),
        "[[tissue.relaxation]]" => ("block_m = [0.08, 0.08, 0.04]\nrelaxation = [{ share = 0.3, time_s = 1.0 }]", ""),
        _ => ("block_m = [0.08, 0.08, 0.04]", ""),
    };
    let modulus = if key == "long_term_modulus_pa" { "" } else { "youngs_modulus_pa = 3500.0" };
    let text = format!(
        "name = \"base\"\n[tissue]\n{source}\n{modulus}\npoisson_ratio = 0.45\ndensity_kg_per_m3 = 1060.0\n[probe]\n{probe}\n{site}\n[drive]\n{drive}\n[solver]\n"
    );
    text.parse().unwrap()
}

/// Keys of a table in a scene; of a repeated table, those of the first one.
fn keys_of<'a>(scene: &'a mut Table, table: &str) -> &'a mut Table {
    let mut at = scene;
    for part in table.trim_matches(['[', ']']).split('.') {
        at = match at.get_mut(part).expect(part) {
            Value::Table(table) => table,
            Value::Array(list) => list[0].as_table_mut().unwrap(),
            other => panic!("{part} is {other}"),
        };
    }
    at
}

fn parse(scene: &Table) -> Result<Scene, String> {
    Scene::parse("base.toml", &toml::to_string(scene).unwrap()).map_err(|error| error.to_string())
}

/// A value for the key that contains as many equal numbers as the key requires.
fn value(key: &str, number: f64) -> Value {
    let one = Value::Float(number);
    match key {
        "block_m" | "gravity_m_per_s2" | "semi_axes_m" | "tilt_deg" => Value::Array(vec![one; 3]),
        "holds_m" | "holds_n" => Value::Array(vec![one]),
        _ => one,
    }
}

/// A range of numbers: its ends, and whether it includes the lower one.
struct Range {
    low: f64,
    low_is_in: bool,
    high: Option<f64>,
}

/// Parses `1 to 5`, `above 0 to 5` or `above 0`; returns `None` for a range in other words.
fn read(range: &str) -> Option<Range> {
    let range = range.split(',').next()?;
    let (low_is_in, numbers) = range.strip_prefix("above ").map_or((true, range), |numbers| (false, numbers));
    let (low, high) = match numbers.split_once(" to ") {
        Some((low, high)) => (low, Some(high.parse().ok()?)),
        None => (numbers, None),
    };
    Some(Range { low: low.parse().ok()?, low_is_in, high })
}

/// All keys with a numeric range.
fn ranged() -> Vec<(&'static str, Key, Range)> {
    let mut all = Vec::new();
    for table in tables() {
        for key in table.keys {
            if let Some(range) = key.range.as_deref().and_then(read) {
                all.push((table.name, key, range));
            }
        }
    }
    all
}

#[test]
fn the_parser_takes_a_range_to_its_ends_and_nothing_beyond() {
    let all = ranged();
    assert!(all.len() >= 22, "{}", all.len());
    for (table, Key { name, .. }, Range { low, low_is_in, high }) in all {
        let with = |number: f64| {
            let mut scene = base(table, &name);
            keys_of(&mut scene, table).insert(name.clone(), value(&name, number));
            parse(&scene)
        };
        // a thousandth of the end, or of the range if that end is zero
        let step = |end: f64| 1e-3 * if end == 0.0 { high.unwrap_or(1.0).abs() } else { end.abs() };
        for inside in [Some(if low_is_in { low } else { low + step(low) }), high].into_iter().flatten() {
            assert!(with(inside).is_ok(), "{table} {name} = {inside}: {:?}", with(inside).err());
        }
        for outside in [Some(if low_is_in { low - step(low) } else { low }), high.map(|high| high + step(high))] {
            let Some(outside) = outside else { continue };
            let message = with(outside).expect_err(&format!("{table} {name} = {outside}"));
            // a message may name the derived quantity: an ellipsoid's third semi-axis is its radius
            let of_table = table.trim_matches(['[', ']']).split('.').next_back().unwrap_or_default();
            assert!(message.contains(&name) || message.contains(of_table), "{message}");
        }
    }
}

#[test]
fn a_key_that_is_left_out_has_its_default() {
    let mut seen = 0;
    for table in tables().iter().filter(|table| table.name != "top") {
        for Key { name, default, .. } in &table.keys {
            let number: Option<f64> = default.split(',').next().and_then(|first| first.parse().ok());
            let Some(given) =
                number.map(|n| value(name, n)).or_else(|| (name == "method").then(|| Value::String(default.clone())))
            else {
                continue;
            };
            if name == "position_m" {
                continue; // `every_scene_key_acts` presses with it
            }
            let left_out = base(table.name, name);
            let mut said = left_out.clone();
            keys_of(&mut said, table.name).insert(name.clone(), given);
            let [a, b] = [left_out, said].map(|scene| parse(&scene).unwrap());
            assert_eq!((a.tissue, a.probe, a.drive, a.solver), (b.tissue, b.probe, b.drive, b.solver), "{} {name}", table.name);
            seen += 1;
        }
    }
    assert!(seen >= 5, "{seen}");
}

#[test]
fn the_default_numbers_of_nodes_are_those_of_the_mesher() {
    let tables = tables();
    let nodes = tables.iter().flat_map(|table| &table.keys).find(|key| key.name == "nodes").unwrap();
    assert_eq!(
        nodes.default,
        format!("{DEFAULT_NODES} of a block, or as many as its proportions need; {DEFAULT_ORGAN_NODES} of an organ or a surface")
    );
}
