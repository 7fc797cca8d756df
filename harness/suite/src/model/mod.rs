//! Compiled suites: every name is resolved, every table row and every variant is expanded.
//!
//! The engine, the replay and the listings use this model and read no YAML.

mod also;
mod condition;
mod reach;
mod request;
mod steps;

pub use super::device::AnswerPart;
pub use also::{GenericSuite, LeftOutPart};
pub use condition::{
    BlockObservation, Condition, ConditionPart, Matcher, PartTest, RuleBody, SequenceEntry, SuiteRule,
};
pub use reach::Reach;
pub use request::{
    AccessChannel, AccessItem, AcyclicAccess, AcyclicService, AlarmToAcknowledge, AnswerMatcher, Code, DpService,
    IdentifyTarget, IpFragments, PingService, RecordPlace, RequestDeviation, RpcService, SnmpService, SoughtStation,
};
pub use steps::{Steps, TrialSteps};

use super::device::{DeviceDescription, NameId, NameKind};
use super::location::Location;
use expression::{Program, Type};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Duration;

use wire::profibus::fdl::BaudRate;

/// A manual: its device, requirements, bugs, and the cases and rules compiled for each variant.
#[derive(Debug, Deserialize, Serialize)]
pub struct Manual {
    /// The device description, `device.yaml`.
    pub device: Arc<DeviceDescription>,
    /// The requirements in the order of the manual.
    pub requirements: Vec<Requirement>,
    /// The deliberate bugs that the reference device of this manual can have.
    pub bugs: Vec<Bug>,
    /// The compiled suites, one for each entry of `device.variants`, in that order.
    pub variants: Vec<SuiteVariant>,
    /// Definitions that nothing uses, for `encspec check`.
    pub unused: Vec<(String, Location)>,
    /// The suites that the manual uses too; their requirements and trials stand among its own, after these.
    pub also: Vec<GenericSuite>,
}

/// The compiled suites of one variant of a device.
#[derive(Debug, Deserialize, Serialize)]
pub struct SuiteVariant {
    /// The name of the variant, as in `device.variants`.
    pub name: String,
    /// Every name that a condition or step uses; a [`NameId`] is an index into this list.
    pub names: Vec<NameKind>,
    /// The path of each name as suites write it, in the same order.
    pub paths: Vec<String>,
    /// The type of each name, in the same order.
    pub types: Vec<Type>,
    /// The trials in the order of the files, the cases and the rows.
    pub trials: Vec<Trial>,
    /// The rules in the order of the files.
    pub rules: Vec<SuiteRule>,
    /// `derived` of the device: name and program of each expression.
    pub derived: Vec<(String, Program)>,
}

/// The weight of a failed requirement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize, Serialize)]
pub enum Level {
    /// The manual, or a profile or standard that it refers to, states it without ambiguity.
    Must,
    /// Expected by the manual or by convention.
    Should,
    /// Reported only.
    Info,
}

/// The source of a requirement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
pub enum RequirementSource {
    /// The manual prints it.
    Manual,
    /// The PROFIdrive or PROFINET profile requires it.
    Profile,
    /// Devices of this kind commonly do it.
    Convention,
}

/// Whether a case has to cover a requirement, and why not.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum RequirementClass {
    /// A case or rule has to cover it.
    Testable,
    /// Other requirements cover it; the reason.
    Implicit(String),
    /// Neither the wire nor the stand shows it; the reason.
    Untestable(String),
    /// Left out on purpose; the reason.
    OutOfScope(String),
    /// It can be tested, but its check is not built yet; what is missing.
    NoCheck(String),
    /// The manual contradicts itself; the interpretation that was chosen.
    Contradictory(String),
}

/// How a device behaves that follows another reading of an ambiguous or contradictory clause.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum OtherReadings {
    /// Nothing is ambiguous, or it is not described how such a device behaves.
    #[default]
    Unknown,
    /// As the reference device with one of these permitted variations.
    Varied(Vec<String>),
    /// As with the chosen reading; the reason.
    Invisible(String),
}

/// One testable statement of a manual, in the words of the suite.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Requirement {
    /// For instance `XAC77-PRE-006`.
    pub id: String,
    /// The clause of the manual.
    pub cites: String,
    /// The statement in one sentence.
    pub statement: String,
    pub level: Level,
    /// Its source.
    pub source: RequirementSource,
    /// The channel that shows it: `cyclic`, `acyclic`, `startup`, `record`, `dcp`, `alarm`, `diagnosis`, `web` or `model`.
    pub channel: String,
    /// The variants it applies to, as indices into `device.variants`.
    pub variants: Vec<usize>,
    /// What the manual leaves open.
    pub ambiguity: Option<String>,
    /// How a device by another reading of the manual behaves.
    pub other_readings: OtherReadings,
    /// Whether a case has to cover it.
    pub class: RequirementClass,
    pub at: Location,
}

impl Requirement {
    /// Chapter and topic from the file name: `7 factory reset` of `requirements-07-factory-reset.yaml`.
    pub fn chapter(&self) -> Option<String> {
        let name = self.at.file.file_stem()?.to_str()?;
        let (number, topic) = name.strip_prefix("requirements-")?.split_once('-')?;
        Some(format!("{} {}", number.trim_start_matches('0'), topic.replace('-', " ")))
    }
}

/// A deliberate bug as listed in the suites.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Bug {
    /// The name that `catches` uses.
    pub name: String,
    /// What the device does wrong, in one sentence; empty if no reference device has this bug.
    pub why: String,
    /// Indices of the requirements that it violates.
    pub breaks: Vec<usize>,
    pub at: Location,
}

/// A row of a case, compiled for one variant.
#[derive(Debug, Deserialize, Serialize)]
pub struct Trial {
    /// `<suite>/<case>` or `<suite>/<case>[row]`; the test name has the manual before it.
    pub id: String,
    /// The case's sentence.
    pub why: String,
    /// Indices of the requirements that the whole trial covers; checks may cover others.
    pub covers: Vec<usize>,
    /// Names of the bugs that must make this trial fail.
    pub catches: Vec<String>,
    /// Position of the case or row.
    pub at: Location,
    /// Summary of its steps for listings.
    pub outline: Outline,
    /// Its steps, decoded on first use.
    pub how: Steps,
}

impl Trial {
    /// Its id without the row: `<suite>/<case>`.
    pub fn case(&self) -> &str {
        self.id.split('[').next().unwrap_or(&self.id)
    }

    /// Its steps.
    pub fn how(&self) -> &TrialSteps {
        self.how.get()
    }

    /// The connection it begins with; `None` for `start: none`.
    pub fn start(&self) -> Option<&ConnectionStart> {
        self.how().start.as_ref()
    }

    /// Its steps in three parts: `given`, the test, and `finally`.
    pub fn parts(&self) -> [&[TrialStep]; 3] {
        let TrialSteps { given, steps, finally, .. } = self.how();
        [given, steps, finally]
    }

    /// Drops the steps.
    pub fn forget_steps(&mut self) {
        self.how = TrialSteps::default().into();
    }
}

/// Summary of the steps of a trial, so that listings need not decode the steps.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct Outline {
    /// Requirements of the checks that are judged separately, in the order of the steps.
    pub checks: Vec<usize>,
    /// The requirements that it covers, including those of its checks, each with what a live bench must have for it.
    pub live: Vec<(usize, Reach)>,
    /// Names of accepted readings, each with its requirement: of a check that is judged separately, or of the whole trial.
    pub readings: Vec<(usize, String)>,
    /// The LEDs that its steps use, in order; the others are not read.
    pub leds: Vec<usize>,
}

/// A connection to establish.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct ConnectionStart {
    /// Index into `device.modules`.
    pub module: usize,
    /// Cycle time of the case, if it sets one; on PROFINET a whole number of send clocks, on PROFIBUS the time from one
    /// Data_Exchange with this slave to the next.
    pub cycle: Option<Duration>,
    /// Watchdog time of the case, if it sets one.
    pub watchdog: Option<Duration>,
    /// The connection has no watchdog (PROFIBUS: `watchdog: none`).
    pub unwatched: bool,
    /// Transmission rate of the case, if it sets one (PROFIBUS).
    #[serde(with = "crate::encoding::baud")]
    pub baud: Option<BaudRate>,
    /// Time from one Global_Control to the next in isochronous mode, which is also the cycle (PROFIBUS).
    pub isochronous: Option<Duration>,
    /// Values of the start parameters.
    pub parameters: Vec<StartParameter>,
    /// Deviations from the correct start-up.
    pub instead: Vec<StartDeviation>,
}

impl ConnectionStart {
    /// Cycle time: of the case, else of the bench, else the default of the language.
    pub fn cycle(&self, device: &DeviceDescription) -> Duration {
        let shortest = device.profibus().map_or(Duration::ZERO, |slave| slave.min_slave_interval);
        self.isochronous.or(self.cycle).unwrap_or(device.timing.cycle).max(shortest)
    }

    /// Watchdog time: of the case, else of the bench, else ten cycles, on PROFIBUS one second. `unwatched` is ignored.
    pub fn watchdog(&self, device: &DeviceDescription) -> Duration {
        let cycle = self.cycle(device);
        let usual = device.bus.usual_watchdog(cycle);
        self.watchdog.unwrap_or_else(|| device.timing.watchdog.unwrap_or(usual).max(cycle))
    }
}

/// A start parameter and its value.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct StartParameter {
    /// Index into `device.records`.
    pub record: usize,
    /// Index into the fields of that record.
    pub field: usize,
    /// The number in the field.
    pub value: i128,
}

/// One deviation from the correct start-up.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum StartDeviation {
    /// Leave out this record (index into `device.records`).
    RecordNone(usize),
    /// Send this record with these bytes.
    RecordBytes(usize, Vec<u8>),
    /// Length of the output data of the telegram's submodule in the expected configuration, in bytes.
    OutputLength(u16),
    /// Length of the input data in the expected configuration, in bytes.
    InputLength(u16),
    /// Ident number of the module.
    ModuleIdent(u32),
    /// Ident number of the telegram's submodule.
    SubmoduleIdent(u32),
    /// API of the telegram's submodule.
    Api(u32),
    /// CMInitiatorStationName of the Connect request.
    StationName(String),
    /// RT class of both IOCRs.
    RtClass(u8),
    /// Slot in which the module is expected.
    Slot(u16),
    /// Ident number of the module in slot 0, the device access point.
    AccessPointIdent(u32),
    /// Send the RPC headers of this connection in little-endian byte order.
    LittleEndian,
    /// Do not assign an IP address; connect to the current address of the device.
    NoAddress,
    /// The field of the Connect request with this word has this value.
    ConnectField(String, u64),
    /// Wait before the end of the parameters.
    ParameterPause(Duration),
    /// Do not expect the submodule of slot 0.
    NoAccessPoint,
    /// Expect the submodules of the interface and the ports as well.
    NetworkExpected,
    /// The connection of a supervisor for records only.
    SupervisorAccess,
    /// PROFIBUS: do not send Set_Prm.
    NoSetPrm,
    /// The whole Set_Prm.
    SetPrm(Vec<u8>),
    /// The bytes of Set_Prm after the seven standard bytes.
    UserOctets(Vec<u8>),
    /// The three DP-V1 bytes of Set_Prm.
    Dpv1([u8; 3]),
    /// Do not send Chk_Cfg.
    NoChkCfg,
    /// The whole Chk_Cfg.
    ChkCfg(Vec<u8>),
    /// Ident number in Set_Prm.
    Ident(u16),
    /// Lock_Req and Unlock_Req in Set_Prm.
    Lock { lock: bool, unlock: bool },
    /// Freeze_Req in Set_Prm.
    FreezeRequest,
    /// Sync_Req in Set_Prm.
    SyncRequest,
    /// Min_TSDR in Set_Prm.
    MinTsdr(u8),
    /// Group_Ident in Set_Prm.
    Groups(u8),
    /// The two watchdog factors in Set_Prm.
    WatchdogFactors(u8, u8),
}

/// A step: a verb with its position and the requirements that it is judged for separately.
#[derive(Debug, Deserialize, Serialize)]
pub struct TrialStep {
    pub at: Location,
    /// The step as shown in reports: one line, with values of tables and procedures filled in.
    pub text: String,
    /// Requirements that this check is judged for separately; its failure does not end the trial.
    pub covers: Vec<usize>,
    /// Requirements of single names of a `read` or `expect`, each with the index of the name; they are in `covers`, too.
    pub apart: Vec<(usize, Vec<usize>)>,
    /// What a failure of this step is about; it ends the trial, and what the trial covers besides is not judged.
    pub about: FailureSubject,
    /// Why the trial is not applicable if this check does not hold, for what a device may lack.
    pub otherwise: Option<String>,
    pub verb: Verb,
}

/// What a failure of a step is about.
#[derive(Clone, Debug, Default, Deserialize, PartialEq, Eq, Serialize)]
pub enum FailureSubject {
    /// What the step around it says, else the case.
    #[default]
    Unsaid,
    /// The case, as its step that runs a procedure says; this counts more than what the procedure says.
    Case,
    /// These requirements, as the case says; this counts more than what a procedure says.
    OfCase(Vec<usize>),
    /// These requirements, as a procedure says.
    OfProcedure(Vec<usize>),
}

impl FailureSubject {
    /// The requirements that the case itself names.
    pub fn of_case(&self) -> &[usize] {
        match self {
            FailureSubject::OfCase(list) => list,
            FailureSubject::Unsaid | FailureSubject::Case | FailureSubject::OfProcedure(_) => &[],
        }
    }

    /// The requirements that the case or a procedure names.
    pub fn requirements(&self) -> &[usize] {
        match self {
            FailureSubject::OfCase(list) | FailureSubject::OfProcedure(list) => list,
            FailureSubject::Unsaid | FailureSubject::Case => &[],
        }
    }
}

/// The action of a step.
#[derive(Debug, Deserialize, Serialize)]
pub enum Verb {
    /// Sets values that hold from now on.
    Set(Vec<Setting>),
    /// Turns the shaft through all intermediate positions.
    Turn(Turn),
    /// Exchanges an exact number of cycles for each entry.
    Exchange(Vec<ExchangeEntry>),
    /// Ends the current connection, if any, then establishes this one.
    Connect {
        start: ConnectionStart,
        /// Expected answer; `None`: the connection is established.
        answer: Option<AnswerMatcher>,
        /// Whether the second controller acts.
        second: bool,
        /// Station address to connect to, if it is not that of the device (PROFIBUS).
        to: Option<Program>,
    },
    /// Ends the current connection.
    Disconnect {
        /// Whether the second controller acts.
        second: bool,
    },
    /// Sends one write request.
    Write(AcyclicAccess),
    /// Sends one read request.
    Read {
        /// The request and the expected values.
        access: AcyclicAccess,
        /// Deadline up to which the request is repeated until the answer is as expected.
        within: Option<Deadline>,
    },
    /// Calls one service.
    Send {
        /// The service and its fields.
        service: AcyclicService,
        /// Expected answer; `None`: accepted.
        answer: Option<AnswerMatcher>,
        /// Whether the second controller acts.
        second: bool,
        /// Station address of the request, if it is not that of the device (PROFIBUS).
        to: Option<Program>,
        /// How often each frame is sent again with the same frame count bit (PROFIBUS).
        repeats: u8,
    },
    /// Waits for a condition.
    Expect {
        /// The condition that has to become true.
        condition: Condition,
        /// The deadline; always filled in by the loader.
        within: Deadline,
        /// How long it has to stay true.
        hold: HoldTime,
    },
    /// Waits.
    Wait(TimeSpan),
    /// Saves values for later steps of this trial.
    Save(Vec<(NameId, Program)>),
    /// A block of steps.
    Block {
        steps: Vec<TrialStep>,
        /// Number of repetitions.
        times: u32,
        /// Observations over the block, judged separately for each repetition.
        observe: Vec<BlockObservation>,
    },
    /// Alternative readings of the manual; the first one that holds is taken.
    Either(Vec<ManualReading>),
}

/// A named reading of the manual.
#[derive(Debug, Deserialize, Serialize)]
pub struct ManualReading {
    /// Its name in the suite.
    pub name: String,
    pub steps: Vec<TrialStep>,
    /// The sentence of the finding, if a device that matches this reading has a fault.
    pub finding: Option<String>,
}

/// Up to when something has to happen.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Deadline {
    /// The limit.
    pub limit: TimeSpan,
    /// If the limit rests on times of ours, how much later is only noted.
    pub ours: Option<Box<OurLimit>>,
}

/// What belongs to a limit that no manual prints.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct OurLimit {
    /// The same limit with each time of ours taken [`patience`](super::device::DeviceTiming::patience) times.
    pub patient: TimeSpan,
    /// The times of ours in it: `timing.reaction`.
    pub names: Vec<String>,
}

/// A span of time or of cycles.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub enum TimeSpan {
    Time(Duration),
    /// Cycles: output frames sent (PROFINET), Data_Exchanges with the device (PROFIBUS).
    Cycles(u64),
    /// A duration that is computed when needed.
    Computed(Program),
}

/// How long a condition has to stay true after it became true.
#[derive(Debug, Deserialize, Serialize)]
pub enum HoldTime {
    /// One sample is enough.
    None,
    /// This long from the first sample at which it is true.
    For(TimeSpan),
    /// Up to, not including, the first sample at which this condition is true.
    Until(Condition),
}

/// A name and its new value.
#[derive(Debug, Deserialize, Serialize)]
pub struct Setting {
    pub name: NameId,
    pub value: SetValue,
}

/// The new value of a name.
#[derive(Debug, Deserialize, Serialize)]
pub enum SetValue {
    /// A value, computed when the step runs.
    Value(Program),
    /// A word of the name (`present`, `down`, `paused`, `held`, `counting`, ...).
    Word(String),
    /// Bytes (`io.outputs`).
    Bytes(Vec<u8>),
}

/// A movement of the shaft.
#[derive(Debug, Deserialize, Serialize)]
pub struct Turn {
    pub way: TurnAngle,
    /// The speed in revolutions per minute.
    pub rpm: Program,
}

/// The angle that a shaft is turned by, clockwise positive.
#[derive(Debug, Deserialize, Serialize)]
pub enum TurnAngle {
    /// In revolutions.
    Revolutions(Program),
    /// In hardware steps.
    Counts(Program),
    /// In degrees.
    Degrees(Program),
}

/// A number of cycles with the same outputs.
#[derive(Debug, Deserialize, Serialize)]
pub struct ExchangeEntry {
    /// Values set at its start.
    pub set: Vec<Setting>,
    /// Number of cycles; 0 skips the entry.
    pub times: Program,
    /// Condition on the answer of each of these cycles (PROFIBUS).
    pub expect: Option<Condition>,
}
