//! Judges the rules of the manuals on recorded frames.

use super::finding::{CaptureFinding, rule_finding};
use super::missing_values::MissingValues;
use super::report::RuleReport;
use judge::evidence::Blips;
use judge::follow::{ConnectionChange, Follower};
use judge::image::CurrentEvent;
use judge::observe::{Address, ArId, BusTracker, Observation, ObservedAr};
use judge::parameter_cache::ParameterCache;
use judge::rule::RuleWatch;
use judge::rule_set::RuleSet;
use judge::slow::SlowReaction;
use judge::view::{NameView, TrialValues};
use judge::violation::RuleViolation;
use judge::{JudgeTick, TickKind};
use results::outcome::DecisionCounts;
use results::verdict::Verdict;
use station::{Duration, Time};
use suite::device::{Bus, DeviceDescription, DeviceModule, PerBus};
use suite::model::{Manual, SuiteRule, SuiteVariant};

/// A hold without samples for longer than this stays undecided.
const WATCHDOG: Duration = Duration::from_secs(1);
/// Upper limit of the pairs of controller and device whose rules are judged.
const MOST_PAIRS: usize = 64;

/// The result of a rule on some frames.
#[derive(Clone, Debug)]
pub struct RuleOutcome {
    /// Index into the rules of the variant.
    pub rule: usize,
    /// How often it was decided.
    pub decided: DecisionCounts,
    /// The first time it was broken.
    pub violation: Option<RuleViolation>,
    /// The first time that only a single frame showed it broken, so the capture may be at fault.
    pub single_frame: Option<RuleViolation>,
    /// What came later than the limit of the rule, which is ours.
    pub slow: Option<SlowReaction>,
    /// Why it could not be decided: the names of the rule that the frames do not show; `None` if they show all.
    pub missing_values: Option<String>,
}

impl RuleOutcome {
    /// `fail` if it was broken; `inconclusive` if only a single frame shows it broken, or if it was never decided because the frames
    /// lack names of the rule or ended too early; `not-run` if its premise never occurred; else `pass`.
    pub fn verdict(&self) -> Verdict {
        match (&self.violation, &self.single_frame, self.decided.premises) {
            (Some(_), ..) => Verdict::Fail,
            (None, Some(_), _) => Verdict::Inconclusive,
            (None, None, 0) if self.missing_values.is_some() || self.decided.undecided > 0 => Verdict::Inconclusive,
            (None, None, 0) => Verdict::NotRun,
            (None, None, _) => Verdict::Pass,
        }
    }

    /// Why it is inconclusive.
    fn undecided(&self) -> String {
        match (&self.single_frame, &self.missing_values, self.decided.undecided) {
            (Some(violation), ..) => {
                format!("only frame {} shows it broken; the capture or the line may be at fault", violation.frame())
            }
            (None, Some(unseen), _) => unseen.clone(),
            (None, None, 1) => {
                "its premise occurred once, but the frames ended or were missing before it was decided".to_owned()
            }
            (None, None, times) => {
                format!(
                    "its premise occurred {times} times, but each time the frames ended or were missing before it was decided"
                )
            }
        }
    }

    fn add(&mut self, other: RuleOutcome) {
        self.decided.premises += other.decided.premises;
        self.decided.undecided += other.decided.undecided;
        self.decided.checked += other.decided.checked;
        self.violation = first(self.violation.take(), other.violation);
        self.single_frame = first(self.single_frame.take(), other.single_frame);
        self.slow = SlowReaction::of_both(self.slow, other.slow);
        self.missing_values = self.missing_values.take().or(other.missing_values);
    }
}

/// The violation with the earlier frame.
fn first(one: Option<RuleViolation>, other: Option<RuleViolation>) -> Option<RuleViolation> {
    match (one, other) {
        (Some(one), Some(other)) if other.tick.frame < one.tick.frame => Some(other),
        (one, other) => one.or(other),
    }
}

/// The rules of one variant.
#[derive(Debug)]
struct VariantRules<'a> {
    variant: &'a SuiteVariant,
    rules: RuleSet<'a>,
    unseen: MissingValues,
    settled: ParameterCache,
}

/// Judges the rules of some variants of a manual on the connections of one controller and one device, one after the other.
#[derive(Debug)]
pub struct RuleJudge<'a> {
    device: &'a DeviceDescription,
    follower: Follower,
    /// Values from outside the frames: none on a capture.
    notebook: TrialValues,
    variants: Vec<VariantRules<'a>>,
    /// Set on recorded frames only.
    blips: Option<Box<Blips>>,
    /// The connection of the last frame or event.
    ar: Option<ArId>,
    /// Whether a rule was broken since the findings were taken.
    has_changed: bool,
}

impl<'a> RuleJudge<'a> {
    /// A judge that has received no frame.
    pub fn new(manual: &'a Manual, variants: impl IntoIterator<Item = &'a SuiteVariant>) -> RuleJudge<'a> {
        let device: &DeviceDescription = &manual.device;
        let of = |variant: &'a SuiteVariant| {
            let rules = RuleSet::new(&variant.rules, WATCHDOG);
            VariantRules { variant, rules, unseen: MissingValues::new(variant), settled: ParameterCache::default() }
        };
        let (follower, notebook) = (Follower::new(device), TrialValues::default());
        let variants = variants.into_iter().map(of).collect();
        RuleJudge { device, follower, notebook, variants, blips: None, ar: None, has_changed: false }
    }

    /// The same for recorded frames, of which some may be missing or damaged.
    #[must_use]
    pub fn recorded(self) -> RuleJudge<'a> {
        let recorded = |of: VariantRules<'a>| VariantRules { rules: of.rules.recorded(), ..of };
        let variants = self.variants.into_iter().map(recorded).collect();
        RuleJudge { variants, blips: Some(Box::default()), ..self }
    }

    /// Takes in an observation of the judged connection, or one without a connection.
    pub fn observe(&mut self, ars: &[ObservedAr], at: (Time, u64), observation: &Observation<'_>) {
        self.ar = observation.ar().or(self.ar);
        if let Observation::Gap { .. } = observation {
            self.follower.image.interrupt();
            return self.cut();
        }
        match self.follower.observe(self.device, ars, |_| true, at, observation) {
            Some(ConnectionChange::Opened) => self.cut(),
            Some(ConnectionChange::Tick(tick)) => self.tick(tick),
            Some(ConnectionChange::Closed(tick, _)) => {
                self.tick(tick);
                self.cut();
            }
            None => {}
        }
    }

    fn cut(&mut self) {
        if let Some(blips) = &mut self.blips {
            blips.forget();
        }
        self.variants.iter_mut().for_each(|of| of.rules.cut());
    }

    fn tick(&mut self, tick: JudgeTick) {
        let RuleJudge { device, follower, notebook, variants, blips, .. } = self;
        let blip = blips.as_mut().and_then(|blips| blips.take(&follower.image, tick.frame));
        for VariantRules { variant, rules, unseen, settled } in variants {
            let (image, settled) = (&follower.image, Some(&*settled));
            let view = NameView { device, variant, image, notebook, tick, reads: None, settled };
            unseen.tick(&view);
            rules.tick(&view, blip.as_ref());
        }
        // An event is true at one instant only.
        if tick.kind == TickKind::Event {
            follower.image.happening = CurrentEvent::Nothing;
        }
    }

    /// Advances the time: a deadline may expire without a frame.
    pub fn time(&mut self, now: Time, frame: u64) {
        let RuleJudge { device, follower, notebook, variants, .. } = self;
        let tick = JudgeTick { time: now, frame, kind: TickKind::Event };
        for VariantRules { variant, rules, settled, .. } in variants {
            let (image, settled) = (&follower.image, Some(&*settled));
            rules.time(&NameView { device, variant, image, notebook, tick, reads: None, settled }, now);
        }
    }

    /// Whether a rule was broken since the last [`new_violations`](Self::new_violations).
    fn has_news(&self) -> bool {
        self.variants.iter().any(|of| of.rules.is_newly_broken())
    }

    /// Where rules were broken, if one was broken since the last call: the frame that shows it, the frame that triggered it, and the
    /// connection.
    fn new_violations(&mut self) -> impl Iterator<Item = NewViolation> {
        let ar = self.ar;
        self.has_changed = true;
        let new = self.variants.iter_mut().filter_map(|of| of.rules.take_newly_broken().then_some(&of.rules));
        let broken =
            new.flat_map(|rules| rules.iter().filter_map(|(_, watch)| watch.violation().or(watch.unconfirmed())));
        broken.map(move |of| NewViolation { frame: of.frame(), trigger: of.trigger.map(|tick| tick.frame), ar })
    }

    /// The result of each rule of each variant, in their order; open premises stay undecided.
    pub fn end(mut self) -> Vec<Vec<RuleOutcome>> {
        self.cut();
        self.outcomes()
    }

    /// The result of each rule of each variant so far, in their order.
    fn outcomes(&self) -> Vec<Vec<RuleOutcome>> {
        let outcome =
            |unseen: &MissingValues, (rule, (of, watch)): (usize, (&SuiteRule, &RuleWatch<'_>))| RuleOutcome {
                rule,
                decided: watch.decided(),
                violation: watch.violation().cloned(),
                single_frame: watch.unconfirmed().cloned(),
                slow: watch.slow(),
                missing_values: unseen.of(of),
            };
        let of = |of: &VariantRules<'_>| of.rules.iter().enumerate().map(|rule| outcome(&of.unseen, rule)).collect();
        self.variants.iter().map(of).collect()
    }
}

/// The frames and the connection of a broken rule.
#[derive(Clone, Copy, Debug)]
pub(super) struct NewViolation {
    pub frame: u64,
    pub trigger: Option<u64>,
    pub ar: Option<ArId>,
}

/// Whether a connection belongs to a device of this manual: it has its identity and the submodules of one of its modules.
pub fn fits_manual(manual: &Manual, ar: &ObservedAr) -> bool {
    let device = &manual.device;
    if let Some(slave) = &ar.slave {
        let is_module = |module: &DeviceModule| slave.configuration.as_deref() == Some(module.cfg());
        return device.profibus().is_some()
            && ar.device.ident == device.ident()
            && device.modules.iter().any(is_module);
    }
    ar.device.ids == Some(device.ids().unwrap_or_default()) && fits_modules(device, ar)
}

/// Whether the submodules of a connection have the idents of a module of the manual, whatever vendor and device ID they belong to.
pub fn fits_modules(device: &DeviceDescription, ar: &ObservedAr) -> bool {
    let placed = |index: &usize| {
        device.submodules.get(*index).is_some_and(|submodule| {
            let submodule = (submodule.slot, submodule.subslot, submodule.ident);
            ar.submodules.iter().any(|placed| (placed.slot, placed.subslot, placed.submodule_ident) == submodule)
        })
    };
    let mut modules = device.modules.iter();
    modules.any(|module| !module.submodules.is_empty() && module.submodules.iter().all(placed))
}

/// Judges the rules of one variant (index into `manual.variants`) on frames: number from 1, time, bytes.
/// The frames are those of a trial, in which the harness is the only controller or master.
///
/// `ours` selects the connections; use [`fits_manual`] for a capture of unknown origin. An unknown variant has no rules.
pub fn judge_rules<'f>(
    frames: impl Iterator<Item = (u64, Time, &'f [u8])>,
    manual: &Manual,
    variant: usize,
    ours: impl Fn(&ObservedAr) -> bool,
) -> Vec<RuleOutcome> {
    let Some(variant) = manual.variants.get(variant) else { return Vec::new() };
    let mut tracker = BusTracker::of_harness(manual.device.bus.kind());
    let mut pairs = ManualJudges { manual, variants: vec![variant], judges: Vec::new(), is_recorded: false };
    let mut of = ConnectionJudges::default();
    for (number, time, octets) in frames {
        pairs.judges.iter_mut().for_each(|(_, judge)| judge.time(time, number));
        tracker.frame(number, time, octets, &mut |ars, observation| {
            of.observe(std::slice::from_mut(&mut pairs), ars, (time, number), &observation, |_, ar| ours(ar));
        });
    }
    pairs.end().pop().unwrap_or_default()
}

/// The judges of a manual, one for each pair of controller and device.
#[derive(Debug)]
struct ManualJudges<'a> {
    manual: &'a Manual,
    variants: Vec<&'a SuiteVariant>,
    judges: Vec<((Address, Address), RuleJudge<'a>)>,
    /// Whether the frames come from a capture.
    is_recorded: bool,
}

impl ManualJudges<'_> {
    /// The judge for the pair of a connection; `None` if there are too many pairs.
    fn judge(&mut self, ar: &ObservedAr) -> Option<usize> {
        let pair = (ar.controller.address, ar.device.address);
        let known = self.judges.iter().position(|(known, _)| *known == pair);
        known.or_else(|| {
            (self.judges.len() < MOST_PAIRS).then(|| {
                let judge = RuleJudge::new(self.manual, self.variants.iter().copied());
                self.judges.push((pair, if self.is_recorded { judge.recorded() } else { judge }));
                self.judges.len() - 1
            })
        })
    }

    /// The results of the rules of each variant over all pairs.
    fn end(self) -> Vec<Vec<RuleOutcome>> {
        let nothing = |rule| RuleOutcome {
            rule,
            decided: DecisionCounts::default(),
            violation: None,
            single_frame: None,
            slow: None,
            missing_values: None,
        };
        let none = |variant: &&SuiteVariant| (0..variant.rules.len()).map(nothing).collect();
        let mut outcomes: Vec<Vec<RuleOutcome>> = self.variants.iter().map(none).collect();
        for (_, judge) in self.judges {
            for (sum, of) in outcomes.iter_mut().zip(judge.end()) {
                sum.iter_mut().zip(of).for_each(|(sum, of)| sum.add(of));
            }
        }
        outcomes
    }
}

/// For each connection of a bus the judges that observe it: index of the manual's pairs, and index of the judge among them.
#[derive(Debug, Default)]
struct ConnectionJudges(Vec<Vec<(usize, usize)>>);

impl ConnectionJudges {
    /// Passes the observation to its judges; returns whether one of them has found a broken rule.
    fn observe(
        &mut self,
        pairs: &mut [ManualJudges<'_>],
        ars: &[ObservedAr],
        at: (Time, u64),
        observation: &Observation<'_>,
        ours: impl Fn(&Manual, &ObservedAr) -> bool,
    ) -> bool {
        if let Observation::Connected { ar } = observation {
            self.connected(pairs, ars, *ar, ours);
        }
        let mut has_news = false;
        let mut pass_on = |judge: &mut RuleJudge<'_>| {
            judge.observe(ars, at, observation);
            has_news |= judge.has_news();
        };
        match observation.ar() {
            Some(ar) => {
                for &(pair, judge) in self.0.get(ar.0 as usize).into_iter().flatten() {
                    pass_on(&mut pairs[pair].judges[judge].1);
                }
            }
            None => pairs.iter_mut().flat_map(|pairs| &mut pairs.judges).for_each(|(_, judge)| pass_on(judge)),
        }
        has_news
    }

    fn connected(
        &mut self,
        pairs: &mut [ManualJudges<'_>],
        ars: &[ObservedAr],
        id: ArId,
        ours: impl Fn(&Manual, &ObservedAr) -> bool,
    ) {
        let Some(ar) = ars.get(id.0 as usize) else { return };
        let index = id.0 as usize;
        self.0.resize_with(self.0.len().max(index + 1), Vec::new);
        let ours = pairs.iter_mut().enumerate().filter(|(_, pairs)| ours(pairs.manual, ar));
        self.0[index] = ours.filter_map(|(place, pairs)| Some((place, pairs.judge(ar)?))).collect();
    }
}

/// The rules of all manuals on one capture; a device without a given variant may be any variant of its manual.
#[derive(Debug)]
pub(super) struct CaptureRules<'a> {
    pairs: PerBus<(Vec<ManualJudges<'a>>, ConnectionJudges)>,
    /// Whether a rule was broken since the last call of [`new_violations`](Self::new_violations).
    has_news: bool,
}

impl<'a> CaptureRules<'a> {
    pub fn new(manuals: &'a [Manual]) -> CaptureRules<'a> {
        let of = |bus: Bus| {
            let manuals = manuals.iter().filter(|manual| manual.device.bus.kind() == bus);
            let pairs = |manual: &'a Manual| ManualJudges {
                manual,
                variants: manual.variants.iter().collect(),
                judges: Vec::new(),
                is_recorded: true,
            };
            (manuals.map(pairs).collect(), ConnectionJudges::default())
        };
        CaptureRules { pairs: PerBus::new(of), has_news: false }
    }

    /// Takes in an observation on a bus; devices of another bus are not concerned.
    #[inline]
    pub fn observe(&mut self, bus: Bus, ars: &[ObservedAr], at: (Time, u64), observation: &Observation<'_>) {
        let (pairs, judges) = self.pairs.of_mut(bus);
        self.has_news |= judges.observe(pairs, ars, at, observation, fits_manual);
    }

    /// Where rules of devices on this bus were broken since the last call, and perhaps some from before.
    pub fn new_violations(&mut self, bus: Bus) -> Vec<NewViolation> {
        if !std::mem::take(&mut self.has_news) {
            return Vec::new();
        }
        let (pairs, _) = self.pairs.of_mut(bus);
        pairs
            .iter_mut()
            .flat_map(|pairs| pairs.judges.iter_mut().flat_map(|(_, judge)| judge.new_violations()))
            .collect()
    }

    /// The findings on rules broken since the last call; these rules are judged afresh.
    pub fn take_findings(&mut self) -> Vec<CaptureFinding> {
        let (mut findings, buses) = (Vec::new(), [Bus::Profinet, Bus::Profibus]);
        for bus in buses {
            let (pairs, _) = self.pairs.of_mut(bus);
            for pairs in pairs {
                let (manual, variants) = (pairs.manual, &pairs.variants);
                for (_, judge) in &mut pairs.judges {
                    if !std::mem::take(&mut judge.has_changed) {
                        continue;
                    }
                    let judged: Vec<_> = variants.iter().copied().zip(judge.outcomes()).collect();
                    for (rule, _, finding) in verdicts(manual, &judged) {
                        let Some(finding) = finding else { continue };
                        findings.push(judge.ar.map_or(finding.clone(), |ar| finding.ar(ar)));
                        // Where one variant still allows what the device does, its violation of the others is remembered.
                        judge.variants.iter_mut().for_each(|of| of.rules.forget_violations(|of| of.id == rule));
                    }
                }
            }
        }
        findings
    }

    /// Forgets the judges of connections on a bus that are forgotten, where there are too many of them.
    pub fn forget(&mut self, bus: Bus, forgotten: &[ArId]) {
        let (pairs, ConnectionJudges(of_connections)) = self.pairs.of_mut(bus);
        for ArId(index) in forgotten {
            if let Some(judges) = of_connections.get_mut(*index as usize) {
                judges.clear();
            }
        }
        for (place, pairs) in pairs.iter_mut().enumerate().filter(|(_, pairs)| pairs.judges.len() >= MOST_PAIRS / 2) {
            let is_used = |judge: usize| of_connections.iter().flatten().any(|of| *of == (place, judge));
            let used: Vec<bool> = (0..pairs.judges.len()).map(is_used).collect();
            let mut number = 0;
            pairs.judges.retain(|_| {
                number += 1;
                used[number - 1]
            });
            for of in of_connections.iter_mut().flatten().filter(|of| of.0 == place) {
                of.1 = used[..of.1].iter().filter(|used| **used).count();
            }
        }
    }

    /// The results of the rules of all devices in the capture, and the findings.
    pub fn end(self) -> (Vec<RuleReport>, Vec<CaptureFinding>) {
        let (mut reports, mut findings) = (Vec::new(), Vec::new());
        let mut all: Vec<ManualJudges<'a>> = self.pairs.into_both().into_iter().flat_map(|(pairs, _)| pairs).collect();
        all.retain(|pairs| !pairs.judges.is_empty());
        all.sort_by(|one, other| one.manual.device.name.cmp(&other.manual.device.name));
        for pairs in all {
            let (manual, variants) = (pairs.manual, pairs.variants.clone());
            let judged: Vec<(&SuiteVariant, Vec<RuleOutcome>)> = variants.into_iter().zip(pairs.end()).collect();
            for (_, report, finding) in verdicts(manual, &judged) {
                reports.extend(report);
                findings.extend(finding);
            }
        }
        (reports, findings)
    }
}

/// The id, the report and the finding on each rule of a manual, from the results of its variants.
fn verdicts<'j>(
    manual: &'j Manual,
    judged: &'j [(&'j SuiteVariant, Vec<RuleOutcome>)],
) -> impl Iterator<Item = (&'j str, Option<RuleReport>, Option<CaptureFinding>)> {
    let mut ids: Vec<&str> = Vec::new();
    for rule in judged.iter().flat_map(|(variant, _)| &variant.rules) {
        if !ids.contains(&rule.id.as_str()) {
            ids.push(&rule.id);
        }
    }
    ids.into_iter().map(move |id| {
        let of: Vec<(&SuiteVariant, &SuiteRule, &RuleOutcome)> = judged
            .iter()
            .flat_map(|(variant, outcomes)| outcomes.iter().map(move |outcome| (*variant, outcome)))
            .filter_map(|(variant, outcome)| Some((variant, variant.rules.get(outcome.rule)?, outcome)))
            .filter(|(_, rule, _)| rule.id == id)
            .collect();
        let (report, finding) = agree(manual, &of);
        (id, report, finding)
    })
}

/// Combines the verdicts of all variants into one: it counts only if they agree.
fn agree(
    manual: &Manual,
    of: &[(&SuiteVariant, &SuiteRule, &RuleOutcome)],
) -> (Option<RuleReport>, Option<CaptureFinding>) {
    let Some(&(_, rule, first)) = of.first() else { return (None, None) };
    let same = of.len() == manual.variants.len() && of.iter().all(|(_, _, other)| other.verdict() == first.verdict());
    let (verdict, reason) = match (same, first.verdict()) {
        (true, Verdict::NotRun) => (Verdict::NotRun, Some("its premise never occurred".to_owned())),
        (true, Verdict::Inconclusive) => (Verdict::Inconclusive, Some(first.undecided())),
        (true, verdict) => (verdict, None),
        (false, _) => {
            let each: Vec<String> =
                of.iter().map(|(variant, _, outcome)| format!("{} {}", variant.name, outcome.verdict())).collect();
            (
                Verdict::Inconclusive,
                Some(format!("the capture does not show which variant the device is: {}", each.join(", "))),
            )
        }
    };
    let report = RuleReport {
        id: format!("{}/{}", manual.device.name, rule.id),
        verdict: verdict.word(),
        premises: first.decided.premises,
        undecided: first.decided.undecided,
        looked_at: first.decided.checked,
        reason,
        note: first.slow.filter(|_| verdict == Verdict::Pass).and_then(|slow| slow.note_of_rule(rule, None)),
    };
    let broken = match (same, verdict) {
        // Before the last of them one variant still allows what the device does.
        (_, Verdict::Fail) => of
            .iter()
            .filter_map(|(_, _, outcome)| outcome.violation.as_ref())
            .reduce(|one, other| if other.frame() > one.frame() { other } else { one })
            .map(|violation| rule_finding(manual, rule, violation)),
        (true, Verdict::Inconclusive) => first.single_frame.as_ref().map(|violation| {
            let mut finding = rule_finding(manual, rule, violation);
            finding.blame_capture();
            finding.text.push_str("; no other frame shows it, so the capture or the line may be at fault");
            finding
        }),
        _ => None,
    };
    (Some(report), broken)
}
