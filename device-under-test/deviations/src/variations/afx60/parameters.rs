//! Parameters: contents, lengths and refusals.

use super::refuse_writes;
use crate::needs::Need;
use crate::seams::Deviations;
use crate::tables::Group;
use alloc::rc::Rc;
use alloc::vec::Vec;
use core::cell::Cell;
use encoder_profile::profidrive::parameters::ParameterContent;
use reference_devices::manuals;
use reference_devices::models::sick_afx60::hooks::Afx60Check;
use wire::profidrive::{ErrorNumber, ParameterError, ParameterResponse, ParameterValue, RequestId};

/// The variations.
pub const GROUP: Group = Group {
    needs: &[Need::Of(&manuals::SICK_AFX60)],
    deviations: permitted! {
        "sensor-type-without-mark" "Bit 31 of the sensor type in P979 is 0."
            "3.5.4, Table 33 (979.1) prints both values"
            => |d| d.encoder.element(|_, at, right| if at == (979, 1) { 2 } else { right });
        "software-date-in-bytes" "P964 and P975 contain the year in decimal digits and the date as one byte for the day and one for the month."
            "3.5.4, Table 33 (964.3, 964.4): yyyy and dd.mm"
            => |d| d.encoder.element(|_, at, right| match at {
                (964 | 975, 3) => 0x2017,
                (964 | 975, 4) => 0x0F03,
                _ => right,
            });
        "reserved-parameter-refused" "P1010 does not exist."
            "3.5.5, Table 34 (1010): reserved"
            => |d| d.encoder.refuse(|_, number, before| if number == 1010 { Some(error(ErrorNumber::UNKNOWN_PARAMETER)) } else { before });
        "speed-elements-to-15" "P1005 has sixteen elements, of which the last ten are 0."
            "3.5.5, Table 34 (1005): array 0 to 15"
            => |d| d.encoder.parameter(|_, number, mut right| {
                if number == 1005 {
                    right.values.resize(16, 0);
                }
                right
            });
        "counters-without-bit-0" "P1004 has no element 0."
            "3.5.5, Table 34 (1004): the rows begin at .1"
            => |d| counters_without_bit_0(d);
        "counters-start-at-1" "The counters of P1004 are 1 in factory state."
            "3.5.5, Table 34 (1004): 1 to 255"
            => |d| counters(d, |count| (count + 1).min(255));
        "counters-continue-at-1" "The counters of P1004 continue at 1 after 255."
            "3.5.5, Table 34 (1004): 1 to 255; whether they stop there is not printed"
            => |d| {
                d.afx60.check(|check, right| right || matches!(check, Afx60Check::Counts(_)));
                counters(d, |count| if count == 0 { 0 } else { (count - 1) % 255 + 1 });
            };
        "fpga-version-below-one" "The FPGA version is 0.1.32."
            "3.5.5, Table 34 (1013): the printed version is an example"
            => |d| d.encoder.element(|_, at, right| if at == (1013, 0) { 0x0000_0120 } else { right });
        "p971-cannot-be-read" "P971 can only be written."
            "3.5.4, Table 33 (971): access W"
            => |d| d.encoder.refuse(|id, number, before| match (id, number) {
                (RequestId::REQUEST, 971) => Some(error(ErrorNumber::UNKNOWN_PARAMETER)),
                _ => before,
            });
        "name-filled-with-zeros" "P61000 has 234 bytes, of which those after the name are 0."
            "3.5.6, Table 35 (61000), and 3.5.2, Table 28: at most EAh values; what follows the name is not printed"
            => |d| d.encoder.parameter(|_, number, mut right| {
                if number == 61000 {
                    right.values.resize(0xEA, 0);
                }
                right
            });
        "second-save-refused" "A save is refused while another one is running."
            "3.5.4, Table 33 (971) is silent about a save during a save"
            => |d| refuse_writes(d, 971, ErrorNumber::WRONG_OPERATING_STATE, |view, _, _| view.store.preset_value.deadline().is_some());
        "relative-log-is-read-only" "P1003 cannot be written."
            "3.5.5, Table 34 (1003): access R"
            => |d| d.encoder.parameter(|_, number, right| if number == 1003 { ParameterContent { writable: 0..0, ..right } } else { right });
        "round-axis-results-reduced" "P1009 shows the fraction in use in lowest terms."
            "3.5.5, Table 34 (1009.6, 1009.7): see subindex .1 and .2"
            => |d| d.encoder.parameter(|_, number, mut right| {
                if let (1009, [.., _, _]) = (number, &right.values[..]) {
                    let divisor = greatest_common_divisor(right.values[6], right.values[7]).max(1);
                    right.values[6] /= divisor;
                    right.values[7] /= divisor;
                }
                right
            });
        "round-axis-results-ignore-writes" "A write to the results of P1009 is acknowledged and has no effect."
            "3.5.5, Table 34 (1009): access R/W for the whole parameter"
            => |d| {
                d.encoder.parameter(|_, number, right| if number == 1009 { right.writable() } else { right });
                d.encoder.written(|_, (number, subindex), values| values.filter(|_| number != 1009 || subindex < 5));
            };
        "no-round-axis-parameter-on-singleturn" "The AFS60 has no P1009."
            "3.1, Table 3: no round axis on the AFS60"
            => |d| no_round_axis_parameter_on_singleturn(d);
    },
};

fn error(number: ErrorNumber) -> ParameterError {
    ParameterError { number, subindex: None }
}

/// Changes the elements 1 to 15 of P1004 as they are read.
fn counters(d: &mut Deviations, change: fn(u64) -> u64) {
    d.encoder.parameter(move |_, number, mut right| {
        if number == 1004 {
            right.values.iter_mut().skip(1).for_each(|count| *count = change(*count));
        }
        right
    });
}

fn counters_without_bit_0(d: &mut Deviations) {
    d.encoder.respond(|request, mut right| {
        let refused = |at: usize| request.addresses.get(at).is_some_and(|one| (one.number, one.subindex) == (1004, 0));
        let read: Vec<ParameterValue> = right.values.clone();
        if request.header.id == RequestId::REQUEST && (0..read.len()).any(refused) {
            let values = read.into_iter().enumerate();
            let changed = values.map(|(at, value)| {
                if refused(at) { ParameterValue::refused(error(ErrorNumber::NO_SUCH_SUBINDEX)) } else { value }
            });
            right = ParameterResponse::to_read(&request.header, changed.collect());
        }
        right
    });
}

fn no_round_axis_parameter_on_singleturn(d: &mut Deviations) {
    let is_singleturn = Rc::new(Cell::new(false));
    let singleturn = is_singleturn.clone();
    d.encoder.starts(move |view| singleturn.set(view.hardware.revolutions == 1));
    d.encoder.refuse(move |_, number, before| {
        if number == 1009 && is_singleturn.get() { Some(error(ErrorNumber::UNKNOWN_PARAMETER)) } else { before }
    });
}

fn greatest_common_divisor(one: u64, other: u64) -> u64 {
    if other == 0 { one } else { greatest_common_divisor(other, one % other) }
}
