//! Connections on PROFINET: requests of the controller, start-up, cyclic frames, release.

use super::startup::{self, DeviceLocation};
use super::unexpected;
use crate::stations::HarnessStations;
use crate::trial::step_error::{BoxedStepError, StepResult, no_connection};
use crate::trial::{RunningTrial, cycle_limit};
use controllers::profinet_io::{ArReleaseOutcome, ConnectOutcome, ControllerOutcome, ControllerRequest, DeviceAddress};
use judge::answer::ReceivedReply;
use suite::model::{AnswerMatcher, AnswerPart, ConnectionStart};
use wire::ethernet::{EtherType, FrameHeader};
use wire::profinet::status::ErrorCode;

impl<'a> RunningTrial<'a> {
    /// Sends a request and waits for its outcome.
    pub(super) fn ask(
        &mut self,
        second: bool,
        request: ControllerRequest,
    ) -> Result<ControllerOutcome, BoxedStepError> {
        let which = usize::from(second);
        let now = self.world.now();
        let begin = |ours: &mut HarnessStations| {
            let controller = ours.controller_mut(which).ok_or("This bench has no second controller.")?;
            controller
                .request(now, request)
                .map_err(|why| format!("The harness's controller cannot send the request: {why}."))
        };
        self.request(begin, |ours| ours.controller_mut(which)?.take_outcome())
    }

    /// Sends a request that needs a connection; without one it is not sent, and there is no answer.
    pub(super) fn ask_in_connection(
        &mut self,
        second: bool,
        request: ControllerRequest,
    ) -> Result<ControllerOutcome, BoxedStepError> {
        let is_inside = !matches!(request, ControllerRequest::ReadImplicit { .. });
        if is_inside && !self.world.stations.is_connected(usize::from(second)) {
            return Err(no_connection());
        }
        self.ask(second, request)
    }

    /// Where the controller finds the device now.
    fn device_location(&self) -> DeviceLocation {
        let address = if self.renamed {
            DeviceAddress::Mac(self.mac)
        } else {
            DeviceAddress::Name(self.environment.name.clone())
        };
        let persona = self.environment.persona.clone();
        DeviceLocation {
            address,
            ip: self.environment.ip,
            keeps_address: self.keeps_address,
            search: self.patience(),
            persona,
        }
    }

    /// Opens an AR with the device; waits for the first data of the trial's own connection.
    pub(super) fn open(
        &mut self,
        start: &'a ConnectionStart,
        answer: Option<&'a AnswerMatcher>,
        second: bool,
    ) -> StepResult {
        let device = &self.world.manual.device;
        let whereabouts = self.device_location();
        let (mut connection, records) = startup::connection(device, self.variant_number(), start, &whereabouts);
        // While another connection of ours stands, a refusal is the answer to the question; asked again, it would be another one.
        connection.repeats = !self.world.stations.is_connected(usize::from(!second));
        if !second {
            self.use_module(start.module);
        }
        let has_wrong_fields = !connection.replaced_fields.is_empty();
        let before = self.world.trace.len();
        let outcome = self.ask(second, ControllerRequest::Connect(Box::new(connection)))?;
        if has_wrong_fields {
            self.world.mark_broken(before, is_call);
        }
        let ControllerOutcome::StartUp(outcome) = outcome else { return Err(unexpected(&outcome)) };
        self.world.scene.notebook_mut().answers =
            startup::replies(&self.world.manual.device, start, &outcome, &records);
        let mut replies = outcome.records.iter().map(|outcome| startup::record(outcome, true));
        let refused = replies.find(|reply| *reply != ReceivedReply::Accepted);
        let refused = refused.map(|reply| format!("A start-up record was not accepted: {reply}."));
        let stands = match (outcome.standing, outcome.failed) {
            (true, _) => Ok(refused),
            (false, failed) => Err(failed.map(|failed| failed.to_string())),
        };
        self.started(stands, answer, second)
    }

    /// Whether there is a connection after this start-up; `None` if the device neither accepts nor refuses it.
    pub(super) fn connects_with(&mut self, start: &ConnectionStart) -> Result<Option<bool>, BoxedStepError> {
        self.disconnect(false)?;
        let whereabouts = self.device_location();
        let (connection, _) =
            startup::connection(&self.world.manual.device, self.variant_number(), start, &whereabouts);
        self.use_module(start.module);
        match self.ask(false, ControllerRequest::Connect(Box::new(connection)))? {
            ControllerOutcome::StartUp(outcome) => Ok(match &outcome.connect {
                Some(ConnectOutcome::Accepted) if outcome.standing => Some(outcome.module_diff.is_none()),
                Some(ConnectOutcome::Accepted) if outcome.module_diff.is_some() => Some(false),
                Some(ConnectOutcome::Refused(_)) => Some(false),
                _ => None,
            }),
            outcome => Err(unexpected(&outcome)),
        }
    }

    /// Releases the AR.
    pub(super) fn release_ar(&mut self, second: bool) -> StepResult {
        match self.ask(second, ControllerRequest::Release)? {
            ControllerOutcome::Ended(ArReleaseOutcome::Released(outcome)) => {
                let reply = startup::control(&outcome, ErrorCode::RELEASE_RESPONSE);
                self.world.scene.notebook_mut().answers = vec![(AnswerPart::Whole, reply)];
                Ok(())
            }
            ControllerOutcome::Ended(ArReleaseOutcome::Aborted | ArReleaseOutcome::NoAr) => Ok(()),
            outcome => Err(unexpected(&outcome)),
        }
    }

    /// Waits until this many cyclic frames have been sent, the last one observed on the wire.
    pub(super) fn cyclic_frames(&mut self, count: u64) -> StepResult {
        let Some(cycle) = self.world.scene.follower.image.cycle() else {
            return Err(no_connection());
        };
        let target = self.world.stations.cycles_begun() + count;
        let until = self.world.now() + cycle_limit(cycle, count);
        let mut left = None;
        let done = self.world.run(until, |world| {
            if world.stations.cycles_done() >= target {
                // On a real wire sent frames are observed when they leave, on the virtual one when they arrive.
                if !world.segment.is_virtual() {
                    return true;
                }
                let observed = *left.get_or_insert(world.output_frames);
                return world.output_frames > observed || world.lost.is_some();
            }
            world.lost.is_some() || !world.stations.is_connected(0)
        });
        if done && self.world.lost.is_none() { Ok(()) } else { Err(no_connection()) }
    }
}

/// Whether a frame may contain a call: those of IPv4 may.
fn is_call(frame: &[u8]) -> bool {
    FrameHeader::parse(frame).is_ok_and(|(header, _)| header.ether_type == EtherType::IPV4)
}
