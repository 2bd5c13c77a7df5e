//! Lists of a fixed number of numbers, as files have them.
//!
//! A reader of TOML ends with the last number that an array has room for, and what follows
//! is lost in silence: a point of three numbers would be one of two.

use core::fmt;

use serde::de::{Deserialize, Deserializer, Error, IgnoredAny, SeqAccess, Visitor};

/// `N` numbers; one more is an error.
struct Exactly<const N: usize>([f64; N]);

impl<'de, const N: usize> Deserialize<'de> for Exactly<N> {
    fn deserialize<D: Deserializer<'de>>(input: D) -> Result<Self, D::Error> {
        struct Numbers<const N: usize>;

        impl<'de, const N: usize> Visitor<'de> for Numbers<N> {
            type Value = Exactly<N>;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "a list of {N} numbers")
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Exactly<N>, A::Error> {
                let mut numbers = [0.0; N];
                for (count, number) in numbers.iter_mut().enumerate() {
                    let next = list.next_element()?;
                    *number = next.ok_or_else(|| A::Error::invalid_length(count, &self))?;
                }
                match list.next_element::<IgnoredAny>()? {
                    None => Ok(Exactly(numbers)),
                    Some(_) => Err(A::Error::invalid_length(N + 1, &self)),
                }
            }
        }

        input.deserialize_tuple(N, Numbers)
    }
}

/// Reads `N` numbers, and no more: for `#[serde(deserialize_with)]`.
///
/// # Errors
/// A list of another length, or something else than a number.
pub fn numbers<'de, D: Deserializer<'de>, const N: usize>(input: D) -> Result<[f64; N], D::Error> {
    Exactly::deserialize(input).map(|Exactly(numbers)| numbers)
}

/// Reads a list of such lists, as [`numbers`] does.
///
/// # Errors
/// As of [`numbers`], for any of them.
pub fn lists<'de, D: Deserializer<'de>, const N: usize>(
    input: D,
) -> Result<Vec<[f64; N]>, D::Error> {
    let lists = Vec::<Exactly<N>>::deserialize(input)?;
    Ok(lists.into_iter().map(|Exactly(numbers)| numbers).collect())
}

#[cfg(test)]
mod tests {
    use crate::WorldSpec;

    #[test]
    fn a_point_has_two_numbers_in_every_format() {
        let text = |bounds: &str, a: &str, at: &str| {
            format!(
                "name = \"box\"\nbounds = {bounds}\n[[walls]]\na = {a}\nb = [4.0, 3.0]\n\
                 material = \"Wall\"\n[[landmarks]]\nid = 1\nat = {at}\n"
            )
        };
        let spec = WorldSpec::from_toml_str(&text("[0, 0, 4, 3]", "[0, 0]", "[1, 2]")).unwrap();
        assert_eq!(spec.landmarks[0].at, [1.0, 2.0]);
        for (bounds, a, at, line) in [
            ("[0, 0, 4, 3, 17]", "[0, 0]", "[1, 2]", "line 2"),
            ("[0, 0, 4]", "[0, 0]", "[1, 2]", "line 2"),
            ("[0, 0, 4, 3]", "[0, 0, \"x\"]", "[1, 2]", "line 4"),
            ("[0, 0, 4, 3]", "[0, 0]", "[1, 2, {}]", "line 9"),
        ] {
            let error = WorldSpec::from_toml_str(&text(bounds, a, at)).unwrap_err().to_string();
            assert!(error.contains(line) && error.contains("numbers"), "{error}");
        }
        let json = spec.to_json().unwrap().replace("1.0,\n", "1.0, 7.0,\n");
        assert!(WorldSpec::from_json_str(&json).is_err(), "{json}");
    }
}
