//! What the applications of both buses do alike with a program: what every answer may contain, records, the stand, deadlines.

use crate::answer::ApplicationAnswer;
use crate::hex::HexText;
use crate::program::{SharedProgram, in_program};
use crate::request::ApplicationRequest;
use crate::stand;
use station::{StandAction, Time};

/// A program in a trial, and what its last answer said.
#[derive(Debug)]
pub(crate) struct ProgramDialogue {
    pub program: SharedProgram,
    pub deadline: Option<Time>,
    pub is_alive: bool,
    /// Until when the inputs are constant as long as the outputs stay the same.
    pub constant_until: Time,
}

impl ProgramDialogue {
    pub fn new(program: SharedProgram) -> ProgramDialogue {
        ProgramDialogue { program, deadline: None, is_alive: true, constant_until: Time::ZERO }
    }

    /// Sends a message and takes what every answer may contain.
    pub fn ask(&mut self, request: &ApplicationRequest) -> Option<ApplicationAnswer> {
        let answer = in_program(&self.program).ask(request);
        self.constant_until = Time::ZERO;
        let Some(answer) = answer else {
            self.deadline = None;
            return None;
        };
        self.deadline = answer.deadline.map(Time::from_nanos);
        self.is_alive = answer.alive;
        Some(answer)
    }

    /// Notes that an answer to a message cannot be used.
    pub fn refuse(&self, request: &ApplicationRequest, why: String) {
        in_program(&self.program).refuse(request, why);
    }

    /// Takes the data of a record out of the answer to its read.
    pub fn take_record(&self, request: &ApplicationRequest, answer: Option<ApplicationAnswer>, out: &mut Vec<u8>) {
        match answer.and_then(|answer| answer.data) {
            Some(HexText(data)) => out.extend_from_slice(&data),
            None => self.refuse(request, "it has neither `data` nor `refused`".to_owned()),
        }
    }
}

/// An application in a program, on either bus.
pub(crate) trait RemoteApplication {
    fn dialogue(&mut self) -> &mut ProgramDialogue;

    /// Sends a message, and takes what the bus needs of the answer.
    fn ask(&mut self, request: &ApplicationRequest) -> Option<ApplicationAnswer>;

    /// Sends the outputs that arrived before and were not sent yet.
    fn send_outputs(&mut self, now: Time);

    /// Sends a message other than cyclic data, after the outputs that arrived before it.
    fn ask_at(&mut self, now: Time, request: &ApplicationRequest) -> Option<ApplicationAnswer> {
        self.send_outputs(now);
        self.ask(request)
    }

    fn act_on_device(&mut self, now: Time, action: &StandAction<'_>) -> Option<Time> {
        let request = stand::act(now, action)?;
        self.ask_at(now, &request)?.done.map(|done| Time::from_nanos(done).max(now))
    }

    /// What an LED shows; `stack` is what holds of the stack, as words.
    fn shown_by_led(&mut self, now: Time, name: &str, stack: Vec<String>) -> Option<&'static str> {
        let request = ApplicationRequest::Led { now: now.as_nanos(), name: name.to_owned(), stack };
        let constant_until = self.dialogue().constant_until;
        let shows = self.ask_at(now, &request)?.shows?;
        // To read an LED changes nothing.
        self.dialogue().constant_until = constant_until;
        in_program(&self.dialogue().program).led_word(&shows)
    }

    fn counted(&mut self, now: Time, name: &str) -> Option<u64> {
        self.ask_at(now, &ApplicationRequest::Counter { now: now.as_nanos(), name: name.to_owned() })?.value
    }

    /// Tells the program that the time of its deadline has come.
    fn advance_program(&mut self, now: Time) {
        if self.dialogue().deadline.is_none_or(|due| due > now) {
            return;
        }
        let request = ApplicationRequest::Advance { now: now.as_nanos() };
        self.ask_at(now, &request);
        let dialogue = self.dialogue();
        if let Some(due) = dialogue.deadline.filter(|due| *due <= now) {
            dialogue.refuse(&request, format!("`deadline` is {}, which is not after `now`", due.as_nanos()));
            dialogue.deadline = None;
        }
    }
}

/// The words of what holds.
pub(crate) fn words_of(holding: &[(bool, &str)]) -> Vec<String> {
    holding.iter().filter(|(holds, _)| *holds).map(|(_, word)| (*word).to_owned()).collect()
}
