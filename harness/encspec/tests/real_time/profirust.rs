//! Interoperability with profirust, a third-party DP master, and the slaves of the PROFIBUS manuals over a pseudoterminal.
//!
//! profirust claims the token, polls for other masters and sends Global_Control, which a slave must tolerate. The expected values come
//! from the manuals; slaves with a bug must not give them. A pseudoterminal has no bit times and a busy host is slow, so the slot time
//! is much longer than on a real bus. The clock of profirust follows real time and is advanced while it polls absent stations.

use crate::{table, tests};
use deviations::{Line as StationLine, Setup, build};
use encspec::live::fdl::FdlFrames;
use libtest_mimic::Trial;
use link::serial::pty;
use link::{Serial, SerialBus, SerialSettings};
use profirust::dp::{DiagnosticFlags, DpMaster, Peripheral, PeripheralEvent, PeripheralHandle, PeripheralOptions};
use profirust::fdl::{FdlActiveStation, ParametersBuilder};
use profirust::phy::ProfibusPhy;
use station::Time;
use std::fs::File;
use std::io::{Read, Write};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::{Duration, Instant};
use testing::stall::run_without_stall;
use wire::profibus::fdl::{BaudRate, BitTimes};

const BAUD: BaudRate = BaudRate(19_200);
/// Slot time: 3 s.
const SLOT_BITS: u16 = 57_600;
const MASTER: u8 = 2;
const SLAVE: u8 = 3;
/// The silence on the bus before profirust starts, so that it claims the token at once.
const SILENCE: Duration = Duration::from_secs(60);
/// A little more than the slot time.
const NO_ANSWER: Duration = Duration::from_secs(4);
/// The number of telegrams within which an expected event must occur.
const TELEGRAMS: usize = 200;
/// How long to wait for bytes before profirust is polled again.
const POLL: Duration = Duration::from_millis(1);
/// How long to wait for an expected event.
const TIMEOUT: Duration = Duration::from_secs(60);
/// A stall of the host up to this length does not affect the exchange.
const TOLERATED_STALL: Duration = Duration::from_secs(1);

pub fn trials() -> Vec<Trial> {
    let mut trials = tests![
        the_amt58_takes_a_preset_of_three_cycles,
        the_amt58_scales_2048_steps_in_each_of_1024_turns,
        the_amt58_refuses_a_wrong_configuration,
        the_a3m60_takes_a_preset_at_an_edge_of_bit_31,
        the_plain_slave_sends_back_what_it_gets,
        a_scaling_in_the_wrong_byte_order_is_detected,
        an_unchecked_configuration_is_detected,
    ];
    trials.extend(table![a_bug_in_the_preset_of_the_amt58_is_detected:
        position(&["position-little-endian"]),
        one_cycle(&["preset-in-the-first-cycle"]),
        four_cycles(&["preset-in-the-fourth-cycle"]),
        not_in_a_row(&["preset-count-not-reset"]),
        undone(&["preset-undone-with-its-bit"]),
        ready(&["ready-before-parameters"]),
        master(&["own-address-as-master"]),
        ends(&["diagnosis-ends-exchange"]),
    ]);
    trials.extend(table![a_bug_in_the_preset_of_the_a3m60_is_detected:
        position(&["position-little-endian"]),
        only_once(&["trigger-works-once"]),
        undone(&["preset-undone-by-the-falling-edge"]),
        value(&["preset-with-bit-31"]),
        ready(&["ready-before-parameters"]),
        master(&["own-address-as-master"]),
    ]);
    trials.extend(table![a_bug_of_the_plain_slave_is_detected:
        bytes(&["output-bytes-exchanged"]),
        length(&["inputs-of-the-first-configuration"]),
        fault(&["cfg-fault-always-set"]),
        ident(&["ident-swapped-in-exchange"]),
    ]);
    trials
}

/// The line of profirust: the controlling end of a pseudoterminal.
struct ProfirustPhyLine {
    control: File,
    incoming: Receiver<Vec<u8>>,
    received: Vec<u8>,
    busy_until: i64,
    /// Whether the last request was to an absent station.
    is_to_absent_station: bool,
    /// Number of telegrams sent.
    sent: usize,
}

/// The result of an exchange with a slave, or why it failed.
type ExchangeResult<T> = Result<T, String>;

impl ProfirustPhyLine {
    fn new(control: File) -> ProfirustPhyLine {
        let mut other = control.try_clone().expect("a copy");
        let (sender, incoming) = channel();
        thread::spawn(move || {
            let mut octets = [0; 512];
            while let Ok(count @ 1..) = other.read(&mut octets) {
                if sender.send(octets[..count].to_vec()).is_err() {
                    break;
                }
            }
        });
        ProfirustPhyLine {
            control,
            incoming,
            received: Vec::new(),
            busy_until: 0,
            is_to_absent_station: false,
            sent: 0,
        }
    }

    /// Waits for bytes, for [`POLL`] at most.
    fn wait(&mut self) {
        self.received.extend(self.incoming.recv_timeout(POLL).into_iter().flatten());
    }
}

impl ProfibusPhy for ProfirustPhyLine {
    fn poll_transmission(&mut self, now: profirust::time::Instant) -> bool {
        now.total_micros() < self.busy_until
    }

    fn transmit_data<F, R>(&mut self, now: profirust::time::Instant, f: F) -> R
    where
        F: FnOnce(&mut [u8]) -> (usize, R),
    {
        let mut buffer = [0; 256];
        let (count, result) = f(&mut buffer);
        if count > 0 {
            self.control.write_all(&buffer[..count]).expect("the line is open");
            self.sent += 1;
            // FDL_Status request: SD1, DA, SA, FC.
            self.is_to_absent_station = matches!(buffer[..count], [0x10, to, MASTER, 0x49, ..] if to != SLAVE);
            let lasts = BAUD.nanoseconds(BitTimes::of_octets(count)).div_ceil(1_000);
            self.busy_until = now.total_micros() + i64::try_from(lasts).expect("a short frame");
        }
        result
    }

    fn receive_data<F, R>(&mut self, _now: profirust::time::Instant, f: F) -> R
    where
        F: FnOnce(&[u8]) -> (usize, R),
    {
        self.received.extend(self.incoming.try_iter().flatten());
        let (count, result) = f(&self.received);
        self.received.drain(..count);
        result
    }
}

/// profirust as DP master of one slave.
struct ProfirustMaster {
    begin: Instant,
    /// How far its clock is ahead of real time since `begin`.
    ahead: Duration,
    station: FdlActiveStation,
    master: DpMaster<'static>,
    slave: PeripheralHandle,
    line: ProfirustPhyLine,
}

impl ProfirustMaster {
    /// Starts the slave of a manual with its shaft at `shaft`, and a master for it. The slave runs until the line is closed.
    fn new(
        (manual, variant): (&'static str, &'static str),
        bugs: &'static [&'static str],
        shaft: u64,
        options: PeripheralOptions<'static>,
    ) -> ProfirustMaster {
        let (control, path) = pty::open().expect("there are pseudoterminals");
        let serial = Serial::open(&path, &SerialSettings::new(BAUD.0)).expect("the controlling end is open");
        thread::spawn(move || {
            let mut bus = SerialBus::new(serial, Box::<FdlFrames>::default());
            let line = StationLine { address: SLAVE, baud: BAUD };
            let setup = Setup { bugs, shaft, line, ..Setup::default() };
            let built = build(manual, variant, &setup);
            let mut device = built.map_err(|error| error.to_string()).expect("it is known");
            while bus.step(&mut [&mut *device], Time::MAX, &mut |_| true, &mut |_| ()).is_ok() {}
        });
        let mut master = DpMaster::new(vec![]);
        let slave = master.add(Peripheral::new(SLAVE, options, vec![0; 4], vec![0; 4]).with_diag_buffer(vec![0; 57]));
        let parameters = ParametersBuilder::new(MASTER, profirust::Baudrate::B19200)
            .slot_bits(SLOT_BITS)
            .highest_station_address(5)
            .max_retry_limit(3)
            .build_verified(&master);
        let mut station = FdlActiveStation::new(parameters);
        station.set_online();
        master.enter_operate();
        let line = ProfirustPhyLine::new(control);
        let mut profirust =
            ProfirustMaster { begin: Instant::now(), ahead: Duration::ZERO, station, master, slave, line };
        profirust.poll();
        profirust.ahead = SILENCE;
        profirust
    }

    fn poll(&mut self) {
        let micros = i64::try_from((self.begin.elapsed() + self.ahead).as_micros()).expect("a short run");
        self.station.poll(profirust::time::Instant::from_micros(micros), &mut self.line, &mut self.master);
    }

    /// Runs the master until it reports the event `expected` of the slave.
    fn work(&mut self, expected: PeripheralEvent) -> ExchangeResult<()> {
        let give_up = Instant::now() + TIMEOUT;
        let mut observed = Vec::new();
        let enough = self.line.sent + TELEGRAMS;
        while self.line.sent < enough && Instant::now() < give_up {
            self.poll();
            if let Some((_, event)) = self.master.take_last_events().peripheral {
                if event == expected {
                    return Ok(());
                }
                if matches!(event, PeripheralEvent::ConfigError | PeripheralEvent::ParameterError) {
                    return Err(format!("expected {expected:?}, observed {event:?}"));
                }
                observed.push(event);
            }
            if std::mem::take(&mut self.line.is_to_absent_station) {
                self.ahead += NO_ANSWER;
            } else {
                self.line.wait();
            }
        }
        Err(format!("expected {expected:?}, observed {observed:?}"))
    }

    /// One data exchange: sends these outputs and returns the inputs.
    fn cycle(&mut self, outputs: u32) -> ExchangeResult<u32> {
        self.master.get_mut(self.slave).pi_q_mut().copy_from_slice(&outputs.to_be_bytes());
        self.work(PeripheralEvent::DataExchanged)?;
        let inputs = self.master.get_mut(self.slave).pi_i();
        inputs.try_into().map(u32::from_be_bytes).map_err(|_| format!("{inputs:02X?} are not four bytes"))
    }

    /// The inputs of consecutive data exchanges with these outputs.
    fn cycles(&mut self, outputs: &[u32]) -> ExchangeResult<Vec<u32>> {
        outputs.iter().map(|outputs| self.cycle(*outputs)).collect()
    }

    /// Flags, ident number and master address of the last diagnosis.
    fn diagnosis(&mut self) -> ExchangeResult<DiagnosisSummary> {
        let last = self.master.get_mut(self.slave).last_diagnostics().ok_or("no diagnosis was read")?;
        Ok((last.flags, last.ident_number, last.master_address))
    }

    /// Starts up the slave. Returns the diagnosis before and after.
    fn start_up(&mut self) -> ExchangeResult<[DiagnosisSummary; 2]> {
        self.work(PeripheralEvent::Online)?;
        let before = self.diagnosis()?;
        self.work(PeripheralEvent::Configured)?;
        Ok([before, self.diagnosis()?])
    }
}

/// Flags, ident number and master address of a diagnosis.
type DiagnosisSummary = (DiagnosticFlags, u16, Option<u8>);

/// The expected diagnosis of a slave with this ident number before and after its start-up.
fn started(ident: u16) -> [DiagnosisSummary; 2] {
    let waiting = DiagnosticFlags::STATION_NOT_READY | DiagnosticFlags::PARAMETER_REQUIRED;
    [(waiting, ident, None), (DiagnosticFlags::empty(), ident, Some(MASTER))]
}

/// The AMT58 in class 2 as in its GSD.
fn amt58(bugs: &'static [&'static str], user_parameters: &'static [u8], config: &'static [u8]) -> ProfirustMaster {
    let options = PeripheralOptions {
        ident_number: 0x1655,
        max_tsdr: 100,
        user_parameters: Some(user_parameters),
        config: Some(config),
        ..Default::default()
    };
    ProfirustMaster::new(("datalogic-amt58-profibus", "hm5816-16384"), bugs, 0x5_5000, options)
}

/// 65536 steps in each of 16384 turns.
const WHOLE: &[u8] = &[0, 0, 0, 0x0A, 0, 1, 0, 0, 0x40, 0, 0, 0, 0, 0];
const CLASS_2: &[u8] = &[0xD1, 0xE1];

/// A preset of the AMT58: the start-up, the position in each cycle, and the diagnosis afterwards.
fn preset_of_the_amt58(
    bugs: &'static [&'static str],
) -> ExchangeResult<([DiagnosisSummary; 2], Vec<u32>, DiagnosisSummary)> {
    let mut master = amt58(bugs, WHOLE, CLASS_2);
    let started = master.start_up()?;
    // Two cycles are too few; then the table in section 6.6 of the manual.
    let positions =
        master.cycles(&[0, 0, 0, 0x8000_1000, 0x8000_1000, 0, 0, 0x8000_1000, 0x8000_1000, 0x8000_1000, 0, 0, 0])?;
    master.master.get_mut(master.slave).request_diagnostics();
    master.work(PeripheralEvent::Diagnostics)?;
    let diagnosis = master.diagnosis()?;
    master.cycle(0)?;
    Ok((started, positions, diagnosis))
}

fn expected_preset_of_the_amt58() -> ([DiagnosisSummary; 2], Vec<u32>, DiagnosisSummary) {
    let (before, after) = (0x5_5000, 0x1000);
    let mut positions = vec![before; 9];
    positions.extend([after; 4]);
    (started(0x1655), positions, started(0x1655)[1])
}

fn the_amt58_takes_a_preset_of_three_cycles() {
    assert_eq!(preset_of_the_amt58(&[]), Ok(expected_preset_of_the_amt58()));
}

/// 2048 steps in each of 1024 turns, with the shaft at 5.3125 turns.
fn scaling_of_the_amt58(bugs: &'static [&'static str]) -> ExchangeResult<([DiagnosisSummary; 2], Vec<u32>)> {
    let mut master = amt58(bugs, &[0, 0, 0, 0x0A, 0, 0, 8, 0, 0, 0x20, 0, 0, 0, 0], CLASS_2);
    Ok((master.start_up()?, master.cycles(&[0; 3])?))
}

fn the_amt58_scales_2048_steps_in_each_of_1024_turns() {
    assert_eq!(scaling_of_the_amt58(&[]), Ok((started(0x1655), vec![10_880; 3])));
}

/// Whether the AMT58 reports a wrong configuration as a configuration fault and as no other fault.
fn is_wrong_configuration_refused(bugs: &'static [&'static str]) -> ExchangeResult<bool> {
    let mut master = amt58(bugs, WHOLE, &[0xD1, 0xE0]);
    master.work(PeripheralEvent::ConfigError)?;
    let (flags, ..) = master.diagnosis()?;
    Ok(flags.contains(DiagnosticFlags::CONFIGURATION_FAULT) && !flags.contains(DiagnosticFlags::PARAMETER_FAULT))
}

fn the_amt58_refuses_a_wrong_configuration() {
    assert_eq!(is_wrong_configuration_refused(&[]), Ok(true));
}

/// A preset of the A3M60 in telegram IO 04: the start-up, and the position in each cycle except those in which bit 31 rises.
fn preset_of_the_a3m60(bugs: &'static [&'static str]) -> ExchangeResult<([DiagnosisSummary; 2], Vec<u32>)> {
    let options = PeripheralOptions {
        ident_number: 0x0C0A,
        max_tsdr: 100,
        user_parameters: Some(&[
            0x80, 0, 0, 2, 0x0C, 0, 0, 0x40, 0, 0x80, 0, 0, 0, 1, 3, 0, 0, 0x10, 0, 0, 0, 0, 1, 8, 0, 0, 0,
        ]),
        config: Some(&[0xF1]),
        ..Default::default()
    };
    let mut master = ProfirustMaster::new(("sick-a3m60-profibus", "a3m60"), bugs, 0xAA, options);
    let started = master.start_up()?;
    // Table 8 of the manual.
    let mut positions = master.cycles(&[0xFFFF; 3])?;
    master.cycle(0x8000_FFFF)?;
    positions.extend(master.cycles(&[0xFFFF; 3])?);
    // Figures 9 to 11.
    positions.extend(master.cycles(&[0x10; 2])?);
    master.cycle(0x8000_0010)?;
    positions.extend(master.cycles(&[0x8000_0010; 3])?);
    Ok((started, positions))
}

fn expected_preset_of_the_a3m60() -> ([DiagnosisSummary; 2], Vec<u32>) {
    let mut positions = vec![0xAA; 3];
    positions.extend([0xFFFF; 5]);
    positions.extend([0x10; 3]);
    (started(0x0C0A), positions)
}

fn the_a3m60_takes_a_preset_at_an_edge_of_bit_31() {
    assert_eq!(preset_of_the_a3m60(&[]), Ok(expected_preset_of_the_a3m60()));
}

/// profirust observes other values with these bugs, so that the tests above can fail.
fn a_bug_in_the_preset_of_the_amt58_is_detected(bugs: &'static [&'static str]) {
    assert_ne!(run_without_stall(TOLERATED_STALL, || preset_of_the_amt58(bugs)), Ok(expected_preset_of_the_amt58()));
}

fn a_scaling_in_the_wrong_byte_order_is_detected() {
    let expected = Ok((started(0x1655), vec![10_880; 3]));
    let observed = run_without_stall(TOLERATED_STALL, || scaling_of_the_amt58(&["units-and-range-little-endian"]));
    assert_ne!(observed, expected);
}

fn an_unchecked_configuration_is_detected() {
    let observed =
        run_without_stall(TOLERATED_STALL, || is_wrong_configuration_refused(&["only-first-identifier-checked"]));
    assert_ne!(observed, Ok(true));
}

fn a_bug_in_the_preset_of_the_a3m60_is_detected(bugs: &'static [&'static str]) {
    assert_ne!(run_without_stall(TOLERATED_STALL, || preset_of_the_a3m60(bugs)), Ok(expected_preset_of_the_a3m60()));
}

/// The plain slave with its mirror alone: the start-up, and the inputs of each cycle.
fn mirror_of_the_plain_slave(bugs: &'static [&'static str]) -> ExchangeResult<([DiagnosisSummary; 2], Vec<u32>)> {
    let options = PeripheralOptions {
        ident_number: 0xFEED,
        max_tsdr: 100,
        user_parameters: Some(&[0, 0, 0, 1]),
        config: Some(&[0xB3]),
        ..Default::default()
    };
    let mut master = ProfirustMaster::new(("dp-slave", "plain"), bugs, 0, options);
    Ok((master.start_up()?, master.cycles(&MIRRORED)?))
}

const MIRRORED: [u32; 3] = [0x0102_0304, 0xFFFF_FFFF, 0];

fn the_plain_slave_sends_back_what_it_gets() {
    assert_eq!(mirror_of_the_plain_slave(&[]), Ok((started(0xFEED), MIRRORED.to_vec())));
}

fn a_bug_of_the_plain_slave_is_detected(bugs: &'static [&'static str]) {
    let observed = run_without_stall(TOLERATED_STALL, || mirror_of_the_plain_slave(bugs));
    assert_ne!(observed, Ok((started(0xFEED), MIRRORED.to_vec())));
}
