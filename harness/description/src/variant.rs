//! Which variant of a manual a device is, by what the device and its description report.
//!
//! A reading says which variants it fits; one that fits none, or all, says nothing, since a manual leaves much of it free. A claim is
//! refuted only if what the device reports excludes it and nothing that it reports speaks for it.

use crate::gsd::Gsd;
use crate::gsdml::{Gsdml, ReportedIdentity, variant_readings};
use results::outcome::{DescriptionKind, DeviceFinding, FindingSeverity};
use suite::device::{DeviceDescription, Origin};

pub use crate::variant_reading::{ReadingSource, VariantReading};

/// The readings of what a PROFINET device reports without a connection, and of its GSDML; `device` has no values of a GSDML yet.
pub fn profinet_readings(
    device: &DeviceDescription,
    gsdml: Option<&Gsdml>,
    says: Option<&ReportedIdentity>,
) -> Vec<VariantReading> {
    if device.variants.len() < 2 {
        return Vec::new();
    }
    let order = says.and_then(|says| says.im0.as_ref()).map(|im0| String::from_utf8_lossy(&im0.order_id).into_owned());
    let order = order.map(|order| order.trim_end_matches(['\0', ' ']).to_owned()).filter(|order| !order.is_empty());
    let mut readings = Vec::new();
    readings.extend(order.as_deref().and_then(|order| order_reading(device, order)));
    readings.extend(says.and_then(|says| printed_access_point(device, says)));
    readings.extend(gsdml.into_iter().flat_map(|gsdml| variant_readings(device, gsdml, says, order.as_deref())));
    readings
}

/// The reading of an order number in I&M0; `None` if it says nothing.
pub fn order_reading(device: &DeviceDescription, order: &str) -> Option<VariantReading> {
    VariantReading::of_text(device, "the order number in I&M0".to_owned(), &[order], ReadingSource::Device)
}

/// The reading of the GSD of a slave.
pub fn profibus_readings(device: &DeviceDescription, gsd: Option<&Gsd>) -> Vec<VariantReading> {
    let source = ReadingSource::Description(DescriptionKind::Gsd);
    let of_model =
        |gsd: &Gsd| VariantReading::of_text(device, "Model_Name in the GSD".to_owned(), &[&gsd.model], source);
    gsd.into_iter().filter_map(of_model).collect()
}

/// The ident of the access point, where the manual prints one for each variant.
fn printed_access_point(device: &DeviceDescription, says: &ReportedIdentity) -> Option<VariantReading> {
    let of = device.submodules.iter().find(|of| of.slot == 0 && of.ident_origin == Origin::Manual)?;
    let idents = of.module_idents.as_ref()?;
    let plugged = says.plugged.iter().find(|plugged| plugged.slot == 0)?.module_ident;
    let reading = VariantReading {
        what: "the ident of the access point".to_owned(),
        value: format!("0x{plugged:X}"),
        source: ReadingSource::Device,
        expected: idents.iter().map(|ident| format!("0x{ident:X}")).collect(),
        fits: idents.iter().map(|ident| *ident == plugged).collect(),
    };
    reading.decides().then_some(reading)
}

/// The variants, as indices, that the readings leave: all where they contradict each other. What the device reports counts first; what
/// a description says decides only between the variants that are left.
pub fn candidates(device: &DeviceDescription, readings: &[VariantReading]) -> Vec<usize> {
    let mut left: Vec<usize> = (0..device.variants.len()).collect();
    for of_device in [true, false] {
        let counts = |reading: &&VariantReading| reading.speaks_of_device() == of_device;
        let fits = |variant: &usize| readings.iter().filter(counts).all(|reading| reading.fits(*variant));
        let fitting: Vec<usize> = left.iter().copied().filter(fits).collect();
        if fitting.is_empty() {
            return left;
        }
        left = fitting;
    }
    left
}

/// The finding that a device is not the claimed variant (an index into `device.variants`); `None` if nothing excludes it, or if
/// something that the device reports speaks for it.
pub fn refuted_claim(device: &DeviceDescription, claimed: usize, readings: &[VariantReading]) -> Option<DeviceFinding> {
    if readings.iter().filter(|reading| reading.speaks_of_device()).any(|reading| reading.fits(claimed)) {
        return None;
    }
    let against: Vec<&VariantReading> = readings.iter().filter(|reading| !reading.fits(claimed)).collect();
    against.first()?;
    let name = device.variants.get(claimed).map_or("", String::as_str);
    let left = candidates(device, readings).into_iter().filter_map(|of| device.variants.get(of));
    let left: Vec<String> = left.map(|variant| format!("{}/{variant}", device.name)).collect();
    let read = |reading: &&VariantReading| format!("{} is {}", reading.what, reading.value);
    let expected = |reading: &&VariantReading| {
        let of_claim = reading.expected.get(claimed).map_or("", String::as_str);
        format!("{}: {of_claim}", reading.what)
    };
    let expected: Vec<String> = against.iter().map(expected).collect();
    let of = |is_device: bool| {
        let said: Vec<String> = against.iter().filter(|of| of.speaks_of_device() == is_device).map(read).collect();
        (!said.is_empty()).then(|| said.join("; "))
    };
    let kind = against.iter().find_map(|reading| match reading.source {
        ReadingSource::Description(kind) => Some(kind),
        ReadingSource::Device => None,
    });
    let (of_device, of_description) = (of(true), of(false));
    let said: Vec<String> = of_device.iter().chain(&of_description).cloned().collect();
    Some(DeviceFinding {
        id: "variant".to_owned(),
        severity: FindingSeverity::Error,
        text: format!(
            "The device is not {}/{name}, which the bench claims, so nothing was judged: {}. Write `device: {}`, or test the claimed \
             device.",
            device.name,
            said.join("; "),
            left.join("` or `device: ")
        ),
        manual: Some(format!("{name}: {}", expected.join("; "))),
        description: kind.zip(of_description),
        device: of_device,
    })
}
