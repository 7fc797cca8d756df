//! Bugs of the contents and storage of vendor parameters, and of the data set that gives access to them.

use super::Group;
use super::parameter_access_state::HangsAfterRequest;
use crate::needs::Need;
use crate::seams::Deviations;
use crate::seams::slave::{frame, request, with_data};
use alloc::rc::Rc;
use alloc::vec;
use alloc::vec::Vec;
use core::cell::{Cell, RefCell};
use core::mem;
use core::time::Duration;
use device_stack::profibus::{SlaveApplication, SlaveHooks};
use encoder_profile::encoder::Gear;
use encoder_profile::encoder_object::{ConnectionPhase, PoweredEncoder};
use encoder_profile::hooks::EncoderView;
use encoder_profile::profidrive::telegram::SignalImage;
use reference_devices::manuals;
use reference_devices::models::sick::hooks as sick;
use reference_devices::models::sick_a3m60::hooks::{A3m60Check, A3m60Event, A3m60Hooks, A3m60Memory, VendorWrite};
use reference_devices::models::sick_a3m60::set_prm::UserByteFields;
use reference_devices::models::sick_a3m60::status::SensorStatusWords;
use reference_devices::models::sick_a3m60::{A3m60State, SpeedCalculation};
use station::{StandAction, Time};
use wire::profibus::dpv1::{Dpv1Pdu, Dpv1Record, PduDirection};
use wire::profibus::sap::{SapService, SlaveSap};
use wire::profidrive::{ErrorNumber, ParameterError, ParameterFormat, RequestId};

/// The bugs, by what they need.
pub static GROUPS: &[Group] = &[Group {
    needs: &[Need::Of(&manuals::SICK_A3M60)],
    deviations: bugs! {
        // Station and profile
        "address-as-digits" "P918 contains the address in BCD."
            => |d| d.encoder.element(|_, at, right| if at == (918, 0) { ((right / 10) << 4) | (right % 10) } else { right });
        "telegram-of-the-start-before" "P922 contains the telegram of the previous start."
            => |d| telegram_of_the_start_before(d);
        "life-sign-tolerance-not-shown" "P925 always reads 0."
            => |d| d.encoder.element(|_, at, right| if at == (925, 0) { 0 } else { right });
        "object-type-swapped" "The bytes of the type are swapped in P964."
            => |d| d.encoder.element(|_, at, right| if at == (964, 1) { u64::from((right as u16).swap_bytes()) } else { right });
        "profile-bytes-swapped" "The bytes of P965 are swapped."
            => |d| d.encoder.element(|_, at, right| if at == (965, 0) { u64::from((right as u16).swap_bytes()) } else { right });
        "profile-version-without-its-second-digit" "P65001 contains profile version 4.0."
            => |d| d.encoder.element(|_, at, right| if at == (65001, 6) { 0x400 } else { right });
        "vendor-of-the-stack" "P964 and P975 contain the vendor ID of the stack."
            => |d| d.encoder.element(|_, at, right| if let (964 | 975, 0) = at { 0x0106 } else { right });
        "drive-object-0" "P964 contains 0 as the number of drive objects."
            => |d| d.encoder.element(|_, at, right| if at == (964, 5) { 0 } else { right });
        "array-shifted-by-one" "P964 begins with the number of its elements, and all other elements are shifted."
            => |d| d.encoder.element(array_shifted_by_one);
        "year-before-2000" "The year of the software has two digits."
            => |d| d.encoder.element(|_, at, right| if let (964 | 975, 3) = at { right % 100 } else { right });
        "subclass-of-class-4" "The bits of the classes in P975 are reversed."
            => |d| d.encoder.element(|_, at, right| if at == (975, 6) { u64::from((right as u16).reverse_bits()) } else { right });
        "sensor-type-with-bit-0" "P979 describes a linear scale."
            => |d| d.encoder.element(|_, at, right| if at == (979, 1) { right | 1 } else { right });
        "resolution-follows-scaling" "P979 contains the configured steps per revolution."
            => |d| d.encoder.element(|view, at, right| if at == (979, 2) { view.user.units_per_revolution } else { right });
        "shift-factors-11" "P979 contains a shift factor of 0 for G1_XIST1."
            => |d| d.encoder.element(|_, at, right| if at == (979, 3) { 0 } else { right });
        "second-shift-1" "P979 contains a shift factor of 1 for G1_XIST2."
            => |d| d.encoder.element(|_, at, right| if at == (979, 4) { 1 } else { right });
        "revolutions-in-bits" "P979 contains the number of revolutions as a number of bits."
            => |d| d.encoder.element(|_, at, right| if at == (979, 5) { right.trailing_zeros().into() } else { right });
        "constants-can-be-written" "P964, P975 and P979 can be written."
            => |d| constants_can_be_written(d);

        // P971, P65000
        "p971-resets" "A write to P971 sets the offset to 0."
            => |d| d.a3m60.write(|write, memory| if write.number == 971 { memory.measuring.offset = 0 });
        "p971-refused" "A write to P971 is refused as read-only."
            => |d| d.encoder.refuse(p971_refused);
        "p971-reads-memory" "P971 reads 5A5Ah."
            => |d| d.encoder.element(|_, at, right| if at == (971, 0) { 0x5A5A } else { right });
        "preset-value-of-31-bits" "The highest bit of P65000 is lost."
            => |d| d.encoder.value(65000, |value| value & 0x7FFF_FFFF);
        "preset-value-never-stored" "P65000 is lost at power-off."
            => |d| d.a3m60.happens(|event, memory| if event == A3m60Event::PowerUp { *memory.preset_value = 0 });
        "saves-by-p971-only" "P65000 is stored only when 1 is written to P971."
            => |d| d.a3m60.add(SavedByP971(0));
        "torn-write-taken" "Power-off while P65000 is being stored leaves half of the value."
            => |d| d.a3m60.happens(|event, memory| {
                let cell = &mut memory.store.preset_value;
                if event == A3m60Event::PowerDown && cell.deadline().is_some() {
                    cell.replace(*memory.preset_value & 0xFFFF_0000 | *cell.stored() & 0xFFFF);
                }
            });
        "offset-of-g1-stw-not-kept" "The offset of a preset by G1_STW is lost at power-off."
            => |d| offset_not_kept(d, false);
        "offset-of-the-button-not-kept" "The offset of a preset by the button is lost at power-off."
            => |d| offset_not_kept(d, true);

        // Status
        "sensor-status-stays" "P1000 and P1001 keep the bits of errors that have disappeared."
            => |d| {
                let collected = d.track(SensorStatusWords::default(), collect_status);
                d.encoder.element(move |_, at, right| match at {
                    (1000, 0) => collected.get().a.into(),
                    (1001, 0) => collected.get().b.into(),
                    _ => right,
                });
            };
        "sensor-status-inverted" "All bits of P1000 are inverted."
            => |d| d.encoder.element(|_, at, right| if at == (1000, 0) { right ^ 0xFFFF } else { right });
        "bus-status-set-without-isochronous" "Bit 5 of P1001 is set outside of isochronous operation."
            => |d| {
                let is_isochronous = d.track(false, |encoder, _, _| encoder.model.clock.times().is_some());
                d.encoder.element(move |_, at, right| if at == (1001, 0) && !is_isochronous.get() { right | 1 << 5 } else { right });
            };
        "faults-stay-after-acknowledgement" "P65001 keeps the fault bits of errors that have disappeared."
            => |d| {
                let collected = d.track(SensorStatusWords::default(), collect_status);
                d.encoder.element(move |_, at, right| if at == (65001, 2) { right | faults_of(collected.get().a) } else { right });
            };
        "faults-always-set" "Bit 1 of the faults in P65001 is always set."
            => |d| d.encoder.element(|_, at, right| if at == (65001, 2) { right | 2 } else { right });
        "warning-at-rest" "Bit 0 of the warnings in P65001 is always set."
            => |d| d.encoder.element(|_, at, right| if at == (65001, 4) { right | 1 } else { right });
        "supported-faults-0" "P65001 contains 0 for the supported faults and warnings."
            => |d| d.encoder.element(|_, at, right| if let (65001, 3 | 5) = at { 0 } else { right });
        "operating-status-0" "P65001 always shows the factory switches."
            => |d| d.encoder.element(|_, at, right| if at == (65001, 1) { 0x0C02 } else { right });
        "operating-status-cut-short" "P65001 ends after eight elements."
            => |d| d.encoder.truncate_elements(65001, 8);
        "operating-time-in-hours" "P65001 counts the operating time in hours instead of 0.1 h."
            => |d| d.encoder.element(|_, at, right| if at == (65001, 7) { right / 10 } else { right });
        "operating-time-not-kept" "The operating time in P65001 is 0 after power-up."
            => |d| d.a3m60.happens(|event, memory| if event == A3m60Event::PowerUp { memory.log.operating = Duration::ZERO });

        // P1002
        "service-log-cut-short" "P1002 has four elements."
            => |d| d.encoder.truncate_elements(1002, 4);
        "power-ups-count-starts" "Each start of a connection counts as a power-up."
            => |d| d.a3m60.happens(|event, memory| if event == A3m60Event::Start { memory.log.power_ups += 1 });
        "seconds-of-power-counted" "P1002 counts the seconds with power instead of those in motion."
            => |d| d.sick.check(|check, right| right || matches!(check, sick::SickCheck::Motion(_)));
        "seconds-counted-at-any-speed" "P1002 counts motion at any speed."
            => |d| d.sick.check(|check, right| match check {
                sick::SickCheck::Motion(rpm) => rpm > 0,
                _ => right,
            });
        "highest-speed-forward-only" "The highest speed is updated only in forward direction."
            => |d| d.sick.check(|check, right| match check {
                sick::SickCheck::HighestSpeed(rpm) => right && rpm > 0,
                _ => right,
            });
        "highest-speed-not-kept" "The highest speed is 1 after power-up."
            => |d| d.a3m60.happens(|event, memory| if event == A3m60Event::PowerUp { memory.log.highest_speed = 1 });
        "highest-speed-not-kept-above-the-table" "A speed above 9000 rpm does not update the highest speed."
            => |d| d.sick.check(|check, right| match check {
                sick::SickCheck::HighestSpeed(rpm) => right && rpm.abs() <= 9000,
                _ => right,
            });
        "counters-count-both-ways" "Both turn counters count each turn."
            => |d| d.sick.log(|_, mut log| {
                (log[3], log[4]) = (log[3] + log[4], log[3] + log[4]);
                log
            });
        "reverse-lowers-the-forward-counter" "A reverse turn decrements the forward counter."
            => |d| d.sick.log_element(3, |_, log| u64::from((log[3] as u32).wrapping_sub(log[4] as u32)));

        // P1007 and P1008
        "p1007-cut-short" "P1007 has four elements."
            => |d| d.encoder.truncate_elements(1007, 4);
        "p1007-disturbs-the-position" "A write to P1007 sets the position to 0 for a second."
            => |d| d.a3m60.add(DisturbedByP1007(None));
        "integration-times-exchanged" "The two factory integration times are swapped."
            => |d| d.encoder.element(|_, at, right| match (at, right) { ((1008, 2), 200) => 10, ((1008, 3), 10) => 200, _ => right });
        "p1008-0-is-a-switch" "P1008.0 can be written and changes the refresh time."
            => |d| d.a3m60.write(|write, _| if (write.number, write.subindex) == (1008, 0) && write.values == [1] {
                write.subindex = 1;
            });
        "highest-setting-refused" "The highest value of each element of P1008 is refused."
            => |d| d.sick.setting(|at, value, right| right && !matches!((at, value), ((1008, 1), 100) | ((1008, 2 | 3), 200)));
        "settings-not-checked" "P1008 accepts any value."
            => |d| d.sick.setting(|at, _, right| right || at.0 == 1008 && at.1 > 0);
        "limits-clip-values" "A value of P1008 beyond its limits is clipped to the limit."
            => |d| {
                d.sick.setting(|at, _, right| right || at.0 == 1008 && at.1 > 0);
                d.sick.written(|at, value, _| match at {
                    (1008, 1) => value.clamp(1, 100),
                    (1008, 2 | 3) => value.clamp(1, 200),
                    _ => value,
                });
            };
        "setting-of-8-bits-with-a-sign" "P1008.2 above 127 reads as a negative number."
            => |d| d.encoder.element(|_, at, right| if at == (1008, 2) && right > 127 { right | 0xFF00 } else { right });
        "third-setting-is-the-second" "A write to P1008.3 changes P1008.2."
            => |d| d.a3m60.write(|write, _| third_setting_is_the_second(write));
        "settings-kept-in-part" "P1008.1 is retained at power-off, P1008.2 and P1008.3 are not."
            => |d| {
                let mut retained = SpeedCalculation::default();
                d.a3m60.happens(move |event, memory| match event {
                    A3m60Event::PowerDown => retained = *memory.speed,
                    A3m60Event::PowerUp => memory.speed.values[0] = retained.values[0],
                    A3m60Event::Start | A3m60Event::Advance => {}
                });
            };

        // P1009
        "fraction-shown-reduced" "P1009 shows the reduced fraction."
            => |d| {
                let fields = d.track(UserByteFields::DELIVERED, |encoder, _, _| encoder.model.fields);
                d.encoder.element(move |_, at, right| match at {
                    (1009, 1 | 2) => right / common_divisor(fields.get().nominator, fields.get().divisor),
                    _ => right,
                });
            };
        "values-in-use-not-shown" "P1009 contains 0 for the values in use."
            => |d| d.encoder.element(|_, at, right| if let (1009, 6..=8) = at { 0 } else { right });
        "round-axis-mode-as-1-and-2" "P1009 reads 1 for off and 2 for on."
            => |d| d.encoder.element(|_, at, right| if at == (1009, 0) { right + 1 } else { right });
        "range-offset-with-a-sign" "The range offset is a negative number."
            => |d| d.encoder.element(|_, at, right| if at == (1009, 4) { u64::from((right as u32 | 1).wrapping_neg()) } else { right });
        "internal-shift-undefined" "The internal shift in P1009 changes at random."
            => |d| d.encoder.element(|view, at, right| if at == (1009, 5) { (view.now.as_nanos() / 1000) & 0xFFFF_FFFF } else { right });
        "fraction-of-the-steps-is-0" "The digits after the decimal point of the steps per revolution are always 0."
            => |d| d.encoder.element(|_, at, right| if at == (1009, 10) { 0 } else { right });

        // Access
        "unknown-parameter-1003-read" "P1003 reads 0."
            => |d| d.encoder.refuse(|id, number, found| found.filter(|_| (id, number) != (RequestId::REQUEST, 1003)));
        "busy-answered-with-another-error" "While a value is being stored, a read is refused with an invalid index."
            => |d| d.a3m60.add(BusyWhileStoring::default());
        "unknown-index-answered" "Any data set index gives access to the parameters."
            => |d| d.a3m60.check(|check, right| right || matches!(check, A3m60Check::DataSet { .. }));
        "every-slot-keeps-silent" "A request for a data set of slots other than 0 and 1 is never answered."
            => |d| d.slave.request(SlaveSap::SERVER, |data| {
                // An empty request is acknowledged and not answered.
                if data.get(1).is_some_and(|slot| *slot > 1) {
                    data.clear();
                }
                true
            });
        "hangs-after-short-request" "After a request of fewer than four bytes no request is answered."
            => |d| d.encoder.add(HangsAfterRequest::after(|octets| octets.len() < 4));
        "parameters-with-telegrams-only" "Parameters cannot be accessed with the vendor telegrams."
            => |d| d.a3m60.check(|check, right| right && !matches!(check, A3m60Check::DataSet { telegram: 0, .. }));
    },
}];

fn p971_refused(id: RequestId, number: u16, found: Option<ParameterError>) -> Option<ParameterError> {
    match (id, number) {
        (RequestId::CHANGE, 971) => Some(ParameterError { number: ErrorNumber::READ_ONLY, subindex: None }),
        _ => found,
    }
}

fn faults_of(status_a: u16) -> u64 {
    u64::from(status_a & 0x7FC0 != 0) | u64::from(status_a & 0x8080 != 0) << 5
}

fn array_shifted_by_one(view: &EncoderView<'_>, at: (u16, usize), right: u64) -> u64 {
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

fn common_divisor(a: u32, b: u32) -> u64 {
    let (mut a, mut b) = (u64::from(a.max(1)), u64::from(b.max(1)));
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
}

/// Collects the status bits since the start of the data exchange.
fn collect_status(
    encoder: &PoweredEncoder<'_, A3m60State>,
    words: SensorStatusWords,
    before: SensorStatusWords,
) -> SensorStatusWords {
    match encoder.ram.phase {
        ConnectionPhase::Parameters(_) => words,
        ConnectionPhase::Alone | ConnectionPhase::Data(_) => {
            SensorStatusWords { a: before.a | words.a, b: before.b | words.b }
        }
    }
}

fn telegram_of_the_start_before(d: &mut Deviations) {
    let before = Rc::new(Cell::new(0));
    let shown = before.clone();
    let mut last = 0;
    d.a3m60.happens(move |event, memory| match event {
        A3m60Event::PowerUp => {
            last = 0;
            before.set(0);
        }
        A3m60Event::Start => before.set(mem::replace(&mut last, memory.telegram.number)),
        A3m60Event::PowerDown | A3m60Event::Advance => {}
    });
    d.encoder.element(move |_, at, right| if at == (922, 0) { shown.get().into() } else { right });
}

fn third_setting_is_the_second(write: &mut VendorWrite) {
    let third = 3_u16.checked_sub(write.subindex).map(usize::from);
    let Some(third) = third.filter(|at| write.number == 1008 && *at < write.values.len()) else { return };
    let value = write.values.remove(third);
    match write.values.last_mut() {
        Some(second) => *second = value,
        None => (write.subindex, write.values) = (2, vec![value]),
    }
}

/// Stores P65000 when 1 is written to P971.
struct SavedByP971(u32);

impl A3m60Hooks for SavedByP971 {
    fn write(&mut self, write: &mut VendorWrite, memory: &mut A3m60Memory<'_>) {
        if write.number == 971 && write.values == [1] {
            self.0 = *memory.preset_value;
        }
    }

    fn happens(&mut self, event: A3m60Event, memory: &mut A3m60Memory<'_>) {
        if event == A3m60Event::PowerUp {
            *memory.preset_value = self.0;
        }
    }
}

/// Sets the position to 0 for a second after a write to P1007.
struct DisturbedByP1007(Option<Time>);

impl A3m60Hooks for DisturbedByP1007 {
    fn write(&mut self, write: &mut VendorWrite, memory: &mut A3m60Memory<'_>) {
        if write.number == 1007 {
            self.0 = Some(memory.now + Duration::from_secs(1));
        }
    }

    fn image(&mut self, encoder: &PoweredEncoder<'_, A3m60State>, image: SignalImage) -> SignalImage {
        if self.0.is_some_and(|until| encoder.now < until) {
            SignalImage { g1_xist1: 0, g1_xist2: 0, plain_position: 0, ..image }
        } else {
            image
        }
    }
}

/// Loses the offset of the last preset at power-off, if it was made by one of two kinds of request.
struct OffsetNotKept {
    /// Whether a preset is requested whose offset is lost, and one whose offset is kept.
    is_requested: [Rc<Cell<bool>>; 2],
    /// The offset that is restored at power-off.
    before: Option<u64>,
}

impl A3m60Hooks for OffsetNotKept {
    fn happens(&mut self, event: A3m60Event, memory: &mut A3m60Memory<'_>) {
        if event == A3m60Event::PowerDown
            && let Some(before) = self.before.take()
        {
            memory.store.offset.replace(before);
        }
        // The preset follows.
        match self.is_requested.each_ref().map(|is_requested| is_requested.take()) {
            [true, _] => self.before = Some(*memory.store.offset.stored()),
            [false, true] => self.before = None,
            [false, false] => {}
        }
    }
}

/// Loses the offsets of presets by the button, or of presets by G1_STW.
fn offset_not_kept(d: &mut Deviations, of_button: bool) {
    struct Button(Rc<Cell<bool>>);

    impl SlaveHooks for Button {
        fn act(&mut self, action: &StandAction<'_>) {
            if let StandAction::Button("preset", false) = action {
                self.0.set(true);
            }
        }
    }

    let [button, command]: [Rc<Cell<bool>>; 2] = Default::default();
    d.slave.add(Button(button.clone()));
    let mut was_requested = false;
    let requests = command.clone();
    d.encoder.outputs(move |_, _, arrived| {
        let is_requested = arrived.words.is_some_and(|[_, g1_stw]| g1_stw & 1 << 12 != 0);
        requests.set(requests.get() || is_requested && !mem::replace(&mut was_requested, is_requested));
        was_requested = is_requested;
        arrived
    });
    let is_requested = if of_button { [button, command] } else { [command, button] };
    d.a3m60.add(OffsetNotKept { is_requested, before: None });
}

/// Refuses to read a data set while P65000 is being stored.
#[derive(Default)]
struct BusyWhileStoring {
    is_storing: bool,
}

impl A3m60Hooks for BusyWhileStoring {
    fn happens(&mut self, _: A3m60Event, memory: &mut A3m60Memory<'_>) {
        self.is_storing = memory.store.preset_value.deadline().is_some();
    }

    fn check(&mut self, check: A3m60Check, verdict: bool) -> bool {
        verdict && !(self.is_storing && matches!(check, A3m60Check::DataSet { is_read: true, .. }))
    }
}

/// The written values by parameter and element.
type WrittenConstants = Rc<RefCell<Vec<((u16, usize), u64)>>>;

fn constants_can_be_written(d: &mut Deviations) {
    let written = WrittenConstants::default();
    d.slave.add(WritesConstants { written: written.clone(), is_awaited: false });
    d.encoder.element(move |_, at, right| {
        let written = written.borrow();
        written.iter().rev().find(|(known, _)| *known == at).map_or(right, |(_, value)| *value)
    });
}

/// Answers a write to P964, P975 or P979 positively.
struct WritesConstants {
    written: WrittenConstants,
    is_awaited: bool,
}

impl WritesConstants {
    /// Stores the values of a request that changes one of these parameters.
    fn take(&mut self, request: &[u8]) {
        let [_, 2, _, 1, _, _, high, low, _, subindex, format, _, values @ ..] = request else { return };
        let number = u16::from_be_bytes([*high, *low]);
        let octets = if *format == ParameterFormat::DOUBLE_WORD.0 { 4 } else { 2 };
        self.is_awaited = matches!(number, 964 | 975 | 979);
        if self.is_awaited {
            let values =
                values.chunks(octets).map(|value| value.iter().fold(0, |sum, octet| sum << 8 | u64::from(*octet)));
            let elements = (usize::from(*subindex)..).map(|at| (number, at));
            self.written.borrow_mut().extend(elements.zip(values));
        }
    }
}

impl SlaveHooks for WritesConstants {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        if let Some((frame, SapService::Slave(SlaveSap::SERVER))) = request(telegram)
            && let Ok(Dpv1Pdu::Write(record)) = Dpv1Pdu::parse(frame.data, PduDirection::Request)
        {
            self.take(&record.data);
        }
        vec![telegram.to_vec()]
    }

    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        let Some(frame) = frame(telegram).filter(|_| self.is_awaited) else { return };
        let Ok(Dpv1Pdu::Read(record)) = Dpv1Pdu::parse(frame.data, PduDirection::Response) else { return };
        if let [reference, 0x82, axis, ..] = record.data[..] {
            let data = vec![reference, 2, axis, 1];
            let mut octets = Vec::new();
            Dpv1Pdu::Read(Dpv1Record { length: data.len() as u8, data, ..record }).write(&mut octets);
            *telegram = with_data(&frame, &octets);
        }
        self.is_awaited = false;
    }

    fn starts(&mut self) {
        self.written.borrow_mut().clear();
    }
}

/// Returns a gear with `units` units per revolution.
pub fn gear_of(units: u64, range: u64) -> Gear {
    Gear { nominator: range.max(1), divisor: units, range }
}
