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
