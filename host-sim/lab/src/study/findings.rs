//! Tables, claims and figures of a study: written, printed and judged.

use palpate_charts::{Figure, Form};
use palpate_sim::command::verdict::Verdict;
use palpate_sim::error::Error;
use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;
use serde::Serialize;
use serde_json::{Map, Value};

use super::Table;
use super::table::short;

/// Largest number of claims that are spelled out in the verdict.
const SPELLED: usize = 3;

/// A claim and what was found.
#[derive(Clone, Debug, Serialize)]
pub struct Claim {
    /// Name of the quantity, or statement of a paper.
    pub name: String,
    /// Bound of the quantity.
    pub bound: String,
    /// Value found.
    pub found: String,
    /// Whether the finding agrees with the claim; `None` if it cannot be tried.
    pub holds: Option<bool>,
    /// Whether the claim is a promise of the product, whose study fails without it, rather than a
    /// statement of a paper.
    pub promised: bool,
}

impl Claim {
    /// A promise of the product.
    pub fn promise(name: impl Into<String>, bound: impl Into<String>, found: impl Into<String>, holds: bool) -> Self {
        Self { name: name.into(), bound: bound.into(), found: found.into(), holds: Some(holds), promised: true }
    }

    /// A statement of a paper.
    pub fn printed(printed: impl Into<String>, found: impl Into<String>, holds: Option<bool>) -> Self {
        Self { name: printed.into(), bound: "as printed".into(), found: found.into(), holds, promised: false }
    }

    /// Verdict on the claim, in words.
    pub fn verdict(&self) -> &'static str {
        match self.holds {
            Some(true) => "holds",
            Some(false) => "does not hold",
            None => "cannot be tried",
        }
    }
}

/// Everything that a study writes and prints.
#[derive(Debug, Default)]
pub struct Findings {
    /// The result in one sentence, besides the claims; may be empty.
    pub headline: String,
    /// Numbers of `summary.json` that are in no table.
    pub facts: Map<String, Value>,
    /// Tables, in the order in which they are printed.
    pub tables: Vec<Table>,
    /// Claims, of which the first that does not hold is named in the verdict.
    pub claims: Vec<Claim>,
    /// Pictures.
    pub figures: Vec<Figure>,
    /// Pictures whose points are written as CSV as well.
    pub plotted: Vec<Figure>,
    /// Names and titles of pictures that are in the folder already.
    pub drawn: Vec<(String, String)>,
    /// Lines after the tables: what their columns mean, and single findings.
    pub notes: Vec<String>,
}

/// Contents of `summary.json`.
#[derive(Serialize)]
struct Summary<'a> {
    #[serde(flatten)]
    facts: &'a Map<String, Value>,
    claims: &'a [Claim],
}

impl Findings {
    /// Adds a number or a text to `summary.json`.
    pub fn fact(&mut self, name: &str, value: impl Into<Value>) {
        self.facts.insert(name.to_owned(), value.into());
    }

    /// Writes everything, prints it with the verdict before and after, and returns the verdict.
    /// With `all`, every row is printed.
    pub fn report(&self, folder: OutputFolder, all: bool) -> Result<(), Error> {
        for table in &self.tables {
            folder.write(&format!("{}.csv", table.name), table.csv().as_bytes())?;
        }
        for figure in &self.plotted {
            folder.write(&format!("{}.csv", figure.name), points(figure).as_bytes())?;
        }
        for figure in self.figures.iter().chain(&self.plotted) {
            figure.draw(folder.draft())?;
        }
        folder.write("report.md", self.markdown().as_bytes())?;
        folder.write_summary(&Summary { facts: &self.facts, claims: &self.claims })?;
        let verdict = Verdict::of(self.judge(), || self.in_words())?.first();
        let printed = self.tables.iter().filter(|table| !table.is_quiet()).map(|table| table.print(all));
        printed.filter(|text| !text.is_empty()).for_each(|text| println!("{text}"));
        let told = self.claims.iter().filter(|claim| !claim.promised || claim.holds != Some(true));
        told.for_each(|claim| println!("{}: {} ({})\n  here: {}", claim.verdict(), claim.name, claim.bound, claim.found));
        let facts = self.facts.iter().filter(|(_, value)| value.is_number());
        let facts: Vec<String> = facts.map(|(name, value)| format!("{name} {}", short(&value.to_string()))).collect();
        println!("{}", facts.join(", "));
        self.notes.iter().for_each(|note| println!("{note}"));
        if !all && self.tables.iter().any(Table::is_cut) {
            println!("--all prints every row");
        }
        let pictures = if self.figures.is_empty() && self.plotted.is_empty() { "" } else { ", pictures as SVG and PNG" };
        println!("wrote {}: report.md, summary.json, tables as CSV{pictures}", folder.publish()?.display());
        verdict.last()
    }

    fn judge(&self) -> Result<(), Error> {
        let broken: Vec<&Claim> = self.claims.iter().filter(|claim| claim.promised && claim.holds != Some(true)).collect();
        let [Claim { name, bound, found, .. }, more @ ..] = broken.as_slice() else { return Ok(()) };
        let more = if more.is_empty() { String::new() } else { format!("; {} more claims do not hold", more.len()) };
        Err(TissueError::Check(format!("{name}: {found}, where {bound} is promised{more}")).into())
    }

    /// The result in one line: the headline, how many statements of a paper hold, and the promises
    /// that hold.
    fn in_words(&self) -> String {
        let printed = || self.claims.iter().filter(|claim| !claim.promised);
        let count = |holds: Option<bool>| printed().filter(|claim| claim.holds == holds).count();
        let of_paper = (printed().count() > 0).then(|| {
            format!(
                "of {} statements of the paper {} hold here, {} do not (no failure of palpate), {} cannot be tried",
                printed().count(),
                count(Some(true)),
                count(Some(false)),
                count(None)
            )
        });
        let promises: Vec<&Claim> = self.claims.iter().filter(|claim| claim.promised).collect();
        let said = |claim: &&Claim| format!("{}: {} (promised: {})", claim.name, claim.found, claim.bound);
        let kept = match promises.len() {
            0 => None,
            n if n > SPELLED => Some(format!("all {n} claims hold")),
            _ => Some(promises.iter().map(said).collect::<Vec<_>>().join("; ")),
        };
        let headline = Some(self.headline.clone()).filter(|words| !words.is_empty());
        headline.into_iter().chain(of_paper).chain(kept).collect::<Vec<_>>().join("; ")
    }
    /// The whole report: tables, claims, pictures and notes.
    fn markdown(&self) -> String {
        let mut text = format!("# {}\n", self.in_words());
        for table in self.tables.iter().filter(|table| !table.is_quiet()) {
            text += &format!("\n{}\n\n{}", table.heading(), table.markdown());
        }
        if !self.claims.is_empty() {
            text += "\n| claim | bound | found | verdict |\n|---|---|---|---|\n";
        }
        for claim in &self.claims {
            text += &format!("| {} | {} | {} | {} |\n", claim.name, claim.bound, claim.found, claim.verdict());
        }
        for (name, title) in &self.drawn {
            text += &format!("\n![{title}]({name}.png)\n");
        }
        for figure in self.figures.iter().chain(&self.plotted) {
            text += &format!("\n{}: {}\n\n![{0}]({}.png)\n", figure.title, figure.below, figure.name);
        }
        self.notes.iter().for_each(|note| text += &format!("\n{note}\n"));
        text
    }
}

/// Points of a picture, one per row.
fn points(figure: &Figure) -> String {
    let Form::Plot(plot) = &figure.form else { return String::new() };
    let column = |title: &str| {
        let words = title.replace(|c: char| !c.is_alphanumeric(), " ");
        words.split_whitespace().collect::<Vec<_>>().join("_").to_lowercase()
    };
    let mut text = format!("curve,{},{}\n", column(&plot.x.title), column(&plot.y.title));
    for series in &plot.series {
        for (x, y) in series.dots.iter().map(|dot| dot.at) {
            text += &format!("\"{}\",{x},{y}\n", series.name);
        }
    }
    text
}
