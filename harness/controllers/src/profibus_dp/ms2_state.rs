//! What the master keeps of its connection as a class 2 master: when Idle is due, and how the connection ended.
//!
//! Idle is a job like any other, but it has no outcome for the caller. A request that arrives meanwhile waits until it is answered.

use super::acyclic::AcyclicTiming;
use super::job::MasterJob;
use super::master::{POLL, ProfibusMaster};
use super::ms2::{Class2Connection, Ms2Job, Ms2Result};
use super::ms2_outcome::Ms2Outcome;
use super::outcome::MasterOutcome;
use super::request::MasterRequest;
use alloc::boxed::Box;
use station::Time;

/// The state of MS2.
#[derive(Debug, Default)]
pub(super) struct Ms2State {
    pub connection: Option<Class2Connection>,
    /// When Idle is due, while a connection stands.
    idle_at: Option<Time>,
    /// Whether the current job is Idle.
    pub is_idle: bool,
    /// A request that waits for the answer to Idle, and since when.
    pub queued: Option<(Time, MasterRequest)>,
    end: Option<Ms2Outcome>,
}

impl ProfibusMaster {
    /// The slave with which a connection of a class 2 master stands.
    pub fn ms2_slave(&self) -> Option<u8> {
        self.ms2.connection.map(|connection| connection.to)
    }

    /// Takes the reason why the connection of a class 2 master ended without a request, once.
    pub fn take_ms2_end(&mut self) -> Option<Ms2Outcome> {
        self.ms2.end.take()
    }

    /// Begins an Idle that is due, if the master has nothing else to do.
    pub(super) fn keep_ms2(&mut self, now: Time) {
        let is_free = self.job.is_none() && self.due.is_none();
        if let Some(connection) = self.ms2.connection
            && is_free
            && self.ms2.idle_at.is_some_and(|due| now >= due)
        {
            let pace = AcyclicTiming { poll: POLL, patience: self.settings.acyclic };
            self.job = Some(MasterJob::Ms2(Box::new(Ms2Job::idle(now, pace, connection))));
            self.ms2.is_idle = true;
            self.waiting_since = now;
        }
    }

    /// Ends a job on MS2.
    pub(super) fn ms2_done(&mut self, now: Time, result: Ms2Result) {
        let Ms2Result { connection, outcome } = result;
        self.ms2.connection = connection;
        self.ms2.idle_at = connection.map(|connection| connection.idle_due(now));
        if self.ms2.is_idle && connection.is_none() {
            self.ms2.end = Some(outcome.clone());
        }
        self.conclude(MasterOutcome::Ms2(outcome));
    }
}
