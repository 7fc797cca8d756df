//! Bugs of the service log and of the words of the sensor status.

use super::Deviation;
use reference_devices::models::sick::knobs::Entries;

/// The bugs of this seam.
pub static BUGS: &[Deviation] = bugs! {
    // P1002 and P1003
    "service-log-cut-short" "The logs have twelve elements."
        => |b| {
            b.at_encoder.cut(1002, 12);
            b.at_encoder.cut(1003, 12);
        };
    "power-ups-not-counted" "A power-up is not counted."
        => |b| b.sick.power_ups = |before| before;
    "power-up-counter-volatile" "After each power-up there was one."
        => |b| b.sick.power_ups = |_| 1;
    "service-log-cleared" "The logs are cleared at power-up, but for the number of power-ups."
        => |b| b.sick.log_survives = false;
    "log-time-in-minutes" "The operating time is counted in minutes."
        => |b| b.sick.log = |entries| with(entries, 1, entries.right[1] / 60);
    "current-speed-for-the-highest" "The present speed is given for the highest one."
        => |b| b.sick.log = |entries| with(entries, 2, entries.rpm.unsigned_abs());
    "reverse-turns-counted-as-forward" "Turns in reverse are counted as forward too."
        => |b| b.sick.turns = |sense| [true, sense < 0];
    "forward-turns-counted-as-reverse" "Turns forward are counted as reverse too."
        => |b| b.sick.turns = |sense| [sense > 0, true];
    "starts-counted-for-changes" "Each start of the shaft is counted as a change of direction."
        => |b| b.sick.is_change = |before, _, now| before != now;
    "motion-threshold-60" "Motion counts from 60 rpm on."
        => |b| b.sick.motion = |_| 60;
    "speed-for-acceleration" "The speed is given for the acceleration."
        => |b| b.sick.log = |entries| with(entries, 7, entries.rpm.unsigned_abs());
    "led-current-in-milliamperes" "The highest current of the LED is given in milliamperes."
        => |b| b.sick.log = |entries| with(entries, 8, entries.right[8] / 1000);
    "lowest-led-current-0" "The lowest current of the LED is 0."
        => |b| b.sick.log = |entries| with(entries, 9, 0);
    "log-voltage-in-millivolts" "The highest voltage is given in millivolts."
        => |b| b.sick.log = |entries| with(entries, 10, entries.right[10] * 1000);
    "temperature-extremes-exchanged" "The lowest and the highest temperature are exchanged."
        => |b| b.sick.log = temperature_extremes_exchanged;
    "lowest-temperature-clamped" "A lowest temperature below 0 is given as 0."
        => |b| b.sick.log = |entries| with(entries, 12, if entries.right[12] > i32::MAX as u64 { 0 } else { entries.right[12] });
    "relative-log-in-other-units" "The log that can be reset counts its time in milliseconds."
        => |b| b.sick.log = |entries| if entries.number == 1003 { with(entries, 1, entries.operating.as_millis() as u64) } else { entries.right };
    "relative-log-is-the-absolute-one" "The log that can be reset is the other one, and is not reset."
        => |b| b.afx60.resets_log = false;
    "reset-clears-both-logs" "A reset of one log resets the other too."
        => |b| b.afx60.resets_both_logs = true;
    "reset-clears-service-log" "The factory reset clears the log."
        => |b| b.afx60.reset_clears_log = true;

    // P1000 and P1001
    "p1000-always-0" "P1000 is always 0."
        => |b| b.at_encoder.element(|_, at, right| if at == (1000, 0) { 0 } else { right });
    "sensor-words-exchanged" "The words B and C are exchanged."
        => |b| b.afx60.words = |[a, b, c], _| [a, c, b];
    "sensor-bits-one-too-high" "The bits of the word A stand one place too high."
        => |b| b.afx60.words = |[a, b, c], _| [a << 1, b, c];
    "reserved-bit-13-with-errors" "Bit 13 of the word A is set with an error of the position."
        => |b| b.afx60.words = |[a, b, c], faults| [a | if faults & 1 == 0 { 0 } else { 1 << 13 }, b, c];
    "memory-areas-exchanged" "Bits of the areas of the memory change places."
        => |b| b.afx60.words = |[a, b, c], _| [a, memory_areas_exchanged(b), c];
    "start-up-warning-left" "Bit 0 of the word A is always set."
        => |b| b.afx60.words = |[a, b, c], _| [a | 1, b, c];
    "preset-warning-missing" "Bit 4 of the word B is never set."
        => |b| b.afx60.words = |[a, b, c], _| [a, b & !0x0010, c];
    "preset-accepted-never-shown" "Bit 12 of the word C is never set."
        => |b| b.afx60.words = |[a, b, c], _| [a, b, c & !0x1000];
    "internal-state-in-reserved-bits" "Bit 0 of the word B and bit 5 of the word C are always set."
        => |b| b.afx60.words = |[a, b, c], _| [a, b | 1, c | 1 << 5];
    "synchronous-and-free-run" "Bits 15 and 14 of the word C are both set."
        => |b| b.afx60.words = |[a, b, c], _| [a, b, c | 0xC000];
    "saving-of-diagnosis-never-ends" "Bits 3 and 2 of the word C are always 01."
        => |b| b.afx60.words = |[a, b, c], _| [a, b, c & !0x000C | 0x0004];
    "saved-before-it-is-written" "A save is complete in the word C as soon as it begins."
        => |b| b.afx60.words = |[a, b, c], _| [a, b, if c & 3 == 1 { c & !3 | 2 } else { c }];
    "save-progress-not-shown" "Bits 1 and 0 of the word C are always 0."
        => |b| b.afx60.words = |[a, b, c], _| [a, b, c & !3];

    // P1004
    "occurrences-one-element-lower" "Bit n of the word A is counted in element n - 1."
        => |b| b.afx60.counters = |mut counters| { counters.rotate_left(1); counters };
    "two-bits-share-a-counter" "Bit 9 of the word A is counted in element 8."
        => |b| b.afx60.counters = |mut counters| { (counters[8], counters[9]) = (counters[8] + counters[9], 0); counters };
    "reserved-bit-counts-its-neighbour" "Element 13 counts bit 14 of the word A."
        => |b| b.afx60.counters = |mut counters| { counters[13] = counters[14]; counters };
    "occurrences-0-from-elsewhere" "Element 0 is some other memory."
        => |b| b.afx60.counters = |mut counters| { counters[0] = 0xA5A5; counters };
    "occurrences-wrap" "The counters begin again after 255."
        => |b| b.afx60.counted = |counted, highest| if counted > highest { 0 } else { counted };
};

fn with(entries: &Entries, at: usize, value: u64) -> [u64; 13] {
    let mut shown = entries.right;
    shown[at] = value;
    shown
}

fn temperature_extremes_exchanged(entries: &Entries) -> [u64; 13] {
    let mut shown = entries.right;
    shown.swap(11, 12);
    shown
}

/// 15 and 14, 13 and 12, 11 and 8 change places.
fn memory_areas_exchanged(word: u16) -> u16 {
    let bit = |from: u32, to: u32| (word >> from & 1) << to;
    word & 0x06FF | bit(15, 14) | bit(14, 15) | bit(13, 12) | bit(12, 13) | bit(11, 8) | bit(8, 11)
}
