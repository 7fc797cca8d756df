//! Trials on PROFIBUS: what the verbs mean for a slave and our master.
//!
//! Who is there and still lives ([`life`]), what a live one is found and left like ([`probe`]), start-ups ([`start`]), what is asked
//! for ([`access`]) and the services of `send` ([`services`]). Windows, rules and the stand are those of every bus; this room must not know them.

mod access;
mod life;
mod probe;
mod services;
mod start;

pub use life::SlaveAt;
pub use start::{ISOCHRONOUS_GROUP, isochronous_times};

use super::trial::{Run, Trouble};
use controllers::profibus_dp::{AcyclicError, Answer, Outcome, Request};
use expression::{Program, State};
use judge::answer::{Refusal, Reply};
use results::outcome::Blame;
use results::verdict::Verdict;

impl Run<'_> {
    /// Asks one of our masters for something and waits for its outcome.
    pub fn ask_master(&mut self, second: bool, request: Request) -> Result<Outcome, Trouble> {
        let which = usize::from(second);
        let now = self.world.now();
        let begin = |ours: &mut super::ours::Ours| {
            let master = ours.master_mut(which).ok_or("There is no second master on this bench.")?;
            master.request(now, request).map_err(|why| format!("Our master cannot: {why}."))
        };
        self.request(begin, |ours| ours.master_mut(which)?.take_outcome())
    }

    /// Asks for something that the data link answers.
    fn ask_link(&mut self, second: bool, request: Request) -> Result<Answer, Trouble> {
        match self.ask_master(second, request)? {
            Outcome::Answer(answer) => Ok(answer),
            outcome => Err(unexpected(&outcome)),
        }
    }

    /// The station address that a step speaks of: its own, else that of the device.
    fn station_of(&mut self, to: Option<&Program>) -> Result<u8, Trouble> {
        let address = match to {
            None => Some(self.slave.address),
            Some(program) => {
                let value = program.eval(&self.world.view(), &State::default()).as_whole();
                value.and_then(|number| u8::try_from(number).ok()).filter(|number| *number <= 127)
            }
        };
        let unknown = || Trouble::other(Blame::Suite, Verdict::Error, "The station address is not known.");
        let address = address.ok_or_else(unknown)?;
        self.slave.meet(address);
        Ok(address)
    }
}

/// What the data link of a slave answered.
fn reply(answer: &Answer) -> Reply {
    match answer {
        answer if answer.is_positive() => Reply::Accepted,
        Answer::Frame { function, .. } => Reply::Refused(Refusal::Fdl(function.0)),
        Answer::Unfit(why) => Reply::Wrong(why.clone()),
        Answer::Short | Answer::None => Reply::Silent("nobody answered, however often it was asked".into()),
    }
}

/// Why an acyclic service came to nothing.
fn failed(error: &AcyclicError) -> Reply {
    match error {
        AcyclicError::Link(answer) => match reply(answer) {
            Reply::Accepted => Reply::Wrong(error.to_string()),
            reply => reply,
        },
        AcyclicError::Timeout(_) => Reply::Silent(error.to_string()),
        AcyclicError::Unfit(why) => Reply::Wrong(why.clone()),
    }
}

/// The trouble with an outcome that does not belong to the request.
fn unexpected(outcome: &Outcome) -> Trouble {
    match outcome {
        // It has no token, or somebody else keeps the bus busy.
        Outcome::Impossible(why) => {
            let what = format!("The master cannot do that: {why}.");
            Trouble::other(Blame::Environment, Verdict::Inconclusive, what)
        }
        outcome => {
            let what = format!("The master answered something else: {outcome:?}.");
            Trouble::other(Blame::Harness, Verdict::Error, what)
        }
    }
}
