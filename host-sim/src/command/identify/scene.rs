//! Scene files of an identified tissue, with the interval and source of every value.

use std::fmt::Write;

use palpate_fit::identify::fit::Quantity;
use palpate_fit::identify::model::Tissue;
use palpate_fit::identify::record::Record;
use palpate_fit::identify::study::Identified;

use crate::command::options::identify::IdentifyArgs;

/// Scene of the tissue, and scene without stiffening for patches on boards.
const NAMES: [&str; 2] = ["identified.toml", "identified-plain.toml"];

/// Name of the scene that `fit` takes, for a law or a patch.
pub(super) fn name(found: &Identified, law: bool) -> &'static str {
    NAMES[usize::from(found.stiffens && !law)]
}

/// Names and texts of the scene files.
pub(super) fn texts(args: &IdentifyArgs, found: &Identified, records: &[Record]) -> Vec<(&'static str, String)> {
    let plain = (NAMES[1], text(args, found, records, &found.plain.0, "identified-plain", false));
    match found.stiffens {
        true => vec![(NAMES[0], text(args, found, records, &found.tissue, "identified", true)), plain],
        false => vec![(NAMES[0], text(args, found, records, &found.plain.0, "identified", false))],
    }
}

/// A number with four digits.
fn digits(value: f64) -> String {
    let shown: f64 = format!("{value:.3e}").parse().unwrap_or(value);
    format!("{shown:?}")
}

fn text(args: &IdentifyArgs, found: &Identified, records: &[Record], tissue: &Tissue, name: &str, stiffening: bool) -> String {
    let between = |of: Quantity, per: f64, unit: &str| {
        found.of(of).map_or_else(String::new, |e| {
            format!("90 % interval {} to {} {unit}", digits(e.interval[0] * per), digits(e.interval[1] * per))
        })
    };
    let [x, y, z] = found.block_m;
    let thickness = if found.thickness_m[0] < found.thickness_m[1] { "fitted" } else { "given" };
    let span_m = found.tests.iter().map(|test| test.depth_m).fold(0.0, f64::max);
    // `fit` presses no deeper than half the thickness
    let deepest_m = span_m.min(0.495 * z);
    let mut text = format!("# Identified by `palpate identify` from {}.\n", args.data.display());
    let rms_pct = if stiffening { found.rms_pct } else { found.plain.1 };
    let _infallible = writeln!(text, "# The forces of this tissue are {rms_pct:.2} % rms of the peak off the data.");
    if !stiffening && found.stiffens {
        text += "# It is the best tissue without stiffening, which patches on boards do not have.\n";
    }
    for unsaid in &found.unsaid {
        let _infallible = writeln!(text, "# Not known: {unsaid}.");
    }
    let modulus =
        if stiffening || !found.stiffens { between(Quantity::Modulus, 1.0, "Pa") } else { "best without stiffening".into() };
    let _infallible = write!(
        text,
        "name = \"{name}\"\n[tissue]\nblock_m = [{}, {}, {}]{}\nyoungs_modulus_pa = {}  # instantaneous; {modulus}\n\
         poisson_ratio = {:?}  # given, not identified\ndensity_kg_per_m3 = 1060.0  # assumed\n",
        digits(x),
        digits(y),
        digits(z),
        format_args!("  # thickness {thickness}, sides {}", if args.block.is_some() { "given" } else { "assumed to be wide" }),
        digits(tissue.youngs_modulus_pa),
        args.nu,
    );
    if stiffening {
        let _infallible =
            writeln!(text, "stiffening_b = {}  # {}", digits(tissue.stiffening_b), between(Quantity::Exponent, 1.0, "(1)"));
    }
    for (k, (share, time_s)) in tissue.terms.iter().enumerate() {
        let same = tissue.terms.len() == found.tissue.terms.len();
        let of = |of: Quantity, unit: &str| if same { format!("  # {}", between(of, 1.0, unit)) } else { String::new() };
        let _infallible = write!(
            text,
            "[[tissue.relaxation]]\nshare = {}{}\ntime_s = {}{}\n",
            digits(*share),
            of(Quantity::Share(k), "(1)"),
            digits(*time_s),
            of(Quantity::Time(k), "s")
        );
    }
    let speed = records.iter().map(Record::speed_m_per_s).fold(f64::MAX, f64::min);
    let hold_s = records.iter().map(Record::hold_s).fold(0.0, f64::max).clamp(0.3, 10.0);
    let friction = found.friction().map_or_else(String::new, |[value, low, high]| {
        format!("friction = {}  # 90 % interval {} to {} (1)\n", digits(value), digits(low), digits(high))
    });
    let _infallible = write!(
        text,
        "[probe]\nshape = \"hemisphere\"\nradius_m = {}  # given\nposition_m = [0.0, 0.0]\n{friction}[drive]  # as in the test\nkind = \"depth\"\n\
         holds_m = [{}]\nramp_m_per_s = {}\nhold_s = {}\n",
        digits(args.tip),
        digits(deepest_m),
        digits(speed.clamp(1e-5, 1.0)),
        digits(hold_s)
    );
    text
}
