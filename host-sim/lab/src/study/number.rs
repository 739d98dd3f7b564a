//! Serialized form of a number that need not be finite, which JSON does not have: text if it is
//! not.

use serde::de::Error;
use serde::{Deserialize, Deserializer, Serializer};
use serde_json::Value;

/// Writes a number.
pub fn serialize<S: Serializer>(number: &f64, to: S) -> Result<S::Ok, S::Error> {
    if number.is_finite() { to.serialize_f64(*number) } else { to.collect_str(number) }
}

/// Reads what [`serialize`] wrote.
pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<f64, D::Error> {
    let number = match Value::deserialize(from)? {
        Value::String(text) => text.parse().ok(),
        value => value.as_f64(),
    };
    number.ok_or_else(|| D::Error::custom("no number"))
}

#[cfg(test)]
mod tests {
    #[derive(serde::Serialize, serde::Deserialize)]
    struct Row(#[serde(with = "super")] f64);

    #[test]
    fn every_number_is_read_as_it_was() {
        for number in [0.0, -0.0, 1.0, 0.1 + 0.2, 1e300, f64::MIN_POSITIVE, f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            let Row(again) = serde_json::from_value(serde_json::to_value(Row(number)).unwrap()).unwrap();
            assert_eq!(format!("{number:?}"), format!("{again:?}"));
        }
    }
}
