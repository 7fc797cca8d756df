//! Which of the variations that a manual permits explain what a device does.

use crate::bench::{CannotExplore, ExploreBench, LoadedSequences};
use crate::distance::{Counters, counters, distance};
use crate::draw::Draw;
use crate::sequence_log::SequenceLog;
use engine::{DutKind, DutSpec};
use std::collections::{BTreeMap, BTreeSet};

/// The reference device, with the permitted variations that have been learned of the device under test.
#[derive(Clone, Debug)]
pub struct LearnedReference {
    manual: String,
    variant: String,
    /// The names of all permitted variations.
    permitted: Vec<String>,
    /// Variations that the description of the device says, which are not changed.
    described: Vec<String>,
    learned: Vec<String>,
    /// All names in the order of the tables.
    order: Vec<String>,
}

impl LearnedReference {
    /// The reference device of the manual. Of the variations of `dut` those are known that its GSDML or GSD, or its bench file, says.
    pub fn new(dut: &DutSpec) -> Result<LearnedReference, CannotExplore> {
        let subject = deviations::subject(&dut.manual).map_err(|error| CannotExplore::Nothing(error.to_string()))?;
        let names = |names: &[String]| -> Vec<String> {
            names.iter().filter_map(|name| subject.variations_of(name)).flatten().map(|of| of.name.to_owned()).collect()
        };
        let says = |name: &String| {
            let one = || std::iter::once(name.as_str());
            !subject.description_changes(one()).is_empty() || subject.position_noise(one()) > 0
        };
        let mut described: Vec<String> =
            dut.variations().into_iter().filter(|name| name.contains("elsewhere")).collect();
        described.extend(names(&dut.variations()).into_iter().filter(says));
        described.dedup();
        let permitted = subject.permitted().map(|of| of.name.to_owned()).filter(|name| !says(name)).collect();
        let (manual, variant) = (dut.manual.clone(), dut.variant.clone());
        let order = subject.permitted().map(|of| of.name.to_owned()).collect();
        Ok(LearnedReference { manual, variant, permitted, described, learned: Vec::new(), order })
    }

    /// The names of the variations that have been learned.
    pub fn learned(&self) -> &[String] {
        &self.learned
    }

    /// The reference device as it is known now.
    pub fn device(&self) -> DutSpec {
        self.with(&self.learned)
    }

    /// The reference device of the manual without what was learned.
    pub fn plain(&self) -> DutSpec {
        self.with(&[])
    }

    fn with(&self, learned: &[String]) -> DutSpec {
        let mut deviations = [self.described.as_slice(), learned].concat();
        // Variations of one thing build on each other, in the order of the tables.
        let place = |name: &String| self.order.iter().position(|known| known == name);
        deviations.sort_by_key(place);
        DutSpec { manual: self.manual.clone(), variant: self.variant.clone(), kind: DutKind::Model { deviations } }
    }

    /// Looks for variations with which the reference device does what the device did: those that change the sequence at all are turned on
    /// and off one after the other, then in pairs, while the logs come closer. Returns whether the sequence is explained; if not, nothing
    /// is learned.
    pub fn explain(
        &mut self,
        bench: &ExploreBench<'_>,
        loaded: &LoadedSequences,
        number: usize,
        other: &SequenceLog,
        most_runs: usize,
    ) -> Result<bool, CannotExplore> {
        let device = &bench.manual().device;
        let mut search = Search {
            reference: self,
            bench,
            loaded,
            number,
            other,
            counters: counters(device),
            known: BTreeMap::new(),
            most_runs,
        };
        let start: BTreeSet<usize> = search
            .reference
            .learned
            .iter()
            .filter_map(|name| search.reference.permitted.iter().position(|of| of == name))
            .collect();
        let explained = search.explain(start);
        let Some(explained) = explained else { return Ok(false) };
        let permitted = &self.permitted;
        self.learned = explained.iter().filter_map(|index| permitted.get(*index).cloned()).collect();
        Ok(true)
    }
}

impl LearnedReference {
    /// Learns the variations that bring the reference device closer to what the device did, one after the other.
    pub fn approach(&mut self, bench: &ExploreBench<'_>, loaded: &LoadedSequences, number: usize, other: &SequenceLog) {
        let start: BTreeSet<usize> =
            self.learned.iter().filter_map(|name| self.permitted.iter().position(|of| of == name)).collect();
        let (counters, most_runs) = (counters(&bench.manual().device), self.permitted.len());
        let known = BTreeMap::new();
        let mut search = Search { reference: self, bench, loaded, number, other, counters, known, most_runs };
        let effective = search.effective(&start);
        let best = search.descend(start, &effective);
        self.learned = best.iter().filter_map(|index| self.permitted.get(*index).cloned()).collect();
    }
}

/// How far the logs are apart with each set of variations.
struct Search<'a, 'm> {
    reference: &'a LearnedReference,
    bench: &'a ExploreBench<'m>,
    loaded: &'a LoadedSequences,
    number: usize,
    other: &'a SequenceLog,
    counters: Counters,
    known: BTreeMap<BTreeSet<usize>, f64>,
    most_runs: usize,
}

impl Search<'_, '_> {
    fn distance(&mut self, set: &BTreeSet<usize>) -> f64 {
        if let Some(known) = self.known.get(set) {
            return *known;
        }
        let names: Vec<String> = set.iter().filter_map(|index| self.reference.permitted.get(*index).cloned()).collect();
        let observed = self.bench.run(self.loaded, self.number, &self.reference.with(&names));
        let distance = observed.map_or(f64::INFINITY, |observed| match self.bench.first(&observed, self.other) {
            None => 0.0,
            Some(_) => {
                let settled = self.bench.count_settled(&observed, self.other).map(|count| count as f64);
                let exact = || distance(&observed.log, &self.other.log, &self.counters);
                settled.unwrap_or_else(exact).max(f64::MIN_POSITIVE)
            }
        });
        self.known.insert(set.clone(), distance);
        distance
    }

    fn explain(&mut self, start: BTreeSet<usize>) -> Option<BTreeSet<usize>> {
        let mut best = start;
        let mut effective = self.effective(&best);
        loop {
            let before = self.distance(&best);
            best = self.descend(best, &effective);
            let reached = self.distance(&best);
            if reached == 0.0 {
                return Some(best);
            }
            if reached >= before {
                break;
            }
            // What had no effect before may have one now.
            effective.extend(self.effective(&best));
            effective.sort_unstable();
            effective.dedup();
        }
        let mut draw = Draw::new(effective.len() as u64);
        // Few variations have fewer sets than runs, so that the tries are counted as well.
        for _ in 0..self.most_runs {
            if self.known.len() >= self.most_runs || effective.len() < 2 {
                break;
            }
            if self.distance(&best) == 0.0 {
                return Some(best);
            }
            best = match self.better_pair(&best, &effective) {
                Some(better) => self.descend(better, &effective),
                None => {
                    // From elsewhere, in case this is only the nearest place.
                    let count = draw.between(2, 5);
                    let others: Vec<usize> = (0..count).filter_map(|_| draw.one(&effective).copied()).collect();
                    let other = self.descend(toggled(&best, &others), &effective);
                    if self.distance(&other) < self.distance(&best) { other } else { best }
                }
            };
        }
        (self.distance(&best) == 0.0).then_some(best)
    }

    /// The variations that change the sequence when they are turned on or off.
    fn effective(&mut self, set: &BTreeSet<usize>) -> Vec<usize> {
        let begin = self.distance(set);
        (0..self.reference.permitted.len()).filter(|index| self.distance(&toggled(set, &[*index])) != begin).collect()
    }

    /// A pair may do what neither of the two does alone.
    fn better_pair(&mut self, set: &BTreeSet<usize>, effective: &[usize]) -> Option<BTreeSet<usize>> {
        let reached = self.distance(set);
        for (at, one) in effective.iter().enumerate() {
            for two in effective.iter().skip(at + 1) {
                if self.known.len() >= self.most_runs {
                    return None;
                }
                let trial = toggled(set, &[*one, *two]);
                if !self.known.contains_key(&trial) && self.distance(&trial) < reached {
                    return Some(trial);
                }
            }
        }
        None
    }

    /// Turns variations on and off as long as the logs come closer.
    fn descend(&mut self, mut set: BTreeSet<usize>, effective: &[usize]) -> BTreeSet<usize> {
        let mut reached = self.distance(&set);
        loop {
            let before = reached;
            for index in effective {
                let trial = toggled(&set, &[*index]);
                let distance = self.distance(&trial);
                if distance < reached {
                    (set, reached) = (trial, distance);
                }
            }
            if reached == 0.0 || reached >= before {
                return set;
            }
        }
    }
}

fn toggled(set: &BTreeSet<usize>, indices: &[usize]) -> BTreeSet<usize> {
    let mut set = set.clone();
    for index in indices {
        if !set.remove(index) {
            set.insert(*index);
        }
    }
    set
}
