//! What distinguishes one PROFINET device from another of the same manual.

use crate::needs::Need;
use crate::seams::Deviations;
use crate::seams::web::with_text;
use crate::tables::Group;
use alloc::format;
use alloc::string::String;
use reference_devices::manuals::{KUEBLER_SENDIX58XX, LIKA_XAC77, PROFINET_IO, SICK_AFX60};

/// The variations, by what they need.
pub static GROUPS: &[Group] = &[
    Group {
        needs: &[Need::Profinet],
        deviations: permitted! {
            "serial-number-long" "The serial number fills its 16 characters."
                "I&M0, SerialNumber: 16 characters of the vendor's choice"
                => |d| d.stack.identity(|identity| identity.serial_number = String::from("SN-2026-11-00417"));
            "serial-number-short" "The serial number is one digit."
                "I&M0, SerialNumber: 16 characters of the vendor's choice"
                => |d| d.stack.identity(|identity| identity.serial_number = String::from("7"));
            "revision-counter-high" "The revision counter of I&M0 is 41."
                "I&M0, RevisionCounter: counts changes of the configuration, 0 in a device without them"
                => |d| d.stack.identity(|identity| identity.revision_counter = 41);
        },
    },
    Group {
        needs: &[Need::OfEither(&SICK_AFX60, &PROFINET_IO)],
        deviations: permitted! {
            "firmware-later" "The firmware is V 7.13.205."
                "the manual prints no firmware version that a device has to have"
                => |d| firmware(d, [b'V', 7, 13, 205]);
            "firmware-prototype" "The firmware is a prototype, P 0.9.1."
                "I&M0, SoftwareRevision: prefix V, R, P, U or T; the manual prints no version that a device has to have"
                => |d| firmware(d, [b'P', 0, 9, 1]);
            "hardware-later" "The hardware revision is 23."
                "the manual prints no hardware revision that a device has to have"
                => |d| d.stack.identity(|identity| identity.hardware_revision = 23);
        },
    },
    Group {
        needs: &[Need::OfEither(&KUEBLER_SENDIX58XX, &PROFINET_IO)],
        deviations: permitted! {
            "order-number-of-an-option" "The order number is that of an option."
                "I&M0, OrderID: 20 characters of the vendor's choice; the manual prints none that a device has to have"
                => |d| d.stack.identity(|identity| identity.order_id = "OPTION-4711-B/123456");
        },
    },
    Group {
        needs: &[Need::Of(&KUEBLER_SENDIX58XX)],
        deviations: permitted! {
            "firmware-with-fixes" "The firmware is V 3.0.205."
                "Sendix 58xx, section 1: the manual covers V3.0.x"
                => |d| firmware(d, [b'V', 3, 0, 205]);
        },
    },
    Group {
        needs: &[Need::Of(&LIKA_XAC77)],
        deviations: permitted! {
            "firmware-of-two-digits" "The firmware is V 7.13.2, and P964 and P975 contain 713."
                "XAC77, version table: 1.0.9 or above; section 15: the parameters contain the version as a decimal number"
                => |d| {
                    firmware(d, [b'V', 7, 13, 2]);
                    firmware_as_a_number(d, 713);
                };
            "firmware-of-a-prototype" "The firmware is a prototype, P 1.2.3, and P964 and P975 contain 123."
                "I&M0, SoftwareRevision: prefix V, R, P, U or T; XAC77, version table: 1.0.9 or above"
                => |d| {
                    firmware(d, [b'P', 1, 2, 3]);
                    firmware_as_a_number(d, 123);
                };
            "order-number-of-a-special-version" "The order number continues with the mark of a special version."
                "XAC77, order codes: special versions continue with a hyphen or /S"
                => |d| d.stack.identity(|identity| identity.order_id = match identity.order_id {
                    "XAC7718/1PT" => "XAC7718/1PT-H12",
                    "XAC7716/16384PT" => "XAC7716/16384PT/S4",
                    other => other,
                });
        },
    },
];

fn firmware(deviations: &mut Deviations, revision: [u8; 4]) {
    deviations.stack.identity(move |identity| identity.software_revision = revision);
}

/// Changes the firmware version in P964, in P975 and on the web pages.
fn firmware_as_a_number(deviations: &mut Deviations, version: u16) {
    deviations.encoder.element(move |_, at, value| if let (964 | 975, 2) = at { version.into() } else { value });
    deviations.web.page(move |view, _, page| {
        with_text(page, |text| {
            text.replace(&format!("<td>{}</td>", view.facts.software[0]), &format!("<td>{version}</td>"))
        })
    });
}
