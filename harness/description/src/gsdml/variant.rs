//! Which variants of a manual fit the access point and the modules of a GSDML, by their names and order numbers.

use super::identity::ReportedIdentity;
use super::matching;
use super::model::{AccessPoint, Gsdml, ModuleInfo};
use crate::variant_reading::{ReadingSource, VariantReading, called_in};
use results::outcome::DescriptionKind;
use suite::device::DeviceDescription;

/// The readings of a GSDML: its access point and modules, those that the device reports if it does. `order` is the order number in I&M0.
pub fn variant_readings(
    device: &DeviceDescription,
    gsdml: &Gsdml,
    says: Option<&ReportedIdentity>,
    order: Option<&str>,
) -> Vec<VariantReading> {
    let all: Vec<&AccessPoint> = gsdml.access_points.iter().collect();
    let plugged = |point: &AccessPoint| {
        let plugged = says?.plugged.iter().find(|of| of.slot == point.slot)?;
        Some(plugged.module_ident)
    };
    let reported: Vec<&AccessPoint> = all.iter().copied().filter(|of| plugged(of) == Some(of.ident)).collect();
    let is_reported = all.iter().any(|point| plugged(point).is_some());
    let meant = if is_reported { &reported } else { &all };
    let mut readings = Vec::new();
    let infos = |points: &[&'_ AccessPoint]| points.iter().map(|of| of.info.clone()).collect::<Vec<_>>();
    readings.extend(reading(device, "the access point", &infos(meant), &infos(&all), is_reported));
    for of in says.map_or(&[][..], |says| &says.plugged) {
        let Some(point) = meant.iter().find(|point| point.slot != of.slot) else { continue };
        let modules = matching::in_slot(gsdml, point, of.slot);
        let found: Vec<ModuleInfo> =
            modules.iter().filter(|known| known.ident == of.module_ident).map(|known| known.info.clone()).collect();
        let every: Vec<ModuleInfo> = modules.iter().map(|known| known.info.clone()).collect();
        let what = format!("the module in slot {}", of.slot);
        let reading = reading(device, &what, &found, &every, true);
        readings.extend(reading.filter(|reading| !readings.contains(reading)));
    }
    readings.extend(order.and_then(|order| ordered(device, gsdml, order)));
    readings
}

/// The texts of an item that can have words of a variant.
fn texts(info: &ModuleInfo) -> [&str; 2] {
    [&info.name, &info.order_number]
}

/// What the items `found` among `all` say about the variant. The device says it if it reports which one it has, and another one would
/// mean another variant.
fn reading(
    device: &DeviceDescription,
    what: &str,
    found: &[ModuleInfo],
    all: &[ModuleInfo],
    is_reported: bool,
) -> Option<VariantReading> {
    let fits: Vec<Vec<bool>> = found.iter().map(|info| called_in(device, &texts(info))).collect();
    // One that says nothing may be any variant.
    if fits.is_empty() || fits.iter().any(|fits| !fits.contains(&true)) {
        return None;
    }
    let chooses = all.iter().any(|info| {
        let other = called_in(device, &texts(info));
        other.contains(&true) && !fits.contains(&other)
    });
    let source = match is_reported && chooses {
        true => ReadingSource::Device,
        false => ReadingSource::Description(DescriptionKind::Gsdml),
    };
    let what = if source == ReadingSource::Device { what.to_owned() } else { format!("{what} of the GSDML") };
    let texts: Vec<&str> = found.iter().flat_map(texts).collect();
    VariantReading::of_text(device, what, &texts, source)
}

/// The item of the GSDML with the order number in I&M0, where the number itself says nothing.
fn ordered(device: &DeviceDescription, gsdml: &Gsdml, order: &str) -> Option<VariantReading> {
    if called_in(device, &[order]).contains(&true) {
        return None;
    }
    let infos = gsdml.access_points.iter().map(|of| &of.info).chain(gsdml.modules.iter().map(|of| &of.info));
    let all: Vec<ModuleInfo> = infos.cloned().collect();
    let is_it = |info: &&ModuleInfo| info.order_number.eq_ignore_ascii_case(order);
    let found: Vec<ModuleInfo> = all.iter().filter(is_it).cloned().collect();
    reading(device, "the item of the GSDML with the order number in I&M0", &found, &all, true)
}
