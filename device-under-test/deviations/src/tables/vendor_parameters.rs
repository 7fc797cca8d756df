//! Bugs of what the parameters of a vendor say and keep, and of the data set through which they are reached.

use super::Group;
use super::parameter_memory::Hangs;
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
use reference_devices::models::sick_a3m60::hooks::{A3m60Check, A3m60Hooks, Event, Memory, Write};
use reference_devices::models::sick_a3m60::set_prm::Fields;
use reference_devices::models::sick_a3m60::status::Words;
use reference_devices::models::sick_a3m60::{Speed, State};
use station::{StandAction, Time};
use wire::profibus::dpv1::{Dpv1Pdu, Dpv1Record, PduDirection};
use wire::profibus::sap::{SapService, SlaveSap};
use wire::profidrive::{ErrorNumber, ParameterError, ParameterFormat, RequestId};

/// The bugs, by what they need.
pub static GROUPS: &[Group] = &[Group {
    needs: &[Need::Of(&manuals::SICK_A3M60)],
    deviations: bugs! {
        // Station and profile
        "address-as-digits" "P918 gives the places of the two switches as digits."
            => |d| d.encoder.element(|_, at, right| if at == (918, 0) { ((right / 10) << 4) | (right % 10) } else { right });
        "telegram-of-the-start-before" "P922 gives the telegram of the start before."
            => |d| telegram_of_the_start_before(d);
        "life-sign-tolerance-not-shown" "P925 reads 0."
            => |d| d.encoder.element(|_, at, right| if at == (925, 0) { 0 } else { right });
        "life-sign-tolerance-default-shown" "P925 reads 1, whatever is set."
            => |d| d.encoder.element(|_, at, right| if at == (925, 0) { 1 } else { right });
        "object-type-swapped" "The octets of the type are exchanged in P964."
            => |d| d.encoder.element(|_, at, right| if at == (964, 1) { u64::from((right as u16).swap_bytes()) } else { right });
        "profile-octets-swapped" "The octets of P965 are exchanged."
            => |d| d.encoder.element(|_, at, right| if at == (965, 0) { u64::from((right as u16).swap_bytes()) } else { right });
        "profile-version-follows-compatibility" "P65001 gives version 3.1 of the profile in compatibility mode."
            => |d| d.encoder.element(|view, at, right| if at == (65001, 6) && view.user.compatible { 0x301 } else { right });
        "vendor-of-the-stack" "P964 and P975 name the vendor of the stack."
            => |d| d.encoder.element(|_, at, right| if let (964 | 975, 0) = at { 0x0106 } else { right });
        "drive-object-0" "P964 gives 0 for the number of drive objects."
            => |d| d.encoder.element(|_, at, right| if at == (964, 5) { 0 } else { right });
        "array-shifted-by-one" "Element 0 of P964 is the number of its elements, and the others follow."
            => |d| d.encoder.element(array_shifted_by_one);
        "year-in-bcd" "The year of the software is given in binary coded decimals."
            => |d| d.encoder.element(|_, at, right| if let (964 | 975, 3) = at { in_bcd(right) } else { right });
        "subclass-of-class-4" "P975 has the bits of the classes at the wrong end."
            => |d| d.encoder.element(|_, at, right| if at == (975, 6) { u64::from((right as u16).reverse_bits()) } else { right });
        "sensor-type-with-bit-0" "P979 describes a linear scale."
            => |d| d.encoder.element(|_, at, right| if at == (979, 1) { right | 1 } else { right });
        "resolution-follows-scaling" "P979 gives the steps that are set."
            => |d| d.encoder.element(|view, at, right| if at == (979, 2) { view.user.units_per_revolution } else { right });
        "shift-factors-11" "P979 gives a shift factor of 0 for G1_XIST1."
            => |d| d.encoder.element(|_, at, right| if at == (979, 3) { 0 } else { right });
        "second-shift-1" "P979 gives a shift factor of 1 for G1_XIST2."
            => |d| d.encoder.element(|_, at, right| if at == (979, 4) { 1 } else { right });
        "revolutions-in-bits" "P979 gives the number of revolutions in bits."
            => |d| d.encoder.element(|_, at, right| if at == (979, 5) { right.trailing_zeros().into() } else { right });
        "constants-can-be-written" "P964, P975 and P979 can be written."
            => |d| constants_can_be_written(d);

        // P971, P65000
        "p971-resets" "A write to P971 sets the offset to 0."
            => |d| d.a3m60.write(|write, memory| if write.number == 971 { memory.measuring.offset = 0 });
        "p971-refused" "A write to P971 is refused as read only."
            => |d| d.encoder.refuse(p971_refused);
        "p971-reads-memory" "P971 reads 5A5Ah."
            => |d| d.encoder.element(|_, at, right| if at == (971, 0) { 0x5A5A } else { right });
        "preset-value-of-31-bits" "The highest bit of P65000 is lost."
            => |d| d.encoder.value(65000, |value| value & 0x7FFF_FFFF);
        "preset-value-never-stored" "P65000 is lost at power-off."
            => |d| d.a3m60.happens(|event, memory| if event == Event::PowerUp { *memory.preset_value = 0 });
        "saves-by-p971-only" "P65000 is stored when 1 is written to P971."
            => |d| d.a3m60.add(SavedByP971(0));
        "torn-write-taken" "A supply that goes while P65000 is being stored leaves half of it."
            => |d| d.a3m60.happens(|event, memory| {
                let cell = &mut memory.store.preset_value;
                if event == Event::PowerDown && cell.deadline().is_some() {
                    cell.replace(*memory.preset_value & 0xFFFF_0000 | *cell.stored() & 0xFFFF);
                }
            });
        "offset-of-g1-stw-not-kept" "The offset of a preset by G1_STW is lost at power-off."
            => |d| offset_not_kept(d, false);
        "offset-of-the-button-not-kept" "The offset of a preset by the button is lost at power-off."
            => |d| offset_not_kept(d, true);

        // Status
        "sensor-status-stays" "P1000 and P1001 keep the bits of what has gone."
            => |d| {
                let seen = d.note(Words::default(), seen);
                d.encoder.element(move |_, at, right| match at {
                    (1000, 0) => seen.get().a.into(),
                    (1001, 0) => seen.get().b.into(),
                    _ => right,
                });
            };
        "sensor-status-inverted" "P1000 has all its bits inverted."
            => |d| d.encoder.element(|_, at, right| if at == (1000, 0) { right ^ 0xFFFF } else { right });
        "bus-status-set-without-isochronous" "P1001 has bit 5 set outside of isochronous operation."
            => |d| {
                let is_isochronous = d.note(false, |encoder, _, _| encoder.model.clock.times().is_some());
                d.encoder.element(move |_, at, right| if at == (1001, 0) && !is_isochronous.get() { right | 1 << 5 } else { right });
            };
        "faults-stay-after-acknowledgement" "P65001 keeps the bits of errors that have gone."
            => |d| {
                let seen = d.note(Words::default(), seen);
                d.encoder.element(move |_, at, right| if at == (65001, 2) { right | faults_of(seen.get().a) } else { right });
            };
        "faults-always-set" "P65001 has bit 1 of the faults always set."
            => |d| d.encoder.element(|_, at, right| if at == (65001, 2) { right | 2 } else { right });
        "warning-at-rest" "P65001 has bit 0 of the warnings set."
            => |d| d.encoder.element(|_, at, right| if at == (65001, 4) { right | 1 } else { right });
        "supported-faults-0" "P65001 gives 0 for the supported faults and warnings."
            => |d| d.encoder.element(|_, at, right| if let (65001, 3 | 5) = at { 0 } else { right });
        "operating-status-0" "P65001 shows the switches of delivery, whatever they are."
            => |d| d.encoder.element(|_, at, right| if at == (65001, 1) { 0x0C02 } else { right });
        "operating-status-cut-short" "P65001 ends after eight elements."
            => |d| d.encoder.cut(65001, 8);
        "operating-time-in-hours" "P65001 counts hours."
            => |d| d.encoder.element(|_, at, right| if at == (65001, 7) { right / 10 } else { right });
        "operating-time-not-kept" "The operating time in P65001 is 0 after power-up."
            => |d| d.a3m60.happens(|event, memory| if event == Event::PowerUp { memory.log.operating = Duration::ZERO });

        // P1002
        "service-log-cut-short" "P1002 has four elements."
            => |d| d.encoder.cut(1002, 4);
        "power-ups-count-starts" "Each start counts as a power-up."
            => |d| d.a3m60.happens(|event, memory| if event == Event::Start { memory.log.power_ups += 1 });
        "seconds-of-power-counted" "P1002 counts the seconds with power."
            => |d| d.sick.check(|check, right| right || matches!(check, sick::Check::Motion(_)));
        "seconds-counted-at-any-speed" "P1002 counts each second of motion."
            => |d| d.sick.check(|check, right| match check {
                sick::Check::Motion(rpm) => rpm > 0,
                _ => right,
            });
        "highest-speed-forward-only" "Only forward there is a highest speed."
            => |d| d.sick.check(|check, right| match check {
                sick::Check::HighestSpeed(rpm) => right && rpm > 0,
                _ => right,
            });
        "highest-speed-not-kept" "The highest speed is 1 after power-up."
            => |d| d.a3m60.happens(|event, memory| if event == Event::PowerUp { memory.log.highest_speed = 1 });
        "highest-speed-not-kept-above-the-table" "A speed above 9000 is not taken for the highest one."
            => |d| d.sick.check(|check, right| match check {
                sick::Check::HighestSpeed(rpm) => right && rpm.abs() <= 9000,
                _ => right,
            });
        "counters-count-both-ways" "Both counters of turns count each turn."
            => |d| d.sick.log(|_, mut log| {
                (log[3], log[4]) = (log[3] + log[4], log[3] + log[4]);
                log
            });
        "reverse-lowers-the-forward-counter" "A turn in reverse lowers the other counter."
            => |d| d.sick.log_element(3, |_, log| u64::from((log[3] as u32).wrapping_sub(log[4] as u32)));

        // P1007 and P1008
        "p1007-cut-short" "P1007 has four elements."
            => |d| d.encoder.cut(1007, 4);
        "p1007-disturbs-the-position" "A write to P1007 sets the position to 0 for a second."
            => |d| d.a3m60.add(DisturbedByP1007(None));
        "integration-times-exchanged" "The two integration times of delivery are exchanged."
            => |d| d.encoder.element(|_, at, right| match (at, right) { ((1008, 2), 200) => 10, ((1008, 3), 10) => 200, _ => right });
        "p1008-0-is-a-switch" "P1008.0 can be written, and changes the refresh time."
            => |d| d.a3m60.write(|write, _| if (write.number, write.subindex) == (1008, 0) && write.values == [1] {
                write.subindex = 1;
            });
        "highest-setting-refused" "The highest value of each element of P1008 is refused."
            => |d| d.sick.setting(|at, value, right| right && !matches!((at, value), ((1008, 1), 100) | ((1008, 2 | 3), 200)));
        "settings-not-checked" "P1008 takes any value."
            => |d| d.sick.setting(|at, _, right| right || at.0 == 1008 && at.1 > 0);
        "limits-clip-values" "A value of P1008 beyond its limits is taken as the limit."
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
        "third-setting-is-the-second" "A write to P1008.3 writes P1008.2."
            => |d| d.a3m60.write(|write, _| third_setting_is_the_second(write));
        "settings-kept-in-part" "P1008.1 outlasts the power, P1008.2 and P1008.3 do not."
            => |d| {
                let mut kept = Speed::default();
                d.a3m60.happens(move |event, memory| match event {
                    Event::PowerDown => kept = *memory.speed,
                    Event::PowerUp => memory.speed.values[0] = kept.values[0],
                    Event::Start | Event::Advance => {}
                });
            };

        // P1009
        "fraction-shown-reduced" "P1009 shows the reduced fraction."
            => |d| {
                let fields = d.note(Fields::DELIVERED, |encoder, _, _| encoder.model.fields);
                d.encoder.element(move |_, at, right| match at {
                    (1009, 1 | 2) => right / common_divisor(fields.get().nominator, fields.get().divisor),
                    _ => right,
                });
            };
        "values-in-use-not-shown" "P1009 gives 0 for what is in use."
            => |d| d.encoder.element(|_, at, right| if let (1009, 6..=8) = at { 0 } else { right });
        "round-axis-mode-as-1-and-2" "P1009 reads 1 for off and 2 for on."
            => |d| d.encoder.element(|_, at, right| if at == (1009, 0) { right + 1 } else { right });
        "range-offset-with-a-sign" "The range offset is a negative number."
            => |d| d.encoder.element(|_, at, right| if at == (1009, 4) { u64::from((right as u32 | 1).wrapping_neg()) } else { right });
        "range-offset-never-moves" "The range offset is always 0."
            => |d| d.encoder.element(|_, at, right| if at == (1009, 4) { 0 } else { right });
        "internal-shift-undefined" "The internal shift is another one each time."
            => |d| d.encoder.element(|view, at, right| if at == (1009, 5) { (view.now.as_nanos() / 1000) & 0xFFFF_FFFF } else { right });
        "fraction-of-the-steps-is-0" "The steps of a revolution have nothing behind the point."
            => |d| d.encoder.element(|_, at, right| if at == (1009, 10) { 0 } else { right });

        // Access
        "unknown-parameter-1003-read" "P1003 reads 0."
            => |d| d.encoder.refuse(|id, number, found| found.filter(|_| (id, number) != (RequestId::REQUEST, 1003)));
        "busy-answered-with-another-error" "While a value is being stored a read is refused with an invalid index."
            => |d| d.a3m60.add(Busy::default());
        "unknown-index-answered" "Any index goes to the parameters."
            => |d| d.a3m60.check(|check, right| right || matches!(check, A3m60Check::DataSet { .. }));
        "every-slot-keeps-silent" "A request for a record of another slot than 0 and 1 is never answered."
            => |d| d.slave.request(SlaveSap::SERVER, |data| {
                // An empty request is acknowledged and fetches nothing.
                if data.get(1).is_some_and(|slot| *slot > 1) {
                    data.clear();
                }
                true
            });
        "hangs-after-short-request" "After a request of fewer than four octets none is answered."
            => |d| d.encoder.add(Hangs::after(|octets| octets.len() < 4));
        "parameters-with-telegrams-only" "There are no parameters with the telegrams of the vendor."
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

fn in_bcd(number: u64) -> u64 {
    [1000, 100, 10, 1].iter().fold(0, |bcd, place| (bcd << 4) | (number / place % 10))
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

/// What was wrong since the exchange began.
fn seen(encoder: &PoweredEncoder<'_, State>, words: Words, before: Words) -> Words {
    match encoder.ram.phase {
        ConnectionPhase::Parameters(_) => words,
        ConnectionPhase::Alone | ConnectionPhase::Data(_) => Words { a: before.a | words.a, b: before.b | words.b },
    }
}

fn telegram_of_the_start_before(d: &mut Deviations) {
    let before = Rc::new(Cell::new(0));
    let shown = before.clone();
    let mut last = 0;
    d.a3m60.happens(move |event, memory| match event {
        Event::PowerUp => (last, _) = (0, before.set(0)),
        Event::Start => before.set(mem::replace(&mut last, memory.telegram.number)),
        Event::PowerDown | Event::Advance => {}
    });
    d.encoder.element(move |_, at, right| if at == (922, 0) { shown.get().into() } else { right });
}

fn third_setting_is_the_second(write: &mut Write) {
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
    fn write(&mut self, write: &mut Write, memory: &mut Memory<'_>) {
        if write.number == 971 && write.values == [1] {
            self.0 = *memory.preset_value;
        }
    }

    fn happens(&mut self, event: Event, memory: &mut Memory<'_>) {
        if event == Event::PowerUp {
            *memory.preset_value = self.0;
        }
    }
}

/// Sets the position to 0 for a second.
struct DisturbedByP1007(Option<Time>);

impl A3m60Hooks for DisturbedByP1007 {
    fn write(&mut self, write: &mut Write, memory: &mut Memory<'_>) {
        if write.number == 1007 {
            self.0 = Some(memory.now + Duration::from_secs(1));
        }
    }

    fn image(&mut self, encoder: &PoweredEncoder<'_, State>, image: SignalImage) -> SignalImage {
        match self.0.is_some_and(|until| encoder.now < until) {
            true => SignalImage { g1_xist1: 0, g1_xist2: 0, plain_position: 0, ..image },
            false => image,
        }
    }
}

/// Loses the offset of the last preset at power-off, if it was made in one of two ways.
struct OffsetNotKept {
    /// Whether a preset is asked for whose offset is lost, and one whose offset is kept.
    is_asked: [Rc<Cell<bool>>; 2],
    /// The offset that comes back.
    before: Option<u64>,
}

impl A3m60Hooks for OffsetNotKept {
    fn happens(&mut self, event: Event, memory: &mut Memory<'_>) {
        if event == Event::PowerDown
            && let Some(before) = self.before.take()
        {
            memory.store.offset.replace(before);
        }
        // The preset follows.
        match self.is_asked.each_ref().map(|is_asked| is_asked.take()) {
            [true, _] => self.before = Some(*memory.store.offset.stored()),
            [false, true] => self.before = None,
            [false, false] => {}
        }
    }
}

/// Loses the offsets of presets by the button, or those of the ones by G1_STW.
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
    let mut was_asked = false;
    let asks = command.clone();
    d.encoder.outputs(move |_, _, arrived| {
        let is_asked = arrived.words.is_some_and(|[_, g1_stw]| g1_stw & 1 << 12 != 0);
        asks.set(asks.get() || is_asked && !mem::replace(&mut was_asked, is_asked));
        was_asked = is_asked;
        arrived
    });
    let is_asked = if of_button { [button, command] } else { [command, button] };
    d.a3m60.add(OffsetNotKept { is_asked, before: None });
}

/// Refuses to read a data set while P65000 is being stored.
#[derive(Default)]
struct Busy {
    is_storing: bool,
}

impl A3m60Hooks for Busy {
    fn happens(&mut self, _: Event, memory: &mut Memory<'_>) {
        self.is_storing = memory.store.preset_value.deadline().is_some();
    }

    fn check(&mut self, check: A3m60Check, verdict: bool) -> bool {
        verdict && !(self.is_storing && matches!(check, A3m60Check::DataSet { is_read: true, .. }))
    }
}

/// What was written to which element.
type Written = Rc<RefCell<Vec<((u16, usize), u64)>>>;

fn constants_can_be_written(d: &mut Deviations) {
    let written = Written::default();
    d.slave.add(WritesConstants { written: written.clone(), is_awaited: false });
    d.encoder.element(move |_, at, right| {
        let written = written.borrow();
        written.iter().rev().find(|(known, _)| *known == at).map_or(right, |(_, value)| *value)
    });
}

/// Answers a write to P964, P975 or P979 as if it had been taken.
struct WritesConstants {
    written: Written,
    is_awaited: bool,
}

impl WritesConstants {
    /// Takes a request to change one of these parameters, the first one of its parameters alone.
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

/// A gear whose units per revolution are `units`.
pub fn gear_of(units: u64, range: u64) -> Gear {
    Gear { nominator: range.max(1), divisor: units, range }
}
