//! The encoder object as an application of a PROFINET device stack.

use super::modules::{self, ENCODER_SLOT};
use super::names;
use super::{ConnectionPhase, EncoderModel, NonVolatileData, PoweredEncoder, StandFaults, VolatileData};
use crate::encoder::{NvmCell, Shaft};
use crate::encoder_object::deviations::EncoderDeviations;
use crate::encoder_object::hooks::SubmoduleInputs;
use crate::facts::{EncoderVariant, ManualFacts};
use crate::profidrive::checks::EncoderCheck;
use crate::profidrive::parameters::PendingResponses;
use alloc::vec::Vec;
use device_stack::profinet::{
    ArKey, DiagnosisChange, IoApplication, IoIdentity, PluggableSubmodule, RecordAccess, RecordRefusal, ResetScope,
    StackStatus, StationData,
};
use station::{StandAction, Time};
use wire::http::{HttpRequest, HttpResponse};

/// The individual data of one specimen.
#[derive(Clone, Debug, Default)]
pub struct EncoderSpecimen {
    /// MAC address; its last three bytes are the serial number.
    pub mac: [u8; 6],
    /// Initial shaft position in hardware steps.
    pub shaft: u64,
    /// The stored name and addresses.
    pub station: StationData,
}

/// An encoder of the encoder profile, the application of a PROFINET stack.
pub struct EncoderObject<M: EncoderModel> {
    pub(super) facts: &'static ManualFacts,
    pub(super) model: M,
    pub(super) variant: &'static EncoderVariant,
    pub(super) deviations: EncoderDeviations,
    pub(super) identity: IoIdentity,
    plugs: Vec<PluggableSubmodule>,
    pub(super) shaft: Shaft,
    pub(super) faults: StandFaults,
    pub(super) store: NonVolatileData,
    pub(super) ram: VolatileData,
    /// The parameter responses that wait to be fetched.
    pub(super) responses: PendingResponses<ArKey>,
    pub(super) powered: bool,
}

impl<M: EncoderModel> EncoderObject<M> {
    /// An encoder in factory state except for its station data, with power from the start of the run.
    pub fn new(
        facts: &'static ManualFacts,
        model: M,
        variant: &'static EncoderVariant,
        deviations: EncoderDeviations,
        piece: EncoderSpecimen,
    ) -> EncoderObject<M> {
        let EncoderSpecimen { mac, shaft, station } = piece;
        let hardware = variant.hardware;
        let shaft = Shaft::new(hardware.steps_per_revolution, (shaft % hardware.range()) as i64);
        let faults = StandFaults::default();
        let store =
            NonVolatileData { offset: NvmCell::new(0), preset_value: NvmCell::new(0), station: NvmCell::new(station) };
        let ram = VolatileData::new(Time::ZERO, facts, variant, &deviations, &shaft, &store, &faults);
        let mut object = EncoderObject {
            facts,
            model,
            variant,
            identity: modules::identity(facts, variant, mac),
            plugs: modules::plugs(facts, variant, &deviations.hooks),
            responses: PendingResponses::default(),
            deviations,
            shaft,
            faults,
            store,
            ram,
            powered: true,
        };
        object.apply_retained(Time::ZERO);
        object
    }

    /// The state of the model.
    pub fn model(&self) -> &M {
        &self.model
    }

    /// The encoder at `now`.
    pub fn live(&mut self, now: Time) -> PoweredEncoder<'_, M> {
        PoweredEncoder {
            now,
            facts: self.facts,
            variant: self.variant,
            hardware: self.variant.hardware,
            deviations: &self.deviations,
            shaft: &self.shaft,
            faults: &self.faults,
            store: &mut self.store,
            ram: &mut self.ram,
            model: &mut self.model,
        }
    }
}

impl<M: EncoderModel> IoApplication for EncoderObject<M> {
    fn identity(&self) -> &IoIdentity {
        &self.identity
    }

    fn plugs(&self) -> &[PluggableSubmodule] {
        &self.plugs
    }

    fn stored_station(&self) -> StationData {
        self.store.station.stored().clone()
    }

    fn set_station(&mut self, now: Time, current: &StationData, stored: &StationData) {
        self.advance(now);
        self.ram.station.clone_from(current);
        if self.store.station.stored() != stored {
            self.store.station.replace(stored.clone());
        }
    }

    fn accepts_name(&self, name: &[u8]) -> bool {
        names::accepts(name, self.facts.longest_name)
    }

    fn factory_reset(&mut self, now: Time, scope: ResetScope) -> bool {
        self.advance(now);
        let (reset, is_connected) = ((self.facts.resets)(scope), self.ram.phase != ConnectionPhase::Alone);
        let is_carried_out = self.deviations.checks.check(EncoderCheck::FactoryReset { is_connected }, reset.is_some());
        if let Some(reset) = reset.filter(|_| is_carried_out) {
            self.reset(now, reset);
        }
        is_carried_out
    }

    fn power_up(&mut self, now: Time) {
        if let Some(reset) = self.model.reset_at_power_up() {
            self.reset(now, reset);
        }
        self.load(now);
        self.advance(now);
    }

    fn power_down(&mut self, now: Time) {
        self.advance(now);
        self.lose_power(now);
    }

    fn started(&mut self, now: Time, ar: ArKey, plugged: &[PluggableSubmodule]) {
        self.advance(now);
        self.start(now, ar, plugged);
    }

    fn parameter_end(&mut self, now: Time, ar: ArKey) -> Time {
        self.advance(now);
        self.end_parameters(now, ar)
    }

    fn ended(&mut self, now: Time, ar: ArKey) {
        self.advance(now);
        self.end(now, ar);
    }

    fn write_record(&mut self, now: Time, access: RecordAccess, data: &[u8]) -> Result<(), RecordRefusal> {
        self.advance(now);
        self.write(now, access, data)
    }

    fn read_record(&mut self, now: Time, access: RecordAccess, out: &mut Vec<u8>) -> Result<(), RecordRefusal> {
        self.advance(now);
        self.read(now, access, out)
    }

    fn outputs(&mut self, now: Time, slot: u16, subslot: u16, data: Option<&[u8]>) {
        self.advance(now);
        if slot == ENCODER_SLOT {
            self.live(now).take(subslot, data);
        }
    }

    fn frame(&mut self, now: Time) {
        self.advance(now);
        self.live(now).cycle();
    }

    fn inputs(&mut self, now: Time, slot: u16, subslot: u16, data: &mut [u8]) -> bool {
        let submodule = self.ram.submodules.iter().find(|one| (ENCODER_SLOT, one.subslot) == (slot, subslot));
        let Some(submodule) = submodule.copied() else { return true };
        let live = self.live(now);
        let image = &live.ram.before.sent;
        submodule.telegram.write(image, data);
        live.deviations.hooks.apply(image.good, |hooks, are_good| {
            let right = SubmoduleInputs { octets: submodule.telegram.octets(image), are_good };
            let SubmoduleInputs { mut octets, are_good } = hooks.inputs(&live.view(), submodule, image, right);
            octets.resize(data.len(), 0);
            data.copy_from_slice(&octets);
            are_good
        })
    }

    fn next_diagnosis(&mut self) -> Option<DiagnosisChange> {
        self.ram.changes.pop_front()
    }

    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Option<Time> {
        self.advance(now);
        let done = self.act_on_encoder(now, action)?;
        self.advance(now);
        Some(done)
    }

    fn is_alive(&self) -> bool {
        self.model.is_alive()
    }

    fn led(&mut self, now: Time, name: &str, status: &StackStatus) -> Option<&'static str> {
        self.led_state(now, name, status)
    }

    fn counter(&mut self, now: Time, name: &str) -> Option<u64> {
        self.advance(now);
        self.counter_value(now, name)
    }

    fn serves_pages(&self) -> bool {
        self.model.serves_pages()
    }

    fn page(&mut self, now: Time, request: &HttpRequest) -> HttpResponse {
        self.advance(now);
        M::page(&mut self.live(now), request)
    }

    fn deadline(&self) -> Option<Time> {
        [self.store.offset.deadline(), self.store.preset_value.deadline(), self.model.deadline()]
            .into_iter()
            .flatten()
            .min()
    }

    fn advance(&mut self, now: Time) {
        if self.powered {
            self.live(now).advance();
        }
    }
}
