//! The hooks of the A3M60: what only this encoder has and a deviation may change. The slave and the encoder object have their own.

use super::State;
use super::clock::{Times, Wrong};
use super::parameters::Speed;
use super::status::Words;
use crate::models::sick::log::Log;
use alloc::vec::Vec;
use core::time::Duration;
use device_stack::Attached;
use encoder_profile::encoder::Measuring;
use encoder_profile::encoder_object::{NonVolatileData, PoweredEncoder};
use encoder_profile::profidrive::telegram::{SignalImage, Telegram};
use station::Time;

/// A decision of the A3M60, with what it is about; the comment says what `true` means.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum A3m60Check {
    /// The user octets of Set_Prm are as many as there have to be.
    UserOctets(usize),
    /// A position can be the mean of so many samples.
    Samples(u8),
    /// A clock with this time from one to the next can be followed.
    Cycle(Duration),
    /// The encoder gets in step with the clock; what was wrong with it has ended.
    Synchronizes(Wrong),
    /// The clock is missing.
    ClockMissing,
    /// The sign of life counts.
    SignOfLife {
        /// Whether operation is isochronous.
        is_isochronous: bool,
        /// What is wrong with the clock.
        wrong: Wrong,
    },
    /// The speed is calculated.
    SpeedCalculated,
    /// The speed is measured from clock to clock.
    SpeedByClock,
    /// The fault of this name is noticed.
    Fault(&'static str),
    /// There is a data set at this index, with the telegram of this number.
    DataSet {
        /// The index.
        index: u8,
        /// The number of the telegram.
        telegram: u16,
        /// Whether it is read, and not written.
        is_read: bool,
    },
    /// The switches may set this address.
    Address(u32),
    /// The bus is terminated with both switches in these positions.
    Terminated([u32; 2]),
    /// The supply of so many millivolts is enough.
    Supply(u64),
}

/// The hooks of an A3M60; each default changes nothing. The encoder is passed for reading only.
#[allow(unused_variables, reason = "the names say what a hook is given")]
pub trait A3m60Hooks {
    /// The decision that counts, from what it is about and the decision of the manual.
    fn check(&mut self, check: A3m60Check, verdict: bool) -> bool {
        verdict
    }

    /// The positions of the hexadecimal and the decimal address switch, as they are read.
    fn switches(&mut self, set: [u32; 2]) -> [u32; 2] {
        set
    }

    /// Where the shaft is by the sensor, in steps over all revolutions.
    fn place(&mut self, encoder: &PoweredEncoder<'_, State>, place: i64) -> i64 {
        place
    }

    /// The times that isochronous operation begins with; none without it.
    fn times(&mut self, times: Option<Times>) -> Option<Times> {
        times
    }

    /// S_STAT-A and S_STAT-B, from which everything follows that reports an error.
    fn status(&mut self, encoder: &PoweredEncoder<'_, State>, words: Words) -> Words {
        words
    }

    /// The numbers of the blocks of the diagnosis.
    fn diagnosis(&mut self, encoder: &PoweredEncoder<'_, State>, numbers: Vec<u8>) -> Vec<u8> {
        numbers
    }

    /// The code in place of the position in the telegrams of the vendor; none without an error.
    fn fault_code(&mut self, encoder: &PoweredEncoder<'_, State>, code: Option<i32>) -> Option<i32> {
        code
    }

    /// The signals of a frame.
    fn image(&mut self, encoder: &PoweredEncoder<'_, State>, image: SignalImage) -> SignalImage {
        image
    }

    /// Changes what is written to a parameter of the vendor, or what of it stays in memory.
    fn write(&mut self, write: &mut Write, memory: &mut Memory<'_>) {}

    /// Changes what is in memory when something happens.
    fn happens(&mut self, event: Event, memory: &mut Memory<'_>) {}
}

/// A write to a parameter.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Write {
    /// The number of the parameter.
    pub number: u16,
    /// The first element.
    pub subindex: u16,
    /// The values of the elements.
    pub values: Vec<u64>,
}

/// Something that happens to the encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Event {
    /// The supply has come; what is stored was read.
    PowerUp,
    /// The supply goes.
    PowerDown,
    /// An exchange of data begins.
    Start,
    /// Time has passed.
    Advance,
}

/// What the encoder stores, and what of it is in use.
pub struct Memory<'a> {
    /// Now.
    pub now: Time,
    /// The telegram in use.
    pub telegram: &'static Telegram,
    /// What is stored.
    pub store: &'a mut NonVolatileData,
    /// P65000.
    pub preset_value: &'a mut u32,
    /// The measuring task with the offset of all presets.
    pub measuring: &'a mut Measuring,
    /// The service log.
    pub log: &'a mut Log,
    /// P1008.
    pub speed: &'a mut Speed,
}

impl core::fmt::Debug for Memory<'_> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Memory").field("now", &self.now).finish_non_exhaustive()
    }
}

impl<'a> Memory<'a> {
    fn of(live: &'a mut PoweredEncoder<'_, State>) -> Memory<'a> {
        Memory {
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
pub struct Hooks(pub Attached<dyn A3m60Hooks>);

impl Hooks {
    /// The decision that counts: `verdict`, unless a deviation flips it.
    #[inline]
    pub fn check(&self, check: A3m60Check, verdict: bool) -> bool {
        self.0.apply(verdict, |hooks, verdict| hooks.check(check, verdict))
    }
}

/// Reports an event.
pub(super) fn report(live: &mut PoweredEncoder<'_, State>, event: Event) {
    let hooks = live.model.hooks.clone();
    hooks.0.notify(|hooks| hooks.happens(event, &mut Memory::of(live)));
}

/// What is written to a parameter in the end.
pub(super) fn written(live: &mut PoweredEncoder<'_, State>, number: u16, subindex: u16, values: &[u64]) -> Write {
    let hooks = live.model.hooks.clone();
    hooks.0.apply(Write { number, subindex, values: values.to_vec() }, |hooks, mut write| {
        hooks.write(&mut write, &mut Memory::of(live));
        write
    })
}
