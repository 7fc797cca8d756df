//! What a recording proves: on Ethernet a bit that the capture flipped looks like one that the device set, so that a single frame
//! is no proof against a device.
//!
//! Two things are told apart here: bits that were still, changed in one frame and changed back in the next ([`Blips`]), and
//! rules that one frame shows to be broken ([`Suspicion`]), which a later frame has to confirm. A run on a wire of our own
//! needs none of this. This file must not know who recorded, and why.

use super::Truth;
use super::image::Image;
use super::view::View;
use super::violation::Violation;
use crate::observe::Direction;
use suite::device::NameKind;
use suite::model::Condition;

/// Changing frames over which a bit must not have changed to count as still.
const STILL: usize = 4;
/// So many frames that each for itself shows a rule to be broken prove it.
const PROOF: u32 = 3;

/// Finds bits that changed in one frame only.
#[derive(Debug, Default)]
pub struct Blips {
    to_controller: Past,
    to_device: Past,
}

/// What the last frames of a direction changed.
#[derive(Debug, Default)]
struct Past {
    last: Vec<u64>,
    last_frame: u64,
    /// What the changing frames before that changed.
    before: [Vec<u64>; STILL],
    next: usize,
    /// Bits that changed back, and the frame that showed them.
    back: Vec<u64>,
    back_frame: u64,
}

/// Bits that were still, changed in one frame and changed back in the next one of the same direction.
#[derive(Clone, Copy, Debug)]
pub struct Blip<'a> {
    /// The frame that showed them, by number.
    pub frame: u64,
    /// Which way it went.
    pub direction: Direction,
    /// The bits of the data area, eight octets in a word, the first octet lowest.
    pub bits: &'a [u64],
}

impl Blips {
    /// Takes in what frame number `frame` changed.
    pub fn take(&mut self, image: &Image, frame: u64) -> Option<Blip<'_>> {
        let change = image.change()?;
        let past = match change.direction {
            Direction::ToController => &mut self.to_controller,
            Direction::ToDevice => &mut self.to_device,
        };
        let found = past.take(change.bits, frame);
        found.then_some(Blip { frame: past.back_frame, direction: change.direction, bits: &past.back })
    }

    /// Forgets everything, where frames are missing.
    pub fn forget(&mut self) {
        *self = Blips::default();
    }
}

impl Past {
    /// Whether bits that were still have changed back.
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

/// What shows a rule to be broken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Evidence {
    /// Several frames, one after the other.
    Frames,
    /// One frame; the next one shows whether it is so.
    Frame,
    /// One frame of which no second one comes, or none at all where one was to come.
    Once,
}

/// What single frames said of a rule.
#[derive(Debug, Default)]
pub struct Suspicion {
    suspect: Option<Suspect>,
    alone: Option<Violation>,
    times: u32,
}

/// A violation that waits for its confirmation.
#[derive(Debug)]
struct Suspect {
    violation: Violation,
    /// The last frame of each direction when it was seen.
    frames: [Option<u64>; 2],
}

/// What became of a violation.
#[derive(Debug)]
pub enum Verdict {
    /// It is proven.
    Proven(Box<Violation>),
    /// One frame only showed it.
    Alone,
    /// It waits for the next frames.
    Open,
}

impl Suspicion {
    /// The first violation that only one frame showed.
    pub fn alone(&self) -> Option<&Violation> {
        self.alone.as_ref()
    }

    /// Whether a violation waits for its confirmation.
    pub fn is_open(&self) -> bool {
        self.suspect.is_some()
    }

    /// Takes in a violation.
    pub fn add(&mut self, violation: Violation, evidence: Evidence, image: &Image) -> Verdict {
        match evidence {
            Evidence::Frames => Verdict::Proven(Box::new(violation)),
            Evidence::Frame if self.suspect.is_some() => Verdict::Open,
            Evidence::Frame => {
                self.suspect = Some(Suspect { violation, frames: image.last_frames() });
                Verdict::Open
            }
            Evidence::Once => self.stays_alone(violation),
        }
    }

    /// Asks a later frame: what waits is confirmed where the condition does not hold in it either.
    pub fn confirm(&mut self, image: &Image, truth: impl FnOnce() -> Truth) -> Verdict {
        let Some(suspect) = &self.suspect else { return Verdict::Open };
        let is_renewed =
            suspect.frames.iter().zip(image.last_frames()).all(|(then, now)| then.is_none() || now > *then);
        match (is_renewed, if is_renewed { truth() } else { Truth::Unknown }) {
            (false, _) | (_, Truth::Unknown) => Verdict::Open,
            (true, Truth::False) => match self.suspect.take() {
                Some(suspect) => Verdict::Proven(Box::new(suspect.violation)),
                None => Verdict::Open,
            },
            (true, Truth::True) => self.give_up(0),
        }
    }

    /// Nothing confirms what waits, if it rests on frame `since` or a later one.
    pub fn give_up(&mut self, since: u64) -> Verdict {
        let rests = |suspect: &mut Suspect| suspect.violation.rests_on() >= since;
        match self.suspect.take_if(rests) {
            Some(suspect) => self.stays_alone(suspect.violation),
            None => Verdict::Open,
        }
    }

    fn stays_alone(&mut self, violation: Violation) -> Verdict {
        self.times += 1;
        let first = self.alone.get_or_insert(violation);
        if self.times >= PROOF { Verdict::Proven(Box::new(first.clone())) } else { Verdict::Alone }
    }
}

/// Whether a condition speaks of something that happens once: one frame carries it, and its loss leaves no trace.
pub fn speaks_of_events(condition: &Condition, view: &View<'_>) -> bool {
    let mut found = false;
    condition.each_name(&mut |name| {
        found |= matches!(view.variant.names.get(name.0 as usize), Some(NameKind::Event(_)));
    });
    found
}

/// Whether a condition compares with what it remembers, so that the next frame shows something else.
pub fn looks_back(condition: &Condition) -> bool {
    let mut found = false;
    condition.each_program(&mut |program| found |= program.has_history());
    found
}
