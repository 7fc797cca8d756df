//! A program as the engine uses it: an encoder application without a network stack, behind the stacks of the workspace on a virtual
//! wire.
//!
//! Time is virtual and each trial begins with a device in factory state, so nothing lasts: there is no preflight, no journal, and
//! nothing to restore.

use crate::device::{ComparedDevice, ReplaceManual, needs_description_of};
use application_protocol::{
    ApplicationBus, ApplicationProgram, DescribedIoDevice, DescribedSubmodule, PATIENCE, ProgramCommand,
    ProgramFailure, RemoteIoApplication, RemoteSlaveApplication, SharedProgram, in_program,
};
use description::gsdml::{PluggedSubmodule, ReportedIdentity};
use description::variant::VariantReading;
use deviations::ReferenceDevice;
use device_stack::profinet::{INTERFACE_IDENT, INTERFACE_SUBSLOT, IoDevice, PORT_IDENT, PORT_SUBSLOT, StationData};
use device_stack::{Attached, profibus};
use engine::dut::{DEVICE, STATION_NAME, virtual_segment};
use engine::needs::{self, BenchNeed};
use engine::segment::{FrameTap, ModelOnStand, NoStand, PeerWithoutStand, Segment};
use engine::{
    Disturbance, DutSpec, HarnessStations, LiveDevice, NullPeer, TrialEnvironment, TrialExclusion, VirtualStart,
};
use results::bench_file::command::CommandLine;
use results::bench_file::{BenchFile, Consents, LinkSpec, ShaftAbility, StandSpec};
use results::journal::{InitialDevice, JournalEntry};
use results::outcome::DeviceFinding;
use station::{Duration, Stand, Time};
use std::fmt;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use suite::device::Bus;
use suite::model::{Manual, SuiteVariant, Trial};
use suite::persona::Persona;
use virtual_wire::null::Silent;
use wire::ethernet::Mac;

/// What the stacks and the virtual wire do themselves, by the names of `stand` in a bench file.
const STACK_ABILITIES: [&str; 4] = ["power", "link", "clock", "device"];
/// After this number of consecutive silences, each of which takes [`PATIENCE`], the program is not tested any more.
const SILENCE_LIMIT: u32 = 3;

/// A running program and the bench file that it is tested with.
pub struct PreparedApplication {
    program: SharedProgram,
    bench: BenchFile,
    bus: ApplicationBus,
    /// What the program says of its device on PROFINET.
    pub reported: ReportedIdentity,
}

impl PreparedApplication {
    /// Starts the program that the link of `bench` names.
    ///
    /// # Errors
    ///
    /// A sentence for people: the program cannot be started, or does not describe itself.
    pub fn start(mut bench: BenchFile, bus: Bus) -> Result<PreparedApplication, String> {
        let LinkSpec::App(command) = &bench.link else { return Err(format!("{} is not a program", bench.link)) };
        let words = CommandLine::parse(command).map_err(|why| format!("`app:{command}` is not a command: {why}"))?;
        let folder = bench.path.as_deref().and_then(Path::parent).unwrap_or(Path::new(""));
        let command = ProgramCommand::new(words.filled(&[]), folder);
        let bus = if bus.is_profibus() { ApplicationBus::Profibus } else { ApplicationBus::Profinet };
        let program = ApplicationProgram::start(command, bus, PATIENCE).map_err(|failure| failure.to_string())?;
        let described = Arc::clone(program.description());
        bench.stand = stand(&described.stand, &bench.stand);
        bench.direct_cable = true;
        bench.consent = Consents {
            factory_reset: true,
            set_name: true,
            set_ip: true,
            set_address: true,
            im_records: true,
            lock_address: true,
            nvm_write: u32::MAX,
            position_reference: true,
            firmware: true,
            overstress: true,
            alone: true,
        };
        let mut reported = ReportedIdentity::default();
        if let Some(device) = &described.profinet {
            reported.ids(device.vendor_id, device.device_id);
            reported.plugged = device.submodules.iter().map(plugged).chain(interface_and_ports(device)).collect();
        }
        Ok(PreparedApplication { program: Arc::new(Mutex::new(program)), bench, bus, reported })
    }
}

fn plugged(of: &DescribedSubmodule) -> PluggedSubmodule {
    PluggedSubmodule {
        api: of.api,
        slot: of.slot,
        module_ident: of.module_ident,
        subslot: of.subslot,
        submodule_ident: of.submodule_ident,
        octets: Some((of.inputs, of.outputs)),
    }
}

/// The submodules that the stack adds to the access point.
fn interface_and_ports(device: &DescribedIoDevice) -> Vec<PluggedSubmodule> {
    let Some(access_point) = device.submodules.iter().find(|of| of.slot == 0) else { return Vec::new() };
    let ports = (0..device.ports).map(|port| (PORT_SUBSLOT + port, PORT_IDENT + u32::from(port)));
    let added = std::iter::once((INTERFACE_SUBSLOT, INTERFACE_IDENT)).chain(ports);
    let added = added.map(|(subslot, submodule_ident)| DescribedSubmodule {
        api: 0,
        subslot,
        submodule_ident,
        inputs: 0,
        outputs: 0,
        ..*access_point
    });
    added.map(|of| plugged(&of)).collect()
}

/// The stand of a program with these abilities: it turns and places the shaft exactly.
fn stand(abilities: &[String], of_bench: &StandSpec) -> StandSpec {
    let can = |name: &str| abilities.iter().any(|known| known == name);
    let stack = STACK_ABILITIES.iter().map(|name| (*name).to_owned());
    StandSpec {
        hooks: stack.chain(abilities.iter().cloned()).map(|name| (name, String::new())).collect(),
        shaft: ShaftAbility {
            hand: false,
            position: (can("shaft.counts") || can("turn")).then_some(0.0),
            speed: can("shaft.speed").then_some(0.0),
            uncoupled: true,
        },
        ..of_bench.clone()
    }
}

/// A program as a device under test.
pub struct ApplicationOnBench {
    prepared: PreparedApplication,
    manual: Manual,
    place: TrialEnvironment,
    found: InitialDevice,
    compared: ComparedDevice,
    notes: Vec<String>,
    state: Mutex<ApplicationState>,
}

#[derive(Default)]
struct ApplicationState {
    /// How often in a row the program did not answer.
    silent: u32,
    /// Why no further trial is possible.
    lost: Option<String>,
}

impl ApplicationOnBench {
    /// A program with the suite of its claimed type, with remarks for the report.
    pub fn new(
        prepared: PreparedApplication,
        manual: Manual,
        compared: ComparedDevice,
        notes: Vec<String>,
        persona: Option<Arc<Persona>>,
    ) -> ApplicationOnBench {
        // The addresses are those of every virtual bench.
        let virtual_bench = DutSpec {
            manual: manual.device.name.clone(),
            variant: String::new(),
            kind: engine::DutKind::Null(NullPeer::Silent),
        };
        let place = TrialEnvironment {
            bench: Some(Arc::new(prepared.bench.clone())),
            noise: prepared.bench.position_noise,
            persona,
            ..virtual_bench.environment()
        };
        let found = InitialDevice { began: 0, ..InitialDevice::of(&prepared.bench) };
        ApplicationOnBench { prepared, manual, place, found, compared, notes, state: Mutex::default() }
    }

    fn state(&self) -> std::sync::MutexGuard<'_, ApplicationState> {
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Starts the program again if it failed, unless it is silent again and again.
    fn revive(&self) -> Result<(), String> {
        let mut state = self.state();
        if let Some(why) = &state.lost {
            return Err(format!("no further trial is possible: {why}"));
        }
        let mut program = in_program(&self.prepared.program);
        let is_silent = matches!(program.failure(), Some(ProgramFailure::Silent { .. }));
        let Some(failure) = program.failure().map(ToString::to_string) else {
            state.silent = 0;
            return Ok(());
        };
        state.silent = if is_silent { state.silent + 1 } else { 0 };
        let lost = if state.silent >= SILENCE_LIMIT {
            Some(failure)
        } else {
            program.revive().err().map(|again| format!("the program cannot be started again: {again}"))
        };
        match lost {
            Some(why) => {
                state.lost = Some(why.clone());
                Err(why)
            }
            None => Ok(()),
        }
    }

    /// A new device that begins with the program in factory state.
    fn device(&self, start: VirtualStart, station: StationData, address: u8) -> Option<Box<dyn ReferenceDevice>> {
        let program = Arc::clone(&self.prepared.program);
        Some(match self.prepared.bus {
            ApplicationBus::Profinet => {
                let application = RemoteIoApplication::new(program, start.shaft, station, DEVICE.0.0)?;
                Box::new(IoDevice::new(application, Mac(DEVICE.0.0), Attached::NONE))
            }
            ApplicationBus::Profibus => {
                let application = RemoteSlaveApplication::new(program, start.shaft, address)?;
                Box::new(profibus::DpDevice::new(application, start.line.baud, Attached::NONE))
            }
        })
    }
}

impl ReplaceManual for ApplicationOnBench {
    fn reported(&self) -> &ReportedIdentity {
        &self.prepared.reported
    }

    fn replace_manual(&mut self, manual: Manual) {
        self.manual = manual;
    }
}

/// The address of a slave in factory state, which waits for Set_Slave_Address.
const FACTORY_ADDRESS: u8 = 126;

impl LiveDevice for ApplicationOnBench {
    fn manual(&self) -> &Manual {
        &self.manual
    }

    fn bench(&self) -> &BenchFile {
        &self.prepared.bench
    }

    fn identity(&self) -> String {
        in_program(&self.prepared.program).description().name.clone()
    }

    fn environment(&self) -> &TrialEnvironment {
        &self.place
    }

    fn found(&self) -> &InitialDevice {
        &self.found
    }

    fn findings(&self) -> &[DeviceFinding] {
        &self.compared.findings
    }

    fn variant_readings(&self) -> &[VariantReading] {
        &self.compared.variant_readings
    }

    fn notes(&self) -> &[String] {
        &self.notes
    }

    fn passive(&self) -> Option<&str> {
        None
    }

    fn segment(&self, start: VirtualStart) -> Box<dyn Segment + '_> {
        let named = StationData { name: STATION_NAME.as_bytes().to_vec(), ..StationData::default() };
        let is_settable = in_program(&self.prepared.program).description().profibus.as_ref().map(|of| of.set_address);
        let factory_address = if is_settable == Some(true) { FACTORY_ADDRESS } else { start.line.station };
        let lost = || "the program describes no device on this bus".to_owned();
        let deliver = move || self.device(start, StationData::default(), factory_address).ok_or_else(lost);
        let program = Arc::clone(&self.prepared.program);
        let is_slave = self.prepared.bus == ApplicationBus::Profibus;
        let wire = match self.device(start, named, start.line.station) {
            Some(device) => virtual_segment(ModelOnStand::new(device, Box::new(deliver)), start.line, is_slave),
            // The program has a device on this bus, or it would not have been started.
            None => virtual_segment(PeerWithoutStand(Silent, NoStand), start.line, is_slave),
        };
        Box::new(ApplicationSegment { wire, program })
    }

    fn is_virtual(&self) -> bool {
        true
    }

    fn note(&self, _: &JournalEntry) -> Result<(), String> {
        Ok(())
    }

    fn changes(&self) -> Vec<String> {
        Vec::new()
    }

    fn count_answer(&self, _: bool) {}

    fn next_call(&self) -> u64 {
        0
    }

    fn end_tests(&self, why: &str) {
        self.state().lost.get_or_insert_with(|| why.to_owned());
    }

    fn objection(&self, variant: &SuiteVariant, trial: &Trial) -> Option<String> {
        self.missing(variant, trial).map(|(why, _)| why)
    }

    fn admit(&self, variant: &SuiteVariant, trial: &Trial) -> Result<(), TrialExclusion> {
        if link::interrupt::requested() {
            return Err(TrialExclusion::NotRun("the run was interrupted".to_owned()));
        }
        if let Some((why, lines)) = self.missing(variant, trial) {
            return Err(TrialExclusion::NotApplicable { why, lines });
        }
        self.revive().map_err(TrialExclusion::Inconclusive)
    }
}

impl ApplicationOnBench {
    /// What a trial needs and the bench has not: a sentence, and the lines of the bench file.
    fn missing(&self, variant: &SuiteVariant, trial: &Trial) -> Option<(String, Vec<String>)> {
        // A virtual wire has what no real line has.
        let is_of_line = |need: &BenchNeed| {
            matches!(need, BenchNeed::BitTiming | BenchNeed::Rate(_) | BenchNeed::Virtual(_) | BenchNeed::Long { .. })
        };
        let needs: Vec<BenchNeed> =
            needs::needs(&self.manual, variant, trial).into_iter().filter(|need| !is_of_line(need)).collect();
        let bench = self.bench();
        let mut lines = needs::missing_lines(&needs, bench, true, u32::MAX);
        let of_description = needs_description_of(&self.manual.device, trial);
        if of_description.is_some() {
            lines.push(if self.manual.device.profibus().is_some() { "gsd" } else { "gsdml" }.to_owned());
        }
        needs::missing(&needs, bench, true, u32::MAX).or(of_description).map(|why| (why, lines))
    }
}

impl fmt::Debug for ApplicationOnBench {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "ApplicationOnBench({})", self.prepared.bench.link)
    }
}

/// The virtual wire of a program, which breaks when the program fails.
struct ApplicationSegment<'a> {
    wire: Box<dyn Segment + 'a>,
    program: SharedProgram,
}

impl Segment for ApplicationSegment<'_> {
    fn now(&self) -> Time {
        self.wire.now()
    }

    fn step(&mut self, ours: &mut HarnessStations, until: Time, tap: FrameTap<'_>) -> bool {
        self.wire.step(ours, until, tap)
    }

    fn stand(&mut self) -> &mut dyn Stand {
        self.wire.stand()
    }

    fn take_touch(&mut self) -> bool {
        self.wire.take_touch()
    }

    fn is_model(&self) -> bool {
        false
    }

    fn is_virtual(&self) -> bool {
        true
    }

    fn objections(&self) -> Vec<String> {
        self.wire.objections()
    }

    fn out_of_turn(&self) -> Vec<String> {
        self.wire.out_of_turn()
    }

    fn invalidated(&self) -> Option<Disturbance> {
        in_program(&self.program).failure().map(|failure| Disturbance::lasting(failure.to_string()))
    }

    fn is_interrupted(&self) -> bool {
        link::interrupt::requested()
    }

    fn lateness(&self) -> Duration {
        Duration::ZERO
    }
}
