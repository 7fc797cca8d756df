//! Plain values: words, numbers, pairs, durations, flags, names, and where a datum comes from.

use super::super::error::{Mistake, Read, every};
use super::super::keys::{Key, Keyed, Pattern, WordChoices};
use super::super::yaml::Node;
use expression::{DurationLiteral, Number};
use std::time::Duration;
use suite::device::Origin;

/// Where a datum comes from that the manual does not print.
pub(crate) static ORIGINS: WordChoices<Origin> =
    WordChoices(&[("description", Origin::Description), ("invented", Origin::Invented)]);
/// The path of a web page: a slash, then printable characters without spaces.
pub static PATH: Pattern = Pattern { regex: r"^/[!-~]*$" };

key_set! {
    pub(crate) sourced_datum "a datum with its origin" {
        value must Scalar, "The datum.";
        from_source must Word(&ORIGINS), "Where it comes from.";
    }
}

/// Words that YAML readers take for something else; a suite says what it means.
const YAML_WORDS: [&str; 8] = ["on", "off", "yes", "no", "true", "false", "null", "~"];

/// A scalar without quotes that is a word or a number, and none of YAML's own words.
pub fn plain<'n>(node: &'n Node, what: &str) -> Read<&'n str> {
    let text = node.text(what)?;
    if node.plain().is_none() {
        return Err(node.wrong(format!("{what} stands without quotes")).help(format!("write {text}")));
    }
    if YAML_WORDS.contains(&text.to_ascii_lowercase().as_str()) {
        return Err(node
            .wrong(format!("`{text}` is a word of YAML itself, not of the suites"))
            .help("write the word that device.yaml declares"));
    }
    Ok(text)
}

/// A number, with or without a fraction.
pub fn numeral(node: &Node, what: &str) -> Read<Number> {
    let text = plain(node, what)?;
    expression::number(text).map_err(|error| Mistake::expression(node.spot, 0, text, error))
}

/// A whole number that fits its type.
pub fn whole<T: TryFrom<i128>>(node: &Node, what: &str) -> Read<T> {
    let value = numeral(node, what)?;
    let whole = value.as_whole().ok_or_else(|| node.wrong(format!("{what} is a whole number")))?;
    T::try_from(whole).map_err(|_| node.wrong(format!("{whole} is out of range for {what}")))
}

/// Two whole numbers, the first not above the second.
pub fn pair<T: TryFrom<i128> + PartialOrd>(node: &Node, what: &str) -> Read<(T, T)> {
    match node.items(what)? {
        [low, high] => {
            let (low, high) = (whole(low, what)?, whole::<T>(high, what)?);
            if low <= high {
                Ok((low, high))
            } else {
                Err(node.wrong(format!("{what}: the first number is above the second")))
            }
        }
        _ => Err(node.wrong(format!("{what} is a pair `[first, last]`"))),
    }
}

/// A duration in time.
pub fn duration(node: &Node, what: &str) -> Read<Duration> {
    let text = plain(node, what)?;
    match expression::duration(text).map_err(|error| Mistake::expression(node.spot, 0, text, error))? {
        DurationLiteral::Time(time) => Ok(time),
        DurationLiteral::Cycles(_) => Err(node.wrong(format!("{what} is a time, not a number of cycles"))),
    }
}

/// The keys that say which bytes and bits a field has, and the words of its messages.
pub struct FieldKeys {
    /// The key of its only byte.
    pub one: &'static Key,
    /// The key of its first and last byte.
    pub many: &'static Key,
    /// The key of its only bit.
    pub bit: &'static Key,
    /// The key of its lowest and highest bit.
    pub bits: &'static Key,
    /// What has these bytes.
    pub whole: &'static str,
}

/// Which bytes and bits a field has.
pub struct FieldPosition {
    /// Its first byte.
    pub first: usize,
    /// The number of its bytes.
    pub octets: usize,
    /// For bits in one byte: the lowest and how many.
    pub bits: Option<(u32, u32)>,
}

/// The position of a field among `size` bytes.
pub fn position(keyed: Keyed<'_>, keys: &FieldKeys, size: usize) -> Read<FieldPosition> {
    let FieldKeys { one, many, bit, bits, whole: of } = keys;
    let wrong = |message: String| Err(keyed.node.wrong(message));
    let (first, last) = match (keyed.get(one), keyed.get(many)) {
        (Some(only), _) => whole::<usize>(only, one.name).map(|only| (only, only))?,
        (None, Some(both)) => pair(both, many.name)?,
        (None, None) => return wrong(format!("a field has either `{}` or `{}`", one.name, many.name)),
    };
    if last >= size {
        return wrong(format!("{} {last} is beyond the {size} {} of the {of}", one.name, many.name));
    }
    let bits = match (keyed.get(bit), keyed.get(bits)) {
        (None, None) => None,
        (Some(bit), _) => Some((whole::<u32>(bit, "a bit")?, 1)),
        (None, Some(bits)) => {
            pair::<u32>(bits, "bits").map(|(low, high)| Some((low, (high - low).saturating_add(1))))?
        }
    };
    if bits.is_some_and(|(low, width)| first != last || low.saturating_add(width) > 8) {
        return wrong(format!("bits are counted 0 to 7 in one {}", one.name));
    }
    Ok(FieldPosition { first, octets: last - first + 1, bits })
}

/// A flag: `true`, or the key is left out.
pub fn flag(keyed: Keyed<'_>, key: &Key) -> Read<bool> {
    flag_value(keyed.get(key), key)
}

/// The value of the flag `key`, if it is there.
pub fn flag_value(value: Option<&Node>, key: &Key) -> Read<bool> {
    match value {
        None => Ok(false),
        Some(node) if node.plain() == Some("true") => Ok(true),
        Some(node) => Err(node.wrong(format!("`{}` is `true` or left out", key.name))),
    }
}

/// Names and values of a mapping that is not empty.
pub fn named<'n>(node: &'n Node, what: &str) -> Read<Vec<(&'n str, &'n Node)>> {
    let entry = |(key, value): &'n (Node, Node)| {
        let name = plain(key, "a name")?;
        label(key, name)?;
        Ok((name, value))
    };
    every(node.entries(what)?.iter().map(entry))
}

/// A list of names that are declared here, each once.
pub fn labels(node: &Node, what: &str) -> Read<Vec<String>> {
    let mut names: Vec<String> = Vec::new();
    for item in node.items(what)? {
        let name = plain(item, what)?;
        label(item, name)?;
        if names.iter().any(|known| known == name) {
            return Err(item.wrong(format!("`{name}` stands twice in {what}")));
        }
        names.push(name.to_owned());
    }
    if names.is_empty() { Err(node.wrong(format!("{what} is empty"))) } else { Ok(names) }
}

/// A name is made of letters, digits, `_` and `-`, and begins with a letter.
pub fn label(at: &Node, name: &str) -> Read<()> {
    let good = name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_' || c == '-');
    if good {
        Ok(())
    } else {
        Err(at
            .wrong(format!("`{name}` is no name"))
            .help("a name has letters, digits, `_` and `-`, and begins with a letter"))
    }
}

/// Where a datum comes from, by the key `from_source` beside it.
pub fn origin(keyed: Keyed<'_>, from_source: &Key) -> Read<Origin> {
    Ok(keyed.word(from_source, &ORIGINS)?.unwrap_or(Origin::Manual))
}

/// A datum, or `{ value, from_source }`.
pub fn sourced(node: &Node) -> Read<(&Node, Origin)> {
    if node.mapping().is_none() {
        return Ok((node, Origin::Manual));
    }
    let keyed = Keyed::new(node, &sourced_datum::KEYS)?;
    Ok((keyed.must(&sourced_datum::value)?, origin(keyed, &sourced_datum::from_source)?))
}
