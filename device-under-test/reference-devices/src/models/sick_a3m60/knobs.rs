//! Where bugs can be put into what is the own of the A3M60.

pub use super::clock::Times;
use super::clock::Wrong;
use super::samples;
pub use super::start::{Brought, Fields, OCTETS};
use super::station::LOWEST_VOLTAGE;
pub use super::station::address;
use super::status;
pub use super::status::{Causes, Words};
use crate::models::sick::{self, log::Log};
use alloc::vec::Vec;
use core::time::Duration;
use encoder_profile::encoder::{Hardware, Settings, Unit};
use encoder_profile::encoder_object::{Ram, Store};
use encoder_profile::profidrive::telegram::{Image, Telegram};
use station::Time;

/// What the status is shown from.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    /// What is wrong now.
    pub words: Words,
    /// What was wrong since the connection began.
    pub seen: Words,
    /// What was wrong when the connection began.
    pub at_start: Words,
    /// The value of the last absolute preset.
    pub last_preset: u64,
    /// Whether several causes were there at once since power-up.
    pub had_several: bool,
    /// What the start has brought.
    pub fields: Fields,
    /// Whether operation is isochronous.
    pub is_isochronous: bool,
    /// Whether data are exchanged by a telegram of the vendor.
    pub is_of_vendor: bool,
    /// Whether data are exchanged.
    pub is_connected: bool,
    /// Milliseconds since power-up.
    pub powered: u64,
}

/// What a time stamp could be made of.
#[derive(Clone, Copy, Debug)]
pub struct Seconds {
    /// Milliseconds since power-up.
    pub powered: u64,
    /// Milliseconds since the connection began.
    pub connected: u64,
    /// Milliseconds of motion since power-up.
    pub moved: u64,
    /// Milliseconds of supply since delivery.
    pub operated: u64,
    /// Milliseconds without an error since power-up.
    pub healthy: u64,
    /// Milliseconds since the last preset, or since power-up.
    pub preset: u64,
}

/// How a preset was asked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// By bit 31 of a telegram of the vendor.
    Word,
    /// By G1_STW.
    Request,
    /// By the button.
    Button,
}

/// A preset that is asked for.
#[derive(Clone, Copy, Debug)]
pub struct AskedPreset {
    /// How it was asked for.
    pub origin: Origin,
    /// How many were asked for by G1_STW since power-up.
    pub count: u32,
    /// Whether the position is asked for in G1_XIST2.
    pub is_transferred: bool,
}

/// The own part of a behaviour.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    // Start
    /// How the fields of Set_Prm are understood.
    pub understands: fn(Fields) -> Fields,
    /// Whether parameters are taken, from whether they are right.
    pub judges: fn(bool, &Fields) -> bool,
    /// Whether a number of samples is taken, from whether it is right.
    pub judges_samples: fn(bool, u8) -> bool,
    /// Whether a cycle of the clock is taken, from whether it is right.
    pub judges_cycle: fn(bool) -> bool,
    /// The user octets that count, from those that came behind the octets of DP-V1; with too few zeros are appended.
    pub octets: fn(Vec<u8>) -> Vec<u8>,
    /// Whether so many user octets are taken.
    pub takes_length: fn(usize) -> bool,
    /// Whether missing user octets are those of the Set_Prm before.
    pub fills_missing: bool,
    /// What a start brings into force, from what was there before.
    pub starts: fn(Brought, Brought) -> Brought,
    /// The module of which Get_Cfg tells.
    pub told_configuration: fn(usize) -> usize,
    /// The module of a configuration, from its octets and the right one by its place among the modules.
    pub configuration: fn(&[u8], Option<usize>) -> Option<usize>,

    // Positions
    /// The position of so many samples, the present one last.
    pub mean: fn(&[i64]) -> i64,
    /// How many samples make a position, from the number that the user has set and whether operation is isochronous.
    pub samples: fn(u8, bool) -> u8,
    /// By how many steps the sensor is beside the place, from the noise.
    pub noise: fn(i64) -> i64,
    /// The signals that are sent, from what is known and those that are right.
    pub image: fn(&Known, Image) -> Image,
    /// Whether a preset by bit 31 is undone when the bit falls.
    pub undoes_presets: bool,
    /// For how long presets wait, each behind the one before.
    pub queues_presets: Option<Duration>,
    /// By how much the place is too old from which a preset is computed.
    pub presets_from_before: Option<Duration>,
    /// The settings in force, from the right ones and whether the telegram is one of the vendor.
    pub settings: fn(Settings, bool, &Hardware) -> Settings,
    /// Whether a preset that was asked for in this way outlasts the power.
    pub keeps_offset: fn(Origin) -> bool,
    /// Whether a preset is carried out.
    pub presets: fn(&AskedPreset) -> bool,
    /// Whether a write to P1007 disturbs the position for a second.
    pub test_disturbs: bool,

    // Status and errors
    /// Whether a fault is noticed, from its name and whether it was there at power-up.
    pub notices: fn(&str, bool) -> bool,
    /// The bit of S_STAT-A for a fault, from its name and the right one.
    pub status_bit: fn(&str, u16) -> u16,
    /// S_STAT-A and S_STAT-B as parameters show them.
    pub words: fn(&Known) -> Words,
    /// The words that the diagnosis tells.
    pub told: fn(&Known) -> Words,
    /// The faults that P65001 shows, from the right ones.
    pub faults: fn(&Known, u64) -> u64,
    /// The warnings that P65001 shows, from the right ones.
    pub warnings: fn(&Known, u64) -> u64,
    /// The octets of the diagnosis behind the six.
    pub blocks: fn(&[u8], &Known) -> Vec<u8>,
    /// Whether Ext_Diag is set, from whether there is an error among what is told.
    pub ext_diag: fn(bool) -> bool,
    /// Whether outputs are taken.
    pub takes_outputs: fn(&Known) -> bool,
    /// Whether a change of the diagnosis is announced, from whether there is one.
    pub announces: fn(bool) -> bool,
    /// Whether fault codes are shown, from what the user has set.
    pub shows_codes: fn(bool) -> bool,
    /// The code of a fault in place of the position, from its name and the right one.
    pub fault_code: fn(&str, i32) -> Option<i32>,
    /// The code in place of the position.
    pub code: fn(&Causes<'_>) -> Option<i32>,
    /// Whether a connection begins with an error of the position.
    pub begins_with_error: bool,

    // Parameters and memory
    /// What writing P971 does, with the value.
    pub saved: fn(u64, &mut Store, &mut Ram),
    /// Whether P65000 is stored when it is written.
    pub stores_preset_value: bool,
    /// Whether P65000 is half stored when the supply goes off in between.
    pub tears_preset_value: bool,
    /// What of P1008 outlasts the power, from the place of its element less 1.
    pub keeps_setting: fn(usize) -> bool,
    /// The element of P1008 that is written, from the right one.
    pub setting: fn(usize) -> usize,
    /// Whether P1008.0 is a switch.
    pub has_hidden_switch: bool,
    /// The elements of P1009 that are shown.
    pub axis: fn([u64; 11]) -> [u64; 11],
    /// The number of the telegram in P922, from that of the start before and the right one.
    pub telegram: fn(u16, u16) -> u16,
    /// What happens to the log at power-up.
    pub log_at_power_up: fn(&mut Log),
    /// Whether each start counts as a power-up.
    pub counts_starts: bool,
    /// Whether identification and sensor format can be written.
    pub constants_are_writable: bool,
    /// Whether there are records with a telegram.
    pub has_parameters: fn(&Telegram) -> bool,
    /// Whether reads are refused with another error while a value is being stored.
    pub is_rude_while_storing: bool,
    /// The slots at which records answer.
    pub has_slot: fn(u8) -> bool,
    /// Whether a record answers at an index.
    pub has_index: fn(u8) -> bool,

    // Speed and time
    /// Whether the speed is calculated, from what the user has set.
    pub measures_speed: fn(bool) -> bool,
    /// Whether the speed is measured with the clock in isochronous operation.
    pub measures_speed_with_clock: bool,
    /// Whether P1008 is used.
    pub speed_is_used: bool,
    /// The unit of the speed in telegrams of the vendor, from that of the parameters.
    pub vendor_unit: fn(Unit) -> Unit,
    /// The seconds of the time stamp.
    pub time_stamp: fn(&Seconds) -> u16,

    // Clock
    /// The times of isochronous operation, from those that came.
    pub times: fn(Option<Times>) -> Option<Times>,
    /// Whether a clock that is right again ends what was wrong.
    pub recovers: fn(Wrong) -> bool,
    /// Whether the encoder ever gets in step with the clock.
    pub synchronizes: bool,
    /// After how many cycles without a clock it is missing; none for never.
    pub misses: fn(u32) -> Option<u32>,
    /// What is wrong with the clock, from the right answer.
    pub wrong: fn(Wrong, Option<Times>) -> Wrong,
    /// When the position is taken that is not taken at the clock.
    pub looks_at: fn(Time) -> Time,
    /// Whether a parameter request makes the clock a missing one.
    pub requests_disturb_clock: bool,
    /// Whether the position is that at the clock.
    pub samples_at_clock: bool,
    /// Whether the sign of life is given, from whether operation is isochronous and in step, and whether the clock is lost.
    pub gives_sign_of_life: fn(bool, bool, bool) -> bool,
    /// Whether the sign of life of the master is watched, from whether operation is isochronous.
    pub watches_master: fn(bool) -> bool,

    // In the hand
    /// What LEDs show when the initialization has failed.
    pub bad_start_light: &'static str,
    /// The lowest supply in millivolts that is enough.
    pub lowest_voltage: u64,
    /// Whether the LED of the encoder is orange, from whether it should be.
    pub is_orange: fn(bool, Words) -> bool,
    /// The address that switches set.
    pub address: fn([u32; 2]) -> Option<u8>,
    /// Whether the switches are looked at all the time.
    pub reads_switches_at_once: bool,
    /// Whether the way of the shaft counts while the inputs are frozen.
    pub measures_while_frozen: bool,
    /// Whether the button works, from whether data are exchanged.
    pub button_works: fn(bool) -> bool,
    /// Whether the button moves G1_XIST1 whatever the preset control says.
    pub button_moves_xist1: bool,
    /// Whether the bus is terminated, from both switches.
    pub terminates: fn([u32; 2]) -> bool,
    /// Whether the bus may give the encoder another address.
    pub takes_address: bool,
}

/// All that a model of it reads: what the encoders of SICK share, and its own.
#[derive(Clone, Copy, Debug, Default)]
pub struct Knobs {
    /// What the encoders of SICK share.
    pub sick: sick::knobs::Rules,
    /// Its own.
    pub own: Rules,
}

impl Default for Rules {
    fn default() -> Rules {
        Rules {
            understands: |fields| fields,
            judges: |right, _| right,
            judges_samples: |right, _| right,
            judges_cycle: |right| right,
            octets: |octets| octets,
            takes_length: |length| length == OCTETS,
            fills_missing: false,
            starts: |_, now| now,
            told_configuration: |module| module,
            configuration: |_, right| right,
            mean: samples::mean,
            samples: |count, is_isochronous| if is_isochronous { 1 } else { count },
            noise: |noise| noise,
            image: |_, right| right,
            undoes_presets: false,
            queues_presets: None,
            presets_from_before: None,
            settings: |right, _, _| right,
            keeps_offset: |_| true,
            presets: |_| true,
            test_disturbs: false,
            notices: |_, _| true,
            status_bit: |_, right| right,
            words: |known| known.words,
            told: |known| known.words,
            faults: |_, right| right,
            warnings: |_, right| right,
            blocks: |numbers, _| status::blocks(numbers),
            ext_diag: |right| right,
            takes_outputs: |_| true,
            announces: |right| right,
            shows_codes: |right| right,
            fault_code: |_, right| Some(right),
            code: |causes| status::code(causes.codes),
            begins_with_error: false,
            saved: |_, _, _| {},
            stores_preset_value: true,
            tears_preset_value: false,
            keeps_setting: |_| false,
            setting: |at| at,
            has_hidden_switch: false,
            axis: |right| right,
            telegram: |_, right| right,
            log_at_power_up: |_| {},
            counts_starts: false,
            constants_are_writable: false,
            has_parameters: |_| true,
            is_rude_while_storing: false,
            has_slot: |slot| slot <= 1,
            has_index: |index| index == 47,
            measures_speed: |right| right,
            measures_speed_with_clock: true,
            speed_is_used: true,
            vendor_unit: |_| Unit::Rpm,
            time_stamp: |seconds| (seconds.powered / 1000) as u16,
            times: |right| right,
            recovers: |_| true,
            synchronizes: true,
            misses: Some,
            wrong: |right, _| right,
            looks_at: |now| now,
            requests_disturb_clock: false,
            samples_at_clock: true,
            gives_sign_of_life: |is_isochronous, is_synchronized, _| is_isochronous && is_synchronized,
            watches_master: |is_isochronous| is_isochronous,
            bad_start_light: "red_green",
            lowest_voltage: LOWEST_VOLTAGE,
            is_orange: |right, _| right,
            address,
            reads_switches_at_once: false,
            measures_while_frozen: true,
            button_works: |_| true,
            button_moves_xist1: false,
            terminates: |switches| switches == [1; 2],
            takes_address: false,
        }
    }
}
