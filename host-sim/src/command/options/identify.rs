//! Command line of `palpate identify`.

use std::path::PathBuf;

use clap::Args;
use palpate_tissue::Error as TissueError;

use crate::command::length::metres;
use crate::error::Error;

#[derive(Args, Clone, Debug)]
pub struct IdentifyArgs {
    /// A table of a test (CSV with a row of names such as `time_s`, `depth_mm`, `force_mN`), or a
    /// folder of them.
    #[arg(value_name = "FILE|FOLDER")]
    pub data: PathBuf,
    /// Tip of the indenter: sphere:RADIUS, such as sphere:4mm.
    #[arg(long, value_name = "SHAPE:RADIUS", value_parser = tip)]
    pub tip: f64,
    /// Thickness of the tissue on its support, such as 10mm; or a range such as 5..20mm, in which
    /// it is fitted.
    #[arg(long, value_name = "LENGTH", value_parser = thickness, allow_hyphen_values = true)]
    pub thickness: [f64; 2],
    /// Sides of the tissue, such as 50x50mm [default: wide enough not to matter].
    #[arg(long, value_name = "SIDExSIDE", value_parser = sides)]
    pub block: Option<[f64; 2]>,
    /// Poisson's ratio.
    #[arg(long, value_name = "RATIO", default_value_t = 0.45)]
    pub nu: f64,
    /// Leave out the last tests, which are then predicted; of a single test, the second half of its
    /// hold. The retreat is never fitted and always predicted.
    #[arg(long, value_name = "COUNT", default_value_t = 0)]
    pub leave_out: usize,
    /// Go on to a law for the board m4f-168, or with friction to a patch, and judge it against the
    /// data.
    #[arg(long)]
    pub fit: bool,
    /// Output folder, created if missing; a finished run replaces an earlier result in it.
    #[arg(long, value_name = "FOLDER")]
    pub out: Option<PathBuf>,
}

fn tip(text: &str) -> Result<f64, String> {
    let radius = text.strip_prefix("sphere:").or_else(|| text.strip_prefix("hemisphere:"));
    metres(radius.ok_or_else(|| format!("\"{text}\" is no tip: give sphere:RADIUS, such as sphere:4mm"))?)
}

/// Ends of a range [m]; equal for a length.
fn thickness(text: &str) -> Result<[f64; 2], String> {
    let Some((low, high)) = text.split_once("..") else { return Ok([metres(text)?; 2]) };
    let unit = high.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.');
    // an end without a unit has that of the other
    let low = if low.ends_with(|c: char| c.is_ascii_digit()) { metres(&format!("{low}{unit}")) } else { metres(low) };
    Ok([low?, metres(high)?])
}

fn sides(text: &str) -> Result<[f64; 2], String> {
    let why = || format!("\"{text}\" are no two sides: give them like 50x50mm");
    let (x, y) = text.split_once('x').ok_or_else(why)?;
    let unit = y.trim_start_matches(|c: char| c.is_ascii_digit() || c == '.');
    let of = |side: &str| metres(side).or_else(|_| metres(&format!("{side}{unit}"))).map_err(|_| why());
    // a side without a unit has that of the other
    let first = if x.ends_with(|c: char| c.is_ascii_digit()) { metres(&format!("{x}{unit}")) } else { metres(x) };
    Ok([first.map_err(|_| why())?, of(y)?])
}

impl IdentifyArgs {
    /// Checks the numbers.
    pub fn check(&self) -> Result<(), Error> {
        let refuse = |why: String| Err(TissueError::Usage(why).into());
        let [low, high] = self.thickness;
        for (option, length_m) in [("--tip", self.tip), ("--thickness", low), ("--thickness", high)] {
            if !(1e-4..=0.5).contains(&length_m) {
                return refuse(format!("{option} {length_m} m: give 0.1 mm to 500 mm, with the unit, such as 4mm"));
            }
        }
        if low > high {
            return refuse("--thickness: the range ends before it begins: give it like 5..20mm".into());
        }
        if let Some(side_m) = self.block.into_iter().flatten().find(|side_m| !(2.0 * self.tip..=1.0).contains(side_m)) {
            return refuse(format!("--block: a side of {side_m} m: give at least the width of the tip, at most 1 m"));
        }
        if !(0.25..=0.49).contains(&self.nu) {
            return refuse(format!("--nu {}: give 0.25 to 0.49, which the finite elements compute exactly", self.nu));
        }
        Ok(())
    }
}
