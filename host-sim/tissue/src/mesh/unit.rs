//! Unit of length of a file.

use std::str::FromStr;

use serde::Deserialize;

/// Unit of length of a mesh file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LengthUnit {
    /// Metres per unit of the file.
    pub metres: f64,
}

impl LengthUnit {
    /// Units that have a name, with their lengths [m], the most likely unit first.
    pub const NAMED: [(&str, f64); 4] = [("m", 1.0), ("mm", 1e-3), ("cm", 1e-2), ("um", 1e-6)];

    /// Makes a unit from its length in metres.
    ///
    /// # Errors
    /// The length is zero, negative or not finite.
    pub fn of_metres(metres: f64) -> Result<Self, String> {
        if metres.is_finite() && metres > 0.0 {
            Ok(Self { metres })
        } else {
            Err(format!("{metres} m must be above zero and finite"))
        }
    }
}

impl FromStr for LengthUnit {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if let Some((_, metres)) = Self::NAMED.iter().find(|(name, _)| *name == text) {
            return Ok(Self { metres: *metres });
        }
        let metres =
            text.parse().map_err(|_| format!("\"{text}\" is not \"m\", \"cm\", \"mm\", \"um\" or a number of metres"))?;
        Self::of_metres(metres)
    }
}

impl<'de> Deserialize<'de> for LengthUnit {
    fn deserialize<D: serde::Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged, expecting = "not \"m\", \"cm\", \"mm\", \"um\" or a number of metres")]
        enum Raw {
            Name(String),
            Metres(f64),
            Whole(i64),
        }
        let unit = match Raw::deserialize(deserializer)? {
            Raw::Name(name) => name.parse(),
            Raw::Metres(metres) => Self::of_metres(metres),
            Raw::Whole(metres) => Self::of_metres(metres as f64),
        };
        unit.map_err(serde::de::Error::custom)
    }
}
