//! RPC calls that wait for their response.

use super::ArId;
use rustc_hash::{FxHashMap, FxHasher};
use station::{Duration, Time};
use std::collections::VecDeque;
use std::hash::{Hash, Hasher};
use wire::profinet::blocks::record::WriteRequest;
use wire::profinet::rpc::Uuid;

/// Maximum number of stored calls; the oldest one is dropped.
const MOST_CALLS: usize = 256;
/// Within this time a request with the same activity, sequence number and bytes is a repetition.
const REPETITION: Duration = Duration::from_secs(60);
/// Within this time a repeated frame is a copy by a mirror port or a network loop.
const COPY: Duration = Duration::from_millis(1);

/// Identifies a call: activity and sequence number.
pub(super) type CallKey = (Uuid, u32);

/// The service of a pending call.
#[derive(Debug)]
pub(super) enum CallService {
    /// Connect.
    Connect(Option<ArId>),
    /// Release.
    Release(Option<ArId>),
    /// Control with PrmEnd.
    ParameterEnd(Option<ArId>),
    /// Control with ApplicationReady.
    Ready(Option<ArId>),
    /// Other Control calls.
    Control(Option<ArId>),
    /// Read of a record: API, slot, subslot, index.
    Read(Option<ArId>, (u32, u16, u16, u16)),
    /// Write of records; the flag says whether it is a multiple write.
    Write(Option<ArId>, Vec<WriteRequest>, bool),
    /// An unreadable or answered call.
    Nothing,
}

impl CallService {
    /// The name of the service.
    pub fn service(&self) -> &'static str {
        match self {
            CallService::Connect(_) => "Connect",
            CallService::Release(_) => "Release",
            CallService::ParameterEnd(_) => "end of parameters",
            CallService::Ready(_) => "ApplicationReady",
            CallService::Control(_) => "Control",
            CallService::Read(..) => "Read",
            CallService::Write(..) => "Write",
            CallService::Nothing => "call",
        }
    }

    /// The connection of the call.
    pub fn ar(&self) -> Option<ArId> {
        match self {
            CallService::Connect(ar) | CallService::Release(ar) | CallService::ParameterEnd(ar) => *ar,
            CallService::Ready(ar) | CallService::Control(ar) => *ar,
            CallService::Read(ar, _) | CallService::Write(ar, ..) => *ar,
            CallService::Nothing => None,
        }
    }
}

#[derive(Debug)]
struct TrackedCall {
    asked: CallService,
    service: &'static str,
    ar: Option<ArId>,
    hash: u64,
    last: Time,
    answered: bool,
}

/// A repeated request.
#[derive(Clone, Copy, Debug)]
pub(super) struct Repetition {
    /// Whether it is a copy of the same frame.
    pub is_copy: bool,
    /// The name of the service.
    pub service: &'static str,
    /// The connection of the call.
    pub ar: Option<ArId>,
}

/// The number of a call in [`Traffic::TrackedCall`](super::Traffic::Call).
pub(super) fn number(key: CallKey) -> u64 {
    let mut hasher = FxHasher::default();
    key.hash(&mut hasher);
    hasher.finish()
}

/// The calls of all stations.
#[derive(Debug, Default)]
pub(super) struct TrackedCalls {
    known: FxHashMap<CallKey, TrackedCall>,
    order: VecDeque<CallKey>,
}

impl TrackedCalls {
    /// Detects a repeated request; `over` returns whether the connection of the call has ended since.
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

    /// Service and connection of a call that waits for its response.
    pub fn waiting(&self, key: CallKey) -> Option<(&'static str, Option<ArId>)> {
        self.known.get(&key).filter(|call| !call.answered).map(|call| (call.service, call.ar))
    }

    /// Whether a request with this key was received within [`COPY`]; a fragment of it is then a repetition.
    pub fn has_just_come(&self, key: CallKey, now: Time) -> bool {
        self.known.get(&key).is_some_and(|call| now.since(call.last) < COPY)
    }

    /// Whether the call waits for its response.
    pub fn waits(&self, key: CallKey) -> bool {
        self.known.get(&key).is_some_and(|call| !call.answered)
    }

    /// Stores a request.
    pub fn ask(&mut self, key: CallKey, hash: u64, now: Time, asked: CallService) {
        let (ar, service) = (asked.ar(), asked.service());
        let call = TrackedCall { ar, service, asked, hash, last: now, answered: false };
        if self.known.insert(key, call).is_none() {
            self.order.push_back(key);
            if self.order.len() > MOST_CALLS
                && let Some(oldest) = self.order.pop_front()
            {
                self.known.remove(&oldest);
            }
        }
    }

    /// Marks a call as answered and returns it; `None` if it is already answered or unknown.
    pub fn answer(&mut self, key: CallKey) -> Option<CallService> {
        let call = self.known.get_mut(&key).filter(|call| !call.answered)?;
        call.answered = true;
        Some(std::mem::replace(&mut call.asked, CallService::Nothing))
    }

    /// Drops all calls of a connection.
    pub fn forget_connection(&mut self, ar: ArId) {
        self.known.retain(|_, call| call.ar != Some(ar));
        self.order.retain(|key| self.known.contains_key(key));
    }

    /// Drops all calls of an activity that restarts.
    pub fn forget(&mut self, activity: Uuid) {
        self.known.retain(|key, _| key.0 != activity);
        self.order.retain(|key| key.0 != activity);
    }
}
