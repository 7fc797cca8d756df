//! Keys of mappings: each set of keys is declared once, beside the code that reads it.
//!
//! [`key_set!`](crate::key_set) makes a module with one [`Key`] for each key and with [`KEYS`](KeySet). What the loader accepts, its
//! messages about unknown and missing keys, and `encspec schema` all come from these declarations.

use super::error::{Mistake, Mistakes, Read};
use super::yaml::Node;
use plain_text::nearest;
use std::fmt;

/// What may stand after a key.
#[derive(Clone, Copy, Debug)]
pub enum Shape {
    /// Any single value.
    Text,
    /// A text that is not blank.
    FilledText,
    /// A text of this form.
    Pattern(&'static Pattern),
    /// A name that is declared here: letters, digits, `_` and `-`.
    Label,
    /// A name that is declared elsewhere.
    Name,
    /// One of the words of an enumeration.
    Word(&'static dyn Vocabulary),
    /// This word and no other.
    Only(&'static str),
    /// A whole number of this range, both ends included.
    Whole(i128, i128),
    /// One of these numbers.
    Numbers(&'static [u32]),
    /// A number, with or without a fraction.
    Number,
    /// A number, a word or `=` and an expression.
    Scalar,
    /// An expression, with or without `=`.
    Expression,
    /// A list of requirements, or `none`.
    Covers,
    /// `Covers`, or `case`.
    CoversOrCase,
    /// The same, or a mapping of names of the check to such lists.
    CoversApart,
    /// Two whole numbers of this range, the first not above the second.
    Pair(i128, i128),
    /// Only `true`; a flag that is not set is left out.
    Flag,
    /// A duration in time.
    Time,
    /// A duration in time, or `none`.
    TimeOrNone,
    /// A duration in time or a number of cycles.
    Duration,
    /// A duration in time, a number of cycles, or a number.
    Quantity,
    /// The same, or a mapping with these keys.
    QuantityOr(&'static KeySet),
    /// Bytes in hexadecimal.
    Octets,
    /// Bytes in hexadecimal, or `none`.
    OctetsOrNone,
    /// This many bytes in hexadecimal.
    OctetsOf(usize),
    /// A condition.
    Condition,
    /// A condition, or a mapping of names and expected values.
    Checks,
    /// Whatever the position allows.
    Any,
    /// A value, or `{ value, from_source }`.
    Sourced(&'static Shape),
    /// One value, or a mapping with one for each variant.
    PerVariant(&'static Shape),
    /// A list, which may be empty.
    List(&'static Shape),
    /// A list of one entry or more.
    NonEmpty(&'static Shape),
    /// A list with a number of entries between these two.
    Between(usize, usize, &'static Shape),
    /// A mapping with names that are declared here.
    Map(&'static Shape),
    /// The same with one entry or more.
    NonEmptyMap(&'static Shape),
    /// A mapping with names that are declared elsewhere.
    Names(&'static Shape),
    /// A mapping with these keys.
    Keys(&'static KeySet),
    /// A table of words and their numbers.
    WordTable,
    /// Subslots of slot 0 and their idents.
    Network,
    /// A bit, a pair of bits, or a mapping with the keys of a field.
    Bits,
    /// Named bits of a parameter, or of each of its elements.
    ParameterBits,
    /// A step: one verb and its modifiers.
    Step,
    /// A connection, or `none`.
    Start,
    /// Names and the values that are set.
    Settings,
    /// Names and the values that are written.
    Written,
    /// Names and the right answers of what is read.
    Access,
    /// One service of `send` with its fields.
    Service,
    /// A right answer.
    Answer,
    /// What is changed in a request.
    Instead,
    /// What is changed in a start-up.
    StartInstead,
    /// Readings of the manual by name, each with its steps.
    Readings,
    /// The right number or the right sequence.
    Observation,
    /// The rows of a table, or its columns as in `takes`.
    Table,
    /// A row of a table.
    Row,
}

/// The form of a text, as a regular expression of ECMA 262, and in words.
#[derive(Debug)]
pub struct Pattern {
    /// The regular expression.
    pub regex: &'static str,
}

/// The words of an enumeration.
pub trait Vocabulary: Sync + fmt::Debug {
    /// The words in the order in which they are listed.
    fn words(&self) -> Vec<&'static str>;
}

/// An enumeration: each word with its value.
#[derive(Debug)]
pub struct WordChoices<T: 'static>(pub &'static [(&'static str, T)]);

impl<T: Sync + fmt::Debug> Vocabulary for WordChoices<T> {
    fn words(&self) -> Vec<&'static str> {
        self.0.iter().map(|(word, _)| *word).collect()
    }
}

impl<T: Copy> WordChoices<T> {
    /// The value of the word after a key; an unknown word is refused with the nearest one.
    pub fn read(&self, node: &Node, key: &Key) -> Read<T> {
        self.find(node, key.name)
    }

    /// The value of a word, which messages call `what`.
    pub fn find(&self, node: &Node, what: &str) -> Read<T> {
        let text = node.text(what)?;
        let found = self.0.iter().find(|(word, _)| *word == text);
        let words = self.0.iter().map(|(word, _)| *word);
        let unknown = || Mistake::unknown(node.spot, &format!("word for {what}"), text, words);
        found.map(|(_, value)| *value).ok_or_else(unknown)
    }
}

/// Words that stand in a table elsewhere.
#[derive(Debug)]
pub struct TableWords(pub fn() -> Vec<&'static str>);

impl Vocabulary for TableWords {
    fn words(&self) -> Vec<&'static str> {
        (self.0)()
    }
}

impl TableWords {
    /// The word after a key; an unknown one is refused with the nearest.
    pub fn read(&self, node: &Node, key: &Key) -> Read<&'static str> {
        let text = node.text(key.name)?;
        let unknown = || Mistake::unknown(node.spot, &format!("word for {}", key.name), text, self.words());
        self.words().into_iter().find(|word| *word == text).ok_or_else(unknown)
    }
}

/// A key of a mapping.
#[derive(Debug)]
pub struct Key {
    /// The key as it is written.
    pub name: &'static str,
    /// Whether the mapping needs it.
    pub required: bool,
    /// What stands after it.
    pub shape: Shape,
    /// What it is for.
    pub sentence: &'static str,
}

impl Key {
    /// A key of the name `ident`, which may be a raw identifier.
    pub const fn new(ident: &'static str, required: bool, shape: Shape, sentence: &'static str) -> Key {
        let name = match ident.as_bytes() {
            [b'r', b'#', ..] => ident.split_at(2).1,
            _ => ident,
        };
        Key { name, required, shape, sentence }
    }
}

/// Which keys go together.
#[derive(Debug)]
pub enum Choice {
    /// Exactly one of these.
    OneOf(&'static [&'static Key]),
    /// One of these at least.
    AnyOf(&'static [&'static Key]),
    /// Not both.
    NotBoth(&'static Key, &'static Key),
    /// All of these or none.
    Together(&'static [&'static Key]),
    /// None of the first without the second.
    With(&'static [&'static Key], &'static Key),
}

impl Choice {
    /// What is wrong with a mapping by this choice: the key to point at, where there is one, and what is wrong.
    fn mistake(&self, what: &str, has: impl Fn(&Key) -> bool) -> Option<(Option<&'static Key>, String)> {
        let listed = |keys: &[&Key]| keys.iter().map(|key| format!("`{}`", key.name)).collect::<Vec<_>>().join(", ");
        match self {
            Choice::OneOf(keys) => match keys.iter().filter(|key| has(key)).count() {
                1 => None,
                _ => Some((None, format!("{what} has exactly one of {}", listed(keys)))),
            },
            Choice::AnyOf(keys) => {
                (!keys.iter().any(|key| has(key))).then(|| (None, format!("{what} has one of {}", listed(keys))))
            }
            Choice::NotBoth(one, other) => (has(one) && has(other))
                .then(|| (Some(*other), format!("{what} has `{}` or `{}`, not both", one.name, other.name))),
            Choice::Together(keys) => {
                let missing = keys.iter().find(|key| !has(key))?;
                let given = keys.iter().find(|key| has(key))?;
                Some((Some(*given), format!("`{}` needs `{}` beside it", given.name, missing.name)))
            }
            Choice::With(keys, needed) => {
                let given = keys.iter().find(|key| has(key) && !has(needed))?;
                Some((Some(*given), format!("`{}` needs `{}` beside it", given.name, needed.name)))
            }
        }
    }
}

/// The keys that a mapping may have; no others are accepted.
#[derive(Debug)]
pub struct KeySet {
    /// The name of the set in the schema.
    pub name: &'static str,
    /// What has these keys, with its article.
    pub what: &'static str,
    /// The keys in the order of the schema.
    pub keys: &'static [&'static Key],
    /// Which of them go together.
    pub choices: &'static [Choice],
}

impl KeySet {
    /// The names of the keys.
    pub fn names(&self) -> impl Iterator<Item = &'static str> + Clone + use<> {
        self.keys.iter().map(|key| key.name)
    }

    /// The key of this name.
    pub fn key(&self, name: &str) -> Option<&'static Key> {
        self.keys.iter().copied().find(|key| key.name == name)
    }
}

/// Declares the keys of a mapping: a module with a static for each key and with `KEYS`, the set of all.
///
/// Each key is written as `name must shape, "sentence";` or with `may` where the mapping can do without it. Choices between keys
/// follow in brackets.
#[macro_export]
macro_rules! key_set {
    (
        $vis:vis $set:ident $what:literal { $($key:ident $must:ident $shape:expr, $sentence:literal;)* }
        $([$($choice:expr),* $(,)?])?
    ) => {
        #[doc = concat!("The keys of ", $what, ".")]
        #[allow(
            dead_code,
            non_upper_case_globals,
            unused_imports,
            reason = "a key is named as it is written, and a set may only lend its keys"
        )]
        $vis mod $set {
            use super::*;
            use $crate::keys::{Choice::*, Key, KeySet, Shape::*};
            $(
                #[doc = $sentence]
                pub static $key: Key = Key::new(stringify!($key), $crate::key_set!(@$must), $shape, $sentence);
            )*
            /// All keys.
            pub static KEYS: KeySet = KeySet {
                name: stringify!($set),
                what: $what,
                keys: &[$(&$key),*],
                choices: &[$($($choice),*)?],
            };
        }
    };
    (@must) => { true };
    (@may) => { false };
}

/// A mapping whose keys were found to be in their set.
#[derive(Clone, Copy)]
pub struct Keyed<'n> {
    /// The mapping.
    pub node: &'n Node,
}

impl<'n> Keyed<'n> {
    /// Checks the keys of `node` against `set`: unknown keys, missing keys, and keys that do not go together.
    pub fn new(node: &'n Node, set: &'static KeySet) -> Read<Keyed<'n>> {
        let mut wrong: Vec<Box<Mistake>> = Vec::new();
        let mut meant: Vec<String> = Vec::new();
        for (key, _) in node.entries(set.what)? {
            let name = key.text("a key")?;
            if set.key(name).is_none() {
                meant.extend(nearest(name, set.names()));
                wrong.push(Mistake::unknown(key.spot, &format!("key of {}", set.what), name, set.names()));
            }
        }
        // A key that is misspelt is not missing too.
        let is_missing =
            |key: &Key| key.required && node.get(key.name).is_none() && meant.iter().all(|name| name != key.name);
        for key in set.keys.iter().filter(|key| is_missing(key)) {
            wrong.push(node.wrong(format!("{} needs the key `{}`", set.what, key.name)).help(key.sentence));
        }
        if let Some(wrong) = Mistake::all(wrong) {
            return Err(wrong);
        }
        let has = |key: &Key| node.get(key.name).is_some();
        match set.choices.iter().find_map(|choice| choice.mistake(set.what, has)) {
            Some((Some(key), message)) => Err(node.key(key.name).wrong(message)),
            Some((None, message)) => Err(node.wrong(message)),
            None => Ok(Keyed { node }),
        }
    }

    /// The same where reading goes on after an unknown key, which is noted; whether there was one.
    pub fn noting(node: &'n Node, set: &'static KeySet, mistakes: &Mistakes) -> Read<(Keyed<'n>, bool)> {
        let is_unknown = |name: &str| set.key(name).is_none();
        match Keyed::new(node, set) {
            Ok(keyed) => Ok((keyed, false)),
            Err(wrong)
                if node
                    .mapping()
                    .is_some_and(|entries| entries.iter().any(|(key, _)| key.scalar().is_none_or(is_unknown)))
                    && set.keys.iter().all(|key| !key.required || node.get(key.name).is_some()) =>
            {
                mistakes.note(wrong);
                Ok((Keyed { node }, true))
            }
            Err(wrong) => Err(wrong),
        }
    }

    /// The value of a key that may be missing.
    pub fn get(&self, key: &Key) -> Option<&'n Node> {
        self.node.get(key.name)
    }

    /// The value of a key that the set requires.
    pub fn must(&self, key: &Key) -> Read<&'n Node> {
        self.get(key).ok_or_else(|| self.node.wrong(format!("the key `{}` is missing", key.name)))
    }

    /// The key's own node, to point at.
    pub fn key(&self, key: &Key) -> Option<&'n Node> {
        self.node.mapping()?.iter().map(|(name, _)| name).find(|name| name.scalar() == Some(key.name))
    }

    /// The value of an enumeration; none without the key.
    pub fn word<T: Copy>(&self, key: &Key, words: &WordChoices<T>) -> Read<Option<T>> {
        self.get(key).map(|node| words.read(node, key)).transpose()
    }
}
