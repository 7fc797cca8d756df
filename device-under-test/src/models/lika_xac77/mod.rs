//! Lika XAC7718/1PT and XAC7716/16384PT with PROFINET, from the user guide MAN XAC77 PT E 1.3.
//!
//! Readings, where the manual is silent or contradicts itself; what is said of the profile is in the profile's rooms:
//!
//! - A record 0xBF00 of another length is refused and nothing changes. One of the right length is accepted; what is
//!   wrong in it is reported as a parametrization fault (0x1002, P65001, diagnosis 0x9011), and where its scaling is
//!   wrong the hardware resolution stands in for it. It belongs to the start-up: in data exchange it is refused.
//! - Each connection begins with the default parameters; the record of this start wins over them.
//! - A preset is carried out when its offset is safe in memory: then, in one frame, the position is shifted and bit 12
//!   is set. With class 4 off the handshake runs and nothing is shifted. The offset is a number on the circle of
//!   the range, 0 to range - 1. Presets work during an alarm.
//! - With G1_XIST1 preset control off, G1_XIST1 is the position without any offset.
//! - While parked, G1_XIST3 and the velocity are 0 as the other positions are. A preset request that is held through
//!   parking is no new request. Parking is refused (0x0003) while the shaft turns.
//! - Withdrawing Control by PLC voids all requests of G1_STW, parking included; positions go on.
//! - A failed save leaves P971 at 1. P971 takes 0 and 1.
//! - The factory reset of the manual is suboption 5; of suboption 6, modes 1, 2, 4 and 8 reset the part they name.
//! - P979 has elements of 32 bits, as its values demand; its resolution and revolutions are those of the hardware.
//! - P925 is not there, for P980 does not list it. LEDs are not described.

mod device;
mod live;
mod names;
pub(crate) mod parameters;
#[cfg(test)]
mod tests;
mod web;

pub use device::Xac77;

use crate::application::Plug;
use crate::bugs::{self, Table};
use crate::encoder::Hardware;
use crate::profidrive::telegram;
use alloc::vec::Vec;

/// One of the two encoders of the manual.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Variant {
    /// Its name in the suites.
    pub name: &'static str,
    /// The order code of the encoder.
    pub order_id: &'static str,
    /// The number of its device access point in the GSDML.
    pub access_point: u32,
    /// What its sensor tells apart.
    pub hardware: Hardware,
}

/// The encoders of the manual.
pub static VARIANTS: [Variant; 2] = [
    Variant {
        name: "xac7718",
        order_id: "XAC7718/1PT",
        access_point: 2,
        hardware: Hardware { steps_per_revolution: 1 << 18, revolutions: 1 },
    },
    Variant {
        name: "xac7716-16384",
        order_id: "XAC7716/16384PT",
        access_point: 3,
        hardware: Hardware { steps_per_revolution: 1 << 16, revolutions: 1 << 14 },
    },
];

/// Every bug that a reference XAC77 can be told to have.
pub static BUGS: &[Table] = &[
    Table::All(bugs::signals::BUGS),
    Table::All(bugs::handshakes::BUGS),
    Table::All(bugs::presets::BUGS),
    Table::All(bugs::measuring::BUGS),
    Table::All(bugs::velocity::BUGS),
    Table::All(bugs::parameter_access::BUGS),
    Table::All(bugs::parameters::BUGS),
    Table::All(bugs::start::BUGS),
    Table::All(bugs::memory::BUGS),
    Table::All(bugs::diagnosis::BUGS),
    Table::All(bugs::reset::BUGS),
    Table::All(bugs::records::BUGS),
    Table::All(bugs::station::BUGS),
    Table::All(bugs::web::BUGS),
    Table::Only(bugs::stack::BUGS, BUGS_OF_THE_STACK),
];

const BUGS_OF_THE_STACK: &[&str] = &[
    "name-prefix-answered",
    "nameless-answers-everybody",
    "name-with-padding",
    "station-type-of-the-stack",
    "mac-of-the-stack",
    "mac-changes-with-reset",
    "set-of-others-taken",
    "mask-ignored",
    "address-after-restart-only",
    "name-after-restart-only",
    "name-erases-address",
    "long-name-cut",
    "address-waits-for-dcp",
    "link-local-address",
    "arp-probe-ignored",
    "reset-answered-and-not-done",
    "silent-after-reset",
    "not-announced-without-name",
    "lldp-tells-old-name",
    "neighbour-not-told",
    "second-port-announced",
    "half-duplex-reported",
    "ident-not-checked",
    "module-difference-not-reported",
    "output-length-not-checked",
    "other-variant-accepted",
    "dap-1-accepted",
    "encoder-in-slot-0",
    "rt-class-3-accepted",
    "fourth-connection-refused",
    "good-inputs-before-ready",
    "outputs-not-watched",
    "im0-length-counts-header",
    "im0-of-54-octets",
    "im0-without-vendor",
    "im0-padded-with-zeros",
    "im0-serial-empty",
    "im0-serial-of-zeros",
    "im0-revisions-wrong",
    "im0-software-as-text",
    "im0-counts-reads",
    "im0-without-profile",
    "im0-version-0",
    "im0-announces-im1",
    "im0-written",
    "im1-accepted",
    "unknown-index-answered",
    "second-reader-ends-connection",
];

/// How the MAC addresses of all encoders begin.
pub const OUI: [u8; 3] = [0x10, 0xB9, 0xFE];
/// API of the encoder profile.
pub const ENCODER_API: u32 = 0x3D00;
/// Slot of the encoder object.
pub const ENCODER_SLOT: u16 = 1;
/// Ident of the module of the encoder object.
const ENCODER_MODULE: u32 = 1;
/// Subslot of the parameter access point.
pub const ACCESS_POINT_SUBSLOT: u16 = 1;
/// Subslot of the telegram.
pub const TELEGRAM_SUBSLOT: u16 = 2;

/// Idents are not printed in the manual but for the numbers of the access points, which stand here for their idents; they
/// and the API of slot 0 are invented for our reference device.
fn plugs(variant: &Variant, rules: &telegram::Rules) -> Vec<Plug> {
    let plug = |slot, subslot, submodule_ident, input_octets, output_octets| Plug {
        api: if slot == 0 { 0 } else { ENCODER_API },
        slot,
        module_ident: if slot == 0 { variant.access_point } else { ENCODER_MODULE },
        subslot,
        submodule_ident,
        input_octets,
        output_octets,
    };
    let fixed = [plug(0, 1, 1, 0, 0), plug(ENCODER_SLOT, ACCESS_POINT_SUBSLOT, 2, 0, 0)];
    let telegrams = telegram::STANDARD.iter().map(|telegram| {
        let ident = u32::from(telegram.number);
        plug(ENCODER_SLOT, TELEGRAM_SUBSLOT, ident, (rules.input_octets)(telegram), telegram::OUTPUT_OCTETS)
    });
    fixed.into_iter().chain(telegrams).collect()
}
