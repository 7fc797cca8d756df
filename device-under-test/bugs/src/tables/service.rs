//! Bugs of the service log and of the sensor status words.

use super::Group;
use crate::needs::Need;
use crate::seams::Deviations;
use reference_devices::manuals;
use reference_devices::models::sick::hooks;
use reference_devices::models::sick::log::Log;
use reference_devices::models::sick_afx60::ServiceLog;
use reference_devices::models::sick_afx60::hooks::{Afx60Check, Afx60Event, RetainedVendorData};

/// The bugs, by what they need.
pub static GROUPS: &[Group] = &[
    Group {
        needs: &[Need::Of(&manuals::SICK_AFX60)],
        deviations: bugs! {
            // P1002 and P1003
            "service-log-cut-short" "The logs have twelve elements."
                => |d| {
                    d.encoder.truncate_elements(1002, 12);
                    d.encoder.truncate_elements(1003, 12);
                };
            "power-ups-not-counted" "Power-ups are not counted."
                => |d| d.sick.log_loaded(|log| log.power_ups -= 1);
            "log-time-in-minutes" "The operating time is counted in minutes."
                => |d| d.sick.log_element(1, |_, log| log[1] / 60);
            "reverse-turns-counted-as-forward" "Reverse turns are also counted as forward turns."
                => |d| d.sick.log_element(3, |_, log| log[3] + log[4]);
            "forward-turns-counted-as-reverse" "Forward turns are also counted as reverse turns."
                => |d| d.sick.log_element(4, |_, log| log[3] + log[4]);
            "starts-counted-for-changes" "Each start of the shaft is counted as a change of direction."
                => |d| d.sick.check(|check, right| match check {
                    hooks::SickCheck::DirectionChange { before, now, .. } => before != now,
                    _ => right,
                });
            "motion-threshold-60" "The time in motion is counted from 60 rpm on."
                => |d| d.sick.check(|check, right| match check {
                    hooks::SickCheck::Motion(rpm) => rpm >= 60,
                    _ => right,
                });
            "speed-for-acceleration" "The acceleration is replaced by the speed."
                => |d| d.sick.log_element(7, |reading, _| reading.rpm.unsigned_abs());
            "led-current-in-milliamperes" "The highest LED current is in milliamperes."
                => |d| d.sick.log_element(8, |_, log| log[8] / 1000);
            "lowest-led-current-0" "The lowest LED current is always 0."
                => |d| d.sick.log_element(9, |_, _| 0);
            "log-voltage-in-millivolts" "The highest voltage is in millivolts."
                => |d| d.sick.log_element(10, |_, log| log[10] * 1000);
            "temperature-extremes-exchanged" "The lowest and the highest temperature are swapped."
                => |d| d.sick.log(|_, mut log| {
                    log.swap(11, 12);
                    log
                });
            "lowest-temperature-clamped" "A lowest temperature below 0 is shown as 0."
                => |d| d.sick.log_element(12, |_, log| if log[12] > i32::MAX as u64 { 0 } else { log[12] });
            "relative-log-in-other-units" "The relative log counts its time in milliseconds."
                => |d| d.sick.log_element(1, |reading, log| match reading.number {
                    1003 => reading.operating.as_millis() as u64,
                    _ => log[1],
                });
            "relative-log-is-the-absolute-one" "The relative log is a copy of the absolute one and cannot be reset."
                => |d| d.afx60.at_event(Afx60Event::LogReset, |before, _| before.clone());
            "reset-clears-both-logs" "A reset of the relative log also resets the absolute one."
                => |d| d.afx60.at_event(Afx60Event::LogReset, |_, mut retained| {
                    retained.log.absolute = retained.log.relative;
                    retained
                });
            "reset-clears-service-log" "The factory reset clears the service log."
                => |d| d.afx60.at_event(Afx60Event::Reset, |_, retained| {
                    let mut log = ServiceLog::default();
                    (log.absolute.log.power_ups, log.relative.log.power_ups) = (0, 0);
                    RetainedVendorData { log, ..retained }
                });

            // P1000 and P1001
            "p1000-always-0" "P1000 is always 0."
                => |d| d.encoder.element(|_, at, right| if at == (1000, 0) { 0 } else { right });
            "sensor-words-exchanged" "Words B and C are swapped."
                => |d| status_words(d, |_, [a, b, c]| [a, c, b]);
            "sensor-bits-one-too-high" "The bits of word A are shifted up by one bit."
                => |d| status_words(d, |_, [a, b, c]| [a << 1, b, c]);
            "reserved-bit-13-with-errors" "Bit 13 of word A is set with a position error."
                => |d| status_words(d, |faults, [a, b, c]| [a | if faults & 1 == 0 { 0 } else { 1 << 13 }, b, c]);
            "memory-areas-exchanged" "The bits of the memory areas are swapped."
                => |d| status_words(d, |_, [a, b, c]| [a, memory_areas_exchanged(b), c]);
            "start-up-warning-left" "Bit 0 of word A is always set."
                => |d| status_words(d, |_, [a, b, c]| [a | 1, b, c]);
            "preset-warning-missing" "Bit 4 of word B is never set."
                => |d| status_words(d, |_, [a, b, c]| [a, b & !0x0010, c]);
            "preset-accepted-never-shown" "Bit 12 of word C is never set."
                => |d| status_words(d, |_, [a, b, c]| [a, b, c & !0x1000]);
            "internal-state-in-reserved-bits" "Bit 0 of word B and bit 5 of word C are always set."
                => |d| status_words(d, |_, [a, b, c]| [a, b | 1, c | 1 << 5]);
            "synchronous-and-free-run" "Bits 15 and 14 of word C are both set."
                => |d| status_words(d, |_, [a, b, c]| [a, b, c | 0xC000]);
            "saving-of-diagnosis-never-ends" "Bits 3 and 2 of word C are always 01."
                => |d| status_words(d, |_, [a, b, c]| [a, b, c & !0x000C | 0x0004]);
            "saved-before-it-is-written" "Word C reports a save as complete as soon as it begins."
                => |d| status_words(d, |_, [a, b, c]| [a, b, if c & 3 == 1 { c & !3 | 2 } else { c }]);
            "save-progress-not-shown" "Bits 1 and 0 of word C are always 0."
                => |d| status_words(d, |_, [a, b, c]| [a, b, c & !3]);

            // P1004
            "occurrences-one-element-lower" "Bit n of word A is counted in element n - 1."
                => |d| counters(d, |mut counters| { counters.rotate_left(1); counters });
            "two-bits-share-a-counter" "Bit 9 of word A is counted in element 8."
                => |d| counters(d, |mut counters| { (counters[8], counters[9]) = (counters[8] + counters[9], 0); counters });
            "reserved-bit-counts-its-neighbour" "Element 13 counts bit 14 of word A."
                => |d| counters(d, |mut counters| { counters[13] = counters[14]; counters });
            "occurrences-0-from-elsewhere" "Element 0 contains unrelated data."
                => |d| counters(d, |mut counters| { counters[0] = 0xA5A5; counters });
            "occurrences-wrap" "The counters wrap to 0 after 255."
                => |d| {
                    d.afx60.check(|check, right| right || matches!(check, Afx60Check::Counts(_)));
                    counters(d, |counters| counters.map(|counter| counter % 256));
                };
        },
    },
    Group {
        needs: &[Need::OfEither(&manuals::SICK_AFX60, &manuals::SICK_A3M60)],
        deviations: bugs! {
            // P1002 and P1003
            "power-up-counter-volatile" "The number of power-ups is always 1 after power-up."
                => |d| d.sick.log_loaded(|log| log.power_ups = 1);
            "service-log-cleared" "The logs are cleared at power-up, except for the number of power-ups."
                => |d| {
                    d.sick.log_loaded(|log| *log = Log { power_ups: log.power_ups, ..Log::default() });
                    d.afx60.at_event(Afx60Event::PowerUp, |_, mut retained| {
                        (retained.log.absolute.extremes, retained.log.relative.extremes, retained.log.counters) = (None, None, [0; 16]);
                        retained
                    });
                };
            "current-speed-for-the-highest" "The highest speed is replaced by the current speed."
                => |d| d.sick.log_element(2, |reading, _| reading.rpm.unsigned_abs());
        },
    },
];

/// Changes the sensor status words as they are read, given the fault bits. P1000 contains only the first word.
pub(super) fn status_words(d: &mut Deviations, change: fn(u32, [u16; 3]) -> [u16; 3]) {
    d.encoder.parameter(move |view, number, mut parameter| {
        if let 1000 | 1001 = number {
            let mut words = [0; 3];
            words.iter_mut().zip(&parameter.values).for_each(|(word, value)| *word = *value as u16);
            let changed = change(view.faults, words);
            parameter.values.iter_mut().zip(changed).for_each(|(value, word)| *value = word.into());
        }
        parameter
    });
}

/// Changes the counters of P1004 as they are read.
fn counters(d: &mut Deviations, change: fn([u16; 16]) -> [u16; 16]) {
    d.encoder.parameter(move |_, number, mut parameter| {
        if number == 1004 {
            let mut counters = [0; 16];
            counters.iter_mut().zip(&parameter.values).for_each(|(counter, value)| *counter = *value as u16);
            parameter.values = change(counters).map(u64::from).to_vec();
        }
        parameter
    });
}

/// Swaps bits 15 and 14, 13 and 12, 11 and 8.
fn memory_areas_exchanged(word: u16) -> u16 {
    let bit = |from: u32, to: u32| (word >> from & 1) << to;
    word & 0x06FF | bit(15, 14) | bit(14, 15) | bit(13, 12) | bit(12, 13) | bit(11, 8) | bit(8, 11)
}
