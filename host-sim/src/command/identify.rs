//! `palpate identify`: from measured forces to a scene, with what the data cannot say.

mod patch;
mod report;
mod scene;

use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use palpate_fit::identify::fit::Estimate;
use palpate_fit::identify::record::{Record, Table, known};
use palpate_fit::identify::slide::Slide;
use palpate_fit::identify::study::{Identified, Plan, identify, identify_within};
use palpate_fit::scene_fit::PIECE_RADII;
use palpate_tissue::Error as TissueError;
use palpate_tissue::output::OutputFolder;

use self::patch::Beside;
use super::options::identify::IdentifyArgs;
use super::progress::told;
use super::stop;
use super::verdict::Verdict;
use crate::error::Error;
use crate::provenance;

/// Tolerance of a fit [%]: as near as a modulus has to be known to be told. The finite elements of
/// a thin slab are themselves known to 2 to 4 % only.
const TOLERANCE_PCT: f64 = 5.0;
/// Largest radius of a piece over the thickness of the tissue (1).
const MOST_PIECE: f64 = 0.6;
/// Smallest radius of a piece over that of the ball (1).
const LEAST_PIECE: f64 = 1.25;
/// Change of a scene with friction for a law.
const NO_FRICTION: &str = "probe.friction=0";

/// All tests of a file or of the files of a folder.
#[derive(Default)]
struct Tests {
    records: Vec<Record>,
    slides: Vec<Slide>,
    notes: Vec<String>,
}

fn of_utf16(bytes: &[u8], unit: fn([u8; 2]) -> u16) -> String {
    let units = bytes.chunks_exact(2).map(|pair| unit([pair[0], pair[1]]));
    char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect()
}

fn read(path: &Path, thickness_m: f64, ball_m: f64) -> Result<Tests, Error> {
    let unreadable = |path: &Path, source| TissueError::Read { path: path.into(), source };
    let mut files = vec![path.to_owned()];
    if path.is_dir() {
        let entries = std::fs::read_dir(path).map_err(|source| unreadable(path, source))?;
        let is_table = |ending: &OsStr| ["csv", "tsv", "txt"].iter().any(|known| ending.eq_ignore_ascii_case(known));
        let table = |path: &PathBuf| path.extension().is_some_and(is_table);
        files = entries.flatten().map(|entry| entry.path()).filter(table).collect();
        files.sort();
        if files.is_empty() {
            return Err(TissueError::Usage(format!(
                "{}: no file ending in .csv, .tsv or .txt: give a folder of tests",
                path.display()
            ))
            .into());
        }
    }
    let mut tests = Tests::default();
    for file in files {
        let bytes = std::fs::read(&file).map_err(|source| unreadable(&file, source))?;
        // files of older programs are in Latin-1, in which a byte is a character
        let text = match &bytes[..] {
            // "Unicode text" of spreadsheets is UTF-16
            [0xff, 0xfe, wide @ ..] => of_utf16(wide, u16::from_le_bytes),
            [0xfe, 0xff, wide @ ..] => of_utf16(wide, u16::from_be_bytes),
            _ => String::from_utf8(bytes).unwrap_or_else(|error| error.into_bytes().into_iter().map(char::from).collect()),
        };
        if path.is_dir() && !Table::is_in(&text) {
            tests.notes.push(format!("{}: left out, as no line names time, depth and force", file.display()));
            continue;
        }
        let table = Table::read(&file.display().to_string(), &text).map_err(TissueError::Usage)?;
        tests.notes.extend(table.notes);
        for ((name, rows), along) in table.tests.into_iter().zip(table.along) {
            let record = Record::of(&name, &rows, thickness_m).map_err(TissueError::Usage)?;
            let contact_radius_m = (ball_m * record.span_m()).sqrt().min(ball_m);
            if !along.is_empty() {
                let rows: Vec<[f64; 3]> = rows.iter().map(|[t, d, f]| [*t, *d, f - record.zero_n]).collect();
                tests.slides.extend(Slide::of(&name, &rows, &along, contact_radius_m).map_err(TissueError::Usage)?);
            }
            tests.notes.extend_from_slice(&record.notes);
            tests.records.push(record);
        }
    }
    if tests.records.is_empty() {
        return Err(TissueError::Usage(format!(
            "{}: no file has a line that names time, depth and force: known are {}",
            path.display(),
            known()
        ))
        .into());
    }
    Ok(tests)
}

impl IdentifyArgs {
    /// Sides of the tissue, the thickness last and at most [m].
    fn block_m(&self) -> [f64; 3] {
        let most_m = self.thickness[1];
        let [x, y] = self.block.unwrap_or([4.0 * most_m + 8.0 * self.tip; 2]);
        [x, y, most_m]
    }

    /// Options of `fit` for a model that feels like the tissue on a board: a law, which leaves
    /// friction out, or a piece, which ends above the support.
    fn fit_options(&self, found: &Identified, law: bool) -> Vec<String> {
        let mut options = vec!["--board".to_owned(), patch::BOARD.to_owned()];
        options.extend(["--tolerance-pct".to_owned(), format!("{TOLERANCE_PCT}")]);
        let most_m = MOST_PIECE * found.block_m[2];
        if law {
            options.push("--law".into());
            if found.friction().is_some() {
                options.extend(["--set", NO_FRICTION].map(String::from));
            }
        } else if PIECE_RADII * self.tip > most_m {
            options.extend(["--radius".into(), format!("{:.2}mm", most_m * 1e3)]);
        }
        options
    }

    /// A law contains the stiffening, but has no friction; a thin slab has no room for a piece.
    fn takes_a_law(&self, found: &Identified) -> bool {
        found.friction().is_none() || LEAST_PIECE * self.tip > MOST_PIECE * found.block_m[2]
    }

    pub(super) fn run(&self) -> Result<(), Error> {
        let Tests { records, slides, notes } = read(&self.data, self.thickness[1], self.tip)?;
        // one test is fitted at least; a single test is divided
        let most = records.len().saturating_sub(1).max(1);
        if self.leave_out > most {
            let tests = records.len();
            let s = if tests == 1 { "" } else { "s" };
            return Err(TissueError::Usage(format!(
                "--leave-out {}: {tests} test{s} given: give at most {most}",
                self.leave_out
            ))
            .into());
        }
        let plan = Plan { ball_m: self.tip, block_m: self.block_m(), poisson_ratio: self.nu, leave_out: self.leave_out };
        let [low_m, high_m] = self.thickness;
        let solve = || match low_m < high_m {
            true => identify_within(&plan, self.thickness, &records),
            false => identify(&plan, &records),
        };
        let mut found = told("solving finite elements of the test", solve).map_err(TissueError::Usage)?;
        found.slides = slides;
        found.say_friction(self.nu);
        let folder = self.out.clone().unwrap_or_else(|| "out/identify".into());
        stop::says_what_stays(&folder);
        let out = self.write(&folder, &found, &records, (&[], ""))?;
        let odd = records.iter().find_map(Record::odd_speed);
        let doubtful = odd.is_some() || found.trusts_zero || found.misfits || !found.estimates.iter().all(Estimate::told);
        let headline = odd.map_or_else(String::new, |odd| odd + "; ") + &report::headline(&found);
        let verdict = Verdict::ok(headline.clone()).warning_if(doubtful).first();
        report::print(self, &found, &records, &notes);
        println!("\nwrote {}: summary.json, identified.toml, fit.csv, identified.svg and .png", out.display());
        let law = self.takes_a_law(&found);
        let options = self.fit_options(&found, law);
        if options.iter().any(|option| option == NO_FRICTION) {
            println!("note: a slab this thin has no room for a patch, and a law leaves the friction out");
        }
        if !self.fit {
            let line = |law: bool| {
                let scene = out.join(scene::name(&found, law));
                format!("palpate fit --scene {} {}", scene.display(), self.fit_options(&found, law).join(" "))
            };
            println!("next: {}", line(law));
            if !law {
                println!("or, where a patch's elements are too wide for this tip, without friction: {}", line(true));
            }
            return verdict.last();
        }
        let scene = out.join(scene::name(&found, law));
        let name = patch::name(&options);
        let (beside, unpromised) = patch::fit_and_judge(&scene, &options, &out.join("board"), &found, &records)?;
        stop::says_what_stays(&folder);
        self.write(&folder, &found, &records, (&beside, &name))?;
        println!("\nwrote the force of the {name} into {}: summary.json, identified.svg and .png", out.display());
        match (unpromised, patch::far_off(&beside, &records, &name, TOLERANCE_PCT)) {
            (Some(why), _) => {
                Verdict::of(Err::<(), _>(TissueError::Check(format!("{headline}; the patch: {why}"))), String::new)?.last()
            }
            (None, Some(far)) => Verdict::ok(format!("{headline}; {far}")).warning_if(true).last(),
            (None, None) => verdict.last(),
        }
    }

    /// Writes the result into a folder, with the force of a patch and its name if there is one; an
    /// earlier result is replaced. Returns the folder's path.
    fn write(
        &self,
        folder: &Path,
        found: &Identified,
        records: &[Record],
        (beside, name): (&[Beside], &str),
    ) -> Result<PathBuf, Error> {
        let folder = OutputFolder::open(folder)?.made_by(provenance::of(None));
        for (name, text) in scene::texts(self, found, records) {
            folder.write(name, text.as_bytes())?;
        }
        let rows = found.tests.iter().enumerate().flat_map(|(n, test)| {
            let record = &records[n];
            let depth_m = record.delayed_m(found.delay_s, test.contact_m);
            (0..record.time_s.len()).map(move |k| [n as f64, record.time_s[k], depth_m[k], record.force_n[k], test.model_n[k]])
        });
        folder.write_csv("fit.csv", ["test", "time_s", "depth_m", "force_n", "model_n"], rows)?;
        report::figure(found, records, (beside, name)).draw(folder.draft())?;
        folder.write_summary(&report::summary(found, records, beside))?;
        Ok(folder.publish()?)
    }
}
