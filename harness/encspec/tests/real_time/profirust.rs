//! profirust, a master of others, at the slaves of both manuals, over a pseudoterminal.
//!
//! It claims the token, looks for other masters and sends Global_Control, all of which a slave has to bear in silence. What is
//! wanted is what the manuals print, and the same is asked of slaves with a bug, which do not pass. A pseudoterminal has no bit
//! times and a busy machine is slow, so the slot time is far longer than on a real bus. The clock of the stranger goes with the real
//! time, and leaps where it waits for somebody who is not there.

use crate::{table, tests};
use deviations::{Line as Place, Setup, build};
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
use testing::patience::undisturbed;
use wire::profibus::fdl::{BaudRate, BitTimes};

const BAUD: BaudRate = BaudRate(19_200);
/// 3 s.
const SLOT_BITS: u16 = 57_600;
const MASTER: u8 = 2;
const SLAVE: u8 = 3;
/// So long nobody has spoken when the stranger begins, so that it claims the token at once.
const SILENCE: Duration = Duration::from_secs(60);
/// A little more than a slot.
const NO_ANSWER: Duration = Duration::from_secs(4);
/// Within so many of its telegrams what the stranger waits for has to come about.
const TELEGRAMS: usize = 200;
/// How long the stranger waits for octets before it looks at its clock.
const LOOK: Duration = Duration::from_millis(1);
const PATIENCE: Duration = Duration::from_secs(60);
/// A halt of this machine that is no longer changes nothing of what either of them sees.
const BEARABLE: Duration = Duration::from_secs(1);

pub fn trials() -> Vec<Trial> {
    let mut trials = tests![
        the_amt58_takes_a_preset_of_three_cycles,
        the_amt58_scales_2048_steps_in_each_of_1024_turns,
        the_amt58_refuses_a_wrong_configuration,
        the_a3m60_takes_a_preset_at_an_edge_of_bit_31,
        a_scaling_that_is_read_the_wrong_way_round_is_seen,
        a_configuration_that_is_not_looked_at_is_seen,
    ];
    trials.extend(table![a_preset_of_an_amt58_with_a_bug_is_seen:
        position(&["position-little-endian"]),
        one_cycle(&["preset-in-the-first-cycle"]),
        four_cycles(&["preset-in-the-fourth-cycle"]),
        not_in_a_row(&["preset-count-not-reset"]),
        undone(&["preset-undone-with-its-bit"]),
        ready(&["ready-before-parameters"]),
        master(&["own-address-as-master"]),
        ends(&["diagnosis-ends-exchange"]),
    ]);
    trials.extend(table![a_preset_of_an_a3m60_with_a_bug_is_seen:
        position(&["position-little-endian"]),
        only_once(&["trigger-works-once"]),
        undone(&["preset-undone-by-the-falling-edge"]),
        value(&["preset-with-bit-31"]),
        ready(&["ready-before-parameters"]),
        master(&["own-address-as-master"]),
    ]);
    trials
}

/// The line of the stranger: the controlling end of a pseudoterminal.
struct Line {
    control: File,
    heard: Receiver<Vec<u8>>,
    received: Vec<u8>,
    busy_until: i64,
    /// Whether the last request was to a station that is not there.
    is_to_nobody: bool,
    /// How many telegrams it has sent.
    sent: usize,
}

/// What an exchange with a slave came to, or why it came to nothing.
type Seen<T> = Result<T, String>;

impl Line {
    fn new(control: File) -> Line {
        let mut other = control.try_clone().expect("a copy");
        let (told, heard) = channel();
        thread::spawn(move || {
            let mut octets = [0; 512];
            while let Ok(count @ 1..) = other.read(&mut octets) {
                if told.send(octets[..count].to_vec()).is_err() {
                    break;
                }
            }
        });
        Line { control, heard, received: Vec::new(), busy_until: 0, is_to_nobody: false, sent: 0 }
    }

    /// Waits until something comes in, for a moment at most.
    fn wait(&mut self) {
        self.received.extend(self.heard.recv_timeout(LOOK).into_iter().flatten());
    }
}

impl ProfibusPhy for Line {
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
            self.control.write_all(&buffer[..count]).expect("the line is there");
            self.sent += 1;
            // A request for the status: SD1, whom, from whom, FDL_Status with reply.
            self.is_to_nobody = matches!(buffer[..count], [0x10, to, MASTER, 0x49, ..] if to != SLAVE);
            let lasts = BAUD.nanoseconds(BitTimes::of_octets(count)).div_ceil(1_000);
            self.busy_until = now.total_micros() + i64::try_from(lasts).expect("a short frame");
        }
        result
    }

    fn receive_data<F, R>(&mut self, _now: profirust::time::Instant, f: F) -> R
    where
        F: FnOnce(&[u8]) -> (usize, R),
    {
        self.received.extend(self.heard.try_iter().flatten());
        let (count, result) = f(&self.received);
        self.received.drain(..count);
        result
    }
}

/// profirust with one slave at its line.
struct Stranger {
    begin: Instant,
    /// What its clock shows beyond the time since then.
    ahead: Duration,
    station: FdlActiveStation,
    master: DpMaster<'static>,
    slave: PeripheralHandle,
    line: Line,
}

impl Stranger {
    /// A master for the slave of a manual with its shaft at `shaft`, which lives as long as the line.
    fn new(
        (manual, variant): (&'static str, &'static str),
        bugs: &'static [&'static str],
        shaft: u64,
        options: PeripheralOptions<'static>,
    ) -> Stranger {
        let (control, path) = pty::open().expect("there are pseudoterminals");
        let serial = Serial::open(&path, &SerialSettings::new(BAUD.0)).expect("the controlling end is open");
        thread::spawn(move || {
            let mut bus = SerialBus::new(serial, Box::<FdlFrames>::default());
            let line = Place { address: SLAVE, baud: BAUD };
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
        let line = Line::new(control);
        let mut stranger = Stranger { begin: Instant::now(), ahead: Duration::ZERO, station, master, slave, line };
        stranger.poll();
        stranger.ahead = SILENCE;
        stranger
    }

    fn poll(&mut self) {
        let micros = i64::try_from((self.begin.elapsed() + self.ahead).as_micros()).expect("a short run");
        self.station.poll(profirust::time::Instant::from_micros(micros), &mut self.line, &mut self.master);
    }

    /// Lets it work until it tells this event of the slave.
    fn work(&mut self, wanted: PeripheralEvent) -> Seen<()> {
        let give_up = Instant::now() + PATIENCE;
        let mut seen = Vec::new();
        let enough = self.line.sent + TELEGRAMS;
        while self.line.sent < enough && Instant::now() < give_up {
            self.poll();
            if let Some((_, event)) = self.master.take_last_events().peripheral {
                if event == wanted {
                    return Ok(());
                }
                if matches!(event, PeripheralEvent::ConfigError | PeripheralEvent::ParameterError) {
                    return Err(format!("{event:?} and not {wanted:?}"));
                }
                seen.push(event);
            }
            if std::mem::take(&mut self.line.is_to_nobody) {
                self.ahead += NO_ANSWER;
            } else {
                self.line.wait();
            }
        }
        Err(format!("no {wanted:?} after {seen:?}"))
    }

    /// One exchange of data: the inputs that answer these outputs.
    fn cycle(&mut self, outputs: u32) -> Seen<u32> {
        self.master.get_mut(self.slave).pi_q_mut().copy_from_slice(&outputs.to_be_bytes());
        self.work(PeripheralEvent::DataExchanged)?;
        let inputs = self.master.get_mut(self.slave).pi_i();
        inputs.try_into().map(u32::from_be_bytes).map_err(|_| format!("{inputs:02X?} are not four octets"))
    }

    /// The inputs that answer these outputs, one after the other.
    fn cycles(&mut self, outputs: &[u32]) -> Seen<Vec<u32>> {
        outputs.iter().map(|outputs| self.cycle(*outputs)).collect()
    }

    /// Bits, ident number and master of the last diagnosis.
    fn diagnosis(&mut self) -> Seen<Diagnosis> {
        let told = self.master.get_mut(self.slave).last_diagnostics().ok_or("no diagnosis was read")?;
        Ok((told.flags, told.ident_number, told.master_address))
    }

    /// The start-up with the diagnosis before and behind it.
    fn start_up(&mut self) -> Seen<[Diagnosis; 2]> {
        self.work(PeripheralEvent::Online)?;
        let before = self.diagnosis()?;
        self.work(PeripheralEvent::Configured)?;
        Ok([before, self.diagnosis()?])
    }
}

/// Bits, ident number and master of a diagnosis.
type Diagnosis = (DiagnosticFlags, u16, Option<u8>);

/// What a slave with this ident number tells before its start-up and behind it.
fn started(ident: u16) -> [Diagnosis; 2] {
    let wants_parameters = DiagnosticFlags::STATION_NOT_READY | DiagnosticFlags::PARAMETER_REQUIRED;
    [(wants_parameters, ident, None), (DiagnosticFlags::empty(), ident, Some(MASTER))]
}

/// Class 2 of the AMT58 as its GSD has it.
fn amt58(bugs: &'static [&'static str], user_parameters: &'static [u8], config: &'static [u8]) -> Stranger {
    let options = PeripheralOptions {
        ident_number: 0x1655,
        max_tsdr: 100,
        user_parameters: Some(user_parameters),
        config: Some(config),
        ..Default::default()
    };
    Stranger::new(("datalogic-amt58-profibus", "hm5816-16384"), bugs, 0x5_5000, options)
}

/// 65536 steps in each of 16384 turns.
const WHOLE: &[u8] = &[0, 0, 0, 0x0A, 0, 1, 0, 0, 0x40, 0, 0, 0, 0, 0];
const CLASS_2: &[u8] = &[0xD1, 0xE1];

/// A preset of the AMT58: start-up, what its position was cycle by cycle, and its diagnosis behind that.
fn preset_of_the_amt58(bugs: &'static [&'static str]) -> Seen<([Diagnosis; 2], Vec<u32>, Diagnosis)> {
    let mut stranger = amt58(bugs, WHOLE, CLASS_2);
    let started = stranger.start_up()?;
    // Two cycles are too few; then the table in section 6.6 of the manual.
    let positions =
        stranger.cycles(&[0, 0, 0, 0x8000_1000, 0x8000_1000, 0, 0, 0x8000_1000, 0x8000_1000, 0x8000_1000, 0, 0, 0])?;
    stranger.master.get_mut(stranger.slave).request_diagnostics();
    stranger.work(PeripheralEvent::Diagnostics)?;
    let diagnosis = stranger.diagnosis()?;
    stranger.cycle(0)?;
    Ok((started, positions, diagnosis))
}

fn healthy_preset_of_the_amt58() -> ([Diagnosis; 2], Vec<u32>, Diagnosis) {
    let (before, behind) = (0x5_5000, 0x1000);
    let mut positions = vec![before; 9];
    positions.extend([behind; 4]);
    (started(0x1655), positions, started(0x1655)[1])
}

fn the_amt58_takes_a_preset_of_three_cycles() {
    assert_eq!(preset_of_the_amt58(&[]), Ok(healthy_preset_of_the_amt58()));
}

/// 2048 steps in each of 1024 turns, with the shaft at 5.3125 turns.
fn scaling_of_the_amt58(bugs: &'static [&'static str]) -> Seen<([Diagnosis; 2], Vec<u32>)> {
    let mut stranger = amt58(bugs, &[0, 0, 0, 0x0A, 0, 0, 8, 0, 0, 0x20, 0, 0, 0, 0], CLASS_2);
    Ok((stranger.start_up()?, stranger.cycles(&[0; 3])?))
}

fn the_amt58_scales_2048_steps_in_each_of_1024_turns() {
    assert_eq!(scaling_of_the_amt58(&[]), Ok((started(0x1655), vec![10_880; 3])));
}

/// Whether a configuration that the AMT58 does not have is a configuration fault, and no other.
fn is_wrong_configuration_refused(bugs: &'static [&'static str]) -> Seen<bool> {
    let mut stranger = amt58(bugs, WHOLE, &[0xD1, 0xE0]);
    stranger.work(PeripheralEvent::ConfigError)?;
    let (flags, ..) = stranger.diagnosis()?;
    Ok(flags.contains(DiagnosticFlags::CONFIGURATION_FAULT) && !flags.contains(DiagnosticFlags::PARAMETER_FAULT))
}

fn the_amt58_refuses_a_wrong_configuration() {
    assert_eq!(is_wrong_configuration_refused(&[]), Ok(true));
}

/// A preset of the A3M60 in telegram IO 04: start-up, and its position cycle by cycle, without those cycles in which bit 31 rises.
fn preset_of_the_a3m60(bugs: &'static [&'static str]) -> Seen<([Diagnosis; 2], Vec<u32>)> {
    let options = PeripheralOptions {
        ident_number: 0x0C0A,
        max_tsdr: 100,
        user_parameters: Some(&[
            0x80, 0, 0, 2, 0x0C, 0, 0, 0x40, 0, 0x80, 0, 0, 0, 1, 3, 0, 0, 0x10, 0, 0, 0, 0, 1, 8, 0, 0, 0,
        ]),
        config: Some(&[0xF1]),
        ..Default::default()
    };
    let mut stranger = Stranger::new(("sick-a3m60-profibus", "a3m60"), bugs, 0xAA, options);
    let started = stranger.start_up()?;
    // Table 8 of the manual.
    let mut positions = stranger.cycles(&[0xFFFF; 3])?;
    stranger.cycle(0x8000_FFFF)?;
    positions.extend(stranger.cycles(&[0xFFFF; 3])?);
    // Figures 9 to 11.
    positions.extend(stranger.cycles(&[0x10; 2])?);
    stranger.cycle(0x8000_0010)?;
    positions.extend(stranger.cycles(&[0x8000_0010; 3])?);
    Ok((started, positions))
}

fn healthy_preset_of_the_a3m60() -> ([Diagnosis; 2], Vec<u32>) {
    let mut positions = vec![0xAA; 3];
    positions.extend([0xFFFF; 5]);
    positions.extend([0x10; 3]);
    (started(0x0C0A), positions)
}

fn the_a3m60_takes_a_preset_at_an_edge_of_bit_31() {
    assert_eq!(preset_of_the_a3m60(&[]), Ok(healthy_preset_of_the_a3m60()));
}

/// The stranger sees what is wrong with these slaves, so that what it says of a healthy one is no accident.
fn a_preset_of_an_amt58_with_a_bug_is_seen(bugs: &'static [&'static str]) {
    assert_ne!(undisturbed(BEARABLE, || preset_of_the_amt58(bugs)), Ok(healthy_preset_of_the_amt58()));
}

fn a_scaling_that_is_read_the_wrong_way_round_is_seen() {
    let healthy = Ok((started(0x1655), vec![10_880; 3]));
    assert_ne!(undisturbed(BEARABLE, || scaling_of_the_amt58(&["units-and-range-little-endian"])), healthy);
}

fn a_configuration_that_is_not_looked_at_is_seen() {
    let seen = undisturbed(BEARABLE, || is_wrong_configuration_refused(&["only-first-identifier-checked"]));
    assert_ne!(seen, Ok(true));
}

fn a_preset_of_an_a3m60_with_a_bug_is_seen(bugs: &'static [&'static str]) {
    assert_ne!(undisturbed(BEARABLE, || preset_of_the_a3m60(bugs)), Ok(healthy_preset_of_the_a3m60()));
}
