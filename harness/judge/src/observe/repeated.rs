//! Frames that a mirror port shows twice.

use rustc_hash::FxHasher;
use station::{Duration, Time};
use std::hash::Hasher;
use wire::ethernet::FrameHeader;

/// Two frames with the same octets that are closer together than this are one.
const MIRROR: Duration = Duration::from_millis(1);

/// The last frames that were no cyclic ones.
#[derive(Debug, Default)]
pub(super) struct Repeated {
    last: [Option<(u64, Time)>; 16],
    next: usize,
}

impl Repeated {
    /// Whether the same addresses and payload were there less than a millisecond ago; tags come and go and do not count.
    pub fn is(&mut self, time: Time, header: &FrameHeader, payload: &[u8]) -> bool {
        let mut hasher = FxHasher::default();
        hasher.write(&header.destination.0);
        hasher.write(&header.source.0);
        hasher.write(payload);
        let hash = hasher.finish();
        // A time that goes backwards says that the frames are from different sources.
        let same = |(known, at): &(u64, Time)| *known == hash && time >= *at && time.since(*at) < MIRROR;
        if self.last.iter().flatten().any(same) {
            return true;
        }
        self.last[self.next] = Some((hash, time));
        self.next = (self.next + 1) % self.last.len();
        false
    }
}
