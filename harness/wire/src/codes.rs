//! Code tables: number, constant, word and sentence of each code in one place.
//!
//! The word is what suites, reports and JSON say. A number that a table does not know is kept and has no word.

/// Makes a type for the codes of one field; constants, words, sentences and their docs all come from the same table.
///
/// ```text
/// codes! {
///     /// What the field is, its width, its source.
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

            /// The word for this code, in snake_case; none for a code that the table does not know.
            pub fn word(self) -> Option<&'static str> {
                match self.0 {
                    $($number => Some(stringify!($word)),)*
                    _ => None,
                }
            }

            /// What this code means, as a sentence; none for a code that the table does not know.
            pub fn sentence(self) -> Option<&'static str> {
                match self.0 {
                    $($number => Some($sentence),)*
                    _ => None,
                }
            }

            /// The code that has this word.
            pub fn by_word(word: &str) -> Option<$name> {
                Self::TABLE.iter().find(|entry| entry.1 == word).map(|entry| entry.0)
            }
        }
    };
}
pub(crate) use codes;

/// Makes a type for a field of bits; constants, words, sentences and their docs all come from the same table.
///
/// It is written like [`codes!`]; each number is one bit.
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

            /// The same with all bits of `bits` set.
            pub const fn with(self, bits: $name) -> $name {
                $name(self.0 | bits.0)
            }

            /// The words of the bits that are set, from bit 0 on.
            pub fn words(self) -> impl Iterator<Item = &'static str> {
                Self::TABLE.iter().filter(move |(bit, _, _)| self.has(*bit)).map(|(_, word, _)| *word)
            }

            /// The bits that are set and have no word: those that are reserved.
            pub const fn reserved(self) -> $repr {
                self.0 & !(0 $(| $number)*)
            }
        }
    };
}
pub(crate) use flags;
