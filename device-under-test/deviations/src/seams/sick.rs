//! The hooks of the encoders of SICK, as the rows of the tables attach to them: of what they share, and of the AFS60 and AFM60.

use encoder_profile::encoder::{Gear, Hardware};
use encoder_profile::profidrive::user_parameters::UserParameterData;
use reference_devices::models::sick::axis::CountedLaps;
use reference_devices::models::sick::hooks::{self, SickHooks, SickSteps};
use reference_devices::models::sick::log::{Log, LogReading};
use reference_devices::models::sick_afx60::Fields;
use reference_devices::models::sick_afx60::hooks::{self as of_afx60, Afx60Hooks, Event, Kept};

hooks! { Sick: SickHooks
    /// Flips a decision: from what it is about and what the encoder has decided.
    check(check: hooks::Check) -> bool;
    /// Changes what the settings of a parameter become, from its number, the encoder and what they were.
    settings(number: u16, hardware: &Hardware, before: &[i64], written: &mut [i64]);
    /// Changes the value of a preset by the button.
    button() -> u32;
    /// Changes the service log that comes from memory at power-up.
    log_loaded(log: &mut Log);
    /// Changes the elements of a service log that is read.
    log(reading: &LogReading) -> [u64; 13];
    /// Changes the laps that come from memory at power-up, from where the encoder stands.
    laps_loaded(now: u64) -> CountedLaps;
}

impl Sick {
    /// Decides about this always so, whatever the manual says.
    pub fn set(&mut self, of: hooks::Check, verdict: bool) {
        self.check(move |check, right| if check == of { verdict } else { right });
    }

    /// Decides whether a setting takes a value, from parameter and subindex, the value and what the encoder has decided.
    pub fn setting(&mut self, decide: fn((u16, usize), i64, bool) -> bool) {
        self.check(move |check, right| match check {
            hooks::Check::Setting(at, value) => decide(at, value, right),
            _ => right,
        });
    }

    /// Changes each setting that gets another value, from parameter and subindex, the value and the encoder.
    pub fn written(&mut self, change: fn((u16, usize), i64, &Hardware) -> i64) {
        self.settings(move |number, hardware, before, written| {
            for (at, (before, value)) in before.iter().zip(written).enumerate() {
                if *before != *value {
                    *value = change((number, at), *value, hardware);
                }
            }
        });
    }

    /// Decides whether a round axis can have a range, from the range, the units per revolution and what the encoder has decided.
    pub fn axis_range(&mut self, decide: fn(u64, u64, bool) -> bool) {
        self.check(move |check, right| match check {
            hooks::Check::RoundAxisRange { range, units_per_revolution } => decide(range, units_per_revolution, right),
            _ => right,
        });
    }

    /// Changes one element of a service log that is read, from the log and its elements.
    pub fn log_element(&mut self, at: usize, change: fn(&LogReading, &[u64; 13]) -> u64) {
        self.log(move |reading, mut elements| {
            elements[at] = change(reading, &elements);
            elements
        });
    }
}

hooks! { SickAxis: SickSteps
    /// Changes the gear by which the round axis counts positions.
    gear(user: &UserParameterData, hardware: &Hardware) -> Gear;
}

hooks! { Afx60: Afx60Hooks
    /// Flips a decision: from what it is about and what the encoder has decided.
    check(check: of_afx60::Check) -> bool;
    /// Changes what is kept over an event, from what was there before.
    kept(event: Event, before: &Kept) -> Kept;
    /// Changes the record of the vendor as it arrives in a start.
    start_record() -> Fields;
}

impl Afx60 {
    /// Decides about this always so, whatever the manual says.
    pub fn set(&mut self, of: of_afx60::Check, verdict: bool) {
        self.check(move |check, right| if check == of { verdict } else { right });
    }

    /// Changes what is kept over this event, from what was there before.
    pub fn over(&mut self, of: Event, change: fn(&Kept, Kept) -> Kept) {
        self.kept(move |event, before, right| if event == of { change(before, right) } else { right });
    }
}
