//! A program under test: its process, what it says of itself, and its failure.

use crate::VERSION;
use crate::answer::ApplicationAnswer;
use crate::failure::{ProgramFailure, shown};
use crate::hello::{ApplicationDescription, DescribedIoDevice};
use crate::process::{ProgramCommand, ProgramProcess};
use crate::request::{ApplicationBus, ApplicationRequest};
use crate::stand::LedWords;
use device_stack::profinet::IoIdentity;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// How long a program may take to answer, in real time.
pub const PATIENCE: Duration = Duration::from_secs(10);

/// A program that implements the application of a device; it is started once and serves one trial after the other.
#[derive(Debug)]
pub struct ApplicationProgram {
    command: ProgramCommand,
    bus: ApplicationBus,
    patience: Duration,
    process: Option<ProgramProcess>,
    description: Arc<ApplicationDescription>,
    failure: Option<ProgramFailure>,
    /// How many messages were sent.
    asked: u64,
    line: Vec<u8>,
    /// The identity for a PROFINET stack, made once.
    io_identity: Option<IoIdentity>,
    led_words: LedWords,
}

/// A program that several parts of a trial use; clones are the same program.
pub type SharedProgram = Arc<Mutex<ApplicationProgram>>;

/// Locks a program for a message.
pub fn in_program(program: &SharedProgram) -> MutexGuard<'_, ApplicationProgram> {
    program.lock().unwrap_or_else(PoisonError::into_inner)
}

impl ApplicationProgram {
    /// Starts a program and asks what it implements; each answer may take `patience`.
    pub fn start(
        command: ProgramCommand,
        bus: ApplicationBus,
        patience: Duration,
    ) -> Result<ApplicationProgram, ProgramFailure> {
        let (process, description) = started(&command, bus, patience)?;
        Ok(ApplicationProgram {
            command,
            bus,
            patience,
            process: Some(process),
            io_identity: description.profinet.as_ref().map(DescribedIoDevice::identity),
            description: Arc::new(description),
            failure: None,
            asked: 1,
            line: Vec::new(),
            led_words: LedWords::default(),
        })
    }

    /// What the program says of its device.
    pub fn description(&self) -> &Arc<ApplicationDescription> {
        &self.description
    }

    /// The identity for a PROFINET stack, if there is a device on PROFINET.
    pub(crate) fn io_identity(&self) -> Option<&IoIdentity> {
        self.io_identity.as_ref()
    }

    /// The word that an LED shows, for the stand.
    pub(crate) fn led_word(&mut self, word: &str) -> Option<&'static str> {
        self.led_words.word(word)
    }

    /// Why the program has not answered since the last reset, if it has not.
    pub fn failure(&self) -> Option<&ProgramFailure> {
        self.failure.as_ref()
    }

    /// How many messages were sent.
    pub fn asked(&self) -> u64 {
        self.asked
    }

    /// Starts the program again if it has failed.
    pub fn revive(&mut self) -> Result<(), ProgramFailure> {
        if self.failure.is_none() {
            return Ok(());
        }
        self.process = None;
        let (process, description) = started(&self.command, self.bus, self.patience)?;
        if description != *self.description {
            return Err(ProgramFailure::Changed);
        }
        (self.process, self.failure) = (Some(process), None);
        Ok(())
    }

    /// Sends a message and returns the answer. `None` if the program has failed, now or before.
    pub fn ask(&mut self, request: &ApplicationRequest) -> Option<ApplicationAnswer> {
        if self.failure.is_some() {
            return None;
        }
        let process = self.process.as_mut()?;
        self.asked += 1;
        self.line.clear();
        // Messages have no map with other keys than text, so they can be written.
        serde_json::to_writer(&mut self.line, request).ok()?;
        match exchange(process, &self.line, request) {
            Ok(answer) => Some(answer),
            Err(failure) => {
                self.fail(failure);
                None
            }
        }
    }

    /// Notes that an answer to a message cannot be used.
    pub fn refuse(&mut self, request: &ApplicationRequest, why: impl Into<String>) {
        self.fail(ProgramFailure::Content { asked: asked(request), why: why.into() });
    }

    fn fail(&mut self, failure: ProgramFailure) {
        self.process = None;
        self.failure.get_or_insert(failure);
    }
}

/// What a message is called in a failure.
fn asked(request: &ApplicationRequest) -> String {
    let text = serde_json::to_string(request).unwrap_or_default();
    format!("`{}`", shown(&text))
}

fn exchange(
    process: &mut ProgramProcess,
    line: &[u8],
    request: &ApplicationRequest,
) -> Result<ApplicationAnswer, ProgramFailure> {
    let text = process.ask(line, &|| asked(request))?;
    let answer: ApplicationAnswer = serde_json::from_str(&text).map_err(|error| ProgramFailure::Nonsense {
        asked: asked(request),
        why: error.to_string(),
        line: shown(&text),
    })?;
    if let Some(text) = answer.error {
        let text = shown(&text);
        return Err(ProgramFailure::Reported { asked: asked(request), text, stderr: process.stderr() });
    }
    if answer.answer != request.word() {
        return Err(ProgramFailure::Other { asked: asked(request), answered: shown(&answer.answer) });
    }
    Ok(answer)
}

fn started(
    command: &ProgramCommand,
    bus: ApplicationBus,
    patience: Duration,
) -> Result<(ProgramProcess, ApplicationDescription), ProgramFailure> {
    let mut process = ProgramProcess::start(command, patience)?;
    let hello = ApplicationRequest::Hello { version: VERSION, bus };
    let line = serde_json::to_vec(&hello).unwrap_or_default();
    let wrong = |why: &str| ProgramFailure::Content { asked: asked(&hello), why: why.to_owned() };
    let answer = exchange(&mut process, &line, &hello)?;
    let description = *answer.description.ok_or_else(|| wrong("it has no `description`"))?;
    if description.version != VERSION {
        return Err(ProgramFailure::Version { theirs: description.version });
    }
    match bus {
        ApplicationBus::Profinet if description.profinet.is_none() => {
            return Err(wrong("it has no `profinet`, and the suite is one of PROFINET"));
        }
        ApplicationBus::Profibus if description.profibus.is_none() => {
            return Err(wrong("it has no `profibus`, and the suite is one of PROFIBUS"));
        }
        ApplicationBus::Profinet | ApplicationBus::Profibus => {}
    }
    match description.problem() {
        Some(why) => Err(wrong(&why)),
        None => Ok((process, description)),
    }
}
