//! A compact store of the frames on a wire.

use station::Time;

use crate::wire::TappedFrame;

/// The frames of one trial in order of arrival, with all bytes in one growing buffer. Frames are numbered from 1, as in
/// Wireshark, so that a number in a report is the number in the saved capture.
#[derive(Clone, Debug, Default)]
pub struct Trace {
    octets: Vec<u8>,
    entries: Vec<TraceEntry>,
    /// Comments by frame number, ascending.
    comments: Vec<(usize, String)>,
}

/// One frame of a [`Trace`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TraceFrame<'a> {
    /// Its number in the trace, from 1.
    pub number: usize,
    /// Arrival time.
    pub time: Time,
    /// The port that sent it.
    pub port: usize,
    /// Its bytes from the destination address, without frame check sequence.
    pub octets: &'a [u8],
    /// The comment on the frame.
    pub comment: Option<&'a str>,
}

#[derive(Clone, Copy, Debug)]
struct TraceEntry {
    time: Time,
    port: usize,
    end: usize,
}

impl Trace {
    /// An empty trace.
    pub fn new() -> Trace {
        Trace::default()
    }

    /// An empty trace with capacity for `frames` frames of `octets` bytes in total.
    pub fn with_room(frames: usize, octets: usize) -> Trace {
        let (octets, entries) = (Vec::with_capacity(octets), Vec::with_capacity(frames));
        Trace { octets, entries, comments: Vec::new() }
    }

    /// Stores a frame and returns its number.
    #[inline]
    pub fn push(&mut self, time: Time, port: usize, octets: &[u8]) -> usize {
        self.octets.extend_from_slice(octets);
        self.entries.push(TraceEntry { time, port, end: self.octets.len() });
        self.entries.len()
    }

    /// Stores a frame from the tap of a wire and returns its number.
    #[inline]
    pub fn push_tapped(&mut self, seen: TappedFrame<'_>) -> usize {
        self.push(seen.time, seen.port, seen.frame)
    }

    /// Adds a comment to frame `number`, after existing comments. The frame may be a future one: `trace.len() + 1` marks where a
    /// step begins.
    pub fn comment(&mut self, number: usize, text: &str) {
        match self.comments.binary_search_by_key(&number, |(of, _)| *of) {
            Ok(at) => {
                let noted = &mut self.comments[at].1;
                if !noted.is_empty() {
                    noted.push('\n');
                }
                noted.push_str(text);
            }
            Err(at) => self.comments.insert(at, (number, text.to_owned())),
        }
    }

    /// The frame with this number; `None` for 0 and for numbers beyond the end.
    #[inline]
    pub fn get(&self, number: usize) -> Option<TraceFrame<'_>> {
        let index = number.checked_sub(1)?;
        let entry = self.entries.get(index)?;
        let start = index.checked_sub(1).map_or(0, |before| self.entries[before].end);
        Some(TraceFrame {
            number,
            time: entry.time,
            port: entry.port,
            octets: &self.octets[start..entry.end],
            comment: if number > self.last_comment() { None } else { self.comment_of(number) },
        })
    }

    /// The number of the last frame with a comment; most lookups are for later frames.
    #[inline]
    fn last_comment(&self) -> usize {
        self.comments.last().map_or(0, |(number, _)| *number)
    }

    fn comment_of(&self, number: usize) -> Option<&str> {
        let at = self.comments.binary_search_by_key(&number, |(of, _)| *of).ok()?;
        Some(&self.comments[at].1)
    }

    /// The frames from the first to the last.
    pub fn iter(&self) -> impl DoubleEndedIterator<Item = TraceFrame<'_>> {
        (1..=self.len()).filter_map(|number| self.get(number))
    }

    /// Number of frames, which is also the number of the last one.
    #[inline]
    pub fn len(&self) -> usize {
        self.entries.len()
    }

    /// Whether there are no frames.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Removes all frames and comments and retains the memory.
    pub fn clear(&mut self) {
        self.octets.clear();
        self.entries.clear();
        self.comments.clear();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_returned_complete_by_number() {
        let mut trace = Trace::new();
        trace.comment(2, "step 1");
        assert_eq!(trace.push(Time::from_nanos(5), 0, &[1, 2, 3]), 1);
        assert_eq!(trace.push(Time::from_nanos(7), 1, &[4]), 2);
        trace.comment(2, "expect");

        let second =
            TraceFrame { number: 2, time: Time::from_nanos(7), port: 1, octets: &[4], comment: Some("step 1\nexpect") };
        assert_eq!(trace.get(2), Some(second));
        assert_eq!(trace.get(0), None);
        assert_eq!(trace.get(3), None);
        let octets: Vec<&[u8]> = trace.iter().map(|frame| frame.octets).collect();
        assert_eq!(octets, [&[1u8, 2, 3][..], &[4]]);
        trace.clear();
        assert!(trace.is_empty() && trace.get(1).is_none());
    }
}
