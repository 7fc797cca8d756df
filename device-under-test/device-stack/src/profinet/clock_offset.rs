//! An application whose clock is ahead of the clock of the stack, for a stand that skips time.

use crate::profinet::{
    ArKey, DiagnosisChange, IoApplication, IoIdentity, PlugChange, PluggableSubmodule, RecordAccess, RecordRefusal,
    ResetScope, StackStatus, StationData,
};
use alloc::vec::Vec;
use core::time::Duration;
use station::{StandAction, Time};
use wire::http::{HttpRequest, HttpResponse};

/// An application whose clock may be ahead of the clock of the stack.
pub(super) struct OffsetClock<A> {
    pub inner: A,
    /// By how much the clock of the application is ahead.
    pub ahead: Duration,
}

impl<A: IoApplication> IoApplication for OffsetClock<A> {
    fn identity(&self) -> &IoIdentity {
        self.inner.identity()
    }

    fn plugs(&self) -> &[PluggableSubmodule] {
        self.inner.plugs()
    }

    fn stored_station(&self) -> StationData {
        self.inner.stored_station()
    }

    fn set_station(&mut self, now: Time, current: &StationData, stored: &StationData) {
        self.inner.set_station(now + self.ahead, current, stored);
    }

    fn accepts_name(&self, name: &[u8]) -> bool {
        self.inner.accepts_name(name)
    }

    fn factory_reset(&mut self, now: Time, scope: ResetScope) -> bool {
        self.inner.factory_reset(now + self.ahead, scope)
    }

    fn power_up(&mut self, now: Time) {
        self.inner.power_up(now + self.ahead);
    }

    fn power_down(&mut self, now: Time) {
        self.inner.power_down(now + self.ahead);
    }

    fn started(&mut self, now: Time, ar: ArKey, plugged: &[PluggableSubmodule]) {
        self.inner.started(now + self.ahead, ar, plugged);
    }

    fn parameter_end(&mut self, now: Time, ar: ArKey) -> Time {
        self.inner.parameter_end(now + self.ahead, ar) - self.ahead
    }

    fn ended(&mut self, now: Time, ar: ArKey) {
        self.inner.ended(now + self.ahead, ar);
    }

    fn write_record(&mut self, now: Time, access: RecordAccess, data: &[u8]) -> Result<(), RecordRefusal> {
        self.inner.write_record(now + self.ahead, access, data)
    }

    fn read_record(&mut self, now: Time, access: RecordAccess, out: &mut Vec<u8>) -> Result<(), RecordRefusal> {
        self.inner.read_record(now + self.ahead, access, out)
    }

    fn outputs(&mut self, now: Time, slot: u16, subslot: u16, data: Option<&[u8]>) {
        self.inner.outputs(now + self.ahead, slot, subslot, data);
    }

    fn frame(&mut self, now: Time) {
        self.inner.frame(now + self.ahead);
    }

    fn inputs(&mut self, now: Time, slot: u16, subslot: u16, data: &mut [u8]) -> bool {
        self.inner.inputs(now + self.ahead, slot, subslot, data)
    }

    fn next_diagnosis(&mut self) -> Option<DiagnosisChange> {
        self.inner.next_diagnosis()
    }

    fn next_plug(&mut self) -> Option<PlugChange> {
        self.inner.next_plug()
    }

    fn next_event(&mut self) -> Option<(u16, u16)> {
        self.inner.next_event()
    }

    fn controllers(&self) -> usize {
        self.inner.controllers()
    }

    fn supervisors(&self) -> usize {
        self.inner.supervisors()
    }

    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Option<Time> {
        self.inner.act(now + self.ahead, action).map(|done| done - self.ahead)
    }

    fn is_alive(&self) -> bool {
        self.inner.is_alive()
    }

    fn led(&mut self, now: Time, name: &str, status: &StackStatus) -> Option<&'static str> {
        self.inner.led(now + self.ahead, name, status)
    }

    fn counter(&mut self, now: Time, name: &str) -> Option<u64> {
        self.inner.counter(now + self.ahead, name)
    }

    fn serves_pages(&self) -> bool {
        self.inner.serves_pages()
    }

    fn page(&mut self, now: Time, request: &HttpRequest) -> HttpResponse {
        self.inner.page(now + self.ahead, request)
    }

    fn deadline(&self) -> Option<Time> {
        self.inner.deadline().map(|due| due - self.ahead)
    }

    fn advance(&mut self, now: Time) {
        self.inner.advance(now + self.ahead);
    }
}
