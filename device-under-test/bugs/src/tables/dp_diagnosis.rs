//! Bugs of the extended PROFIBUS diagnosis (blocks after the first six bytes) and of the sensor status.

use super::Group;
use super::signal_image::{ERROR, has_error};
use crate::needs::Need;
use crate::seams::Deviations;
use crate::seams::slave::{frame, request, with_data};
use alloc::rc::Rc;
use alloc::vec;
use alloc::vec::Vec;
use core::cell::Cell;
use device_stack::profibus::{SlaveApplication, SlaveHooks};
use encoder_profile::checks::EncoderCheck;
use encoder_profile::encoder_object::PoweredEncoder;
use encoder_profile::facts::{ErrorCause, ErrorFact};
use encoder_profile::profidrive::telegram::SignalImage;
use reference_devices::manuals;
use reference_devices::models::sick_a3m60::A3m60State;
use reference_devices::models::sick_a3m60::hooks::{A3m60Check, A3m60Event, A3m60Hooks, A3m60Memory};
use reference_devices::models::sick_a3m60::set_prm::UserByteFields;
use reference_devices::models::sick_a3m60::status::{self, SensorStatusWords};
use wire::profibus::fdl::{AnswerFunction, DataFrame, Extension, FunctionCode, StationType};
use wire::profibus::sap::{MasterSap, SapService, SlaveSap};

/// The bugs, by what they need.
pub static GROUPS: &[Group] = &[Group {
    needs: &[Need::Of(&manuals::SICK_A3M60)],
    deviations: bugs! {
        // Blocks
        "block-header-wrong" "The first byte of a block is C1h."
            => |d| d.slave.diagnosis(|diag, _| diag.ext.chunks_mut(BLOCK).for_each(|block| block[0] = 0xC1));
        "channel-counts-errors" "The second byte of a block is 41h."
            => |d| d.slave.diagnosis(|diag, _| diag.ext.chunks_mut(BLOCK).for_each(|block| block[1] = 0x41));
        "empty-block-without-an-error" "After the last error there is an additional block with the number 0."
            => |d| {
                let has_channel = d.track(false, |encoder, _, _| encoder.model.fields.switches[0] & ALARM_CHANNEL != 0);
                d.slave.diagnosis(move |diag, _| if has_channel.get() { diag.ext.extend([0x81, 0x40, 0]) });
            };
        "one-header-for-two-blocks" "The second block has no header, only its number."
            => |d| d.slave.diagnosis(|diag, _| {
                let numbers: Vec<u8> = diag.ext.chunks(BLOCK).skip(1).filter_map(|block| block.last().copied()).collect();
                diag.ext.truncate(BLOCK);
                diag.ext.extend(numbers);
            });
        "no-block-for-several-causes" "Several causes with the same number have no block."
            => |d| d.a3m60.diagnosis(|encoder, numbers| without(numbers, status::POSITION_ERROR, (status::words(encoder).a & status::POSITION).count_ones() > 1));
        "two-blocks-at-most" "There are at most two blocks."
            => |d| d.a3m60.diagnosis(|_, mut numbers| {
                numbers.truncate(2);
                numbers
            });
        "position-error-as-memory-error" "A position error has the number of a memory error."
            => |d| d.encoder.error_type(|right| Some(if right == 0x36 { 0x38 } else { right }));
        "life-sign-fault-as-missing-clock" "A lost sign of life has the number of a missing clock."
            => |d| d.encoder.error_type(|right| Some(if right == 0x3B { 0x3C } else { right }));
        "eeprom-error-not-in-38" "An EEPROM that does not answer is reported only as a position error."
            => |d| d.a3m60.diagnosis(|encoder, numbers| without(numbers, status::MEMORY_ERROR, status::words(encoder).a & 0x8080 == EEPROM));
        "overspeed-forward-only" "Overspeed is detected only in forward direction."
            => |d| d.checks.check(|check, right| match check { EncoderCheck::TooFast(rpm) => right && rpm > 0, _ => right });
        "diagnosis-frozen-at-start" "The blocks are not updated after the start of the data exchange."
            => |d| d.a3m60.add(FrozenAtStart(Some(Vec::new())));
        "diagnosis-stays" "A block stays after its error has disappeared."
            => |d| d.a3m60.add(StickyDiagnosis::default());
        "diagnosis-in-telegrams-only" "With the vendor telegrams there are no blocks."
            => |d| d.a3m60.diagnosis(|encoder, numbers| if encoder.ram.telegram().number == 0 { Vec::new() } else { numbers });
        "show-fault-code-hides-the-diagnosis" "If fault codes are switched off, there are no blocks either."
            => |d| d.a3m60.diagnosis(|encoder, numbers| if encoder.model.fields.shows_codes() { numbers } else { Vec::new() });
        "alarm-channel-ignored" "Blocks are always sent, even with the alarm channel off."
            => |d| d.checks.check(|check, right| right || matches!(check, EncoderCheck::AlarmChannel { .. }));
        "alarm-channel-silences-codes" "With the alarm channel off, the sensor status is 0 and there is no fault code either."
            => |d| {
                d.encoder.element(|view, at, right| match at {
                    (1000 | 1001, 0) if view.user.compatible && !view.user.alarm_channel => 0,
                    _ => right,
                });
                d.a3m60.image(|encoder, now| if is_silent(&encoder.model.fields) { without_code(now) } else { now });
            };
        "alarm-channel-off-in-v41-mode" "Without compatibility mode the alarm channel can be switched off."
            => |d| d.checks.check(|check, right| match check { EncoderCheck::AlarmChannel { is_on, .. } => is_on, _ => right });
        "warning-blocks-the-data" "During overspeed the outputs are refused."
            => |d| {
                let words = d.track_status();
                d.slave.add(RefusesOutputs { words, is_refusing: false });
            };

        // S_STAT-A
        "flash-only-checked" "The checksum of the EEPROM is not checked."
            => |d| {
                unnoticed(d, &["eeprom_checksum"]);
                d.encoder.raise(|error| !is_of(error, "eeprom_checksum"));
            };
        "fram-in-bit-7" "An FRAM that does not answer sets bit 7 instead of bit 14."
            => |d| d.a3m60.status(|_, words| SensorStatusWords { a: if words.a & 0x4000 == 0 { words.a } else { words.a & !0x4000 | 1 << 7 }, ..words });
        "synchronization-bits-exchanged" "Bits 11 and 13 are swapped."
            => |d| d.a3m60.status(|_, words| SensorStatusWords { a: words.a & !0x2800 | (words.a & 0x2000) >> 2 | (words.a & 0x0800) << 2, ..words });
        "synchronization-corrected-silently" "Deviations of the counters are not reported."
            => |d| {
                unnoticed(d, &SYNCHRONIZATION);
                d.encoder.raise(|error| !SYNCHRONIZATION.iter().any(|name| is_of(error, name)));
            };
        "linearization-not-watched" "A wrong linearization is not detected."
            => |d| {
                unnoticed(d, &["linearization"]);
                d.encoder.raise(|error| !is_of(error, "linearization"));
            };
        "vector-length-low-not-checked" "A vector that is too short is not detected."
            => |d| {
                unnoticed(d, &["vector_length"]);
                d.encoder.raise(|error| !is_of(error, "vector_length"));
            };
        "vector-length-high-not-checked" "A vector that is too long is not detected."
            => |d| {
                unnoticed(d, &["vector_length_long"]);
                d.encoder.raise(|error| !is_of(error, "vector_length_long"));
            };
        "sine-only-watched" "The amplitude of the cosine is not checked."
            => |d| {
                unnoticed(d, &["amplitude_cosine"]);
                d.encoder.raise(|error| !is_of(error, "amplitude_cosine"));
            };
        "eeprom-noticed-at-start-only" "An EEPROM that does not answer is detected only at power-up."
            => |d| d.a3m60.add(NoticedAtStart::default());
        "bit-12-set-with-errors" "Bit 12 is set with each error."
            => |d| d.encoder.element(|_, at, right| if at == (1000, 0) && right != 0 { right | 1 << 12 } else { right });

        // P65001
        "memory-error-in-bit-0" "A memory fault is shown as a position fault."
            => |d| d.encoder.element(|_, at, right| if at == (65001, 2) { u64::from(right != 0) } else { right });
        "position-error-for-bit-6-only" "Only a wrong amplitude is a position fault."
            => |d| {
                let words = d.track_status();
                d.encoder.element(move |_, at, right| if at == (65001, 2) && words.get().a & 1 << 6 == 0 { right & !1 } else { right });
            };
        "unsupported-fault-bits-set" "Bit 1 of the faults is set with each fault."
            => |d| d.encoder.element(|_, at, right| if at == (65001, 2) && right != 0 { right | 2 } else { right });
        "overspeed-as-fault" "Overspeed is a fault instead of a warning."
            => |d| {
                let words = d.track_status();
                d.encoder.element(move |_, at, right| match at {
                    (65001, 2) => right | u64::from(words.get().a & status::OVERSPEED != 0) << 1,
                    (65001, 4) => 0,
                    _ => right,
                });
            };
        "announced-warning-bit-used" "Bit 1 of the warnings is set while there is a fault."
            => |d| {
                let words = d.track_status();
                d.encoder.element(move |_, at, right| if at == (65001, 4) && words.get().a & !status::OVERSPEED != 0 { right | 2 } else { right });
            };
        "other-fault-bits-in-compatibility-mode" "In compatibility mode a position fault is in bit 4."
            => |d| d.encoder.element(|view, at, right| match at {
                (65001, 2) if view.user.compatible => right & !1 | (right & 1) << 4,
                _ => right,
            });
    },
}];

/// Length of a block in bytes.
const BLOCK: usize = 3;
/// Bit of the alarm channel in the first switch byte of Set_Prm.
const ALARM_CHANNEL: u8 = 1 << 4;
/// Bit of S_STAT-A for an EEPROM that does not answer.
const EEPROM: u16 = 1 << 7;

const SYNCHRONIZATION: [&str; 3] = ["synchronization_large", "synchronization_shutdown", "synchronization_start"];

fn is_of(error: &ErrorFact, name: &'static str) -> bool {
    error.causes.contains(&ErrorCause::Stand(name))
}

/// Ignores the faults of these names.
fn unnoticed(d: &mut Deviations, names: &'static [&'static str]) {
    d.a3m60.check(|check, right| right && !matches!(check, A3m60Check::Fault(name) if names.contains(&name)));
}

/// Whether blocks are not sent: the alarm channel is off in compatibility mode.
fn is_silent(fields: &UserByteFields) -> bool {
    fields.switches[0] & (ALARM_CHANNEL | 0x20) == 0
}

fn without(mut numbers: Vec<u8>, number: u8, is_left_out: bool) -> Vec<u8> {
    numbers.retain(|known| *known != number || !is_left_out);
    numbers
}

/// Removes the error code from the signals.
pub fn without_code(image: SignalImage) -> SignalImage {
    if has_error(&image) {
        let transfers = image.is_transferred;
        let g1_xist2 = if transfers { image.position as u32 } else { 0 };
        SignalImage { g1_zsw: image.g1_zsw & !ERROR | u16::from(transfers) << 13, g1_xist2, ..image }
    } else {
        image
    }
}

/// Repeats the diagnosis from the start of the data exchange.
struct FrozenAtStart(Option<Vec<u8>>);

impl A3m60Hooks for FrozenAtStart {
    fn happens(&mut self, event: A3m60Event, _: &mut A3m60Memory<'_>) {
        if event == A3m60Event::Start {
            self.0 = None;
        }
    }

    fn diagnosis(&mut self, _: &PoweredEncoder<'_, A3m60State>, numbers: Vec<u8>) -> Vec<u8> {
        self.0.get_or_insert(numbers).clone()
    }
}

/// Reports all numbers since the start of the data exchange.
#[derive(Default)]
struct StickyDiagnosis(Vec<u8>);

impl A3m60Hooks for StickyDiagnosis {
    fn happens(&mut self, event: A3m60Event, _: &mut A3m60Memory<'_>) {
        if event == A3m60Event::Start {
            self.0.clear();
        }
    }

    fn diagnosis(&mut self, _: &PoweredEncoder<'_, A3m60State>, numbers: Vec<u8>) -> Vec<u8> {
        self.0.extend(numbers);
        self.0.sort_unstable();
        self.0.dedup();
        self.0.clone()
    }
}

/// Detects an EEPROM that does not answer only at power-up.
#[derive(Default)]
struct NoticedAtStart {
    is_new: bool,
    was_there: bool,
}

impl A3m60Hooks for NoticedAtStart {
    fn happens(&mut self, event: A3m60Event, _: &mut A3m60Memory<'_>) {
        if event == A3m60Event::PowerUp {
            (self.is_new, self.was_there) = (true, false);
        }
    }

    fn check(&mut self, check: A3m60Check, verdict: bool) -> bool {
        if check != A3m60Check::Fault("eeprom") {
            return verdict;
        }
        self.was_there |= self.is_new && verdict;
        verdict && self.was_there
    }

    fn status(&mut self, _: &PoweredEncoder<'_, A3m60State>, words: SensorStatusWords) -> SensorStatusWords {
        self.is_new = false;
        words
    }
}

/// Refuses outputs during overspeed: the exchange becomes a read of the inputs, answered without data.
struct RefusesOutputs {
    words: Rc<Cell<SensorStatusWords>>,
    is_refusing: bool,
}

impl SlaveHooks for RefusesOutputs {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        let exchange = request(telegram).filter(|(_, service)| *service == SapService::DataExchange);
        self.is_refusing = exchange.is_some() && self.words.get().a & status::OVERSPEED != 0;
        let Some((frame, _)) = exchange.filter(|_| self.is_refusing) else { return vec![telegram.to_vec()] };
        let (destination, source) = (Extension::sap(SlaveSap::READ_INPUTS.0), Extension::sap(MasterSap::MS0.0));
        vec![with_data(&DataFrame { destination, source, ..frame }, &[])]
    }

    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        if let Some(frame) = frame(telegram).filter(|_| self.is_refusing) {
            let fc = FunctionCode::answer(AnswerFunction::NO_SERVICE, StationType::SLAVE);
            *telegram =
                with_data(&DataFrame { fc, destination: Extension::NONE, source: Extension::NONE, ..frame }, &[]);
        }
    }
}
