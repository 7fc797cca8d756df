//! Bugs of the switches, of Set_Slave_Address and of the supply.

use crate::seams::slave::request;
use crate::tables::Deviation;
use alloc::vec;
use alloc::vec::Vec;
use device_stack::profibus::{SlaveApplication, SlaveHooks, SlaveStackCheck};
use reference_devices::models::datalogic_amt58::ADDRESS;
use reference_devices::models::datalogic_amt58::hooks::Amt58Check;
use station::StandAction;
use wire::profibus::address::SetSlaveAddress;
use wire::profibus::sap::{SapService, SlaveSap};

/// The bugs of the address.
pub static BUGS: &[Deviation] = bugs! {
    "address-service-never-active" "Set_Slave_Address is refused even with the switches at 126."
        => |d| d.slave.check(|check, is_served| is_served && check != SlaveStackCheck::AddressService);
    "address-service-always-active" "Set_Slave_Address is accepted with any position of the switches."
        => |d| d.slave.check(|check, is_served| is_served || check == SlaveStackCheck::AddressService);
    "address-locked-with-0" "Only the first Set_Slave_Address is accepted, whatever its lock byte is."
        => |d| d.slave.add(AddressLock { with_0: true, ..AddressLock::default() });
    "address-locked" "A lock byte other than 0 locks the address permanently."
        => |d| d.slave.add(AddressLock::default());
    "address-lost-at-power-off" "The address set over the bus is lost at power-off."
        => |d| d.amt58.address(|of, _| of.switches);
    "bus-address-before-switches" "An address set over the bus takes precedence over the switches."
        => |d| d.amt58.address(|of, _| of.set_by_bus.unwrap_or(of.switches));
    "address-bits-reversed" "Switch 1 is the highest bit of the address and switch 7 the lowest."
        => |d| d.amt58.address(|of, _| of.switches.reverse_bits() >> 1);
    "eighth-switch-adds-128" "Switch 8 adds 128 to the address, and the device does not answer then."
        => |d| d.slave.add(EighthSwitch::default());
    "address-0-refused" "With the switches at 0 the device does not answer."
        => |d| d.amt58.address(|_, address| if address == 0 { SILENT } else { address });
    "addresses-above-99-refused" "With the switches above 99, except at 126, the device does not answer."
        => |d| d.amt58.address(|of, address| if of.switches > 99 && of.switches != 126 { SILENT } else { address });
    "address-126-refused" "With the switches at 126 the device does not answer."
        => |d| d.amt58.address(|of, address| if of.switches == 126 { SILENT } else { address });
    "delivered-with-another-address" "A new device has its switches at 2."
        => |d| {
            let mut is_new = true;
            d.amt58.address(move |of, right| {
                let is_first = core::mem::replace(&mut is_new, false);
                if is_first && of.switches == ADDRESS { ADDRESS + 1 } else { right }
            });
        };
    "works-from-12-v-on" "With less than 12 V the device does not work."
        => |d| d.amt58.check(|_, check, right| right && !matches!(check, Amt58Check::Supply(..12_000)));
    "works-up-to-28-v" "With more than 28 V the device does not work."
        => |d| d.amt58.check(|_, check, right| right && !matches!(check, Amt58Check::Supply(28_001..)));
    "termination-never-on" "The line is not terminated with both RT switches on."
        => |d| d.amt58.check(|_, check, right| right && !matches!(check, Amt58Check::Terminated(_)));
    "termination-never-off" "The line is terminated with both RT switches off."
        => |d| d.amt58.check(|_, check, right| right || matches!(check, Amt58Check::Terminated(_)));
    "address-of-the-first-power-up" "The switches are read at the first power-up only."
        => |d| {
            let mut first = None;
            d.amt58.address(move |_, right| *first.get_or_insert(right));
        };
};

/// An address at which no slave answers.
const SILENT: u8 = 127;

/// Locks the address set by Set_Slave_Address: if its lock byte is not 0, or always.
#[derive(Default)]
struct AddressLock {
    with_0: bool,
    is_requested: bool,
    is_locked: bool,
}

impl SlaveHooks for AddressLock {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        if let Some((frame, SapService::Slave(SlaveSap::SET_SLAVE_ADDRESS))) = request(telegram)
            && let Ok(address) = SetSlaveAddress::parse(frame.data)
        {
            self.is_requested = self.with_0 || address.no_change != 0;
        }
        vec![telegram.to_vec()]
    }

    fn check(&mut self, _: &dyn SlaveApplication, check: SlaveStackCheck, verdict: bool) -> bool {
        match check {
            SlaveStackCheck::AddressService => verdict && !self.is_locked,
            SlaveStackCheck::NewAddress(_) => {
                self.is_locked |= verdict && self.is_requested;
                verdict
            }
            _ => verdict,
        }
    }
}

/// Adds 128 to the address at power-up with the eighth switch on.
#[derive(Default)]
struct EighthSwitch {
    is_on: bool,
    acts: bool,
}

impl SlaveHooks for EighthSwitch {
    fn check(&mut self, _: &dyn SlaveApplication, check: SlaveStackCheck, verdict: bool) -> bool {
        verdict && !(self.acts && matches!(check, SlaveStackCheck::Address(_)))
    }

    fn starts(&mut self) {
        self.acts = self.is_on;
    }

    fn act(&mut self, action: &StandAction<'_>) {
        if let StandAction::Switch("eighth", position) = action {
            self.is_on = *position != 0;
        }
    }
}
