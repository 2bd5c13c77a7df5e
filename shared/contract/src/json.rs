//! JSON of what programs exchange and keep. It is compiled here, once: what is generic over
//! a format would be compiled again in every crate that reads it.

use serde::de::Error as _;
use serde::{Deserialize, Deserializer};
use serde_json::{Error, Value};

/// What is written as JSON.
pub trait Json: Sized {
    /// Reads it from a text. Nothing is checked but its form.
    ///
    /// # Errors
    /// What serde says of the text, with line and column.
    fn from_json(text: &[u8]) -> Result<Self, Error>;

    /// Writes it on one line.
    ///
    /// # Errors
    /// What serde says; nothing here has what JSON cannot hold.
    fn to_json(&self) -> Result<Vec<u8>, Error>;
}

/// What is also read from, and written as, a tree of JSON values, in which single fields can
/// be changed or compared.
pub trait JsonTree: Sized {
    /// Reads it from a tree.
    ///
    /// # Errors
    /// What serde says of the first value that cannot be read.
    fn from_tree(tree: &Value) -> Result<Self, Error>;

    /// Returns it as a tree.
    ///
    /// # Errors
    /// What serde says; nothing here has what JSON cannot hold.
    fn to_tree(&self) -> Result<Value, Error>;
}

/// Reads a field of a format that describes itself by way of a tree, so that its type is not
/// compiled for that format.
///
/// # Errors
/// What serde says, without the place in the text.
pub fn through_tree<'de, T: JsonTree, D: Deserializer<'de>>(input: D) -> Result<T, D::Error> {
    T::from_tree(&Value::deserialize(input)?).map_err(D::Error::custom)
}

/// Implements [`Json`].
macro_rules! json {
    ($($kind:ty),*) => {$(
        impl $crate::json::Json for $kind {
            fn from_json(text: &[u8]) -> Result<Self, serde_json::Error> {
                serde_json::from_slice(text)
            }

            fn to_json(&self) -> Result<Vec<u8>, serde_json::Error> {
                serde_json::to_vec(self)
            }
        }
    )*};
}

/// Implements [`JsonTree`].
macro_rules! json_tree {
    ($($kind:ty),*) => {$(
        impl $crate::json::JsonTree for $kind {
            fn from_tree(tree: &serde_json::Value) -> Result<Self, serde_json::Error> {
                serde::Deserialize::deserialize(tree)
            }

            fn to_tree(&self) -> Result<serde_json::Value, serde_json::Error> {
                serde_json::to_value(self)
            }
        }
    )*};
}

pub(crate) use {json, json_tree};
