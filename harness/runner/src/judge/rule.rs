//! Rules: what has to hold on every connection, or over a block of steps.

use super::condition::Memory;
use super::view::View;
use super::window::{Outcome, Stay, Window};
use super::{Tick, TickKind, Truth};
use crate::result::{Decided, PartSeen};
use crate::suite::expr::{NameId, State, Value};
use crate::suite::model::{Hold, Rule, RuleBody, Span};
use station::{Duration, Time};

/// A rule that was broken: where, and what was wanted and seen there.
#[derive(Clone, Debug)]
pub struct Violation {
    /// Where it was broken; for a deadline the last tick that was looked at.
    pub tick: Tick,
    /// Where the premise was true, for a rule with one.
    pub trigger: Option<Tick>,
    /// How, in a few words.
    pub how: String,
    /// The parts of the condition.
    pub parts: Vec<PartSeen>,
    /// The names of the parts, for the place on the wire.
    pub names: Vec<NameId>,
}

/// A rule at work on one connection after the other.
#[derive(Debug)]
pub struct RuleWatch<'a> {
    body: &'a RuleBody,
    premise: State,
    condition: Memory,
    end: Memory,
    open: Vec<(Window, Tick)>,
    last: Option<Tick>,
    decided: Decided,
    violation: Option<Violation>,
    watchdog: Duration,
}

impl<'a> RuleWatch<'a> {
    /// A rule that has seen nothing yet; a hold without samples for longer than `watchdog` is undecided.
    pub fn new(body: &'a RuleBody, watchdog: Duration) -> RuleWatch<'a> {
        RuleWatch {
            body,
            premise: State::default(),
            condition: Memory::default(),
            end: Memory::default(),
            open: Vec::new(),
            last: None,
            decided: Decided::default(),
            violation: None,
            watchdog,
        }
    }

    /// How often it was decided so far.
    pub fn decided(&self) -> Decided {
        self.decided
    }

    /// The first time it was broken.
    pub fn violation(&self) -> Option<&Violation> {
        self.violation.as_ref()
    }

    /// Whether windows are open that may still be decided.
    pub fn is_waiting(&self) -> bool {
        self.violation.is_none() && !self.open.is_empty()
    }

    /// Looks at a frame or an event.
    pub fn tick(&mut self, view: &View<'_>) {
        if self.violation.is_some() {
            return;
        }
        self.decided.looked_at += 1;
        match self.body {
            RuleBody::Always(condition) => {
                if view.tick.kind.is_judged() {
                    match self.condition.truth(condition, view) {
                        Truth::True => self.decided.premises += 1,
                        Truth::Unknown => self.decided.undecided += 1,
                        Truth::False => {
                            self.decided.premises += 1;
                            let parts = self.condition.parts(condition, view);
                            self.break_with("it does not hold".into(), view.tick, None, parts);
                        }
                    }
                }
                self.condition.advance(condition, view);
            }
            RuleBody::When { premise, then, within, hold } => {
                if premise.truth(view, &self.premise) == Some(true) {
                    let window = Window::open(
                        view.tick.time,
                        time(within, view),
                        Duration::ZERO,
                        stay(hold, view),
                        self.watchdog,
                    );
                    let window = if view.tick.kind == TickKind::Event { window.by_event() } else { window };
                    self.open.push((window, view.tick));
                }
                self.premise.advance(premise, view);
                if !self.open.is_empty() {
                    self.look(view, then, hold);
                }
                self.condition.advance(then, view);
                if let Hold::Until(end) = hold {
                    self.end.advance(end, view);
                }
            }
        }
        self.last = Some(view.tick);
    }

    fn look(&mut self, view: &View<'_>, then: &crate::suite::model::Condition, hold: &Hold) {
        let truth = self.condition.truth(then, view);
        let end = match hold {
            Hold::Until(end) => self.end.truth(end, view),
            Hold::None | Hold::For(_) => Truth::False,
        };
        for (window, _) in &mut self.open {
            window.tick(view.tick, truth, end);
        }
        self.settle(|condition| condition.parts(then, view), view.tick);
    }

    /// Takes the decided windows out; the first broken one is kept as the violation.
    fn settle(&mut self, parts: impl Fn(&Memory) -> Vec<PartSeen>, tick: Tick) {
        let mut broken = None;
        let decided = &mut self.decided;
        self.open.retain(|(window, trigger)| {
            match window.outcome() {
                Outcome::Open => return true,
                Outcome::Held => decided.premises += 1,
                Outcome::Undecided | Outcome::Starved(_) => decided.undecided += 1,
                Outcome::Late(at) => {
                    decided.premises += 1;
                    broken.get_or_insert(("it did not come in time", at.unwrap_or(tick), *trigger));
                }
                Outcome::Relapsed(at) => {
                    decided.premises += 1;
                    broken.get_or_insert(("it did not stay", at, *trigger));
                }
            }
            false
        });
        if let Some((how, at, trigger)) = broken {
            let parts = parts(&self.condition);
            self.break_with(how.into(), at, Some(trigger), parts);
        }
    }

    /// Lets time go by without a frame.
    pub fn time(&mut self, view: &View<'_>, now: Time) {
        if self.open.is_empty() {
            return;
        }
        for (window, _) in &mut self.open {
            window.time(now);
        }
        if let (RuleBody::When { then, .. }, Some(last)) = (self.body, self.last) {
            self.settle(|condition| condition.parts(then, view), last);
        }
    }

    /// Ends what is open where a connection or the trace ends or has a gap, and forgets what came before.
    pub fn cut(&mut self) {
        self.decided.undecided += self.open.len() as u64;
        self.open.clear();
        self.premise.forget();
        self.condition.forget();
        self.end.forget();
    }

    fn break_with(&mut self, how: String, tick: Tick, trigger: Option<Tick>, parts: Vec<PartSeen>) {
        let mut names = Vec::new();
        let (RuleBody::Always(condition) | RuleBody::When { then: condition, .. }) = self.body;
        super::condition::each_name(condition, &mut |name| names.push(name));
        self.violation = Some(Violation { tick, trigger, how, parts, names });
    }
}

/// The rules of a variant at work.
#[derive(Debug)]
pub struct RuleSet<'a> {
    rules: &'a [Rule],
    watches: Vec<RuleWatch<'a>>,
}

impl<'a> RuleSet<'a> {
    /// Rules that have seen nothing yet; a hold without samples for longer than `watchdog` is undecided.
    pub fn new(rules: &'a [Rule], watchdog: Duration) -> RuleSet<'a> {
        RuleSet { rules, watches: rules.iter().map(|rule| RuleWatch::new(&rule.body, watchdog)).collect() }
    }

    /// Looks at a frame or an event; a rule that names a signal which the module in use lacks is not judged.
    pub fn tick(&mut self, view: &View<'_>) {
        let Some(module) = view.image.module() else { return };
        let rules = self.rules.iter().zip(&mut self.watches);
        rules.filter(|(rule, _)| rule.modules.contains(&module)).for_each(|(_, watch)| watch.tick(view));
    }

    /// Lets time go by without a frame.
    pub fn time(&mut self, view: &View<'_>, now: Time) {
        self.watches.iter_mut().for_each(|watch| watch.time(view, now));
    }

    /// Ends what is open where a connection or the trace ends.
    pub fn cut(&mut self) {
        self.watches.iter_mut().for_each(RuleWatch::cut);
    }

    /// The rules with what each has seen, in the order of the variant.
    pub fn iter(&self) -> impl Iterator<Item = (&'a Rule, &RuleWatch<'a>)> {
        self.rules.iter().zip(&self.watches)
    }
}

/// A span as time, with the cycle and the values of this instant.
pub fn time(span: &Span, view: &View<'_>) -> Duration {
    let computed = |value: Value| match value {
        Value::Time(nanos) => nanos.as_whole().and_then(|nanos| u64::try_from(nanos).ok()).map(Duration::from_nanos),
        Value::Cycles(cycles) => {
            let cycles = cycles.as_whole().and_then(|cycles| u32::try_from(cycles).ok())?;
            view.image.cycle().map(|cycle| cycle * cycles)
        }
        _ => None,
    };
    match span {
        Span::Time(time) => *time,
        Span::Cycles(cycles) => view.image.cycle().unwrap_or_default() * u32::try_from(*cycles).unwrap_or(u32::MAX),
        Span::Computed(program) => computed(program.eval(view, &State::default())).unwrap_or_default(),
    }
}

/// A hold with its length as time.
pub fn stay(hold: &Hold, view: &View<'_>) -> Stay {
    match hold {
        Hold::None => Stay::No,
        Hold::For(span) => Stay::For(time(span, view)),
        Hold::Until(_) => Stay::Until,
    }
}
