//! TOML whose lists have exactly as many entries as the arrays into which they are read.
//!
//! The `toml` crate fills an array of Rust and drops the rest of the list, so that a fourth entry
//! of a vector passes unseen. Every layer of the parser is wrapped here, because lists occur at any
//! depth; a key that is added later is covered as well.

use std::fmt;

use serde::de::{DeserializeOwned, DeserializeSeed, Deserializer, Error, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::forward_to_deserialize_any;

/// Reads TOML as `toml::from_str` does, but refuses a list that is too long for its array.
///
/// # Errors
/// Errors of `toml::from_str`, and a list that is too long.
pub fn from_toml<T: DeserializeOwned>(text: &str) -> Result<T, toml::de::Error> {
    T::deserialize(Exact(toml::Deserializer::parse(text)?))
}

/// Layer of a parser, with the check on all that is read through it.
struct Exact<T>(T);

impl<'de, D: Deserializer<'de>> Deserializer<'de> for Exact<D> {
    type Error = D::Error;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, D::Error> {
        self.0.deserialize_any(Read { visitor, entries: None })
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, D::Error> {
        self.0.deserialize_option(Read { visitor, entries: None })
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(self, name: &'static str, visitor: V) -> Result<V::Value, D::Error> {
        self.0.deserialize_newtype_struct(name, Read { visitor, entries: None })
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, D::Error> {
        self.0.deserialize_struct(name, fields, Read { visitor, entries: None })
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        name: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, D::Error> {
        self.0.deserialize_enum(name, variants, visitor)
    }

    fn deserialize_tuple<V: Visitor<'de>>(self, len: usize, visitor: V) -> Result<V::Value, D::Error> {
        self.0.deserialize_tuple(len, Read { visitor, entries: Some(len) })
    }

    forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf
        unit unit_struct seq tuple_struct map identifier ignored_any
    }
}

/// Visitor that wraps what it is given; `entries` is the length of its array, if it reads one.
struct Read<V> {
    visitor: V,
    entries: Option<usize>,
}

/// Methods that pass a plain value on.
macro_rules! pass {
    ($($method:ident: $kind:ty,)*) => {
        $(fn $method<E: Error>(self, value: $kind) -> Result<V::Value, E> {
            self.visitor.$method(value)
        })*
    };
}

impl<'de, V: Visitor<'de>> Visitor<'de> for Read<V> {
    type Value = V::Value;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.visitor.expecting(f)
    }

    pass! {
        visit_bool: bool,
        visit_i64: i64,
        visit_i128: i128,
        visit_u64: u64,
        visit_u128: u128,
        visit_f64: f64,
        visit_str: &str,
        visit_borrowed_str: &'de str,
        visit_string: String,
    }

    fn visit_some<D: Deserializer<'de>>(self, value: D) -> Result<V::Value, D::Error> {
        self.visitor.visit_some(Exact(value))
    }

    fn visit_newtype_struct<D: Deserializer<'de>>(self, value: D) -> Result<V::Value, D::Error> {
        self.visitor.visit_newtype_struct(Exact(value))
    }

    fn visit_map<A: MapAccess<'de>>(self, map: A) -> Result<V::Value, A::Error> {
        self.visitor.visit_map(Exact(map))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<V::Value, A::Error> {
        let value = self.visitor.visit_seq(Exact(&mut list))?;
        let Some(entries) = self.entries else { return Ok(value) };
        let mut found = entries;
        while list.next_element::<IgnoredAny>()?.is_some() {
            found += 1;
        }
        // in serde's words for a list that is too short
        let array = format!("an array of length {entries}");
        if found == entries { Ok(value) } else { Err(Error::invalid_length(found, &array.as_str())) }
    }
}

impl<'de, A: SeqAccess<'de>> SeqAccess<'de> for Exact<A> {
    type Error = A::Error;

    fn next_element_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, A::Error> {
        self.0.next_element_seed(Exact(seed))
    }
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for Exact<A> {
    type Error = A::Error;

    fn next_key_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<Option<S::Value>, A::Error> {
        self.0.next_key_seed(seed)
    }

    fn next_value_seed<S: DeserializeSeed<'de>>(&mut self, seed: S) -> Result<S::Value, A::Error> {
        self.0.next_value_seed(Exact(seed))
    }
}

impl<'de, S: DeserializeSeed<'de>> DeserializeSeed<'de> for Exact<S> {
    type Value = S::Value;

    fn deserialize<D: Deserializer<'de>>(self, value: D) -> Result<S::Value, D::Error> {
        self.0.deserialize(Exact(value))
    }
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;

    #[derive(Debug, Deserialize, PartialEq)]
    struct Inner {
        pair: Option<[f64; 2]>,
        rows: Option<Vec<[u8; 2]>>,
    }

    #[derive(Debug, Deserialize, PartialEq)]
    #[serde(rename_all = "lowercase")]
    enum Word {
        One,
    }

    #[derive(Debug, Deserialize, PartialEq)]
    struct Outer {
        word: Option<Word>,
        inner: Vec<Inner>,
        other: Option<toml::Table>,
    }

    #[test]
    fn lists_of_the_right_length_are_read_as_by_toml() {
        let text = "word = \"one\"\nother = { a = [1, [2, 3.5], \"x\"], day = 2026-11-28, yes = true }\n\
            [[inner]]\npair = [1, 2.5]\n[[inner]]\nrows = [[1, 2], [3, 4], [5, 6]]\n";
        assert_eq!(from_toml::<Outer>(text).unwrap(), toml::from_str(text).unwrap());
    }

    #[test]
    fn a_list_that_is_too_long_is_refused_at_any_depth_with_its_place() {
        for (text, at) in [
            ("[[inner]]\npair = [1, 2, 3]", "[1, 2, 3]"),
            ("[[inner]]\npair = [1, 2]\n[[inner]]\nrows = [[1, 2], [3, 4, 5]]", "[3, 4, 5]"),
            ("inner = [{ pair = [1, 2, 3] }]", "[1, 2, 3]"),
        ] {
            let error = from_toml::<Outer>(text).unwrap_err();
            assert_eq!(error.message(), "invalid length 3, expected an array of length 2");
            assert_eq!(&text[error.span().unwrap()], at);
        }
    }
}
