//! Bugs of the switches and of Set_Slave_Address.

use crate::seams::slave::{frame, request, with_data};
use crate::tables::Deviation;
use alloc::vec;
use alloc::vec::Vec;
use device_stack::profibus::{SlaveApplication, SlaveHooks, SlaveStackCheck};
use station::StandAction;
use wire::profibus::address::SetSlaveAddress;
use wire::profibus::fdl::DataFrame;
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
    "address-changes-on-the-fly" "The switches are read continuously, and their address is used at once."
        => |d| d.slave.add(LiveDipSwitches::default());
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

/// Uses the address of the switches as soon as they are moved.
#[derive(Default)]
struct LiveDipSwitches {
    /// The position of the switches, if they were moved since power-up.
    moved_to: Option<u8>,
}

impl SlaveHooks for LiveDipSwitches {
    fn check(&mut self, _: &dyn SlaveApplication, check: SlaveStackCheck, verdict: bool) -> bool {
        match (check, self.moved_to) {
            (SlaveStackCheck::Address(address), Some(position)) => address == position,
            _ => verdict,
        }
    }

    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        if let (Some(position), Some(frame)) = (self.moved_to, frame(telegram)) {
            *telegram = with_data(&DataFrame { sa: position, ..frame }, frame.data);
        }
    }

    fn starts(&mut self) {
        self.moved_to = None;
    }

    fn act(&mut self, action: &StandAction<'_>) {
        if let StandAction::Switch("address", position) = action {
            self.moved_to = u8::try_from(*position).ok();
        }
    }
}
