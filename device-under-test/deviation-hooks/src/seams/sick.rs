//! Deviations at the hooks of the SICK encoders: of the parts that they share, and of the AFS60 and AFM60.

use core::time::Duration;
use encoder_profile::encoder::{Gear, Hardware};
use encoder_profile::profidrive::user_parameters::UserParameterData;
use reference_devices::models::sick::axis::CountedLaps;
use reference_devices::models::sick::hooks::{self, SickHooks, SickSteps};
use reference_devices::models::sick::log::{Log, LogReading};
use reference_devices::models::sick_afx60::hooks::{
    self as of_afx60, Afx60Event, Afx60Hooks, MeasuredSupply, RetainedVendorData,
};
use reference_devices::models::sick_afx60::{ServiceLog, StartRecordFields};
use station::Time;

hooks! { Sick: SickHooks
    /// Changes a decision, given the check and the decision of the encoder.
    check(check: hooks::SickCheck) -> bool;
    /// Changes the settings that a parameter write results in, given the parameter number, the encoder and the previous settings.
    settings(number: u16, hardware: &Hardware, before: &[i64], written: &mut [i64]);
    /// Changes the value of a preset by the button.
    button() -> u32;
    /// Changes the service log that is restored at power-up.
    log_loaded(log: &mut Log);
    /// Changes how many turns the log counts, given whether one of them begins.
    turns(begins: bool) -> u32;
    /// Changes the elements of the service log as they are read.
    log(reading: &LogReading) -> [u64; 13];
    /// Changes the laps that are restored at power-up, given the shaft position.
    laps_loaded(now: u64) -> CountedLaps;
}

impl Sick {
    /// Fixes the result of a check, whatever the manual says.
    pub fn set(&mut self, of: hooks::SickCheck, verdict: bool) {
        self.check(move |check, right| if check == of { verdict } else { right });
    }

    /// Changes whether a setting accepts a value, given parameter and subindex, the value and the decision of the encoder.
    pub fn setting(&mut self, decide: fn((u16, usize), i64, bool) -> bool) {
        self.check(move |check, right| match check {
            hooks::SickCheck::Setting(at, value) => decide(at, value, right),
            _ => right,
        });
    }

    /// Changes each setting whose value changes, given parameter and subindex, the value and the encoder.
    pub fn written(&mut self, change: fn((u16, usize), i64, &Hardware) -> i64) {
        self.settings(move |number, hardware, before, written| {
            for (at, (before, value)) in before.iter().zip(written).enumerate() {
                if *before != *value {
                    *value = change((number, at), *value, hardware);
                }
            }
        });
    }

    /// Changes whether a round axis can have a range, given the range, the units per revolution and the decision of the encoder.
    pub fn axis_range(&mut self, decide: fn(u64, u64, bool) -> bool) {
        self.check(move |check, right| match check {
            hooks::SickCheck::RoundAxisRange { range, units_per_revolution } => {
                decide(range, units_per_revolution, right)
            }
            _ => right,
        });
    }

    /// Changes one element of the service log as it is read, given the log and its elements.
    pub fn log_element(&mut self, at: usize, change: fn(&LogReading, &[u64; 13]) -> u64) {
        self.log(move |reading, mut elements| {
            elements[at] = change(reading, &elements);
            elements
        });
    }
}

hooks! { SickAxis: SickSteps
    /// Changes the gear of the round axis.
    gear(user: &UserParameterData, hardware: &Hardware) -> Gear;
}

hooks! { Afx60: Afx60Hooks
    /// Changes a decision, given the check and the decision of the encoder.
    check(check: of_afx60::Afx60Check) -> bool;
    /// Changes the data retained at an event, given the data before the event.
    kept(event: Afx60Event, before: &RetainedVendorData) -> RetainedVendorData;
    /// Changes the supply voltage and the temperature that the encoder measures.
    measured(now: Time) -> MeasuredSupply;
    /// Changes how long a save takes.
    save_takes() -> Duration;
    /// Is called when the service log has been updated.
    logged(now: Time, log: &ServiceLog);
    /// Changes the vendor record as it arrives during start-up.
    start_record() -> StartRecordFields;
}

impl Afx60 {
    /// Fixes the result of a check, whatever the manual says.
    pub fn set(&mut self, of: of_afx60::Afx60Check, verdict: bool) {
        self.check(move |check, right| if check == of { verdict } else { right });
    }

    /// Changes the data retained at this event, given the data before the event.
    pub fn at_event(
        &mut self,
        of: Afx60Event,
        change: fn(&RetainedVendorData, RetainedVendorData) -> RetainedVendorData,
    ) {
        self.kept(move |event, before, right| if event == of { change(before, right) } else { right });
    }
}
