//! What a common suite takes from a manual: the kinds of it, and whether a manual gives the right one.
//!
//! Whether a name exists and a number fits is seen where it is used; here it is only seen that it can be meant at all.

use super::device_yaml::{self, plain, word};
use super::error::{Mistake, Read};
use super::frame::literal;
use super::keys::{self, Keyed};
use super::yaml::Node;
use expression::Type;

/// What a manual has to write for a kind, for messages.
fn wanted(kind: &str) -> &'static str {
    match kind {
        "parameter" => "a parameter, as `P65000`",
        "number" => "a number, or `=` and an expression",
        "bits" => "bits by name, as `[parked, sensor_error]`, or a number",
        "role" => "a role, as `role.position`",
        "name" => "a name of the device, as `G1_ZSW.parked`",
        "text" => "a text in quotes",
        "bytes" => "octets in quotes, as \"40 .. 00\"",
        "span" => "a duration, as `20ms`, or a number of cycles",
        "words" => "a list of single values, as `[read_only, limit]`",
        "values" => "a mapping of names and values, as `{ G1_STW.park: 1 }`",
        "condition" => "a condition, as `G1_ZSW.parked and not G1_ZSW.sensor_error`",
        "requirements" => "a list of requirements, or `none`",
        "any" => "whatever the place asks for",
        _ => "a word",
    }
}

/// The mistakes of a declaration `{ is, why }` by itself; its kind.
pub(super) fn kind(declared: &Node) -> Read<&'static str> {
    let keyed = Keyed::new(declared, &keys::TAKES)?;
    keyed.must("why")?.text("why")?;
    word(keyed.must("is")?, "is", keys::TAKEN)
}

/// Whether `value` is of the kind that `declared` asks for.
pub(super) fn fits(value: &Node, declared: &Node) -> Read<()> {
    let kind = kind(declared)?;
    if is_of(value, kind) {
        return Ok(());
    }
    let shown = value.scalar().filter(|text| !text.is_empty()).map(|text| format!("`{text}`"));
    let shown = shown.unwrap_or_else(|| value.what().to_owned());
    Err(value
        .wrong(format!("{shown} is not what the common suite takes here"))
        .help(format!("it takes {}", wanted(kind))))
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
        "any" => !matches!(&value.kind, super::yaml::Kind::Scalar { text, quoted: false } if text.is_empty()),
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
