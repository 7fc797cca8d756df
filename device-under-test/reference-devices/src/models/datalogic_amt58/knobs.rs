//! Where bugs can be put into what is these encoders' own.

use super::lights::{self, Lamps, Situation};
use super::preset::{self, Order, Trigger, Wanted};
use super::program::{self, CLASS_2, EXTENDED, OCTETS, Program, SCALING, Scales, VELOCITY};
use super::told::{self, Shown};
use alloc::vec::Vec;
use core::time::Duration;
use device_stack::profibus::DiagnosisBits;
use encoder_profile::encoder::{Hardware, Scaling, Unit};
use wire::profibus::cfg::Sums;

/// What the switches say and what the bus has given.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Switches {
    /// Switches 1 to 7 as a number.
    pub address: u8,
    /// Whether the eighth is on.
    pub eighth: bool,
    /// The address that the bus has given.
    pub given: Option<u8>,
}

/// What becomes of the offset of a preset.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Storing {
    /// It is stored at once.
    AtOnce,
    /// It is stored after this time.
    After(Duration),
    /// It is not stored.
    Never,
}

/// The position and the place of the shaft when the supply went, and those of now.
#[derive(Clone, Copy, Debug)]
pub struct PowerUp {
    /// The offset in memory.
    pub offset: i64,
    /// Hardware steps from the place at which the supply went to the place now.
    pub moved: i64,
    /// The place now.
    pub place: u64,
}

/// The own part of a behaviour.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// The hardware, from what it is.
    pub hardware: fn(Hardware) -> Hardware,
    /// Whether user octets of this length are taken.
    pub takes_length: fn(usize) -> bool,
    /// Whether octets that are missing are those of the parameters before, and not 0.
    pub fills_from_before: bool,
    /// Whether octets are taken, those of the scaling and of the unit apart.
    pub takes_octets: fn(&[u8; OCTETS]) -> bool,
    /// Whether scaling acts, from the operating bits.
    pub scales: fn(u8) -> bool,
    /// Whether the diagnosis is extended, from the operating bits.
    pub is_extended: fn(u8) -> bool,
    /// Whether the velocity is exchanged, from the operating bits and the code of the unit.
    pub has_velocity: fn(u8, u8) -> bool,
    /// The scaling in force, from what was sent.
    pub clamped: fn(Scaling, &Hardware) -> Scaling,
    /// Whether a scaling is taken.
    pub takes_scaling: fn(&Scales) -> bool,
    /// Whether a scaling is looked at, by whether it acts and by all 14 user octets.
    pub checks_scaling: fn(bool, &[u8; OCTETS]) -> bool,
    /// Whether a scaling stops the device until the supply goes off.
    pub stops_at: fn(&Scaling) -> bool,
    /// The unit of a code; none is refused.
    pub unit: fn(u8) -> Option<Unit>,
    /// Whether the code of the unit is looked at, by whether there is a velocity.
    pub checks_unit: fn(bool) -> bool,
    /// The program in force, from what was understood and from the first one that was ever taken.
    pub in_force: fn(Program, Option<&Program>) -> Program,
    /// The scaling by which the velocity is counted.
    pub scaling_of_velocity: fn(&Program, &Hardware) -> Scaling,
    /// Whether identifiers are taken, from what is right.
    pub takes_configuration: fn(&Program, &[u8], Option<Sums>) -> Option<Sums>,
    /// The identifiers that Get_Cfg tells.
    pub configuration: fn(&Program) -> &'static [u8],
    /// What the outputs of a cycle ask for.
    pub order: fn(&mut Trigger, u32, &Program) -> Order,
    /// The outputs of a cycle, from the octets that came.
    pub outputs: fn([u8; 4]) -> u32,
    /// The value of a preset, from what is wanted; none carries out nothing.
    pub takes_preset: fn(&Wanted) -> Option<u64>,
    /// How old the place is from which an offset is computed.
    pub preset_delay: Duration,
    /// What the offset of a preset is, from what it should be, the offset before, and whether it is the first one since the
    /// scaling has changed.
    pub offset: fn(i64, i64, bool) -> i64,
    /// The offset in force, from the one in memory, whether the shaft has moved since the preset, and the program.
    pub acts: fn(i64, bool, &Program) -> i64,
    /// What becomes of the offset.
    pub storing: Storing,
    /// The offset after parameters were taken.
    pub offset_at_start: fn(i64) -> i64,
    /// A preset that parameters make.
    pub preset_at_start: fn(&Program) -> Option<u32>,
    /// Whether each class has an offset of its own.
    pub offset_per_class: bool,
    /// Whether outputs that come before the exchange of data count as cycles.
    pub outputs_before_exchange_count: bool,
    /// Whether outputs that were there at the end of an exchange make their preset when the next one begins.
    pub keeps_outputs: bool,
    /// The offset and by how many hardware steps the place is shifted after power-up.
    pub at_power_up: fn(&PowerUp) -> (i64, i64),
    /// Puts the inputs together.
    pub inputs: fn(&Shown, &mut [u8]),
    /// The offset that the diagnosis shows, from the one in force and the number of presets since power-up.
    pub shown_offset: fn(i64, u32) -> i64,
    /// Changes the octets behind the six of the diagnosis and the bits that belong to them.
    pub diagnosis: fn(&Told, &mut Vec<u8>, &mut DiagnosisBits),
    /// Whether the shaft is in the red zone, as the LEDs show it.
    pub is_in_zone: fn(&Zone) -> bool,
    /// What the LEDs show.
    pub lamps: fn(&Situation) -> Lamps,
    /// Whether the memory is looked at when the supply comes.
    pub checks_memory: bool,
    /// The address, from switches and memory.
    pub address: fn(Switches) -> u8,
    /// Whether the bus may give an address.
    pub takes_address: fn(Switches) -> bool,
    /// What is stored of an address that the bus gives, and of whether it is final.
    pub stores_address: fn(u8, bool) -> Option<u8>,
    /// Whether an address cannot be changed again, from whether the bus has said so.
    pub locks_address: fn(bool) -> bool,
    /// Whether switches act at once, and not only when the supply comes.
    pub switches_act_at_once: bool,
}

/// What the diagnosis is told from.
#[derive(Clone, Copy, Debug)]
pub struct Told<'a> {
    /// The program in force.
    pub program: &'a Program,
    /// The hardware.
    pub hardware: &'a Hardware,
    /// Whether the memory could not be read.
    pub is_unreadable: bool,
    /// Whether the shaft is in the red zone.
    pub is_in_zone: bool,
    /// The offset of all presets.
    pub offset: i64,
    /// The value of the last preset.
    pub last_preset: u32,
    /// How often the supply has come.
    pub power_ups: u32,
}

/// Where the shaft is, to be compared with the red zone.
#[derive(Clone, Copy, Debug)]
pub struct Zone<'a> {
    /// The program in force.
    pub program: &'a Program,
    /// The hardware.
    pub hardware: &'a Hardware,
    /// The place, counted in the direction in force.
    pub place: u64,
    /// The position that is shown.
    pub position: u64,
}

/// Whether all of `wanted` is set.
pub fn has(bits: u8, wanted: u8) -> bool {
    bits & wanted == wanted
}

impl Default for Rules {
    fn default() -> Rules {
        Rules {
            hardware: |hardware| hardware,
            takes_length: |length| length == program::OCTETS,
            fills_from_before: false,
            takes_octets: |_| true,
            scales: |bits| has(bits, CLASS_2 | SCALING),
            is_extended: |bits| has(bits, CLASS_2 | EXTENDED),
            has_velocity: |bits, _| has(bits, CLASS_2 | VELOCITY),
            clamped: program::clamped,
            takes_scaling: |scales| program::is_possible(&scales.clamped, &scales.hardware),
            checks_scaling: |acts, _| acts,
            stops_at: |_| false,
            unit: program::unit,
            checks_unit: |has_velocity| has_velocity,
            in_force: |program, _| program,
            scaling_of_velocity: |program, _| program.scaling,
            takes_configuration: |_, _, right| right,
            configuration: Program::identifiers,
            order: |trigger, outputs, _| preset::order(trigger, outputs),
            outputs: u32::from_be_bytes,
            takes_preset: preset::taken,
            preset_delay: Duration::ZERO,
            offset: |right, _, _| right,
            acts: |offset, _, _| offset,
            storing: Storing::AtOnce,
            offset_at_start: |offset| offset,
            preset_at_start: |_| None,
            offset_per_class: false,
            outputs_before_exchange_count: false,
            keeps_outputs: false,
            at_power_up: |found| (found.offset, 0),
            inputs: told::inputs,
            shown_offset: |offset, _| offset,
            diagnosis: |_, _, _| {},
            is_in_zone: program::is_in_zone,
            lamps: lights::lamps,
            checks_memory: true,
            address: super::switches::address,
            takes_address: super::switches::takes_address,
            stores_address: |address, _| Some(address),
            locks_address: |_| false,
            switches_act_at_once: false,
        }
    }
}
