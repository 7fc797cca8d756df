//! Explores a device until a limit: draws sequences, compares the device with the reference device, and makes a case of each difference.
//!
//! Without a reference device, only broken rules of the manual and errors of the protocol are found.

use crate::bench::{BrokenRule, CannotExplore, ExploreBench, LoadedSequences, SequenceLog};
use crate::case::CaseParts;
use crate::described::DeviceWords;
use crate::difference::{DifferenceName, LogDifference, LogDifferenceKind, first, protocol_errors};
use crate::draw::Draw;
use crate::learn::LearnedReference;
use crate::minimise::minimise;
use crate::sequence::{SequenceSource, at_position};
use crate::states::StateCoverage;
use crate::step::SequenceStep;
use compare::action::ControllerAction;
use compare::report::related;
use compare::write_case::WrittenCase;
use engine::DutSpec;
use engine::step_log::StepLog;
use results::verdict::Verdict;
use std::collections::BTreeSet;
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

/// The result of a campaign.
#[derive(Debug, Default)]
pub struct CampaignResult {
    pub sequences: u64,
    pub frames: u64,
    /// Whether it was interrupted before its limit.
    pub interrupted: bool,
    /// Sequences that say nothing, because this host or the line was late.
    pub spoilt: u64,
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
}

/// Explores a device.
pub struct Campaign<'a, 'm> {
    bench: &'a ExploreBench<'m>,
    dut: &'a DutSpec,
    options: &'a CampaignOptions,
    source: SequenceSource,
    reference: Option<LearnedReference>,
    known: BTreeSet<(LogDifferenceKind, DifferenceName)>,
    /// Sequences that reached something new.
    corpus: Vec<Vec<SequenceStep>>,
    result: CampaignResult,
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
        Campaign { bench, dut, options, source, reference, known: BTreeSet::new(), corpus, result }
    }

    /// Runs until a limit is reached. `progress` is called with each number of sequences and findings.
    pub fn run(mut self, progress: &mut dyn FnMut(u64, usize)) -> Result<CampaignResult, CannotExplore> {
        let began = Instant::now();
        let most = self.options.sequences.unwrap_or(u64::MAX);
        let findings = if self.options.most_findings == 0 { MOST_FINDINGS } else { self.options.most_findings };
        let is_over = |done: u64, found: usize| {
            done >= most || found >= findings || self.options.time.is_some_and(|time| began.elapsed() >= time)
        };
        while !self.result.interrupted && !is_over(self.result.sequences, self.result.findings.len()) {
            let begin = self.result.sequences;
            let count = TOGETHER.min(most - begin);
            let drawn: Vec<(Option<u64>, Vec<SequenceStep>)> =
                (begin..begin + count).map(|number| self.draw(number)).collect();
            let (seeds, mut drawn): (Vec<Option<u64>>, Vec<Vec<SequenceStep>>) = drawn.into_iter().unzip();
            for steps in &mut drawn {
                self.bench.retain_possible(steps, self.dut);
            }
            let loaded = self.load(&drawn);
            for (index, steps) in drawn.iter().enumerate() {
                if is_over(self.result.sequences, self.result.findings.len()) {
                    break;
                }
                self.result.sequences += 1;
                if let Some(Some((loaded, place))) = loaded.get(index) {
                    let seed = seeds.get(index).copied().flatten();
                    match self.sequence(begin + index as u64, seed, steps, loaded, *place) {
                        Err(CannotExplore::Interrupted) => {
                            self.result.interrupted = true;
                            break;
                        }
                        done => done?,
                    }
                }
                progress(self.result.sequences, self.result.findings.len());
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
        loaded: &LoadedSequences,
        place: usize,
    ) -> Result<(), CannotExplore> {
        let other = self.bench.run(loaded, place, self.dut)?;
        self.result.frames += other.frames as u64;
        if other.spoilt.is_some() {
            self.result.spoilt += 1;
            return Ok(());
        }
        let reference = self.expected(loaded, place, &other)?;
        let new = self.result.states.take(&self.bench.manual().device, steps, &reference.log);
        if new > NEW_PAIRS && self.corpus.len() < MOST_KEPT {
            self.corpus.push(steps.to_vec());
            self.result.kept.extend(seed);
        }
        let Some(found) = first(&reference, &other) else { return Ok(()) };
        if self.known.contains(&found.target()) {
            return Ok(());
        }
        self.difference(number, steps, found)
    }

    /// What the reference device does where `other` was done; without one, the same without errors.
    fn expected(
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
    fn both(&self, loaded: &LoadedSequences) -> Result<[SequenceLog; 2], CannotExplore> {
        let other = self.bench.run(loaded, 0, self.dut)?;
        Ok([self.expected(loaded, 0, &other)?, other])
    }

    /// Shortens a sequence with a difference, and looks for permitted variations that explain it.
    fn difference(&mut self, number: u64, steps: &[SequenceStep], found: LogDifference) -> Result<(), CannotExplore> {
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
            let Some(rest) = first(&reference, &other) else {
                self.known.insert(target);
                return self.unstable(number, steps, &found);
            };
            let is_explained = match &mut self.reference {
                Some(learned) => learned.explain(self.bench, &loaded, 0, &other, most_runs)?,
                None => false,
            };
            if !is_explained {
                let before = steps.len();
                if rest.step < small.len() {
                    return self.finding(number, before, &small, [&reference, &other], &rest);
                }
                // It shows after the last step.
                let mut longer = small.clone();
                longer.push(ControllerAction::Wait(AFTERWARDS).into());
                let loaded = self.bench.load(std::slice::from_ref(&longer))?;
                let [reference, other] = self.both(&loaded)?;
                return match first(&reference, &other) {
                    Some(rest) => self.finding(number, before, &longer, [&reference, &other], &rest),
                    None => self.unstable(number, steps, &rest),
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

    fn shows(&self, steps: &[SequenceStep]) -> Option<LogDifference> {
        let loaded = self.bench.load(&[steps.to_vec()]).ok()?;
        let [reference, other] = self.both(&loaded).ok()?;
        if other.spoilt.is_some() {
            return None;
        }
        first(&reference, &other)
    }

    fn words(&self) -> DeviceWords<'m> {
        DeviceWords { device: &self.bench.manual().device, variant: self.bench.variant_index() }
    }

    fn unstable(&mut self, number: u64, steps: &[SequenceStep], found: &LogDifference) -> Result<(), CannotExplore> {
        self.result.findings.push(Finding {
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
        });
        Ok(())
    }

    fn finding(
        &mut self,
        number: u64,
        before: usize,
        steps: &[SequenceStep],
        logs: [&SequenceLog; 2],
        found: &LogDifference,
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
            if let Some(found) = first(&one, &two) {
                placed.case = self.case(&placed, &one.log, &two.log, &found)?;
            }
            if placed.case.is_some() {
                finding = placed;
            }
        }
        self.result.findings.push(finding);
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
