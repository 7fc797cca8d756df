//! DCP: identification, name, addresses and resets.

mod set;
mod values;

use super::fast_start_up::HelloSettings;
use super::hooks::StackCheck;
use super::stack::{Stack, StackEnv};
use crate::earlier;
use crate::profinet::StationData;
use alloc::vec::Vec;
use station::{Duration, Time};
use wire::ethernet::{FrameHeader, Mac};
use wire::profinet::dcp::{
    BlockError, BlockInfo, Dcp, DcpBlock, DcpBody, DcpValue, Element, ServiceId, ServiceType, response_delay_steps,
};
use wire::profinet::rt::FrameId;

/// The state of DCP: delayed responses, a transaction, a flashing LED, a Hello that is due.
#[derive(Debug, Default)]
pub(super) struct DcpState {
    waiting: Vec<DelayedResponse>,
    transaction: Option<DcpTransaction>,
    signals_until: Option<Time>,
    hello: Option<HelloSchedule>,
}

/// A Hello that is due.
#[derive(Debug)]
struct HelloSchedule {
    due: Time,
    interval: Duration,
    repetitions: u32,
}

#[derive(Debug)]
struct DelayedResponse {
    due: Time,
    to: Mac,
    answer: Dcp,
}

/// Changes between Start and Stop, which take effect together.
#[derive(Debug)]
struct DcpTransaction {
    owner: Mac,
    /// When it ends without a Stop.
    expires: Option<Time>,
    station: StationData,
    stored: StationData,
}

impl DcpState {
    /// One step of the delay of an Identify response (ResponseDelayFactor).
    const DELAY_STEP: Duration = Duration::from_millis(10);
    /// How many delayed responses are kept.
    const WAITING: usize = 32;
    /// How long the LED flashes for Signal: three times, once a second.
    const SIGNAL: Duration = Duration::from_secs(3);
    /// How long a transaction waits for its Stop.
    const TRANSACTION: Duration = Duration::from_secs(3);

    /// The device is linked from `now` on, and says Hello if `settings` has it do so.
    pub(super) fn announce(&mut self, now: Time, settings: Option<HelloSettings>) {
        self.hello = settings.map(|HelloSettings { delay, interval, repetitions }| HelloSchedule {
            due: now + delay,
            interval,
            repetitions,
        });
    }

    /// Whether the LED flashes.
    pub(super) fn is_signalling(&self, now: Time) -> bool {
        self.signals_until.is_some_and(|until| now < until)
    }

    /// When the next timer expires.
    pub(super) fn due(&self) -> Option<Time> {
        let waiting = self.waiting.iter().map(|waiting| waiting.due).min();
        let transaction = self.transaction.as_ref().and_then(|transaction| transaction.expires);
        earlier(waiting, earlier(transaction, self.hello.as_ref().map(|hello| hello.due)))
    }
}

impl Stack {
    /// Processes a DCP frame.
    pub(super) fn receive_dcp(
        &mut self,
        env: &mut StackEnv<'_>,
        header: &FrameHeader,
        payload: &[u8],
        is_for_us: bool,
    ) {
        let Ok(request) = Dcp::parse(payload) else { return };
        if request.service_type != ServiceType::REQUEST {
            return;
        }
        match (request.frame_id, request.service_id) {
            (FrameId::DCP_IDENTIFY_REQUEST, ServiceId::IDENTIFY) => self.identify(env, header.source, &request),
            (FrameId::DCP_GET_SET, ServiceId::GET) if is_for_us => {
                let blocks = self.get(&request);
                request.response(blocks).write_frame_to(header.source, self.retained.mac, env);
            }
            (FrameId::DCP_GET_SET, ServiceId::SET) if is_for_us => self.set(env, header.source, &request),
            (FrameId::DCP_GET_SET, _) if is_for_us => {
                request.not_supported().write_frame_to(header.source, self.retained.mac, env);
            }
            _ => {}
        }
    }

    fn identify(&mut self, env: &mut StackEnv<'_>, source: Mac, request: &Dcp) {
        let blocks = request.blocks();
        let matches = |block: &DcpBlock| match &block.value {
            DcpValue::AllSelector => self.hooks.check(StackCheck::IdentifyAll, true),
            DcpValue::AliasName(alias) => self.alias().as_ref() == Some(alias),
            DcpValue::NameOfStation(name) => self.is_own_name(name),
            value => self.value(value.element()).as_ref() == Some(value),
        };
        if blocks.is_empty() || !blocks.iter().all(matches) || self.dcp.waiting.len() >= DcpState::WAITING {
            return;
        }
        let steps = response_delay_steps(self.retained.mac, request.response_delay_factor);
        let answer = request.response(self.identify_blocks());
        self.dcp.waiting.push(DelayedResponse {
            due: env.now + DcpState::DELAY_STEP * u32::from(steps),
            to: source,
            answer,
        });
        self.wake_dcp(env);
    }

    /// Whether this is the name in use.
    fn is_own_name(&self, name: &[u8]) -> bool {
        let station_name = &self.station.name;
        self.hooks.check(StackCheck::IdentifyName(station_name, name), station_name == name)
    }

    fn get(&self, request: &Dcp) -> Vec<DcpBlock> {
        let DcpBody::Elements(elements) = &request.body else { return Vec::new() };
        let answer = |element: &Element| match self.value(*element) {
            Some(value) => DcpBlock::report(self.info(*element), value),
            None => DcpBlock::outcome(*element, values::unsupported_error(*element)),
        };
        elements.iter().map(answer).collect()
    }

    /// Sends what is due and ends what has expired.
    pub(super) fn wake_dcp(&mut self, env: &mut StackEnv<'_>) {
        while let Some(at) = self.dcp.waiting.iter().position(|waiting| waiting.due <= env.now) {
            let DelayedResponse { to, answer, .. } = self.dcp.waiting.remove(at);
            answer.write_frame_to(to, self.retained.mac, env);
        }
        let transaction = self.dcp.transaction.take();
        self.dcp.transaction = transaction.filter(|transaction| transaction.expires.is_none_or(|at| at > env.now));
        if let Some(HelloSchedule { due, interval, repetitions }) = self.dcp.hello.take_if(|hello| hello.due <= env.now)
        {
            let is_last = self.hooks.check(StackCheck::LastHello, repetitions == 0);
            let repetitions = repetitions.saturating_sub(1);
            self.dcp.hello = (!is_last).then(|| HelloSchedule { due: due + interval, interval, repetitions });
            let blocks = self.hello_blocks();
            Dcp::hello(env.now.as_nanos() as u32, blocks).write_frame_to(
                Mac::DCP_HELLO_MULTICAST,
                self.retained.mac,
                env,
            );
        }
    }
}

trait WriteDcpFrame {
    fn write_frame_to(&self, destination: Mac, source: Mac, env: &mut StackEnv<'_>);
}

impl WriteDcpFrame for Dcp {
    fn write_frame_to(&self, destination: Mac, source: Mac, env: &mut StackEnv<'_>) {
        env.out.push_with(|frame| self.write_frame(destination, source, frame));
    }
}

/// The answer to one element of a Set.
fn outcome(element: Element, result: Result<(), BlockError>) -> DcpBlock {
    DcpBlock::outcome(element, result.err().unwrap_or(BlockError::OK))
}

/// A block whose BlockInfo is 0.
fn block_without_info(value: DcpValue) -> DcpBlock {
    DcpBlock::report(BlockInfo::NONE, value)
}
