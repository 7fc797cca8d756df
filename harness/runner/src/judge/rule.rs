//! Rules: what has to hold on every connection, or over a block of steps.

use super::condition::Memory;
use super::image::Happening;
use super::steady::Steady;
use super::view::View;
use super::window::{Outcome, Stay, Window};
use super::{Tick, TickKind, Truth};
use crate::result::{Decided, PartSeen};
use crate::suite::expr::{NameId, State, Value};
use crate::suite::model::{Condition, Hold, Rule, RuleBody, Span};
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

/// Open windows that will all be decided alike, with the first tick that opened one.
#[derive(Debug)]
struct Open {
    window: Window,
    trigger: Tick,
    count: u64,
}

/// A rule at work on one connection after the other.
#[derive(Debug)]
pub struct RuleWatch<'a> {
    body: &'a RuleBody,
    premise: State,
    condition: Memory,
    end: Memory,
    open: Vec<Open>,
    closed: bool,
    last: Option<Tick>,
    decided: Decided,
    violation: Option<Violation>,
    watchdog: Duration,
    steady: Steady<Known>,
}

/// What the programs of a rule came to, as far as they were asked.
#[derive(Clone, Copy, Debug, Default)]
struct Known {
    /// The condition that always holds, or that of `then`.
    truth: Option<Truth>,
    premise: Option<Option<bool>>,
    end: Option<Truth>,
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
            closed: false,
            last: None,
            decided: Decided::default(),
            violation: None,
            watchdog,
            steady: Steady::default(),
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

    /// Remembers how things stand before the first frame that is looked at, so that a change in that frame is seen.
    pub fn begin_with(&mut self, view: &View<'_>) {
        self.advance(view);
        self.steady.forget();
    }

    /// Lets nothing new begin: premises open no window any more, `always` is not judged; open windows go on.
    pub fn close(&mut self) {
        self.closed = true;
    }

    /// Looks at a frame or an event; says whether the rule spoke of the event that happens at this tick.
    pub fn tick(&mut self, view: &View<'_>) -> bool {
        if self.violation.is_some() || self.closed && self.open.is_empty() {
            return false;
        }
        self.decided.looked_at += 1;
        let before = self.steady.known(self.body, view);
        let mut known = before.unwrap_or_default();
        let speaks = self.judge(view, &mut known);
        // What is remembered stays as well where neither what is seen nor what is remembered has changed.
        let moved = before.is_none() && self.advance(view);
        self.steady.keep(view, known, moved);
        self.last = Some(view.tick);
        speaks
    }

    fn judge(&mut self, view: &View<'_>, known: &mut Known) -> bool {
        match self.body {
            RuleBody::Always(condition) => {
                if !view.tick.kind.is_judged() {
                    return false;
                }
                let truth = *known.truth.get_or_insert_with(|| self.condition.truth(condition, view));
                match truth {
                    Truth::True => self.decided.premises += 1,
                    Truth::Unknown => self.decided.undecided += 1,
                    Truth::False => {
                        self.decided.premises += 1;
                        let parts = self.condition.parts(condition, view);
                        self.break_with("it does not hold".into(), view.tick, None, parts);
                    }
                }
                truth != Truth::Unknown && names_happening(condition, view)
            }
            RuleBody::When { premise, then, within, hold } => {
                let mut speaks = false;
                if !self.closed {
                    let begins = *known.premise.get_or_insert_with(|| premise.truth(view, &self.premise));
                    if begins == Some(true) {
                        speaks = premise.names().any(|name| view.is_happening(name));
                        self.open_window(within, hold, view);
                    }
                }
                if !self.open.is_empty() {
                    speaks |= self.look(view, then, hold, known) == Truth::True && names_happening(then, view);
                }
                speaks
            }
        }
    }

    /// Moves on to the next observation, and says whether something else is remembered now.
    fn advance(&mut self, view: &View<'_>) -> bool {
        let (RuleBody::Always(condition) | RuleBody::When { then: condition, .. }) = self.body;
        let mut changed = self.condition.advance(condition, view);
        if let RuleBody::When { premise, hold, .. } = self.body {
            changed |= self.premise.advance(premise, view);
            if let Hold::Until(end) = hold {
                changed |= self.end.advance(end, view);
            }
        }
        changed
    }

    /// Opens the window of a premise; without knowing how long it is nothing can be decided.
    fn open_window(&mut self, within: &Span, hold: &Hold, view: &View<'_>) {
        let (Some(within), Some(stay)) = (length(within, view), stay(hold, view)) else {
            self.decided.undecided += 1;
            return;
        };
        let window = Window::open(view.tick.time, within, view.notebook.slack, stay, self.watchdog).of_rule();
        let window = if view.tick.kind == TickKind::Event { window.by_event() } else { window };
        self.open.push(Open { window, trigger: view.tick, count: 1 });
    }

    fn look(&mut self, view: &View<'_>, then: &Condition, hold: &Hold, known: &mut Known) -> Truth {
        let truth = *known.truth.get_or_insert_with(|| self.condition.truth(then, view));
        let end = match hold {
            Hold::Until(end) => *known.end.get_or_insert_with(|| self.end.truth(end, view)),
            Hold::None | Hold::For(_) => Truth::False,
        };
        for open in &mut self.open {
            open.window.tick(view.tick, truth, end);
        }
        self.settle(|condition| condition.parts(then, view), view.tick);
        // A premise that stays true opens a window at every frame: those without a difference are kept as one.
        self.open.dedup_by(|later, earlier| {
            let like = later.window.is_like(&earlier.window);
            earlier.count += if like { later.count } else { 0 };
            like
        });
        truth
    }

    /// Takes the decided windows out; the first broken one is kept as the violation.
    fn settle(&mut self, parts: impl Fn(&Memory) -> Vec<PartSeen>, tick: Tick) {
        let mut broken = None;
        let decided = &mut self.decided;
        self.open.retain(|Open { window, trigger, count }| {
            match window.outcome() {
                Outcome::Open => return true,
                Outcome::Held => decided.premises += count,
                Outcome::Undecided | Outcome::Starved(_) => decided.undecided += count,
                Outcome::Late(at) => {
                    decided.premises += count;
                    broken.get_or_insert(("it did not come in time", at.unwrap_or(tick), *trigger));
                }
                Outcome::Relapsed(at) => {
                    decided.premises += count;
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
        for open in &mut self.open {
            open.window.time(now);
        }
        if let (RuleBody::When { then, .. }, Some(last)) = (self.body, self.last) {
            self.settle(|condition| condition.parts(then, view), last);
        }
    }

    /// Ends what is open where a connection or the trace ends or has a gap, and forgets what came before.
    pub fn cut(&mut self) {
        self.decided.undecided += self.open.iter().map(|open| open.count).sum::<u64>();
        self.open.clear();
        self.premise.forget();
        self.condition.forget();
        self.end.forget();
        self.steady.forget();
    }

    fn break_with(&mut self, how: String, tick: Tick, trigger: Option<Tick>, parts: Vec<PartSeen>) {
        let mut names = Vec::new();
        let (RuleBody::Always(condition) | RuleBody::When { then: condition, .. }) = self.body;
        condition.each_name(&mut |name| names.push(name));
        self.violation = Some(Violation { tick, trigger, how, parts, names });
    }
}

/// The rules of a variant at work.
#[derive(Debug)]
pub struct RuleSet<'a> {
    rules: &'a [Rule],
    watches: Vec<RuleWatch<'a>>,
    /// Whether a window is open.
    is_waiting: bool,
}

impl<'a> RuleSet<'a> {
    /// Rules that have seen nothing yet; a hold without samples for longer than `watchdog` is undecided.
    pub fn new(rules: &'a [Rule], watchdog: Duration) -> RuleSet<'a> {
        let watches = rules.iter().map(|rule| RuleWatch::new(&rule.body, watchdog)).collect();
        RuleSet { rules, watches, is_waiting: false }
    }

    /// Looks at a frame or an event; a rule that names a signal which the module in use lacks is not judged.
    pub fn tick(&mut self, view: &View<'_>) {
        let Some(module) = view.image.module() else { return };
        self.is_waiting = false;
        let rules = self.rules.iter().zip(&mut self.watches);
        rules.filter(|(rule, _)| rule.modules.contains(&module)).for_each(|(_, watch)| {
            watch.tick(view);
            self.is_waiting |= !watch.open.is_empty();
        });
    }

    /// Lets time go by without a frame.
    pub fn time(&mut self, view: &View<'_>, now: Time) {
        if self.is_waiting {
            self.watches.iter_mut().for_each(|watch| watch.time(view, now));
        }
    }

    /// Ends what is open where a connection or the trace ends.
    pub fn cut(&mut self) {
        self.is_waiting = false;
        self.watches.iter_mut().for_each(RuleWatch::cut);
    }

    /// The rules with what each has seen, in the order of the variant.
    pub fn iter(&self) -> impl Iterator<Item = (&'a Rule, &RuleWatch<'a>)> {
        self.rules.iter().zip(&self.watches)
    }
}

/// Whether a condition names the event that happens at the instant of `view`.
fn names_happening(condition: &Condition, view: &View<'_>) -> bool {
    if view.image.happening == Happening::Nothing {
        return false;
    }
    let mut found = false;
    condition.each_name(&mut |name| found |= view.is_happening(name));
    found
}

/// A span as time, with the cycle and the values of this instant; `None` if it cannot be known.
pub fn length(span: &Span, view: &View<'_>) -> Option<Duration> {
    match span {
        Span::Time(time) => Some(*time),
        Span::Cycles(cycles) => Some(view.image.cycle()? * u32::try_from(*cycles).unwrap_or(u32::MAX)),
        Span::Computed(program) => match program.eval(view, &State::default()) {
            Value::Time(nanos) => u64::try_from(nanos.as_whole()?).ok().map(Duration::from_nanos),
            Value::Cycles(cycles) => Some(view.image.cycle()? * u32::try_from(cycles.as_whole()?).ok()?),
            _ => None,
        },
    }
}

/// A hold with its length as time; `None` if that cannot be known.
pub fn stay(hold: &Hold, view: &View<'_>) -> Option<Stay> {
    Some(match hold {
        Hold::None => Stay::No,
        Hold::For(span) => Stay::For(length(span, view)?),
        Hold::Until(_) => Stay::Until,
    })
}
