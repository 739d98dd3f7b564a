//! Lengths on the command line: `16mm`, `1.6cm`, `0.016m`, or a number of metres.

use palpate_tissue::scene::LengthUnit;

/// Reads a length [m]. Its range is checked by the command.
pub(super) fn metres(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let number = |text: &str| text.trim().parse::<f64>().ok();
    // the longest name first, since every name ends in m
    let mut units = LengthUnit::NAMED;
    units.sort_by_key(|(name, _)| std::cmp::Reverse(name.len()));
    let with_unit = units.iter().find_map(|(name, metres)| Some(number(text.strip_suffix(name)?)? * metres));
    with_unit
        .or_else(|| number(text))
        .ok_or_else(|| format!("\"{text}\" is no length: give it like 16mm, 1.6cm or 0.016 (metres)"))
}

#[cfg(test)]
mod tests {
    use super::metres;

    #[test]
    fn lengths_have_a_unit_or_are_metres() {
        for (text, expected) in
            [("16mm", 16e-3), ("1.6 cm", 16e-3), ("0.016m", 16e-3), ("0.016", 0.016), ("55um", 55e-6), ("-4mm", -4e-3)]
        {
            assert!((metres(text).unwrap() - expected).abs() < 1e-15, "{text}");
        }
        assert!(metres("nan").unwrap().is_nan());
        for text in ["", "mm", "4 inches", "4mmm", "1,6cm"] {
            assert!(metres(text).unwrap_err().contains("is no length"), "{text}");
        }
    }
}
