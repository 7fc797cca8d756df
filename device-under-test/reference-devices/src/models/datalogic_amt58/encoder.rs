//! The encoder at work: what it stores, what it holds while it has power, how it measures and makes presets.

use super::knobs::{Rules, Storing, Switches, Zone};
use super::lights::{DARK, Lamps, Situation};
use super::preset::{Order, Trigger, Wanted};
use super::program::{self, Program};
use core::time::Duration;
use device_stack::profibus::{Identity, Seen};
use encoder_profile::behaviour::Behaviour;
use encoder_profile::encoder::{Cell, Direction, Hardware, Measuring, PresetMode, Shaft, Velocity};
use station::Time;

/// From one velocity to the next; invented.
const WINDOW: Duration = Duration::from_millis(50);

/// An AMT58 behind its slave.
pub struct Amt58 {
    pub(super) identity: Identity,
    pub(super) behaviour: Behaviour,
    pub(super) rules: Rules,
    pub(super) hardware: Hardware,
    /// The hardware that the shaft really has.
    pub(super) physical: Hardware,
    pub(super) shaft: Shaft,
    pub(super) address_switches: u8,
    pub(super) eighth_switch: bool,
    pub(super) has_broken_memory: bool,
    pub(super) offset: Cell<i64>,
    pub(super) address: Cell<Option<u8>>,
    pub(super) is_address_final: bool,
    /// The place of the shaft when the supply went.
    pub(super) place_at_power_down: u64,
    pub(super) power_ups: u32,
    /// The first program that was ever taken.
    pub(super) first: Option<Program>,
    pub(super) ram: Ram,
    /// What the LEDs show to who looks at them.
    pub(super) shown: Lamps,
}

/// What is lost without power.
pub(super) struct Ram {
    pub(super) switches: (u8, bool),
    pub(super) program: Program,
    pub(super) measuring: Measuring,
    pub(super) velocity: Velocity,
    /// By how many steps of the hardware the place is taken for another one.
    pub(super) shift: i64,
    pub(super) trigger: Trigger,
    pub(super) offset: i64,
    pub(super) offset_before: i64,
    pub(super) place_of_preset: u64,
    /// Whether no preset was made since the last parameters.
    pub(super) is_first_preset: bool,
    pub(super) is_preset: bool,
    pub(super) last_preset: u32,
    pub(super) offsets: [i64; 3],
    pub(super) is_unreadable: bool,
    pub(super) is_stuck: bool,
    pub(super) expired: Option<Time>,
    pub(super) is_invalid: bool,
    pub(super) was_invalid: bool,
    pub(super) is_invalid_with_zone: bool,
    pub(super) inputs: [u8; 8],
    pub(super) truth: (u32, i32),
    pub(super) outputs: [u32; 2],
    pub(super) inputs_given: u32,
}

impl Amt58 {
    /// An encoder with its shaft at `shaft` and its switches at `address`.
    pub fn new(physical: Hardware, behaviour: Behaviour, rules: Rules, shaft: u64, address: u8) -> Amt58 {
        let hardware = (rules.hardware)(physical);
        let shaft = Shaft::new(physical.steps_per_revolution, shaft as i64);
        let ram = Ram::new(Time::ZERO, hardware, &shaft, &behaviour, (address, false));
        Amt58 {
            identity: super::identity(),
            behaviour,
            rules,
            hardware,
            physical,
            shaft,
            address_switches: address,
            eighth_switch: false,
            has_broken_memory: false,
            offset: Cell::new(0),
            address: Cell::new(None),
            is_address_final: false,
            place_at_power_down: 0,
            power_ups: 0,
            first: None,
            ram,
            shown: DARK,
        }
    }

    pub(super) fn rules(&self) -> &Rules {
        &self.rules
    }

    pub(super) fn switches(&self) -> Switches {
        let (address, eighth) = match self.rules().switches_act_at_once {
            true => (self.address_switches, self.eighth_switch),
            false => self.ram.switches,
        };
        Switches { address, eighth, given: *self.address.stored() }
    }

    pub(super) fn place(&self, now: Time) -> u64 {
        self.hardware.sense(self.shaft.place(now).saturating_add(self.ram.shift))
    }

    pub(super) fn sample(&mut self, now: Time) {
        let place = self.place(now);
        self.ram.velocity.advance(now, &self.shaft);
        self.ram.measuring.sample(place);
        self.use_offset(place);
    }

    /// Lets the offset act on positions.
    pub(super) fn use_offset(&mut self, place: u64) {
        let has_moved = place != self.ram.place_of_preset;
        let offset = (self.rules.acts)(self.ram.offset, has_moved, &self.ram.program);
        let range = i64::try_from(self.ram.measuring.range().max(1)).unwrap_or(i64::MAX);
        self.ram.measuring.offset = offset.rem_euclid(range) as u64;
    }

    pub(super) fn preset(&mut self, now: Time, value: u32) {
        let rules = self.rules;
        let is_moving = self.shaft.is_moving(now);
        let Ram { program, trigger, .. } = &self.ram;
        let range = self.ram.measuring.range();
        let presets = trigger.presets;
        let wanted = Wanted { value, range, program, hardware: &self.hardware, is_moving, presets };
        let Some(value) = (rules.takes_preset)(&wanted) else { return };
        let mut measuring = self.ram.measuring.clone();
        if !rules.preset_delay.is_zero() {
            measuring.put(self.place(now - rules.preset_delay));
        }
        let right = value as i64 - measuring.position() as i64;
        let on_circle = measuring.preset(PresetMode::Absolute, value);
        let is_right = i128::from(right).rem_euclid(i128::from(range.max(1))) == i128::from(on_circle);
        let right = if is_right { right } else { on_circle as i64 };
        let ram = &mut self.ram;
        let offset = (rules.offset)(right, ram.offset, ram.is_first_preset);
        (ram.is_preset, ram.last_preset) = (true, value as u32);
        (ram.offset_before, ram.offset) = (ram.offset, offset);
        (ram.is_first_preset, ram.trigger.presets) = (false, ram.trigger.presets.saturating_add(1));
        self.ram.place_of_preset = self.place(now);
        self.store_offset(now);
    }

    pub(super) fn store_offset(&mut self, now: Time) {
        match self.rules().storing {
            Storing::AtOnce => self.offset.replace(self.ram.offset),
            Storing::After(time) => self.offset.write(now, self.ram.offset, time),
            Storing::Never => {}
        }
    }

    pub(super) fn take_outputs(&mut self, now: Time, octets: [u8; 4]) {
        let outputs = (self.rules().outputs)(octets);
        let order = self.rules().order;
        let Ram { trigger, program, .. } = &mut self.ram;
        let order = order(trigger, outputs, program);
        trigger.before = outputs;
        self.ram.outputs = [outputs, self.ram.outputs[0]];
        match order {
            Order::Nothing => {}
            Order::Preset(value) => {
                self.sample(now);
                self.preset(now, value);
            }
            Order::Undo => {
                self.ram.offset = self.ram.offset_before;
                self.store_offset(now);
            }
            Order::Units(units) => {
                self.ram.program.scaling.units_per_revolution = units;
                self.ram.measuring.settings.scaling.units_per_revolution = units;
            }
        }
    }

    /// The place, counted in the direction in force.
    pub(super) fn counted(&self, place: u64) -> u64 {
        match self.ram.program.direction {
            Direction::Clockwise => place,
            Direction::Counterclockwise => self.hardware.range() - 1 - place,
        }
    }

    pub(super) fn is_in_zone(&self, now: Time) -> bool {
        let place = self.counted(self.place(now));
        let position = self.ram.measuring.shifted();
        let zone = Zone { program: &self.ram.program, hardware: &self.hardware, place, position };
        (self.rules().is_in_zone)(&zone)
    }

    pub(super) fn lamps(&self, now: Time, seen: &Seen) -> Lamps {
        let expired_for = self.ram.expired.map_or(0, |since| now.since(since).as_millis() as u64);
        (self.rules().lamps)(&Situation {
            seen: *seen,
            is_unreadable: self.ram.is_unreadable,
            has_expired: self.ram.expired.is_some(),
            expired_for,
            is_invalid: self.ram.is_invalid,
            was_invalid: self.ram.was_invalid,
            is_invalid_with_zone: self.ram.is_invalid_with_zone,
            is_in_zone: self.is_in_zone(now),
            program: self.ram.program,
            is_multiturn: self.hardware.revolutions > 1,
            has_zone: program::zone(&self.ram.program.scaling, &self.hardware).1 > 0,
        })
    }
}

impl Ram {
    pub(super) fn new(
        now: Time,
        hardware: Hardware,
        shaft: &Shaft,
        behaviour: &Behaviour,
        switches: (u8, bool),
    ) -> Ram {
        let program = Program::unprogrammed(&hardware);
        let place = hardware.sense(shaft.place(now));
        let mut measuring = Measuring::new(hardware, place, behaviour.measuring.clone());
        measuring.settings = program.settings();
        Ram {
            switches,
            program,
            measuring,
            velocity: Velocity::new(WINDOW, program.unit, hardware, now, shaft, behaviour.velocity.clone()),
            shift: 0,
            trigger: Trigger::default(),
            offset: 0,
            offset_before: 0,
            place_of_preset: place,
            is_first_preset: false,
            is_preset: false,
            last_preset: 0,
            offsets: [0; 3],
            is_unreadable: false,
            is_stuck: false,
            expired: None,
            is_invalid: false,
            was_invalid: false,
            is_invalid_with_zone: false,
            inputs: [0; 8],
            truth: (0, 0),
            outputs: [0; 2],
            inputs_given: 0,
        }
    }
}
