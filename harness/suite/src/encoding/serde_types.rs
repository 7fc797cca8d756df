//! Serde for types of crates without serde.

use serde::{Deserialize, Deserializer, Serialize, Serializer};
use wire::ethernet::Mac;
use wire::profibus::fdl::BaudRate;

/// A MAC address, for `#[serde(with)]`.
pub(crate) mod mac {
    use super::*;

    pub(crate) fn serialize<S: Serializer>(mac: &Mac, to: S) -> Result<S::Ok, S::Error> {
        mac.0.serialize(to)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Mac, D::Error> {
        Deserialize::deserialize(from).map(Mac)
    }
}

/// An optional transmission rate, for `#[serde(with)]`.
pub(crate) mod baud {
    use super::*;

    pub(crate) fn serialize<S: Serializer>(rate: &Option<BaudRate>, to: S) -> Result<S::Ok, S::Error> {
        rate.map(|rate| rate.0).serialize(to)
    }

    pub(crate) fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<Option<BaudRate>, D::Error> {
        Ok(Option::<u32>::deserialize(from)?.map(BaudRate))
    }
}
