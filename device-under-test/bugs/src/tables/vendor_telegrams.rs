//! Bugs of the vendor telegrams of the A3M60: position or fault code, preset by trigger, speed, time stamp.

use super::Group;
use super::cyclic_state::ForgottenInPark;
use super::layouts::swap_words;
use super::signal_image::{ERROR, POSITION, has_error, is_parked};
use super::signals::put;
use crate::needs::Need;
use crate::seams::Deviations;
use crate::seams::encoder::SentSignal;
use alloc::rc::Rc;
use alloc::vec::Vec;
use core::cell::Cell;
use core::mem;
use core::time::Duration;
use encoder_profile::encoder::{Sampling, VelocityUnit};
use encoder_profile::encoder_object::PoweredEncoder;
use encoder_profile::profidrive::preset_trigger::TRIGGER;
use encoder_profile::profidrive::telegram::{InputSignal, OutputWord, PreviousCycle, SignalImage};
use reference_devices::manuals;
use reference_devices::models::sick::settings;
use reference_devices::models::sick_a3m60::hooks::{A3m60Check, A3m60Event, A3m60Hooks, A3m60Memory};
use reference_devices::models::sick_a3m60::status::{self, A3m60Fault, SensorStatusWords, noticed};
use reference_devices::models::sick_a3m60::{A3m60State, SpeedCalculation, powered, rpm};
use station::Time;

/// The deviations, by what they need.
pub static GROUPS: &[Group] = &[
    // Unused outputs
    Group {
        needs: &[Need::Output(OutputWord::Unused)],
        deviations: bugs! {
            "words-of-the-image-swapped" "The two words of each double word are swapped, in outputs and inputs."
                => |d| {
                    d.encoder.signal(|_, octets| swap_words(octets));
                    d.encoder.preset_word(|word, _| word.rotate_right(16));
                };
            "trigger-in-unused-outputs" "Bit 31 of the unused outputs also triggers a preset."
                => |d| d.encoder.preset_word(|word, unused| word | unused.unwrap_or(0) & TRIGGER);
            "preset-in-unused-outputs" "The preset is taken from the unused outputs."
                => |d| d.encoder.preset_word(|word, unused| unused.unwrap_or(word));
            "offset-in-io-04-only" "The preset offset has no effect in the telegram of eight bytes."
                => |d| d.encoder.signal(offset_in_io_04_only);
        },
    },
    // The time stamp
    Group {
        needs: &[Need::Input(InputSignal::TimeStamp)],
        deviations: bugs! {
            "speed-after-the-time-stamp" "The time stamp comes before the speed."
                => |d| d.encoder.order(|telegram| match telegram.inputs {
                    [InputSignal::Position, InputSignal::NistA, InputSignal::TimeStamp] => &[InputSignal::Position, InputSignal::TimeStamp, InputSignal::NistA],
                    right => right,
                });
            "time-stamp-in-milliseconds" "The time stamp counts milliseconds."
                => |d| d.a3m60.image(|encoder, now| SignalImage { time_stamp: powered(encoder).as_millis() as u16, ..now });
            "time-stamp-by-two" "The time stamp is incremented by two every two seconds."
                => |d| d.a3m60.image(|encoder, now| SignalImage { time_stamp: (powered(encoder).as_secs() / 2 * 2) as u16, ..now });
            "time-stamp-saturates" "The time stamp stays at FFFFh."
                => |d| d.a3m60.image(|encoder, now| SignalImage { time_stamp: powered(encoder).as_secs().min(0xFFFF) as u16, ..now });
            "time-stamp-kept" "The time stamp continues after a power cycle."
                => |d| d.a3m60.image(|encoder, now| SignalImage { time_stamp: encoder.model.log.operating.as_secs() as u16, ..now });
            "time-stamp-reset-by-parameters" "Each start sets the time stamp to 0."
                => |d| d.a3m60.add(StampOfStart(None));
            "time-stamp-with-motion-only" "The time stamp is frozen at standstill."
                => |d| d.a3m60.add(StandingStamp::new(|encoder| rpm(encoder).abs() >= MOTION));
            "time-stamp-stops-with-an-error" "The time stamp is frozen during an error."
                => |d| d.a3m60.add(StandingStamp::new(|encoder| status::words(encoder) == SensorStatusWords::default()));
        },
    },
    // Codes, speed and G1_XIST1 of this manual
    Group {
        needs: &[Need::Of(&manuals::SICK_A3M60)],
        deviations: bugs! {
            "telegram-83-not-shifted" "In telegram 83 G1_XIST1 is not shifted."
                => |d| d.encoder.signal(|of, octets| if of.telegram.number == 83 && of.signal == InputSignal::G1Xist1 { put(octets, of.image.g1_xist1) });
            "trigger-bit-echoed" "Bit 31 of the outputs is mirrored in the inputs."
                => |d| d.encoder.signals(|_, now| SignalImage { plain_position: now.plain_position | now.trigger & TRIGGER, ..now });
            "half-steps-in-xist1" "The lowest bit of G1_XIST1 is always 1."
                => |d| d.encoder.signal(|of, octets| if of.signal == InputSignal::G1Xist1 { octets[3] |= 1 });
            "park-and-position-bits-exchanged" "Bits 13 and 14 of G1_STW are swapped."
                => |d| d.encoder.control_words(|_, [a, b]| [a, b & !0x6000 | (b & 0x2000) << 1 | (b & 0x4000) >> 1]);
            "reserved-stw2-bits-act" "Each reserved bit of STW2_ENC takes control away from the PLC, even in compatibility mode."
                => |d| d.encoder.control_words(|_, [a, b]| if a & 0x0B7F == 0 { [a, b] } else { [a & !0x0400, 0] });
            "parking-makes-a-speed" "The start and end of parking are reported as a velocity."
                => |d| d.encoder.signals(|before, now| SignalImage { velocity: if is_parked(&now) != is_parked(&before.unhooked) { 1000 } else { now.velocity }, ..now });
            "status-bit-10-shows-motion" "The reserved bit 10 of G1_ZSW is set while the shaft stands still."
                => |d| d.encoder.signals(|_, now| SignalImage { g1_zsw: now.g1_zsw | if now.velocity == 0 { 0x0400 } else { 0 }, ..now });
            "error-after-start" "Each connection begins with a position error."
                => |d| d.a3m60.add(ErrorAfterStart::default());
            "error-lost-in-park" "An error whose cause appears while parked is not raised after parking."
                => |d| d.checks.add(ForgottenInPark::default());
            "io-code-of-16-bits" "Fault codes have zeros in their upper 16 bits."
                => |d| d.encoder.signals(|_, now| code_as(now, |code| code & 0xFFFF));
            "io-code-without-bit-31" "Bit 31 of fault codes is 0."
                => |d| d.encoder.signals(|_, now| code_as(now, |code| code & !TRIGGER));
            "synchronization-not-checked" "Deviations of the counters have no fault code."
                => |d| codes(d, |fault| (!is_synchronization(fault.name)).then_some(fault.code));
            "io-code-in-decimal-digits" "The code -10 is sent as FFFFFFF0h and -8 as FFFFFFF2h."
                => |d| codes(d, |fault| Some(match fault.code { -10 => -16, -8 => -14, other => other }));
            "io-codes-ored" "Several fault codes are combined bit by bit."
                => |d| d.a3m60.fault_code(|encoder, code| code.and_then(|_| noticed(encoder).map(|fault| fault.code).reduce(|all, code| all & code)));
            "first-error-kept" "Of several fault codes the first one of the table is shown."
                => |d| d.a3m60.fault_code(|encoder, code| code.and_then(|_| noticed(encoder).next()).map(|fault| fault.code));
            "code-gone-with-the-first-error" "When one of several errors has gone, the position replaces the fault code."
                => |d| d.a3m60.add(GoneWithTheFirst::default());
            "io-code-and-position-alternate" "In every second cycle the position is sent instead of the fault code."
                => |d| d.encoder.signals(io_code_and_position_alternate);
            "io-code-in-the-speed" "The speed is -3 while there is a fault code."
                => |d| d.encoder.signals(|_, now| SignalImage { velocity: if has_code(&now) { -3 } else { now.velocity }, ..now });
            "show-fault-code-ignored" "The fault code is always shown, even if it is switched off."
                => |d| d.a3m60.fault_code(|encoder, _| status::code(&noticed(encoder).map(|fault| fault.code).collect::<Vec<_>>()));
            "warning-blocks-the-position" "Overspeed has the fault code -16."
                => |d| several_with(d, |words| words.a & status::OVERSPEED != 0);
            "code-for-a-missing-clock" "A missing clock has the fault code -16."
                => |d| several_with(d, |words| words.b & status::CLOCK_MISSING != 0);
            "position-with-an-error-without-a-row" "Invalid parameters in the EEPROM and a wrong linearization have no fault code."
                => |d| codes(d, |fault| (!matches!(fault.name, "eeprom_checksum" | "linearization")).then_some(fault.code));
            "undocumented-io-code" "The amplitude of the cosine has the fault code -6."
                => |d| codes(d, |fault| Some(if fault.name == "amplitude_cosine" { -6 } else { fault.code }));
            "error-bit-hidden-with-the-codes" "If fault codes are switched off, G1_XIST2 has the codes, but the error bit is 0."
                => |d| d.a3m60.image(|encoder, now| if encoder.model.fields.shows_codes() { now } else { SignalImage { g1_zsw: now.g1_zsw & !ERROR, ..now } });
            "error-code-in-the-speed" "The error code is also in NIST_B."
                => |d| d.encoder.signals(|_, now| SignalImage { velocity: if has_error(&now) { now.g1_xist2.into() } else { now.velocity }, ..now });
            "synchronization-without-a-code" "A deviation of the counters that is detected at power-up has no error code and no bit 15."
                => |d| d.encoder.code(|error| if is_caused_at_start(error) { None } else { error.code });
            "speed-in-steps" "The speed is in steps per second."
                => |d| d.a3m60.image(|encoder, now| with_unit(encoder, now, VelocityUnit::PerSecond));
            "unit-in-io-08" "The vendor telegram uses the configured velocity unit instead of rpm."
                => |d| d.a3m60.image(|encoder, now| with_unit(encoder, now, settings::unit(encoder.ram.user.speed_unit.into()).unwrap_or(VelocityUnit::Rpm)));
            "speed-sign-and-magnitude" "A negative speed is sent as a magnitude with the highest bit set."
                => |d| d.encoder.signal(speed_sign_and_magnitude);
            "velocity-limited-at-8191" "The speed is limited to 8191."
                => |d| d.encoder.signals(|_, now| SignalImage { velocity: now.velocity.clamp(-8191, 8191), ..now });
            "speed-never-quite-0" "At standstill the speed is 1."
                => |d| d.encoder.signals(|_, now| SignalImage { velocity: if now.velocity == 0 { 1 } else { now.velocity }, ..now });
            "speed-by-blocks" "The speed is updated only once per averaging time."
                => |d| d.velocity.sampling(|_, right| Sampling { interval: right.interval * right.count, count: 1 });
            "velocity-every-cycle" "The speed is updated every millisecond."
                => |d| d.velocity.sampling(|_, right| Sampling { interval: Duration::from_millis(1), count: (right.interval * right.count).as_millis().max(1) as u32 });
            "speed-calculation-always" "The speed is calculated even if this is switched off."
                => |d| d.a3m60.check(|check, right| right || check == A3m60Check::SpeedCalculated);
            "speed-settings-without-effect" "P1008 has no effect."
                => |d| speed_settings_without_effect(d);
            "isochronous-mean-of-a-second" "In isochronous operation the speed is averaged as without a clock."
                => |d| d.a3m60.check(|check, right| right && check != A3m60Check::SpeedByClock);
        },
    },
];

/// Whether a fault code is sent instead of the position.
fn has_code(image: &SignalImage) -> bool {
    image.plain_position & TRIGGER != 0
}

fn code_as(image: SignalImage, change: fn(u32) -> u32) -> SignalImage {
    let plain_position = if has_code(&image) { change(image.plain_position) } else { image.plain_position };
    SignalImage { plain_position, ..image }
}

/// Computes the fault code from the result of `code` for each fault.
fn codes(d: &mut Deviations, code: fn(&A3m60Fault) -> Option<i32>) {
    d.a3m60.fault_code(move |encoder, right| {
        right.and_then(|_| status::code(&noticed(encoder).filter_map(code).collect::<Vec<_>>()))
    });
}

/// Sends the code of several errors while `is_so` returns `true` for the status.
fn several_with(d: &mut Deviations, is_so: fn(SensorStatusWords) -> bool) {
    d.a3m60.fault_code(move |encoder, code| {
        if encoder.model.fields.shows_codes() && is_so(status::words(encoder)) { Some(status::SEVERAL) } else { code }
    });
}

/// Changes the unit of the speed in the vendor telegrams.
fn with_unit(encoder: &PoweredEncoder<'_, A3m60State>, image: SignalImage, unit: VelocityUnit) -> SignalImage {
    if encoder.ram.telegram().number != 0 || encoder.ram.velocity_is_off {
        return image;
    }
    let mut velocity = encoder.ram.velocity.clone();
    velocity.set_unit(unit);
    let settings = encoder.ram.measuring.settings;
    SignalImage { velocity: velocity.value(&settings.scaling, settings.direction), ..image }
}

/// Shows the values written to P1008 but does not use them.
fn speed_settings_without_effect(d: &mut Deviations) {
    let shown: Rc<Cell<[Option<u64>; 4]>> = Rc::default();
    let written = shown.clone();
    d.a3m60.write(move |write, _| {
        if write.number != 1008 {
            return;
        }
        let [a, b, c] = SpeedCalculation::default().values.map(u64::from);
        let delivered = [0, a, b, c];
        let most = [0, 100, 200, 200];
        for (at, value) in (usize::from(write.subindex)..4).zip(&mut write.values) {
            if (1..=most[at]).contains(value) {
                let mut all = written.get();
                all[at] = Some(mem::replace(value, delivered[at]));
                written.set(all);
            }
        }
    });
    let lost = shown.clone();
    d.a3m60.happens(move |event, _| {
        if event == A3m60Event::PowerUp {
            lost.set([None; 4])
        }
    });
    d.encoder.element(move |_, at, right| match at {
        (1008, at) => shown.get().get(at).copied().flatten().unwrap_or(right),
        _ => right,
    });
}

/// Shows a position error from the start on, until it is acknowledged or the encoder is parked.
#[derive(Default)]
struct ErrorAfterStart {
    is_new: bool,
    is_there: bool,
}

impl A3m60Hooks for ErrorAfterStart {
    fn happens(&mut self, event: A3m60Event, _: &mut A3m60Memory<'_>) {
        match event {
            A3m60Event::Start => (self.is_new, self.is_there) = (true, true),
            A3m60Event::PowerUp => self.is_there = false,
            A3m60Event::PowerDown | A3m60Event::Advance => {}
        }
    }

    fn image(&mut self, _: &PoweredEncoder<'_, A3m60State>, image: SignalImage) -> SignalImage {
        // An earlier error takes precedence.
        let is_second = mem::take(&mut self.is_new) && has_error(&image);
        self.is_there &= !image.request.acknowledge && !is_parked(&image) && !is_second;
        if self.is_there {
            SignalImage { g1_zsw: image.g1_zsw & !POSITION | ERROR, g1_xist2: 1, ..image }
        } else {
            image
        }
    }
}

/// Sends the position again as soon as one of several errors has gone.
#[derive(Default)]
struct GoneWithTheFirst {
    most: usize,
}

impl A3m60Hooks for GoneWithTheFirst {
    fn status(&mut self, encoder: &PoweredEncoder<'_, A3m60State>, words: SensorStatusWords) -> SensorStatusWords {
        let count = noticed(encoder).count();
        self.most = if count == 0 { 0 } else { self.most.max(count) };
        words
    }

    fn fault_code(&mut self, encoder: &PoweredEncoder<'_, A3m60State>, code: Option<i32>) -> Option<i32> {
        code.filter(|_| noticed(encoder).count() >= self.most)
    }
}

/// Counts the time stamp from the start of the connection.
struct StampOfStart(Option<Time>);

impl A3m60Hooks for StampOfStart {
    fn happens(&mut self, event: A3m60Event, memory: &mut A3m60Memory<'_>) {
        if event == A3m60Event::Start {
            self.0 = Some(memory.now);
        }
    }

    fn image(&mut self, encoder: &PoweredEncoder<'_, A3m60State>, image: SignalImage) -> SignalImage {
        let started = self.0.unwrap_or(encoder.now);
        SignalImage { time_stamp: encoder.now.since(started).as_secs() as u16, ..image }
    }
}

/// The lowest speed that counts as motion, in revolutions per minute.
const MOTION: i64 = 7;

/// Counts the time stamp only while `counts` returns `true`.
struct StandingStamp {
    counts: fn(&PoweredEncoder<'_, A3m60State>) -> bool,
    counted: Duration,
    last: Option<Time>,
}

impl StandingStamp {
    fn new(counts: fn(&PoweredEncoder<'_, A3m60State>) -> bool) -> StandingStamp {
        StandingStamp { counts, counted: Duration::ZERO, last: None }
    }
}

impl A3m60Hooks for StandingStamp {
    fn happens(&mut self, event: A3m60Event, _: &mut A3m60Memory<'_>) {
        if event == A3m60Event::PowerUp {
            (self.counted, self.last) = (Duration::ZERO, None);
        }
    }

    fn status(&mut self, encoder: &PoweredEncoder<'_, A3m60State>, words: SensorStatusWords) -> SensorStatusWords {
        let passed = encoder.now.since(self.last.replace(encoder.now).unwrap_or(encoder.now));
        if (self.counts)(encoder) {
            self.counted += passed;
        }
        words
    }

    fn image(&mut self, _: &PoweredEncoder<'_, A3m60State>, image: SignalImage) -> SignalImage {
        SignalImage { time_stamp: self.counted.as_secs() as u16, ..image }
    }
}

fn is_synchronization(name: &str) -> bool {
    matches!(name, "synchronization_shutdown" | "synchronization_start")
}

fn is_caused_at_start(error: &encoder_profile::facts::ErrorFact) -> bool {
    error.causes.contains(&encoder_profile::facts::ErrorCause::Stand("synchronization_start"))
}

fn offset_in_io_04_only(of: &SentSignal<'_>, octets: &mut Vec<u8>) {
    let image = of.image;
    if of.signal == InputSignal::Position && of.telegram.input_octets == 8 && !has_code(image) {
        let positions = of.view.positions.max(1);
        put(octets, ((u64::from(image.plain_position) + positions - image.offset % positions) % positions) as u32);
    }
}

fn io_code_and_position_alternate(before: &PreviousCycle, now: SignalImage) -> SignalImage {
    if has_code(&now) && has_code(&before.sent) {
        SignalImage { plain_position: now.position as u32, ..now }
    } else {
        now
    }
}

fn speed_sign_and_magnitude(of: &SentSignal<'_>, octets: &mut Vec<u8>) {
    let magnitude = of.image.velocity.unsigned_abs();
    match of.signal {
        InputSignal::NistA if of.image.velocity < 0 => *octets = (magnitude as u16 | 0x8000).to_be_bytes().into(),
        InputSignal::NistB if of.image.velocity < 0 => put(octets, magnitude as u32 | TRIGGER),
        _ => {}
    }
}
