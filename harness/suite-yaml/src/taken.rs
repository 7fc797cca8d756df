//! What a common suite takes from a manual: the kinds of it, and whether a manual gives the right one.
//!
//! Whether a name exists and a number fits is checked where it is used; here only its form is checked.

use super::device_yaml::{self, plain};
use super::error::{Mistake, Read};
use super::frame::literal;
use super::keys::Keyed;
use super::topic_keys::{KINDS, takes};
use super::yaml::Node;
use expression::Type;

/// The mistakes of a declaration `{ is, why }` by itself; its kind.
pub(super) fn kind(declared: &Node) -> Read<&str> {
    let keyed = Keyed::new(declared, &takes::KEYS)?;
    keyed.must(&takes::why)?.text(takes::why.name)?;
    let kind = keyed.must(&takes::is)?;
    KINDS.read(kind, &takes::is)?;
    kind.text(takes::is.name)
}

/// Whether `value` is of the kind in `declared`.
pub(super) fn fits(value: &Node, declared: &Node) -> Read<()> {
    let kind = kind(declared)?;
    if is_of(value, kind) {
        return Ok(());
    }
    let shown = value.scalar().filter(|text| !text.is_empty()).map(|text| format!("`{text}`"));
    let shown = shown.unwrap_or_else(|| value.what().to_owned());
    let expected = KINDS.0.iter().find(|(word, _)| *word == kind).map_or("", |(_, expected)| expected);
    Err(value.wrong(format!("{shown} is not what the common suite takes here")).help(format!("it takes {expected}")))
}

fn is_of(value: &Node, kind: &str) -> bool {
    let text = value.scalar().unwrap_or_default();
    let computed = value.expression().is_some_and(|text| !text.trim().is_empty());
    match kind {
        "parameter" => device_yaml::parameter_number(text.split('.').next().unwrap_or(text)).is_some(),
        "number" => computed || expression::number(text).is_ok(),
        "bits" => is_words(value) || computed || expression::number(text).is_ok(),
        "role" => text.starts_with("role."),
        "name" => is_name(value),
        "text" => computed || literal(value, &Type::Text).is_ok(),
        "bytes" => computed || literal(value, &Type::Bytes).is_ok(),
        "span" => computed || value.plain().is_some() && expression::duration(text).is_ok(),
        "words" => is_words(value),
        "values" => value.mapping().is_some_and(|entries| !entries.is_empty()),
        "requirements" => {
            value.plain() == Some("none")
                || value.sequence().is_some_and(|items| {
                    !items.is_empty() && items.iter().all(|item| plain(item, "a requirement").is_ok())
                })
        }
        "any" => !matches!(&value.kind, super::yaml::NodeKind::Scalar { text, quoted: false } if text.is_empty()),
        "condition" => is_single(value),
        _ => computed || value.plain().is_some() && is_single(value) && !text.contains(char::is_whitespace),
    }
}

fn is_single(value: &Node) -> bool {
    value.scalar().is_some_and(|text| !text.is_empty())
}

/// A list of single values.
fn is_words(value: &Node) -> bool {
    value.sequence().is_some_and(|items| !items.is_empty() && items.iter().all(is_single))
}

/// Names parted by dots; the first begins with a letter.
fn is_name(value: &Node) -> bool {
    let Some(text) = value.plain() else { return false };
    let part = |part: &str| !part.is_empty() && part.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
    text.starts_with(|c: char| c.is_ascii_alphabetic()) && text.split('.').all(part)
}

/// The columns that a common suite leaves to the manual, `with: { column: { is, why } }`.
pub(super) fn columns(with: &Node) -> Read<Vec<(&str, &Node)>> {
    let columns = device_yaml::named(with, "a table")?;
    match columns.iter().try_for_each(|(_, declared)| kind(declared).map(|_| ())) {
        Ok(()) if columns.is_empty() => Err(with.wrong("a table without columns")),
        read => read.map(|()| columns),
    }
}

/// Whether `value` says something else for each variant: a mapping of variants.
fn is_per_variant(value: &Node, variants: &[String]) -> bool {
    let is_variant = |key: &Node| key.plain().is_some_and(|key| variants.iter().any(|known| known == key));
    value.mapping().is_some_and(|entries| entries.iter().any(|(key, _)| is_variant(key)))
}

/// What `value` is for a variant.
pub(super) fn of_variant<'n>(value: &'n Node, variants: &[String], variant: usize) -> &'n Node {
    match variants.get(variant).filter(|_| is_per_variant(value, variants)) {
        Some(name) => value.get(name).unwrap_or(value),
        None => value,
    }
}

/// Whether a manual gives what is taken, alike for all variants or for each of them.
pub(super) fn given(value: &Node, declared: &Node, variants: &[String]) -> Read<()> {
    if !is_per_variant(value, variants) {
        return fits(value, declared);
    }
    for (key, value) in value.entries("what is given")? {
        let name = key.text("a variant")?;
        if !variants.iter().any(|known| known == name) {
            return Err(Mistake::unknown(key.spot, "variant", name, variants.iter().map(String::as_str)));
        }
        fits(value, declared)?;
    }
    match variants.iter().find(|variant| value.get(variant).is_none()) {
        Some(missing) => Err(value.wrong(format!("there is no value for the variant `{missing}`"))),
        None => Ok(()),
    }
}
