//! A window: a condition has to become true in time, and then to stay true.
//!
//! It serves `expect` in a case and `then` in a rule; both mean the same (section 4 of the suite language).

use super::{Tick, TickKind, Truth};
use station::{Duration, Time};

/// How long the condition has to stay true once it was.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stay {
    /// One sample is enough.
    No,
    /// So long from the first sample at which it was true.
    For(Duration),
    /// Up to the first sample at which the end condition is true.
    Until,
}

/// What became of a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Outcome {
    /// Not decided yet.
    Open,
    /// The condition became true in time and stayed true.
    Held,
    /// The condition was not true in time; the tick is the last one that was looked at in time.
    Late(Option<Tick>),
    /// The condition was true and became false.
    Relapsed(Tick),
    /// No samples came for longer than the watchdog while it had to stay true.
    Starved(Time),
    /// The condition could not be known at the tick that had to decide.
    Undecided,
}

/// A window of time over a condition.
///
/// The clock of the window starts at `opened`; it is told of every tick and of time going by.
#[derive(Clone, Debug)]
pub struct Window {
    opened: Time,
    deadline: Time,
    next_sample_decides: bool,
    next_event_decides: bool,
    stay: Stay,
    watchdog: Duration,
    phase: Phase,
    last: Option<Tick>,
    seen_unknown: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Phase {
    Waiting,
    Holding { since: Time, last_sample: Time },
    Done(Outcome),
}

impl Window {
    /// A window that opens at `opened`: the condition has to be true at a sample not later than `within` after that
    /// (zero: at the very next sample), then to `stay`. A hold without samples for longer than `watchdog` is starved.
    pub fn open(opened: Time, within: Duration, slack: Duration, stay: Stay, watchdog: Duration) -> Window {
        Window {
            opened,
            deadline: opened + within + slack,
            next_sample_decides: within.is_zero(),
            next_event_decides: false,
            stay,
            watchdog,
            phase: Phase::Waiting,
            last: None,
            seen_unknown: false,
        }
    }

    /// The same window, opened by an event: without time to wait, what is said of the event is decided by the event.
    #[must_use]
    pub fn by_event(self) -> Window {
        Window { next_event_decides: self.next_sample_decides, ..self }
    }

    /// When it opened.
    pub fn opened(&self) -> Time {
        self.opened
    }

    /// The first sample of a hold, where one has begun.
    pub fn holding_since(&self) -> Option<Time> {
        match self.phase {
            Phase::Holding { since, .. } => Some(since),
            Phase::Waiting | Phase::Done(_) => None,
        }
    }

    /// Whether the end condition of an `until` matters now.
    pub fn wants_end(&self) -> bool {
        self.stay == Stay::Until && matches!(self.phase, Phase::Holding { .. })
    }

    /// What became of it so far.
    pub fn outcome(&self) -> Outcome {
        match self.phase {
            Phase::Done(outcome) => outcome,
            Phase::Waiting | Phase::Holding { .. } => Outcome::Open,
        }
    }

    /// Looks at a tick: `truth` of the condition there, `end` of the end condition where [`Window::wants_end`].
    pub fn tick(&mut self, tick: Tick, truth: Truth, end: Truth) -> Outcome {
        if !tick.kind.is_judged() {
            return self.outcome();
        }
        self.phase = match self.phase {
            Phase::Done(_) => self.phase,
            Phase::Waiting => self.waiting(tick, truth),
            Phase::Holding { since, last_sample } => self.holding(tick, truth, end, since, last_sample),
        };
        self.last = Some(tick);
        self.outcome()
    }

    fn waiting(&mut self, tick: Tick, truth: Truth) -> Phase {
        self.seen_unknown |= truth == Truth::Unknown;
        let decides = match tick.kind {
            TickKind::Sample | TickKind::BadSample => self.next_sample_decides,
            TickKind::Event => self.next_event_decides,
            TickKind::Output => false,
        };
        if truth == Truth::True && (decides || self.next_sample_decides || tick.time <= self.deadline) {
            return match self.stay {
                Stay::No => Phase::Done(Outcome::Held),
                Stay::For(length) if length.is_zero() => Phase::Done(Outcome::Held),
                Stay::For(_) | Stay::Until => Phase::Holding { since: tick.time, last_sample: tick.time },
            };
        }
        if decides {
            let undecided = truth == Truth::Unknown;
            return Phase::Done(if undecided { Outcome::Undecided } else { Outcome::Late(Some(tick)) });
        }
        if !self.next_sample_decides && tick.time > self.deadline {
            return Phase::Done(Outcome::Late(Some(tick)));
        }
        Phase::Waiting
    }

    fn holding(&mut self, tick: Tick, truth: Truth, end: Truth, since: Time, last_sample: Time) -> Phase {
        let is_sample = tick.kind == TickKind::Sample;
        if is_sample && tick.time.since(last_sample) > self.watchdog {
            return Phase::Done(Outcome::Starved(last_sample));
        }
        if self.stay == Stay::Until && end == Truth::True {
            return Phase::Done(Outcome::Held);
        }
        if let Stay::For(length) = self.stay
            && tick.time > since + length
        {
            return Phase::Done(Outcome::Held);
        }
        match truth {
            Truth::True => {
                if let Stay::For(length) = self.stay
                    && is_sample
                    && tick.time == since + length
                {
                    return Phase::Done(Outcome::Held);
                }
                Phase::Holding { since, last_sample: if is_sample { tick.time } else { last_sample } }
            }
            Truth::False => Phase::Done(Outcome::Relapsed(tick)),
            Truth::Unknown => Phase::Done(if end == Truth::Unknown && self.stay == Stay::Until {
                Outcome::Undecided
            } else {
                Outcome::Relapsed(tick)
            }),
        }
    }

    /// Lets time go by without a tick: a deadline may run out, a hold may be complete or starve.
    pub fn time(&mut self, now: Time) -> Outcome {
        self.phase = match self.phase {
            Phase::Waiting if !self.next_sample_decides && now > self.deadline => Phase::Done(Outcome::Late(self.last)),
            Phase::Holding { last_sample, .. } if now.since(last_sample) > self.watchdog => {
                Phase::Done(Outcome::Starved(last_sample))
            }
            phase => phase,
        };
        self.outcome()
    }

    /// Ends the window where the connection or the trace ends.
    pub fn cut(&mut self) -> Outcome {
        if self.outcome() == Outcome::Open {
            self.phase = Phase::Done(Outcome::Undecided);
        }
        self.outcome()
    }

    /// The next time at which [`Window::time`] may decide something.
    pub fn wake(&self) -> Option<Time> {
        match self.phase {
            Phase::Waiting if self.next_sample_decides => None,
            Phase::Waiting => Some(self.deadline + Duration::from_nanos(1)),
            Phase::Holding { last_sample, .. } => Some(last_sample + self.watchdog + Duration::from_nanos(1)),
            Phase::Done(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tick(kind: TickKind) -> Tick {
        Tick { time: Time::ZERO, frame: 0, kind }
    }

    fn window() -> Window {
        Window::open(Time::ZERO, Duration::ZERO, Duration::ZERO, Stay::No, Duration::from_millis(20))
    }

    #[test]
    fn what_is_said_of_an_event_is_decided_by_the_event() {
        let event = tick(TickKind::Event);
        assert_eq!(window().by_event().tick(event, Truth::False, Truth::False), Outcome::Late(Some(event)));
        assert_eq!(window().by_event().tick(event, Truth::True, Truth::False), Outcome::Held);
        assert_eq!(window().by_event().tick(event, Truth::Unknown, Truth::False), Outcome::Undecided);
    }

    #[test]
    fn without_time_to_wait_the_next_sample_decides_and_an_event_before_it_may() {
        let mut window = window();
        assert_eq!(window.tick(tick(TickKind::Event), Truth::False, Truth::False), Outcome::Open);
        assert_eq!(window.clone().tick(tick(TickKind::Event), Truth::True, Truth::False), Outcome::Held);
        let sample = tick(TickKind::Sample);
        assert_eq!(window.tick(sample, Truth::False, Truth::False), Outcome::Late(Some(sample)));
    }
}
