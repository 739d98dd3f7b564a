//! A report in Markdown with tables, pictures, and a verdict on each claim of the paper.

use std::fmt::{Display, Write};
use std::path::Path;

/// A report that is being written.
#[derive(Clone, Debug, Default)]
pub struct Report {
    text: String,
    claims: Vec<Claim>,
}

/// A claim of a paper, and the result found here.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Claim {
    /// Statement of the paper, with its place in the text.
    pub printed: String,
    /// Result found here.
    pub found: String,
    /// Whether the result confirms the claim; `None` if it cannot be tested.
    pub held: Option<bool>,
}

impl Report {
    /// An empty report with a title.
    #[must_use]
    pub fn new(title: &str) -> Self {
        Self { text: format!("# {title}\n"), claims: Vec::new() }
    }

    /// Starts a section.
    pub fn section(&mut self, title: &str) {
        let _ = write!(self.text, "\n## {title}\n");
    }

    /// Adds a paragraph.
    pub fn say(&mut self, paragraph: impl Display) {
        let _ = write!(self.text, "\n{paragraph}\n");
    }

    /// Adds a table; the first column is left-aligned, the others are right-aligned.
    pub fn table<R: AsRef<[String]>>(&mut self, header: &[&str], rows: impl IntoIterator<Item = R>) {
        let rule = header.iter().enumerate().map(|(n, _)| if n == 0 { "---" } else { "---:" }).collect::<Vec<_>>();
        let _ = write!(self.text, "\n| {} |\n| {} |\n", header.join(" | "), rule.join(" | "));
        for row in rows {
            let _ = writeln!(self.text, "| {} |", row.as_ref().join(" | "));
        }
    }

    /// Shows the picture `NAME.png` from the folder of the report.
    pub fn picture(&mut self, name: &str, caption: &str) {
        let _ = write!(self.text, "\n![{caption}]({name}.png)\n");
    }

    /// Records a claim of the paper and the result found here.
    pub fn claim(&mut self, printed: impl Into<String>, found: impl Into<String>, held: Option<bool>) {
        self.claims.push(Claim { printed: printed.into(), found: found.into(), held });
    }

    /// The claims so far.
    #[must_use]
    pub fn claims(&self) -> &[Claim] {
        &self.claims
    }

    /// The complete text, with the table of claims at the end.
    #[must_use]
    pub fn finish(mut self) -> String {
        if !self.claims.is_empty() {
            self.section("Which printed claims held here");
            let verdict = |held: Option<bool>| match held {
                Some(true) => "held",
                Some(false) => "did not hold",
                None => "cannot be tried",
            };
            let rows: Vec<[String; 3]> =
                self.claims.iter().map(|c| [c.printed.clone(), c.found.clone(), verdict(c.held).into()]).collect();
            self.table(&["the paper says", "here", "verdict"], rows);
        }
        self.text
    }
}

/// The outcome in one line: broken promises of the product if there are any, otherwise the number
/// of claims of the paper that held.
#[must_use]
pub fn verdict(claims: &[Claim], broken: &[String]) -> String {
    if !broken.is_empty() {
        return format!("failed: {}", broken.join("; "));
    }
    let count = |held: Option<bool>| claims.iter().filter(|claim| claim.held == held).count();
    format!(
        "ok: of {} claims of the paper {} held here, {} did not (no failure of palpate), {} cannot be tried",
        claims.len(),
        count(Some(true)),
        count(Some(false)),
        count(None)
    )
}

/// Prints the verdict on each claim, and the path of the report.
pub fn print_claims(claims: &[Claim], out: &Path) {
    println!(
        "\nclaims of the paper, with its equations as printed; one that does not hold is a finding about them, and no failure here:"
    );
    for claim in claims {
        let verdict = claim.held.map_or("cannot be tried", |held| if held { "held" } else { "did not hold" });
        println!("{verdict:>15}: {} - here: {}", claim.printed, claim.found);
    }
    println!("\nwrote {}: report.md, summary.json, tables as CSV, pictures as SVG and PNG", out.display());
}
