//! What the loader hands to the engine: suites with every name resolved, every table row and every variant spelled out.
//!
//! Nothing here is text to be interpreted again. The engine, the replay and the listings read this and no YAML.

use super::device::{Device, Location, NameId, NameKind};
use super::expr::{Program, Type, Value};
use std::net::Ipv4Addr;
use std::sync::Arc;
use std::time::Duration;
use wire::ethernet::Mac;

/// One manual: its device, its requirements, its bugs, and its cases and rules compiled for each variant.
#[derive(Debug)]
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
#[derive(Debug)]
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
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Level {
    /// The manual says it without ambiguity.
    Must,
    /// It is expected, by the manual or by convention.
    Should,
    /// It is only reported.
    Info,
}

/// Where a requirement comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Source {
    /// The manual prints it.
    Manual,
    /// The PROFIdrive or PROFINET profile demands it.
    Profile,
    /// It is what devices of this kind do.
    Convention,
}

/// What is said of a requirement that no case has to cover.
#[derive(Clone, Debug, PartialEq, Eq)]
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
#[derive(Clone, Debug)]
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
    /// On which way it shows: `cyclic`, `acyclic`, `startup`, `record`, `dcp`, `alarm`, `web` or `model`.
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
#[derive(Clone, Debug)]
pub struct Bug {
    /// The name that `catches` uses.
    pub name: String,
    /// One sentence.
    pub why: String,
    /// Indices into the requirements that it breaks.
    pub breaks: Vec<usize>,
    /// Where it stands.
    pub at: Location,
}

/// A row of a case, compiled for one variant.
#[derive(Debug)]
pub struct Trial {
    /// `<suite>/<case>` or `<suite>/<case>[row]`; with the manual in front it is the name of the test.
    pub id: String,
    /// The case's sentence.
    pub why: String,
    /// Indices of the requirements that the trial as a whole covers (checks may cover others).
    pub covers: Vec<usize>,
    /// The bugs that must make this trial fail, by name.
    pub catches: Vec<String>,
    /// The connection it begins with; `None` for `start: none`.
    pub start: Option<Start>,
    /// Brings the device where the test begins.
    pub given: Vec<Step>,
    /// The test.
    pub steps: Vec<Step>,
    /// Runs always.
    pub finally: Vec<Step>,
    /// The names of `save`, by their number in [`NameKind::Saved`].
    pub saved: Vec<String>,
    /// The line that runs it alone stands here.
    pub at: Location,
}

/// A connection to be made.
#[derive(Clone, Debug)]
pub struct Start {
    /// Index into `device.modules`.
    pub module: usize,
    /// The time between two cyclic frames; a whole number of send clocks.
    pub cycle: Duration,
    /// The time without frames after which the connection ends.
    pub watchdog: Duration,
    /// The value of each start parameter: record, field (indices into `device.records`), value as it goes on the wire.
    pub parameters: Vec<StartParameter>,
    /// What is changed against the right start-up.
    pub instead: Vec<InsteadStart>,
}

/// A start parameter and the value it is given.
#[derive(Clone, Debug)]
pub struct StartParameter {
    /// Index into `device.records`.
    pub record: usize,
    /// Index into the fields of that record.
    pub field: usize,
    /// The number that goes into the field.
    pub value: i128,
}

/// One thing that a start-up does differently.
#[derive(Clone, Debug, PartialEq, Eq)]
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
}

/// A step: one verb, where it stands and what it covers for itself.
#[derive(Debug)]
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
#[derive(Debug)]
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
#[derive(Debug)]
pub struct Reading {
    /// Its name in the suite.
    pub name: String,
    /// Expectations and reads.
    pub steps: Vec<Step>,
}

/// A span of time or of cycles.
#[derive(Clone, Debug)]
pub enum Span {
    /// Time.
    Time(Duration),
    /// Cycles: sent output frames (PROFINET).
    Cycles(u64),
    /// Computed when it is needed; a duration.
    Computed(Program),
}

/// How long a condition has to stay true once it was.
#[derive(Debug)]
pub enum Hold {
    /// One sample is enough.
    None,
    /// So long from the first sample at which it is true.
    For(Span),
    /// Up to, not including, the first sample at which this is true.
    Until(Condition),
}

/// A name and what it is set to.
#[derive(Debug)]
pub struct Setting {
    /// The name.
    pub name: NameId,
    /// The value.
    pub value: SetValue,
}

/// What a name is set to.
#[derive(Debug)]
pub enum SetValue {
    /// A value, computed when the step is done.
    Value(Program),
    /// A word of the name (`present`, `down`, `paused`, `held`, `counting`, ...).
    Word(String),
    /// Octets (`io.outputs`).
    Bytes(Vec<u8>),
}

/// A movement of the shaft.
#[derive(Debug)]
pub struct Turn {
    /// How far.
    pub way: Way,
    /// How fast, in revolutions per minute.
    pub rpm: Program,
}

/// How far a shaft is turned, clockwise positive.
#[derive(Debug)]
pub enum Way {
    /// In revolutions.
    Revolutions(Program),
    /// In hardware steps.
    Counts(Program),
    /// In degrees.
    Degrees(Program),
}

/// A stretch of cycles with the same outputs.
#[derive(Debug)]
pub struct ExchangeEntry {
    /// What is set at its begin.
    pub set: Vec<Setting>,
    /// How many cycles; 0 leaves the entry out.
    pub times: Program,
}

/// An acyclic access: all of its items go into one request.
#[derive(Debug)]
pub struct Access {
    /// Which service carries it.
    pub via: Via,
    /// What is read or written, in the order written.
    pub items: Vec<AccessItem>,
    /// What is changed against the right request.
    pub instead: Vec<Instead>,
    /// Which answer is right (writes); `None` asks for acceptance.
    pub answer: Option<Answer>,
    /// Whether the second controller acts.
    pub second: bool,
}

/// The service that carries an access.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Via {
    /// Base mode parameter access through the parameter access point.
    Parameters,
    /// One record (index into `device.records`).
    Record(usize),
    /// DCP.
    Station,
    /// Web pages.
    Pages,
    /// What the second face of the bus says of the device itself: led, counter.
    Stand,
}

/// One name in an access.
#[derive(Debug)]
pub struct AccessItem {
    /// The name.
    pub name: NameId,
    /// Read: what is right. Write: what is written ([`Matcher::Equal`]).
    pub value: Matcher,
}

/// One thing that a request has different from the right one.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Instead {
    /// Parameter request: reference.
    Reference(u8),
    /// Parameter request: request identifier.
    Request(u8),
    /// Parameter request: DO-ID (axis).
    DoId(u8),
    /// Parameter request: number of parameters.
    Count(u8),
    /// Parameter request: attribute.
    Attribute(u8),
    /// Parameter request: number of elements.
    Elements(u8),
    /// Parameter request: subindex.
    Subindex(u16),
    /// Parameter request: format octet.
    Format(u8),
    /// Parameter request: number of values.
    Values(u8),
    /// Length in octets, cut or lengthened with zeros.
    Length(usize),
    /// The whole request.
    Bytes(Vec<u8>),
    /// Record, or the one that carries a parameter request: slot.
    Slot(u16),
    /// Likewise: subslot.
    Subslot(u16),
    /// Likewise: API.
    Api(u32),
    /// Record: index.
    Index(u16),
    /// Station: the octets of the value.
    StationValue(Vec<u8>),
    /// Station: the block qualifier.
    Qualifier(u16),
    /// Station: another station that the request goes to; on a virtual wire only.
    Destination(Mac),
}

/// Whom a DCP identify looks for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Sought {
    /// Every station.
    All,
    /// The station of the name that the bench gives the device.
    OwnName,
    /// The station of this name.
    Name(String),
    /// The station at this place: the neighbour's port and name.
    Alias(String),
}

/// One service of `send`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Service {
    /// DCP reset; the mode by its word (`factory`, ...) and the suboption and qualifier that carry it.
    DcpReset {
        /// Suboption of the control option: 5 or 6.
        suboption: u8,
        /// The block qualifier.
        qualifier: u16,
    },
    /// DCP signal: the device blinks.
    DcpSignal,
    /// DCP identify.
    DcpIdentify(Sought),
    /// Reads a record by its numbers.
    RecordRead {
        /// Slot.
        slot: u16,
        /// Subslot.
        subslot: u16,
        /// Index.
        index: u16,
        /// Octets asked for.
        length: u32,
    },
    /// Writes a record by its numbers.
    RecordWrite {
        /// Slot.
        slot: u16,
        /// Subslot.
        subslot: u16,
        /// Index.
        index: u16,
        /// The data.
        bytes: Vec<u8>,
    },
    /// Announces a neighbour.
    Lldp {
        /// Chassis id.
        chassis: String,
        /// Port id.
        port: String,
    },
    /// Asks by ARP who has an address: the device has to say that it has it.
    Arp {
        /// The address; none for the one that the device was last given.
        ip: Option<Ipv4Addr>,
        /// Whether the question names no sender, as before an address is given.
        probe: bool,
    },
    /// Aborts the own connection with an ERR-RTA.
    Abort,
    /// One of the damaged frames that the controller can make, by its word.
    Broken(String),
    /// A web page is asked for (index into `device.pages`).
    HttpGet {
        /// The page.
        page: usize,
    },
    /// The form of a web page is sent.
    HttpPost {
        /// The page (index into `device.pages`).
        page: usize,
        /// The fields (indices into those of the page) and what is entered.
        fields: Vec<(usize, String)>,
    },
}

/// Which answer is right.
#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "there are few of them, and they live as long as the suite")]
pub enum Answer {
    /// The request is carried out.
    Accepted,
    /// Nobody answers.
    None,
    /// Whatever comes.
    Any,
    /// The request is refused with one of these codes; empty: with any.
    Refused(Vec<Code>),
    /// One of these has to hold.
    OneOf(Vec<Answer>),
    /// Each of these parts has to hold.
    Parts(Vec<(AnswerPart, Answer)>),
    /// The part has this value (`bytes`, `connection`, `module_diff.x`, `status`).
    Is(Matcher),
}

/// A part of an answer.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub enum AnswerPart {
    /// The answer as a whole.
    Whole,
    /// A parameter of a multi-parameter request, as number and subindex.
    Parameter(u16, u16),
    /// The octets of the response.
    Bytes,
    /// Stage of a start-up: the Connect call.
    Connect,
    /// Stage of a start-up: a record (index into `device.records`).
    Record(usize),
    /// Stage of a start-up: what ModuleDiff says of a submodule (index into `device.submodules`).
    ModuleDiff(usize),
    /// Stage of a start-up: end of parameters.
    ParameterEnd,
    /// Stage of a start-up: the device's ApplicationReady.
    ApplicationReady,
    /// Whether a connection stands afterwards: `data` or `none`.
    Connection,
    /// Status of a web answer.
    Status,
    /// Texts that are in a web answer.
    Contains,
    /// Texts that are not in a web answer.
    Lacks,
    /// A web answer as a reader sees it.
    Text,
}

/// A refusal as a word of one of the code tables, with the numbers it stands for.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Code {
    /// PROFIdrive error number.
    Parameter(u16, String),
    /// PNIO status: ErrorDecode and ErrorCode1 (ErrorCode2 where the word says so).
    Pnio {
        /// ErrorDecode.
        decode: u8,
        /// ErrorCode1.
        code1: u8,
        /// ErrorCode2, where it counts.
        code2: Option<u8>,
        /// The word.
        word: String,
    },
    /// DCP block error.
    Dcp(u8, String),
}

/// What a value is compared with.
#[derive(Debug)]
pub enum Matcher {
    /// Equal to a computed value, with a tolerance where one is given.
    Equal(super::expr::Target),
    /// A word of the name.
    Word(String),
    /// A set of words: order free, number of entries exact.
    Set(Vec<String>),
    /// Octets, with `..` for any octet and `*` for any rest.
    Bytes(super::expr::BytePattern),
    /// A web page that has all of these texts, the case of letters apart.
    Contains(Vec<String>),
    /// A web page that has none of these texts.
    Lacks(Vec<String>),
    /// Anything that is there.
    Any,
    /// One of these.
    In(Vec<Matcher>),
    /// Both ends inclusive, one may be missing.
    Range {
        /// The lower end.
        from: Option<Program>,
        /// The upper end.
        to: Option<Program>,
    },
    /// Anything else than this.
    Not(Box<Matcher>),
    /// The answer refuses with one of these codes; empty: with any.
    Refused(Vec<Code>),
    /// The answer accepts.
    Accepted,
}

/// A condition: all parts have to be true.
#[derive(Debug)]
pub struct Condition {
    /// The parts, in the order written.
    pub parts: Vec<Part>,
}

/// One part of a condition.
#[derive(Debug)]
pub struct Part {
    /// As written.
    pub text: String,
    /// What is tested.
    pub test: Test,
}

/// What a part of a condition tests.
#[derive(Debug)]
pub enum Test {
    /// An expression that is a condition.
    Expression(Program),
    /// A name against a matcher.
    Name(NameId, Matcher),
}

/// A rule of a file: judged on every connection of every trial, live run and capture.
#[derive(Debug)]
pub struct Rule {
    /// `<suite>/<id>`; with the manual in front it is the name of the test.
    pub id: String,
    /// Its sentence.
    pub why: String,
    /// Indices of the requirements.
    pub covers: Vec<usize>,
    /// Bugs that it catches, by name.
    pub catches: Vec<String>,
    /// What it says.
    pub body: RuleBody,
    /// The modules (indices into `device.modules`) that have all of its signals.
    pub modules: Vec<usize>,
    /// Where it stands.
    pub at: Location,
}

/// What a rule says.
#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "there are few of them, and they live as long as the suite")]
pub enum RuleBody {
    /// True at every sample at which it is known.
    Always(Condition),
    /// Each time the premise is true, the consequence follows.
    When {
        /// The premise, looked at on every frame and event.
        premise: Program,
        /// What follows.
        then: Condition,
        /// Not later than this after the premise.
        within: Span,
        /// How long it then has to stay true.
        hold: Hold,
    },
}

/// A rule over a block.
#[derive(Debug)]
pub enum Observation {
    /// A rule without id.
    Rule {
        /// As written.
        text: String,
        /// Where it stands.
        at: Location,
        /// What it says.
        body: RuleBody,
    },
    /// The number of frames or events at which a condition is true.
    Count {
        /// As written.
        text: String,
        /// Where it stands.
        at: Location,
        /// What is counted.
        condition: Program,
        /// The number that is right.
        is: Matcher,
    },
    /// The values that names take one after the other, equal neighbours taken as one.
    Sequence {
        /// As written.
        text: String,
        /// Where it stands.
        at: Location,
        /// The names.
        names: Vec<Program>,
        /// The values that are right, one entry after the other.
        is: Vec<SequenceEntry>,
    },
}

/// One entry of a sequence.
#[derive(Debug)]
pub enum SequenceEntry {
    /// The values of all names.
    Values(Vec<Value>),
    /// One of several runs of values.
    Either(Vec<Vec<Vec<Value>>>),
}

impl Condition {
    /// Visits the programs of the condition in the order in which it is walked.
    pub fn each_program<'a>(&'a self, visit: &mut dyn FnMut(&'a Program)) {
        for part in &self.parts {
            match &part.test {
                Test::Expression(program) => visit(program),
                Test::Name(_, matcher) => matcher.each_program(visit),
            }
        }
    }

    /// Visits the names whose values the condition depends on.
    pub fn each_name(&self, visit: &mut dyn FnMut(NameId)) {
        for part in &self.parts {
            if let Test::Name(name, _) = part.test {
                visit(name);
            }
        }
        self.each_program(&mut |program| program.names().for_each(&mut *visit));
    }
}

impl Matcher {
    fn each_program<'a>(&'a self, visit: &mut dyn FnMut(&'a Program)) {
        match self {
            Matcher::Equal(target) => visit(target.center()),
            Matcher::In(list) => list.iter().for_each(|matcher| matcher.each_program(visit)),
            Matcher::Range { from, to } => from.iter().chain(to).for_each(visit),
            Matcher::Not(matcher) => matcher.each_program(visit),
            Matcher::Word(_)
            | Matcher::Set(_)
            | Matcher::Bytes(_)
            | Matcher::Contains(_)
            | Matcher::Lacks(_)
            | Matcher::Any
            | Matcher::Refused(_)
            | Matcher::Accepted => {}
        }
    }
}
