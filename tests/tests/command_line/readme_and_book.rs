//! README and book are consistent: links and anchors resolve, pictures exist, every page is in the
//! table of contents, and the README is short.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use palpate_tests::palpate_command::{files_below, repository};

const BOOK: &str = "host-sim/book/src";
/// Largest number of lines in the README, and of words in a paragraph or list item of README and
/// book.
const MOST_LINES: usize = 100;
const MOST_WORDS: usize = 105;

fn read(path: &str) -> String {
    std::fs::read_to_string(repository().join(path)).unwrap_or_else(|error| panic!("{path}: {error}"))
}

/// Markdown files in a folder and its subfolders, relative to the repository's root.
fn markdown_below(folder: &str) -> Vec<String> {
    let below = |path: PathBuf| path.strip_prefix(repository()).unwrap().to_str().unwrap().to_owned();
    files_below(&[folder], ".md").into_iter().map(below).collect()
}

/// Path and text of the README and of the book's pages, without included or generated pages.
pub fn own_pages() -> Vec<(String, String)> {
    let pages =
        markdown_below(BOOK).into_iter().filter(|page| !page.ends_with("SUMMARY.md") && !page.ends_with("scene-reference.md"));
    let mut all = vec!["README.md".to_owned()];
    all.extend(pages);
    all.into_iter().map(|path| (path.clone(), read(&path))).collect()
}

/// File that a line of a page includes, relative to the repository's root.
fn included(page: &str, line: &str) -> Option<String> {
    let path = line.trim().strip_prefix("{{#include ")?.strip_suffix("}}")?;
    Some(joined(page, path))
}

/// Path of `target`, which is relative to `page`, without `..`.
fn joined(page: &str, target: &str) -> String {
    let mut parts: Vec<&str> = page.split('/').collect();
    parts.pop();
    for part in target.split('/') {
        match part {
            ".." => drop(parts.pop()),
            "." | "" => {}
            part => parts.push(part),
        }
    }
    parts.join("/")
}

/// The text of a page with its included files.
fn whole(page: &str) -> String {
    let line = |line: &str| match included(page, line) {
        // a guide of the firmware exists only together with its boards
        Some(path) if path.starts_with("firmware/") && !repository().join(&path).exists() => String::new(),
        Some(path) => read(&path),
        None => line.to_owned(),
    };
    read(page).lines().map(|text| line(text) + "\n").collect()
}

/// Lines outside fenced code, without inline code.
fn prose(text: &str) -> Vec<String> {
    let mut fenced = false;
    let mut lines = Vec::new();
    for line in text.lines() {
        if line.trim_start().starts_with("```") {
            fenced = !fenced;
            lines.push(String::new());
        } else if fenced {
            lines.push(String::new());
        } else {
            lines.push(line.split('`').step_by(2).collect::<Vec<_>>().join("`"));
        }
    }
    lines
}

/// Targets of the links and pictures in a text.
fn targets(text: &str) -> Vec<String> {
    let lines = prose(text);
    let of_line = |line: &String| {
        let rest: Vec<String> = line.split("](").skip(1).filter_map(|rest| Some(rest.split_once(')')?.0.to_owned())).collect();
        rest
    };
    lines.iter().flat_map(of_line).collect()
}

/// Anchors in a text: of its headings, as GitHub and mdBook generate them, and of its rows.
fn anchors(text: &str) -> BTreeSet<String> {
    let slug = |heading: &str| -> String {
        let kept = heading
            .trim()
            .to_lowercase()
            .chars()
            .filter(|c| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_'))
            .collect::<String>();
        kept.replace(' ', "-")
    };
    let mut fenced = false;
    let headings = text.lines().filter(|line| {
        fenced ^= line.trim_start().starts_with("```");
        !fenced && line.starts_with('#')
    });
    let rows = text.split("<a id=\"").skip(1).filter_map(|rest| Some(rest.split_once('"')?.0.to_owned()));
    headings.map(|line| slug(line.trim_start_matches('#'))).chain(rows).collect()
}

/// Links in a page whose target does not exist.
fn broken(page: &str, text: &str) -> Vec<String> {
    let mut broken = Vec::new();
    for target in targets(text) {
        if target.contains("://") {
            continue;
        }
        let (path, anchor) = target.split_once('#').unwrap_or((&target, ""));
        let file = if path.is_empty() { page.to_owned() } else { joined(page, path) };
        if !repository().join(&file).exists() {
            broken.push(format!("{page}: {target} is not there"));
        } else if !anchor.is_empty() && !anchors(&whole(&file)).contains(anchor) {
            broken.push(format!("{page}: {file} has no heading for #{anchor}"));
        } else if page.starts_with(BOOK) && file.ends_with(".md") && !file.starts_with(BOOK) {
            broken.push(format!("{page}: {target} is no page of the book, where links to .md become links to pages"));
        }
    }
    broken
}

#[test]
fn every_link_leads_somewhere() {
    let mut pages = markdown_below(BOOK);
    let root = std::fs::read_dir(repository()).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    pages.extend(root.filter(|name| Path::new(name).extension().is_some_and(|e| e == "md")));
    let (mut found, mut links) = (Vec::new(), 0);
    for page in &pages {
        let text = whole(page);
        links += targets(&text).len();
        found.extend(broken(page, &text));
    }
    assert!(pages.len() > 30 && links > 100, "{} pages, {links} links", pages.len());
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn a_link_that_leads_nowhere_is_seen() {
    let page = format!("{BOOK}/guide/scene.md");
    let of = |text: &str| broken(&page, text).len();
    assert_eq!(of("[x](../glossary.md) `[y](gone.md)` [z](https://example.org)\n```text\n[q](gone.md)\n```"), 0);
    assert_eq!(of("[x](gone.md)"), 1);
    assert_eq!(of("[x](../glossary.md#glossary) [y](../glossary.md#no-such-heading)"), 1);
    assert_eq!(of("[x](../../../../README.md)"), 1);
    assert_eq!(of("![x](../../../pictures/gone.png) ![y](../../../pictures/section.png)"), 1);
}

#[test]
fn every_page_is_in_the_table_of_contents_once() {
    let listed = targets(&read(&format!("{BOOK}/SUMMARY.md")));
    let mut listed: Vec<String> = listed.iter().map(|page| format!("{BOOK}/{page}")).collect();
    listed.push(format!("{BOOK}/SUMMARY.md"));
    listed.sort();
    assert_eq!(listed, markdown_below(BOOK));
}

#[test]
fn every_guide_of_the_firmware_is_a_page() {
    let pages = markdown_below(BOOK);
    let shown: Vec<String> =
        pages.iter().flat_map(|page| read(page).lines().filter_map(|line| included(page, line)).collect::<Vec<_>>()).collect();
    for guide in markdown_below("firmware") {
        // in the book, a folder's README is named after the folder
        let path = Path::new(&guide);
        let named = if guide.ends_with("README.md") { path.parent().unwrap().with_extension("md") } else { path.to_owned() };
        let name = named.file_name().unwrap().to_str().unwrap();
        assert!(
            shown.contains(&guide),
            "{guide} is on no page of the book: make {BOOK}/{name} the one line {{{{#include ../../../{guide}}}}}, and name it in SUMMARY.md under Hardware"
        );
    }
}

#[test]
fn the_readme_is_one_screen_and_shows_a_picture() {
    let text = read("README.md");
    assert!(text.lines().count() <= MOST_LINES, "{} lines", text.lines().count());
    assert!(text.contains("!["));
}

#[test]
fn no_paragraph_is_a_wall() {
    let mut walls = Vec::new();
    for (page, text) in own_pages() {
        let mut words = 0;
        for line in prose(&text) {
            let item = line.trim_start().split_once(". ").is_some_and(|(n, _)| n.parse::<u8>().is_ok());
            let begins = item || line.trim().is_empty() || line.trim_start().starts_with(['#', '|', '*']);
            words = if begins { 0 } else { words } + if line.starts_with('|') { 0 } else { line.split_whitespace().count() };
            if words > MOST_WORDS {
                walls.push(format!("{page}: more than {MOST_WORDS} words at: {line}"));
                words = 0;
            }
        }
    }
    assert!(walls.is_empty(), "{}", walls.join("\n"));
}

/// Every fault number has a paragraph whose heading gives its number and its message.
#[test]
fn every_fault_is_explained() {
    let text = read(&format!("{BOOK}/troubleshooting.md"));
    let headings: Vec<&str> = text.lines().filter(|line| line.starts_with("### Fault ")).collect();
    assert!(headings.len() >= palpate::Fault::ALL.len());
    for fault in palpate::Fault::ALL {
        let number = format!("### Fault {}: ", fault as u8);
        let heading = headings.iter().find(|line| line.starts_with(&number)).unwrap_or_else(|| panic!("{number}"));
        let words = fault.text().split(':').next().unwrap_or_default();
        assert!(heading.ends_with(words), "{heading} is not: {words}");
    }
}
