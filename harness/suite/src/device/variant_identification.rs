//! How the variants of a manual are distinguished by what a device reports.

use serde::{Deserialize, Serialize};

/// The differences between the variants of a manual that a device or its description shows.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct VariantIdentification {
    /// The question to a person who has the device, where its variant stays open.
    pub question: String,
    /// For each variant words of its order numbers and of its names in descriptions; empty if the manual has none.
    pub called: Vec<Vec<String>>,
    /// The start-ups after which the values are read, one after the other until one decides: start parameters with their numbers; all
    /// others have their defaults.
    pub starts: Vec<Vec<(String, i128)>>,
    /// The values that differ.
    pub values: Vec<VariantValue>,
}

/// A value that a device reports, and what it is in each variant.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub struct VariantValue {
    /// Its name as in suites, for instance `P979.revolutions`.
    pub name: String,
    pub source: VariantValueSource,
    /// What it can be, for each variant.
    pub expected: Vec<ExpectedNumber>,
}

/// Where a value is read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum VariantValueSource {
    /// An element of a parameter.
    Parameter { number: u16, subindex: u16 },
    /// A field of the diagnosis, an index into its fields (PROFIBUS).
    Diagnosis(usize),
    /// An input, an index into `signals`.
    Input(usize),
}

/// The numbers that a value can have in a variant.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum ExpectedNumber {
    /// One of these.
    OneOf(Vec<i128>),
    /// Any number below this one: a position of a device with this range.
    Below(i128),
}

impl ExpectedNumber {
    /// Whether a device of the variant can report this number.
    pub fn allows(&self, number: i128) -> bool {
        match self {
            ExpectedNumber::OneOf(numbers) => numbers.contains(&number),
            ExpectedNumber::Below(limit) => number < *limit,
        }
    }
}

impl std::fmt::Display for ExpectedNumber {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            ExpectedNumber::OneOf(numbers) => {
                let numbers: Vec<String> = numbers.iter().map(ToString::to_string).collect();
                f.write_str(&numbers.join(" or "))
            }
            ExpectedNumber::Below(limit) => write!(f, "below {limit}"),
        }
    }
}
