//! The rules of the manuals over frames that somebody else recorded.

use super::report::{Finding, RuleReport, Severity};
use crate::judge::Tick;
use crate::judge::follow::Change;
use crate::judge::rule::{RuleSet, RuleWatch, Violation};
use crate::judge::scene::Scene;
use crate::observe::{Address, Ar, ArId, BusTracker, Observation};
use crate::result::{Decided, PartSeen};
use crate::suite::device::{Bus, Module};
use crate::suite::model::{Level, Manual, Rule, Variant};
use crate::verdict::Verdict;
use station::{Duration, Time};
use std::collections::BTreeMap;

/// A hold without samples for longer than this is undecided.
const WATCHDOG: Duration = Duration::from_secs(1);
/// Pairs of controller and device whose rules are judged.
const MOST_PAIRS: usize = 64;

/// What became of a rule on some frames.
#[derive(Clone, Debug)]
pub struct RuleOutcome {
    /// Index into the rules of the variant.
    pub rule: usize,
    /// How often it was decided.
    pub decided: Decided,
    /// The first time it was broken.
    pub violation: Option<Violation>,
}

impl RuleOutcome {
    /// `fail` where it was broken, `not-run` where it was never decided, else `pass`.
    pub fn verdict(&self) -> Verdict {
        match (&self.violation, self.decided.premises) {
            (Some(_), _) => Verdict::Fail,
            (None, 0) => Verdict::NotRun,
            (None, _) => Verdict::Pass,
        }
    }

    fn add(&mut self, other: RuleOutcome) {
        self.decided.premises += other.decided.premises;
        self.decided.undecided += other.decided.undecided;
        self.decided.looked_at += other.decided.looked_at;
        let earlier = |violation: &Violation| violation.tick.frame;
        self.violation = match (self.violation.take(), other.violation) {
            (Some(own), Some(other)) if earlier(&other) < earlier(&own) => Some(other),
            (own, other) => own.or(other),
        };
    }
}

/// Judges the rules of one variant on the connections between one controller and one device, one after the other.
#[derive(Debug)]
pub struct RuleJudge<'a> {
    scene: Scene<'a>,
    rules: RuleSet<'a>,
}

impl<'a> RuleJudge<'a> {
    /// Has seen nothing.
    pub fn new(manual: &'a Manual, variant: &'a Variant) -> RuleJudge<'a> {
        RuleJudge { scene: Scene::new(manual, variant), rules: RuleSet::new(&variant.rules, WATCHDOG) }
    }

    /// Takes in an observation of a connection that is judged, or of none.
    pub fn observe(&mut self, ars: &[Ar], at: (Time, u64), observation: &Observation<'_>) {
        match self.scene.observe(ars, |_| true, at, observation) {
            Some(Change::Opened) => self.rules.cut(),
            Some(Change::Tick(tick)) => self.tick(tick),
            Some(Change::Closed(tick, _)) => {
                self.tick(tick);
                self.rules.cut();
            }
            None => {}
        }
    }

    fn tick(&mut self, tick: Tick) {
        self.rules.tick(&self.scene.view(tick));
        self.scene.end_of(tick);
    }

    /// Lets time go by: a deadline may run out without a frame.
    pub fn time(&mut self, now: Time, frame: u64) {
        self.rules.time(&self.scene.view_at(now, frame), now);
    }

    /// What became of each rule, in the order of the variant; what is open stays undecided.
    pub fn end(mut self) -> Vec<RuleOutcome> {
        self.rules.cut();
        let outcome = |(rule, (_, watch)): (usize, (&Rule, &RuleWatch<'_>))| RuleOutcome {
            rule,
            decided: watch.decided(),
            violation: watch.violation().cloned(),
        };
        self.rules.iter().enumerate().map(outcome).collect()
    }
}

/// Whether a connection is one to a device of this manual: its numbers and the submodules of one of its modules.
pub fn speaks_to(manual: &Manual, ar: &Ar) -> bool {
    let device = &manual.device;
    if let Some(told) = &ar.slave {
        let is_module = |module: &Module| told.configuration.as_ref() == Some(&module.cfg);
        return device.bus == Bus::Profibus
            && ar.device.ident == Some(device.identity.device_id)
            && device.modules.iter().any(is_module);
    }
    let identity = (device.identity.vendor_id, device.identity.device_id);
    let placed = |index: &usize| {
        device.submodules.get(*index).is_some_and(|submodule| {
            let place = (submodule.slot, submodule.subslot, submodule.ident);
            ar.submodules.iter().any(|placed| (placed.slot, placed.subslot, placed.submodule_ident) == place)
        })
    };
    let mut modules = device.modules.iter();
    ar.device.ids == Some(identity)
        && modules.any(|module| !module.submodules.is_empty() && module.submodules.iter().all(placed))
}

/// Judges the rules of one variant (index into `manual.variants`) on frames: number from 1, time, octets.
///
/// `ours` says which connections count; [`speaks_to`] is the choice for a capture of which nothing is known. An unknown
/// variant has no rules.
pub fn judge_rules<'f>(
    frames: impl Iterator<Item = (u64, Time, &'f [u8])>,
    manual: &Manual,
    variant: usize,
    ours: impl Fn(&Ar) -> bool,
) -> Vec<RuleOutcome> {
    let Some(variant) = manual.variants.get(variant) else { return Vec::new() };
    let mut tracker = match manual.device.bus {
        Bus::Profinet => BusTracker::Profinet(Box::default()),
        Bus::Profibus => BusTracker::Profibus(Box::default()),
    };
    let mut pairs = Pairs::new(manual, variant);
    for (number, time, octets) in frames {
        pairs.time(time, number);
        tracker.frame(number, time, octets, &mut |ars, observation| {
            pairs.observe(ars, (time, number), &observation, &ours);
        });
    }
    pairs.end()
}

/// The judges of one variant, one for each pair of controller and device.
#[derive(Debug)]
struct Pairs<'a> {
    manual: &'a Manual,
    variant: &'a Variant,
    judges: Vec<((Address, Address), RuleJudge<'a>)>,
    /// The judge of each connection.
    of: Vec<Option<usize>>,
}

impl<'a> Pairs<'a> {
    fn new(manual: &'a Manual, variant: &'a Variant) -> Pairs<'a> {
        Pairs { manual, variant, judges: Vec::new(), of: Vec::new() }
    }

    fn observe(&mut self, ars: &[Ar], at: (Time, u64), observation: &Observation<'_>, ours: impl Fn(&Ar) -> bool) {
        if let Observation::Connected { ar } = observation {
            self.connected(ars, *ar, ours);
        }
        match observation.ar() {
            Some(ar) => {
                if let Some(judge) = self.of.get(ar.0 as usize).copied().flatten() {
                    self.judges[judge].1.observe(ars, at, observation);
                }
            }
            None => self.judges.iter_mut().for_each(|(_, judge)| judge.observe(ars, at, observation)),
        }
    }

    fn connected(&mut self, ars: &[Ar], id: ArId, ours: impl Fn(&Ar) -> bool) {
        let Some(ar) = ars.get(id.0 as usize).filter(|ar| ours(ar)) else { return };
        let pair = (ar.controller.address, ar.device.address);
        let known = self.judges.iter().position(|(known, _)| *known == pair);
        let judge = known.or_else(|| {
            (self.judges.len() < MOST_PAIRS).then(|| {
                self.judges.push((pair, RuleJudge::new(self.manual, self.variant)));
                self.judges.len() - 1
            })
        });
        let index = id.0 as usize;
        self.of.resize(self.of.len().max(index + 1), None);
        self.of[index] = judge;
    }

    fn time(&mut self, now: Time, frame: u64) {
        self.judges.iter_mut().for_each(|(_, judge)| judge.time(now, frame));
    }

    fn end(self) -> Vec<RuleOutcome> {
        let nothing = |rule| RuleOutcome { rule, decided: Decided::default(), violation: None };
        let mut outcomes: Vec<RuleOutcome> = (0..self.variant.rules.len()).map(nothing).collect();
        for (_, judge) in self.judges {
            outcomes.iter_mut().zip(judge.end()).for_each(|(sum, of)| sum.add(of));
        }
        outcomes
    }
}

/// The rules of all manuals on one capture; a device that nobody has named may be any variant of its manual.
#[derive(Debug)]
pub(super) struct CaptureRules<'a>(Vec<Pairs<'a>>);

impl<'a> CaptureRules<'a> {
    pub fn new(manuals: &'a [Manual]) -> CaptureRules<'a> {
        let all = manuals.iter().flat_map(|manual| manual.variants.iter().map(move |variant| (manual, variant)));
        CaptureRules(all.map(|(manual, variant)| Pairs::new(manual, variant)).collect())
    }

    /// Takes in an observation on a bus; what devices of another one are is not told by it.
    pub fn observe(&mut self, bus: Bus, ars: &[Ar], at: (Time, u64), observation: &Observation<'_>) {
        for pairs in self.0.iter_mut().filter(|pairs| pairs.manual.device.bus == bus) {
            let manual = pairs.manual;
            pairs.observe(ars, at, observation, |ar| speaks_to(manual, ar));
        }
    }

    pub fn time(&mut self, now: Time, frame: u64) {
        self.0.iter_mut().for_each(|pairs| pairs.time(now, frame));
    }

    /// What became of the rules of the devices that were there, and what was broken.
    pub fn end(self) -> (Vec<RuleReport>, Vec<Finding>) {
        let (mut reports, mut findings) = (Vec::new(), Vec::new());
        let mut manuals: BTreeMap<&str, Vec<Pairs<'a>>> = BTreeMap::new();
        for pairs in self.0.into_iter().filter(|pairs| !pairs.judges.is_empty()) {
            manuals.entry(&pairs.manual.device.name).or_default().push(pairs);
        }
        for variants in manuals.into_values() {
            let Some(manual) = variants.first().map(|pairs| pairs.manual) else { continue };
            let judged: Vec<(&Variant, Vec<RuleOutcome>)> =
                variants.into_iter().map(|pairs| (pairs.variant, pairs.end())).collect();
            let mut ids: Vec<&str> = Vec::new();
            for rule in judged.iter().flat_map(|(variant, _)| &variant.rules) {
                if !ids.contains(&rule.id.as_str()) {
                    ids.push(&rule.id);
                }
            }
            for id in ids {
                let of: Vec<(&Variant, &Rule, &RuleOutcome)> = judged
                    .iter()
                    .flat_map(|(variant, outcomes)| outcomes.iter().map(move |outcome| (*variant, outcome)))
                    .filter_map(|(variant, outcome)| Some((variant, variant.rules.get(outcome.rule)?, outcome)))
                    .filter(|(_, rule, _)| rule.id == id)
                    .collect();
                let (report, finding) = agree(manual, &of);
                reports.extend(report);
                findings.extend(finding);
            }
        }
        (reports, findings)
    }
}

/// One verdict from those under each variant: only one on which they agree counts.
fn agree(manual: &Manual, of: &[(&Variant, &Rule, &RuleOutcome)]) -> (Option<RuleReport>, Option<Finding>) {
    let Some(&(_, rule, first)) = of.first() else { return (None, None) };
    let same = of.len() == manual.variants.len() && of.iter().all(|(_, _, other)| other.verdict() == first.verdict());
    let (verdict, reason) = match (same, first.verdict()) {
        (true, Verdict::NotRun) => (Verdict::NotRun, Some("its premise was never seen".to_owned())),
        (true, verdict) => (verdict, None),
        (false, _) => {
            let each: Vec<String> =
                of.iter().map(|(variant, _, outcome)| format!("{} {}", variant.name, outcome.verdict())).collect();
            (
                Verdict::Inconclusive,
                Some(format!("which variant it is cannot be told from the capture: {}", each.join(", "))),
            )
        }
    };
    let report = RuleReport {
        id: format!("{}/{}", manual.device.name, rule.id),
        verdict: verdict.word(),
        premises: first.decided.premises,
        undecided: first.decided.undecided,
        looked_at: first.decided.looked_at,
        reason,
    };
    let broken = first.violation.as_ref().filter(|_| verdict == Verdict::Fail);
    (Some(report), broken.map(|violation| finding(manual, rule, violation)))
}

fn finding(manual: &Manual, rule: &Rule, violation: &Violation) -> Finding {
    let covered: Vec<_> = rule.covers.iter().filter_map(|&index| manual.requirements.get(index)).collect();
    let id = match covered.is_empty() {
        true => format!("{}/{}", manual.device.name, rule.id),
        false => covered.iter().map(|requirement| requirement.id.as_str()).collect::<Vec<_>>().join(", "),
    };
    let info = !covered.is_empty() && covered.iter().all(|requirement| requirement.level == Level::Info);
    let part = |part: &PartSeen| format!("{}: wanted {}, seen {}", part.text, part.wanted, part.seen);
    let parts: Vec<String> = violation.parts.iter().filter(|part| !part.held).map(part).collect();
    let since = violation.trigger.map_or(String::new(), |trigger| format!(" (after frame {})", trigger.frame));
    let text = format!("{} {}{since} [{}]; {}", rule.why.trim_end(), violation.how, rule.id, parts.join("; "));
    Finding {
        id,
        severity: if info { Severity::Info } else { Severity::Error },
        frame: violation.tick.frame,
        text: text.trim_end_matches("; ").to_owned(),
    }
}
