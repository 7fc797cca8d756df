//! The limits of settings, and what the limits cause.

use super::refuse_writes;
use crate::needs::Need;
use crate::seams::Deviations;
use crate::tables::Group;
use alloc::rc::Rc;
use core::cell::Cell;
use reference_devices::manuals;
use reference_devices::models::sick::hooks::SickCheck;
use reference_devices::models::sick_afx60::hooks::Afx60Check;
use wire::profidrive::ErrorNumber;

/// The variations.
pub const GROUP: Group = Group {
    needs: &[Need::Of(&manuals::SICK_AFX60)],
    deviations: permitted! {
        "speed-filter-of-table-34" "P1005 accepts a refresh time up to 50 ms and up to 100 measurements."
            "3.5.5, Table 34 (1005.2, 1005.3); sections 3.6.15 and 3.6.16 print other limits"
            => |d| d.sick.setting(|at, value, right| right && match at {
                (1005, 2) => value <= 50,
                (1005, 3) => value <= 100,
                _ => true,
            });
        "refresh-time-of-section-3-6-15" "P1005 accepts a refresh time of 1 to 100 ms on the AFS60 too."
            "3.6.15: 1 to 100 ms, without a difference between the encoders"
            => |d| d.sick.setting(|at, value, right| right || at == (1005, 2) && (1..=100).contains(&value));
        "fraction-of-sections-3-6-13-and-3-6-14" "P1009 accepts a nominator up to 2048 and a divisor up to 65535."
            "3.6.13 and 3.6.14; Table 34 prints another limit"
            => |d| d.sick.setting(|at, value, right| right && match at {
                (1009, 1) => value <= 2048,
                (1009, 2) => value <= 65535,
                _ => true,
            });
        "lowest-speed-above-the-highest-refused" "A minimum speed above the maximum speed is refused."
            "3.5.5, Table 34 (1005.4, 1005.5) is silent about the order of the limits"
            => |d| lowest_speed_above_the_highest_refused(d);
        "limit-belongs-to-the-outside" "A speed, temperature or voltage equal to its limit raises the warning."
            "5.4.1, Table 44: outside the limit; no accuracy of a measured value is printed"
            => |d| d.afx60.check(|check, right| match check {
                Afx60Check::TooFast(speeds) => right || speeds.rpm.abs() == speeds.highest,
                Afx60Check::TooSlow(speeds) => right || speeds.lowest > 0 && speeds.rpm.abs() == speeds.lowest,
                Afx60Check::TemperatureIsOutside(celsius, [lower, upper]) => right || celsius <= lower || celsius >= upper,
                Afx60Check::Overvoltage(millivolts, limit) => right || millivolts == limit,
                _ => right,
            });
        "voltage-limits-only-warn" "The limits of P1007 set a bit of the sensor status; an error is only a supply below 10 V or above 30 V."
            "5.4.1, Table 44 bit 3: a warning; 4.1.1, Table 38: 10 to 30 V"
            => |d| voltage_limits_only_warn(d);
        "preset-value-refused-at-the-write" "A preset value beyond the range is refused when it is written."
            "5.4.1, Table 45 bits 1 and 4: a warning at the write and one at the preset; which one applies is not printed"
            => |d| refuse_writes(d, 65000, ErrorNumber::LIMIT, |view, _, values| {
                values.first().is_some_and(|value| *value >= view.positions)
            });
        "round-axis-of-the-start" "The position has the gear of the start, whatever is written to P1009 later."
            "3.5.5, Table 34 (1009) and 3.6.12 do not print when a written value acts on the position"
            => |d| round_axis_of_the_start(d);
        "round-axis-on-singleturn" "The AFS60 has the round axis."
            "3.2.2 and 3.6.12 speak of the encoder without a difference"
            => |d| d.afx60.set(Afx60Check::HasRoundAxis, true);
    },
};

fn round_axis_of_the_start(d: &mut Deviations) {
    let takes_axis = Rc::new(Cell::new(true));
    let takes_gear = Rc::new(Cell::new(true));
    let (axis, gear) = (takes_axis.clone(), takes_gear.clone());
    // What the start says is complete at PrmEnd.
    d.encoder.ready(move |_, right| {
        axis.set(true);
        gear.set(true);
        right
    });
    let mut is_on = false;
    d.sick.check(move |check, right| {
        if check != SickCheck::RoundAxis {
            return right;
        }
        if takes_axis.take() {
            is_on = right;
        }
        is_on
    });
    let mut of_start = None;
    d.sick_axis.gear(move |_, _, gear| {
        if takes_gear.take() {
            of_start = Some(gear);
        }
        of_start.unwrap_or(gear)
    });
}

fn lowest_speed_above_the_highest_refused(d: &mut Deviations) {
    let highest = Rc::new(Cell::new(10_000));
    let written = highest.clone();
    d.encoder.written(move |_, (number, subindex), values| {
        let values = values?;
        let at = usize::from(4_u16.wrapping_sub(subindex));
        if let (1005, Some(value)) = (number, values.get(at)) {
            written.set(*value);
        }
        Some(values)
    });
    refuse_writes(d, 1005, ErrorNumber::LIMIT, move |_, subindex, values| {
        let at = usize::from(5_u16.wrapping_sub(subindex));
        values.get(at).is_some_and(|lowest| *lowest > highest.get())
    });
}

fn voltage_limits_only_warn(d: &mut Deviations) {
    let was_wrong = Cell::new(false);
    d.afx60.check(move |check, right| match check {
        Afx60Check::SupplyIsWrong(millivolts) => {
            let is_wrong = right && !(10_000..=30_000).contains(&millivolts);
            was_wrong.set(was_wrong.get() || is_wrong);
            is_wrong
        }
        Afx60Check::Restarts if right => was_wrong.take(),
        _ => right,
    });
}
