//! Enums whose values have a word and a sentence, as tables that can be printed.

macro_rules! words {
    ($(#[$doc:meta])* pub enum $name:ident { $($Variant:ident $word:literal $sentence:literal,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum $name {
            $(#[doc = $sentence] $Variant,)*
        }

        impl $name {
            /// All values with word and sentence.
            pub const TABLE: &'static [($name, &'static str, &'static str)] = &[$(($name::$Variant, $word, $sentence),)*];

            /// The word in snake_case.
            pub fn word(self) -> &'static str {
                match self { $($name::$Variant => $word,)* }
            }

            /// The meaning as a sentence.
            pub fn sentence(self) -> &'static str {
                match self { $($name::$Variant => $sentence,)* }
            }
        }

        impl core::fmt::Display for $name {
            fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
                f.write_str(self.word())
            }
        }
    };
}
pub(crate) use words;
