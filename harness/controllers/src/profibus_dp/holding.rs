//! What the master sends while it holds the token, in which order, and for how long.
//!
//! The token holding time is the target rotation time less the real one, measured from token receipt to token receipt: TTH = TTR -
//! TRR. Messages of low priority and polls for new masters are begun within it only; of those of high priority one is sent with
//! every token, however late it is. A message that has begun is finished with its retries. The poll for a new master is the last
//! message before the token is passed. A master that is alone takes no time from others, so its holding time does not end.
//!
//! This module must not know the content of the requests. Source: IEC 61158-4-3, message cycles and token holding time.

use super::access::{Action, MediumAccess, TokenHold};
use super::job::MasterJob;
use super::master::ProfibusMaster;
use core::time::Duration;
use station::Time;
use wire::profibus::fdl::{BitTimes, LONGEST};

impl ProfibusMaster {
    /// Takes the token, which was received at `since`.
    pub(super) fn take_token(&mut self, since: Time) {
        // TRR is not measured before the second token, so the first one may be held for TTR.
        let before = self.token_received.replace(since);
        if let Some(before) = before {
            self.statistics.rotation.add(self.settings.baud.bits(since.nanos_since(before)));
        }
        let before = before.unwrap_or(since);
        let until = self.later(before, self.settings.rotation);
        let gap = self.ring.token();
        let hold = TokenHold { until, has_worked: false, has_sent_message: false, has_polled: false, gap };
        self.access = MediumAccess::Holding(hold);
    }

    /// Whether a message may be begun at `at`.
    fn may_begin(&self, hold: &TokenHold, at: Time, is_high: bool) -> bool {
        self.ring.is_alone() || at < hold.until || (is_high && !hold.has_worked)
    }

    /// When an unused token is passed on, so that the other masters see it in use within the slot time.
    fn token_pass_due(&self) -> Time {
        let half = BitTimes(self.settings.slot_time.0 / 2);
        self.later(self.silent_since, if self.ring.is_alone() { self.settings.token_pause } else { half })
    }

    /// The next action with the token, and when.
    pub(super) fn plan(&self, hold: &TokenHold) -> (Time, Action) {
        let free = self.later(self.silent_since, self.pause);
        let pass_due = if hold.has_worked { free } else { self.token_pass_due().max(free) };
        let clock = match &self.exchange {
            Some(exchange) if !self.is_clock_stopped => exchange.clock_due(self.clock_offset),
            _ => None,
        };
        let mut best = match hold.gap {
            Some(station) if self.may_begin(hold, pass_due, false) => (pass_due, Action::Gap(station)),
            _ => (pass_due, Action::Pass),
        };
        let exchange = self.exchange.as_ref().filter(|_| !self.outputs.is_paused());
        let diagnosis = self.exchange.as_ref().filter(|exchange| exchange.needs_diagnosis());
        let job = self.job.as_ref().filter(|_| !hold.has_sent_message);
        let is_high = job.is_some_and(MasterJob::is_high);
        // Of two actions due at the same time, the later one in this list wins.
        let candidates = [
            job.and_then(MasterJob::due).map(|due| (due, Action::Job, is_high)),
            diagnosis.map(|_| (free, Action::Diagnosis, true)),
            exchange.map(|exchange| (exchange.due(clock), Action::Exchange, true)),
            clock.map(|due| (due, Action::Clock, true)),
        ];
        for (due, action, is_high) in candidates.into_iter().flatten().filter(|_| !hold.has_polled) {
            let at = due.max(free);
            if at <= best.0 && self.may_begin(hold, at, is_high) {
                best = (at, action);
            }
        }
        match clock.map(|clock| (clock, clock.max(free))) {
            // The bus must be free when the clock is due.
            Some((clock, at))
                if best.1 != Action::Clock && best.0 + self.lasts(best.1) > clock && self.may_begin(hold, at, true) =>
            {
                (at, Action::Clock)
            }
            _ => best,
        }
    }

    /// How long an action keeps the bus busy, including the silence after it.
    fn lasts(&self, action: Action) -> Duration {
        let connection = self.exchange.as_ref().map(|exchange| &exchange.connection);
        let (slot, idle) = (self.settings.slot_time.0, self.settings.idle_after_answer().0);
        let bits = match action {
            Action::Clock => 0,
            Action::Pass => BitTimes::of_octets(3).0,
            // The token follows.
            Action::Gap(_) => BitTimes::of_octets(6 + 3).0 + slot + idle,
            Action::Exchange => {
                let octets = connection.map_or(0, |of| of.output_length + of.input_length);
                BitTimes::of_octets(18 + octets).0 + slot
            }
            Action::Diagnosis | Action::Job => BitTimes::of_octets(2 * LONGEST).0 + slot,
        };
        let lasts = self.time(BitTimes(bits + idle));
        let most = connection.map_or(lasts, |of| of.cycle / 4);
        lasts.min(most)
    }

    /// Records, as the token is passed at `now`, that its holding time was too short for a request that is due.
    pub(super) fn note_starvation(&mut self, now: Time, hold: &TokenHold) {
        let job = self.job.as_ref().filter(|_| !hold.has_sent_message);
        let is_due = job.and_then(MasterJob::due).is_some_and(|due| due <= now);
        if is_due && self.starved_since.is_none() {
            self.starved_since = Some(now);
        }
    }
}
