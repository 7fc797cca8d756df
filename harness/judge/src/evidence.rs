//! Evidence in recordings: a bit flipped by the capture looks like a bit set by the device, so a single frame does not prove a
//! violation.
//!
//! [`Blips`] finds bits that change in one frame only. [`Suspicion`] holds a violation that one frame shows until a later frame
//! confirms it. Runs of the harness itself do not need this.

use super::Truth;
use super::image::ConnectionImage;
use super::view::NameView;
use super::violation::RuleViolation;
use crate::observe::FrameDirection;
use suite::device::NameKind;
use suite::model::Condition;

/// Number of changing frames in which a bit must be constant to count as stable.
const STILL: usize = 4;
/// Number of single frames that together prove a violation.
const PROOF: u32 = 3;

/// Finds bits that changed in one frame only.
#[derive(Debug, Default)]
pub struct Blips {
    to_controller: Past,
    to_device: Past,
}

/// The changes of the last frames of a direction.
#[derive(Debug, Default)]
struct Past {
    last: Vec<u64>,
    last_frame: u64,
    /// The changes of the changing frames before the last one.
    before: [Vec<u64>; STILL],
    next: usize,
    /// Bits that changed back, and the frame that had changed them.
    back: Vec<u64>,
    back_frame: u64,
}

/// Stable bits that changed in one frame and changed back in the next one of the same direction.
#[derive(Clone, Copy, Debug)]
pub struct Blip<'a> {
    /// Number of the frame with the changed bits.
    pub frame: u64,
    pub direction: FrameDirection,
    /// The bits of the data area, eight bytes per word, the first byte lowest.
    pub bits: &'a [u64],
}

impl Blips {
    /// Processes the change of frame number `frame`.
    pub fn take(&mut self, image: &ConnectionImage, frame: u64) -> Option<Blip<'_>> {
        let change = image.change()?;
        let past = match change.direction {
            FrameDirection::ToController => &mut self.to_controller,
            FrameDirection::ToDevice => &mut self.to_device,
        };
        let found = past.take(change.bits, frame);
        found.then_some(Blip { frame: past.back_frame, direction: change.direction, bits: &past.back })
    }

    /// Clears the memory, after missing frames.
    pub fn forget(&mut self) {
        *self = Blips::default();
    }
}

impl Past {
    /// Processes the changed bits; returns whether stable bits have changed back.
    fn take(&mut self, bits: &[u64], frame: u64) -> bool {
        let changes = bits.iter().any(|&word| word != 0);
        if self.last.iter().all(|&word| word == 0) {
            if changes {
                self.replace(bits, frame);
            }
            return false;
        }
        let is_still =
            |place: usize| !self.before.iter().filter_map(|of| of.get(place)).fold(0, |all, word| all | word);
        self.back.clear();
        let pairs = self.last.iter().zip(bits).enumerate();
        self.back.extend(pairs.map(|(place, (before, now))| before & now & is_still(place)));
        let found = self.back.iter().any(|&word| word != 0);
        self.back_frame = self.last_frame;
        let place = self.next;
        std::mem::swap(&mut self.before[place], &mut self.last);
        self.next = (place + 1) % STILL;
        self.replace(bits, frame);
        found
    }

    fn replace(&mut self, bits: &[u64], frame: u64) {
        self.last.clear();
        self.last.extend_from_slice(bits);
        self.last_frame = frame;
    }
}

/// The evidence for a violation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Evidence {
    /// Several consecutive frames.
    Frames,
    /// One frame; the next one confirms or refutes it.
    Frame,
    /// One frame that is not repeated, or the absence of an expected frame.
    Once,
}

/// Violations of a rule shown by single frames.
#[derive(Debug, Default)]
pub struct Suspicion {
    suspect: Option<Suspect>,
    alone: Option<RuleViolation>,
    times: u32,
}

/// A violation that waits for its confirmation.
#[derive(Debug)]
struct Suspect {
    violation: RuleViolation,
    /// The last frame of each direction at that time.
    frames: [Option<u64>; 2],
}

/// The state of a violation.
#[derive(Debug)]
pub enum SuspicionState {
    /// Proven.
    Proven(Box<RuleViolation>),
    /// Shown by one frame only.
    Alone,
    /// Waiting for the next frames.
    Open,
}

impl Suspicion {
    /// The first violation that only one frame shows.
    pub fn alone(&self) -> Option<&RuleViolation> {
        self.alone.as_ref()
    }

    /// Whether a violation waits for its confirmation.
    pub fn is_open(&self) -> bool {
        self.suspect.is_some()
    }

    /// Adds a violation.
    pub fn add(&mut self, violation: RuleViolation, evidence: Evidence, image: &ConnectionImage) -> SuspicionState {
        match evidence {
            Evidence::Frames => SuspicionState::Proven(Box::new(violation)),
            Evidence::Frame if self.suspect.is_some() => SuspicionState::Open,
            Evidence::Frame => {
                self.suspect = Some(Suspect { violation, frames: image.last_frames() });
                SuspicionState::Open
            }
            Evidence::Once => self.keep_unconfirmed(violation),
        }
    }

    /// Checks a later frame: a waiting violation is confirmed if the condition does not hold in this frame either.
    pub fn confirm(&mut self, image: &ConnectionImage, truth: impl FnOnce() -> Truth) -> SuspicionState {
        let Some(suspect) = &self.suspect else { return SuspicionState::Open };
        let is_renewed =
            suspect.frames.iter().zip(image.last_frames()).all(|(then, now)| then.is_none() || now > *then);
        match (is_renewed, if is_renewed { truth() } else { Truth::Unknown }) {
            (false, _) | (_, Truth::Unknown) => SuspicionState::Open,
            (true, Truth::False) => match self.suspect.take() {
                Some(suspect) => SuspicionState::Proven(Box::new(suspect.violation)),
                None => SuspicionState::Open,
            },
            (true, Truth::True) => self.give_up(0),
        }
    }

    /// Gives up a waiting violation that is based on frame `since` or a later one.
    pub fn give_up(&mut self, since: u64) -> SuspicionState {
        let rests = |suspect: &mut Suspect| suspect.violation.rests_on() >= since;
        match self.suspect.take_if(rests) {
            Some(suspect) => self.keep_unconfirmed(suspect.violation),
            None => SuspicionState::Open,
        }
    }

    fn keep_unconfirmed(&mut self, violation: RuleViolation) -> SuspicionState {
        self.times += 1;
        let first = self.alone.get_or_insert(violation);
        if self.times >= PROOF { SuspicionState::Proven(Box::new(first.clone())) } else { SuspicionState::Alone }
    }
}

/// Whether a condition uses an event, which only one frame carries.
pub fn uses_events(condition: &Condition, view: &NameView<'_>) -> bool {
    let mut found = false;
    condition.each_name(&mut |name| {
        found |= matches!(view.variant.names.get(name.0 as usize), Some(NameKind::Event(_)));
    });
    found
}

/// Whether a condition uses history functions, so that the next frame gives another result.
pub fn uses_history(condition: &Condition) -> bool {
    let mut found = false;
    condition.each_program(&mut |program| found |= program.has_history());
    found
}
