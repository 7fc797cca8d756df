//! A live device as the engine uses it: its segment, the permitted changes, and its condition between trials.
//!
//! `segment` carries the frames of a trial; this module must not know it in detail, nor how a bench is found or prepared.

mod bus_watch;
mod segment;

use crate::frame_limits::FrameLimits;
use crate::journal::Journal;
use crate::line::DeviceLine;
use crate::stand::{LiveStand, StandLimits};
use crate::{preflight, profibus};
use description::gsdml::ReportedIdentity;
use description::variant::VariantReading;
use engine::dut::{CONTROLLER, SECOND};
use engine::needs::{self, Ability, BenchNeed, Consent};
use engine::scan::each_step_of;
use engine::segment::Segment;
use engine::{DpLine, LiveDevice, SequenceLimits, TrialEnvironment, TrialExclusion, VirtualStart};
use results::bench_file::BenchFile;
use results::journal::{InitialDevice, JournalEntry, change};
use results::outcome::DeviceFinding;
use station::{Duration, Stand, StandAction, StandRefusal, Time};
use std::fmt;
use std::net::Ipv4Addr;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use suite::device::DeviceDescription;
use suite::model::{AccessChannel, AcyclicService, ConnectionStart, DpService, Manual, SuiteVariant, Trial, Verb};
use suite::persona::Persona;
use wire::profinet::dcp::block::IpParameter;

/// After this number of consecutive trials without an answer the device is not tested any more.
const UNANSWERED_LIMIT: u32 = 3;
/// How long to wait for a lost line before the next trial.
const LINE_TIMEOUT: Duration = Duration::from_secs(10);
/// Interval of the checks whether the line is back.
const LINE_CHECK_INTERVAL: Duration = Duration::from_millis(100);
/// Timeout for a replaced device to be present.
const RENEW_TIMEOUT: Duration = Duration::from_secs(60);
/// Interval of the checks whether it is present.
const RENEW_CHECK_INTERVAL: Duration = Duration::from_millis(1);

/// A live device on its bench; clones refer to the same device.
#[derive(Clone)]
pub struct DeviceOnBench(Arc<DeviceOnBenchInner>);

struct DeviceOnBenchInner {
    bench: BenchFile,
    manual: Manual,
    place: TrialEnvironment,
    found: InitialDevice,
    passive: Option<String>,
    long: bool,
    findings: Vec<DeviceFinding>,
    variant_readings: Vec<VariantReading>,
    reported: ReportedIdentity,
    notes: Vec<String>,
    state: Mutex<BenchState>,
    /// Number of calls so far that needed a unique number, across trials.
    calls: AtomicU64,
}

/// The state that only one trial at a time may use.
struct BenchState {
    line: DeviceLine,
    stand: LiveStand,
    journal: Journal,
    /// The lasting changes so far, in the words of the journal.
    changes: Vec<String>,
    nvm_left: u32,
    frames_lost: u64,
    /// Consecutive trials in which the device did not answer.
    unanswered: u32,
    /// Why the line was lost, once it did not come back.
    lost: Option<String>,
}

impl BenchState {
    fn new(bench: &BenchFile, line: DeviceLine, journal: Journal, changes: Vec<String>) -> BenchState {
        BenchState {
            line,
            stand: LiveStand::new(&bench.stand),
            journal,
            changes,
            nvm_left: bench.consent.nvm_write,
            frames_lost: 0,
            unanswered: 0,
            lost: None,
        }
    }
}

impl BenchState {
    /// How many memory writes are left.
    fn nvm_left(&mut self) -> u32 {
        self.line.limits_mut().as_ref().map_or(self.nvm_left, |limits| limits.writes_left())
    }
}

/// The network addresses of the device and the controllers, before the preflight fills them in.
fn place(bench: &BenchFile) -> TrialEnvironment {
    let seed = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap_or_default();
    TrialEnvironment {
        is_other_model: false,
        name: String::new(),
        mac: None,
        ip: IpParameter::NONE,
        controllers: [CONTROLLER, SECOND],
        free_ip: Ipv4Addr::UNSPECIFIED,
        seed: seed.as_nanos() as u64,
        noise: bench.position_noise,
        slack: Duration::ZERO,
        bench: Some(Arc::new(bench.clone())),
        persona: None,
        deviates: false,
        line: DpLine::default(),
    }
}

/// What the device and its description report, compared with the manual.
#[derive(Debug, Default)]
pub struct ComparedDevice {
    /// Where they disagree.
    pub findings: Vec<DeviceFinding>,
    /// What shows the variant.
    pub variant_readings: Vec<VariantReading>,
}

/// A device whose suite is replaced before its first trial: an encoder that only its GSDML describes says more of itself in P979.
pub trait ReplaceManual {
    /// What the device reported of itself on PROFINET.
    fn reported(&self) -> &ReportedIdentity;

    /// Takes another description of the same device for its suite, while nothing else uses the bench.
    fn replace_manual(&mut self, manual: Manual);
}

impl ReplaceManual for DeviceOnBench {
    fn reported(&self) -> &ReportedIdentity {
        &self.0.reported
    }

    fn replace_manual(&mut self, manual: Manual) {
        if let Some(inner) = Arc::get_mut(&mut self.0) {
            inner.manual = manual;
        }
    }
}

impl DeviceOnBench {
    /// A PROFINET device on a prepared bench, with the suite of its claimed type, addressed like `persona`.
    pub fn new(
        bench: BenchFile,
        manual: Manual,
        prepared: preflight::PreparedDevice,
        long: bool,
        compared: ComparedDevice,
        persona: Option<Arc<Persona>>,
    ) -> DeviceOnBench {
        let place = TrialEnvironment {
            name: String::from_utf8_lossy(&prepared.station.name).into_owned(),
            mac: Some(prepared.station.mac),
            ip: prepared.ip,
            controllers: prepared.controllers,
            free_ip: prepared.free_ip,
            slack: prepared.slack,
            persona,
            ..place(&bench)
        };
        let preflight::PreparedDevice { line, found, journal, changes, passive, notes, reported, .. } = prepared;
        let state = BenchState::new(&bench, line, journal, changes);
        let state = Mutex::new(state);
        let calls = AtomicU64::new(0);
        let ComparedDevice { findings, variant_readings } = compared;
        DeviceOnBench(Arc::new(DeviceOnBenchInner {
            bench,
            manual,
            place,
            found,
            passive,
            long,
            findings,
            variant_readings,
            reported,
            notes,
            state,
            calls,
        }))
    }

    /// A PROFIBUS slave on a prepared bench, with the suite of its claimed type.
    pub fn on_bus(
        bench: BenchFile,
        manual: Manual,
        prepared: profibus::preflight::PreparedBus,
        long: bool,
        compared: ComparedDevice,
    ) -> DeviceOnBench {
        let profibus::preflight::PreparedBus { line, found, journal, passive, notes, .. } = prepared;
        let dp = DpLine {
            station: prepared.station,
            masters: prepared.masters,
            free: prepared.free,
            baud: prepared.baud,
            pace: Some(prepared.pace),
        };
        let place = TrialEnvironment { line: dp, slack: prepared.slack, ..place(&bench) };
        let state = Mutex::new(BenchState::new(&bench, line, journal, Vec::new()));
        let calls = AtomicU64::new(0);
        let ComparedDevice { findings, variant_readings } = compared;
        DeviceOnBench(Arc::new(DeviceOnBenchInner {
            bench,
            manual,
            place,
            found,
            passive,
            long,
            findings,
            variant_readings,
            reported: ReportedIdentity::default(),
            notes,
            state,
            calls,
        }))
    }

    /// Locks the state of the bench, for one trial.
    fn state(&self) -> MutexGuard<'_, BenchState> {
        self.0.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Checks whether this bench serves a trial. The reason is the first one found, the lines are all.
    fn check_bench(&self, needs: &[BenchNeed], trial: &Trial) -> Result<(), TrialExclusion> {
        let (long, nvm_left) = (self.0.long, self.state().nvm_left());
        let of_needs = needs::missing(needs, self.bench(), long, nvm_left);
        let of_description = needs_description_of(&self.manual().device, trial);
        let passive = self.0.passive.as_ref().filter(|_| !only_reads(trial));
        let mut lines = needs::missing_lines(needs, self.bench(), long, nvm_left);
        if of_description.is_some() {
            lines.push(if self.manual().device.profibus().is_some() { "gsd" } else { "gsdml" }.to_owned());
        }
        if passive.is_some_and(|_| !self.bench().consent.alone) {
            lines.push("consent alone".to_owned());
        }
        let passive = passive.map(|why| format!("only reading trials may run: {why}"));
        let why = of_needs.or(of_description).or(passive);
        why.map_or(Ok(()), |why| Err(TrialExclusion::NotApplicable { why, lines }))
    }

    /// What in these needs drawn sequences may not do.
    fn beyond_limits(&self, needs: &[BenchNeed]) -> Option<String> {
        let limits = self.state().stand.limits()?;
        let is_preset = |need: &&BenchNeed| {
            matches!(need, BenchNeed::Consent(Consent::PositionReference) | BenchNeed::Stand(Ability::Button(_)))
        };
        if !limits.may_press && needs.iter().any(|need| is_preset(&need)) {
            return Some("a preset needs the consent position_reference and `shaft: [uncoupled]`".to_owned());
        }
        let cycles = needs.contains(&BenchNeed::Stand(Ability::Power)) && limits.power_cycles == 0;
        cycles.then(|| "no power cycle of this run is left".to_owned())
    }

    /// Waits for a lost line; after one timeout it does not wait again.
    fn line_is_there(&self) -> Result<(), String> {
        let mut state = self.state();
        if let Some(why) = &state.lost {
            return Err(format!("no further trial is possible: {why}"));
        }
        state.line.restart();
        let Err(error) = state.line.step_alone(Time::ZERO) else { return Ok(()) };
        let until = state.line.now() + LINE_TIMEOUT;
        while state.line.now() < until && !link::interrupt::requested() {
            let soon = state.line.now() + LINE_CHECK_INTERVAL;
            if state.line.recover(soon).is_ok() {
                return Ok(());
            }
        }
        state.lost = Some(error.to_string());
        Err(error.to_string())
    }

    /// Replaces the device by a new one.
    fn renew(&self) -> Result<(), String> {
        let mut state = self.state();
        let BenchState { line, stand, .. } = &mut *state;
        let no_new = |refusal: StandRefusal| match refusal {
            StandRefusal::CannotDo(why) | StandRefusal::Broken(why) => format!("no new device: {why}"),
        };
        let latest = line.now() + RENEW_TIMEOUT;
        let limits = stand.limits();
        stand.limit(None);
        let begun = stand.act(line.now(), &StandAction::ReplaceDevice);
        stand.limit(limits);
        let mut until = begun.map_err(no_new)?.min(latest);
        let mut at_work = true;
        while at_work || line.now() < until {
            if at_work {
                if link::interrupt::requested() {
                    return Err("the run was interrupted".to_owned());
                }
                if line.now() >= latest {
                    return Err(format!(
                        "no new device: the stand has not replaced it within {} s",
                        RENEW_TIMEOUT.as_secs()
                    ));
                }
                let outcome = stand.outcome(line.now()).transpose().map_err(no_new)?;
                at_work = outcome.is_none();
                until = outcome.unwrap_or(line.now() + RENEW_CHECK_INTERVAL).min(latest);
            }
            line.step_alone(until).map_err(|error| error.to_string())?;
        }
        Ok(())
    }
}

impl LiveDevice for DeviceOnBench {
    fn manual(&self) -> &Manual {
        &self.0.manual
    }

    fn bench(&self) -> &BenchFile {
        &self.0.bench
    }

    fn identity(&self) -> String {
        let InitialDevice { mac, station, vendor_id, device_id, .. } = &self.0.found;
        if let Some(station) = station {
            return format!("ident 0x{device_id:04X} at station {station}");
        }
        format!("{mac} (vendor 0x{vendor_id:04X}, device 0x{device_id:04X})")
    }

    fn environment(&self) -> &TrialEnvironment {
        &self.0.place
    }

    fn found(&self) -> &InitialDevice {
        &self.0.found
    }

    fn findings(&self) -> &[DeviceFinding] {
        &self.0.findings
    }

    fn variant_readings(&self) -> &[VariantReading] {
        &self.0.variant_readings
    }

    fn notes(&self) -> &[String] {
        &self.0.notes
    }

    fn passive(&self) -> Option<&str> {
        self.0.passive.as_deref()
    }

    fn segment(&self, _: VirtualStart) -> Box<dyn Segment + '_> {
        segment::of(self.state(), self.environment())
    }

    fn limit_changes(&self, limits: Option<SequenceLimits>) {
        let mut state = self.state();
        state.nvm_left = state.nvm_left();
        let bench = &self.0.bench;
        let may_press = bench.consent.position_reference && bench.stand.shaft.uncoupled;
        state.stand.limit(limits.map(|limits| StandLimits { power_cycles: limits.power_cycles, may_press }));
        let nvm_left = state.nvm_left;
        *state.line.limits_mut() = limits.map(|limits| {
            let writes = limits.memory_writes.min(nvm_left);
            Box::new(FrameLimits::new(&self.0.manual.device, bench, writes))
        });
    }

    fn limits_left(&self) -> Option<SequenceLimits> {
        let mut state = self.state();
        let power_cycles = state.stand.limits()?.power_cycles;
        Some(SequenceLimits { power_cycles, memory_writes: state.nvm_left() })
    }

    fn note(&self, entry: &JournalEntry) -> Result<(), String> {
        let mut state = self.state();
        if let JournalEntry::Changes { what, .. } = entry {
            let new: Vec<String> = what.iter().filter(|word| !state.changes.contains(word)).cloned().collect();
            state.changes.extend(new);
        }
        let journal = &mut state.journal;
        journal.add(entry).map_err(|error| {
            format!("the journal {} cannot be written, so nothing more is changed: {error}", journal.path().display())
        })
    }

    fn changes(&self) -> Vec<String> {
        self.state().changes.clone()
    }

    fn count_answer(&self, answered: bool) {
        let mut state = self.state();
        state.unanswered = if answered { 0 } else { state.unanswered + 1 };
        if state.unanswered >= UNANSWERED_LIMIT {
            state
                .lost
                .get_or_insert_with(|| format!("the device has not answered in {UNANSWERED_LIMIT} trials in a row"));
        }
    }

    fn next_call(&self) -> u64 {
        (self.0.calls.fetch_add(1, Ordering::Relaxed) + 1) << 32
    }

    fn end_tests(&self, why: &str) {
        self.state().lost.get_or_insert_with(|| why.to_owned());
    }

    fn objection(&self, variant: &SuiteVariant, trial: &Trial) -> Option<String> {
        let needs = needs::needs(self.manual(), variant, trial);
        match self.check_bench(&needs, trial) {
            Err(TrialExclusion::NotApplicable { why, .. }) => Some(why),
            Ok(()) | Err(_) => self.beyond_limits(&needs),
        }
    }

    fn admit(&self, variant: &SuiteVariant, trial: &Trial) -> Result<(), TrialExclusion> {
        if link::interrupt::requested() {
            return Err(TrialExclusion::NotRun("the run was interrupted".to_owned()));
        }
        let needs = needs::needs(self.manual(), variant, trial);
        self.check_bench(&needs, trial)?;
        self.line_is_there().map_err(TrialExclusion::Inconclusive)?;
        let mut what: Vec<String> = needs.iter().filter_map(lasting).collect();
        if !self.manual().device.parameters.is_empty() && changes_parameters(self.manual(), trial, &needs) {
            what.push(change::PARAMETERS.to_owned());
        }
        let renews = self.0.passive.is_none() && self.bench().stand.serves("renew");
        if renews {
            what.push(change::NEW_DEVICE.to_owned());
        }
        let stand: Vec<String> = needs.iter().filter_map(at_stand).collect();
        if !what.is_empty() || !stand.is_empty() {
            let entry = JournalEntry::Changes { trial: trial.id.clone(), what, stand };
            self.note(&entry).map_err(TrialExclusion::Inconclusive)?;
        }
        if renews {
            self.renew().map_err(TrialExclusion::Inconclusive)?;
        }
        let mut state = self.state();
        // The frames of drawn sequences are counted one by one.
        if state.line.limits_mut().is_none() {
            state.nvm_left = state.nvm_left.saturating_sub(needs::nvm_writes(&needs));
        }
        Ok(())
    }
}

/// Why a start-up of the trial cannot be made: a value in it was invented for the reference device.
pub(crate) fn needs_description_of(device: &DeviceDescription, trial: &Trial) -> Option<String> {
    let mut starts: Vec<&ConnectionStart> = trial.start().into_iter().collect();
    each_step_of(trial, &mut |step| {
        if let Verb::Connect { start, .. } = &step.verb {
            starts.push(start);
        }
    });
    starts.into_iter().find_map(|start| description::gsdml::needs_description(device, start))
}

/// Whether a trial changes parameters: by base mode parameter access, by a web page, or by a reset.
fn changes_parameters(manual: &Manual, trial: &Trial, needs: &[BenchNeed]) -> bool {
    let access = manual.device.parameter_access.index;
    let mut changes = needs.contains(&BenchNeed::Consent(Consent::FactoryReset));
    each_step_of(trial, &mut |step| {
        changes |= match &step.verb {
            Verb::Write(access) => matches!(access.via, AccessChannel::Parameters),
            Verb::Send { service: AcyclicService::RecordWrite { at, .. }, .. } => at.index == access,
            // A value entered on a page is a parameter too.
            Verb::Send { service: AcyclicService::HttpPost { .. }, .. } => true,
            _ => false,
        };
    });
    changes
}

/// The permanent change of a need, in the word of the consent.
fn lasting(need: &BenchNeed) -> Option<String> {
    match need {
        BenchNeed::Consent(consent) => Some(consent.to_string()),
        _ => None,
    }
}

/// The name that a need sets at the stand, where something stays set if the trial is interrupted.
fn at_stand(need: &BenchNeed) -> Option<String> {
    match need {
        BenchNeed::Stand(Ability::Led(_) | Ability::Counter(_)) => None,
        BenchNeed::Stand(ability) => Some(ability.to_string()),
        _ => None,
    }
}

/// Whether a trial neither connects nor changes anything.
fn only_reads(trial: &Trial) -> bool {
    let mut reads = trial.start().is_none();
    each_step_of(trial, &mut |step| {
        reads &= match &step.verb {
            Verb::Read { access, .. } => {
                matches!(access.via, AccessChannel::Station | AccessChannel::Diagnosis | AccessChannel::Configuration)
            }
            Verb::Send { service, .. } => matches!(
                service,
                AcyclicService::DcpIdentify(_)
                    | AcyclicService::DcpGet { .. }
                    | AcyclicService::Dp(
                        DpService::FdlStatus | DpService::SlaveDiag | DpService::GetCfg | DpService::ReadInputs
                    )
            ),
            Verb::Expect { .. } | Verb::Wait(_) | Verb::Save(_) | Verb::Block { .. } | Verb::Either(_) => true,
            Verb::Set(_) | Verb::Turn(_) | Verb::Exchange(_) | Verb::Write(_) => false,
            Verb::Connect { .. } | Verb::Disconnect { .. } => false,
        };
    });
    reads
}

impl fmt::Debug for DeviceOnBench {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "DeviceOnBench({})", self.0.bench.link)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;
    use suite_yaml::load;

    #[rstest]
    #[case::by_a_page("web/entry-is-hexadecimal", true)]
    #[case::by_a_reset("factory-reset/still-to-be-found", true)]
    #[case::by_another_device("start-parameters/as-delivered", true)]
    #[case::by_the_parameter_access("parameter-values/save-and-confirm", true)]
    #[case::not_at_all("web/links", false)]
    fn what_a_trial_changes_of_the_parameters(#[case] id: &str, #[case] changes: bool) {
        let manuals = load(&suites::sources(), Some("lika-xac77-profinet"));
        let manuals = manuals.unwrap_or_else(|errors| panic!("{errors}"));
        let (manual, variant) = (&manuals[0], &manuals[0].variants[0]);
        let trial = variant.trials.iter().find(|trial| trial.id.starts_with(id)).expect("the suite has it");
        assert_eq!(changes_parameters(manual, trial, &needs::needs(manual, variant, trial)), changes);
    }
}
