//! A thread that performs one job after the other, so that the wire never waits for a stand.

use super::hook;
use super::operator;
use crate::control::{StandAnswer, StandCommand};
use link::lines::LineClient;
use results::bench_file::StandSpec;
use results::bench_file::command::CommandLine;
use station::{Duration, StandAction, StandRefusal};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread;

/// Timeout for an answer of the control channel.
pub(super) const CONTROL_TIMEOUT: Duration = Duration::from_secs(10);

/// A job of the stand.
pub(super) enum StandJob {
    /// An action: its ability, the line for the control channel, the values for a hook, the text for an operator.
    Act { name: String, line: String, values: Vec<(&'static str, String)>, words: String },
    /// Reads an LED, after this number of actions.
    Led(String, u64),
    /// Reads a counter, after this number of actions.
    Counter(String, u64),
    /// Reads the abilities of the control channel.
    Abilities,
}

impl StandJob {
    /// The job for `action`, whose ability is `name`.
    pub(super) fn act(action: &StandAction<'_>, name: &str) -> StandJob {
        let line = StandCommand::Act(action.clone()).to_string();
        let one = |value: String| vec![("value", value)];
        let word = |on: bool, yes: &str, no: &str| one(if on { yes } else { no }.to_owned());
        let values = match *action {
            StandAction::Power(on) | StandAction::Link(on) => word(on, "up", "down"),
            StandAction::ShaftSpeed(number) | StandAction::SupplyVoltage(number) | StandAction::Temperature(number) => {
                one(number.to_string())
            }
            StandAction::ShaftRamp { rpm, acceleration } => {
                vec![("value", rpm.to_string()), ("acceleration", acceleration.to_string())]
            }
            StandAction::ShaftCounts(place) => one(place.to_string()),
            StandAction::Turn { steps, rpm } => {
                vec![("value", steps.to_string()), ("unit", "counts".to_owned()), ("rpm", rpm.to_string())]
            }
            StandAction::TurnRevolutions { revolutions, rpm } => {
                vec![("value", revolutions.to_string()), ("unit", "revolutions".to_owned()), ("rpm", rpm.to_string())]
            }
            StandAction::Fault(_, there) => word(there, "present", "absent"),
            StandAction::Button(_, down) => word(down, "pressed", "released"),
            StandAction::Switch(_, position) => one(position.to_string()),
            StandAction::ReplaceDevice => Vec::new(),
            StandAction::RestoreFactoryState => one("as_delivered".to_owned()),
            StandAction::Skip(time) => one(time.as_secs_f64().to_string()),
        };
        StandJob::Act { name: name.to_owned(), line, words: operator::words(action), values }
    }
}

/// The result of a job.
pub(super) enum StandJobResult {
    /// The action is done after this additional time, or failed.
    Done(Result<Duration, StandRefusal>),
    /// The reading of an LED after this number of actions; `None` if it could not be read.
    Led(String, u64, Option<String>),
    /// The reading of a counter after this number of actions.
    Counter(String, u64, Option<String>),
    /// The requested value.
    Word(Result<String, StandRefusal>),
}

/// The handle of the thread: sends jobs and receives their results.
pub(super) struct StandThread {
    spec: StandSpec,
    ends: Option<(Sender<StandJob>, Receiver<StandJobResult>)>,
}

impl StandThread {
    /// A stand thread without jobs; it starts with the first job.
    pub(super) fn new(spec: &StandSpec) -> StandThread {
        StandThread { spec: spec.clone(), ends: None }
    }

    /// Sends a job; the thread starts with the first one.
    pub(super) fn send_job(&mut self, job: StandJob) {
        let spec = &self.spec;
        let (jobs, _) = self.ends.get_or_insert_with(|| {
            let (jobs, to_do) = channel();
            let (tell, results) = channel();
            let worker = StandWorker { spec: spec.clone(), client: None };
            thread::spawn(move || worker.work(&to_do, &tell));
            (jobs, results)
        });
        // The thread ends only when this handle is dropped.
        let _ = jobs.send(job);
    }

    /// The next result, if there is one.
    pub(super) fn try_result(&mut self) -> Option<StandJobResult> {
        self.ends.as_ref()?.1.try_recv().ok()
    }

    /// Waits for the next result.
    pub(super) fn wait_result(&mut self, at_most: Duration) -> Option<StandJobResult> {
        self.ends.as_ref()?.1.recv_timeout(at_most).ok()
    }
}

struct StandWorker {
    spec: StandSpec,
    client: Option<LineClient>,
}

impl StandWorker {
    fn work(mut self, jobs: &Receiver<StandJob>, tell: &Sender<StandJobResult>) {
        for job in jobs {
            let result = match job {
                StandJob::Act { name, line, values, words } => {
                    StandJobResult::Done(self.act(&name, &line, &values, &words))
                }
                StandJob::Led(name, actions) => {
                    let word = self.read_value(&format!("led.{name}"), &StandCommand::Led(&name).to_string());
                    StandJobResult::Led(name, actions, word.ok())
                }
                StandJob::Counter(name, actions) => {
                    let word = self.read_value(&format!("counter.{name}"), &StandCommand::Counter(&name).to_string());
                    StandJobResult::Counter(name, actions, word.ok())
                }
                StandJob::Abilities => StandJobResult::Word(self.request_word(&StandCommand::Abilities.to_string())),
            };
            if tell.send(result).is_err() {
                return;
            }
        }
    }

    fn hook(&self, name: &str, values: &[(&str, String)]) -> Option<Result<String, StandRefusal>> {
        let (_, line) = self.spec.hooks.iter().find(|(hook, _)| hook == name)?;
        let words = CommandLine::parse(line).map(|line| line.filled(values));
        Some(
            words
                .and_then(|words| hook::run(&words, &self.spec.folder, hook::HOOK_TIMEOUT))
                .map_err(StandRefusal::Broken),
        )
    }

    fn act(
        &mut self,
        name: &str,
        line: &str,
        values: &[(&str, String)],
        words: &str,
    ) -> Result<Duration, StandRefusal> {
        if let Some(done) = self.hook(name, values) {
            return done.map(|_| Duration::ZERO);
        }
        if self.spec.ask.iter().any(|ability| ability == name) {
            return operator::ask(words).map(|()| Duration::ZERO);
        }
        match self.control(line)? {
            StandAnswer::Done(more) => Ok(more),
            StandAnswer::Word(word) => Err(StandRefusal::Broken(format!("the stand answered `{word}` to `{line}`"))),
            StandAnswer::Cannot(why) => Err(StandRefusal::CannotDo(why)),
            StandAnswer::Broken(why) => Err(StandRefusal::Broken(why)),
        }
    }

    fn read_value(&mut self, name: &str, line: &str) -> Result<String, StandRefusal> {
        match self.hook(name, &[]) {
            Some(word) => word,
            None => self.request_word(line),
        }
    }

    fn request_word(&mut self, line: &str) -> Result<String, StandRefusal> {
        match self.control(line)? {
            StandAnswer::Word(word) => Ok(word),
            StandAnswer::Done(_) => Err(StandRefusal::Broken(format!("the stand returned no value for `{line}`"))),
            StandAnswer::Cannot(why) => Err(StandRefusal::CannotDo(why)),
            StandAnswer::Broken(why) => Err(StandRefusal::Broken(why)),
        }
    }

    fn control(&mut self, line: &str) -> Result<StandAnswer, StandRefusal> {
        let Some(path) = &self.spec.control else {
            return Err(StandRefusal::CannotDo("the stand has no control channel".to_owned()));
        };
        let client = match self.client.take() {
            Some(client) => Ok(client),
            None => LineClient::connect(path),
        };
        let broken = |error: link::LinkError| StandRefusal::Broken(error.to_string());
        let mut client = client.map_err(broken)?;
        let answer = client.request(line, CONTROL_TIMEOUT).map_err(broken)?;
        self.client = Some(client);
        StandAnswer::parse(&answer).map_err(StandRefusal::Broken)
    }
}
