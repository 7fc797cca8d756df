//! Rules over a block of steps: `observe` with its rules, counts and sequences.

use crate::judge::condition;
use crate::judge::rule::RuleWatch;
use crate::judge::view::View;
use crate::judge::{Tick, Truth};
use crate::result::PartSeen;
use crate::suite::device::Location;
use crate::suite::expr::{NameId, State, Value};
use crate::suite::model::{Observation, SequenceEntry};
use station::{Duration, Time};

/// The observations of one repetition of a block.
pub struct BlockWatch<'a> {
    watches: Vec<Watch<'a>>,
}

enum Watch<'a> {
    Rule { of: &'a Observation, rule: Box<RuleWatch<'a>> },
    Count { of: &'a Observation, state: State, count: u64, last: Option<Tick> },
    Sequence { of: &'a Observation, states: Vec<State>, values: Vec<(Tick, Vec<Value>)> },
}

/// An observation that was broken.
#[derive(Clone, Debug)]
pub struct Broken {
    /// As written.
    pub text: String,
    /// Where it stands.
    pub at: Location,
    /// What broke, in a sentence.
    pub what: String,
    /// Wanted and seen.
    pub parts: Vec<PartSeen>,
    /// Where it was broken.
    pub tick: Option<Tick>,
    /// The names of the parts.
    pub names: Vec<NameId>,
    /// Whether it was never decided, so that nothing can be said about the device.
    pub undecided: bool,
}

impl<'a> BlockWatch<'a> {
    /// Begins to observe; holds of its rules starve after `watchdog` without samples.
    pub fn begin(observations: &'a [Observation], watchdog: Duration) -> BlockWatch<'a> {
        let watch = |of: &'a Observation| match of {
            Observation::Rule { body, .. } => Watch::Rule { of, rule: Box::new(RuleWatch::new(body, watchdog)) },
            Observation::Count { .. } => Watch::Count { of, state: State::default(), count: 0, last: None },
            Observation::Sequence { names, .. } => {
                Watch::Sequence { of, states: vec![State::default(); names.len()], values: Vec::new() }
            }
        };
        BlockWatch { watches: observations.iter().map(watch).collect() }
    }

    /// Looks at how things stand at the begin of the block: sequences begin with these values.
    pub fn begin_with(&mut self, view: &View<'_>) {
        for watch in &mut self.watches {
            if let Watch::Sequence { .. } = watch {
                watch.tick(view);
            }
        }
    }

    /// Looks at a frame or an event.
    pub fn tick(&mut self, view: &View<'_>) {
        self.watches.iter_mut().for_each(|watch| watch.tick(view));
    }

    /// Lets time go by without a frame.
    pub fn time(&mut self, view: &View<'_>, now: Time) {
        for watch in &mut self.watches {
            if let Watch::Rule { rule, .. } = watch {
                rule.time(view, now);
            }
        }
    }

    /// Ends what is open where the connection ends.
    pub fn cut(&mut self) {
        for watch in &mut self.watches {
            if let Watch::Rule { rule, .. } = watch {
                rule.cut();
            }
        }
    }

    /// Whether windows are open that have to be waited for.
    pub fn is_waiting(&self) -> bool {
        self.watches.iter().any(|watch| matches!(watch, Watch::Rule { rule, .. } if rule.is_waiting()))
    }

    /// Whether one of its counts looks at events, so that they are expected while it runs.
    pub fn counts_events(&self, view: &View<'_>) -> bool {
        self.watches.iter().any(|watch| match watch {
            Watch::Count { of: Observation::Count { condition, .. }, .. } => condition.names().any(|name| {
                matches!(view.variant.names.get(name.0 as usize), Some(crate::suite::device::NameKind::Event(_)))
            }),
            _ => false,
        })
    }

    /// The observations that were broken, or that nothing was seen for.
    pub fn end(self, view: &View<'_>) -> Vec<Broken> {
        self.watches.into_iter().filter_map(|watch| watch.end(view)).collect()
    }
}

impl Watch<'_> {
    fn tick(&mut self, view: &View<'_>) {
        match self {
            Watch::Rule { rule, .. } => rule.tick(view),
            Watch::Count { of, state, count, last } => {
                if let Observation::Count { condition, .. } = of {
                    if condition.truth(view, state) == Some(true) {
                        *count += 1;
                        *last = Some(view.tick);
                    }
                    state.advance(condition, view);
                }
            }
            Watch::Sequence { of, states, values } => {
                if let Observation::Sequence { names, .. } = of {
                    let now: Vec<Value> =
                        names.iter().zip(states.iter()).map(|(program, state)| program.eval(view, state)).collect();
                    for (program, state) in names.iter().zip(states) {
                        state.advance(program, view);
                    }
                    let known = !now.iter().any(Value::is_unknown);
                    if known && values.last().is_none_or(|(_, last)| *last != now) {
                        values.push((view.tick, now));
                    }
                }
            }
        }
    }

    fn end(self, view: &View<'_>) -> Option<Broken> {
        match self {
            Watch::Rule { of: Observation::Rule { text, at, .. }, rule } => {
                if let Some(violation) = rule.violation() {
                    return Some(Broken {
                        text: text.clone(),
                        at: at.clone(),
                        what: format!("The rule over the block was broken: {}.", violation.how),
                        parts: violation.parts.clone(),
                        tick: Some(violation.tick),
                        names: violation.names.clone(),
                        undecided: false,
                    });
                }
                let decided = rule.decided();
                (decided.premises == 0).then(|| Broken {
                    text: text.clone(),
                    at: at.clone(),
                    what: format!("The rule was never decided ({} frames and events looked at).", decided.looked_at),
                    parts: Vec::new(),
                    tick: None,
                    names: Vec::new(),
                    undecided: true,
                })
            }
            Watch::Count { of: Observation::Count { text, at, condition, is }, count, last, .. } => {
                let held = condition::matches(is, &Value::whole(count), view) == Truth::True;
                (!held).then(|| Broken {
                    text: text.clone(),
                    at: at.clone(),
                    what: "The number is not right.".into(),
                    parts: vec![PartSeen {
                        text: condition.text().to_owned(),
                        wanted: condition::wanted_text(is, view),
                        seen: count.to_string(),
                        held,
                    }],
                    tick: last,
                    names: condition.names().collect(),
                    undecided: false,
                })
            }
            Watch::Sequence { of: Observation::Sequence { text, at, names, is }, values, .. } => {
                let seen: Vec<&[Value]> = values.iter().map(|(_, values)| &values[..]).collect();
                let wrong = first_difference(is, &seen)?;
                Some(Broken {
                    text: text.clone(),
                    at: at.clone(),
                    what: format!("The order is not right from entry {} on.", wrong + 1),
                    parts: vec![PartSeen {
                        text: names.iter().map(|name| name.text()).collect::<Vec<_>>().join(", "),
                        wanted: is.iter().map(show_entry).collect::<Vec<_>>().join(" "),
                        seen: seen.iter().map(|values| show(values)).collect::<Vec<_>>().join(" "),
                        held: false,
                    }],
                    tick: values.get(wrong).or(values.last()).map(|(tick, _)| *tick),
                    names: names.iter().flat_map(|name| name.names()).collect(),
                    undecided: false,
                })
            }
            Watch::Rule { .. } | Watch::Count { .. } | Watch::Sequence { .. } => None,
        }
    }
}

/// The first place at which what was seen is not what is right; `None` if all of it is.
fn first_difference(wanted: &[SequenceEntry], seen: &[&[Value]]) -> Option<usize> {
    let mut furthest = 0;
    (!fits(wanted, seen, 0, &mut furthest)).then_some(furthest)
}

fn fits(wanted: &[SequenceEntry], seen: &[&[Value]], at: usize, furthest: &mut usize) -> bool {
    *furthest = (*furthest).max(at);
    match wanted.split_first() {
        None => at == seen.len(),
        Some((SequenceEntry::Values(values), rest)) => {
            seen.get(at).is_some_and(|seen| seen == values) && fits(rest, seen, at + 1, furthest)
        }
        Some((SequenceEntry::Either(runs), rest)) => runs.iter().any(|run| {
            let fit =
                run.iter().enumerate().all(|(index, values)| seen.get(at + index).is_some_and(|seen| seen == values));
            fit && fits(rest, seen, at + run.len(), furthest)
        }),
    }
}

fn show(values: &[Value]) -> String {
    format!("[{}]", values.iter().map(crate::judge::view::plain).collect::<Vec<_>>().join(", "))
}

fn show_entry(entry: &SequenceEntry) -> String {
    match entry {
        SequenceEntry::Values(values) => show(values),
        SequenceEntry::Either(runs) => {
            let run = |run: &Vec<Vec<Value>>| run.iter().map(|values| show(values)).collect::<Vec<_>>().join(" ");
            format!("({})", runs.iter().map(run).collect::<Vec<_>>().join(" | "))
        }
    }
}
