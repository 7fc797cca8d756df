//! The encoder as a PROFIBUS slave sees it: from Set_Prm, Chk_Cfg and Data_Exchange to the start, the record of the user
//! parameters and the telegrams of the encoder object, and from data set 47 to its parameter access.

use super::knobs::{Knobs, Rules};
use super::own::{self, State};
use super::start;
use super::status;
use super::{CONFIGURATIONS, FACTS, SUBMODULES, SUBSLOT, station};
use ::station::{StandAction, Time};
use alloc::vec::Vec;
use device_stack::profibus::{Access, Application, DiagnosisBits, End, Identity, Refusal, Seen, State as Stage};
use device_stack::profinet::{
    self as object, Access as ObjectAccess, Application as _, ArKey, Plug, RecordRefusal, Severity,
};
use encoder_profile::behaviour::Behaviour;
use encoder_profile::encoder_object::{ACCESS_POINT_SUBSLOT, ENCODER_API, ENCODER_SLOT, EncoderObject, Piece};
use encoder_profile::facts::Variant;
use wire::profibus::cfg::Sums;
use wire::profibus::dpv1::RecordError;
use wire::profibus::prm::SetPrm;

/// The record of the user parameters, and that of the parameter access, as the encoder object has them.
const USER_PARAMETERS: u16 = 0xBF00;
const PARAMETER_ACCESS: u16 = 0xB02E;

/// An A3M60 behind its slave.
pub struct Encoder {
    object: EncoderObject<State>,
    rules: Rules,
    identity: Identity,
    /// The connection, and whether data are exchanged in it.
    connection: ArKey,
    is_connected: bool,
    /// The module of the last configuration that was right.
    module: usize,
    /// The diagnosis when last looked at, and whether it was another one before.
    told: Vec<u8>,
    has_changed: bool,
    /// When it was asked last whether it takes outputs: then it has advanced to that instant.
    asked: Option<Time>,
}

impl Encoder {
    /// An encoder fresh from the factory but for its address.
    pub fn new(variant: &'static Variant, behaviour: Behaviour, rules: Knobs, shaft: u64, address: u8) -> Encoder {
        let state = State::new(address);
        let object = EncoderObject::new(&FACTS, state, variant, behaviour, rules, Piece { shaft, ..Piece::default() });
        let identity = Identity {
            ident: 0x0C0A,
            boot_time: FACTS.timing.boot,
            freeze: true,
            sync: true,
            fail_safe: true,
            dpv1: true,
            ms1: true,
            ms2: 0,
            abilities: None,
            set_ext_prm: false,
        };
        Encoder {
            object,
            rules: rules.own,
            identity,
            connection: ArKey(0),
            is_connected: false,
            module: 0,
            told: Vec::new(),
            has_changed: false,
            asked: None,
        }
    }

    /// Looks whether the diagnosis has changed.
    fn look(&mut self, now: Time) {
        while self.object.next_diagnosis().is_some() {}
        let told = self.blocks(now);
        if told != self.told {
            (self.told, self.has_changed) = (told, true);
        }
    }

    fn blocks(&mut self, now: Time) -> Vec<u8> {
        let live = self.object.live(now);
        let known = status::known(&live);
        let numbers: Vec<u8> = status::diagnoses(&live, &known).iter().map(|(number, _)| *number as u8).collect();
        (live.rules.own.blocks)(&numbers, &known)
    }

    fn plugged(&self) -> Option<Plug> {
        let submodule = SUBMODULES.get(self.module)?;
        let is_it = |plug: &Plug| plug.submodule_ident == submodule.ident && plug.subslot == SUBSLOT;
        self.object.plugs().iter().copied().find(is_it)
    }

    fn access(&mut self, now: Time, access: Access, index: u16) -> Result<ObjectAccess, Refusal> {
        let has_parameters = (self.rules.has_parameters)(self.object.live(now).ram.telegram());
        let rules = &self.rules;
        if !(rules.has_slot)(access.slot) {
            return Err(Refusal::error(RecordError::INVALID_SLOT));
        }
        if !(rules.has_index)(access.index) || !has_parameters {
            return Err(Refusal::error(RecordError::INVALID_INDEX));
        }
        Ok(self.place(index))
    }

    fn place(&self, index: u16) -> ObjectAccess {
        ObjectAccess {
            ar: Some(self.connection),
            api: ENCODER_API,
            slot: ENCODER_SLOT,
            subslot: ACCESS_POINT_SUBSLOT,
            index,
        }
    }
}

fn refused(refusal: RecordRefusal) -> Refusal {
    Refusal::error(RecordError(refusal.code1()))
}

impl Application for Encoder {
    fn identity(&self) -> &Identity {
        &self.identity
    }

    fn power_up(&mut self, now: Time) {
        (self.is_connected, self.module, self.has_changed) = (false, 0, false);
        self.told.clear();
        self.object.power_up(now);
    }

    fn power_down(&mut self, now: Time) {
        self.object.power_down(now);
    }

    fn address(&self) -> u8 {
        self.object.model().hands.address().unwrap_or(station::NOWHERE)
    }

    fn takes_address(&self) -> bool {
        self.rules.takes_address
    }

    fn set_address(&mut self, now: Time, address: u8, _: bool) {
        self.object.live(now).model.hands.set_address(address);
    }

    fn parameters(&mut self, now: Time, parameters: &SetPrm) -> bool {
        self.object.advance(now);
        let Some(brought) = start::judge(&mut self.object.live(now), parameters) else { return false };
        self.object.live(now).model.brought = brought;
        true
    }

    fn check_configuration(&mut self, now: Time, identifiers: &[u8]) -> Option<Sums> {
        self.object.advance(now);
        let right = CONFIGURATIONS.iter().position(|known| *known == identifiers);
        self.module = (self.rules.configuration)(identifiers, right)?;
        let plug = self.plugged()?;
        Some(Sums { inputs: plug.input_octets.into(), outputs: plug.output_octets.into() })
    }

    fn configuration(&self, out: &mut Vec<u8>) {
        let module = (self.rules.told_configuration)(self.module);
        out.extend(CONFIGURATIONS.get(module).copied().unwrap_or_default());
    }

    fn exchange_begins(&mut self, now: Time) {
        self.connection = ArKey(self.connection.0.wrapping_add(1));
        self.is_connected = true;
        let plugs: Vec<Plug> = self.plugged().into_iter().collect();
        self.object.started(now, self.connection, &plugs);
        let record = self.object.model().fields.record();
        // What could be refused was looked at when it came.
        let _ = self.object.write_record(now, self.place(USER_PARAMETERS), &record);
        self.object.parameter_end(now, self.connection);
        self.told = self.blocks(now);
        self.has_changed = false;
    }

    fn exchange_ends(&mut self, now: Time, _: End) {
        if self.is_connected {
            self.is_connected = false;
            self.object.live(now).model.clock.begin(now, None);
            self.object.ended(now, self.connection);
        }
    }

    fn takes_outputs(&mut self, now: Time) -> bool {
        self.object.advance(now);
        self.asked = Some(now);
        let live = self.object.live(now);
        (live.rules.own.takes_outputs)(&status::known(&live))
    }

    fn outputs(&mut self, now: Time, data: Option<&[u8]>) {
        if self.asked.take() != Some(now) {
            self.object.advance(now);
        }
        self.object.live(now).take(SUBSLOT, data);
        self.look(now);
    }

    fn inputs(&mut self, now: Time, data: &mut [u8]) {
        self.object.frame(now);
        self.object.inputs(now, ENCODER_SLOT, SUBSLOT, data);
        self.look(now);
    }

    fn clock(&mut self, now: Time) {
        own::clock(&mut self.object.live(now));
        self.object.advance(now);
        self.look(now);
    }

    fn freeze(&mut self, now: Time, is_frozen: bool) {
        own::freeze(&mut self.object.live(now), is_frozen);
    }

    fn diagnosis(&mut self, now: Time, out: &mut Vec<u8>) -> DiagnosisBits {
        self.object.advance(now);
        self.look(now);
        let live = self.object.live(now);
        let diagnoses = status::diagnoses(&live, &status::known(&live));
        let has_error = diagnoses.iter().any(|(_, severity)| *severity == Severity::Fault);
        let ext_diag = (live.rules.own.ext_diag)(has_error);
        out.extend_from_slice(&self.told);
        DiagnosisBits { ext_diag, ..DiagnosisBits::default() }
    }

    fn diagnosis_changed(&mut self) -> bool {
        let has_changed = core::mem::take(&mut self.has_changed);
        (self.rules.announces)(has_changed)
    }

    fn write(&mut self, now: Time, access: Access, data: &[u8]) -> Result<(), Refusal> {
        let place = self.access(now, access, PARAMETER_ACCESS)?;
        let written = self.object.write_record(now, place, data);
        if self.rules.requests_disturb_clock {
            self.object.live(now).model.clock.lose();
        }
        self.look(now);
        written.map_err(refused)
    }

    fn read(&mut self, now: Time, access: Access, out: &mut Vec<u8>) -> Result<(), Refusal> {
        let place = self.access(now, access, PARAMETER_ACCESS)?;
        self.object.advance(now);
        let is_storing = self.object.live(now).store.preset_value.deadline().is_some();
        if is_storing && self.rules.is_rude_while_storing {
            return Err(Refusal::error(RecordError::INVALID_INDEX));
        }
        self.object.read_record(now, place, out).map_err(refused)
    }

    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Option<Time> {
        let done = self.object.act(now, action);
        self.look(now);
        done
    }

    fn is_alive(&self) -> bool {
        self.object.is_alive()
    }

    fn led(&mut self, now: Time, name: &str, seen: &Seen) -> Option<&'static str> {
        let seen = object::Seen {
            has_supply: seen.has_supply,
            is_booting: seen.is_booting,
            is_linked: seen.is_linked,
            has_connection: seen.state != Stage::WaitPrm,
            exchanges_data: seen.state == Stage::DataExchange,
            module_differs: seen.prm_fault,
            is_signalling: false,
        };
        self.object.led(now, name, &seen)
    }

    fn counter(&mut self, now: Time, name: &str) -> Option<u64> {
        self.object.counter(now, name)
    }

    fn deadline(&self) -> Option<Time> {
        self.object.deadline()
    }

    fn advance(&mut self, now: Time) {
        self.object.advance(now);
        self.look(now);
    }
}
