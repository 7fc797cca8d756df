//! Detects whether the inputs of a condition are unchanged since the last evaluation, so that its result is the same.
//!
//! It maps names to bits of the cyclic data and compares them with the bits that a frame changed. The caller evaluates the
//! condition and stores its result here.

use super::TickKind;
use super::image::{ConnectionImage, StatusByte};
use super::view::{NameView, Reads};
use crate::observe::FrameDirection;
use expression::Program;
use suite::device::{NameId, NameKind};
use suite::model::{Condition, HoldTime, RuleBody};

/// The inputs of a condition or rule, the version at the last evaluation, and its result.
#[derive(Clone, Debug)]
pub struct TrackedInputs<K> {
    /// The result at the last frame of each kind; events are always evaluated.
    known: [Option<K>; 3],
    inputs: Inputs,
    /// The inputs of each name, if the caller reports the names that were read.
    leaves: Vec<(NameId, Inputs)>,
    /// The inputs that were read since the last [`forget`](Self::forget); others do not affect the result.
    read: Option<Inputs>,
    /// The names of these inputs in the order of reading, and whether the time was read.
    asked: (Vec<NameId>, bool),
    /// Whether they are from before the last [`forget`](Self::forget).
    is_outdated: bool,
    /// Whether they are others than at the last [`list_octets`](Self::list_octets).
    is_listed_otherwise: bool,
    /// The layout of the connection that the inputs were determined for.
    layout: Option<u64>,
    image: u64,
    notebook: u64,
}

/// Bits of the cyclic data and other inputs that change from frame to frame.
#[derive(Clone, Debug, Default)]
struct Inputs {
    to_controller: Mask,
    to_device: Mask,
    /// The time between two frames.
    elapsed: bool,
    /// The time or an invisible value, so that the condition must always be evaluated.
    clock: bool,
}

/// Bits of the data area of one direction, eight bytes per word.
#[derive(Clone, Debug, Default)]
struct Mask {
    /// The first words, which are sufficient in nearly all cases and are compared at every frame.
    near: [u64; NEAR],
    far: Vec<u64>,
}

/// Number of words stored inline in a mask.
const NEAR: usize = 4;

impl Mask {
    fn add(&mut self, octet: usize, bits: u8) {
        let word = octet / 8;
        if word >= NEAR && self.far.len() <= word - NEAR {
            self.far.resize(word - NEAR + 1, 0);
        }
        let word = self.near.iter_mut().chain(&mut self.far).nth(word);
        word.into_iter().for_each(|word| *word |= u64::from(bits) << (octet % 8 * 8));
    }

    fn unite(&mut self, other: &Mask) {
        if self.far.len() < other.far.len() {
            self.far.resize(other.far.len(), 0);
        }
        self.near.iter_mut().zip(&other.near).for_each(|(own, other)| *own |= other);
        self.far.iter_mut().zip(&other.far).for_each(|(own, other)| *own |= other);
    }

    fn meets(&self, changed: &[u64]) -> bool {
        let meet = |mask: &[u64], changed: &[u64]| mask.iter().zip(changed).any(|(mask, changed)| mask & changed != 0);
        meet(&self.near, changed)
            || !self.far.is_empty() && changed.get(NEAR..).is_some_and(|changed| meet(&self.far, changed))
    }
}

/// A condition or rule whose inputs are tracked.
pub trait HasInputs {
    /// Visits every program.
    fn programs(&self, visit: &mut dyn FnMut(&Program));

    /// Visits every name, including those of the programs.
    fn names(&self, visit: &mut dyn FnMut(NameId));
}

impl HasInputs for RuleBody {
    fn programs(&self, visit: &mut dyn FnMut(&Program)) {
        match self {
            RuleBody::Always(condition) => condition.each_program(&mut |program| visit(program)),
            RuleBody::When { premise, then, hold, .. } => {
                visit(premise);
                then.each_program(&mut |program| visit(program));
                if let HoldTime::Until(end) = hold {
                    end.each_program(&mut |program| visit(program));
                }
            }
        }
    }

    fn names(&self, visit: &mut dyn FnMut(NameId)) {
        self.each_name(visit);
    }
}

impl HasInputs for Program {
    fn programs(&self, visit: &mut dyn FnMut(&Program)) {
        visit(self);
    }

    fn names(&self, visit: &mut dyn FnMut(NameId)) {
        Program::names(self).for_each(visit);
    }
}

impl HasInputs for (&Condition, &HoldTime) {
    fn programs(&self, visit: &mut dyn FnMut(&Program)) {
        self.0.each_program(&mut |program| visit(program));
        if let HoldTime::Until(end) = self.1 {
            end.each_program(&mut |program| visit(program));
        }
    }

    fn names(&self, visit: &mut dyn FnMut(NameId)) {
        self.0.each_name(visit);
        if let HoldTime::Until(end) = self.1 {
            end.each_name(visit);
        }
    }
}

impl<K> Default for TrackedInputs<K> {
    fn default() -> TrackedInputs<K> {
        let known = [None, None, None];
        TrackedInputs {
            known,
            inputs: Inputs::default(),
            leaves: Vec::new(),
            read: None,
            asked: (Vec::new(), false),
            is_outdated: false,
            is_listed_otherwise: false,
            layout: None,
            image: 0,
            notebook: 0,
        }
    }
}

/// Index of frames to the device.
pub(super) const OUTPUT: usize = 0;

/// Index of a kind of frames; `None` for events.
pub(super) fn place(kind: TickKind) -> Option<usize> {
    match kind {
        TickKind::Output => Some(OUTPUT),
        TickKind::Sample => Some(1),
        TickKind::BadSample => Some(2),
        TickKind::Event => None,
    }
}

impl<K: Copy> TrackedInputs<K> {
    /// The result at the last frame of this kind, if no input of `sees` and no state has changed since.
    ///
    /// Must be called once per version of the image; after a skipped version the result is unknown.
    pub fn known(&mut self, sees: &impl HasInputs, view: &NameView<'_>) -> Option<K> {
        if !self.is_unchanged(sees, view) {
            self.forget();
        }
        self.known[place(view.tick.kind)?]
    }

    /// Stores the result at `view`, unless the state of the condition has changed.
    pub fn keep(&mut self, view: &NameView<'_>, known: K, remembers_else: bool) {
        match place(view.tick.kind) {
            _ if remembers_else => self.forget(),
            Some(place) => self.known[place] = Some(known),
            None => {}
        }
    }

    /// The stored result of a kind of frames.
    pub(super) fn stored(&self, place: usize) -> Option<K> {
        self.known[place]
    }

    /// Reports that no input changed up to the version `image`; the caller has checked it.
    pub(super) fn unchanged_until(&mut self, image: u64, notebook: u64) {
        (self.image, self.notebook) = (image, notebook);
    }

    /// Reports what was read in this evaluation; before the first call all inputs count.
    pub(super) fn record_reads(&mut self, reads: &mut Reads) {
        let TrackedInputs { inputs, leaves, read, asked, is_outdated, is_listed_otherwise, .. } = self;
        let (has_time, names) = (reads.has_time(), reads.names());
        let is_outdated = std::mem::take(is_outdated);
        let is_nothing_else = if is_outdated {
            asked.0 == names && asked.1 == has_time
        } else {
            names.is_empty() && (asked.1 || !has_time)
        };
        if read.is_some() && is_nothing_else {
            return;
        }
        let read = read.get_or_insert_default();
        if is_outdated {
            asked.0.clear();
            asked.1 = false;
            read.clear();
        }
        asked.0.extend_from_slice(names);
        asked.1 |= has_time;
        read.clock |= has_time;
        for name in names {
            let leaf = leaves.iter().find(|(known, _)| known == name);
            read.unite(leaf.map_or(inputs, |(_, leaf)| leaf));
        }
        *is_listed_otherwise = true;
    }

    /// Whether the inputs are others than at the last [`list_octets`](Self::list_octets).
    pub(super) fn inputs_changed(&self) -> bool {
        self.is_listed_otherwise
    }

    /// Visits the bytes of the data areas that affect the result.
    pub(super) fn list_octets(&mut self, visit: &mut dyn FnMut(FrameDirection, usize)) {
        self.is_listed_otherwise = false;
        let counting = self.counting();
        for direction in [FrameDirection::ToController, FrameDirection::ToDevice] {
            let mask = counting.of_direction(direction);
            for (place, word) in mask.near.iter().chain(&mask.far).enumerate() {
                let octets = (0..8).filter(|octet| word >> (octet * 8) & 0xFF != 0);
                octets.for_each(|octet| visit(direction, place * 8 + octet));
            }
        }
    }

    /// Whether the time between two frames is an input.
    pub(super) fn uses_elapsed(&self) -> bool {
        self.counting().elapsed
    }

    /// Whether the time or an invisible value is an input.
    pub(super) fn uses_time(&self) -> bool {
        self.counting().clock
    }

    /// Whether one of these bits of a direction is an input.
    pub fn uses_bits(&self, direction: FrameDirection, bits: &[u64]) -> bool {
        self.inputs.of_direction(direction).meets(bits)
    }

    /// Drops the stored results after a change of the state.
    pub fn forget(&mut self) {
        self.known = [None; 3];
        self.is_outdated = true;
    }

    /// The inputs that affect the result.
    fn counting(&self) -> &Inputs {
        self.read.as_ref().unwrap_or(&self.inputs)
    }

    fn is_unchanged(&mut self, sees: &impl HasInputs, view: &NameView<'_>) -> bool {
        let (image, notebook) = (view.image.version(), view.notebook.version());
        let before = (std::mem::replace(&mut self.image, image), std::mem::replace(&mut self.notebook, notebook));
        if view.tick.kind == TickKind::Event {
            return false;
        }
        if self.layout != Some(view.image.layout()) {
            self.layout = Some(view.image.layout());
            self.inputs = Inputs::of(sees, view);
            self.leaves.clear();
            self.read = None;
            self.asked = (Vec::new(), false);
            sees.names(&mut |name| leaves(name, view, &mut self.leaves));
            return false;
        }
        if before != (image.wrapping_sub(1), notebook) || self.counting().clock {
            return false;
        }
        let Some(change) = view.image.change() else { return false };
        let counting = self.counting();
        !(counting.of_direction(change.direction).meets(change.bits) || counting.elapsed && change.elapsed)
    }
}

/// Adds a name and the names that it depends on, each with its own inputs.
fn leaves(name: NameId, view: &NameView<'_>, list: &mut Vec<(NameId, Inputs)>) {
    if list.iter().any(|(known, _)| *known == name) {
        return;
    }
    let mut own = Inputs::default();
    let parts = match view.variant.names.get(name.0 as usize) {
        Some(NameKind::Signal { signal, low, width, circle, code_when, .. }) => {
            own.add_signal(*signal, *low, *width, view.image);
            code_when.iter().for_each(|bit| own.add(*bit, view));
            circle.as_ref()
        }
        Some(NameKind::Derived(index)) => view.variant.derived.get(*index).map(|(_, program)| program),
        _ => {
            own.add(name, view);
            None
        }
    };
    list.push((name, own));
    parts.into_iter().flat_map(Program::names).for_each(|name| leaves(name, view, list));
}

impl Inputs {
    fn of(sees: &impl HasInputs, view: &NameView<'_>) -> Inputs {
        let mut inputs = Inputs::default();
        sees.programs(&mut |program| inputs.clock |= program.depends_on_time());
        sees.names(&mut |name| inputs.add(name, view));
        inputs
    }

    fn unite(&mut self, other: &Inputs) {
        self.to_controller.unite(&other.to_controller);
        self.to_device.unite(&other.to_device);
        self.elapsed |= other.elapsed;
        self.clock |= other.clock;
    }

    fn clear(&mut self) {
        for mask in [&mut self.to_controller, &mut self.to_device] {
            mask.near = [0; NEAR];
            mask.far.clear();
        }
        (self.elapsed, self.clock) = (false, false);
    }

    fn of_direction(&self, direction: FrameDirection) -> &Mask {
        match direction {
            FrameDirection::ToController => &self.to_controller,
            FrameDirection::ToDevice => &self.to_device,
        }
    }

    fn add(&mut self, name: NameId, view: &NameView<'_>) {
        let image = view.image;
        match view.variant.names.get(name.0 as usize) {
            Some(NameKind::Signal { signal, low, width, circle, code_when, .. }) => {
                self.add_signal(*signal, *low, *width, image);
                code_when.iter().for_each(|bit| self.add(*bit, view));
                circle.iter().flat_map(Program::names).for_each(|name| self.add(name, view));
            }
            Some(NameKind::OutputOctets(of)) => {
                self.add_all(FrameDirection::ToDevice, image.octets_of(FrameDirection::ToDevice, *of))
            }
            Some(NameKind::InputOctets(of)) => {
                self.add_all(FrameDirection::ToController, image.octets_of(FrameDirection::ToController, *of));
            }
            Some(NameKind::OutputStatus(of)) => {
                self.add_all(FrameDirection::ToDevice, image.status_of(StatusByte::Output, *of))
            }
            Some(NameKind::InputStatus(of)) => {
                self.add_all(FrameDirection::ToController, image.status_of(StatusByte::Input, *of))
            }
            Some(NameKind::ConsumerStatus(of)) => {
                self.add_all(FrameDirection::ToController, image.status_of(StatusByte::Consumer, *of));
            }
            Some(NameKind::Derived(index)) => {
                let program = view.variant.derived.get(*index).map(|(_, program)| program);
                program.into_iter().flat_map(Program::names).for_each(|name| self.add(name, view));
            }
            // A cycle that is not configured is measured.
            Some(NameKind::Elapsed | NameKind::Cycle) => self.elapsed = true,
            // Other names belong to the image or notebook, which have versions, or are constant. Events are always evaluated.
            Some(other) => self.clock |= other.observability().changes_unseen,
            None => {}
        }
    }

    fn add_signal(&mut self, signal: usize, low: u32, width: u32, image: &ConnectionImage) {
        let Some((direction, octets)) = image.octets_of_signal(signal) else { return };
        let count = octets.len();
        let is_little_endian = image.is_little_endian(signal);
        for (index, octet) in octets.enumerate() {
            // Of a big-endian number the last byte holds bits 0 to 7.
            let first = if is_little_endian { index } else { count - 1 - index } as u32 * 8;
            let meant = (0..8).filter(|bit| (low..low.saturating_add(width)).contains(&(first + bit)));
            let bits = meant.fold(0u8, |bits, bit| bits | 1 << bit);
            self.mask(direction).add(octet, bits);
        }
    }

    fn add_all(&mut self, direction: FrameDirection, octets: impl Iterator<Item = usize>) {
        octets.for_each(|octet| self.mask(direction).add(octet, 0xFF));
    }

    fn mask(&mut self, direction: FrameDirection) -> &mut Mask {
        match direction {
            FrameDirection::ToController => &mut self.to_controller,
            FrameDirection::ToDevice => &mut self.to_device,
        }
    }
}
