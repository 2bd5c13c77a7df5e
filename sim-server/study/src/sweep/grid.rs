//! `--set key=v1,v2,…`: the fields that are swept, and all combinations.

use rusty_contract::FieldError;

/// A field and the values it takes, as they were written.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Axis {
    /// Path of the field, as in the scenario file.
    pub key: String,
    /// Its values, in order; at least one.
    pub values: Vec<String>,
}

impl Axis {
    /// Reads `key=v1,v2,…`. Commas inside brackets, braces and quotation marks
    /// belong to a value.
    ///
    /// # Errors
    /// [`FieldError`] names `option`, text and form.
    pub fn parse(option: &str, text: &str) -> Result<Self, FieldError> {
        let wrong = |problem: &str| {
            let remedy = "write key=v1,v2, e.g. robot.slip_std=0.01,0.02; a value with a comma \
                          of its own stands in [], {} or quotation marks";
            FieldError::new(option, text, problem, remedy)
        };
        let (key, list) = text.split_once('=').ok_or_else(|| wrong("has no `=`"))?;
        let values = split(list).ok_or_else(|| wrong("has a bracket or quotation mark alone"))?;
        if key.trim().is_empty() || values.iter().any(String::is_empty) {
            return Err(wrong("has a key or value that is empty"));
        }
        let same = |a: &String, b: &String| match (a.parse::<f64>(), b.parse::<f64>()) {
            (Ok(a), Ok(b)) => a == b,
            _ => a == b,
        };
        let twice = (1..values.len()).any(|i| values[..i].iter().any(|v| same(v, &values[i])));
        if twice {
            return Err(wrong("has a value twice"));
        }
        Ok(Self { key: key.trim().to_owned(), values })
    }
}

impl std::fmt::Display for Axis {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}={}", self.key, self.values.join(","))
    }
}

/// Reads the swept fields: every `--set`, then the `--ab`, which has two values.
///
/// # Errors
/// [`FieldError`] names option, text and form.
pub fn axes(set: &[String], ab: Option<&str>) -> Result<Vec<Axis>, FieldError> {
    let axes = set.iter().map(|text| Axis::parse("--set", text));
    let mut axes: Vec<Axis> = axes.collect::<Result<_, _>>()?;
    if let Some(text) = ab {
        let axis = Axis::parse("--ab", text)?;
        if axis.values.len() != 2 {
            let problem = format!("has {} values", axis.values.len());
            let remedy = "give the two to compare: --ab robot.slip_std=0.02,0.03";
            return Err(FieldError::new("--ab", text, problem, remedy));
        }
        axes.push(axis);
    }
    Ok(axes)
}

/// Splits at the commas outside brackets and quotation marks; `None` where one
/// of those has no partner.
fn split(list: &str) -> Option<Vec<String>> {
    let mut values = vec![String::new()];
    let (mut open, mut quote) = (Vec::new(), None);
    let mut escaped = false;
    for c in list.chars() {
        match (quote, c) {
            (Some('"'), _) if escaped => escaped = false,
            (Some('"'), '\\') => escaped = true,
            (Some(mark), _) if c == mark => quote = None,
            (Some(_), _) => {}
            (None, '"' | '\'') => quote = Some(c),
            (None, '[') => open.push(']'),
            (None, '{') => open.push('}'),
            (None, ']' | '}') if open.pop() != Some(c) => return None,
            (None, ',') if open.is_empty() => {
                values.push(String::new());
                continue;
            }
            _ => {}
        }
        values.last_mut()?.push(c);
    }
    let whole = open.is_empty() && quote.is_none();
    whole.then(|| values.iter().map(|v| v.trim().to_owned()).collect())
}

/// All combinations of the axes' values, the last axis changing fastest; one
/// empty combination of no axes. `None` if there are more than `most`.
#[must_use]
pub fn combinations(axes: &[Axis], most: usize) -> Option<Vec<Vec<(String, String)>>> {
    let mut all = vec![Vec::new()];
    for axis in axes {
        if all.len().checked_mul(axis.values.len())? > most {
            return None;
        }
        let with = |before: &Vec<(String, String)>, value: &String| {
            let mut parameters = before.clone();
            parameters.push((axis.key.clone(), value.clone()));
            parameters
        };
        all = all.iter().flat_map(|b| axis.values.iter().map(move |v| with(b, v))).collect();
    }
    Some(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> Vec<String> {
        Axis::parse("--set", text).unwrap().values
    }

    #[test]
    fn only_commas_between_values_part_them() {
        assert_eq!(values("a.b=1,2 , 3"), ["1", "2", "3"]);
        assert_eq!(values("a=x"), ["x"]);
        assert_eq!(
            values("a={ x = 1, y = [2, 3] },{ x = 2 }"),
            ["{ x = 1, y = [2, 3] }", "{ x = 2 }"]
        );
        assert_eq!(
            values(r#"a="1,2",'3,"4',"\",","b""#),
            [r#""1,2""#, "'3,\"4'", r#""\",""#, "\"b\""]
        );
        assert_eq!(values("a=b=c,d"), ["b=c", "d"]);
        for text in ["a", "=1", "a=", "a=1,,2", "a=[1,2", "a=1],2", "a={[1}],2", "a=\"1", "a=1,1"] {
            assert!(Axis::parse("--set", text).is_err(), "{text}");
        }
    }

    #[test]
    fn the_last_axis_changes_fastest() {
        let axes = ["a=1,2", "b=x,y,z"].map(|text| Axis::parse("--set", text).unwrap());
        let words = |c: &Vec<(String, String)>| c.iter().map(|p| p.1.as_str()).collect::<String>();
        let all: Vec<String> = combinations(&axes, 6).unwrap().iter().map(words).collect();
        assert_eq!(all, ["1x", "1y", "1z", "2x", "2y", "2z"]);
        assert_eq!(combinations(&axes, 5), None);
        assert_eq!(combinations(&[], 1), Some(vec![Vec::new()]));
    }
}
