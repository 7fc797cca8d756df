//! Rules over a block of steps: `observe` with its rules, counts and sequences.

use expression::{HistoryState, NameId, NameValues, Program, Value, equal};
use judge::condition;
use judge::rule::RuleWatch;
use judge::view::NameView;
use judge::wire_position::{WirePosition, place_of};
use judge::{JudgeTick, Truth};
use results::outcome::JudgedPart;
use station::{Duration, Time};
use suite::Location;
use suite::model::{BlockObservation, SequenceEntry};

/// The observations of one repetition of a block.
pub struct BlockWatch<'a> {
    watches: Vec<ObservationWatch<'a>>,
    closed: bool,
}

enum ObservationWatch<'a> {
    Rule { of: &'a BlockObservation, rule: Box<RuleWatch<'a>> },
    Count { of: &'a BlockObservation, state: HistoryState, counted: ConditionCount },
    Sequence { of: &'a BlockObservation, states: Vec<HistoryState>, passed: ObservedSequence },
}

/// The result of a count.
#[derive(Default)]
struct ConditionCount {
    /// Number of frames and events at which the condition was true.
    held: u64,
    /// Number of frames and events at which it was true or false.
    known: u64,
    /// Number of frames and events at which it was unknown, so that it may have been true.
    unknown: u64,
    /// The first and the last one at which it was true.
    first: Option<BreakingPlace>,
    last: Option<BreakingPlace>,
}

/// A frame or event that may break an observation, and the byte and bit in its frame that show it.
pub type BreakingPlace = (JudgeTick, Option<WirePosition>);

/// What the names of a sequence were from a frame or event on.
struct ObservedEntry {
    at: BreakingPlace,
    values: Vec<Value>,
}

/// The result of a sequence.
#[derive(Default)]
struct ObservedSequence {
    /// The known values; equal consecutive ones count once.
    values: Vec<ObservedEntry>,
    /// How many of them came before the values became unknown for the first time.
    gap: Option<usize>,
}

/// A broken or undecided observation.
#[derive(Clone, Debug)]
pub struct BrokenObservation {
    /// The observation as written in the suite.
    pub text: String,
    /// Its position in the suite.
    pub at: Location,
    /// What is wrong, in a sentence.
    pub what: String,
    /// Expected and observed values.
    pub parts: Vec<JudgedPart>,
    /// Where it was broken.
    pub place: Option<BreakingPlace>,
    /// Whether it was never decided, so it says nothing about the device.
    pub undecided: bool,
}

impl<'a> BlockWatch<'a> {
    /// Begins to observe; holds of its rules starve after `watchdog` without samples.
    pub fn begin(observations: &'a [BlockObservation], watchdog: Duration) -> BlockWatch<'a> {
        let watch = |of: &'a BlockObservation| match of {
            BlockObservation::Rule { body, .. } => {
                ObservationWatch::Rule { of, rule: Box::new(RuleWatch::new(body, watchdog)) }
            }
            BlockObservation::Count { .. } => {
                ObservationWatch::Count { of, state: HistoryState::default(), counted: ConditionCount::default() }
            }
            BlockObservation::Sequence { names, .. } => ObservationWatch::Sequence {
                of,
                states: vec![HistoryState::default(); names.len()],
                passed: ObservedSequence::default(),
            },
        };
        BlockWatch { watches: observations.iter().map(watch).collect(), closed: false }
    }

    /// Takes in the state at the begin of the block: sequences begin with these values, and a change in the first frame of the block
    /// counts as a change.
    pub fn begin_with(&mut self, view: &NameView<'_>) {
        for watch in &mut self.watches {
            match watch {
                ObservationWatch::Rule { rule, .. } => rule.begin_with(view),
                ObservationWatch::Count { of: BlockObservation::Count { condition, .. }, state, .. } => {
                    state.advance(condition, view);
                }
                ObservationWatch::Sequence { .. } | ObservationWatch::Count { .. } => {
                    watch.tick(view);
                }
            }
        }
    }

    /// Ends the block: nothing new is judged or counted; only open windows go on.
    pub fn close(&mut self) {
        self.closed = true;
        for watch in &mut self.watches {
            if let ObservationWatch::Rule { rule, .. } = watch {
                rule.close();
            }
        }
    }

    /// Takes in a frame or an event; returns whether an observation uses the event at this tick.
    pub fn tick(&mut self, view: &NameView<'_>) -> bool {
        let closed = self.closed;
        let watches = self.watches.iter_mut().filter(|watch| !closed || matches!(watch, ObservationWatch::Rule { .. }));
        watches.fold(false, |speaks, watch| watch.tick(view) | speaks)
    }

    /// Advances the time without a frame.
    pub fn time(&mut self, view: &NameView<'_>, now: Time) {
        for watch in &mut self.watches {
            if let ObservationWatch::Rule { rule, .. } = watch {
                rule.time(view, now);
            }
        }
    }

    /// Ends the open windows when the connection ends, and forgets earlier values.
    pub fn cut(&mut self) {
        for watch in &mut self.watches {
            match watch {
                ObservationWatch::Rule { rule, .. } => rule.cut(),
                ObservationWatch::Count { state, .. } => state.forget(),
                ObservationWatch::Sequence { states, .. } => states.iter_mut().for_each(HistoryState::forget),
            }
        }
    }

    /// Whether a window is still open.
    pub fn is_waiting(&self) -> bool {
        self.watches.iter().any(|watch| matches!(watch, ObservationWatch::Rule { rule, .. } if rule.is_waiting()))
    }

    /// The broken observations, then the undecided ones.
    pub fn end(self, view: &NameView<'_>) -> Vec<BrokenObservation> {
        let mut broken: Vec<BrokenObservation> = self.watches.into_iter().filter_map(|watch| watch.end(view)).collect();
        broken.sort_by_key(|broken| broken.undecided);
        broken
    }
}

impl ObservationWatch<'_> {
    fn tick(&mut self, view: &NameView<'_>) -> bool {
        match self {
            ObservationWatch::Rule { rule, .. } => return rule.tick(view),
            ObservationWatch::Count { of: BlockObservation::Count { condition, .. }, state, counted } => {
                let truth = condition.truth(view, state);
                state.advance(condition, view);
                counted.add(truth, || here(condition.names(), view));
                return truth == Some(true) && condition.names().any(|name| view.is_happening(name));
            }
            ObservationWatch::Sequence { of: BlockObservation::Sequence { names, .. }, states, passed } => {
                let now: Vec<Value> =
                    names.iter().zip(states.iter()).map(|(program, state)| program.eval(view, state)).collect();
                for (program, state) in names.iter().zip(states) {
                    state.advance(program, view);
                }
                passed.add(now, names, view);
            }
            ObservationWatch::Count { .. } | ObservationWatch::Sequence { .. } => {}
        }
        false
    }

    fn end(self, view: &NameView<'_>) -> Option<BrokenObservation> {
        match self {
            ObservationWatch::Rule { of: BlockObservation::Rule { text, at, .. }, rule } => {
                if let Some(violation) = rule.violation() {
                    return Some(BrokenObservation {
                        text: text.clone(),
                        at: at.clone(),
                        what: format!("The rule over the block was broken: {}.", violation.how),
                        parts: violation.parts.clone(),
                        place: Some((violation.tick, violation.place)),
                        undecided: false,
                    });
                }
                let decided = rule.decided();
                (decided.premises == 0).then(|| BrokenObservation {
                    text: text.clone(),
                    at: at.clone(),
                    what: format!("The rule was never decided ({} frames and events checked).", decided.checked),
                    parts: Vec::new(),
                    place: None,
                    undecided: true,
                })
            }
            ObservationWatch::Count { of: BlockObservation::Count { text, at, condition, is }, counted, .. } => {
                let is_right = |count| condition::matches(is, &Value::whole(count), view);
                let right = counted.judge(is_right);
                let what = match right {
                    Truth::True => return None,
                    Truth::False => "The number is wrong.".into(),
                    Truth::Unknown => format!(
                        "The number is uncertain: the condition was known at {1} of {0} frames and events.",
                        counted.known + counted.unknown,
                        counted.known
                    ),
                };
                Some(BrokenObservation {
                    text: text.clone(),
                    at: at.clone(),
                    what,
                    parts: vec![JudgedPart {
                        text: condition.text().to_owned(),
                        expected: condition::expected_text(is, view),
                        observed: counted.held.to_string(),
                        held: false,
                    }],
                    place: counted.breaking(is_right),
                    undecided: right == Truth::Unknown,
                })
            }
            ObservationWatch::Sequence { of: BlockObservation::Sequence { text, at, names, is }, passed, .. } => {
                let observed: Vec<&[Value]> = passed.values.iter().map(|entry| &entry.values[..]).collect();
                let known = passed.gap.unwrap_or(observed.len());
                let open = passed.gap.is_some() || observed.is_empty();
                let order =
                    SequenceMatcher { expected: is, observed: &observed[..known], open, noise: view.position_noise() };
                let wrong = order.first_difference();
                let undecided = wrong.is_none();
                let (what, wrong) = match wrong {
                    Some(wrong) => (format!("The order is wrong from entry {}.", wrong + 1), wrong),
                    None if !open => return None,
                    None => (format!("The order is uncertain: after {known} entries the values were unknown."), known),
                };
                Some(BrokenObservation {
                    text: text.clone(),
                    at: at.clone(),
                    undecided,
                    what,
                    parts: vec![JudgedPart {
                        text: names.iter().map(|name| name.text()).collect::<Vec<_>>().join(", "),
                        expected: is.iter().map(show_entry).collect::<Vec<_>>().join(" "),
                        observed: observed.iter().map(|values| show(values)).collect::<Vec<_>>().join(" "),
                        held: false,
                    }],
                    place: passed.values.get(wrong).or(passed.values.last()).map(|entry| entry.at),
                })
            }
            ObservationWatch::Rule { .. } | ObservationWatch::Count { .. } | ObservationWatch::Sequence { .. } => None,
        }
    }
}

/// This frame or event, and the position of the first of these names that its frame contains.
fn here(names: impl Iterator<Item = NameId>, view: &NameView<'_>) -> BreakingPlace {
    let mut places = names.filter_map(|name| place_of(name, view));
    (view.tick, places.find(|(frame, ..)| *frame == view.tick.frame))
}

impl ConditionCount {
    fn add(&mut self, truth: Option<bool>, here: impl FnOnce() -> BreakingPlace) {
        match truth {
            Some(true) => {
                (self.known, self.held) = (self.known + 1, self.held + 1);
                self.last = Some(here());
                self.first = self.first.or(self.last);
            }
            Some(false) => self.known += 1,
            None => self.unknown += 1,
        }
    }

    /// Where there were too many: at the first one if there may be none, else at the last one. No frame shows what is missing.
    fn breaking(&self, is_right: impl Fn(u64) -> Truth) -> Option<BreakingPlace> {
        let allowed = (0..self.held).rev().find(|count| is_right(*count) == Truth::True)?;
        if allowed == 0 { self.first } else { self.last }
    }

    /// Whether the number is right, with any value of the condition where it was unknown.
    fn judge(&self, is_right: impl Fn(u64) -> Truth) -> Truth {
        if self.known == 0 {
            return Truth::Unknown;
        }
        let first = is_right(self.held);
        let certain = (self.held + 1..=self.held + self.unknown).all(|count| is_right(count) == first);
        if certain { first } else { Truth::Unknown }
    }
}

impl ObservedSequence {
    fn add(&mut self, now: Vec<Value>, names: &[Program], view: &NameView<'_>) {
        if now.iter().any(Value::is_unknown) {
            if !self.values.is_empty() {
                self.gap.get_or_insert(self.values.len());
            }
            return;
        }
        let (last, noise) = (self.values.last().map(|entry| &entry.values), view.position_noise());
        let has_changed = |at: &usize| last.is_none_or(|last| !is_same(&last[*at], &now[*at], noise));
        let mut changed = (0..names.len()).filter(has_changed).peekable();
        if changed.peek().is_some() {
            let at = here(changed.flat_map(|at| names[at].names()), view);
            self.values.push(ObservedEntry { at, values: now });
        }
    }
}

/// Whether values are equal by the rules of `==`; the noise applies to positions only.
fn same(observed: &[Value], expected: &[Value], noise: u32) -> bool {
    observed.len() == expected.len()
        && observed.iter().zip(expected).all(|(observed, expected)| is_same(observed, expected, noise))
}

fn is_same(observed: &Value, expected: &Value, noise: u32) -> bool {
    let noise = if matches!((observed, expected), (Value::Place(_), _) | (_, Value::Place(_))) { noise } else { 0 };
    equal(observed, expected, None, noise) == Some(true)
}

/// The expected sequence and the observed values.
struct SequenceMatcher<'a> {
    expected: &'a [SequenceEntry],
    observed: &'a [&'a [Value]],
    /// Whether further values may have followed the observed ones.
    open: bool,
    noise: u32,
}

impl SequenceMatcher<'_> {
    /// The index of the first observed value that does not fit; `None` if all fit.
    fn first_difference(&self) -> Option<usize> {
        let mut furthest = 0;
        (!self.fits(self.expected, 0, &mut furthest)).then_some(furthest)
    }

    fn fits(&self, expected: &[SequenceEntry], at: usize, furthest: &mut usize) -> bool {
        *furthest = (*furthest).max(at);
        match expected.split_first() {
            None => at >= self.observed.len(),
            Some((SequenceEntry::Values(values), rest)) => self.is(at, values) && self.fits(rest, at + 1, furthest),
            Some((SequenceEntry::Either(runs), rest)) => runs.iter().any(|run| {
                let fit = run.iter().enumerate().all(|(index, values)| self.is(at + index, values));
                fit && self.fits(rest, at + run.len(), furthest)
            }),
        }
    }

    fn is(&self, at: usize, expected: &[Value]) -> bool {
        self.observed.get(at).map_or(self.open, |observed| same(observed, expected, self.noise))
    }
}

fn show(values: &[Value]) -> String {
    format!("[{}]", values.iter().map(judge::format::plain).collect::<Vec<_>>().join(", "))
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
