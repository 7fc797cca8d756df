//! The stand of a live bench: control channel, hooks, operator.
//!
//! Nothing here keeps the wire waiting: what takes time is done by a thread of its own, [`Stand::outcome`] says when it is
//! done, and what LEDs show is asked for beside it. This room must not know suites, nor how anything is judged.

mod hands;
mod hook;
mod operator;

use self::hands::{Hands, Job, Told};
use super::control::ability;
use results::bench_file::StandSpec;
use station::{Duration, Refusal, Stand, StandAction, Time};
use std::collections::BTreeMap;
use std::time::Instant;

/// How old what an LED shows may be before it is asked for again.
const FRESH: Duration = Duration::from_millis(20);
/// How old it may be before nobody knows what it shows.
const STALE: Duration = Duration::from_secs(1);
/// The most different words that LEDs are believed to show; a stand that tells more than this tells nonsense.
const MOST_WORDS: usize = 256;
/// The longest word.
const LONGEST_WORD: usize = 64;

/// The stand that a bench file describes.
pub struct LiveStand {
    spec: StandSpec,
    /// Does what is to be done, one thing after the other.
    doing: Hands,
    /// Looks at LEDs and counters, while something is being done or not.
    looking: Hands,
    /// Whether something is being done.
    busy: bool,
    /// What became of the last action.
    outcome: Option<Result<Duration, Refusal>>,
    leds: BTreeMap<String, Seen>,
    counters: BTreeMap<String, Seen>,
    /// How many actions there were: what was asked before the last one says nothing about now.
    actions: u64,
    words: Vec<&'static str>,
}

/// What was last seen of an LED or a counter; by a clock of its own, since that of the wire begins anew with each trial.
#[derive(Default)]
struct Seen {
    /// Whether an answer is on its way.
    asked: bool,
    /// When the last answer was taken.
    at: Option<Instant>,
    word: Option<String>,
}

impl LiveStand {
    /// The stand that `spec` describes; nothing is done or asked yet.
    pub fn new(spec: &StandSpec) -> LiveStand {
        LiveStand {
            doing: Hands::new(spec),
            looking: Hands::new(spec),
            spec: spec.clone(),
            busy: false,
            outcome: None,
            leds: BTreeMap::new(),
            counters: BTreeMap::new(),
            actions: 0,
            words: Vec::new(),
        }
    }

    /// Asks the other end of the control channel for the names that it serves, for [`StandSpec::offers`].
    ///
    /// None without a control channel; fails with a sentence if nobody answers there or the answer makes no sense.
    pub fn offers(&mut self) -> Result<Option<Vec<String>>, String> {
        if self.spec.control.is_none() {
            return Ok(None);
        }
        self.doing.give(Job::Abilities);
        match self.doing.wait(hands::CONTROL_PATIENCE * 2) {
            Some(Told::Word(Ok(names))) => Ok(Some(names.split_whitespace().map(str::to_owned).collect())),
            Some(Told::Word(Err(refusal))) => Err(sentence(&refusal).to_owned()),
            _ => Err("the stand does not say what it can do".to_owned()),
        }
    }

    /// Takes in what the threads have to say.
    fn catch_up(&mut self) {
        while let Some(told) = self.doing.told() {
            if let Told::Done(result) = told {
                self.busy = false;
                self.outcome = Some(result);
            }
        }
        while let Some(told) = self.looking.told() {
            let (of, name, asked_after, word) = match told {
                Told::Led(name, actions, word) => (&mut self.leds, name, actions, word),
                Told::Counter(name, actions, word) => (&mut self.counters, name, actions, word),
                _ => continue,
            };
            if asked_after == self.actions {
                of.insert(name, Seen { asked: false, at: Some(Instant::now()), word });
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
    /// Begins `action` and comes back at once; [`Stand::outcome`] says when it is done.
    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Result<Time, Refusal> {
        self.catch_up();
        let name = ability(action);
        if !self.spec.serves(&name) {
            // Nothing has to be done to a shaft that nobody keeps turning.
            return match action {
                StandAction::ShaftSpeed(0.0) => Ok(now),
                _ => Err(Refusal::CannotDo(format!("it has nothing that serves {name}"))),
            };
        }
        if self.busy {
            return Err(Refusal::Broken(format!("it is not done with the last action, so {name} has to wait")));
        }
        self.leds.clear();
        self.counters.clear();
        self.actions += 1;
        self.outcome = None;
        self.busy = true;
        self.doing.give(Job::act(action, &name));
        Ok(now)
    }

    fn outcome(&mut self, now: Time) -> Option<Result<Time, Refusal>> {
        self.catch_up();
        if self.busy {
            return None;
        }
        let outcome = self.outcome.take().unwrap_or(Ok(Duration::ZERO));
        Some(outcome.map(|more| now + more))
    }

    /// What the LED shows: asked for at most every 20 ms; none before the first answer since the last action.
    fn led(&mut self, _: Time, name: &str) -> Option<&'static str> {
        self.catch_up();
        if !self.spec.serves(&format!("led.{name}")) {
            return None;
        }
        let seen = self.leds.entry(name.to_owned()).or_default();
        let age = seen.at.map(|at| at.elapsed());
        if !seen.asked && age.is_none_or(|age| age >= FRESH) {
            seen.asked = true;
            self.looking.give(Job::Led(name.to_owned(), self.actions));
        }
        let word = seen.word.clone().filter(|_| age.is_some_and(|age| age < STALE))?;
        self.interned(&word)
    }

    /// What the counter has counted by now; none while the answer is on its way, so ask again: each answer is given once.
    fn counter(&mut self, _: Time, name: &str) -> Option<u64> {
        self.catch_up();
        if !self.spec.serves(&format!("counter.{name}")) {
            return None;
        }
        let seen = self.counters.entry(name.to_owned()).or_default();
        let answer = seen.at.take().filter(|at| at.elapsed() < STALE);
        if let Some(word) = seen.word.take().filter(|_| answer.is_some()) {
            return word.parse().ok();
        }
        if !seen.asked {
            seen.asked = true;
            self.looking.give(Job::Counter(name.to_owned(), self.actions));
        }
        None
    }
}

fn sentence(refusal: &Refusal) -> &str {
    match refusal {
        Refusal::CannotDo(why) | Refusal::Broken(why) => why,
    }
}
