//! The rules of a variant. At each frame only those rules are evaluated that used a changed value in their last evaluation; for the
//! others the frame is counted.
//!
//! Each rule reports its dependencies and whether it waits for a window.

use super::evidence::Blip;
use super::image::ImageChange;
use super::rule::{RuleResults, RuleWatch};
use super::tracked_inputs::{self, TrackedInputs};
use super::view::NameView;
use crate::observe::FrameDirection;
use station::{Duration, Time};
use suite::model::SuiteRule;

/// A set of rules by their number in a variant. A variant with more rules than bits has no index: all rules are evaluated.
type RuleBits = u128;

/// The rules of a variant and their state.
#[derive(Debug)]
pub struct RuleSet<'a> {
    rules: &'a [SuiteRule],
    watches: Vec<RuleWatch<'a>>,
    /// Whether a window was open after the last evaluation.
    is_waiting: bool,
    /// Whether a window may have closed since then.
    may_wait_no_more: bool,
    /// Whether the frames are from a recording.
    is_recorded: bool,
    /// Whether a rule was violated since the last [`take_newly_broken`](Self::take_newly_broken).
    is_newly_broken: bool,
    /// Number of frames of each kind, in total and as counted for each rule.
    frames: [u64; 3],
    counted: Vec<[u64; 3]>,
    index: Option<Index>,
    /// Versions of the image and the notebook at the last evaluation.
    version: (u64, u64),
}

/// Dependencies of the rules on one connection, from the values that each rule used last.
#[derive(Debug)]
struct Index {
    layout: u64,
    module: usize,
    /// Rules that apply to this module.
    judged: RuleBits,
    to_controller: Vec<RuleBits>,
    to_device: Vec<RuleBits>,
    elapsed: RuleBits,
    clock: RuleBits,
    /// Rules that must be evaluated at the next frame of each kind, whatever it changes.
    restless: [RuleBits; 3],
}

impl Index {
    fn new(rules: &[SuiteRule], watches: &mut [RuleWatch<'_>], layout: u64, module: usize) -> Option<Index> {
        if rules.len() > RuleBits::BITS as usize {
            return None;
        }
        let (to_controller, to_device) = (Vec::new(), Vec::new());
        let (judged, elapsed, clock) = (0, 0, 0);
        let mut index =
            Index { layout, module, judged, to_controller, to_device, elapsed, clock, restless: [RuleBits::MAX; 3] };
        for (place, (rule, watch)) in rules.iter().zip(watches).enumerate() {
            if !rule.modules.contains(&module) {
                continue;
            }
            index.judged |= 1 << place;
            index.list(place, watch.steady());
        }
        Some(index)
    }

    /// Updates what a rule depends on.
    fn list(&mut self, rule: usize, steady: &mut TrackedInputs<RuleResults>) {
        let bit = 1 << rule;
        let listed = self.to_controller.iter_mut().chain(&mut self.to_device);
        listed.chain([&mut self.elapsed, &mut self.clock]).for_each(|rules| *rules &= !bit);
        self.elapsed |= if steady.uses_elapsed() { bit } else { 0 };
        self.clock |= if steady.uses_time() { bit } else { 0 };
        steady.list_octets(&mut |direction, octet| {
            let of = match direction {
                FrameDirection::ToController => &mut self.to_controller,
                FrameDirection::ToDevice => &mut self.to_device,
            };
            if of.len() <= octet {
                of.resize(octet + 1, 0);
            }
            of[octet] |= bit;
        });
    }

    /// The rules that depend on the change of a frame.
    #[inline]
    fn meant(&self, place: usize, change: &ImageChange<'_>) -> RuleBits {
        let of = match change.direction {
            FrameDirection::ToController => &self.to_controller,
            FrameDirection::ToDevice => &self.to_device,
        };
        let mut meant = self.restless[place] | self.clock | if change.elapsed { self.elapsed } else { 0 };
        for (word, &bits) in change.bits.iter().enumerate().filter(|(_, bits)| **bits != 0) {
            for (octet, bits) in bits.to_le_bytes().into_iter().enumerate() {
                if bits != 0 {
                    meant |= of.get(word * 8 + octet).copied().unwrap_or(0);
                }
            }
        }
        meant & self.judged
    }
}

impl<'a> RuleSet<'a> {
    /// Rules in their initial state; a hold without samples for longer than `watchdog` is undecided.
    pub fn new(rules: &'a [SuiteRule], watchdog: Duration) -> RuleSet<'a> {
        let watches = rules.iter().map(|rule| RuleWatch::new(&rule.body, watchdog)).collect();
        let counted = vec![[0; 3]; rules.len()];
        let (frames, version) = ([0; 3], (0, 0));
        RuleSet {
            rules,
            watches,
            is_waiting: false,
            may_wait_no_more: false,
            is_newly_broken: false,
            is_recorded: false,
            frames,
            counted,
            index: None,
            version,
        }
    }

    /// Switches to a recording: violations shown by a single frame are kept separate, and time advances only with frames of the
    /// connection, since others may be missing.
    #[must_use]
    pub fn recorded(self) -> RuleSet<'a> {
        let watches = self.watches.into_iter().map(RuleWatch::recorded).collect();
        RuleSet { watches, is_recorded: true, ..self }
    }

    /// Evaluates the rules at a frame or event. A rule with a signal that the current module does not have is not judged. In a
    /// recording, `blip` revokes bits of the previous frame.
    pub fn tick(&mut self, view: &NameView<'_>, blip: Option<&Blip<'_>>) {
        let Some(module) = view.image.module() else { return };
        let (image, notebook) = (view.image.version(), view.notebook.version());
        let before = std::mem::replace(&mut self.version, (image, notebook));
        let follows = before == (image.wrapping_sub(1), notebook);
        let is_of = |index: &&mut Index| (index.layout, index.module) == (view.image.layout(), module);
        let place = tracked_inputs::place(view.tick.kind);
        let is_recorded = self.is_recorded;
        if let (Some(place), true, Some(change), Some(index)) =
            (place, follows, view.image.change(), self.index.as_mut().filter(is_of))
        {
            let mut meant = index.meant(place, &change);
            self.frames[place] += 1;
            debug_assert_eq!(left_out_wrongly(index, &self.watches, place, meant, view), None);
            if meant == 0 {
                return;
            }
            while meant != 0 {
                let rule = meant.trailing_zeros() as usize;
                meant &= meant - 1;
                let watch = &mut self.watches[rule];
                let mut counted = std::mem::replace(&mut self.counted[rule], self.frames);
                counted[place] += 1;
                settle(watch, counted, self.frames);
                watch.steady().unchanged_until(image.wrapping_sub(1), notebook);
                if let Some(blip) = blip {
                    watch.take_back(blip);
                }
                let waited = watch.is_waiting();
                look(watch, view, is_recorded);
                self.is_newly_broken |= watch.has_new_violation;
                self.is_waiting |= watch.is_waiting();
                self.may_wait_no_more |= waited && !watch.is_waiting();
                if watch.steady().inputs_changed() {
                    index.list(rule, watch.steady());
                }
                for (place, restless) in index.restless.iter_mut().enumerate() {
                    let bit = 1 << rule;
                    *restless = if watch.is_idle(place) { *restless & !bit } else { *restless | bit };
                }
            }
            if std::mem::take(&mut self.may_wait_no_more) {
                self.is_waiting = self.watches.iter().any(RuleWatch::is_waiting);
            }
            return;
        }
        settle_all(self.index.as_ref(), &mut self.watches, &mut self.counted, self.frames);
        if let Some(place) = place {
            self.frames[place] += 1;
        }
        self.counted.fill(self.frames);
        self.is_waiting = false;
        for (rule, watch) in self.rules.iter().zip(&mut self.watches) {
            if !rule.modules.contains(&module) {
                continue;
            }
            if let Some(blip) = blip {
                watch.take_back(blip);
            }
            look(watch, view, is_recorded);
            self.is_newly_broken |= watch.has_new_violation;
            self.is_waiting |= watch.is_waiting();
        }
        match self.index.as_mut().filter(is_of) {
            Some(index) => index.restless = [RuleBits::MAX; 3],
            // Dependencies of a rule are known after its first evaluation at a frame.
            None if place.is_some() => {
                self.index = Index::new(self.rules, &mut self.watches, view.image.layout(), module);
            }
            None => self.index = None,
        }
    }

    /// Forgets the violations of the rules that `is_meant` selects: they are judged afresh from the next frame on.
    pub fn forget_violations(&mut self, is_meant: impl Fn(&SuiteRule) -> bool) {
        self.settle();
        let meant = self.rules.iter().zip(&mut self.watches).filter(|(rule, _)| is_meant(rule));
        for (_, watch) in meant.filter(|(_, watch)| watch.violation().is_some() || watch.unconfirmed().is_some()) {
            watch.begin_afresh();
            self.index = None;
        }
    }

    /// Advances time without a frame.
    pub fn time(&mut self, view: &NameView<'_>, now: Time) {
        if self.is_waiting && !self.is_recorded {
            self.may_wait_no_more = true;
            for watch in &mut self.watches {
                watch.time(view, now);
                self.is_newly_broken |= watch.has_new_violation;
            }
        }
    }

    /// Whether a rule waits for something that is past a limit of ours.
    pub fn is_late(&self, now: Time) -> bool {
        self.is_waiting && self.watches.iter().any(|watch| watch.is_late(now))
    }

    /// Whether a violation or suspected violation is new since [`take_newly_broken`](Self::take_newly_broken).
    pub fn is_newly_broken(&self) -> bool {
        self.is_newly_broken
    }

    /// Returns [`is_newly_broken`](Self::is_newly_broken) and resets it.
    pub fn take_newly_broken(&mut self) -> bool {
        if self.is_newly_broken {
            self.watches.iter_mut().for_each(|watch| watch.has_new_violation = false);
        }
        std::mem::take(&mut self.is_newly_broken)
    }

    /// Ends open windows at the end of a connection or trace, or at a gap.
    pub fn cut(&mut self) {
        self.settle();
        self.is_waiting = false;
        for watch in &mut self.watches {
            watch.cut();
            self.is_newly_broken |= watch.has_new_violation;
        }
        if let Some(index) = &mut self.index {
            index.restless = [RuleBits::MAX; 3];
        }
    }

    /// The rules with their state at the last [`settle`](Self::settle) or [`cut`](Self::cut), in the order of the variant.
    pub fn iter(&self) -> impl Iterator<Item = (&'a SuiteRule, &RuleWatch<'a>)> {
        self.rules.iter().zip(&self.watches)
    }

    /// Adds the frames that were counted without evaluation to each rule.
    pub fn settle(&mut self) {
        settle_all(self.index.as_ref(), &mut self.watches, &mut self.counted, self.frames);
    }
}

/// Debug check: returns a rule that was left out although it had to be evaluated; checks another rule at each frame.
fn left_out_wrongly(
    index: &Index,
    watches: &[RuleWatch<'_>],
    place: usize,
    meant: RuleBits,
    view: &NameView<'_>,
) -> Option<usize> {
    let rule = usize::try_from(view.image.version()).ok()? % watches.len().max(1);
    let is_left_out = (index.judged & !meant) >> rule & 1 == 1;
    (is_left_out && !watches.get(rule)?.matches_stored(place, view)).then_some(rule)
}

fn settle_all(index: Option<&Index>, watches: &mut [RuleWatch<'_>], counted: &mut [[u64; 3]], frames: [u64; 3]) {
    let Some(index) = index else { return };
    for (rule, (watch, counted)) in watches.iter_mut().zip(counted).enumerate() {
        let before = std::mem::replace(counted, frames);
        if index.judged >> rule & 1 == 1 {
            settle(watch, before, frames);
        }
    }
}

fn settle(watch: &mut RuleWatch<'_>, counted: [u64; 3], frames: [u64; 3]) {
    for (place, (before, now)) in counted.into_iter().zip(frames).enumerate() {
        if now > before {
            watch.count(place, now - before);
        }
    }
}

fn look(watch: &mut RuleWatch<'_>, view: &NameView<'_>, is_recorded: bool) {
    if is_recorded {
        watch.time(view, view.tick.time);
    }
    watch.tick(view);
}
