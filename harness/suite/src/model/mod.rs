//! What the loader hands to the engine: suites with every name resolved, every table row and every variant spelled out.
//!
//! Nothing here is text to be interpreted again. The engine, the replay and the listings read this and no YAML.

mod condition;
mod request;
mod steps;

pub use super::device::AnswerPart;
pub use condition::{Condition, Matcher, Observation, Part, Rule, RuleBody, SequenceEntry, Test};
pub use request::{Access, AccessItem, Answer, Code, DpService, Instead, Service, Sought, Via};
pub use steps::{Steps, TrialSteps};

use super::device::{Device, NameId, NameKind};
use super::location::Location;
use expression::{Program, Type};
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Duration;

use wire::profibus::fdl::BaudRate;

/// One manual: its device, its requirements, its bugs, and its cases and rules compiled for each variant.
#[derive(Debug, Deserialize, Serialize)]
pub struct Manual {
    /// The device description, `device.yaml`.
    pub device: Arc<Device>,
    /// The requirements in the manual's order.
    pub requirements: Vec<Requirement>,
    /// The deliberate bugs that the reference device of this manual can be told to have.
    pub bugs: Vec<Bug>,
    /// The compiled suites, one for each entry of `device.variants`, in that order.
    pub variants: Vec<Variant>,
    /// Definitions that nothing uses, for `encspec check`.
    pub unused: Vec<(String, Location)>,
}

/// One variant of a device with everything compiled for it.
#[derive(Debug, Deserialize, Serialize)]
pub struct Variant {
    /// The name of the variant, as in `device.variants`.
    pub name: String,
    /// Every name that a condition or a step of this variant uses; a [`NameId`] is an index into it.
    pub names: Vec<NameKind>,
    /// The path of each name as suites write it, in the same order.
    pub paths: Vec<String>,
    /// The type of each name, in the same order.
    pub types: Vec<Type>,
    /// The trials in the order of the files, the cases and the rows.
    pub trials: Vec<Trial>,
    /// The rules in the order of the files.
    pub rules: Vec<Rule>,
    /// `derived` of the device: what each expression is called and the program that gives its value.
    pub derived: Vec<(String, Program)>,
}

/// How much a failed requirement weighs.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Deserialize, Serialize)]
pub enum Level {
    /// The manual says it without ambiguity.
    Must,
    /// It is expected, by the manual or by convention.
    Should,
    /// It is only reported.
    Info,
}

/// Where a requirement comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
pub enum Source {
    /// The manual prints it.
    Manual,
    /// The PROFIdrive or PROFINET profile demands it.
    Profile,
    /// It is what devices of this kind do.
    Convention,
}

/// What is said of a requirement that no case has to cover.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum Class {
    /// A case or rule has to cover it.
    Testable,
    /// It shows in others and needs no case of its own.
    Implicit(String),
    /// Nothing on the wire or the stand shows it, and why.
    Untestable(String),
    /// Left out on purpose, and why.
    OutOfScope(String),
    /// The manual contradicts itself, and the reading that was chosen.
    Contradictory(String),
}

/// One testable statement of a manual, in our own words.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Requirement {
    /// For instance `XAC77-PRE-006`.
    pub id: String,
    /// The clause of the manual.
    pub cites: String,
    /// Our sentence of it.
    pub statement: String,
    /// How much a failure weighs.
    pub level: Level,
    /// Where it comes from.
    pub source: Source,
    /// On which way it shows: `cyclic`, `acyclic`, `startup`, `record`, `dcp`, `alarm`, `diagnosis`, `web` or `model`.
    pub channel: String,
    /// The variants it applies to, as indices into `device.variants`.
    pub variants: Vec<usize>,
    /// What the manual leaves open.
    pub ambiguity: Option<String>,
    /// Whether a case has to cover it.
    pub class: Class,
    /// Where it stands.
    pub at: Location,
}

impl Requirement {
    /// The chapter and topic as the name of the file has them: `7 factory reset` of `requirements-07-factory-reset.yaml`.
    pub fn chapter(&self) -> Option<String> {
        let name = self.at.file.file_stem()?.to_str()?;
        let (number, topic) = name.strip_prefix("requirements-")?.split_once('-')?;
        Some(format!("{} {}", number.trim_start_matches('0'), topic.replace('-', " ")))
    }
}

/// A deliberate bug as the suites list it.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Bug {
    /// The name that `catches` uses.
    pub name: String,
    /// What the device does wrong, in one sentence; empty where no reference device is known that can do it.
    pub why: String,
    /// Indices into the requirements that it breaks.
    pub breaks: Vec<usize>,
    /// Where it stands.
    pub at: Location,
}

/// A row of a case, compiled for one variant.
#[derive(Debug, Deserialize, Serialize)]
pub struct Trial {
    /// `<suite>/<case>` or `<suite>/<case>[row]`; with the manual in front it is the name of the test.
    pub id: String,
    /// The case's sentence.
    pub why: String,
    /// Indices of the requirements that the trial as a whole covers (checks may cover others).
    pub covers: Vec<usize>,
    /// The bugs that must make this trial fail, by name.
    pub catches: Vec<String>,
    /// The line that runs it alone stands here.
    pub at: Location,
    /// What its steps come to, for whoever does not run it.
    pub outline: Outline,
    /// How it is run; read from the compiled suites when it is asked for.
    pub how: Steps,
}

impl Trial {
    /// Its id without the row: `<suite>/<case>`.
    pub fn case(&self) -> &str {
        self.id.split('[').next().unwrap_or(&self.id)
    }

    /// How it is run.
    pub fn how(&self) -> &TrialSteps {
        self.how.get()
    }

    /// The connection it begins with; `None` for `start: none`.
    pub fn start(&self) -> Option<&Start> {
        self.how().start.as_ref()
    }

    /// Its steps: those that bring the device where the test begins, those of the test, and those that run always.
    pub fn parts(&self) -> [&[Step]; 3] {
        let TrialSteps { given, steps, finally, .. } = self.how();
        [given, steps, finally]
    }

    /// Keeps what it is about, and nothing of how it is run.
    pub fn forget_steps(&mut self) {
        self.how = TrialSteps::default().into();
    }
}

/// What the steps of a trial come to: all that listings ask of them, so that these need not read the steps.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub struct Outline {
    /// Requirements of the checks that are judged for themselves, in the order of the steps.
    pub checks: Vec<usize>,
    /// The requirements that it covers on a bench without a stand, those of its checks included.
    pub without_stand: Vec<usize>,
    /// Names of readings that it accepts, each with the requirement that is read so: those of the checks that cover it for
    /// themselves, or of the whole trial.
    pub readings: Vec<(usize, String)>,
    /// The LEDs that its steps name, in order: nobody looks at the others.
    pub leds: Vec<usize>,
}

/// A connection to be made.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct Start {
    /// Index into `device.modules`.
    pub module: usize,
    /// The time between two cyclic frames where the case says it; on PROFINET a whole number of send clocks, on PROFIBUS the time
    /// from one Data_Exchange with this slave to the next.
    pub cycle: Option<Duration>,
    /// The time without frames after which the connection ends, where the case says it.
    pub watchdog: Option<Duration>,
    /// Nobody watches over the connection (PROFIBUS: `watchdog: none`).
    pub unwatched: bool,
    /// The transmission rate of the bus where the case says it (PROFIBUS).
    #[serde(with = "crate::encoding::baud")]
    pub baud: Option<BaudRate>,
    /// The time from one Global_Control to the next in isochronous mode, then also the cycle (PROFIBUS).
    pub isochronous: Option<Duration>,
    /// The value of each start parameter: record, field (indices into `device.records`), value as it goes on the wire.
    pub parameters: Vec<StartParameter>,
    /// What is changed against the right start-up.
    pub instead: Vec<InsteadStart>,
}

impl Start {
    /// The time between two cyclic frames: what the case says, else that of the bench or the language.
    pub fn cycle(&self, device: &Device) -> Duration {
        self.isochronous.or(self.cycle).unwrap_or(device.timing.cycle)
    }

    /// The time without frames after which the connection ends: what the case says, else that of the bench, else ten cycles, on
    /// PROFIBUS one second. What `unwatched` says is not looked at.
    pub fn watchdog(&self, device: &Device) -> Duration {
        let cycle = self.cycle(device);
        let usual = device.bus.usual_watchdog(cycle);
        self.watchdog.unwrap_or_else(|| device.timing.watchdog.unwrap_or(usual).max(cycle))
    }
}

/// A start parameter and the value it is given.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub struct StartParameter {
    /// Index into `device.records`.
    pub record: usize,
    /// Index into the fields of that record.
    pub field: usize,
    /// The number that goes into the field.
    pub value: i128,
}

/// One thing that a start-up does differently.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
pub enum InsteadStart {
    /// This record (index into `device.records`) is left out.
    RecordNone(usize),
    /// This record is sent with these octets.
    RecordBytes(usize, Vec<u8>),
    /// Length of the output data of the telegram's submodule as the expected configuration says it, in octets.
    OutputLength(u16),
    /// Length of the input data, likewise.
    InputLength(u16),
    /// Ident number of the module.
    ModuleIdent(u32),
    /// Ident number of the telegram's submodule.
    SubmoduleIdent(u32),
    /// API of the telegram's submodule.
    Api(u32),
    /// The station name that is put into the Connect request.
    StationName(String),
    /// RT class of both IOCRs.
    RtClass(u8),
    /// The slot in which the module is expected.
    Slot(u16),
    /// Ident number of the module in slot 0, the device access point.
    AccessPointIdent(u32),
    /// No address is given; the device is called at the one that it has.
    NoAddress,
    /// PROFIBUS: no Set_Prm is sent.
    NoSetPrm,
    /// The whole Set_Prm.
    SetPrm(Vec<u8>),
    /// The octets of Set_Prm behind the seven that every slave has.
    UserOctets(Vec<u8>),
    /// The three octets of DP-V1 in Set_Prm.
    Dpv1([u8; 3]),
    /// No Chk_Cfg is sent.
    NoChkCfg,
    /// The whole Chk_Cfg.
    ChkCfg(Vec<u8>),
    /// Ident number in Set_Prm.
    Ident(u16),
    /// Lock_Req and Unlock_Req in Set_Prm.
    Lock {
        /// Lock_Req.
        lock: bool,
        /// Unlock_Req.
        unlock: bool,
    },
    /// Freeze_Req in Set_Prm.
    FreezeRequest,
    /// Sync_Req in Set_Prm.
    SyncRequest,
    /// Min_TSDR in Set_Prm.
    MinTsdr(u8),
    /// Group_Ident in Set_Prm.
    Groups(u8),
    /// The two factors of the watchdog in Set_Prm.
    WatchdogFactors(u8, u8),
}

/// A step: one verb, where it stands and what it covers for itself.
#[derive(Debug, Deserialize, Serialize)]
pub struct Step {
    /// Where it stands.
    pub at: Location,
    /// The step as a reader of the report sees it, on one line, tables and procedures filled in.
    pub text: String,
    /// Requirements for which this check is judged alone; its failure does not end the trial.
    pub covers: Vec<usize>,
    /// What is done.
    pub verb: Verb,
}

/// What a step does.
#[derive(Debug, Deserialize, Serialize)]
pub enum Verb {
    /// Holds from now on.
    Set(Vec<Setting>),
    /// Moves the shaft through all places between.
    Turn(Turn),
    /// Each entry is exactly so many cycles.
    Exchange(Vec<ExchangeEntry>),
    /// Ends the own connection if there is one, then makes this one.
    Connect {
        /// The connection to be made.
        start: Start,
        /// Which answer is right; `None` asks for a connection that stands.
        answer: Option<Answer>,
        /// Whether the second controller acts.
        second: bool,
        /// The station address that is called where it is not the device's (PROFIBUS).
        to: Option<Program>,
    },
    /// Ends the own connection.
    Disconnect {
        /// Whether the second controller acts.
        second: bool,
    },
    /// One request that changes something.
    Write(Access),
    /// One request that asks for something.
    Read {
        /// The request and the values that are right.
        access: Access,
        /// Repeated until the answer is right, at most so long.
        within: Option<Span>,
    },
    /// One service without a value.
    Send {
        /// The service and its fields.
        service: Service,
        /// Which answer is right; `None` asks for acceptance.
        answer: Option<Answer>,
        /// Whether the second controller acts.
        second: bool,
        /// The station address that is asked where it is not the device's (PROFIBUS).
        to: Option<Program>,
    },
    /// Looks.
    Expect {
        /// What has to be true.
        condition: Condition,
        /// The deadline; always filled in by the loader.
        within: Span,
        /// The hold.
        hold: Hold,
    },
    /// Lets time go by.
    Wait(Span),
    /// Keeps values of this trial.
    Save(Vec<(NameId, Program)>),
    /// A block of steps.
    Block {
        /// The steps.
        steps: Vec<Step>,
        /// How often.
        times: u32,
        /// Rules that are judged over the block, each repetition for itself.
        observe: Vec<Observation>,
    },
    /// Readings of the manual: the first that holds is taken.
    Either(Vec<Reading>),
}

/// A named reading of the manual.
#[derive(Debug, Deserialize, Serialize)]
pub struct Reading {
    /// Its name in the suite.
    pub name: String,
    /// Expectations and reads.
    pub steps: Vec<Step>,
    /// The sentence about a device that is found so, where this reading is a fault.
    pub finding: Option<String>,
}

/// A span of time or of cycles.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub enum Span {
    /// Time.
    Time(Duration),
    /// Cycles: sent output frames (PROFINET), Data_Exchanges with the device (PROFIBUS).
    Cycles(u64),
    /// Computed when it is needed; a duration.
    Computed(Program),
}

/// How long a condition has to stay true once it was.
#[derive(Debug, Deserialize, Serialize)]
pub enum Hold {
    /// One sample is enough.
    None,
    /// So long from the first sample at which it is true.
    For(Span),
    /// Up to, not including, the first sample at which this is true.
    Until(Condition),
}

/// A name and what it is set to.
#[derive(Debug, Deserialize, Serialize)]
pub struct Setting {
    /// The name.
    pub name: NameId,
    /// The value.
    pub value: SetValue,
}

/// What a name is set to.
#[derive(Debug, Deserialize, Serialize)]
pub enum SetValue {
    /// A value, computed when the step is done.
    Value(Program),
    /// A word of the name (`present`, `down`, `paused`, `held`, `counting`, ...).
    Word(String),
    /// Octets (`io.outputs`).
    Bytes(Vec<u8>),
}

/// A movement of the shaft.
#[derive(Debug, Deserialize, Serialize)]
pub struct Turn {
    /// How far.
    pub way: Way,
    /// How fast, in revolutions per minute.
    pub rpm: Program,
}

/// How far a shaft is turned, clockwise positive.
#[derive(Debug, Deserialize, Serialize)]
pub enum Way {
    /// In revolutions.
    Revolutions(Program),
    /// In hardware steps.
    Counts(Program),
    /// In degrees.
    Degrees(Program),
}

/// A stretch of cycles with the same outputs.
#[derive(Debug, Deserialize, Serialize)]
pub struct ExchangeEntry {
    /// What is set at its begin.
    pub set: Vec<Setting>,
    /// How many cycles; 0 leaves the entry out.
    pub times: Program,
    /// What the answer of each of these cycles shows (PROFIBUS).
    pub expect: Option<Condition>,
}
