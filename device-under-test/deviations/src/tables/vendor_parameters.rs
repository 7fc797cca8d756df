//! Bugs of what the parameters of a vendor say and keep, and of the data set through which they are reached.

use super::Deviation;
use super::parameter_memory::Hangs;
use super::set_prm::with;
use encoder_profile::encoder::Gear;
use encoder_profile::hooks::View;
use reference_devices::models::sick_a3m60::knobs::{Origin, Words};
use wire::profibus::sap::SlaveSap;
use wire::profidrive::{ErrorNumber, ParameterError, RequestId};

/// The bugs of this seam.
pub static BUGS: &[Deviation] = bugs! {
    // Station and profile
    "address-as-digits" "P918 gives the places of the two switches as digits."
        => |b| b.at_encoder.element(|_, at, right| if at == (918, 0) { ((right / 10) << 4) | (right % 10) } else { right });
    "telegram-of-the-start-before" "P922 gives the telegram of the start before."
        => |b| b.a3m60.telegram = |before, _| before;
    "life-sign-tolerance-not-shown" "P925 reads 0."
        => |b| b.at_encoder.element(|_, at, right| if at == (925, 0) { 0 } else { right });
    "life-sign-tolerance-default-shown" "P925 reads 1, whatever is set."
        => |b| b.at_encoder.element(|_, at, right| if at == (925, 0) { 1 } else { right });
    "object-type-swapped" "The octets of the type are exchanged in P964."
        => |b| b.at_encoder.element(|_, at, right| if at == (964, 1) { u64::from((right as u16).swap_bytes()) } else { right });
    "profile-octets-swapped" "The octets of P965 are exchanged."
        => |b| b.at_encoder.element(|_, at, right| if at == (965, 0) { u64::from((right as u16).swap_bytes()) } else { right });
    "profile-version-follows-compatibility" "P65001 gives version 3.1 of the profile in compatibility mode."
        => |b| b.at_encoder.element(|view, at, right| if at == (65001, 6) && view.user.compatible { 0x301 } else { right });
    "vendor-of-the-stack" "P964 and P975 name the vendor of the stack."
        => |b| b.at_encoder.element(|_, at, right| if let (964 | 975, 0) = at { 0x0106 } else { right });
    "drive-object-0" "P964 gives 0 for the number of drive objects."
        => |b| b.at_encoder.element(|_, at, right| if at == (964, 5) { 0 } else { right });
    "array-shifted-by-one" "Element 0 of P964 is the number of its elements, and the others follow."
        => |b| b.at_encoder.element(array_shifted_by_one);
    "year-in-bcd" "The year of the software is given in binary coded decimals."
        => |b| b.at_encoder.element(|_, at, right| if let (964 | 975, 3) = at { in_bcd(right) } else { right });
    "subclass-of-class-4" "P975 has the bits of the classes at the wrong end."
        => |b| b.at_encoder.element(|_, at, right| if at == (975, 6) { u64::from((right as u16).reverse_bits()) } else { right });
    "sensor-type-with-bit-0" "P979 describes a linear scale."
        => |b| b.at_encoder.element(|_, at, right| if at == (979, 1) { right | 1 } else { right });
    "resolution-follows-scaling" "P979 gives the steps that are set."
        => |b| b.at_encoder.element(|view, at, right| if at == (979, 2) { view.user.units_per_revolution } else { right });
    "shift-factors-11" "P979 gives a shift factor of 0 for G1_XIST1."
        => |b| b.at_encoder.element(|_, at, right| if at == (979, 3) { 0 } else { right });
    "second-shift-1" "P979 gives a shift factor of 1 for G1_XIST2."
        => |b| b.at_encoder.element(|_, at, right| if at == (979, 4) { 1 } else { right });
    "revolutions-in-bits" "P979 gives the number of revolutions in bits."
        => |b| b.at_encoder.element(|_, at, right| if at == (979, 5) { right.trailing_zeros().into() } else { right });
    "constants-can-be-written" "P964, P975 and P979 can be written."
        => |b| b.a3m60.constants_are_writable = true;

    // P971, P65000
    "p971-resets" "A write to P971 sets the offset to 0."
        => |b| b.a3m60.saved = |_, _, ram| ram.measuring.offset = 0;
    "p971-refused" "A write to P971 is refused as read only."
        => |b| b.at_encoder.refuse(p971_refused);
    "p971-reads-memory" "P971 reads 5A5Ah."
        => |b| b.at_encoder.element(|_, at, right| if at == (971, 0) { 0x5A5A } else { right });
    "preset-value-of-31-bits" "The highest bit of P65000 is lost."
        => |b| b.at_encoder.value(65000, |value| value & 0x7FFF_FFFF);
    "preset-value-never-stored" "P65000 is lost at power-off."
        => |b| b.a3m60.stores_preset_value = false;
    "saves-by-p971-only" "P65000 is stored when 1 is written to P971."
        => |b| {
            b.a3m60.stores_preset_value = false;
            b.a3m60.saved = |value, store, ram| if value == 1 { store.preset_value.replace(ram.preset_value) };
        };
    "torn-write-taken" "A supply that goes while P65000 is being stored leaves half of it."
        => |b| b.a3m60.tears_preset_value = true;
    "offset-of-g1-stw-not-kept" "The offset of a preset by G1_STW is lost at power-off."
        => |b| b.a3m60.keeps_offset = |origin| origin != Origin::Request;
    "offset-of-the-button-not-kept" "The offset of a preset by the button is lost at power-off."
        => |b| b.a3m60.keeps_offset = |origin| origin != Origin::Button;

    // Status
    "sensor-status-stays" "P1000 and P1001 keep the bits of what has gone."
        => |b| b.a3m60.words = |known| Words { a: known.seen.a, b: known.seen.b };
    "sensor-status-inverted" "P1000 has all its bits inverted."
        => |b| b.at_encoder.element(|_, at, right| if at == (1000, 0) { right ^ 0xFFFF } else { right });
    "bus-status-set-without-isochronous" "P1001 has bit 5 set outside of isochronous operation."
        => |b| b.a3m60.words = |known| Words { b: known.words.b | if known.is_isochronous { 0 } else { 1 << 5 }, ..known.words };
    "faults-stay-after-acknowledgement" "P65001 keeps the bits of errors that have gone."
        => |b| b.a3m60.faults = |known, right| right | faults_of(known.seen.a);
    "faults-always-set" "P65001 has bit 1 of the faults always set."
        => |b| b.at_encoder.element(|_, at, right| if at == (65001, 2) { right | 2 } else { right });
    "warning-at-rest" "P65001 has bit 0 of the warnings set."
        => |b| b.at_encoder.element(|_, at, right| if at == (65001, 4) { right | 1 } else { right });
    "supported-faults-0" "P65001 gives 0 for the supported faults and warnings."
        => |b| b.at_encoder.element(|_, at, right| if let (65001, 3 | 5) = at { 0 } else { right });
    "operating-status-0" "P65001 shows the switches of delivery, whatever they are."
        => |b| b.at_encoder.element(|_, at, right| if at == (65001, 1) { 0x0C02 } else { right });
    "operating-status-cut-short" "P65001 ends after eight elements."
        => |b| b.at_encoder.cut(65001, 8);
    "operating-time-in-hours" "P65001 counts hours."
        => |b| b.at_encoder.element(|_, at, right| if at == (65001, 7) { right / 10 } else { right });
    "operating-time-not-kept" "The operating time in P65001 is 0 after power-up."
        => |b| b.a3m60.log_at_power_up = |log| log.operating = core::time::Duration::ZERO;

    // P1002
    "service-log-cut-short" "P1002 has four elements."
        => |b| b.at_encoder.cut(1002, 4);
    "power-ups-count-starts" "Each start counts as a power-up."
        => |b| b.a3m60.counts_starts = true;
    "seconds-of-power-counted" "P1002 counts the seconds with power."
        => |b| b.sick.motion = |_| 0;
    "seconds-counted-at-any-speed" "P1002 counts each second of motion."
        => |b| b.sick.motion = |_| 1;
    "highest-speed-forward-only" "Only forward there is a highest speed."
        => |b| b.sick.highest_speed = |rpm| rpm.max(0) as u64;
    "highest-speed-not-kept" "The highest speed is 1 after power-up."
        => |b| b.a3m60.log_at_power_up = |log| log.highest_speed = 1;
    "highest-speed-not-kept-above-the-table" "A speed above 9000 is not taken for the highest one."
        => |b| b.sick.highest_speed = |rpm| if rpm.abs() > 9000 { 0 } else { rpm.unsigned_abs() };
    "counters-count-both-ways" "Both counters of turns count each turn."
        => |b| b.sick.turns = |_| [true, true];
    "reverse-lowers-the-forward-counter" "A turn in reverse lowers the other counter."
        => |b| b.sick.log = |entries| {
            let mut log = entries.right;
            log[3] = u64::from((log[3] as u32).wrapping_sub(log[4] as u32));
            log
        };

    // P1007 and P1008
    "p1007-cut-short" "P1007 has four elements."
        => |b| b.at_encoder.cut(1007, 4);
    "p1007-disturbs-the-position" "A write to P1007 sets the position to 0 for a second."
        => |b| b.a3m60.test_disturbs = true;
    "integration-times-exchanged" "The two integration times of delivery are exchanged."
        => |b| b.at_encoder.element(|_, at, right| match (at, right) { ((1008, 2), 200) => 10, ((1008, 3), 10) => 200, _ => right });
    "p1008-0-is-a-switch" "P1008.0 can be written, and changes the refresh time."
        => |b| b.a3m60.has_hidden_switch = true;
    "highest-setting-refused" "The highest value of each element of P1008 is refused."
        => |b| b.sick.takes = |at, value, right| right && !matches!((at, value), ((1008, 1), 100) | ((1008, 2 | 3), 200));
    "settings-not-checked" "P1008 takes any value."
        => |b| b.sick.takes = |at, _, right| right || at.0 == 1008 && at.1 > 0;
    "limits-clip-values" "A value of P1008 beyond its limits is taken as the limit."
        => |b| b.sick.settled = |at, value, _| match at { (1008, 1) => value.clamp(1, 100), (1008, 2 | 3) => value.clamp(1, 200), _ => value };
    "setting-of-8-bits-with-a-sign" "P1008.2 above 127 reads as a negative number."
        => |b| b.at_encoder.element(|_, at, right| if at == (1008, 2) && right > 127 { right | 0xFF00 } else { right });
    "third-setting-is-the-second" "A write to P1008.3 writes P1008.2."
        => |b| b.a3m60.setting = |at| if at == 3 { 2 } else { at };
    "settings-kept-in-part" "P1008.1 outlasts the power, P1008.2 and P1008.3 do not."
        => |b| b.a3m60.keeps_setting = |at| at == 0;

    // P1009
    "fraction-shown-reduced" "P1009 shows the reduced fraction."
        => |b| b.a3m60.axis = fraction_shown_reduced;
    "values-in-use-not-shown" "P1009 gives 0 for what is in use."
        => |b| b.a3m60.axis = |axis| with(axis, &[(6, 0), (7, 0), (8, 0)]);
    "round-axis-mode-as-1-and-2" "P1009 reads 1 for off and 2 for on."
        => |b| b.a3m60.axis = |axis| with(axis, &[(0, axis[0] + 1)]);
    "range-offset-with-a-sign" "The range offset is a negative number."
        => |b| b.a3m60.axis = |axis| with(axis, &[(4, u64::from((axis[4] as u32 | 1).wrapping_neg()))]);
    "range-offset-never-moves" "The range offset is always 0."
        => |b| b.a3m60.axis = |axis| with(axis, &[(4, 0)]);
    "internal-shift-undefined" "The internal shift is another one each time."
        => |b| b.at_encoder.element(|view, at, right| if at == (1009, 5) { (view.now.as_nanos() / 1000) & 0xFFFF_FFFF } else { right });
    "fraction-of-the-steps-is-0" "The steps of a revolution have nothing behind the point."
        => |b| b.a3m60.axis = |axis| with(axis, &[(10, 0)]);

    // Access
    "unknown-parameter-1003-read" "P1003 reads 0."
        => |b| b.at_encoder.refuse(|id, number, found| found.filter(|_| (id, number) != (RequestId::REQUEST, 1003)));
    "busy-answered-with-another-error" "While a value is being stored a read is refused with an invalid index."
        => |b| b.a3m60.is_rude_while_storing = true;
    "unknown-index-answered" "Any index goes to the parameters."
        => |b| b.a3m60.has_index = |_| true;
    "every-slot-keeps-silent" "A request for a record of another slot than 0 and 1 is never answered."
        => |b| b.slave.request(SlaveSap::SERVER, |data| {
            // An empty request is acknowledged and fetches nothing.
            if data.get(1).is_some_and(|slot| *slot > 1) {
                data.clear();
            }
            true
        });
    "hangs-after-short-request" "After a request of fewer than four octets none is answered."
        => |b| b.at_encoder.add(Hangs::after(|octets| octets.len() < 4));
    "parameters-with-telegrams-only" "There are no parameters with the telegrams of the vendor."
        => |b| b.a3m60.has_parameters = |telegram| telegram.number != 0;
};

fn p971_refused(id: RequestId, number: u16, found: Option<ParameterError>) -> Option<ParameterError> {
    match (id, number) {
        (RequestId::CHANGE, 971) => Some(ParameterError { number: ErrorNumber::READ_ONLY, subindex: None }),
        _ => found,
    }
}

fn faults_of(status_a: u16) -> u64 {
    u64::from(status_a & 0x7FC0 != 0) | u64::from(status_a & 0x8080 != 0) << 5
}

fn in_bcd(number: u64) -> u64 {
    [1000, 100, 10, 1].iter().fold(0, |bcd, place| (bcd << 4) | (number / place % 10))
}

fn array_shifted_by_one(view: &View<'_>, at: (u16, usize), right: u64) -> u64 {
    let [version, year, day] = view.facts.software;
    match at {
        (964, 0) => 6,
        (964, 1) => view.facts.identity.vendor_id.into(),
        (964, 2) => view.facts.unit_type.into(),
        (964, 3) => version.into(),
        (964, 4) => year.into(),
        (964, 5) => day.into(),
        _ => right,
    }
}

fn fraction_shown_reduced(axis: [u64; 11]) -> [u64; 11] {
    let (mut a, mut b) = (axis[1].max(1), axis[2].max(1));
    while b != 0 {
        (a, b) = (b, a % b);
    }
    with(axis, &[(1, axis[1] / a), (2, axis[2] / a)])
}

/// A gear whose units per revolution are `units`.
pub fn gear_of(units: u64, range: u64) -> Gear {
    Gear { nominator: range.max(1), divisor: units, range }
}
