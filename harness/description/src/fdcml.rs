//! A vendor's FDCML: the type of device that it names, held against the manual.

use results::outcome::{DescriptionKind, Finding, Severity};
use suite::device::Device;

/// Where the manual and an FDCML name another type of station; nothing for a device without one, or a text that is no XML.
pub fn compare(device: &Device, text: &str) -> Vec<Finding> {
    let Some(facts) = device.profinet() else { return Vec::new() };
    let Ok(document) = roxmltree::Document::parse(text) else { return Vec::new() };
    let named = document.descendants().find(|node| node.has_tag_name("deviceType")).and_then(|node| node.text());
    let manual = &facts.identity.station_type;
    let other = named.filter(|named| *named != manual.as_str());
    let finding = |said: &str| Finding {
        id: "station_type".into(),
        severity: Severity::Warning,
        text: format!("Type of station: the manual says {manual}, the FDCML says {said}."),
        manual: Some(manual.clone()),
        description: Some((DescriptionKind::Fdcml, said.to_owned())),
        device: None,
    };
    other.map(finding).into_iter().collect()
}
