//! `masks.yaml`: what is not compared where a device is held against a capture, and how exactly the rest is.
//!
//! This room must not know captures.

use super::device_yaml::whole;
use super::error::{Mistake, Read};
use super::keys::{self, Keyed};
use super::names::Names;
use super::yaml::Node;

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
}

/// Reads a file of masks; every name has to be one of the device.
pub(super) fn read(node: &Node, names: &Names<'_>) -> Read<MaskList> {
    let keyed = Keyed::new(node, &keys::MASKS)?;
    let mut list = MaskList::default();
    for (key, why) in keyed.must("masks")?.entries("masks")? {
        let name = key.text("a name")?;
        match names.find(name) {
            Some(Ok(_)) => list.names.push((name.to_owned(), why.text("a reason")?.to_owned())),
            Some(Err((message, _))) => return Err(key.wrong(message)),
            None => {
                let mut known: Vec<String> = Vec::new();
                names.known(&mut |name| known.push(name.to_owned()));
                return Err(Mistake::unknown(key.spot, "name", name, known.iter().map(String::as_str)));
            }
        }
    }
    list.tolerance = keyed.get("tolerance").map(|node| whole(node, "a number of cycles")).transpose()?;
    list.noise = keyed.get("noise").map(|node| whole(node, "a number of steps")).transpose()?;
    Ok(list)
}
