//! An application whose clock is ahead of the clock of the stack, for a stand that skips time.

use crate::profinet::{
    Access, Application, ArKey, DiagnosisChange, Identity, Plug, RecordRefusal, ResetScope, Seen, StationData,
};
use alloc::vec::Vec;
use core::time::Duration;
use station::{StandAction, Time};
use wire::http::{Request, Response};

/// An application whose clock may be ahead of the clock of the stack.
pub(super) struct Ahead<A> {
    pub inner: A,
    /// By how much the clock of the application is ahead.
    pub by: Duration,
}

impl<A: Application> Application for Ahead<A> {
    fn identity(&self) -> &Identity {
        self.inner.identity()
    }

    fn plugs(&self) -> &[Plug] {
        self.inner.plugs()
    }

    fn stored_station(&self) -> StationData {
        self.inner.stored_station()
    }

    fn set_station(&mut self, now: Time, current: &StationData, stored: &StationData) {
        self.inner.set_station(now + self.by, current, stored);
    }

    fn accepts_name(&self, name: &[u8]) -> bool {
        self.inner.accepts_name(name)
    }

    fn factory_reset(&mut self, now: Time, scope: ResetScope) -> bool {
        self.inner.factory_reset(now + self.by, scope)
    }

    fn power_up(&mut self, now: Time) {
        self.inner.power_up(now + self.by);
    }

    fn power_down(&mut self, now: Time) {
        self.inner.power_down(now + self.by);
    }

    fn started(&mut self, now: Time, ar: ArKey, plugged: &[Plug]) {
        self.inner.started(now + self.by, ar, plugged);
    }

    fn parameter_end(&mut self, now: Time, ar: ArKey) -> Time {
        self.inner.parameter_end(now + self.by, ar) - self.by
    }

    fn ended(&mut self, now: Time, ar: ArKey) {
        self.inner.ended(now + self.by, ar);
    }

    fn write_record(&mut self, now: Time, access: Access, data: &[u8]) -> Result<(), RecordRefusal> {
        self.inner.write_record(now + self.by, access, data)
    }

    fn read_record(&mut self, now: Time, access: Access, out: &mut Vec<u8>) -> Result<(), RecordRefusal> {
        self.inner.read_record(now + self.by, access, out)
    }

    fn outputs(&mut self, now: Time, slot: u16, subslot: u16, data: Option<&[u8]>) {
        self.inner.outputs(now + self.by, slot, subslot, data);
    }

    fn frame(&mut self, now: Time) {
        self.inner.frame(now + self.by);
    }

    fn inputs(&mut self, now: Time, slot: u16, subslot: u16, data: &mut [u8]) -> bool {
        self.inner.inputs(now + self.by, slot, subslot, data)
    }

    fn next_diagnosis(&mut self) -> Option<DiagnosisChange> {
        self.inner.next_diagnosis()
    }

    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Option<Time> {
        self.inner.act(now + self.by, action).map(|done| done - self.by)
    }

    fn is_alive(&self) -> bool {
        self.inner.is_alive()
    }

    fn led(&mut self, now: Time, name: &str, status: &Seen) -> Option<&'static str> {
        self.inner.led(now + self.by, name, status)
    }

    fn counter(&mut self, now: Time, name: &str) -> Option<u64> {
        self.inner.counter(now + self.by, name)
    }

    fn serves_pages(&self) -> bool {
        self.inner.serves_pages()
    }

    fn page(&mut self, now: Time, request: &Request) -> Response {
        self.inner.page(now + self.by, request)
    }

    fn deadline(&self) -> Option<Time> {
        self.inner.deadline().map(|due| due - self.by)
    }

    fn advance(&mut self, now: Time) {
        self.inner.advance(now + self.by);
    }
}
