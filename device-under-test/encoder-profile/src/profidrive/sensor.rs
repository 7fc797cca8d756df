//! The sensor interface: what G1_STW asks for and G1_ZSW answers.
//!
//! Three handshakes run side by side (preset, parking, acknowledgement), and errors are latched until they are
//! acknowledged, parked away or the connection starts anew. Sources: XAC77 manual, chapters 10 and 16; where its diagrams
//! are lost or silent, the PROFIdrive profile.

use super::telegram::Image;
use crate::encoder::PresetMode;
use alloc::vec::Vec;

/// The error code of a parking request that was refused because the shaft turns.
pub const PARKING_REFUSED: u16 = 0x0003;

/// The requests of a control word; one that is void has none.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Request {
    /// Bit 11, home position mode: the preset is relative.
    pub relative: bool,
    /// Bit 12: a preset is requested.
    pub home: bool,
    /// Bit 13: the position is requested in G1_XIST2.
    pub absolute: bool,
    /// Bit 14: parking is requested.
    pub park: bool,
    /// Bit 15: the acknowledgement of an error is requested.
    pub acknowledge: bool,
}

impl Request {
    /// The requests in the bits of G1_STW; the other bits have no function.
    pub fn of(g1_stw: u16) -> Request {
        let bit = |n: u32| g1_stw >> n & 1 != 0;
        Request { relative: bit(11), home: bit(12), absolute: bit(13), park: bit(14), acknowledge: bit(15) }
    }

    /// What a preset is to do with its value.
    pub fn mode(self) -> PresetMode {
        if self.relative { PresetMode::Relative } else { PresetMode::Absolute }
    }
}

/// Where the handshake of a preset stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// Nothing is asked for, or the last preset was not carried out.
    Idle,
    /// The preset is being carried out.
    Running,
    /// The preset was carried out and the request is still held.
    Executed,
}

/// Where parking stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parking {
    /// The encoder measures.
    Off,
    /// The encoder is parked.
    On,
    /// Parking was refused and the request is still held.
    Refused,
}

/// Where the acknowledgement of an error stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Acknowledge {
    /// Nothing is being acknowledged.
    Idle,
    /// The request was seen and is still held.
    Requested,
    /// The request was taken back: errors have gone as far as they can, the answer goes one cycle later.
    Closing,
}

/// An error of the encoder.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Error {
    /// Which one it is: its index in the facts, or [`Error::OWN`] and more for one that is not there. Errors with different numbers
    /// may share a code.
    pub number: u16,
    /// Its code in G1_XIST2; an error without one is neither shown there nor by bit 15 of G1_ZSW.
    pub code: Option<u16>,
}

impl Error {
    /// The number of an error that is not in the facts is this and its code.
    pub const OWN: u16 = 0x8000;

    /// The error that has a code of its own.
    pub const fn of(code: u16) -> Error {
        Error { number: Error::OWN | code, code: Some(code) }
    }

    fn shown(self) -> u16 {
        self.code.unwrap_or(0)
    }
}

/// When the position stands in G1_XIST2, as far as neither an error nor parking is in its way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transfers {
    /// While bit 13 of G1_STW requests it.
    Requested,
    /// Always.
    Always,
}

/// What parking does to the positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parks {
    /// They are 0.
    Zeroes,
    /// They keep their last values, and bit 13 of G1_ZSW stays as it would be without parking.
    Freezes,
}

/// How a request to acknowledge is answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answers {
    /// Errors whose cause has gone go when the request is taken back, and bit 11 of G1_ZSW goes one cycle later.
    Handshake,
    /// Bit 11 of G1_ZSW is 1 while there is an error and the request; what goes by it goes at once.
    Echo,
}

/// Where bugs can be put into the sensor interface.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// Whether a control word asks for a preset.
    pub asks_for_preset: fn(Request) -> bool,
    /// When the position stands in G1_XIST2.
    pub transfers: Transfers,
    /// What parking does to the positions.
    pub parks: Parks,
    /// The signals while parking fixes the positions, from those at its begin and those of now.
    pub freezes: fn(Image, Image) -> Image,
    /// How a request to acknowledge is answered.
    pub answers: Answers,
    /// The code in G1_XIST2, from those of all errors, oldest first and at least one.
    pub code: fn(&[u16]) -> u16,
    /// Whether errors can be acknowledged while parked.
    pub acknowledges_while_parked: bool,
    /// Whether an encoder that was parked at the end of a connection stays so until parking is requested anew.
    pub keeps_parked: bool,
    /// The offset when the request of a preset is taken back, from the one now and the one before the preset.
    pub release: fn(u64, u64) -> u64,
    /// Whether a preset begins, from the request of the cycle before and of this one.
    pub begins_preset: fn(Request, Request) -> bool,
    /// Whether bit 12 is set in this state of the handshake with this request.
    pub acknowledges_preset: fn(Preset, Request) -> bool,
    /// An error that a preset raises when it is carried out.
    pub preset_raises: Option<u16>,
    /// Whether the acknowledgement of a preset is taken back with its request.
    pub releases_preset: bool,
    /// Whether parking takes back the acknowledgement of a preset.
    pub parking_ends_preset: bool,
    /// Whether parking clears the errors.
    pub parking_clears_errors: bool,
    /// Whether no velocity is measured while parked.
    pub parking_stops_velocity: bool,
    /// Whether a preset is carried out while parked.
    pub presets_while_parked: bool,
    /// Whether presets are carried out while there are errors.
    pub presets_with_errors: bool,
    /// Whether a preset that is blocked by the user parameters or by an error is answered like one that was carried out.
    pub answers_blocked_preset: bool,
    /// Whether presets are carried out after the encoder has been parked.
    pub presets_after_parking: bool,
    /// Whether parking is refused, from whether the shaft turns and whether there is an error.
    pub refuses_to_park: fn(bool, bool) -> bool,
    /// The error code of parking that was refused.
    pub parking_code: u16,
    /// Whether the error of this code is raised.
    pub raises: fn(u16) -> bool,
    /// Whether bit 12 that was set at the end of a connection stays so until a preset is requested and taken back.
    pub keeps_acknowledgement: bool,
    /// Whether the error of this code is raised while parked.
    pub raises_while_parked: fn(u16) -> bool,
    /// Whether an error whose cause is there at the end of parking is raised anew.
    pub looks_again_after_parking: bool,
    /// An error whose cause is always there.
    pub constant_cause: Option<u16>,
    /// Whether a request is taken for an acknowledgement, from how many have failed so far.
    pub acknowledges: fn(u32) -> bool,
    /// Whether an acknowledgement clears the error of this code, from whether its cause is still there.
    pub clears: fn(u16, bool) -> bool,
    /// Whether an error stays when its cause has gone.
    pub latches: bool,
    /// Whether errors survive new connections and a loss of power.
    pub keeps_errors: bool,
    /// Whether a request of the connection before, if it is held, is no new one.
    pub keeps_requests: bool,
}

impl Default for Rules {
    fn default() -> Rules {
        Rules {
            asks_for_preset: |request| request.home,
            transfers: Transfers::Requested,
            parks: Parks::Zeroes,
            freezes,
            answers: Answers::Handshake,
            code: |codes| codes.first().copied().unwrap_or(0),
            acknowledges_while_parked: false,
            keeps_parked: false,
            release: |now, _| now,
            begins_preset: |before, now| !before.home && now.home,
            acknowledges_preset: |preset, _| preset == Preset::Executed,
            preset_raises: None,
            releases_preset: true,
            parking_ends_preset: true,
            parking_clears_errors: true,
            parking_stops_velocity: true,
            presets_while_parked: false,
            presets_with_errors: true,
            answers_blocked_preset: true,
            presets_after_parking: true,
            refuses_to_park: |moving, _| moving,
            parking_code: PARKING_REFUSED,
            raises: |_| true,
            keeps_acknowledgement: false,
            raises_while_parked: |_| false,
            looks_again_after_parking: true,
            constant_cause: None,
            acknowledges: |_| true,
            clears: |_, persists| !persists,
            latches: true,
            keeps_errors: false,
            keeps_requests: false,
        }
    }
}

/// All positions stay what they were; an error is shown all the same.
pub fn freezes(kept: Image, now: Image) -> Image {
    let shows_position = now.g1_zsw >> 13 & 1 != 0;
    Image {
        g1_xist1: kept.g1_xist1,
        g1_xist2: if shows_position { kept.position as u32 } else { now.g1_xist2 },
        g1_xist3: kept.g1_xist3,
        plain_position: kept.plain_position,
        single_turn: kept.single_turn,
        multi_turn: kept.multi_turn,
        ..now
    }
}

/// What G1_XIST2 has to show.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Xist2 {
    /// Neither position nor error.
    Nothing,
    /// The position.
    Position,
    /// The code of an error.
    Error(u16),
}

/// The sensor interface of one encoder.
#[derive(Clone, Debug)]
pub struct Sensor {
    preset: Preset,
    parking: Parking,
    acknowledge: Acknowledge,
    request: Request,
    /// The requests that are no new ones when they are there in the next cycle.
    held: Request,
    /// The requests at the end of the last connection.
    last: Request,
    /// Whether those count although the power was gone since then.
    remembers: bool,
    /// Whether bit 12 is still set from the connection before.
    is_acknowledged: bool,
    /// Latched errors, oldest first.
    errors: Vec<Error>,
    /// The causes that were there when last looked at.
    causes: Vec<Error>,
    /// Acknowledgements that left an error.
    failed_acknowledgements: u32,
    was_parked: bool,
    /// Whether parking outlasts its request until there is another one.
    stays_parked: bool,
    /// Whether the request of a preset that was carried out was taken back in the last cycle.
    is_released: bool,
    rules: Rules,
}

impl Sensor {
    /// A sensor interface in normal operation.
    pub fn new(rules: Rules) -> Sensor {
        Sensor {
            preset: Preset::Idle,
            parking: Parking::Off,
            acknowledge: Acknowledge::Idle,
            request: Request::default(),
            held: Request::default(),
            last: Request::default(),
            remembers: false,
            is_acknowledged: false,
            errors: Vec::new(),
            causes: Vec::new(),
            failed_acknowledgements: 0,
            was_parked: false,
            stays_parked: false,
            is_released: false,
            rules,
        }
    }

    /// Begins anew for a new connection: handshakes are idle, and errors whose cause has gone are forgotten.
    pub fn restart(&mut self, causes: &[Error]) {
        let errors = core::mem::take(&mut self.errors);
        let held = if self.rules.keeps_requests || self.remembers { self.last } else { Request::default() };
        let Sensor { stays_parked, is_acknowledged, remembers, rules, .. } = *self;
        *self = Sensor { errors, held, last: held, remembers, stays_parked, is_acknowledged, ..Sensor::new(rules) };
        self.errors.retain(|error| causes.contains(error) || self.rules.keeps_errors);
        self.causes = self.errors.clone();
    }

    /// Begins anew after a loss of power, from the interface before it: nothing is left of that.
    pub fn power_up(&mut self, before: &Sensor) {
        if self.rules.keeps_errors {
            self.errors.clone_from(&before.errors);
        }
    }

    /// Takes note of whether words came in this cycle: until the first ones a request of before may be held on.
    pub fn hear(&mut self, has_words: bool) {
        match has_words {
            true => (self.last, self.remembers) = (Request::default(), false),
            false if self.rules.keeps_requests || self.remembers => self.held = self.last,
            false => {}
        }
    }

    /// Takes the requests from before a loss of power as if they were still there.
    pub fn remember(&mut self, before: &Sensor) {
        (self.last, self.remembers) = (before.held, true);
    }

    /// Looks at the causes of errors that are there now: each new one raises its error.
    pub fn watch(&mut self, causes: &[Error]) {
        let nothing_was = self.causes.is_empty() && (self.rules.latches || self.errors.is_empty());
        if causes.is_empty() && self.rules.constant_cause.is_none() && nothing_was {
            return;
        }
        let parked = self.parking == Parking::On;
        let causes: Vec<Error> = causes.iter().copied().chain(self.rules.constant_cause.map(Error::of)).collect();
        let is_noticed = |cause: &Error| {
            (self.rules.raises)(cause.shown()) && (!parked || (self.rules.raises_while_parked)(cause.shown()))
        };
        let noticed: Vec<Error> = causes.iter().copied().filter(is_noticed).collect();
        for cause in &noticed {
            if !self.causes.contains(cause) {
                self.raise(*cause);
            }
        }
        if !self.rules.latches {
            self.errors.retain(|error| causes.contains(error));
        }
        self.causes = if self.rules.looks_again_after_parking { noticed } else { causes };
    }

    /// Takes the requests of one cycle; gives the preset that is to be carried out, if one begins.
    ///
    /// Whoever carries it out says so with [`preset_done`](Sensor::preset_done).
    pub fn cycle(&mut self, request: Request, moving: bool) -> Option<PresetMode> {
        let before = core::mem::replace(&mut self.held, request);
        self.request = request;
        self.stays_parked &= !request.park;
        self.parking = self.park(request.park || self.stays_parked, moving);
        let parked = self.parking == Parking::On;
        self.was_parked |= parked;
        self.acknowledge = match !parked || self.rules.acknowledges_while_parked {
            true => self.acknowledge(before.acknowledge),
            false => Acknowledge::Idle,
        };

        let asks = self.rules.asks_for_preset;
        let may_begin = match parked {
            true => self.rules.presets_while_parked,
            false => self.rules.presets_after_parking || !self.was_parked,
        };
        let begins = (self.rules.begins_preset)(before, request) && may_begin;
        let next = match self.preset {
            Preset::Idle | Preset::Executed if begins => Preset::Running,
            Preset::Executed if !asks(request) && self.rules.releases_preset => Preset::Idle,
            Preset::Executed if parked && self.rules.parking_ends_preset => Preset::Idle,
            unchanged @ (Preset::Idle | Preset::Running | Preset::Executed) => unchanged,
        };
        let before = core::mem::replace(&mut self.preset, next);
        self.is_acknowledged &= before != Preset::Executed || next != Preset::Idle;
        self.is_released = before == Preset::Executed && next == Preset::Idle && !parked;
        (before != Preset::Running && next == Preset::Running).then(|| request.mode())
    }

    /// Takes note of requests that were void in this cycle: held on, they are no new ones when they count.
    pub fn see(&mut self, void: Request) {
        self.held.home |= void.home;
        self.held.acknowledge |= void.acknowledge;
    }

    /// The connection has ended, and with it all requests.
    pub fn ended(&mut self) {
        self.last = self.held;
        let is_acknowledged = self.preset == Preset::Executed && self.rules.keeps_acknowledgement;
        let stays = self.rules.keeps_parked && self.is_parked();
        self.cycle(Request::default(), false);
        self.is_acknowledged |= is_acknowledged;
        self.stays_parked |= stays;
    }

    /// The preset that was begun is carried out (`true`), or it could not be.
    pub fn preset_done(&mut self, carried_out: bool) {
        if carried_out {
            self.rules.preset_raises.into_iter().for_each(|code| self.raise(Error::of(code)));
        }
        let parked = self.parking == Parking::On && !self.rules.presets_while_parked;
        self.preset = match self.preset {
            Preset::Running if carried_out && !parked && (self.rules.asks_for_preset)(self.request) => Preset::Executed,
            Preset::Running => Preset::Idle,
            other @ (Preset::Idle | Preset::Executed) => other,
        };
    }

    fn park(&mut self, requested: bool, moving: bool) -> Parking {
        match (self.parking, requested) {
            (Parking::Off | Parking::On | Parking::Refused, false) => Parking::Off,
            (Parking::Off, true) if (self.rules.refuses_to_park)(moving, !self.errors.is_empty()) => {
                self.raise(Error::of(self.rules.parking_code));
                Parking::Refused
            }
            (Parking::Off, true) => {
                if self.rules.parking_clears_errors {
                    self.errors.clear();
                }
                Parking::On
            }
            (held @ (Parking::On | Parking::Refused), true) => held,
        }
    }

    fn acknowledge(&mut self, before: bool) -> Acknowledge {
        if self.rules.answers == Answers::Echo {
            let is_answered = self.request.acknowledge && self.has_error();
            if is_answered {
                let (clears, causes) = (self.rules.clears, &self.causes);
                self.errors.retain(|error| !clears(error.shown(), causes.contains(error)));
            }
            return match is_answered {
                true => Acknowledge::Requested,
                false => Acknowledge::Idle,
            };
        }
        let is_new = self.request.acknowledge && !before && !self.errors.is_empty();
        let begins = is_new && (self.rules.acknowledges)(self.failed_acknowledgements);
        match self.acknowledge {
            Acknowledge::Idle | Acknowledge::Closing if begins => Acknowledge::Requested,
            Acknowledge::Idle | Acknowledge::Closing => Acknowledge::Idle,
            Acknowledge::Requested if self.request.acknowledge => Acknowledge::Requested,
            Acknowledge::Requested => {
                let Rules { clears, parking_code, .. } = self.rules;
                let refused = self.parking == Parking::Refused;
                let is_refusal = |error| refused && error == Error::of(parking_code);
                let persists = |error| self.causes.contains(&error) || is_refusal(error);
                self.errors.retain(|error| !clears(error.shown(), persists(*error)));
                self.failed_acknowledgements += u32::from(!self.errors.is_empty());
                Acknowledge::Closing
            }
        }
    }

    fn raise(&mut self, error: Error) {
        if !self.errors.contains(&error) {
            self.errors.push(error);
        }
    }

    /// Latched errors, oldest first.
    pub fn errors(&self) -> &[Error] {
        &self.errors
    }

    /// Whether there is an error that is shown.
    pub fn has_error(&self) -> bool {
        self.errors.iter().any(|error| error.code.is_some())
    }

    /// Whether the encoder is parked.
    pub fn is_parked(&self) -> bool {
        self.parking == Parking::On
    }

    /// Whether the positions keep their last values, since the encoder is parked.
    pub fn is_frozen(&self) -> bool {
        self.is_parked() && self.rules.parks == Parks::Freezes
    }

    /// The offset after the last cycle, from the one in force and the one before the last preset.
    pub fn released(&self, offset: u64, before: u64) -> u64 {
        if self.is_released { (self.rules.release)(offset, before) } else { offset }
    }

    /// The requests of the last cycle.
    pub fn request(&self) -> Request {
        self.request
    }

    /// Whether the position stands in G1_XIST2 where neither an error nor parking is in its way.
    pub fn is_transferred(&self) -> bool {
        self.request.absolute || self.rules.transfers == Transfers::Always
    }

    /// What G1_XIST2 has to show: errors before the position, and no position while parking makes it 0.
    pub fn xist2(&self) -> Xist2 {
        if self.has_error() {
            let codes: Vec<u16> = self.errors.iter().filter_map(|error| error.code).collect();
            return Xist2::Error((self.rules.code)(&codes));
        }
        match self.is_transferred() && (!self.is_parked() || self.is_frozen()) {
            true => Xist2::Position,
            false => Xist2::Nothing,
        }
    }

    /// G1_ZSW: bit 11 acknowledgement in process, 12 preset executed, 13 position in G1_XIST2, 14 parked, 15 error.
    pub fn g1_zsw(&self) -> u16 {
        let bit = |n: u32, set: bool| u16::from(set) << n;
        bit(11, self.acknowledge != Acknowledge::Idle)
            | bit(12, self.is_acknowledged || (self.rules.acknowledges_preset)(self.preset, self.request))
            | bit(13, self.xist2() == Xist2::Position)
            | bit(14, self.is_parked())
            | bit(15, self.has_error())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    const HOME: u16 = 0x1000;
    const RELATIVE: u16 = 0x1800;
    const ABSOLUTE: u16 = 0x2000;
    const PARK: u16 = 0x4000;
    const ACKNOWLEDGE: u16 = 0x8000;
    const MEMORY: Error = Error::of(0x1001);
    const PARAMETERS: Error = Error::of(0x1002);
    const LIFE_SIGN: Error = Error::of(0x0F02);

    fn sensor() -> Sensor {
        Sensor::new(Rules::default())
    }

    fn cycle(sensor: &mut Sensor, g1_stw: u16) -> u16 {
        if sensor.cycle(Request::of(g1_stw), false).is_some() {
            sensor.preset_done(true);
        }
        sensor.g1_zsw()
    }

    #[rstest]
    #[case(HOME, PresetMode::Absolute)]
    #[case(RELATIVE, PresetMode::Relative)]
    fn a_preset_is_acknowledged_when_it_is_done(#[case] word: u16, #[case] mode: PresetMode) {
        let mut sensor = sensor();
        assert_eq!(sensor.cycle(Request::of(word & 0x0800), false), None);
        assert_eq!(sensor.cycle(Request::of(word), false), Some(mode));
        assert_eq!(sensor.cycle(Request::of(word), false), None);
        assert_eq!(sensor.g1_zsw(), 0);
        sensor.preset_done(true);
        assert_eq!(sensor.g1_zsw(), HOME);
        for _ in 0..3 {
            assert_eq!(sensor.cycle(Request::of(word), false), None);
            assert_eq!(sensor.g1_zsw(), HOME);
        }
        assert_eq!(sensor.cycle(Request::of(0), false), None);
        assert_eq!(sensor.g1_zsw(), 0);
        assert_eq!(sensor.cycle(Request::of(word), false), Some(mode));
    }

    #[test]
    fn a_preset_that_failed_or_was_given_up_is_not_acknowledged() {
        let mut sensor = sensor();
        sensor.cycle(Request::of(HOME), false);
        sensor.preset_done(false);
        assert_eq!(cycle(&mut sensor, HOME), 0);
        cycle(&mut sensor, 0);
        sensor.cycle(Request::of(HOME), false);
        sensor.cycle(Request::of(0), false);
        sensor.preset_done(true);
        assert_eq!(sensor.g1_zsw(), 0);
    }

    // Manual, 16.3: parking clears bits 12 and 13 and all errors; bit 13 comes back by itself.
    #[test]
    fn parking() {
        let mut sensor = sensor();
        sensor.watch(&[MEMORY]);
        assert_eq!(cycle(&mut sensor, HOME | ABSOLUTE), 0x9000);
        assert_eq!(cycle(&mut sensor, HOME | ABSOLUTE | PARK), PARK);
        sensor.watch(&[MEMORY, PARAMETERS]);
        assert_eq!((sensor.xist2(), sensor.errors().len()), (Xist2::Nothing, 0));
        assert_eq!(cycle(&mut sensor, ABSOLUTE | PARK), PARK);
        assert_eq!(sensor.cycle(Request::of(HOME | ABSOLUTE | PARK), false), None);
        assert_eq!(sensor.cycle(Request::of(HOME | ABSOLUTE), true), None);
        assert_eq!(sensor.g1_zsw(), ABSOLUTE);
        sensor.watch(&[PARAMETERS]);
        assert_eq!(sensor.xist2(), Xist2::Error(0x1002));
    }

    #[test]
    fn a_turning_encoder_does_not_park() {
        let mut sensor = sensor();
        sensor.cycle(Request::of(PARK | ABSOLUTE), true);
        assert_eq!((sensor.g1_zsw(), sensor.xist2()), (0x8000, Xist2::Error(3)));
        for word in [PARK, PARK | ACKNOWLEDGE, PARK] {
            sensor.cycle(Request::of(word), false);
            assert_eq!(sensor.g1_zsw() & 0xC000, 0x8000);
        }
        let words = [0, ACKNOWLEDGE, 0, 0, PARK].map(|word| cycle(&mut sensor, word));
        assert_eq!(words, [0x8000, 0x8800, 0x0800, 0, PARK]);
    }

    // Manual, 16.4.1 and 16.4.2, read from top to bottom: the answer is taken back last.
    #[rstest]
    #[case::solved(&[], [0x8000, 0x8800, 0x8800, 0x2800, 0x2000])]
    #[case::not_solved(&[MEMORY], [0x8000, 0x8800, 0x8800, 0x8800, 0x8000])]
    fn acknowledgement(#[case] causes: &[Error], #[case] expected: [u16; 5]) {
        let mut sensor = sensor();
        assert_eq!(cycle(&mut sensor, ABSOLUTE), ABSOLUTE);
        sensor.watch(&[MEMORY]);
        sensor.watch(causes);
        for _ in 0..2 {
            let words = [0, ACKNOWLEDGE, ACKNOWLEDGE, 0, 0].map(|word| cycle(&mut sensor, word | ABSOLUTE));
            assert_eq!(words, expected);
            if causes.is_empty() {
                break;
            }
        }
    }

    #[test]
    fn acknowledging_without_an_error_or_before_it_does_nothing() {
        let mut sensor = sensor();
        assert_eq!(cycle(&mut sensor, ACKNOWLEDGE | ABSOLUTE), ABSOLUTE);
        sensor.watch(&[MEMORY]);
        sensor.watch(&[]);
        assert_eq!(cycle(&mut sensor, ACKNOWLEDGE), 0x8000);
        assert_eq!(cycle(&mut sensor, 0), 0x8000);
    }

    #[test]
    fn an_acknowledgement_may_follow_the_last_one_at_once() {
        let mut sensor = sensor();
        sensor.watch(&[MEMORY]);
        let words = [ACKNOWLEDGE, 0, ACKNOWLEDGE, 0, 0].map(|word| cycle(&mut sensor, word));
        assert_eq!(words, [0x8800, 0x8800, 0x8800, 0x8800, 0x8000]);
    }

    #[test]
    fn the_oldest_error_is_shown_and_a_new_connection_keeps_what_persists() {
        let mut sensor = sensor();
        sensor.watch(&[LIFE_SIGN]);
        sensor.watch(&[LIFE_SIGN, MEMORY]);
        assert_eq!(sensor.xist2(), Xist2::Error(0x0F02));
        sensor.restart(&[MEMORY]);
        assert_eq!((sensor.xist2(), sensor.g1_zsw()), (Xist2::Error(0x1001), 0x8000));
        sensor.watch(&[]);
        sensor.restart(&[]);
        assert_eq!(sensor.g1_zsw(), 0);
    }

    // Catalogue SIG-021, SIG-022, SIG-028, SIG-036: bits without function, and what is never set together.
    #[test]
    fn for_every_control_word_the_status_word_makes_sense() {
        for word in 0..=u16::MAX {
            let mut sensor = sensor();
            sensor.watch(&[MEMORY]);
            sensor.watch(&[]);
            for word in [word, word ^ 0x8000, 0x2000, word] {
                let status = cycle(&mut sensor, word);
                assert_eq!(status & 0x07FF, 0);
                assert_ne!(status & 0xA000, 0xA000);
                assert_eq!(cycle(&mut sensor.clone(), word & 0xF800), cycle(&mut sensor.clone(), word));
            }
        }
    }

    /// A sensor interface after the manual of the Kübler Sendix 58xx: errors are a state, parking freezes.
    fn state_sensor() -> Sensor {
        Sensor::new(Rules {
            transfers: Transfers::Always,
            parks: Parks::Freezes,
            answers: Answers::Echo,
            latches: false,
            refuses_to_park: |_, _| false,
            parking_clears_errors: false,
            ..Rules::default()
        })
    }

    // Sendix 58xx: bit 13 of G1_ZSW is set without a request, and 8800h answers a request while there is a fault.
    #[test]
    fn errors_that_are_a_state() {
        let mut sensor = state_sensor();
        let sent = [0, ACKNOWLEDGE, PARK, 0].map(|word| cycle(&mut sensor, word));
        assert_eq!(sent, [0x2000, 0x2000, 0x6000, 0x2000]);
        sensor.watch(&[Error::of(0x0020)]);
        let sent = [0, ACKNOWLEDGE, ACKNOWLEDGE, 0].map(|word| cycle(&mut sensor, word));
        assert_eq!((sent, sensor.xist2()), ([0x8000, 0x8800, 0x8800, 0x8000], Xist2::Error(0x0020)));
        sensor.watch(&[]);
        assert_eq!((sensor.g1_zsw(), sensor.xist2()), (0x2000, Xist2::Position));
    }

    #[test]
    fn parking_that_freezes_ends_with_the_connection() {
        let mut sensor = state_sensor();
        cycle(&mut sensor, PARK);
        assert!(sensor.is_frozen());
        sensor.ended();
        assert!(!sensor.is_parked());
        sensor.rules.keeps_parked = true;
        cycle(&mut sensor, PARK);
        sensor.ended();
        sensor.restart(&[]);
        let parked = [0, 0, PARK, 0].map(|word| cycle(&mut sensor, word) & PARK != 0);
        assert_eq!(parked, [true, true, true, false]);
    }

    // SICK AFS60/AFM60: two errors share the code 1001h, and one has none.
    #[test]
    fn errors_that_share_a_code_or_have_none() {
        let [first, second] = [1, 2].map(|number| Error { number, code: Some(0x1001) });
        let commissioning = Error { number: 3, code: None };
        let mut sensor = sensor();
        sensor.watch(&[commissioning]);
        assert_eq!((cycle(&mut sensor, ABSOLUTE), sensor.errors().len()), (ABSOLUTE, 1));
        sensor.watch(&[commissioning, first, second]);
        sensor.watch(&[second]);
        let sent = [ACKNOWLEDGE, 0, 0].map(|word| cycle(&mut sensor, word));
        assert_eq!((sent, sensor.errors()), ([0x8800, 0x8800, 0x8000], &[second][..]));
    }

    // SICK AFS60/AFM60: parking clears no errors, and acknowledging works while parked.
    #[test]
    fn acknowledging_while_parked() {
        let rules = Rules { parking_clears_errors: false, acknowledges_while_parked: true, ..Rules::default() };
        let mut sensor = Sensor::new(rules);
        sensor.watch(&[MEMORY]);
        sensor.watch(&[]);
        let sent = [PARK, PARK | ACKNOWLEDGE, PARK, PARK, 0].map(|word| cycle(&mut sensor, word));
        assert_eq!(sent, [0xC000, 0xC800, 0x4800, 0x4000, 0]);
    }

    #[test]
    fn a_request_that_was_seen_void_is_no_new_one() {
        let mut sensor = sensor();
        assert_eq!(sensor.cycle(Request::default(), false), None);
        sensor.see(Request::of(HOME));
        assert_eq!(sensor.cycle(Request::of(HOME), false), None);
        assert_eq!(sensor.cycle(Request::of(0), false), None);
        assert_eq!(sensor.cycle(Request::of(HOME), false), Some(PresetMode::Absolute));
        sensor.preset_done(true);
        assert_eq!(sensor.released(7, 5), 7);
        sensor.rules.release = |_, before| before;
        assert_eq!(sensor.released(7, 5), 7);
        sensor.cycle(Request::of(0), false);
        assert_eq!(sensor.released(7, 5), 5);
    }
}
