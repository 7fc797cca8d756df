//! Requests that are sent again with the same frame count bit, as after a lost answer.
//!
//! A slave answers a repetition with the stored answer and does not carry out the request again (IEC 61158-4-3, frame count bit). It
//! stores the answer only until the next frame to it, so the repetition follows the answer within the same hold of the token. This
//! module must not know services.

use super::access::{MediumAccess, PendingTransfer, Purpose, TokenHold};
use super::master::ProfibusMaster;
use super::message::DpMessage;
use super::outcome::{DataLinkAnswer, MasterOutcome, RepeatedAnswers};
use alloc::boxed::Box;
use station::Time;
use wire::profibus::fdl::FrameCount;

/// The repetitions of the current request, and what they brought.
#[derive(Debug)]
pub(super) struct RequestRepetition {
    /// How often each frame is sent again.
    times: u8,
    /// Whether a Slave_Diag went ahead of the request.
    is_introduced: bool,
    answered: u32,
    difference: Option<(DataLinkAnswer, DataLinkAnswer)>,
}

/// The repetitions of one frame.
#[derive(Debug)]
pub(super) struct FrameRepetition {
    /// The answer to the frame when it was new.
    first: DataLinkAnswer,
    /// How often the frame is still to be answered.
    left: u8,
}

impl RequestRepetition {
    pub fn new(times: u8) -> RequestRepetition {
        RequestRepetition { times, is_introduced: false, answered: 0, difference: None }
    }

    /// The outcome of the whole request, from that of its first answers.
    pub fn outcome(self, outcome: MasterOutcome) -> MasterOutcome {
        let RequestRepetition { answered, difference, .. } = self;
        MasterOutcome::Repeated(Box::new(RepeatedAnswers { outcome, answered, difference }))
    }

    /// Compares the answer to a repetition with the first answer.
    fn compare(&mut self, first: &DataLinkAnswer, again: DataLinkAnswer) {
        if again == *first {
            self.answered += 1;
        } else if self.difference.is_none() {
            self.difference = Some((first.clone(), again));
        }
    }
}

impl ProfibusMaster {
    /// Whether a Slave_Diag has to go ahead of `message`: the first request to a station is carried out each time it is received.
    pub(super) fn needs_introduction(&mut self, message: &DpMessage) -> bool {
        let is_first = message.is_counted() && self.counts.next(message.to) == FrameCount::First;
        let repetition = self.repetition.as_mut().filter(|_| is_first);
        repetition.is_some_and(|repetition| !core::mem::replace(&mut repetition.is_introduced, true))
    }

    /// Processes the answer to a frame that may have to be sent again. Returns the transfer and its first answer when it has ended, and
    /// `None` if the frame is sent again: the transfer then waits as after a lost answer.
    pub(super) fn repeated(
        &mut self,
        now: Time,
        mut transfer: PendingTransfer,
        hold: TokenHold,
        answer: DataLinkAnswer,
    ) -> Option<(PendingTransfer, DataLinkAnswer)> {
        let is_repeatable =
            transfer.purpose == Purpose::Job && matches!(transfer.count, FrameCount::Zero | FrameCount::One);
        let Some(repetition) = self.repetition.as_mut().filter(|_| is_repeatable) else {
            return Some((transfer, answer));
        };
        // Another master has taken the token: its frames say nothing about the slave.
        let has_token = !matches!(self.access, MediumAccess::Waiting);
        let (first, left) = match transfer.repetition.take() {
            None if answer.is_frame() => (answer, repetition.times),
            None => return Some((transfer, answer)),
            Some(FrameRepetition { first, left }) => {
                if has_token {
                    repetition.compare(&first, answer);
                }
                (first, left.saturating_sub(1))
            }
        };
        if left == 0 || !has_token || repetition.difference.is_some() {
            return Some((transfer, first));
        }
        transfer.repetition = Some(FrameRepetition { first, left });
        transfer.retries = self.settings.retries.saturating_add(1);
        transfer.unfit = None;
        transfer.until = self.later(now, self.settings.idle_after_answer());
        self.access = MediumAccess::AwaitingAnswer(transfer, hold);
        None
    }
}
