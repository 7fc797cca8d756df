//! `masks.yaml`: what is not compared where a device is held against a capture, and how exactly the rest is.
//!
//! This module does not depend on captures.

use super::device_yaml::{duration, whole};
use super::error::{Mistake, Read};
use super::keys::Keyed;
use super::names::Names;
use super::yaml::Node;
use std::time::Duration;

key_set! {
    pub(crate) masks "masks.yaml" {
        masks must Names(&Text), "Names that are not compared with a capture, each with the reason.";
        tolerance may Whole(0, 0xFFFF_FFFF_FFFF_FFFF), "By how many cycles a value may come earlier or later than recorded, 5 by default.";
        noise may Whole(0, 0xFFFF_FFFF), "By how many steps a measured number may differ, 0 by default.";
        periods may Names(&Time), "Names that are measured once in this time: while the shaft turns they may be earlier or later by it.";
    }
}

/// The name of the file.
pub(super) const MASKS: &str = "masks";

/// What is not compared, and how exactly the rest is.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct MaskList {
    /// Names of the device, each with the reason; all that is part of one is not compared either.
    pub names: Vec<(String, String)>,
    /// By how many cycles a value may come earlier or later, where it is said.
    pub tolerance: Option<u64>,
    /// By how many steps a measured number may differ, where it is said.
    pub noise: Option<u32>,
    /// Names that are measured once in a time, each with that time.
    pub periods: Vec<(String, Duration)>,
}

/// Reads a file of masks; every name has to be one of the device.
pub(super) fn read(node: &Node, names: &Names<'_>) -> Read<MaskList> {
    let keyed = Keyed::new(node, &masks::KEYS)?;
    let mut list = MaskList::default();
    for (key, why) in keyed.must(&masks::masks)?.entries("masks")? {
        list.names.push((known_name(key, names)?, why.text("a reason")?.to_owned()));
    }
    if let Some(periods) = keyed.get(&masks::periods) {
        for (key, period) in periods.entries("periods")? {
            list.periods.push((known_name(key, names)?, duration(period, "a period")?));
        }
    }
    list.tolerance = keyed.get(&masks::tolerance).map(|node| whole(node, "a number of cycles")).transpose()?;
    list.noise = keyed.get(&masks::noise).map(|node| whole(node, "a number of steps")).transpose()?;
    Ok(list)
}

/// A name of the device.
fn known_name(key: &Node, names: &Names<'_>) -> Read<String> {
    let name = key.text("a name")?;
    match names.find(name) {
        Some(Ok(_)) => Ok(name.to_owned()),
        Some(Err((message, _))) => Err(key.wrong(message)),
        None => {
            let mut known: Vec<String> = Vec::new();
            names.known(&mut |name| known.push(name.to_owned()));
            Err(Mistake::unknown(key.spot, "name", name, known.iter().map(String::as_str)))
        }
    }
}
