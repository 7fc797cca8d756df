//! What the GSDML of a vendor may say otherwise than that of the reference device: device and description vary together.
//!
//! A manual prints none of this. A harness takes it from [`CHANGES`], as it takes that of a live device from its GSDML.

use super::vendor_records::{RECORDS, VendorRecord, VendorRecords};
use crate::needs::Need;
use crate::seams::Deviations;
use crate::seams::idents::IdentMask;
use crate::seams::start_layout::StartLayout;
use crate::seams::web::with_text;
use crate::tables::Group;
use alloc::format;
use reference_devices::manuals::{LIKA_XAC77, PROFINET_IO};

/// What a variation changes in the description of a device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum DescriptionChange {
    /// Idents of modules and submodules.
    Idents(IdentMask),
    /// The device ID.
    DeviceId(u16),
    /// The number of ports.
    Ports(u16),
    /// The label of a value on the web pages, and the one instead.
    Label(&'static str, &'static str),
    /// The places of the start parameters.
    StartParameters(StartLayout),
    /// More records that belong to each start-up.
    StartRecords(&'static [VendorRecord]),
}

/// Idents that fill all 32 bits.
const LARGE: IdentMask = IdentMask { module: 0x8A00_0000, submodule: 0xF0F0_0000, network: 0 };
/// Idents that have nothing to do with the number of a telegram.
const MIXED: IdentMask = IdentMask { module: 0x0000_5300, submodule: 0x0000_A6C0, network: 0 };
/// Idents of interface and ports that are not their subslots.
const NETWORK: IdentMask = IdentMask { module: 0, submodule: 0, network: 0x0053_8A10 };
const OTHER_DEVICE_ID: u16 = 0x0A17;
const FIRMWARE: (&str, &str) = ("Firmware version", "Software release");
const POSITION: (&str, &str) = ("Current position", "Position value");

/// What each of these variations changes in the description.
pub const CHANGES: [(&str, DescriptionChange); 8] = [
    ("idents-of-32-bits", DescriptionChange::Idents(LARGE)),
    ("idents-of-another-list", DescriptionChange::Idents(MIXED)),
    ("idents-of-interface-and-ports", DescriptionChange::Idents(NETWORK)),
    ("device-id-of-another-series", DescriptionChange::DeviceId(OTHER_DEVICE_ID)),
    ("start-records-of-the-vendor", DescriptionChange::StartRecords(&RECORDS)),
    ("one-port", DescriptionChange::Ports(1)),
    ("pages-with-other-labels", DescriptionChange::Label(FIRMWARE.0, FIRMWARE.1)),
    ("pages-with-other-labels", DescriptionChange::Label(POSITION.0, POSITION.1)),
];

/// The variations, by what they need.
pub static GROUPS: &[Group] = &[
    Group {
        needs: &[Need::Profinet],
        deviations: permitted! {
            "idents-of-32-bits" "The idents of modules and submodules use all 32 bits."
                "GSDML, ModuleIdentNumber and SubmoduleIdentNumber: 32 bits of the vendor's choice; no manual prints them"
                => |d| d.idents = d.idents.and(LARGE);
            "idents-of-another-list" "Modules and submodules have idents that are not the numbers of their telegrams."
                "GSDML, ModuleIdentNumber and SubmoduleIdentNumber: 32 bits of the vendor's choice; no manual prints them"
                => |d| d.idents = d.idents.and(MIXED);
        },
    },
    Group {
        needs: &[Need::OfEither(&LIKA_XAC77, &PROFINET_IO)],
        deviations: permitted! {
            "device-id-of-another-series" "The device ID is another number of the vendor."
                "GSDML, DeviceIdentity: 16 bits of the vendor's choice; the manual does not print it"
                => |d| d.stack.identity(|identity| identity.device_id = OTHER_DEVICE_ID);
            "start-records-of-the-vendor" "Two more records of the vendor, one of the access point and one of its module, belong to each start-up: without their defaults no inputs of that module are good."
                "GSDML, ParameterRecordDataItem: a controller writes each of them at each start-up; the manual does not list them"
                => |d| d.stack.add(VendorRecords::default());
        },
    },
    Group {
        needs: &[Need::Of(&PROFINET_IO)],
        deviations: permitted! {
            "one-port" "The device has one port."
                "IEC 61158-6-10: an IO device has at least one port; the other manuals print how many their encoder has"
                => |d| d.stack.identity(|identity| identity.ports = 1);
            "idents-of-interface-and-ports" "The idents of the interface and of the ports are not their subslots."
                "GSDML, SubmoduleIdentNumber of the interface and of a port: 32 bits of the vendor's choice; no manual prints them"
                => |d| d.idents = d.idents.and(NETWORK);
        },
    },
    Group {
        needs: &[Need::Of(&LIKA_XAC77)],
        deviations: permitted! {
            "pages-with-other-labels" "The web pages call the firmware version and the position by other names."
                "XAC77, chapter 17: the figures with the pages are missing, and the text does not print these labels"
                => |d| [FIRMWARE, POSITION].into_iter().for_each(|(label, other)| relabel(d, label, other));
        },
    },
];

fn relabel(deviations: &mut Deviations, label: &'static str, other: &'static str) {
    let (label, other) = (format!("<td>{label}</td>"), format!("<td>{other}</td>"));
    deviations.web.page(move |_, _, page| with_text(page, |text| text.replace(&label, &other)));
}
