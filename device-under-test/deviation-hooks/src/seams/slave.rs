//! Deviations at the hooks of a PROFIBUS slave.
//!
//! A deviation without state is a closure. A deviation with state implements [`SlaveHooks`] next to its table row and is
//! [`add`](SlaveDeviations::add)ed.

use super::last_cycles::LastCycles;
use alloc::boxed::Box;
use alloc::rc::Rc;
use alloc::vec;
use alloc::vec::Vec;
use core::cell::RefCell;
use core::time::Duration;
use device_stack::Attached;
use device_stack::profibus::{SlaveApplication, SlaveHooks, SlaveStackCheck};
use station::{StandAction, Time};
use wire::profibus::address::SetSlaveAddress;
use wire::profibus::cfg::IoLengths;
use wire::profibus::diag::SlaveDiag;
use wire::profibus::dpv1::{Dpv1Pdu, PduDirection};
use wire::profibus::fdl::{BitTimes, DataFrame, FdlFormat, FdlFrame};
use wire::profibus::global_control::GlobalControl;
use wire::profibus::prm::SetPrm;
use wire::profibus::sap::{SapService, SlaveSap};

/// The deviations at [`SlaveHooks`].
#[derive(Default)]
pub struct SlaveDeviations {
    hooks: Vec<Box<dyn SlaveHooks>>,
    buffers: BufferedData,
}

/// The longest time for which buffered inputs are held: a slave renews its buffer even while no master asks.
const LONGEST_HELD: Duration = Duration::from_millis(20);

/// Inputs and outputs in the buffers of a DP ASIC: the inputs of an answer were put there some cycles before, and outputs are taken
/// out some cycles later. They come last, after all other deviations.
#[derive(Default)]
struct BufferedData {
    inputs: LastCycles<(Time, Vec<u8>)>,
    outputs: LastCycles<Vec<u8>>,
}

impl BufferedData {
    fn clear(&mut self) {
        self.inputs.clear();
        self.outputs.clear();
    }

    fn inputs(&mut self, now: Time, inputs: &mut [u8]) {
        if self.inputs.cycles == 0 {
            return;
        }
        let is_held = |at: &Time, octets: &[u8]| octets.len() == inputs.len() && now.since(*at) <= LONGEST_HELD;
        self.inputs.retain(|(at, octets)| is_held(at, octets));
        if let Some((_, octets)) = self.inputs.oldest_with((now, inputs.to_vec())) {
            inputs.copy_from_slice(octets);
        }
    }

    fn outputs(&mut self, outputs: &mut Option<Vec<u8>>) {
        let Some(octets) = outputs else { return self.outputs.clear() };
        if self.outputs.cycles > 0 {
            *outputs = self.outputs.oldest_with(core::mem::take(octets)).cloned();
        }
    }
}

impl SlaveDeviations {
    /// Adds a deviation that has state or uses several hooks.
    pub fn add(&mut self, deviation: impl SlaveHooks + 'static) {
        self.hooks.push(Box::new(deviation));
    }

    /// Lets each answer have inputs that are this number of cycles old; of several numbers the highest.
    pub fn inputs_old(&mut self, cycles: usize) {
        self.buffers.inputs.cycles = self.buffers.inputs.cycles.max(cycles);
    }

    /// Lets outputs be taken this number of cycles later; of several numbers the highest.
    pub fn outputs_late(&mut self, cycles: usize) {
        self.buffers.outputs.cycles = self.buffers.outputs.cycles.max(cycles);
    }

    fn is_empty(&self) -> bool {
        self.hooks.is_empty() && self.buffers.inputs.cycles == 0 && self.buffers.outputs.cycles == 0
    }

    /// The handle that a device is built with.
    pub fn attached(self) -> Attached<dyn SlaveHooks> {
        if self.is_empty() { Attached::NONE } else { Attached::new(Rc::new(RefCell::new(self))) }
    }

    /// Changes a decision, given the check and the decision of the slave.
    pub fn check(&mut self, decide: impl FnMut(SlaveStackCheck, bool) -> bool + 'static) {
        self.add(CheckHook(decide));
    }

    /// Like [`check`](SlaveDeviations::check), but also given the encoder.
    pub fn check_with(&mut self, decide: impl FnMut(&dyn SlaveApplication, SlaveStackCheck, bool) -> bool + 'static) {
        self.add(EncoderCheckHook(decide));
    }

    /// Changes the data of the requests for a service; with `false` the slave does not receive the request.
    pub fn request(&mut self, of: SlaveSap, change: impl FnMut(&mut Vec<u8>) -> bool + 'static) {
        self.add(RequestHook(SapService::Slave(of), change));
    }

    /// Like [`request`](SlaveDeviations::request), but before all other deviations.
    pub fn request_first(&mut self, of: SlaveSap, change: impl FnMut(&mut Vec<u8>) -> bool + 'static) {
        self.hooks.insert(0, Box::new(RequestHook(SapService::Slave(of), change)));
    }

    /// Changes each Set_Prm before the slave handles it.
    pub fn set_prm(&mut self, mut change: impl FnMut(&mut SetPrm) + 'static) {
        self.request(SlaveSap::SET_PRM, move |data| {
            if let Ok(mut parameters) = SetPrm::parse(data) {
                change(&mut parameters);
                data.clear();
                parameters.write(data);
            }
            true
        });
    }

    /// Changes each Set_Slave_Address before the slave handles it.
    pub fn set_slave_address(&mut self, mut change: impl FnMut(&mut SetSlaveAddress) + 'static) {
        self.request(SlaveSap::SET_SLAVE_ADDRESS, move |data| {
            if let Ok(mut request) = SetSlaveAddress::parse(data) {
                change(&mut request);
                data.clear();
                request.write(data);
            }
            true
        });
    }

    /// Changes each Global_Control before the slave obeys it.
    pub fn global_control(&mut self, mut change: impl FnMut(&mut GlobalControl) + 'static) {
        self.request(SlaveSap::GLOBAL_CONTROL, move |data| {
            if let Ok(mut control) = GlobalControl::parse(data) {
                change(&mut control);
                data.clear();
                control.write(data);
            }
            true
        });
    }

    /// Changes each record request before the slave handles it.
    pub fn record(&mut self, mut change: impl FnMut(&mut Dpv1Pdu) + 'static) {
        self.request(SlaveSap::SERVER, move |data| {
            if let Ok(mut pdu) = Dpv1Pdu::parse(data, PduDirection::Request) {
                change(&mut pdu);
                data.clear();
                pdu.write(data);
            }
            true
        });
    }

    /// Drops the requests for which `receives` returns `false`.
    pub fn filter_requests(&mut self, receives: impl FnMut(&DataFrame<'_>, SapService) -> bool + 'static) {
        self.add(ReceiveFilter(receives));
    }

    /// Changes each telegram that the slave sends; an empty one is not sent.
    pub fn answer(&mut self, change: impl FnMut(&mut Vec<u8>) + 'static) {
        self.add(AnswerHook(change));
    }

    /// Changes each diagnosis that is sent, given the frame that carries it.
    pub fn diagnosis(&mut self, change: impl FnMut(&mut SlaveDiag, &DataFrame<'_>) + 'static) {
        self.add(DiagnosisHook(change));
    }

    /// Changes the identifiers in the response to Get_Cfg.
    pub fn get_cfg(&mut self, mut change: impl FnMut(&mut Vec<u8>) + 'static) {
        self.answer(move |telegram| {
            let Some(frame) = frame(telegram).filter(|frame| !frame.fc.is_request()) else { return };
            if SapService::of(&frame) == SapService::Slave(SlaveSap::GET_CFG) && !frame.data.is_empty() {
                let mut identifiers = frame.data.to_vec();
                change(&mut identifiers);
                *telegram = with_data(&frame, &identifiers);
            }
        });
    }

    /// Changes the time from a request to its answer.
    pub fn delay(&mut self, delay: impl FnMut(BitTimes) -> BitTimes + 'static) {
        self.add(DelayHook(delay));
    }

    /// Changes the time from power-up to the first answer.
    pub fn boot_time(&mut self, time: impl FnMut(Duration) -> Duration + 'static) {
        self.add(BootHook(time));
    }

    /// Changes the time from a valid Chk_Cfg to data exchange.
    pub fn ready_time(&mut self, time: impl FnMut(Duration) -> Duration + 'static) {
        self.add(ReadyHook(time));
    }

    /// Changes the time that a record takes.
    pub fn record_time(&mut self, time: impl FnMut(Duration) -> Duration + 'static) {
        self.add(RecordHook(time));
    }

    /// Changes the watchdog time.
    pub fn watchdog(&mut self, time: impl FnMut(Duration) -> Duration + 'static) {
        self.add(WatchdogHook(time));
    }

    /// Changes the parameters that the slave passes to the encoder.
    pub fn parameters(&mut self, change: impl FnMut(&mut SetPrm) + 'static) {
        self.add(ParameterHook(change));
    }
}

impl SlaveHooks for SlaveDeviations {
    fn check(&mut self, encoder: &dyn SlaveApplication, check: SlaveStackCheck, verdict: bool) -> bool {
        self.hooks.iter_mut().fold(verdict, |verdict, of| of.check(encoder, check, verdict))
    }

    fn received_telegrams(&mut self, encoder: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        let mut received = vec![telegram.to_vec()];
        for of in &mut self.hooks {
            received = received.iter().flat_map(|telegram| of.received_telegrams(encoder, telegram)).collect();
        }
        received
    }

    fn sent_telegram(&mut self, encoder: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        self.hooks.iter_mut().for_each(|of| of.sent_telegram(encoder, telegram));
    }

    fn delay(&mut self, right: BitTimes) -> BitTimes {
        self.hooks.iter_mut().fold(right, |right, of| of.delay(right))
    }

    fn boot_time(&mut self, right: Duration) -> Duration {
        self.hooks.iter_mut().fold(right, |right, of| of.boot_time(right))
    }

    fn ready_time(&mut self, right: Duration) -> Duration {
        self.hooks.iter_mut().fold(right, |right, of| of.ready_time(right))
    }

    fn record_time(&mut self, right: Duration) -> Duration {
        self.hooks.iter_mut().fold(right, |right, of| of.record_time(right))
    }

    fn watchdog(&mut self, right: Duration) -> Duration {
        self.hooks.iter_mut().fold(right, |right, of| of.watchdog(right))
    }

    fn parameters(&mut self, parameters: &mut SetPrm) -> bool {
        let mut are_given = true;
        for of in &mut self.hooks {
            are_given &= of.parameters(parameters);
        }
        are_given
    }

    fn configuration(
        &mut self,
        encoder: &dyn SlaveApplication,
        identifiers: &[u8],
        right: Option<IoLengths>,
    ) -> Option<IoLengths> {
        self.buffers.clear();
        self.hooks.iter_mut().fold(right, |right, of| of.configuration(encoder, identifiers, right))
    }

    fn outputs(&mut self, outputs: &mut Option<Vec<u8>>) {
        self.hooks.iter_mut().for_each(|of| of.outputs(outputs));
        self.buffers.outputs(outputs);
    }

    fn inputs(&mut self, now: Time, inputs: &mut [u8]) {
        self.hooks.iter_mut().for_each(|of| of.inputs(now, inputs));
        self.buffers.inputs(now, inputs);
    }

    fn starts(&mut self) {
        self.hooks.iter_mut().for_each(|of| of.starts());
        self.buffers.clear();
    }

    fn act(&mut self, action: &StandAction<'_>) {
        self.hooks.iter_mut().for_each(|of| of.act(action));
    }
}

/// Parses a telegram; `None` if its frame cannot carry data.
pub fn frame(telegram: &[u8]) -> Option<DataFrame<'_>> {
    match FdlFrame::parse(telegram) {
        Ok(FdlFrame::Data(frame)) => Some(frame),
        _ => None,
    }
}

/// Writes a telegram like `frame` with other data.
pub fn with_data(frame: &DataFrame<'_>, data: &[u8]) -> Vec<u8> {
    let has_octets = !data.is_empty() || !frame.source.is_empty() || !frame.destination.is_empty();
    let format = if has_octets { FdlFormat::Variable } else { FdlFormat::NoData };
    let mut telegram = Vec::new();
    FdlFrame::Data(DataFrame { format, data, ..*frame }).write(&mut telegram);
    telegram
}

/// Parses a telegram as a response to Slave_Diag; `None` if it is another telegram.
pub fn diagnosis_response(telegram: &[u8]) -> Option<(DataFrame<'_>, SlaveDiag)> {
    let frame = frame(telegram).filter(|frame| !frame.fc.is_request())?;
    let is_diagnosis = SapService::of(&frame) == SapService::Slave(SlaveSap::SLAVE_DIAG);
    let diagnosis = SlaveDiag::parse(frame.data).ok().filter(|_| is_diagnosis)?;
    Some((frame, diagnosis))
}

/// Parses a telegram as a request of a master: its frame and service; `None` if it is a response.
pub fn request(telegram: &[u8]) -> Option<(DataFrame<'_>, SapService)> {
    let frame = frame(telegram).filter(|frame| frame.fc.is_request())?;
    Some((frame, SapService::of(&frame)))
}

struct CheckHook<F>(F);

impl<F: FnMut(SlaveStackCheck, bool) -> bool> SlaveHooks for CheckHook<F> {
    fn check(&mut self, _: &dyn SlaveApplication, check: SlaveStackCheck, verdict: bool) -> bool {
        (self.0)(check, verdict)
    }
}

struct EncoderCheckHook<F>(F);

impl<F: FnMut(&dyn SlaveApplication, SlaveStackCheck, bool) -> bool> SlaveHooks for EncoderCheckHook<F> {
    fn check(&mut self, encoder: &dyn SlaveApplication, check: SlaveStackCheck, verdict: bool) -> bool {
        (self.0)(encoder, check, verdict)
    }
}

struct RequestHook<F>(SapService, F);

impl<F: FnMut(&mut Vec<u8>) -> bool> SlaveHooks for RequestHook<F> {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        let Some((frame, _)) = request(telegram).filter(|(_, service)| *service == self.0) else {
            return vec![telegram.to_vec()];
        };
        let mut data = frame.data.to_vec();
        if (self.1)(&mut data) { vec![with_data(&frame, &data)] } else { Vec::new() }
    }
}

struct ReceiveFilter<F>(F);

impl<F: FnMut(&DataFrame<'_>, SapService) -> bool> SlaveHooks for ReceiveFilter<F> {
    fn received_telegrams(&mut self, _: &dyn SlaveApplication, telegram: &[u8]) -> Vec<Vec<u8>> {
        let receives = request(telegram).is_none_or(|(frame, service)| (self.0)(&frame, service));
        receives.then(|| telegram.to_vec()).into_iter().collect()
    }
}

struct AnswerHook<F>(F);

impl<F: FnMut(&mut Vec<u8>)> SlaveHooks for AnswerHook<F> {
    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        (self.0)(telegram);
    }
}

struct DiagnosisHook<F>(F);

impl<F: FnMut(&mut SlaveDiag, &DataFrame<'_>)> SlaveHooks for DiagnosisHook<F> {
    fn sent_telegram(&mut self, _: &dyn SlaveApplication, telegram: &mut Vec<u8>) {
        let Some((frame, mut diagnosis)) = diagnosis_response(telegram) else { return };
        (self.0)(&mut diagnosis, &frame);
        let mut data = Vec::new();
        diagnosis.write(&mut data);
        *telegram = with_data(&frame, &data);
    }
}

struct DelayHook<F>(F);

impl<F: FnMut(BitTimes) -> BitTimes> SlaveHooks for DelayHook<F> {
    fn delay(&mut self, right: BitTimes) -> BitTimes {
        (self.0)(right)
    }
}

struct BootHook<F>(F);

impl<F: FnMut(Duration) -> Duration> SlaveHooks for BootHook<F> {
    fn boot_time(&mut self, right: Duration) -> Duration {
        (self.0)(right)
    }
}

struct ReadyHook<F>(F);

impl<F: FnMut(Duration) -> Duration> SlaveHooks for ReadyHook<F> {
    fn ready_time(&mut self, right: Duration) -> Duration {
        (self.0)(right)
    }
}

struct RecordHook<F>(F);

impl<F: FnMut(Duration) -> Duration> SlaveHooks for RecordHook<F> {
    fn record_time(&mut self, right: Duration) -> Duration {
        (self.0)(right)
    }
}

struct WatchdogHook<F>(F);

impl<F: FnMut(Duration) -> Duration> SlaveHooks for WatchdogHook<F> {
    fn watchdog(&mut self, right: Duration) -> Duration {
        (self.0)(right)
    }
}

struct ParameterHook<F>(F);

impl<F: FnMut(&mut SetPrm)> SlaveHooks for ParameterHook<F> {
    fn parameters(&mut self, parameters: &mut SetPrm) -> bool {
        (self.0)(parameters);
        true
    }
}
