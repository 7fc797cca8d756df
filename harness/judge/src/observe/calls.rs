//! Calls that wait for their answer.

use super::ArId;
use rustc_hash::{FxHashMap, FxHasher};
use station::{Duration, Time};
use std::collections::VecDeque;
use std::hash::{Hash, Hasher};
use wire::profinet::blocks::record::WriteRequest;
use wire::profinet::rpc::Uuid;

/// Calls that are remembered; the oldest makes room.
const MOST_CALLS: usize = 256;
/// A request with the same numbers and octets is a repetition for so long.
const REPETITION: Duration = Duration::from_secs(60);
/// Copies by mirror ports and short turns of the network come within this time, whatever happened in between.
const COPY: Duration = Duration::from_millis(1);

/// A call, by its activity and sequence number.
pub(super) type CallKey = (Uuid, u32);

/// What a call asks for.
#[derive(Debug)]
pub(super) enum Asked {
    /// A connection.
    Connect(Option<ArId>),
    /// The end of a connection.
    Release(Option<ArId>),
    /// The end of the parameters.
    ParameterEnd(Option<ArId>),
    /// ApplicationReady.
    Ready(Option<ArId>),
    /// Everything else that is called Control.
    Control(Option<ArId>),
    /// A record is read: API, slot, subslot, index.
    Read(Option<ArId>, (u32, u16, u16, u16)),
    /// Records are written, several in one call or one.
    Write(Option<ArId>, Vec<WriteRequest>, bool),
    /// It could not be read, or it was answered.
    Nothing,
}

impl Asked {
    /// What is asked for, in a word.
    pub fn service(&self) -> &'static str {
        match self {
            Asked::Connect(_) => "Connect",
            Asked::Release(_) => "Release",
            Asked::ParameterEnd(_) => "end of parameters",
            Asked::Ready(_) => "ApplicationReady",
            Asked::Control(_) => "Control",
            Asked::Read(..) => "Read",
            Asked::Write(..) => "Write",
            Asked::Nothing => "call",
        }
    }

    /// The connection that is meant.
    pub fn ar(&self) -> Option<ArId> {
        match self {
            Asked::Connect(ar) | Asked::Release(ar) | Asked::ParameterEnd(ar) => *ar,
            Asked::Ready(ar) | Asked::Control(ar) => *ar,
            Asked::Read(ar, _) | Asked::Write(ar, ..) => *ar,
            Asked::Nothing => None,
        }
    }
}

#[derive(Debug)]
struct Call {
    asked: Asked,
    service: &'static str,
    ar: Option<ArId>,
    hash: u64,
    last: Time,
    answered: bool,
}

/// A request that was there before.
#[derive(Clone, Copy, Debug)]
pub(super) struct Repetition {
    /// Whether it is the same frame, seen twice.
    pub is_copy: bool,
    /// What is asked for.
    pub service: &'static str,
    /// The connection that is meant.
    pub ar: Option<ArId>,
}

/// The number of a call as others are told it.
pub(super) fn number(key: CallKey) -> u64 {
    let mut hasher = FxHasher::default();
    key.hash(&mut hasher);
    hasher.finish()
}

/// The calls of all stations.
#[derive(Debug, Default)]
pub(super) struct Calls {
    known: FxHashMap<CallKey, Call>,
    order: VecDeque<CallKey>,
}

impl Calls {
    /// Whether a request was there before; `over` says whether the connection that it meant has come to its end since.
    pub fn repetition(
        &mut self,
        key: CallKey,
        hash: u64,
        now: Time,
        over: impl Fn(ArId) -> bool,
    ) -> Option<Repetition> {
        let call = self.known.get_mut(&key).filter(|call| call.hash == hash)?;
        let since = now.since(call.last);
        let is_copy = since < COPY;
        if !is_copy && (since >= REPETITION || call.ar.is_some_and(over)) {
            return None;
        }
        call.last = now;
        Some(Repetition { is_copy, service: call.service, ar: call.ar })
    }

    /// What a call that waits for its answer asks for.
    pub fn waiting(&self, key: CallKey) -> Option<(&'static str, Option<ArId>)> {
        self.known.get(&key).filter(|call| !call.answered).map(|call| (call.service, call.ar))
    }

    /// Whether a request with these numbers came just now: a fragment of it is then a repetition.
    pub fn has_just_come(&self, key: CallKey, now: Time) -> bool {
        self.known.get(&key).is_some_and(|call| now.since(call.last) < COPY)
    }

    /// Whether the call waits for its answer.
    pub fn waits(&self, key: CallKey) -> bool {
        self.known.get(&key).is_some_and(|call| !call.answered)
    }

    /// Remembers a request.
    pub fn ask(&mut self, key: CallKey, hash: u64, now: Time, asked: Asked) {
        let (ar, service) = (asked.ar(), asked.service());
        let call = Call { ar, service, asked, hash, last: now, answered: false };
        if self.known.insert(key, call).is_none() {
            self.order.push_back(key);
            if self.order.len() > MOST_CALLS
                && let Some(oldest) = self.order.pop_front()
            {
                self.known.remove(&oldest);
            }
        }
    }

    /// Takes what a call asked for, when its answer comes; `None` where the answer was there before or nobody asked.
    pub fn answer(&mut self, key: CallKey) -> Option<Asked> {
        let call = self.known.get_mut(&key).filter(|call| !call.answered)?;
        call.answered = true;
        Some(std::mem::replace(&mut call.asked, Asked::Nothing))
    }

    /// Forgets all calls of an activity, which begins anew.
    pub fn forget(&mut self, activity: Uuid) {
        self.known.retain(|key, _| key.0 != activity);
        self.order.retain(|key| key.0 != activity);
    }
}
