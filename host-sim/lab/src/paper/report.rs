//! A report: Markdown with tables and pictures, and the verdict on each printed claim.

use std::fmt::{Display, Write};
use std::path::Path;

/// Text in the making.
#[derive(Clone, Debug, Default)]
pub struct Report {
    text: String,
    claims: Vec<Claim>,
}

/// A claim of a paper, and the finding.
#[derive(Clone, Debug, serde::Serialize)]
pub struct Claim {
    /// Statement of the paper, with its place.
    pub printed: String,
    /// Result found here.
    pub found: String,
    /// Whether the claim held; `None` if it cannot be tested.
    pub held: Option<bool>,
}

impl Report {
    /// A report with a title.
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

    /// Adds a table; the first column is text, the rest numbers.
    pub fn table<R: AsRef<[String]>>(&mut self, header: &[&str], rows: impl IntoIterator<Item = R>) {
        let rule = header.iter().enumerate().map(|(n, _)| if n == 0 { "---" } else { "---:" }).collect::<Vec<_>>();
        let _ = write!(self.text, "\n| {} |\n| {} |\n", header.join(" | "), rule.join(" | "));
        for row in rows {
            let _ = writeln!(self.text, "| {} |", row.as_ref().join(" | "));
        }
    }

    /// Shows a picture that lies beside the report as `NAME.png`.
    pub fn picture(&mut self, name: &str, caption: &str) {
        let _ = write!(self.text, "\n![{caption}]({name}.png)\n");
    }

    /// Records a claim of the paper and the finding.
    pub fn claim(&mut self, printed: impl Into<String>, found: impl Into<String>, held: Option<bool>) {
        self.claims.push(Claim { printed: printed.into(), found: found.into(), held });
    }

    /// The claims so far.
    #[must_use]
    pub fn claims(&self) -> &[Claim] {
        &self.claims
    }

    /// The text, claims last.
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

/// The outcome in one line: the product's own promise, and the paper's claims.
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

/// Prints which claims held, and the path of the report.
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
