//! Opens the live devices that the command line names.

use super::encoder::GsdmlEncoder;
use super::{CommandError, Suites, print_message};
use ::live::application::{ApplicationOnBench, PreparedApplication};
use ::live::device::{ComparedDevice, DeviceOnBench, ReplaceManual};
use description::gsd::{self, DescribedSlave};
use description::gsdml::{self, Gsdml, ReportedIdentity, SensorFormat};
use description::variant::{profibus_readings, profinet_readings};
use engine::{DpLine, DutKind, DutSpec, LiveDevice, SharedLiveDevice};
use expression::Value;
use link::Port;
use live::device_discovery::ExpectedDevice;
use live::lock::Lock;
use live::preflight::{self, PreflightPurpose};
use live::profibus;
use live::stand::LiveStand;
use results::bench_file::{self, ANY_DEVICE, ANY_SLAVE, BenchFile, DeviceClaim, LinkSpec};
use results::outcome::DescriptionKind;
use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Duration;
use suite::device::{DeviceDescription, Origin};
use suite::model::Manual;
use suite::persona::Persona;
use suite_yaml::{ANY_DP_ENCODER, ANY_ENCODER, BenchTimes, Sources, load};

/// A live device as named on the command line.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum LiveTarget {
    /// A link, and the manual and variant that the device claims to be.
    Link(LinkSpec, DeviceClaim),
    /// A bench file.
    File(std::path::PathBuf),
}

impl LiveTarget {
    /// The bench of the device; reads the bench file.
    pub fn bench(&self, manuals: &[Manual]) -> Result<BenchFile, CommandError> {
        match self {
            LiveTarget::Link(link, claim) => Ok(BenchFile::bare(link.clone(), claim.clone())),
            LiveTarget::File(path) => {
                let mut bench = bench_file::read_alone(path)?;
                if let Some(encoder) = GsdmlEncoder::of_bench(&bench)? {
                    ANY_ENCODER.clone_into(&mut bench.claim.manual);
                    bench.telegrams.get_or_insert(encoder.telegrams()?);
                    return Ok(bench);
                }
                if ![ANY_DEVICE, ANY_SLAVE].contains(&bench.claim.manual.as_str()) {
                    return Ok(bench_file::read(path, manuals)?);
                }
                if let Some((_, slave)) = described_by_gsd(&bench)? {
                    let claimed = || slave.claimed.iter().map(|name| (*name).to_owned()).collect();
                    bench.telegrams.get_or_insert_with(claimed);
                }
                Ok(bench)
            }
        }
    }
}

/// What the GSD of a bench says of a slave that has neither a manual nor a description.
fn described_by_gsd(bench: &BenchFile) -> Result<Option<(&Path, DescribedSlave)>, CommandError> {
    let gsd = bench.description_of(DescriptionKind::Gsd);
    // `device: dp-slave/plain` is the plain device itself.
    let is_unknown = bench.claim.manual == ANY_SLAVE && bench.claim.variant.is_empty();
    let Some(path) = gsd.filter(|_| is_unknown && bench.description.is_none()) else {
        return Ok(None);
    };
    let described = gsd::describe(&super::gsd::open(path)?, bench.gsd_module.as_deref()).map_err(|error| {
        CommandError::usage(format!(
            "{}: {error}; or describe the slave in a file, and name it under `description`",
            path.display()
        ))
    })?;
    Ok(Some((path, described)))
}

/// Locks the device of a bench. Waits at most `patience` for another process that holds the lock.
pub fn lock(bench: &BenchFile, patience: Duration) -> Result<Lock, CommandError> {
    let device = lock_name(bench);
    let mut waiting = |holder| print_message(&format!("{device} is in use by {holder}; waiting for it"));
    let lock = Lock::take(&device, &std::env::temp_dir(), patience, &mut waiting);
    lock.map_err(|error| CommandError::bench(error.to_string()))
}

/// The name of the lock; the same for all spellings of the same link.
fn lock_name(bench: &BenchFile) -> String {
    match &bench.link {
        LinkSpec::Nic(name) => format!("nic:{name}"),
        LinkSpec::Serial(path) => {
            let path = std::fs::canonicalize(path).map_or_else(|_| path.clone(), |path| path.display().to_string());
            format!("serial:{path}")
        }
        LinkSpec::Socket(address) => {
            let path = address.rsplit(':').next().unwrap_or(address);
            format!(
                "socket:{}",
                std::fs::canonicalize(path).map_or_else(|_| address.clone(), |path| path.display().to_string())
            )
        }
        // Each bench starts a program of its own, so none is in use elsewhere.
        LinkSpec::App(_) => {
            static BENCHES: AtomicU64 = AtomicU64::new(0);
            format!("app:{}:{}", std::process::id(), BENCHES.fetch_add(1, Ordering::Relaxed))
        }
    }
}

/// Opens the bench and finds the device. Only the name and address of the device may have been changed when this returns.
///
/// Trials on PROFINET use `persona`; PROFIBUS ignores it.
pub fn open(
    bench: BenchFile,
    suites: &Suites,
    long: bool,
    persona: Option<Arc<Persona>>,
) -> Result<DutSpec, CommandError> {
    open_for(PreflightPurpose::Run, None, bench, suites, long, persona)
}

/// The same for another purpose, perhaps at a port that is open already.
pub fn open_for(
    purpose: PreflightPurpose<'_>,
    port: Option<Box<dyn Port>>,
    mut bench: BenchFile,
    suites: &Suites,
    long: bool,
    persona: Option<Arc<Persona>>,
) -> Result<DutSpec, CommandError> {
    let mut manual = manual(&bench, suites)?;
    let unshifted = GsdmlEncoder::of_bench(&bench)?.is_some().then(|| bench.clone());
    if bench.link.bus().is_some_and(|bus| bus != manual.device.bus.kind()) {
        let name = &manual.device.name;
        return Err(CommandError::usage(match manual.device.profibus() {
            Some(_) => format!("{name} is a PROFIBUS device; its link is `serial:TTY`, not {}", bench.link),
            None => {
                format!("{name} is a PROFINET device; its link is `nic:IF` or `socket:ADDRESS`, not {}", bench.link)
            }
        }));
    }
    let variant = manual.device.variants.iter().position(|known| *known == bench.claim.variant).unwrap_or_default();
    // With `device: none` the bench file names no variant; the description has only one.
    bench.claim.variant.clone_from(&manual.device.variants[variant]);
    let device =
        Arc::get_mut(&mut manual.device).ok_or_else(|| CommandError::bench("the suite is in use elsewhere"))?;
    bench.describe_pages(device);
    let DeviceClaim { manual: name, variant: claimed } = bench.claim.clone();
    link::interrupt::watch();
    if matches!(bench.link, LinkSpec::App(_)) {
        let device = Arc::new(prepare_application(bench, manual, variant, persona)?);
        return dut_with_sensor_format(device, unshifted.as_ref(), suites, (name, claimed));
    }
    let live = match manual.device.profibus() {
        None => prepare_profinet_device(purpose, port, bench, manual, variant, long, persona)?,
        Some(_) => prepare_profibus_slave(purpose, bench, manual, variant, long)?,
    };
    if let Some(why) = live.passive() {
        print_message(&format!("only cases that read are run: {why}"));
    }
    dut_with_sensor_format(Arc::new(live), unshifted.as_ref(), suites, (name, claimed))
}

/// The device under test. If only its GSDML describes it, as `unshifted` says, the suite takes from its P979 what no GSDML has.
fn dut_with_sensor_format<D: LiveDevice + ReplaceManual + 'static>(
    mut device: Arc<D>,
    unshifted: Option<&BenchFile>,
    suites: &Suites,
    (manual, variant): (String, String),
) -> Result<DutSpec, CommandError> {
    let dut = |device: Arc<dyn LiveDevice>| DutSpec {
        manual: manual.clone(),
        variant: variant.clone(),
        kind: DutKind::Live(SharedLiveDevice(device)),
    };
    let Some(bench) = unshifted else { return Ok(dut(device)) };
    let known = device.manual().variants.first();
    let asked = dut(device.clone());
    // A bench that cannot be used is reported by the first trial.
    let format = known.and_then(|variant| engine::sensor_format(device.manual(), variant, &asked).ok()?);
    drop(asked);
    if let (Some(format), Some(device)) = (format, Arc::get_mut(&mut device)) {
        let gsdml = bench.description_of(DescriptionKind::Gsdml).map(read_gsdml).transpose()?;
        let mut manual = manual_with_format(bench, suites, format)?;
        if let Some(described) = Arc::get_mut(&mut manual.device) {
            gsdml::overlay(described, 0, gsdml.as_ref(), Some(device.reported()), &bench.start_parameters);
        }
        device.replace_manual(manual);
    }
    Ok(dut(device))
}

/// Starts a program and prepares the device whose application it is.
fn prepare_application(
    bench: BenchFile,
    mut manual: Manual,
    variant: usize,
    persona: Option<Arc<Persona>>,
) -> Result<ApplicationOnBench, CommandError> {
    let gsdml = bench.description_of(DescriptionKind::Gsdml).map(read_gsdml).transpose()?;
    let gsd = bench.description_of(DescriptionKind::Gsd).map(super::gsd::open).transpose()?;
    let start_parameters = bench.start_parameters.clone();
    let prepared = PreparedApplication::start(bench, manual.device.bus.kind()).map_err(CommandError::bench)?;
    let device =
        Arc::get_mut(&mut manual.device).ok_or_else(|| CommandError::bench("the suite is in use elsewhere"))?;
    let (compared, notes) = match device.profibus() {
        None => compared_by_gsdml(device, variant, gsdml.as_ref(), &prepared.reported, &start_parameters),
        Some(_) => compared_by_gsd(device, variant, gsd.as_ref(), &start_parameters),
    };
    Ok(ApplicationOnBench::new(prepared, manual, compared, notes, persona))
}

/// Fills in what a GSDML and the device say, and compares them with the manual; also returns what was taken and what is missing.
fn compared_by_gsdml(
    device: &mut DeviceDescription,
    variant: usize,
    gsdml: Option<&Gsdml>,
    reported: &ReportedIdentity,
    start_parameters: &[(String, String)],
) -> (ComparedDevice, Vec<String>) {
    let reported = Some(reported);
    // A description that was made of the GSDML agrees with it.
    let compared = gsdml.filter(|_| device.bus.number_origin() != Origin::Description);
    let variant_readings = profinet_readings(device, gsdml, reported);
    let overlay = gsdml::overlay(device, variant, gsdml, reported, start_parameters);
    let findings = gsdml::compare(device, variant, compared, reported);
    (ComparedDevice { findings, variant_readings }, [overlay.taken, overlay.missing].concat())
}

/// The same with the GSD of a slave.
fn compared_by_gsd(
    device: &mut DeviceDescription,
    variant: usize,
    gsd: Option<&gsd::Gsd>,
    start_parameters: &[(String, String)],
) -> (ComparedDevice, Vec<String>) {
    let variant_readings = profibus_readings(device, gsd);
    let overlay = gsd::overlay(device, gsd, start_parameters);
    let findings = gsd.iter().flat_map(|known| gsd::compare(device, variant, known)).collect();
    (ComparedDevice { findings, variant_readings }, [overlay.taken, overlay.missing].concat())
}

/// Prepares a PROFINET device.
fn prepare_profinet_device(
    purpose: PreflightPurpose<'_>,
    port: Option<Box<dyn Port>>,
    mut bench: BenchFile,
    mut manual: Manual,
    variant: usize,
    long: bool,
    persona: Option<Arc<Persona>>,
) -> Result<DeviceOnBench, CommandError> {
    let description = bench.description_of(DescriptionKind::Gsdml).map(read_gsdml).transpose()?;
    let device =
        Arc::get_mut(&mut manual.device).ok_or_else(|| CommandError::bench("the suite is in use elsewhere"))?;
    let firmware_pages = device.pages_for_firmware().map(|page| page.path.clone()).collect();
    let (vendor_id, device_id) = device.ids().unwrap_or_default();
    let described = description.as_ref().filter(|known| known.vendor_id == vendor_id).map(|known| known.device_id);
    let printed = (device.bus.number_origin() != Origin::Invented).then_some(device_id);
    let cycle = device.timing.cycle;
    let cycle = persona.as_ref().and_then(|of| of.cycle).map_or(cycle, |of| of.time().max(cycle));
    let expected = ExpectedDevice { vendor_id, device_id: printed.or(described), cycle, firmware_pages };
    let scheduling = link::realtime::raise();
    let mut offers = None;
    let mut opened = || query_stand_abilities(&bench, &mut offers);
    let prepared = match port {
        Some(port) => preflight::prepare_at(port, &bench, &expected, purpose, &mut opened),
        None => preflight::prepare(&bench, &expected, purpose, &mut opened),
    };
    let mut prepared = prepared.map_err(|why| CommandError::bench(why.to_string()))?;
    bench.stand.offers = offers;
    prepared.notes.extend(scheduling.granted.into_iter().chain(scheduling.refused));
    let (compared, notes) =
        compared_by_gsdml(device, variant, description.as_ref(), &prepared.reported, &bench.start_parameters);
    prepared.notes.extend(notes);
    Ok(DeviceOnBench::new(bench, manual, prepared, long, compared, persona))
}

/// Prepares a PROFIBUS slave.
fn prepare_profibus_slave(
    purpose: PreflightPurpose<'_>,
    mut bench: BenchFile,
    mut manual: Manual,
    variant: usize,
    long: bool,
) -> Result<DeviceOnBench, CommandError> {
    let description = bench.description_of(DescriptionKind::Gsd).map(super::gsd::open).transpose()?;
    let device =
        Arc::get_mut(&mut manual.device).ok_or_else(|| CommandError::bench("the suite is in use elsewhere"))?;
    let printed = device.ident().filter(|_| device.bus.number_origin() != Origin::Invented);
    let expected = profibus::preflight::ExpectedSlave {
        ident: printed.or(description.as_ref().map(|known| known.ident)),
        address: device.profibus().map_or(DpLine::default().station, |slave| slave.address),
        cycle: device.timing.cycle,
        max_tsdr: description.as_ref().map(|known| known.max_tsdr.clone()).unwrap_or_default(),
    };
    let scheduling = link::realtime::raise();
    let mut offers = None;
    let prepared =
        profibus::preflight::prepare(&bench, &expected, purpose, &mut || query_stand_abilities(&bench, &mut offers));
    let mut prepared = prepared.map_err(|why| CommandError::bench(why.to_string()))?;
    bench.stand.offers = offers;
    prepared.notes.extend(scheduling.granted.into_iter().chain(scheduling.refused));
    let (compared, notes) = compared_by_gsd(device, variant, description.as_ref(), &bench.start_parameters);
    prepared.notes.extend(notes);
    Ok(DeviceOnBench::on_bus(bench, manual, prepared, long, compared))
}

/// Queries the abilities of the stand's control channel, once, before any frame is sent.
fn query_stand_abilities(bench: &BenchFile, offers: &mut Option<Vec<String>>) -> Result<Option<Vec<String>>, String> {
    *offers = LiveStand::new(&bench.stand).offers()?;
    Ok(offers.clone())
}

/// Loads the suite that the device claims to implement, with the times of the bench.
pub(super) fn manual(bench: &BenchFile, suites: &Suites) -> Result<Manual, CommandError> {
    manual_with_format(bench, suites, SensorFormat::default())
}

/// The same for an encoder without a manual whose P979 says this.
fn manual_with_format(bench: &BenchFile, suites: &Suites, format: SensorFormat) -> Result<Manual, CommandError> {
    let sources = sources_with_format(bench, suites, format)?;
    let mut manuals = load(&sources, Some(&bench.claim.manual))?;
    manuals.pop().ok_or_else(|| CommandError::usage(format!("there is no suite for {}", bench.claim.manual)))
}

/// The files of the suite that the device claims to implement, for an open device.
pub(super) fn sources(bench: &BenchFile, suites: &Suites, dut: &DutSpec) -> Result<Sources, CommandError> {
    let known = dut.live().filter(|_| bench.claim.variant.is_empty());
    let format =
        known.and_then(|live| engine::sensor_format(live.manual(), live.manual().variants.first()?, dut).ok()?);
    sources_with_format(bench, suites, format.unwrap_or_default())
}

fn sources_with_format(bench: &BenchFile, suites: &Suites, format: SensorFormat) -> Result<Sources, CommandError> {
    let boot_time = bench.boot_time.map(|time| ("power_up".to_owned(), Value::nanos(time.as_nanos() as i128)));
    let times = BenchTimes {
        cycle: bench.cycle,
        watchdog: bench.watchdog,
        ours: boot_time.into_iter().chain(bench.timing.ours.iter().cloned()).collect(),
        patience: bench.timing.patience,
        tolerances: bench.tolerances.clone(),
    };
    let mut sources = suites.sources()?.on_bench(times);
    if let Some(path) = &bench.description {
        let text = std::fs::read_to_string(path).map_err(|error| {
            CommandError::usage(format!("the description {} cannot be read: {error}", path.display()))
        })?;
        sources = sources.described(&bench.claim.manual, path, text);
    } else if let Some((path, slave)) = described_by_gsd(bench)? {
        sources = sources.described(ANY_SLAVE, path, slave.text);
        if slave.is_encoder {
            sources = sources.joined(ANY_SLAVE, ANY_DP_ENCODER);
        }
    } else if let Some(encoder) = GsdmlEncoder::of_bench(bench)? {
        sources = encoder.sources(sources, format)?;
    }
    Ok(sources)
}

pub(super) fn read_gsdml(path: &Path) -> Result<Gsdml, CommandError> {
    let failed = |why: String| CommandError::usage(format!("the GSDML {}: {why}", path.display()));
    let octets = std::fs::read(path).map_err(|error| failed(error.to_string()))?;
    gsdml::read_octets(&octets).map_err(|error| failed(error.to_string()))
}
