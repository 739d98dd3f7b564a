//! Reads the doc comments of the scene's types and writes the page.

use std::fmt::Write as _;

use palpate_tests::palpate_command::repository;
use syn::{Attribute, Expr, ExprLit, Fields, Item, Lit, Meta, Type};

/// Tables of a scene file: heading, source file below `host-sim/tissue/src`, type.
const TABLES: [(&str, &str, &str); 8] = [
    ("top", "scene.rs", "Scene"),
    ("[tissue]", "scene.rs", "TissueScene"),
    ("[[tissue.region]]", "scene.rs", "RegionScene"),
    ("[[tissue.inclusion]]", "scene.rs", "Inclusion"),
    ("[[tissue.relaxation]]", "scene/relaxation.rs", "RelaxationScene"),
    ("[probe]", "scene.rs", "ProbeKeys"),
    ("[drive]", "scene/drive.rs", "Table"),
    ("[solver]", "scene.rs", "Solver"),
];

/// Types whose variants are a key's accepted words: type of the key, source file, enum.
const WORDS: [(&str, &str, &str); 3] =
    [("Name", "scene/shape.rs", "Name"), ("Kind", "scene/drive.rs", "Kind"), ("Method", "scene.rs", "Method")];

const HEAD: &str = "\
# Scene reference

<!-- Made from the docs of the scene's types: do not edit. To make it anew:
     cargo test --release -p palpate-tests --test command_line -- --ignored rewrite_the_scene_reference -->

Every key of a scene file, as the parser knows it. An unknown key is an error that names the nearest known one. The tests
hold each range and default against the parser. *Source* says where values in the presets come from.

A scene to begin with is in [Your own scene](guide/scene.md).
";

/// A table of a scene file.
pub struct Table {
    /// Heading, such as `[tissue]`.
    pub name: &'static str,
    about: String,
    /// Keys, in the order of the source.
    pub keys: Vec<Key>,
}

/// A key of a table.
pub struct Key {
    /// Name of the key.
    pub name: String,
    /// First paragraph of the key's doc comment, without the unit.
    pub meaning: String,
    unit: String,
    /// Range as stated in the doc comment.
    pub range: Option<String>,
    /// Default as stated in the doc comment, or as implied by the key's type.
    pub default: String,
    source: Option<String>,
    words: Vec<(String, String)>,
}

fn items(file: &str) -> Vec<Item> {
    let path = repository().join("host-sim/tissue/src").join(file);
    syn::parse_file(&std::fs::read_to_string(path).unwrap()).expect(file).items
}

/// Lines of a doc comment.
fn docs(attributes: &[Attribute]) -> Vec<String> {
    let text = |attribute: &Attribute| match &attribute.meta {
        Meta::NameValue(pair) if pair.path.is_ident("doc") => match &pair.value {
            Expr::Lit(ExprLit { lit: Lit::Str(text), .. }) => Some(text.value().strip_prefix(' ').unwrap_or_default().to_owned()),
            _ => None,
        },
        _ => None,
    };
    attributes.iter().filter_map(text).collect()
}

/// Whether one of a field's serde attributes begins with this word.
fn serde_says(attributes: &[Attribute], word: &str) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        Meta::List(list) if list.path.is_ident("serde") => list.tokens.to_string().starts_with(word),
        _ => false,
    })
}

/// Last path segment of a type and of its arguments: `Option<Vec<f64>>` gives `Option`, `Vec`.
fn words_of(ty: &Type) -> Vec<String> {
    match ty {
        Type::Path(path) => {
            let Some(last) = path.path.segments.last() else { return Vec::new() };
            let mut words = vec![last.ident.to_string()];
            if let syn::PathArguments::AngleBracketed(inner) = &last.arguments {
                for argument in &inner.args {
                    if let syn::GenericArgument::Type(inner) = argument {
                        words.extend(words_of(inner));
                    }
                }
            }
            words
        }
        Type::Array(array) => words_of(&array.elem),
        _ => Vec::new(),
    }
}

/// Splits a key's doc comment into its first paragraph and its list.
fn split(lines: &[String]) -> (String, Vec<(String, String)>) {
    let (mut meaning, mut list): (Vec<&str>, Vec<(String, String)>) = (Vec::new(), Vec::new());
    for line in lines {
        if let Some((name, value)) = line.strip_prefix("* ").and_then(|item| item.split_once(": ")) {
            list.push((name.into(), value.into()));
        } else if let Some((_, value)) = list.last_mut() {
            value.push(' ');
            value.push_str(line.trim());
        } else if !line.is_empty() {
            meaning.push(line.trim());
        }
    }
    (meaning.join(" "), list)
}

/// Removes the unit, ` [Pa]` or ` (1)`, from a meaning and returns it.
fn take_unit(meaning: &mut String) -> Option<String> {
    let bracket = meaning.match_indices(" [").find_map(|(at, _)| meaning[at..].find(']').map(|end| (at, at + end + 1)));
    let (begin, end) = bracket.or_else(|| meaning.find(" (1)").map(|at| (at, at + 4)))?;
    let unit = meaning[begin + 2..end - 1].to_owned();
    meaning.replace_range(begin..end, "");
    Some(unit)
}

fn key(field: &syn::Field) -> Key {
    let name = field.ident.as_ref().expect("a named field").to_string();
    let (mut meaning, list) = split(&docs(&field.attrs));
    let types = words_of(&field.ty);
    let is = |word: &str| types.iter().any(|t| t == word);
    let listed = |what: &str| list.iter().find(|(name, _)| name == what).map(|(_, value)| value.clone());
    let unit = take_unit(&mut meaning).unwrap_or_else(|| {
        let by_type =
            [("PathBuf", "file"), ("usize", "count"), ("String", "text"), ("Name", "word"), ("Kind", "word"), ("Method", "word")];
        let by_type = by_type.iter().find(|(ty, _)| is(ty)).map(|(_, unit)| *unit);
        by_type.unwrap_or(if is("LengthUnit") { "word, or m" } else { "table" }).to_owned()
    });
    let default = listed("default").unwrap_or_else(|| {
        let optional = is("Option") || is("Vec") || is("Solver") || serde_says(&field.attrs, "default");
        if optional { "none" } else { "required" }.to_owned()
    });
    let words = WORDS.iter().filter(|(ty, ..)| is(ty)).flat_map(|(_, file, ty)| variants(file, ty)).collect();
    Key { name, meaning, unit, range: listed("range"), default, source: listed("source"), words }
}

/// Words that an enum accepts, with their doc comments.
fn variants(file: &str, name: &str) -> Vec<(String, String)> {
    let found = items(file).into_iter().find_map(|item| match item {
        Item::Enum(found) if found.ident == name => Some(found),
        _ => None,
    });
    let word = |v: &syn::Variant| (v.ident.to_string().to_lowercase(), docs(&v.attrs).join(" "));
    found.expect(name).variants.iter().map(word).collect()
}

/// All tables with their keys.
pub fn tables() -> Vec<Table> {
    let table = |(name, file, ty): (&'static str, &str, &str)| {
        let found = items(file).into_iter().find_map(|item| match item {
            Item::Struct(found) if found.ident == ty => Some(found),
            _ => None,
        });
        let found = found.expect(ty);
        let about = docs(&found.attrs).into_iter().take_while(|line| !line.is_empty()).collect::<Vec<_>>().join(" ");
        let Fields::Named(fields) = &found.fields else { panic!("{ty} has no keys") };
        let keys = fields.named.iter().filter(|field| !serde_says(&field.attrs, "skip")).map(key).collect();
        Table { name, about, keys }
    };
    TABLES.into_iter().map(table).collect()
}

/// Text of the page.
pub fn page() -> String {
    let mut page = HEAD.to_owned();
    for Table { name, about, keys } in tables() {
        match name {
            "top" => writeln!(page, "\n## Top of the file\n\nKeys before the first table, and the tables.\n"),
            _ => writeln!(page, "\n## `{name}`\n\n{about}\n"),
        }
        .unwrap();
        writeln!(page, "| key | meaning | unit | range | default | source |\n|---|---|---|---|---|---|").unwrap();
        for key in &keys {
            let Key { name, meaning, unit, range, default, source, .. } = key;
            let (range, source) = (range.as_deref().unwrap_or("-"), source.as_deref().unwrap_or("-"));
            writeln!(page, "| `{name}` | {meaning} | {unit} | {range} | {default} | {source} |").unwrap();
        }
        for key in keys.iter().filter(|key| !key.words.is_empty()) {
            writeln!(page, "\n`{}` is one of\n\n| word | meaning |\n|---|---|", key.name).unwrap();
            for (word, meaning) in &key.words {
                writeln!(page, "| `\"{word}\"` | {meaning} |").unwrap();
            }
        }
    }
    page
}
