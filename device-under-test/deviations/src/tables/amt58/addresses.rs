//! Bugs of the switches and of the address that the bus gives.

use crate::tables::Deviation;
use crate::tables::slave_memory::FollowsAddress;

/// The bugs of this seam.
pub static BUGS: &[Deviation] = bugs! {
    "address-service-never-active" "Set_Slave_Address is refused with the switches at 126 too."
        => |b| b.amt58.takes_address = |_| false;
    "address-service-always-active" "Set_Slave_Address is taken with any position of the switches."
        => |b| b.amt58.takes_address = |_| true;
    "address-locked-with-0" "After the first Set_Slave_Address no other is taken, whatever its lock octet says."
        => |b| b.amt58.locks_address = |_| true;
    "address-locked" "A lock octet other than 0 locks the address for good."
        => |b| b.amt58.locks_address = |is_final| is_final;
    "address-lost-at-power-off" "The address given over the bus is lost when the supply goes off."
        => |b| b.amt58.stores_address = |_, _| None;
    "bus-address-before-switches" "An address once given over the bus counts whatever the switches say."
        => |b| b.amt58.address = |switches| switches.given.unwrap_or(switches.address);
    "address-bits-reversed" "Switch 1 is the highest bit of the address and switch 7 the lowest."
        => |b| b.amt58.address = |switches| switches.address.reverse_bits() >> 1;
    "eighth-switch-adds-128" "Switch 8 adds 128 to the address, and the device then answers nobody."
        => |b| b.amt58.address = |switches| switches.address | u8::from(switches.eighth) << 7;
    "address-0-refused" "With the switches at 0 the device answers nobody."
        => |b| b.amt58.address = |switches| if switches.address == 0 { NOBODY } else { switches.address };
    "addresses-above-99-refused" "With the switches above 99 the device answers nobody, 126 apart."
        => |b| b.amt58.address = |switches| match switches.address {
            126 => switches.given.unwrap_or(126),
            100.. => NOBODY,
            address => address,
        };
    "address-126-refused" "With the switches at 126 the device answers nobody."
        => |b| b.amt58.address = |switches| if switches.address == 126 { NOBODY } else { switches.address };
    "address-changes-on-the-fly" "The switches are read all the time, and their address counts at once."
        => |b| {
            b.amt58.switches_act_at_once = true;
            b.slave.add(FollowsAddress);
        };
};

/// An address at which no slave answers.
const NOBODY: u8 = 127;
