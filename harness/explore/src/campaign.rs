//! Explores a device until a limit: draws sequences, compares the device with the reference device, and makes a case of each difference.
//!
//! Without a reference device, only broken rules of the manual and errors of the protocol are found.

use crate::bench::{CannotExplore, ExploreBench, LoadedSequences};
use crate::case::CaseParts;
use crate::described::DeviceWords;
use crate::difference::{DifferenceName, LogDifference, LogDifferenceKind, protocol_errors};
use crate::draw::Draw;
use crate::learn::LearnedReference;
use crate::live_steps::adapted;
use crate::minimise::minimise;
use crate::sequence::{SequenceSource, at_position};
use crate::sequence_log::{BrokenRule, SequenceLog};
use crate::states::StateCoverage;
use crate::step::SequenceStep;
use compare::action::ControllerAction;
use compare::report::related;
use compare::write_case::WrittenCase;
use engine::DutSpec;
use engine::step_log::StepLog;
use results::verdict::Verdict;
use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

/// How many sequences are loaded together.
const TOGETHER: u64 = 8;
/// The most sequences that are kept because they reached something new.
const MOST_KEPT: usize = 256;
/// A sequence is kept if it took more new pairs of transitions than this.
const NEW_PAIRS: usize = 8;
/// How many shorter sequences are tried for a finding.
const MOST_TRIES: usize = 400;
/// A device of which fewer sequences were run may have many variations.
const NEW_DEVICE: u64 = 2;
/// How many sets of variations are tried to explain a difference.
const MANY_RUNS: usize = 3000;
const FEW_RUNS: usize = 300;
/// Without a reference device, one of so many sequences is about what a power cycle keeps.
const RETENTION_EACH: u64 = 16;
/// How often a difference has to show.
const REPEATS: usize = 3;
/// The position of the shaft in a case that depends on it, in hardware steps.
const SHAFT: u64 = 0x1_2345;
/// The wait in which a difference after the last step shows.
const AFTERWARDS: Duration = Duration::from_millis(20);
/// How long the reference device is watched after the last step of a case.
const LATER: Duration = Duration::from_millis(500);
/// The most requirements of a written case.
const MOST_COVERED: usize = 3;
/// How many different findings end a campaign.
const MOST_FINDINGS: usize = 20;

/// The limits of a campaign, and what it is about.
#[derive(Clone, Debug, Default)]
pub struct CampaignOptions {
    pub seed: u64,
    /// How many sequences are run at most.
    pub sequences: Option<u64>,
    /// How long it takes at most.
    pub time: Option<Duration>,
    /// Sequences with these words are preferred.
    pub focus: Vec<String>,
    /// Seeds of sequences that an earlier campaign kept, to begin with.
    pub kept: Vec<u64>,
    /// How many different findings end the campaign; 0 for the usual number.
    pub most_findings: usize,
}

/// A true difference.
#[derive(Clone, Debug)]
pub struct Finding {
    /// What differs, as a name of the suite language where it has one.
    pub name: String,
    pub kind: LogDifferenceKind,
    /// What the reference device did.
    pub reference: String,
    /// What the device did.
    pub device: String,
    /// The number of the sequence.
    pub sequence: u64,
    /// Number of steps of that sequence.
    pub before: usize,
    /// The shortest steps that show it.
    pub steps: Vec<SequenceStep>,
    /// The case that fails on the device and passes on the reference device.
    pub case: Option<WrittenCase>,
    /// Rules of the suite that break in the steps.
    pub rules: Vec<BrokenRule>,
    /// Whether it showed in each of three repetitions.
    pub is_stable: bool,
}

/// What a campaign has just found.
#[derive(Clone, Copy, Debug)]
pub enum CampaignEvent<'e> {
    /// A difference has shown again; its sequence is shortened now.
    Confirmed {
        /// The number of the finding, from 1.
        number: usize,
        /// What differs.
        name: &'e str,
        steps: &'e [SequenceStep],
    },
    /// A finding is complete.
    Found {
        /// Its number, from 1.
        number: usize,
        finding: &'e Finding,
    },
}

/// Takes what a campaign finds, at once.
pub type CampaignEvents<'e> = &'e mut dyn FnMut(CampaignEvent<'_>);

/// The result of a campaign.
#[derive(Debug, Default)]
pub struct CampaignResult {
    pub sequences: u64,
    pub frames: u64,
    /// Whether it was interrupted before its limit.
    pub interrupted: bool,
    /// Sequences that say nothing, because this host or the line was late.
    pub spoilt: u64,
    /// Why they say nothing: what the reasons have in common up to the first number, with the first of them and how many there are.
    pub spoilt_by: BTreeMap<String, (String, u64)>,
    /// Differences on a live device that did not show again or that other times explain, by name, each with how many.
    pub unconfirmed: BTreeMap<String, u64>,
    /// Why the campaign ended before its limit.
    pub ended: Option<String>,
    /// Sequences that did not load, each with why; there should be none.
    pub invalid: Vec<String>,
    pub findings: Vec<Finding>,
    /// The permitted variations that the device has.
    pub learned: Vec<String>,
    pub states: StateCoverage,
    /// Seeds of new sequences that reached something new.
    pub kept: Vec<u64>,
}

impl CampaignResult {
    /// Whether a sequence said anything about the device.
    pub fn says_something(&self) -> bool {
        self.spoilt < self.sequences
    }

    /// Whether it ran to its limit.
    pub fn is_complete(&self) -> bool {
        !self.interrupted && self.ended.is_none()
    }
}

/// Explores a device.
pub struct Campaign<'a, 'm> {
    pub(crate) bench: &'a ExploreBench<'m>,
    pub(crate) dut: &'a DutSpec,
    options: &'a CampaignOptions,
    source: SequenceSource,
    pub(crate) reference: Option<LearnedReference>,
    pub(crate) known: BTreeSet<(LogDifferenceKind, DifferenceName)>,
    /// The sequence before.
    pub(crate) last: Vec<SequenceStep>,
    /// Sequences that reached something new.
    corpus: Vec<Vec<SequenceStep>>,
    pub(crate) result: CampaignResult,
}

impl<'a, 'm> Campaign<'a, 'm> {
    /// A campaign about `dut`, which is compared with `reference` if there is one.
    pub fn new(
        bench: &'a ExploreBench<'m>,
        dut: &'a DutSpec,
        reference: Option<LearnedReference>,
        options: &'a CampaignOptions,
    ) -> Self {
        let source = SequenceSource::broad(bench.manual());
        let corpus = options.kept.iter().take(MOST_KEPT).map(|seed| source.steps(*seed)).collect();
        let result = CampaignResult { kept: options.kept.clone(), ..CampaignResult::default() };
        Campaign { bench, dut, options, source, reference, known: BTreeSet::new(), last: Vec::new(), corpus, result }
    }

    /// Runs until a limit is reached. `events` is called with each finding.
    pub fn run(mut self, events: CampaignEvents<'_>) -> Result<CampaignResult, CannotExplore> {
        let began = Instant::now();
        let most = self.options.sequences.unwrap_or(u64::MAX);
        let findings = if self.options.most_findings == 0 { MOST_FINDINGS } else { self.options.most_findings };
        let is_over = |done: u64, found: usize| {
            done >= most || found >= findings || self.options.time.is_some_and(|time| began.elapsed() >= time)
        };
        while !self.result.interrupted
            && self.result.ended.is_none()
            && !is_over(self.result.sequences, self.result.findings.len())
        {
            let begin = self.result.sequences;
            // What the bench of a live device permits changes with each sequence.
            let count = if self.bench.is_live() { 1 } else { TOGETHER }.min(most - begin);
            let drawn: Vec<(Option<u64>, Vec<SequenceStep>)> =
                (begin..begin + count).map(|number| self.draw(number)).collect();
            let (seeds, mut drawn): (Vec<Option<u64>>, Vec<Vec<SequenceStep>>) = drawn.into_iter().unzip();
            for steps in &mut drawn {
                if self.bench.is_live() {
                    *steps = adapted(std::mem::take(steps), self.reference.is_some());
                }
                self.bench.retain_possible(steps, self.dut);
            }
            let loaded = self.load(&drawn);
            for (index, steps) in drawn.iter().enumerate() {
                if self.result.ended.is_some() || is_over(self.result.sequences, self.result.findings.len()) {
                    break;
                }
                self.result.sequences += 1;
                if let Some(Some((loaded, place))) = loaded.get(index) {
                    let seed = seeds.get(index).copied().flatten();
                    match self.sequence(begin + index as u64, seed, steps, (loaded, *place), events) {
                        Err(CannotExplore::Interrupted) => {
                            self.result.interrupted = true;
                            break;
                        }
                        done => done?,
                    }
                }
            }
        }
        self.result.learned = self.reference.iter().flat_map(LearnedReference::learned).cloned().collect();
        Ok(self.result)
    }

    /// Loads sequences together; where one is wrong, each alone.
    fn load(&mut self, drawn: &[Vec<SequenceStep>]) -> Vec<Option<(std::rc::Rc<LoadedSequences>, usize)>> {
        if let Ok(loaded) = self.bench.load(drawn) {
            let loaded = std::rc::Rc::new(loaded);
            return (0..drawn.len()).map(|place| Some((loaded.clone(), place))).collect();
        }
        let mut list = Vec::new();
        for steps in drawn {
            match self.bench.load(std::slice::from_ref(steps)) {
                Ok(loaded) => list.push(Some((std::rc::Rc::new(loaded), 0))),
                Err(error) => {
                    self.result.invalid.push(error.to_string());
                    list.push(None);
                }
            }
        }
        list
    }

    /// The sequence with this number: a new one, or one that reached something new with another end.
    ///
    /// A new one has a seed.
    fn draw(&self, number: u64) -> (Option<u64>, Vec<SequenceStep>) {
        let mut draw = Draw::new(self.options.seed.wrapping_mul(0x1_0001).wrapping_add(number));
        if self.reference.is_none() && number % RETENTION_EACH == RETENTION_EACH - 1 {
            let save = self.bench.manual().device.parameter_access.save;
            if let Some(steps) = self.source.retention(save, draw.bits()) {
                return (None, steps);
            }
        }
        let focus = &self.options.focus;
        let hits = |(_, steps): &(u64, Vec<SequenceStep>)| {
            let text: String = steps.iter().map(|step| step.action.yaml()).collect();
            focus.iter().map(|word| text.matches(word.as_str()).count()).sum::<usize>()
        };
        let tries = if focus.is_empty() { 1 } else { 5 };
        let candidates = (0..tries).map(|_| draw.bits()).map(|seed| (seed, self.source.steps(seed)));
        let (seed, new) = candidates.max_by_key(hits).unwrap_or_default();
        if !draw.chance(35) {
            return (Some(seed), new);
        }
        let Some(kept) = draw.one(&self.corpus) else { return (Some(seed), new) };
        let cut = draw.between(1, kept.len() as u64) as usize;
        let begins =
            |step: &SequenceStep| matches!(step.action, ControllerAction::Connect(_)) && step.modifiers.is_empty();
        let from = new.iter().enumerate().filter(|(_, step)| begins(step)).map(|(index, _)| index).collect::<Vec<_>>();
        let from = draw.one(&from).copied().unwrap_or_default();
        (None, kept.iter().take(cut).chain(new.iter().skip(from)).cloned().collect())
    }

    fn sequence(
        &mut self,
        number: u64,
        seed: Option<u64>,
        steps: &[SequenceStep],
        (loaded, place): (&LoadedSequences, usize),
        events: CampaignEvents<'_>,
    ) -> Result<(), CannotExplore> {
        let other = self.bench.run(loaded, place, self.dut)?;
        self.result.frames += other.frames as u64;
        if let Some(why) = other.spoilt {
            self.result.spoilt += 1;
            let common = why.split(|letter: char| letter.is_ascii_digit()).find(|part| !part.is_empty()).unwrap_or("");
            self.result.spoilt_by.entry(common.to_owned()).or_insert((why, 0)).1 += 1;
            return Ok(());
        }
        if self.bench.is_live() && other.is_silent() {
            return self.lost_device(number, steps, &other, events);
        }
        self.last = steps.to_vec();
        let reference = self.expected(loaded, place, &other)?;
        let new = self.result.states.take(&self.bench.manual().device, steps, &reference.log);
        if new > NEW_PAIRS && self.corpus.len() < MOST_KEPT {
            self.corpus.push(steps.to_vec());
            self.result.kept.extend(seed);
        }
        let Some(found) = self.bench.first(&reference, &other) else { return Ok(()) };
        if self.known.contains(&found.target()) {
            return Ok(());
        }
        if self.bench.is_live() {
            return self.live_difference(number, steps, &found, events);
        }
        self.difference(number, steps, found, events)
    }

    /// What the reference device does where `other` was done; without one, the same without errors.
    pub(crate) fn expected(
        &self,
        loaded: &LoadedSequences,
        place: usize,
        other: &SequenceLog,
    ) -> Result<SequenceLog, CannotExplore> {
        match &self.reference {
            Some(reference) => self.bench.run(loaded, place, &reference.device()),
            None => Ok(other.without_errors()),
        }
    }

    /// What both devices do in these steps.
    pub(crate) fn both(&self, loaded: &LoadedSequences) -> Result<[SequenceLog; 2], CannotExplore> {
        let other = self.bench.run(loaded, 0, self.dut)?;
        Ok([self.expected(loaded, 0, &other)?, other])
    }

    /// Shortens a sequence with a difference, and looks for permitted variations that explain it.
    fn difference(
        &mut self,
        number: u64,
        steps: &[SequenceStep],
        found: LogDifference,
        events: CampaignEvents<'_>,
    ) -> Result<(), CannotExplore> {
        let mut found = found;
        let mut steps_left: Vec<SequenceStep> = steps.iter().take(found.step.saturating_add(1)).cloned().collect();
        loop {
            let target = found.target();
            let shows = |steps: &[SequenceStep]| self.shows(steps).is_some_and(|of| of.target() == target);
            if !shows(&steps_left) {
                // What differs only with the steps after it.
                steps_left = steps.to_vec();
            }
            let mut left = MOST_TRIES;
            let small = minimise(steps_left.clone(), &mut |steps| {
                left -= usize::from(left > 0);
                left > 0 && shows(steps)
            });
            let loaded = self.bench.load(std::slice::from_ref(&small))?;
            let [reference, other] = self.both(&loaded)?;
            if other.spoilt.is_some() {
                return Ok(());
            }
            // A device that was as the reference device so far has few variations, if any.
            let has_variations = self.reference.as_ref().is_some_and(|of| !of.learned().is_empty());
            let most_runs = if has_variations || self.result.sequences <= NEW_DEVICE { MANY_RUNS } else { FEW_RUNS };
            let Some(rest) = self.bench.first(&reference, &other) else {
                self.known.insert(target);
                return self.unstable(number, steps, &found, events);
            };
            let is_explained = match &mut self.reference {
                Some(learned) => learned.explain(self.bench, &loaded, 0, &other, most_runs)?,
                None => false,
            };
            if !is_explained {
                let before = steps.len();
                if rest.step < small.len() {
                    return self.finding((number, before), &small, [&reference, &other], &rest, events);
                }
                // It shows after the last step.
                let mut longer = small.clone();
                longer.push(ControllerAction::Wait(AFTERWARDS).into());
                let loaded = self.bench.load(std::slice::from_ref(&longer))?;
                let [reference, other] = self.both(&loaded)?;
                return match self.bench.first(&reference, &other) {
                    Some(rest) => self.finding((number, before), &longer, [&reference, &other], &rest, events),
                    None => self.unstable(number, steps, &rest, events),
                };
            }
            // It is explained; what else is there?
            match self.shows(steps) {
                Some(more) if !self.known.contains(&more.target()) => found = more,
                _ => return Ok(()),
            }
            steps_left = steps.iter().take(found.step.saturating_add(1)).cloned().collect();
        }
    }

    pub(crate) fn shows(&self, steps: &[SequenceStep]) -> Option<LogDifference> {
        let loaded = self.bench.load(&[steps.to_vec()]).ok()?;
        let [reference, other] = self.both(&loaded).ok()?;
        if other.spoilt.is_some() {
            return None;
        }
        self.bench.first(&reference, &other)
    }

    pub(crate) fn words(&self) -> DeviceWords<'m> {
        DeviceWords { device: &self.bench.manual().device, variant: self.bench.variant_index() }
    }

    pub(crate) fn unstable(
        &mut self,
        number: u64,
        steps: &[SequenceStep],
        found: &LogDifference,
        events: CampaignEvents<'_>,
    ) -> Result<(), CannotExplore> {
        let finding = Finding {
            name: self.words().name(found, [&StepLog::default(), &StepLog::default()]),
            kind: found.kind,
            reference: String::new(),
            device: String::new(),
            sequence: number,
            before: steps.len(),
            steps: steps.to_vec(),
            case: None,
            rules: Vec::new(),
            is_stable: false,
        };
        self.add(finding, events);
        Ok(())
    }

    /// Adds a finding and says so.
    pub(crate) fn add(&mut self, finding: Finding, events: CampaignEvents<'_>) {
        let number = self.result.findings.len() + 1;
        events(CampaignEvent::Found { number, finding: &finding });
        self.result.findings.push(finding);
    }

    pub(crate) fn finding(
        &mut self,
        (number, before): (u64, usize),
        steps: &[SequenceStep],
        logs: [&SequenceLog; 2],
        found: &LogDifference,
        events: CampaignEvents<'_>,
    ) -> Result<(), CannotExplore> {
        self.known.insert(found.target());
        let is_stable = (0..REPEATS).all(|_| self.shows(steps).is_some_and(|of| of.target() == found.target()));
        let [expected, seen] = logs;
        let is_new = |rule: &&BrokenRule| expected.broken.iter().all(|of| of.id != rule.id);
        let rules: Vec<BrokenRule> = seen.broken.iter().filter(is_new).cloned().collect();
        let [reference, other] = logs.map(|of| &of.log);
        let value = |log: &StepLog| self.words().value(log, found);
        let name = self.words().name(found, [reference, other]);
        let mut finding = Finding {
            name,
            kind: found.kind,
            reference: value(reference),
            device: match found.kind {
                LogDifferenceKind::Protocol => protocol_errors(reference, other).join(" "),
                LogDifferenceKind::Rule => rules.iter().map(|rule| rule.what.as_str()).collect::<Vec<_>>().join(" "),
                _ => value(other),
            },
            sequence: number,
            before,
            steps: steps.to_vec(),
            case: None,
            rules,
            is_stable,
        };
        finding.case = self.case(&finding, reference, other, found)?;
        if finding.case.is_none() && !found.kind.is_error() && self.reference.is_some() {
            // What depends on the position of the shaft needs it.
            let mut placed = finding.clone();
            placed.steps.insert(0, at_position(SHAFT));
            let loaded = self.bench.load(std::slice::from_ref(&placed.steps))?;
            let [one, two] = self.both(&loaded)?;
            if let Some(found) = self.bench.first(&one, &two) {
                placed.case = self.case(&placed, &one.log, &two.log, &found)?;
            }
            if placed.case.is_some() {
                finding = placed;
            }
        }
        self.add(finding, events);
        Ok(())
    }

    /// The first form of a case that passes on the reference device and fails on the device; none without a reference device.
    fn case(
        &self,
        finding: &Finding,
        reference: &StepLog,
        other: &StepLog,
        found: &LogDifference,
    ) -> Result<Option<WrittenCase>, CannotExplore> {
        let manual = self.bench.manual();
        let variant = self.bench.variant_index();
        let Some(device) = self.reference.as_ref().map(LearnedReference::device) else { return Ok(None) };
        let mut longer = finding.steps.clone();
        longer.push(ControllerAction::Wait(LATER).into());
        let later = self.bench.drive(&longer, &device)?;
        let after = later.log.steps.get(finding.steps.len());
        let (manual_device, steps) = (&manual.device, finding.steps.as_slice());
        let parts = CaseParts { device: manual_device, variant, steps, reference, other, difference: found, after };
        let applies = |id: &String| manual.requirements.iter().any(|of| of.id == *id && of.variants.contains(&variant));
        let mut covers: Vec<String> =
            finding.rules.iter().flat_map(|rule| rule.covers.clone()).filter(applies).collect();
        covers.dedup();
        let source = if covers.is_empty() {
            "guessed from the name: check them"
        } else {
            "those of the rules that break in its steps"
        };
        if covers.is_empty() {
            let id = |index: usize| manual.requirements.get(index).map(|of| of.id.clone());
            let guessed = related(manual, variant, &finding.name).and_then(id).filter(applies);
            let any = || manual.requirements.iter().map(|of| of.id.clone()).find(applies);
            covers.extend(guessed.or_else(any));
        }
        covers.truncate(MOST_COVERED);
        for steps in parts.forms() {
            let case = WrittenCase {
                comment: vec![
                    format!("Found by `encspec explore` on {}/{}.", manual.device.name, self.bench.variant()),
                    format!(
                        "{}: reference device {}, this device {}.",
                        finding.name, finding.reference, finding.device
                    ),
                    format!("The requirements are {source}."),
                ],
                id: format!("explored-{}", self.result.findings.len() + 1),
                why: format!("{} is as on the reference device.", finding.name.replace(['{', '}', '"'], "")),
                covers: covers.clone(),
                catches: Vec::new(),
                variant: self.bench.variant().to_owned(),
                steps,
            };
            let verdict = |dut: &DutSpec| self.bench.judge(&case, dut, None).map(|outcome| outcome.case.verdict);
            let (Ok(Verdict::Pass), Ok(Verdict::Fail)) = (verdict(&device), verdict(self.dut)) else { continue };
            return Ok(Some(case));
        }
        Ok(None)
    }
}
