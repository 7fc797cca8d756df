//! Connections whose Connect is not in the capture: the layout of their cyclic frames is guessed from the identity of the device,
//! the lengths of the frames and the offsets of their status bytes.
//!
//! A guess is used only if a single arrangement of a single module fits every sampled frame, and findings made with it are marked.
//! This module must not know rules.

use super::finding::{CaptureFinding, FindingSeverity};
use judge::observe::{AdoptedConnection, ArId, Observation, SubmodulePlacement, Tracker, Traffic};
use rustc_hash::FxHashMap;
use std::collections::{BTreeMap, BTreeSet};
use suite::device::{DeviceDescription, DeviceModule, DeviceSubmodule};
use suite::model::Manual;
use wire::ethernet::Mac;
use wire::profinet::rt::{IoxS, SHORTEST_DATA};

/// Sampled frames of each direction.
const SAMPLES: usize = 16;
/// After this many frames of one direction the other one is not waited for.
const ONE_SIDED: u32 = 256;
/// Upper limit of the pairs of stations that are sampled.
const MOST_PAIRS: usize = 64;

/// A station with its vendor ID and device ID.
pub(super) type StationIdentity = (Mac, (u16, u16));

/// The guessed layout of a connection without Connect.
#[derive(Clone, Debug)]
pub(super) struct GuessedLayout {
    /// The manual and the module.
    pub what: String,
}

/// The connections without a Connect.
#[derive(Debug)]
pub(super) struct LayoutGuesser<'a> {
    manuals: &'a [Manual],
    pairs: FxHashMap<(Mac, Mac), StrayPair>,
    guesses: BTreeMap<ArId, GuessedLayout>,
    /// A pair with enough samples.
    ripe: Option<(Mac, Mac)>,
    /// Pairs that had enough samples before the capture identified one of them.
    unidentified: BTreeSet<(Mac, Mac)>,
}

/// The cyclic frames between two stations, the lower address first.
#[derive(Debug, Default)]
struct StrayPair {
    ways: [StrayStream; 2],
    done: bool,
}

/// The frames of one direction.
#[derive(Debug, Default)]
struct StrayStream {
    frame_id: u16,
    samples: Vec<Vec<u8>>,
    seen: u32,
    last: Option<u16>,
    /// The smallest step of the cycle counter.
    step: u16,
}

/// A possible arrangement of a module in the frames.
struct Arrangement<'a> {
    module: &'a DeviceModule,
    placed: Vec<SubmodulePlacement>,
    /// Bytes used in the frames to the controller and to the device, without padding.
    used: (usize, usize),
}

impl<'a> LayoutGuesser<'a> {
    pub fn new(manuals: &'a [Manual]) -> LayoutGuesser<'a> {
        LayoutGuesser {
            manuals,
            pairs: FxHashMap::default(),
            guesses: BTreeMap::new(),
            ripe: None,
            unidentified: BTreeSet::new(),
        }
    }

    /// Forgets connections whose ids later ones may get, and the pairs of stations where there are too many.
    pub fn forget(&mut self, forgotten: &[ArId]) {
        self.guesses.retain(|ar, _| !forgotten.contains(ar));
        if self.pairs.len() >= MOST_PAIRS {
            self.pairs.clear();
        }
    }

    /// Takes in an observation of a tracker: only cyclic frames without a connection count.
    #[inline]
    pub fn observe(&mut self, observation: &Observation<'_>) {
        if let Observation::Traffic(Traffic::Stray { source, destination, frame_id, counter, data, .. }) = observation {
            self.stray((*source, *destination), *frame_id, *counter, data);
        }
    }

    fn stray(&mut self, (source, destination): (Mac, Mac), frame_id: u16, counter: u16, data: &[u8]) {
        let key = (source.min(destination), source.max(destination));
        if self.pairs.len() >= MOST_PAIRS && !self.pairs.contains_key(&key) {
            return;
        }
        let pair = self.pairs.entry(key).or_default();
        if pair.done {
            return;
        }
        let way = &mut pair.ways[usize::from(source != key.0)];
        if way.seen > 0 && way.frame_id != frame_id {
            // Two streams in one direction are two connections, which cannot be distinguished.
            pair.done = true;
            return;
        }
        way.frame_id = frame_id;
        way.seen += 1;
        if let Some(last) = way.last.replace(counter) {
            let step = counter.wrapping_sub(last);
            if step > 0 && step < 0x8000 && (way.step == 0 || step < way.step) {
                way.step = step;
            }
        }
        if way.samples.len() < SAMPLES {
            way.samples.push(data.to_vec());
        }
        let [one, other] = &pair.ways;
        let both = one.samples.len() >= SAMPLES && other.samples.len() >= SAMPLES;
        if both || one.seen.max(other.seen) >= ONE_SIDED {
            self.ripe = Some(key);
        }
    }

    /// A connection whose layout is now known, for the tracker to follow.
    pub fn guessed(&mut self, tracker: &Tracker) -> Option<(AdoptedConnection, GuessedLayout)> {
        let key = self.ripe.take()?;
        let pair = self.pairs.get_mut(&key)?;
        pair.done = true;
        if tracker.ids_of(key.0).is_none() && tracker.ids_of(key.1).is_none() {
            self.unidentified.insert(key);
        }
        let [low, high] = &pair.ways;
        let mut fits: Vec<(AdoptedConnection, GuessedLayout)> = Vec::new();
        for (device, controller, inputs, outputs) in [(key.0, key.1, low, high), (key.1, key.0, high, low)] {
            let ids = tracker.ids_of(device);
            let known = |manual: &&Manual| {
                let own = manual.device.ids();
                match ids {
                    Some(_) => ids == own,
                    // A user who names a single manual says that this is the device.
                    None => {
                        self.manuals.len() == 1
                            && tracker.ids_of(controller).is_none_or(|ids| own.is_none_or(|own| ids.0 != own.0))
                    }
                }
            };
            for manual in self.manuals.iter().filter(|manual| manual.device.profinet().is_some()).filter(known) {
                for arrangement in arrangements(&manual.device) {
                    if !arrangement.fits(inputs, outputs) {
                        continue;
                    }
                    let met = AdoptedConnection {
                        controller,
                        device,
                        ids: manual.device.ids().unwrap_or_default(),
                        inputs: (inputs.frame_id, arrangement.used.0.max(SHORTEST_DATA), inputs.step),
                        outputs: (outputs.frame_id, arrangement.used.1.max(SHORTEST_DATA), outputs.step),
                        submodules: arrangement.placed.clone(),
                    };
                    let what = format!("{}, module {}", manual.device.name, arrangement.module.name);
                    fits.push((met, GuessedLayout { what }));
                }
            }
        }
        let (first, _) = fits.first()?;
        // Submodules of access point and ports may differ as long as the data have the same offsets.
        let places = |met: &AdoptedConnection| {
            let data = met.submodules.iter().filter(|of| of.input.is_some() || of.output.is_some());
            data.map(|of| (of.submodule_ident, of.input.clone(), of.output.clone(), of.input_status))
                .collect::<Vec<_>>()
        };
        let same = fits.iter().all(|(met, _)| met.device == first.device && places(met) == places(first));
        same.then(|| fits.swap_remove(0))
    }

    /// The stations that a manual knows, and which the capture identifies only after their cyclic frames were sampled.
    pub fn late(&self, tracker: &Tracker) -> Vec<StationIdentity> {
        let is_known = |ids: &(u16, u16)| self.manuals.iter().any(|manual| manual.device.ids() == Some(*ids));
        let stations = self.unidentified.iter().flat_map(|(one, other)| [*one, *other]);
        stations.filter_map(|mac| Some((mac, tracker.ids_of(mac).filter(is_known)?))).collect()
    }

    /// Remembers the guess from which a connection was made.
    pub fn remember_guess(&mut self, ar: ArId, guess: GuessedLayout) {
        self.guesses.insert(ar, guess);
    }

    /// The guess by which a connection without Connect is read.
    pub fn guess(&self, ar: ArId) -> Option<&GuessedLayout> {
        self.guesses.get(&ar)
    }

    /// Marks a finding on a connection with a guessed layout, since the guess may be wrong.
    pub fn mark(&self, finding: &mut CaptureFinding) {
        // A rule finding without a connection may be about a guessed one.
        let of_rule = finding.ar.is_none() && !finding.requirements.is_empty();
        let guess = match finding.ar {
            Some(ar) => self.guess(ArId(ar as u32)),
            None => self.guesses.values().next().filter(|_| of_rule),
        };
        let Some(guess) = guess.filter(|_| !finding.bus.is_profibus()) else { return };
        finding.severity = finding.severity.min(FindingSeverity::Warning);
        finding.text += &format!(" (the Connect is not in the capture; the layout is guessed: {})", guess.what);
    }
}

/// The arrangements of the submodules of a module that controllers use, with and without those of the access point.
fn arrangements(device: &DeviceDescription) -> Vec<Arrangement<'_>> {
    let mut all = Vec::new();
    let point: Vec<&DeviceSubmodule> = device.submodules.iter().filter(|of| of.slot == 0).collect();
    for module in &device.modules {
        let own: Vec<&DeviceSubmodule> =
            module.submodules.iter().filter_map(|&index| device.submodules.get(index)).collect();
        if own.iter().all(|of| of.input_octets == 0 && of.output_octets == 0) {
            continue;
        }
        for head in 0..3 {
            for in_turn in [false, true] {
                let mut submodules: Vec<SubmodulePlacement> = Vec::new();
                let mut lengths: Vec<(usize, usize)> = Vec::new();
                let mut put = |api, slot, subslot, ident, octets: (u16, u16)| {
                    submodules.push(SubmodulePlacement::bare((api, slot, subslot), ident));
                    lengths.push((octets.0.into(), octets.1.into()));
                };
                if head > 0 {
                    point.iter().for_each(|of| put(of.api, of.slot, of.subslot, of.ident, (0, 0)));
                }
                if head > 1 {
                    device
                        .profinet()
                        .map_or(&[][..], |facts| &facts.network)
                        .iter()
                        .for_each(|&(subslot, ident)| put(0, 0, subslot, ident, (0, 0)));
                }
                own.iter()
                    .for_each(|of| put(of.api, of.slot, of.subslot, of.ident, (of.input_octets, of.output_octets)));
                let used = place(&mut submodules, &lengths, in_turn);
                all.push(Arrangement { module, placed: submodules, used });
            }
        }
    }
    all
}

/// Places the submodules one after the other: all data and then all consumer statuses, or both in turn. Returns the bytes used.
fn place(submodules: &mut [SubmodulePlacement], lengths: &[(usize, usize)], in_turn: bool) -> (usize, usize) {
    let (mut input, mut output) = (0, 0);
    let has_input = |octets: (usize, usize)| octets.0 > 0 || octets.1 == 0;
    for (of, &octets) in submodules.iter_mut().zip(lengths) {
        if has_input(octets) {
            of.input = (octets.0 > 0).then_some(input..input + octets.0);
            of.input_status = Some(input + octets.0);
            input += octets.0 + 1;
            if in_turn {
                (of.input_consumer, output) = (Some(output), output + 1);
            }
        }
        if octets.1 > 0 {
            if in_turn && has_input(octets) {
                // Its own outputs come before the status of its inputs.
                output -= 1;
            }
            of.output = Some(output..output + octets.1);
            of.output_status = Some(output + octets.1);
            output += octets.1 + 1;
            if in_turn {
                if has_input(octets) {
                    (of.input_consumer, output) = (Some(output), output + 1);
                }
                (of.output_consumer, input) = (Some(input), input + 1);
            }
        }
    }
    if !in_turn {
        for (of, &octets) in submodules.iter_mut().zip(lengths) {
            if octets.1 > 0 {
                (of.output_consumer, input) = (Some(input), input + 1);
            }
        }
        for (of, &octets) in submodules.iter_mut().zip(lengths) {
            if has_input(octets) {
                (of.input_consumer, output) = (Some(output), output + 1);
            }
        }
    }
    (input, output)
}

impl Arrangement<'_> {
    /// Whether all sampled frames may have this arrangement, and one of each direction has good data.
    fn fits(&self, inputs: &StrayStream, outputs: &StrayStream) -> bool {
        let of_inputs: Vec<usize> =
            self.placed.iter().flat_map(|of| of.input_status.into_iter().chain(of.output_consumer)).collect();
        let of_outputs: Vec<usize> =
            self.placed.iter().flat_map(|of| of.output_status.into_iter().chain(of.input_consumer)).collect();
        !inputs.samples.is_empty()
            && way_fits(&inputs.samples, &of_inputs, self.used.0)
            && (outputs.samples.is_empty() || way_fits(&outputs.samples, &of_outputs, self.used.1))
    }
}

fn way_fits(samples: &[Vec<u8>], status: &[usize], used: usize) -> bool {
    let octet = |data: &[u8], at: usize| data.get(at).copied();
    let plausible = |data: &Vec<u8>| {
        data.len() == used.max(SHORTEST_DATA)
            && status.iter().all(|&at| octet(data, at).is_some_and(|of| of & 0x1F == 0))
            && data.iter().skip(used).all(|of| *of == 0)
    };
    let good = |data: &Vec<u8>| status.iter().all(|&at| octet(data, at).is_some_and(|of| IoxS(of).is_good()));
    samples.iter().all(plausible) && samples.iter().any(good)
}
