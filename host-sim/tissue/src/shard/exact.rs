//! Forms in a shard's file for values that JSON does not have: numbers that are not finite, and
//! types of the core.

use palpate::{ClampFlags, Fault};
use serde::de::Error;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Writes a number as text, whether it is finite or not: the shortest text that reads back as the
/// same bits.
///
/// # Errors
/// Errors of the serializer.
pub fn serialize<S: Serializer>(number: &f64, to: S) -> Result<S::Ok, S::Error> {
    to.collect_str(&format_args!("{number:e}"))
}

/// Reads what [`serialize`] wrote. There is no untagged choice between number and text: if a crate
/// of the build enables arbitrary precision in `serde_json`, such a choice cannot read numbers.
///
/// # Errors
/// The text is no number.
pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    String::deserialize(from)?.parse().map_err(D::Error::custom)
}

/// Reads a plainly written number; null, JSON's form of a number that is not finite, is read as
/// NaN.
///
/// # Errors
/// The value is neither a number nor null.
pub fn or_null<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(from)?.unwrap_or(f64::NAN))
}

/// Flags of clamped quantities, as one byte.
pub mod clamp_flags {
    use super::{ClampFlags, Deserialize, Deserializer, Serializer};

    const EACH: [ClampFlags; 8] = [
        ClampFlags::SPEED,
        ClampFlags::DEPTH,
        ClampFlags::FORCE,
        ClampFlags::BURIED,
        ClampFlags::SLEW,
        ClampFlags::HELD,
        ClampFlags::GAIN,
        ClampFlags::ENERGY,
    ];

    /// Writes the flags as a byte.
    ///
    /// # Errors
    /// Errors of the serializer.
    pub fn serialize<S: Serializer>(flags: &ClampFlags, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_u8(flags.bits())
    }

    /// Reads the flags from a byte.
    ///
    /// # Errors
    /// The value is not a byte.
    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<ClampFlags, D::Error> {
        let bits = u8::deserialize(from)?;
        let mut flags = ClampFlags::DEFAULT;
        EACH.into_iter().filter(|flag| bits & flag.bits() != 0).for_each(|flag| flags.set(flag));
        Ok(flags)
    }
}

/// A result whose error is a fault of the core, as the fault's number.
pub mod fault {
    use super::{Deserialize, Deserializer, Error, Fault, Serialize, Serializer};

    /// Writes a result, with the number of a fault in place of the fault.
    ///
    /// # Errors
    /// Errors of the serializer.
    pub fn serialize<S: Serializer, T: Serialize>(result: &Option<Result<T, Fault>>, to: S) -> Result<S::Ok, S::Error> {
        result.as_ref().map(|result| result.as_ref().map_err(|fault| *fault as u8)).serialize(to)
    }

    /// Reads what [`serialize`] wrote.
    ///
    /// # Errors
    /// No fault has the number.
    pub fn deserialize<'de, D, T>(from: D) -> Result<Option<Result<T, Fault>>, D::Error>
    where
        D: Deserializer<'de>,
        T: Deserialize<'de>,
    {
        let named = |number: u8| {
            let fault = Fault::ALL.into_iter().find(|fault| *fault as u8 == number);
            fault.ok_or_else(|| D::Error::custom(format!("no fault has the number {number}")))
        };
        match Option::<Result<T, u8>>::deserialize(from)? {
            None => Ok(None),
            Some(Ok(value)) => Ok(Some(Ok(value))),
            Some(Err(number)) => Ok(Some(Err(named(number)?))),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, Serialize, Deserialize)]
    struct Row(#[serde(with = "super")] f64, #[serde(with = "super::clamp_flags")] ClampFlags);

    #[test]
    fn every_number_and_flag_is_read_as_it_was() {
        for number in [0.0, -0.0, 1.0, 0.1 + 0.2, 1e300, f64::MIN_POSITIVE, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let mut flags = ClampFlags::DEPTH;
            flags.set(ClampFlags::ENERGY);
            let row = Row(number, flags);
            let again: Row = serde_json::from_str(&serde_json::to_string(&row).unwrap()).unwrap();
            assert_eq!(format!("{row:?}"), format!("{again:?}"));
        }
    }
}
