//! The encoder as the application of a PROFIBUS slave. It maps Set_Prm, Chk_Cfg and Data_Exchange to the start, the user parameter
//! record and the telegrams of the encoder object, and data set 47 to its parameter access.

use super::controls::NOWHERE;
use super::hooks::{A3m60Check, A3m60Deviations};
use super::{A3m60State, CONFIGURATIONS, FACTS, SUBMODULES, SUBSLOT, encoder, set_prm, status};
use crate::models::sick;
use alloc::vec::Vec;
use device_stack::profibus::{
    DiagnosisBits, DpState as SlaveState, Dpv1Access, Dpv1RecordRefusal, ExchangeEnd, SlaveApplication, SlaveIdentity,
    SlaveStatus,
};
use device_stack::profinet::{
    self as object, ArKey, DiagnosisSeverity, IoApplication as _, PluggableSubmodule, RecordAccess as ObjectAccess,
    RecordRefusal,
};
use encoder_profile::deviations::EncoderDeviations;
use encoder_profile::encoder_object::{
    ACCESS_POINT_SUBSLOT, ENCODER_API, ENCODER_SLOT, EncoderObject, EncoderSpecimen,
};
use encoder_profile::facts::EncoderVariant;
use station::{StandAction, Time};
use wire::profibus::cfg::IoLengths;
use wire::profibus::dpv1::RecordError;
use wire::profibus::prm::SetPrm;

/// Record index of the user parameters in the encoder object, followed by that of the parameter access.
const USER_PARAMETERS: u16 = 0xBF00;
const PARAMETER_ACCESS: u16 = 0xB02E;
/// Data set of the parameter access on the bus, followed by the last slot that has it.
const PARAMETER_DATA_SET: u8 = 47;
const LAST_SLOT: u8 = 1;

/// An A3M60, for a PROFIBUS slave stack.
pub struct Encoder {
    object: EncoderObject<A3m60State>,
    identity: SlaveIdentity,
    /// The key of the connection.
    connection: ArKey,
    is_connected: bool,
    /// The module of the last accepted configuration, as an index into `CONFIGURATIONS`.
    module: usize,
    /// The blocks of the diagnosis.
    blocks: Vec<u8>,
    /// Whether the blocks have changed since the last `diagnosis_changed`.
    has_changed: bool,
}

impl Encoder {
    /// Creates an encoder in factory state except for its address.
    pub fn new(
        variant: &'static EncoderVariant,
        deviations: EncoderDeviations,
        shared: sick::hooks::SickDeviations,
        hooks: A3m60Deviations,
        shaft: u64,
        address: u8,
    ) -> Encoder {
        let state = A3m60State::new(address, shared, hooks);
        let object = EncoderObject::new(
            &FACTS,
            state,
            variant,
            deviations,
            EncoderSpecimen { shaft, ..EncoderSpecimen::default() },
        );
        let identity = SlaveIdentity {
            ident: 0x0C0A,
            boot_time: FACTS.timing.boot,
            freeze: true,
            sync: true,
            fail_safe: true,
            dpv1: true,
            ms1: true,
            extra_alarm_sap: false,
            ms2: 0,
            abilities: None,
            isochronous: true,
            set_ext_prm: false,
        };
        Encoder {
            object,
            identity,
            connection: ArKey(0),
            is_connected: false,
            module: 0,
            blocks: Vec::new(),
            has_changed: false,
        }
    }

    /// Updates the blocks of the diagnosis.
    fn update_diagnosis(&mut self, now: Time) {
        while self.object.next_diagnosis().is_some() {}
        let blocks = status::blocks(&status::diagnoses(&self.object.live(now)));
        if blocks != self.blocks {
            (self.blocks, self.has_changed) = (blocks, true);
        }
    }

    fn plugged(&self) -> Option<PluggableSubmodule> {
        let submodule = SUBMODULES.get(self.module)?;
        let is_it = |plug: &PluggableSubmodule| plug.submodule_ident == submodule.ident && plug.subslot == SUBSLOT;
        self.object.plugs().iter().copied().find(is_it)
    }

    /// Maps a data set to a record of the encoder object: manual, 3.5.
    fn access(&mut self, now: Time, access: Dpv1Access, is_read: bool) -> Result<ObjectAccess, Dpv1RecordRefusal> {
        if access.slot > LAST_SLOT {
            return Err(Dpv1RecordRefusal::error(RecordError::INVALID_SLOT));
        }
        let live = self.object.live(now);
        let data_set = A3m60Check::DataSet { index: access.index, telegram: live.ram.telegram().number, is_read };
        if !live.model.hooks.check(data_set, access.index == PARAMETER_DATA_SET) {
            return Err(Dpv1RecordRefusal::error(RecordError::INVALID_INDEX));
        }
        Ok(self.object_access(PARAMETER_ACCESS))
    }

    fn object_access(&self, index: u16) -> ObjectAccess {
        ObjectAccess {
            ar: Some(self.connection),
            api: ENCODER_API,
            slot: ENCODER_SLOT,
            subslot: ACCESS_POINT_SUBSLOT,
            index,
        }
    }
}

fn refused(refusal: RecordRefusal) -> Dpv1RecordRefusal {
    Dpv1RecordRefusal::error(RecordError(refusal.code1()))
}

impl SlaveApplication for Encoder {
    fn identity(&self) -> &SlaveIdentity {
        &self.identity
    }

    fn power_up(&mut self, now: Time) {
        (self.is_connected, self.module, self.has_changed) = (false, 0, false);
        self.blocks.clear();
        self.object.power_up(now);
    }

    fn power_down(&mut self, now: Time) {
        self.object.power_down(now);
    }

    fn address(&self) -> u8 {
        self.object.model().controls.address().unwrap_or(NOWHERE)
    }

    /// The address is that of the switches: manual, 4.3.2.
    fn takes_address(&self) -> bool {
        false
    }

    fn set_address(&mut self, _: Time, _: u8, _: bool) {}

    fn parameters(&mut self, now: Time, parameters: &SetPrm) -> bool {
        self.object.advance(now);
        let Some(brought) = set_prm::check_set_prm(&self.object.live(now), parameters) else { return false };
        self.object.live(now).model.set_prm = brought;
        true
    }

    fn check_configuration(&mut self, now: Time, identifiers: &[u8]) -> Option<IoLengths> {
        self.object.advance(now);
        self.module = CONFIGURATIONS.iter().position(|known| *known == identifiers)?;
        let plug = self.plugged()?;
        Some(IoLengths { inputs: plug.input_octets.into(), outputs: plug.output_octets.into() })
    }

    fn configuration(&self, out: &mut Vec<u8>) {
        out.extend(CONFIGURATIONS.get(self.module).copied().unwrap_or_default());
    }

    fn exchange_begins(&mut self, now: Time) {
        self.connection = ArKey(self.connection.0.wrapping_add(1));
        self.is_connected = true;
        let plugs: Vec<PluggableSubmodule> = self.plugged().into_iter().collect();
        self.object.started(now, self.connection, &plugs);
        let record = self.object.model().fields.record();
        // Cannot be refused, since Set_Prm was checked on arrival.
        let _ = self.object.write_record(now, self.object_access(USER_PARAMETERS), &record);
        self.object.parameter_end(now, self.connection);
        self.update_diagnosis(now);
        self.has_changed = false;
    }

    fn exchange_ends(&mut self, now: Time, _: ExchangeEnd) {
        if self.is_connected {
            self.is_connected = false;
            self.object.live(now).model.clock.begin(now, None);
            self.object.ended(now, self.connection);
        }
    }

    fn outputs(&mut self, now: Time, data: Option<&[u8]>) {
        self.object.advance(now);
        self.object.live(now).take(SUBSLOT, data);
        self.update_diagnosis(now);
    }

    fn inputs(&mut self, now: Time, data: &mut [u8]) {
        self.object.frame(now);
        self.object.inputs(now, ENCODER_SLOT, SUBSLOT, data);
        self.update_diagnosis(now);
    }

    fn clock(&mut self, now: Time) {
        encoder::clock(&mut self.object.live(now));
        self.object.advance(now);
        self.update_diagnosis(now);
    }

    fn diagnosis(&mut self, now: Time, out: &mut Vec<u8>) -> DiagnosisBits {
        self.object.advance(now);
        self.update_diagnosis(now);
        let live = self.object.live(now);
        let has_error = status::diagnoses(&live).iter().any(|(_, severity)| *severity == DiagnosisSeverity::Fault);
        out.extend_from_slice(&self.blocks);
        DiagnosisBits { ext_diag: has_error, ..DiagnosisBits::default() }
    }

    fn diagnosis_changed(&mut self) -> bool {
        core::mem::take(&mut self.has_changed)
    }

    fn write(&mut self, now: Time, access: Dpv1Access, data: &[u8]) -> Result<(), Dpv1RecordRefusal> {
        let place = self.access(now, access, false)?;
        let written = self.object.write_record(now, place, data);
        self.update_diagnosis(now);
        written.map_err(refused)
    }

    fn read(&mut self, now: Time, access: Dpv1Access, out: &mut Vec<u8>) -> Result<(), Dpv1RecordRefusal> {
        self.object.advance(now);
        let place = self.access(now, access, true)?;
        self.object.read_record(now, place, out).map_err(refused)
    }

    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Option<Time> {
        let done = self.object.act(now, action);
        self.update_diagnosis(now);
        done
    }

    fn is_alive(&self) -> bool {
        self.object.is_alive()
    }

    fn led(&mut self, now: Time, name: &str, seen: &SlaveStatus) -> Option<&'static str> {
        let status = object::StackStatus {
            has_supply: seen.has_supply,
            is_booting: seen.is_booting,
            is_linked: seen.is_linked,
            has_connection: seen.state != SlaveState::WaitPrm,
            exchanges_data: seen.state == SlaveState::DataExchange,
            module_differs: seen.prm_fault,
            is_signalling: false,
        };
        self.object.led(now, name, &status)
    }

    fn counter(&mut self, now: Time, name: &str) -> Option<u64> {
        self.object.counter(now, name)
    }

    fn deadline(&self) -> Option<Time> {
        self.object.deadline()
    }

    fn advance(&mut self, now: Time) {
        self.object.advance(now);
        self.update_diagnosis(now);
    }
}
