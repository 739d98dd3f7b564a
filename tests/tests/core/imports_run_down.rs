//! Imports point downwards: no crate depends on one above it, and no files, and no modules of a
//! crate's root, import each other in a circle, except a file and those in the folder of the same
//! name.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use palpate_tests::palpate_command::{files_below, repository};

/// Name of a package, its folder, and the packages of the repository on which it may depend.
const LAYERS: [(&str, &str, &[&str]); 13] = [
    ("palpate", "core", &[]),
    ("palpate-controller", "firmware/controller", &["palpate"]),
    ("palpate-firmware", "firmware", &["palpate", "palpate-controller"]),
    ("palpate-charts", "host-sim/charts", &[]),
    ("palpate-tissue", "host-sim/tissue", &["palpate"]),
    ("palpate-fit", "host-sim/fit", &["palpate", "palpate-tissue"]),
    ("palpate-loop", "host-sim/loop", &["palpate", "palpate-tissue"]),
    ("palpate-bindings", "host-sim/bindings", &["palpate", "palpate-loop", "palpate-tissue"]),
    ("palpate-python", "host-sim/bindings/python", &["palpate", "palpate-loop", "palpate-tissue"]),
    ("palpate-board", "host-sim/board", &["palpate", "palpate-controller", "palpate-loop", "palpate-tissue"]),
    (
        "palpate-sim",
        "host-sim",
        &["palpate", "palpate-board", "palpate-charts", "palpate-controller", "palpate-fit", "palpate-loop", "palpate-tissue"],
    ),
    (
        "palpate-lab",
        "host-sim/lab",
        &["palpate", "palpate-charts", "palpate-fit", "palpate-loop", "palpate-sim", "palpate-tissue"],
    ),
    ("palpate-live", "host-sim/live", &["palpate", "palpate-loop", "palpate-tissue"]),
];

/// Packages that may depend on all others and on which no other may depend.
const ON_TOP: [&str; 4] = ["tests", "tests/bench", "tests/mutants", "host-sim/live/tools/page"];

#[test]
fn no_crate_stands_on_one_above_it() {
    for (package, folder, allowed) in LAYERS {
        let manifest = std::fs::read_to_string(repository().join(folder).join("Cargo.toml")).unwrap();
        assert!(manifest.contains(&format!("name = \"{package}\"")), "{folder} is not {package}");
        for name in own_dependencies(&manifest) {
            assert!(allowed.contains(&name.as_str()), "{package} stands on {name}, which is not below it");
        }
    }
}

#[test]
fn every_crate_has_a_place() {
    let workspace: toml::Table = std::fs::read_to_string(repository().join("Cargo.toml")).unwrap().parse().unwrap();
    let members = workspace["workspace"]["members"].as_array().unwrap();
    for member in members {
        let member = member.as_str().unwrap();
        let placed = LAYERS.iter().any(|(_, folder, _)| *folder == member) || ON_TOP.contains(&member);
        assert!(placed, "{member} has no place in the order of crates");
    }
}

/// Packages of the repository on which a manifest depends, in any section and under any name.
fn own_dependencies(manifest: &str) -> Vec<String> {
    let manifest: toml::Table = manifest.parse().unwrap();
    let targets = manifest.get("target").and_then(toml::Value::as_table);
    let sections =
        std::iter::once(&manifest).chain(targets.into_iter().flat_map(|t| t.values().filter_map(toml::Value::as_table)));
    let kinds = ["dependencies", "dev-dependencies", "build-dependencies"];
    let tables = sections.flat_map(|section| kinds.map(|kind| section.get(kind).and_then(toml::Value::as_table)));
    let named = tables.flatten().flatten().map(|(name, spec)| spec.get("package").and_then(toml::Value::as_str).unwrap_or(name));
    named.filter(|name| name.starts_with("palpate")).map(str::to_owned).collect()
}

#[test]
fn a_dependency_is_seen_however_it_is_written() {
    let written = [
        "[dependencies]\npalpate-lab.workspace = true",
        "[dependencies.palpate-lab]\npath = \"../lab\"",
        "[dependencies]\nlab = { package = \"palpate-lab\", path = \"../lab\" }",
        "[target.'cfg(unix)'.dev-dependencies]\npalpate-lab = { path = \"../lab\" }",
    ];
    for manifest in written {
        assert_eq!(own_dependencies(manifest), ["palpate-lab"], "{manifest}");
    }
}

#[test]
fn no_files_import_each_other_in_a_circle() {
    let mut circles = Vec::new();
    for (package, folder, _) in LAYERS {
        let files = Files::read(&repository().join(folder).join("src"));
        assert!(!files.text.is_empty(), "{package} has no files");
        circles.extend(files.circles().into_iter().chain(files.circles_of_modules()).map(|circle| (package, circle)));
    }
    assert!(circles.is_empty(), "{circles:#?}");
}

#[test]
fn a_circle_is_found_and_a_file_with_its_folder_is_none() {
    let files = |texts: &[(&str, &str)]| {
        let text = texts.iter().map(|(name, text)| (name.split('/').map(str::to_owned).collect(), (*text).to_owned())).collect();
        Files { text }
    };
    let circle = files(&[
        ("a", "use crate::b::B; pub struct A;"),
        ("b", "mod inner; pub use inner::B;"),
        ("b/inner", "use crate::a::A; pub struct B;"),
    ]);
    assert_eq!(circle.circles(), [["a", "b/inner"]]);
    let in_words = files(&[("a", "// use crate::b::B;\npub struct A;"), ("b", "pub fn b() { crate::a::a(); }")]);
    assert!(in_words.circles().is_empty());
    let inline = files(&[("a", "pub fn a() { crate::b::b(); }"), ("b", "pub fn b() { super::a::a(); }")]);
    assert_eq!(inline.circles(), [["a", "b"]]);
    let folder = files(&[("a", "mod b; use b::B; pub struct A;"), ("a/b", "use super::A; pub struct B;")]);
    assert!(folder.circles().is_empty());
    let through = files(&[("a", "mod b; use b::B;"), ("a/b", "use crate::c::C;"), ("c", "use crate::a::A;")]);
    assert_eq!(through.circles(), [["a", "a/b"], ["a", "c"], ["a/b", "c"]]);
}

#[test]
fn a_circle_of_modules_is_found_where_no_file_closes_it() {
    let texts = [
        ("patch", "mod stiffness; use crate::tissue::Tissue;"),
        ("patch/stiffness", "pub fn six_volume() {}"),
        ("tissue", "mod steepness; pub struct Tissue;"),
        ("tissue/steepness", "use crate::patch::stiffness::six_volume;"),
        ("mesh", "mod quality; pub use quality::Quality;"),
        ("mesh/quality", "use super::Mesh; pub struct Quality;"),
    ];
    let text = texts.iter().map(|(name, text)| (name.split('/').map(str::to_owned).collect(), (*text).to_owned())).collect();
    let files = Files { text };
    assert!(files.circles().is_empty());
    assert_eq!(files.circles_of_modules(), [["patch", "tissue"]]);
}

type Module = Vec<String>;

/// Source files of a crate, by module.
struct Files {
    text: BTreeMap<Module, String>,
}

impl Files {
    fn read(folder: &Path) -> Self {
        let mut text = BTreeMap::new();
        for path in files_below(&[folder.to_str().unwrap()], ".rs").into_iter().filter(|path| !path.ends_with("tests.rs")) {
            let relative = path.strip_prefix(folder).unwrap().with_extension("");
            let mut module: Module = relative.iter().map(|part| part.to_string_lossy().into_owned()).collect();
            module.pop_if(|last| ["lib", "mod"].contains(&last.as_str()));
            text.insert(module, std::fs::read_to_string(&path).unwrap());
        }
        Self { text }
    }

    /// Pairs of files that reach each other by imports. Imports of a folder's own file by the files
    /// in that folder are not counted.
    fn circles(&self) -> Vec<[String; 2]> {
        let mut arrows = self.arrows();
        for (module, to) in &mut arrows {
            // a file calls its submodules without an import
            let inner =
                self.text.keys().filter(|to| to.len() == module.len() + 1 && !module.is_empty() && to.starts_with(module));
            to.extend(inner);
        }
        both_ways(&arrows, |module| module.join("/"))
    }

    /// Pairs of modules of the crate's root that reach each other by imports of any of their files.
    fn circles_of_modules(&self) -> Vec<[String; 2]> {
        let mut arrows: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
        for (from, to) in self.arrows() {
            let Some(from) = from.first() else { continue };
            let others = to.into_iter().filter_map(|to| to.first()).filter(|to| *to != from);
            arrows.entry(from).or_default().extend(others.map(String::as_str));
        }
        both_ways(&arrows, |module| (*module).to_owned())
    }

    /// Modules that each module imports, without those that contain it.
    fn arrows(&self) -> BTreeMap<&Module, BTreeSet<&Module>> {
        let code: BTreeMap<&Module, String> = self.text.iter().map(|(m, text)| (m, without_words(text))).collect();
        let imports: BTreeMap<&Module, Vec<Import>> = code.iter().map(|(m, code)| (*m, Import::all(code))).collect();
        let mut arrows: BTreeMap<&Module, BTreeSet<&Module>> = BTreeMap::new();
        for (module, own) in &imports {
            for import in own.iter().filter(|import| !import.public) {
                let found = self.resolved(&imports, &code, module, &import.path, 0);
                let other = found.filter(|to| !module.starts_with(to));
                arrows.entry(module).or_default().extend(other);
            }
        }
        arrows
    }

    /// Module whose file defines the item that `path` names, as seen from `module`.
    fn resolved(
        &self,
        imports: &BTreeMap<&Module, Vec<Import>>,
        code: &BTreeMap<&Module, String>,
        module: &Module,
        path: &[String],
        depth: usize,
    ) -> Option<&Module> {
        let supers = path.iter().take_while(|part| *part == "super").count();
        let (mut at, mut rest) = match path.first()?.as_str() {
            "crate" => (Module::new(), &path[1..]),
            "self" => (module.clone(), &path[1..]),
            "super" => (module.iter().take(module.len().checked_sub(supers)?).cloned().collect(), &path[supers..]),
            first if self.text.contains_key(&[&module[..], &[first.to_owned()]].concat()) => (module.clone(), path),
            _ => return None,
        };
        while let Some((first, behind)) = rest.split_first() {
            let child = [&at[..], std::slice::from_ref(first)].concat();
            if !self.text.contains_key(&child) {
                break;
            }
            (at, rest) = (child, behind);
        }
        let (here, _) = self.text.get_key_value(&at)?;
        let Some(item) = rest.first().filter(|item| !defines(&code[here], item)) else { return Some(here) };
        let passed_on = imports[here].iter().find(|import| import.path.last() == Some(item) && import.path != path);
        passed_on
            .filter(|_| depth < 9)
            .and_then(|import| self.resolved(imports, code, here, &import.path, depth + 1))
            .or(Some(here))
    }
}

/// Pairs that reach each other along the arrows.
fn both_ways<T: Ord + Copy>(arrows: &BTreeMap<T, BTreeSet<T>>, name: impl Fn(&T) -> String) -> Vec<[String; 2]> {
    let reach: BTreeMap<T, BTreeSet<T>> = arrows.keys().map(|from| (*from, reached(arrows, *from))).collect();
    let both = |a: T, b: T| a < b && reach[&a].contains(&b) && reach[&b].contains(&a);
    let pairs = reach.keys().flat_map(|a| reach.keys().filter(|b| both(*a, **b)).map(|b| [name(a), name(b)]));
    pairs.collect()
}

/// All that can be reached along the arrows.
fn reached<T: Ord + Copy>(arrows: &BTreeMap<T, BTreeSet<T>>, from: T) -> BTreeSet<T> {
    let (mut seen, mut next) = (BTreeSet::new(), vec![from]);
    while let Some(now) = next.pop() {
        next.extend(arrows.get(&now).into_iter().flatten().copied().filter(|to| seen.insert(*to)));
    }
    seen
}

fn defines(code: &str, item: &str) -> bool {
    let words: Vec<&str> = code.split(|c: char| !c.is_alphanumeric() && c != '_').filter(|word| !word.is_empty()).collect();
    let kinds = ["struct", "enum", "fn", "const", "static", "trait", "type", "macro_rules"];
    words.windows(2).any(|pair| kinds.contains(&pair[0]) && pair[1] == item)
}

/// A path that a file names.
struct Import {
    path: Vec<String>,
    /// Re-exported by `pub use`, which does not count as an import of this file.
    public: bool,
}

impl Import {
    fn all(code: &str) -> Vec<Self> {
        let mut found = Vec::new();
        let mut rest = code;
        while let Some(at) = rest.find("use ") {
            let starts = rest[..at].chars().next_back().is_none_or(|c| !c.is_alphanumeric() && c != '_');
            let end = rest[at..].find(';').map_or(rest.len(), |end| at + end);
            if starts {
                let public = rest[..at].trim_end().ends_with("pub") || rest[..at].trim_end().ends_with(')');
                tree(&rest[at + 4..end], &[], &mut |path| found.push(Self { path, public }));
            }
            rest = &rest[if starts { end } else { at + 4 }..];
        }
        for root in ["crate::", "super::"] {
            for (at, _) in code.match_indices(root) {
                let path = code[at..].split(|c: char| !c.is_alphanumeric() && c != '_' && c != ':').next().unwrap_or_default();
                let path: Vec<String> = path.split("::").filter(|part| !part.is_empty()).map(str::to_owned).collect();
                let inside = code[..at].ends_with("::") || code[..at].ends_with(|c: char| c.is_alphanumeric());
                if path.len() > 1 && !inside && !in_use(code, at) {
                    found.push(Self { path, public: false });
                }
            }
        }
        found
    }
}

/// Whether a position is inside a `use` statement.
fn in_use(code: &str, at: usize) -> bool {
    let statement = code[..at].rfind([';', '}']).map_or(&code[..at], |start| &code[start..at]);
    statement.contains("use ")
}

/// Finds the paths in a `use` tree.
fn tree(text: &str, prefix: &[String], found: &mut impl FnMut(Vec<String>)) {
    let text = text.trim();
    if let Some((head, inner)) = text.strip_suffix('}').and_then(|text| text.split_once('{')) {
        let head = head.split("::").map(str::trim).filter(|part| !part.is_empty()).map(str::to_owned);
        let prefix: Vec<String> = prefix.iter().cloned().chain(head).collect();
        let (mut depth, mut from) = (0, 0);
        for (at, letter) in inner.char_indices().chain([(inner.len(), ',')]) {
            match letter {
                '{' => depth += 1,
                '}' => depth -= 1,
                ',' if depth == 0 => {
                    tree(&inner[from..at], &prefix, found);
                    from = at + 1;
                }
                _ => {}
            }
        }
    } else if !text.is_empty() {
        let path = text.split(" as ").next().unwrap_or_default().split("::").map(|part| part.trim().to_owned());
        found(prefix.iter().cloned().chain(path.filter(|part| part != "self" || prefix.is_empty())).collect());
    }
}

/// The text without comments, contents of strings, and unit tests.
fn without_words(text: &str) -> String {
    let mut rest = text.split("#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    let mut code = String::new();
    while let Some(at) = rest.find(['/', '"', '\'']) {
        let raw = rest[..at].trim_end_matches('#');
        let hashes = &rest[raw.len()..at];
        let raw = raw.strip_suffix('r').map(|before| before.strip_suffix('b').unwrap_or(before));
        let is_raw = rest[at..].starts_with('"') && raw.is_some_and(|before| !before.ends_with(char::is_alphanumeric));
        code.push_str(&rest[..at]);
        let (kept, behind) = match rest.as_bytes()[at..] {
            [b'/', b'/', ..] => ("", rest[at..].find('\n').unwrap_or(rest.len() - at)),
            [b'"', ..] if is_raw => ("\"\"", 1 + end_of(&rest[at + 1..], &format!("\"{hashes}"), false)),
            [b'"', ..] => ("\"\"", 1 + end_of(&rest[at + 1..], "\"", true)),
            [b'\'', b'\\', ..] => ("", 3 + end_of(&rest[at + 3..], "'", false)),
            [b'\'', _, b'\'', ..] => ("", 3),
            _ => (&rest[at..=at], 1),
        };
        code.push_str(kept);
        rest = &rest[at + behind..];
    }
    code + rest
}

/// Number of bytes up to the end of a string, including its closing mark.
fn end_of(text: &str, mark: &str, escapes: bool) -> usize {
    let escaped = |at: usize| escapes && at % 2 != text[..at].trim_end_matches('\\').len() % 2;
    text.match_indices(mark).find(|(at, _)| !escaped(*at)).map_or(text.len(), |(at, mark)| at + mark.len())
}

#[test]
fn words_are_left_out_and_code_behind_them_is_kept() {
    let text = r##"a("https://b"); c("d \" e \\"); f('"', '\'', '\\', 'é'); g(r#"h " i"#); // "j
k<'l>()"##;
    assert_eq!(without_words(text), "a(\"\"); c(\"\"); f(, , , 'é'); g(r#\"\"); \nk<'l>()");
}
