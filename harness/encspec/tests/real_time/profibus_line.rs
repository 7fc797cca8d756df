//! The PROFIBUS master at one end of a serial line and a reference device at the other, over two pseudoterminals.
//!
//! The slot time is much longer than on a real bus: a pseudoterminal has no bit times, and a loaded host is slow.

use crate::tests;
use std::io::{Read, Write};
use std::thread;

use controllers::profibus_dp::{
    ConnectionState, MasterOutcome, MasterRequest, MasterSettings, ProfibusMaster, SlaveConfig,
};
use deviations::{Line, Setup, build};
use encspec::live::fdl::FdlFrames;
use libtest_mimic::Trial;
use link::serial::pty;
use link::{BusTransmission, Serial, SerialBus, SerialSettings, WireStep};
use station::{Duration, Time};
use wire::profibus::fdl::{BaudRate, BitTimes};

const BAUD: BaudRate = BaudRate(1_500_000);
/// Slot time: 200 ms at 1.5 Mbit/s.
const SLOT: BitTimes = BitTimes(300_000);
/// How long the line must be quiet before the master starts.
const QUIET: Duration = Duration::from_millis(50);
/// A master claims the token after 10 slot times, 2 s here.
const TOKEN_CLAIM: Duration = Duration::from_secs(4);
const CYCLE: Duration = Duration::from_millis(5);
/// How long the master tries to start up the slave.
const START_UP: Duration = Duration::from_secs(10);
/// How long the start-up may take on a loaded host.
const TIMEOUT: Duration = Duration::from_secs(30);
/// How long data are exchanged.
const EXCHANGE: Duration = Duration::from_millis(500);
/// AMT58 HM, class 2, 65536 steps in each of 16384 revolutions; no watchdog.
const SET_PRM: [u8; 21] = [0x80, 1, 1, 0x0B, 0x16, 0x55, 0, 0, 0, 0, 0x0A, 0, 1, 0, 0, 0x40, 0, 0, 0, 0, 0];

pub fn trials() -> Vec<Trial> {
    tests![data_are_exchanged_over_a_serial_line, a_bus_with_a_master_on_it_is_refused]
}

/// The two ends of a line: bytes written to one are read from the other.
fn line() -> (SerialBus, SerialBus) {
    let bus = |path: &std::path::Path| {
        let serial = Serial::open(path, &SerialSettings::new(BAUD.0)).expect("the other end is open");
        SerialBus::new(serial, Box::<FdlFrames>::default())
    };
    let (left, left_path) = pty::open().expect("there are pseudoterminals");
    let (right, right_path) = pty::open().expect("there are pseudoterminals");
    let ends = (bus(&left_path), bus(&right_path));
    let copies = (left.try_clone().expect("a copy"), right.try_clone().expect("a copy"));
    for (mut from, mut to) in [(left, copies.1), (right, copies.0)] {
        thread::spawn(move || {
            let mut octets = [0; 512];
            while let Ok(count @ 1..) = from.read(&mut octets) {
                if to.write_all(&octets[..count]).is_err() {
                    break;
                }
            }
        });
    }
    ends
}

/// Serves a reference device at `bus` until the line is closed.
fn serve(mut bus: SerialBus) {
    thread::spawn(move || {
        let setup = Setup { shaft: 0x1388, line: Line { address: 3, baud: BAUD }, ..Setup::default() };
        let built = build("datalogic-amt58-profibus", "hm5816-16384", &setup);
        let mut device = built.map_err(|error| error.to_string()).expect("it is known");
        while bus.step(&mut [&mut *device], Time::MAX, &mut |_| true, &mut |_| ()).is_ok() {}
    });
}

fn master() -> ProfibusMaster {
    ProfibusMaster::new(MasterSettings {
        slot_time: SLOT,
        token_pause: BitTimes(30_000),
        ..MasterSettings::new(2, BAUD)
    })
}

fn data_are_exchanged_over_a_serial_line() {
    let (mut bus, other) = line();
    serve(other);
    bus.refuse_traffic(QUIET).expect("a slave sends nothing on its own");
    let mut master = master();
    let mut connection = SlaveConfig::new(3, SET_PRM.to_vec(), vec![0xD1, 0xE1], (4, 4));
    connection.cycle = CYCLE;
    connection.patience = START_UP;
    master.request(bus.now(), MasterRequest::Connect(Box::new(connection))).expect("an idle master");
    let mut damaged = 0;
    let mut tap = |heard: BusTransmission<'_>| damaged += usize::from(!heard.is_frame);
    let give_up = bus.now() + TIMEOUT;
    let outcome = loop {
        if let Some(outcome) = master.take_outcome() {
            break outcome;
        }
        assert!(bus.now() < give_up, "no outcome");
        bus.step(&mut [&mut master], give_up, &mut |_| true, &mut tap).expect("the line works");
    };
    let MasterOutcome::StartUp(start) = outcome else { panic!("{outcome:?}") };
    assert!(start.standing, "{start:?}");
    let until = bus.now() + EXCHANGE;
    while bus.step(&mut [&mut master], until, &mut |_| true, &mut tap).expect("the line works") == WireStep::Worked {}
    assert_eq!(master.state(), ConnectionState::Exchange);
    assert!(master.cycles_done() > 5, "{} cycles", master.cycles_done());
    assert_eq!((master.inputs(), damaged), (&[0x00, 0x00, 0x13, 0x88][..], 0));
}

fn a_bus_with_a_master_on_it_is_refused() {
    let (mut bus, mut other) = line();
    thread::spawn(move || {
        let mut master = master();
        while other.step(&mut [&mut master], Time::MAX, &mut |_| true, &mut |_| ()).is_ok() {}
    });
    let error = bus.refuse_traffic(TOKEN_CLAIM).expect_err("there is a master");
    assert!(error.to_string().contains(": DC 02 02;"), "{error}");
}
