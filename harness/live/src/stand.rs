//! The stand of a live bench: control channel, hooks, operator.
//!
//! Nothing here delays the wire: slow actions run in a thread, [`Stand::outcome`] reports their end, and LEDs are read in
//! parallel. This module must not know suites, nor how anything is judged.

mod hook;
mod operator;
pub mod set_back;
mod thread;

use self::thread::{StandJob, StandJobResult, StandThread};
use super::control::ability;
use results::bench_file::StandSpec;
use station::{Duration, Stand, StandAction, StandRefusal, Time};
use std::collections::BTreeMap;
use std::time::Instant;

/// Maximum age of an LED reading before it is read again.
const MAX_LED_AGE: Duration = Duration::from_millis(20);
/// Maximum age of an LED reading before it counts as unknown.
const LED_TIMEOUT: Duration = Duration::from_secs(1);
/// Maximum number of different LED words; a stand that sends more is faulty.
const MOST_WORDS: usize = 256;
/// Maximum length of a word.
const LONGEST_WORD: usize = 64;

/// The stand that a bench file describes.
pub struct LiveStand {
    spec: StandSpec,
    /// Performs actions in sequence.
    doing: StandThread,
    /// Reads LEDs and counters, also during an action.
    looking: StandThread,
    /// Whether an action is running.
    busy: bool,
    /// The result of the last action.
    outcome: Option<Result<Duration, StandRefusal>>,
    leds: BTreeMap<String, StandReading>,
    counters: BTreeMap<String, StandReading>,
    /// Number of actions so far: readings requested before the last one are outdated.
    actions: u64,
    words: Vec<&'static str>,
    /// What drawn sequences may do, while they run.
    limits: Option<StandLimits>,
    /// What these limits did not permit.
    refused: Option<String>,
}

/// What drawn sequences may do at a stand.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StandLimits {
    /// How often they may still switch off the supply.
    pub power_cycles: u32,
    /// Whether they may press buttons, which may preset the position.
    pub may_press: bool,
}

/// The last reading of an LED or a counter, with the time of the host's clock, since that of the wire restarts with each trial.
#[derive(Default)]
struct StandReading {
    /// Whether a reading was requested.
    pending: bool,
    /// Time of the last reading.
    at: Option<Instant>,
    word: Option<String>,
}

impl LiveStand {
    /// The stand that `spec` describes; nothing is done or read yet.
    pub fn new(spec: &StandSpec) -> LiveStand {
        LiveStand {
            doing: StandThread::new(spec),
            looking: StandThread::new(spec),
            spec: spec.clone(),
            busy: false,
            outcome: None,
            leds: BTreeMap::new(),
            counters: BTreeMap::new(),
            actions: 0,
            words: Vec::new(),
            limits: None,
            refused: None,
        }
    }

    /// Reads the names that the other end of the control channel serves, for [`StandSpec::offers`]. `None` without a control
    /// channel; fails with a sentence if there is no valid answer.
    pub fn offers(&mut self) -> Result<Option<Vec<String>>, String> {
        if self.spec.control.is_none() {
            return Ok(None);
        }
        self.doing.send_job(StandJob::Abilities);
        match self.doing.wait_result(thread::CONTROL_TIMEOUT * 2) {
            Some(StandJobResult::Word(Ok(names))) => Ok(Some(names.split_whitespace().map(str::to_owned).collect())),
            Some(StandJobResult::Word(Err(refusal))) => Err(sentence(&refusal).to_owned()),
            _ => Err("the stand does not report its abilities".to_owned()),
        }
    }

    /// Limits what is done from now on; `None` takes the limits away.
    pub fn limit(&mut self, limits: Option<StandLimits>) {
        self.limits = limits;
    }

    /// The limits with what is left of them.
    pub fn limits(&self) -> Option<StandLimits> {
        self.limits
    }

    /// What the limits have not permitted.
    pub fn refused_by_limits(&self) -> Option<&str> {
        self.refused.as_deref()
    }

    /// Forgets what was refused.
    pub fn forget_refused(&mut self) {
        self.refused = None;
    }

    /// Counts an action; fails if the limits do not permit it.
    fn count(&mut self, action: &StandAction<'_>) -> Result<(), StandRefusal> {
        let Some(limits) = &mut self.limits else { return Ok(()) };
        let why = match action {
            StandAction::Power(false) if limits.power_cycles == 0 => "no power cycle of this run is left",
            StandAction::Power(false) => {
                limits.power_cycles -= 1;
                return Ok(());
            }
            StandAction::Button(..) if !limits.may_press => {
                "a button may preset the position: that needs the consent position_reference and `shaft: [uncoupled]`"
            }
            StandAction::ReplaceDevice | StandAction::RestoreFactoryState => "no sequence puts another device there",
            _ => return Ok(()),
        };
        self.refused.get_or_insert_with(|| why.to_owned());
        Err(StandRefusal::CannotDo(why.to_owned()))
    }

    /// Processes the results of the threads.
    fn catch_up(&mut self) {
        while let Some(finished) = self.doing.try_result() {
            if let StandJobResult::Done(result) = finished {
                self.busy = false;
                self.outcome = Some(result);
            }
        }
        while let Some(reading) = self.looking.try_result() {
            let (of, name, asked_after, word) = match reading {
                StandJobResult::Led(name, actions, word) => (&mut self.leds, name, actions, word),
                StandJobResult::Counter(name, actions, word) => (&mut self.counters, name, actions, word),
                _ => continue,
            };
            if asked_after == self.actions {
                of.insert(name, StandReading { pending: false, at: Some(Instant::now()), word });
            }
        }
    }

    fn interned(&mut self, word: &str) -> Option<&'static str> {
        if let Some(known) = self.words.iter().find(|known| **known == word) {
            return Some(known);
        }
        if word.len() > LONGEST_WORD || self.words.len() >= MOST_WORDS {
            return None;
        }
        let word: &'static str = Box::leak(word.to_owned().into_boxed_str());
        self.words.push(word);
        Some(word)
    }
}

impl Stand for LiveStand {
    /// Begins `action` and returns at once; [`Stand::outcome`] reports its end.
    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Result<Time, StandRefusal> {
        self.catch_up();
        let name = ability(action);
        if !self.spec.serves(&name) {
            // A shaft that no stand turns is already stopped.
            return match action {
                StandAction::ShaftSpeed(0.0) => Ok(now),
                _ => Err(StandRefusal::CannotDo(format!("it has no means for {name}"))),
            };
        }
        if self.busy {
            return Err(StandRefusal::Broken(format!("the last action is still running, so {name} has to wait")));
        }
        self.count(action)?;
        self.leds.clear();
        self.counters.clear();
        self.actions += 1;
        self.outcome = None;
        self.busy = true;
        self.doing.send_job(StandJob::act(action, &name));
        Ok(now)
    }

    fn outcome(&mut self, now: Time) -> Option<Result<Time, StandRefusal>> {
        self.catch_up();
        if self.busy {
            return None;
        }
        let outcome = self.outcome.take().unwrap_or(Ok(Duration::ZERO));
        Some(outcome.map(|more| now + more))
    }

    /// The reading of the LED, requested at most every 20 ms; `None` before the first one after the last action.
    fn led(&mut self, _: Time, name: &str) -> Option<&'static str> {
        self.catch_up();
        if !self.spec.serves(&format!("led.{name}")) {
            return None;
        }
        let seen = self.leds.entry(name.to_owned()).or_default();
        let age = seen.at.map(|at| at.elapsed());
        if !seen.pending && age.is_none_or(|age| age >= MAX_LED_AGE) {
            seen.pending = true;
            self.looking.send_job(StandJob::Led(name.to_owned(), self.actions));
        }
        let word = seen.word.clone().filter(|_| age.is_some_and(|age| age < LED_TIMEOUT))?;
        self.interned(&word)
    }

    /// The current value of the counter; `None` while the answer is pending, so call again: each answer is returned once.
    fn counter(&mut self, _: Time, name: &str) -> Option<u64> {
        self.catch_up();
        if !self.spec.serves(&format!("counter.{name}")) {
            return None;
        }
        let seen = self.counters.entry(name.to_owned()).or_default();
        let answer = seen.at.take().filter(|at| at.elapsed() < LED_TIMEOUT);
        if let Some(word) = seen.word.take().filter(|_| answer.is_some()) {
            return word.parse().ok();
        }
        if !seen.pending {
            seen.pending = true;
            self.looking.send_job(StandJob::Counter(name.to_owned(), self.actions));
        }
        None
    }
}

fn sentence(refusal: &StandRefusal) -> &str {
    match refusal {
        StandRefusal::CannotDo(why) | StandRefusal::Broken(why) => why,
    }
}
