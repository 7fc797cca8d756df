//! The hooks of the A3M60, with which a deviation can change the parts that only this encoder has. The slave and the encoder object
//! have their own hooks.

use super::A3m60State;
use super::clock::{ClockErrors, IsochronousTimes};
use super::parameters::SpeedCalculation;
use super::set_prm::UserByteFields;
use super::status::SensorStatusWords;
use crate::models::sick::log::Log;
use alloc::vec::Vec;
use core::time::Duration;
use device_stack::Attached;
use encoder_profile::encoder::Measuring;
use encoder_profile::encoder_object::{NonVolatileData, PoweredEncoder};
use encoder_profile::profidrive::telegram::{SignalImage, Telegram};
use station::Time;

/// A decision of the A3M60 with its data; each comment describes `true`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum A3m60Check {
    /// The number of user bytes in Set_Prm is right.
    UserOctets(usize),
    /// A position can be the mean of this number of samples.
    Samples(u8),
    /// This cycle time of the clock is permitted.
    Cycle(Duration),
    /// The encoder synchronizes with the clock, which had these errors.
    Synchronizes(ClockErrors),
    /// The clock is missing.
    ClockMissing,
    /// The sign of life counts.
    SignOfLife {
        /// Whether operation is isochronous.
        is_isochronous: bool,
        /// The errors of the clock.
        wrong: ClockErrors,
    },
    /// The speed is calculated.
    SpeedCalculated,
    /// The speed is measured from clock to clock.
    SpeedByClock,
    /// The fault of this name is present and detected.
    Fault(&'static str),
    /// This data set exists with this telegram.
    DataSet {
        /// The index of the data set.
        index: u8,
        /// The number of the telegram.
        telegram: u16,
        /// Whether the data set is read, not written.
        is_read: bool,
    },
    /// The switches can set this address.
    Address(u32),
    /// The bus is terminated with the termination switches in these positions.
    Terminated([u32; 2]),
    /// This supply voltage in millivolts is high enough.
    Supply(u64),
}

/// The hooks of an A3M60. The default implementations change nothing. The encoder is passed read-only.
#[allow(unused_variables, reason = "the names say what a hook is given")]
pub trait A3m60Hooks {
    /// Returns the decision to use, given the check and the decision of the manual.
    fn check(&mut self, check: A3m60Check, verdict: bool) -> bool {
        verdict
    }

    /// Returns the settings in force after a Set_Prm without user bytes, given those of the manual.
    fn delivered(&mut self, fields: UserByteFields) -> UserByteFields {
        fields
    }

    /// Returns the positions of the hexadecimal and the decimal address switch as they are read.
    fn switches(&mut self, set: [u32; 2]) -> [u32; 2] {
        set
    }

    /// Returns the shaft position that the sensor reads, in steps over all revolutions.
    fn place(&mut self, encoder: &PoweredEncoder<'_, A3m60State>, place: i64) -> i64 {
        place
    }

    /// Returns the times with which isochronous operation begins; `None` without it.
    fn times(&mut self, times: Option<IsochronousTimes>) -> Option<IsochronousTimes> {
        times
    }

    /// Returns S_STAT-A and S_STAT-B, from which every error report is derived.
    fn status(&mut self, encoder: &PoweredEncoder<'_, A3m60State>, words: SensorStatusWords) -> SensorStatusWords {
        words
    }

    /// Returns the error numbers of the diagnosis blocks.
    fn diagnosis(&mut self, encoder: &PoweredEncoder<'_, A3m60State>, numbers: Vec<u8>) -> Vec<u8> {
        numbers
    }

    /// Returns the fault code that replaces the position in the vendor telegrams; `None` without an error.
    fn fault_code(&mut self, encoder: &PoweredEncoder<'_, A3m60State>, code: Option<i32>) -> Option<i32> {
        code
    }

    /// Returns the signals of a frame.
    fn image(&mut self, encoder: &PoweredEncoder<'_, A3m60State>, image: SignalImage) -> SignalImage {
        image
    }

    /// Changes a write to a vendor parameter, or its effect on the memory.
    fn write(&mut self, write: &mut VendorWrite, memory: &mut A3m60Memory<'_>) {}

    /// Changes the contents of the memory at an event.
    fn happens(&mut self, event: A3m60Event, memory: &mut A3m60Memory<'_>) {}
}

/// A write to a parameter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VendorWrite {
    /// The number of the parameter.
    pub number: u16,
    /// The first element.
    pub subindex: u16,
    /// The values of the elements.
    pub values: Vec<u64>,
}

/// An event of the encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum A3m60Event {
    /// Power-up, after the stored data have been read.
    PowerUp,
    /// Power-down.
    PowerDown,
    /// A data exchange begins.
    Start,
    /// Time has passed.
    Advance,
}

/// The stored data of the encoder, and those in use.
pub struct A3m60Memory<'a> {
    /// The time of the event.
    pub now: Time,
    /// The telegram in use.
    pub telegram: &'static Telegram,
    /// The stored data.
    pub store: &'a mut NonVolatileData,
    /// P65000 in use.
    pub preset_value: &'a mut u32,
    /// The measuring task with the preset offset.
    pub measuring: &'a mut Measuring,
    /// The service log.
    pub log: &'a mut Log,
    /// P1008, the speed calculation.
    pub speed: &'a mut SpeedCalculation,
}

impl core::fmt::Debug for A3m60Memory<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Memory").field("now", &self.now).finish_non_exhaustive()
    }
}

impl<'a> A3m60Memory<'a> {
    fn of(live: &'a mut PoweredEncoder<'_, A3m60State>) -> A3m60Memory<'a> {
        A3m60Memory {
            now: live.now,
            telegram: live.ram.telegram(),
            store: live.store,
            preset_value: &mut live.ram.preset_value,
            measuring: &mut live.ram.measuring,
            log: &mut live.model.log,
            speed: &mut live.model.speed,
        }
    }
}

/// The deviations attached to one encoder.
#[derive(Clone, Debug, Default)]
pub struct A3m60Deviations(pub Attached<dyn A3m60Hooks>);

impl A3m60Deviations {
    /// Returns `verdict`, unless a deviation changes it.
    #[inline]
    pub fn check(&self, check: A3m60Check, verdict: bool) -> bool {
        self.0.apply(verdict, |hooks, verdict| hooks.check(check, verdict))
    }
}

/// Passes an event to the deviations.
pub(super) fn report(live: &mut PoweredEncoder<'_, A3m60State>, event: A3m60Event) {
    let hooks = live.model.hooks.clone();
    hooks.0.notify(|hooks| hooks.happens(event, &mut A3m60Memory::of(live)));
}

/// Passes a parameter write to the deviations and returns the write to carry out.
pub(super) fn written(
    live: &mut PoweredEncoder<'_, A3m60State>,
    number: u16,
    subindex: u16,
    values: &[u64],
) -> VendorWrite {
    let hooks = live.model.hooks.clone();
    hooks.0.apply(VendorWrite { number, subindex, values: values.to_vec() }, |hooks, mut write| {
        hooks.write(&mut write, &mut A3m60Memory::of(live));
        write
    })
}
