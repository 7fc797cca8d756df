//! Macros for code tables: number, constant, word and sentence of each code.
//!
//! The word is used in suites, reports and JSON. A number that is not in the table is preserved and has no word.

/// Defines a type for the codes of a field; its constants, words, sentences and docs come from one table.
///
/// ```text
/// codes! {
///     /// The field, its width, its source.
///     pub struct Name(u16) {
///         0x01 CONSTANT word_in_snake_case "A full sentence.",
///     }
/// }
/// ```
macro_rules! codes {
    ($(#[$doc:meta])* pub struct $name:ident($repr:ty) { $($number:literal $constant:ident $word:ident $sentence:literal),* $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub $repr);

        impl $name {
            $(#[doc = $sentence] pub const $constant: $name = $name($number);)*

            /// Every code that has a word: the code, its word, its sentence; ascending.
            pub const TABLE: &'static [($name, &'static str, &'static str)] =
                &[$(($name($number), stringify!($word), $sentence),)*];

            /// The word for this code, in snake_case; `None` for a code that is not in the table.
            pub fn word(self) -> Option<&'static str> {
                match self.0 {
                    $($number => Some(stringify!($word)),)*
                    _ => None,
                }
            }

            /// The meaning of this code, as a sentence; `None` for a code that is not in the table.
            pub fn sentence(self) -> Option<&'static str> {
                match self.0 {
                    $($number => Some($sentence),)*
                    _ => None,
                }
            }

            /// The code with this word.
            pub fn by_word(word: &str) -> Option<$name> {
                Self::TABLE.iter().find(|entry| entry.1 == word).map(|entry| entry.0)
            }
        }
    };
}
pub(crate) use codes;

/// Defines a type for a bit field; its constants, words, sentences and docs come from one table.
///
/// The syntax is that of [`codes!`]; each number is one bit.
macro_rules! flags {
    ($(#[$doc:meta])* pub struct $name:ident($repr:ty) { $($number:literal $constant:ident $word:ident $sentence:literal),* $(,)? }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub struct $name(pub $repr);

        impl $name {
            $(#[doc = $sentence] pub const $constant: $name = $name($number);)*

            /// Every bit that has a word: the bit, its word, its sentence; ascending.
            pub const TABLE: &'static [($name, &'static str, &'static str)] =
                &[$(($name($number), stringify!($word), $sentence),)*];

            /// Whether all bits of `bits` are set.
            pub const fn has(self, bits: $name) -> bool {
                self.0 & bits.0 == bits.0
            }

            /// Returns the value with all bits of `bits` set.
            pub const fn with(self, bits: $name) -> $name {
                $name(self.0 | bits.0)
            }

            /// The words of the set bits, from bit 0 on.
            pub fn words(self) -> impl Iterator<Item = &'static str> {
                Self::TABLE.iter().filter(move |(bit, _, _)| self.has(*bit)).map(|(_, word, _)| *word)
            }

            /// The set bits that are not in the table: reserved bits.
            pub const fn reserved(self) -> $repr {
                self.0 & !(0 $(| $number)*)
            }
        }
    };
}
pub(crate) use flags;
