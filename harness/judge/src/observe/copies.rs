//! Detects copies of frames by mirror ports.

use rustc_hash::FxHasher;
use station::{Duration, Time};
use std::hash::Hasher;
use wire::ethernet::FrameHeader;

/// Within this time, a frame with the same bytes is a copy.
const MIRROR: Duration = Duration::from_millis(1);

/// The last acyclic frames.
#[derive(Debug, Default)]
pub(super) struct CopyDetector {
    last: [Option<(u64, Time)>; 16],
    next: usize,
}

impl CopyDetector {
    /// Whether a frame with the same addresses and payload was received within [`MIRROR`]; VLAN tags are ignored.
    pub fn is(&mut self, time: Time, header: &FrameHeader, payload: &[u8]) -> bool {
        let mut hasher = FxHasher::default();
        hasher.write(&header.destination.0);
        hasher.write(&header.source.0);
        hasher.write(payload);
        let hash = hasher.finish();
        // A time that goes backwards means that the frames are from different sources.
        let same = |(known, at): &(u64, Time)| *known == hash && time >= *at && time.since(*at) < MIRROR;
        if self.last.iter().flatten().any(same) {
            return true;
        }
        self.last[self.next] = Some((hash, time));
        self.next = (self.next + 1) % self.last.len();
        false
    }
}
