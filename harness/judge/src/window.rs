//! A time window in which a condition has to become true, and a hold time for which it has to stay true.
//!
//! Used for `expect` in a case and `then` in a rule, which have the same meaning ("Time" of `docs/suite-language.md`).

use super::{JudgeTick, TickKind, Truth};
use station::{Duration, Time};

/// Resolution of time: a deadline has passed one step after it.
const TIME_STEP: Duration = Duration::from_nanos(1);

/// How long the condition has to stay true after it became true.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stay {
    /// One sample is enough.
    No,
    /// This long from the first sample at which it was true.
    For(Duration),
    /// Up to the first sample at which the end condition is true.
    Until,
}

/// The outcome of a window.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum WindowOutcome {
    /// Not decided yet.
    Open,
    /// The condition became true in time and stayed true.
    Held,
    /// The condition did not become true in time; the tick is the last one before the deadline, or before the last chance where
    /// the window is patient.
    Late(Option<JudgeTick>),
    /// The condition became false during the hold time.
    Relapsed(JudgeTick),
    /// No sample was received for longer than the watchdog time during the hold time.
    Starved(Time),
    /// The condition of a rule was unknown when it had to be true, or the connection ended first.
    Undecided,
}

/// A time window for a condition.
///
/// The window starts at `opened`; the caller passes every tick and the current time.
#[derive(Clone, Debug)]
pub struct TimeWindow {
    opened: Time,
    /// Up to here the condition becomes true in time.
    deadline: Time,
    /// Up to here it may become true.
    last_chance: Time,
    /// When the condition became true, if that was after the deadline.
    became_true: Option<Time>,
    next_sample_decides: bool,
    next_event_decides: bool,
    stay: Stay,
    watchdog: Duration,
    phase: WindowPhase,
    last: Option<JudgeTick>,
    last_truth: Truth,
    unknown_is_late: bool,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum WindowPhase {
    Waiting,
    Holding { since: Time, last_sample: Time },
    Done(WindowOutcome),
}

impl TimeWindow {
    /// A window that opens at `opened`: the condition has to be true at a sample at most `within` later (zero: at the next
    /// sample), then to `stay` true. A hold without samples for longer than `watchdog` is starved.
    ///
    /// This is the window of an `expect`: an unknown condition counts as false.
    pub fn open(opened: Time, within: Duration, slack: Duration, stay: Stay, watchdog: Duration) -> TimeWindow {
        TimeWindow {
            opened,
            deadline: opened + within + slack,
            last_chance: opened + within + slack,
            became_true: None,
            next_sample_decides: within.is_zero(),
            next_event_decides: false,
            stay,
            watchdog,
            phase: WindowPhase::Waiting,
            last: None,
            last_truth: Truth::False,
            unknown_is_late: true,
        }
    }

    /// Gives the condition time up to `patient` after the begin, since no manual prints the deadline; [`slow`](Self::slow) tells
    /// whether it needed it.
    #[must_use]
    pub fn patient(self, patient: Duration, slack: Duration) -> TimeWindow {
        TimeWindow { last_chance: self.last_chance.max(self.opened + patient + slack), ..self }
    }

    /// Takes back the patience: nothing can come any more.
    pub fn be_strict(&mut self) {
        self.last_chance = self.deadline;
    }

    /// Whether the deadline has passed and only the patience lasts.
    pub fn is_late(&self, now: Time) -> bool {
        self.phase == WindowPhase::Waiting && !self.next_sample_decides && now > self.deadline
    }

    /// How long the condition took, if it became true after the deadline but not too late.
    pub fn slow(&self) -> Option<Duration> {
        Some(self.became_true?.since(self.opened))
    }

    /// Converts it to the window of a `then`: an unknown condition leaves the rule undecided, and only a sample after the deadline shows
    /// that the condition is late. A device that was switched off, or whose frames are lost, is not accused of an old value.
    #[must_use]
    pub fn of_rule(self) -> TimeWindow {
        TimeWindow { unknown_is_late: false, ..self }
    }

    /// Converts it to a window opened by an event: with a deadline of zero the event itself decides.
    #[must_use]
    pub fn by_event(self) -> TimeWindow {
        TimeWindow { next_event_decides: self.next_sample_decides, ..self }
    }

    /// Whether the end condition of an `until` has to be evaluated now.
    pub fn needs_end(&self) -> bool {
        self.stay == Stay::Until && !matches!(self.phase, WindowPhase::Done(_))
    }

    /// Whether both windows will have the same outcome for all later ticks and times; only how slow they are can differ.
    pub fn is_like(&self, other: &TimeWindow) -> bool {
        let same_phase = match (self.phase, other.phase) {
            (WindowPhase::Waiting, WindowPhase::Waiting) if self.next_sample_decides => true,
            (WindowPhase::Waiting, WindowPhase::Waiting) => {
                (self.deadline, self.last_chance) == (other.deadline, other.last_chance)
            }
            (WindowPhase::Holding { last_sample: one, .. }, WindowPhase::Holding { last_sample: two, .. })
                if self.stay == Stay::Until =>
            {
                one == two
            }
            (one, two) => one == two,
        };
        let nature = |window: &TimeWindow| {
            let TimeWindow { next_sample_decides, next_event_decides, stay, watchdog, unknown_is_late, .. } = *window;
            (next_sample_decides, next_event_decides, stay, watchdog, unknown_is_late)
        };
        same_phase && nature(self) == nature(other)
    }

    /// The outcome so far.
    pub fn outcome(&self) -> WindowOutcome {
        match self.phase {
            WindowPhase::Done(outcome) => outcome,
            WindowPhase::Waiting | WindowPhase::Holding { .. } => WindowOutcome::Open,
        }
    }

    /// Processes a tick with the truth of the condition and, if [`TimeWindow::needs_end`], of the end condition.
    pub fn tick(&mut self, tick: JudgeTick, truth: Truth, end: Truth) -> WindowOutcome {
        if !tick.kind.is_judged() {
            return self.outcome();
        }
        let before = self.phase;
        self.phase = match before {
            WindowPhase::Done(_) => before,
            WindowPhase::Waiting => self.waiting(tick, truth, end),
            WindowPhase::Holding { since, last_sample } => self.holding(tick, truth, end, since, last_sample),
        };
        if before == WindowPhase::Waiting
            && truth == Truth::True
            && tick.time > self.deadline
            && tick.time <= self.last_chance
            && !self.next_sample_decides
        {
            self.became_true = Some(tick.time);
        }
        self.last = Some(tick);
        self.last_truth = truth;
        self.outcome()
    }

    fn waiting(&self, tick: JudgeTick, truth: Truth, end: Truth) -> WindowPhase {
        let is_sample = matches!(tick.kind, TickKind::Sample | TickKind::BadSample);
        let decides = match tick.kind {
            TickKind::Sample | TickKind::BadSample => self.next_sample_decides,
            TickKind::Event => self.next_event_decides,
            TickKind::Output => false,
        };
        if truth == Truth::True && (decides || self.next_sample_decides || tick.time <= self.last_chance) {
            return match self.stay {
                Stay::No => WindowPhase::Done(WindowOutcome::Held),
                Stay::For(length) if length.is_zero() => WindowPhase::Done(WindowOutcome::Held),
                Stay::Until if end == Truth::True => WindowPhase::Done(WindowOutcome::Held),
                Stay::For(_) | Stay::Until => WindowPhase::Holding { since: tick.time, last_sample: tick.time },
            };
        }
        if decides {
            return WindowPhase::Done(self.unless_unknown(truth, WindowOutcome::Late(Some(tick))));
        }
        if !self.next_sample_decides && tick.time > self.last_chance && (self.unknown_is_late || is_sample) {
            return WindowPhase::Done(
                self.unless_unknown(self.last_truth, WindowOutcome::Late(self.last.or(Some(tick)))),
            );
        }
        WindowPhase::Waiting
    }

    /// Returns `wrong`, or undecided if the condition of a rule is unknown.
    fn unless_unknown(&self, truth: Truth, wrong: WindowOutcome) -> WindowOutcome {
        if truth == Truth::Unknown && !self.unknown_is_late { WindowOutcome::Undecided } else { wrong }
    }

    fn holding(&self, tick: JudgeTick, truth: Truth, end: Truth, since: Time, last_sample: Time) -> WindowPhase {
        let is_sample = tick.kind == TickKind::Sample;
        if tick.time.since(last_sample) > self.watchdog {
            return WindowPhase::Done(WindowOutcome::Starved(last_sample));
        }
        if self.stay == Stay::Until && end == Truth::True {
            return WindowPhase::Done(WindowOutcome::Held);
        }
        // The end may have come, and what follows may belong to it.
        if self.stay == Stay::Until && end == Truth::Unknown && !self.unknown_is_late {
            return WindowPhase::Done(WindowOutcome::Undecided);
        }
        if let Stay::For(length) = self.stay
            && tick.time > since + length
        {
            // An event does not prove that cyclic data were received up to now; a frame has to.
            return match tick.kind {
                TickKind::Sample | TickKind::BadSample => WindowPhase::Done(WindowOutcome::Held),
                TickKind::Event | TickKind::Output => self.phase,
            };
        }
        match truth {
            Truth::True => {
                if let Stay::For(length) = self.stay
                    && is_sample
                    && tick.time == since + length
                {
                    return WindowPhase::Done(WindowOutcome::Held);
                }
                WindowPhase::Holding { since, last_sample: if is_sample { tick.time } else { last_sample } }
            }
            Truth::False | Truth::Unknown => {
                WindowPhase::Done(self.unless_unknown(truth, WindowOutcome::Relapsed(tick)))
            }
        }
    }

    /// Advances time without a tick: a deadline may expire, a hold may be complete or starve.
    pub fn time(&mut self, now: Time) -> WindowOutcome {
        self.phase = match self.phase {
            WindowPhase::Waiting if self.unknown_is_late && !self.next_sample_decides && now > self.last_chance => {
                WindowPhase::Done(self.unless_unknown(self.last_truth, WindowOutcome::Late(self.last)))
            }
            WindowPhase::Holding { last_sample, .. } if now.since(last_sample) > self.watchdog => {
                WindowPhase::Done(WindowOutcome::Starved(last_sample))
            }
            phase => phase,
        };
        self.outcome()
    }

    /// Ends the window at the end of the connection or trace.
    pub fn cut(&mut self) -> WindowOutcome {
        if self.outcome() == WindowOutcome::Open {
            self.phase = WindowPhase::Done(WindowOutcome::Undecided);
        }
        self.outcome()
    }

    /// The next time at which [`TimeWindow::time`] may decide something.
    pub fn wake(&self) -> Option<Time> {
        match self.phase {
            WindowPhase::Waiting if self.next_sample_decides || !self.unknown_is_late => None,
            WindowPhase::Waiting => Some(self.last_chance + TIME_STEP),
            WindowPhase::Holding { last_sample, .. } => Some(last_sample + self.watchdog + TIME_STEP),
            WindowPhase::Done(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tick(kind: TickKind) -> JudgeTick {
        JudgeTick { time: Time::ZERO, frame: 0, kind }
    }

    fn window() -> TimeWindow {
        TimeWindow::open(Time::ZERO, Duration::ZERO, Duration::ZERO, Stay::No, Duration::from_millis(20))
    }

    fn at(millis: u64, kind: TickKind) -> JudgeTick {
        JudgeTick { time: Time::ZERO + Duration::from_millis(millis), frame: 0, kind }
    }

    fn within(millis: u64, stay: Stay) -> TimeWindow {
        let within = Duration::from_millis(millis);
        TimeWindow::open(Time::ZERO, within, Duration::ZERO, stay, Duration::from_millis(20))
    }

    #[test]
    fn a_condition_on_an_event_is_decided_by_the_event() {
        let event = tick(TickKind::Event);
        let window = || window().of_rule().by_event();
        assert_eq!(window().tick(event, Truth::False, Truth::False), WindowOutcome::Late(Some(event)));
        assert_eq!(window().tick(event, Truth::True, Truth::False), WindowOutcome::Held);
        assert_eq!(window().tick(event, Truth::Unknown, Truth::False), WindowOutcome::Undecided);
    }

    #[test]
    fn an_unknown_condition_is_late_in_a_case_and_undecided_in_a_rule() {
        let sample = at(2, TickKind::BadSample);
        assert_eq!(window().tick(sample, Truth::Unknown, Truth::False), WindowOutcome::Late(Some(sample)));
        assert_eq!(window().of_rule().tick(sample, Truth::Unknown, Truth::False), WindowOutcome::Undecided);
        let late = Time::ZERO + Duration::from_millis(11);
        for (observed, case, rule) in [
            (
                [Truth::False, Truth::Unknown],
                WindowOutcome::Late(Some(at(4, TickKind::BadSample))),
                WindowOutcome::Undecided,
            ),
            (
                [Truth::Unknown, Truth::False],
                WindowOutcome::Late(Some(at(4, TickKind::BadSample))),
                WindowOutcome::Late(Some(at(4, TickKind::BadSample))),
            ),
        ] {
            for (mut window, expected) in [(within(10, Stay::No), case), (within(10, Stay::No).of_rule(), rule)] {
                window.tick(at(2, TickKind::BadSample), observed[0], Truth::False);
                window.tick(at(4, TickKind::BadSample), observed[1], Truth::False);
                assert_eq!(
                    window.clone().time(late),
                    if window.unknown_is_late { expected } else { WindowOutcome::Open }
                );
                let frame = at(11, TickKind::Sample);
                let by_frame = window.tick(frame, Truth::True, Truth::False);
                assert_eq!(by_frame == WindowOutcome::Undecided, expected == WindowOutcome::Undecided);
                assert_ne!(by_frame, WindowOutcome::Held);
            }
        }
    }

    /// The last sample is older than the deadline: the device may have been switched off since, or its frames are lost.
    #[test]
    fn without_a_sample_after_the_deadline_a_case_is_late_and_a_rule_is_undecided() {
        let (before, after) = (at(8, TickKind::Sample), at(14, TickKind::Sample));
        let mut case = within(10, Stay::No);
        let mut rule = within(10, Stay::No).of_rule();
        for window in [&mut case, &mut rule] {
            window.tick(before, Truth::False, Truth::False);
        }
        let late = Time::ZERO + Duration::from_millis(12);
        assert_eq!(case.time(late), WindowOutcome::Late(Some(before)));
        assert_eq!(rule.time(late), WindowOutcome::Open);
        assert_eq!(rule.clone().cut(), WindowOutcome::Undecided);
        assert_eq!(rule.tick(after, Truth::False, Truth::False), WindowOutcome::Late(Some(before)));
    }

    #[test]
    fn a_hold_that_becomes_unknown_relapses_in_a_case_and_is_undecided_in_a_rule() {
        let (first, bad) = (at(2, TickKind::Sample), at(4, TickKind::BadSample));
        for stay in [Stay::For(Duration::from_millis(10)), Stay::Until] {
            for end in [Truth::False, Truth::Unknown] {
                let (mut case, mut rule) = (within(10, stay), within(10, stay).of_rule());
                case.tick(first, Truth::True, Truth::False);
                rule.tick(first, Truth::True, Truth::False);
                assert_eq!(case.tick(bad, Truth::Unknown, end), WindowOutcome::Relapsed(bad));
                assert_eq!(rule.tick(bad, Truth::Unknown, end), WindowOutcome::Undecided);
            }
        }
    }

    #[test]
    fn an_end_condition_at_the_first_true_sample_completes_the_hold() {
        let mut window = within(10, Stay::Until);
        assert!(window.needs_end());
        assert_eq!(window.tick(at(2, TickKind::Sample), Truth::True, Truth::True), WindowOutcome::Held);
    }

    #[test]
    fn an_event_neither_completes_a_hold_nor_prevents_starving() {
        let hold = Stay::For(Duration::from_millis(10));
        let begun = || {
            let mut window = within(10, hold);
            window.tick(at(2, TickKind::Sample), Truth::True, Truth::False);
            window
        };
        let starved = WindowOutcome::Starved(at(2, TickKind::Sample).time);
        assert_eq!(begun().tick(at(23, TickKind::Event), Truth::True, Truth::False), starved);
        let mut window = begun();
        assert_eq!(window.tick(at(15, TickKind::Event), Truth::True, Truth::False), WindowOutcome::Open);
        assert_eq!(window.clone().time(at(23, TickKind::Event).time), starved);
        assert_eq!(window.tick(at(16, TickKind::Sample), Truth::True, Truth::False), WindowOutcome::Held);
    }

    fn patient(within_millis: u64, at_most: u64, stay: Stay) -> TimeWindow {
        within(within_millis, stay).patient(Duration::from_millis(at_most), Duration::ZERO)
    }

    #[test]
    fn what_comes_after_a_deadline_of_ours_is_slow_and_holds() {
        let slow = |at_millis| {
            let mut window = patient(10, 100, Stay::No);
            let outcome = window.tick(at(at_millis, TickKind::Sample), Truth::True, Truth::False);
            (outcome, window.slow())
        };
        assert_eq!(slow(10), (WindowOutcome::Held, None));
        assert_eq!(slow(11), (WindowOutcome::Held, Some(Duration::from_millis(11))));
        assert_eq!(slow(100), (WindowOutcome::Held, Some(Duration::from_millis(100))));
        let late = WindowOutcome::Late(Some(at(101, TickKind::Sample)));
        assert_eq!(slow(101), (late, None));
    }

    #[test]
    fn a_patient_window_fails_only_after_its_last_chance() {
        let mut window = patient(10, 100, Stay::No);
        assert_eq!(window.wake(), Some(at(100, TickKind::Sample).time + TIME_STEP));
        window.tick(at(8, TickKind::Sample), Truth::False, Truth::False);
        assert_eq!(window.time(at(100, TickKind::Sample).time), WindowOutcome::Open);
        window.tick(at(98, TickKind::Sample), Truth::False, Truth::False);
        assert_eq!(window.time(at(101, TickKind::Sample).time), WindowOutcome::Late(Some(at(98, TickKind::Sample))));
    }

    #[test]
    fn a_hold_after_a_late_begin_is_as_long_as_any() {
        let mut window = patient(10, 100, Stay::For(Duration::from_millis(10)));
        assert_eq!(window.tick(at(95, TickKind::Sample), Truth::True, Truth::False), WindowOutcome::Open);
        assert_eq!(window.clone().tick(at(104, TickKind::Sample), Truth::False, Truth::False), {
            WindowOutcome::Relapsed(at(104, TickKind::Sample))
        });
        assert_eq!(window.tick(at(105, TickKind::Sample), Truth::True, Truth::False), WindowOutcome::Held);
        assert_eq!(window.slow(), Some(Duration::from_millis(95)));
    }

    #[test]
    fn the_slack_of_a_line_makes_nothing_slow() {
        let (within, slack) = (Duration::from_millis(10), Duration::from_millis(5));
        let open = || TimeWindow::open(Time::ZERO, within, slack, Stay::No, within).patient(within * 10, slack);
        let mut window = open();
        window.tick(at(15, TickKind::Sample), Truth::True, Truth::False);
        assert_eq!(window.slow(), None);
        let mut window = open();
        window.tick(at(16, TickKind::Sample), Truth::True, Truth::False);
        assert_eq!(window.slow(), Some(Duration::from_millis(16)));
        assert_eq!(open().tick(at(105, TickKind::Sample), Truth::True, Truth::False), WindowOutcome::Held);
        assert_ne!(open().tick(at(106, TickKind::Sample), Truth::True, Truth::False), WindowOutcome::Held);
    }

    #[test]
    fn windows_with_other_patience_are_not_alike() {
        let (strict, patient) = (within(10, Stay::No), patient(10, 100, Stay::No));
        assert!(!strict.is_like(&patient));
        assert!(patient.is_like(&patient.clone()));
    }

    #[test]
    fn with_a_zero_deadline_the_next_sample_or_an_earlier_event_decides() {
        let mut window = window();
        assert_eq!(window.tick(tick(TickKind::Event), Truth::False, Truth::False), WindowOutcome::Open);
        assert_eq!(window.clone().tick(tick(TickKind::Event), Truth::True, Truth::False), WindowOutcome::Held);
        let sample = tick(TickKind::Sample);
        assert_eq!(window.tick(sample, Truth::False, Truth::False), WindowOutcome::Late(Some(sample)));
    }
}
