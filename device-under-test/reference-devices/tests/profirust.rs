//! The AMT58 with an independent master: profirust parameterises it, exchanges data and makes a preset.
#![allow(clippy::unwrap_used, reason = "a test that cannot go on fails")]

use encoder_profile::encoder_object::EncoderSpecimen;
use profirust::dp::{DpMaster, Peripheral, PeripheralOptions};
use profirust::fdl::{FdlActiveStation, ParametersBuilder};
use profirust::phy::ProfibusPhy;
use profirust::time::Instant;
use reference_devices::deviations::DeviceDeviations;
use reference_devices::manuals::DATALOGIC_AMT58;
use reference_devices::{Line, ReferenceDevice};
use station::{Duration, Outbox, Time};
use wire::profibus::fdl::{BaudRate, BitTimes};

const BAUD: BaudRate = BaudRate(500_000);
const ENCODER: u8 = 5;

/// The master's end of a wire; the encoder is at the other end.
struct MasterPhy {
    encoder: Box<dyn ReferenceDevice>,
    sent: Option<(Time, Vec<u8>)>,
    coming: Option<(Time, Vec<u8>)>,
    arrived: Vec<u8>,
}

fn time(now: Instant) -> Time {
    Time::from_nanos(now.total_micros().unsigned_abs() * 1_000)
}

fn end(begin: Time, octets: usize) -> Time {
    begin + Duration::from_nanos(BAUD.nanoseconds(BitTimes::of_octets(octets)))
}

impl MasterPhy {
    fn settle(&mut self, now: Time) {
        let mut out = Outbox::new();
        if let Some((at, frame)) = self.sent.take_if(|(at, _)| *at <= now) {
            self.encoder.receive(at, &frame, &mut out);
        }
        while let Some(due) = self.encoder.deadline().filter(|due| *due <= now) {
            self.encoder.wake(due, &mut out);
            if let Some(frame) = out.frames().next() {
                self.coming = Some((end(due, frame.len()), frame.to_vec()));
            }
            out.clear();
        }
        if let Some((_, frame)) = self.coming.take_if(|(at, _)| *at <= now) {
            self.arrived.extend(frame);
        }
    }
}

impl ProfibusPhy for MasterPhy {
    fn poll_transmission(&mut self, now: Instant) -> bool {
        self.settle(time(now));
        self.sent.is_some()
    }

    fn transmit_data<F, R>(&mut self, now: Instant, f: F) -> R
    where
        F: FnOnce(&mut [u8]) -> (usize, R),
    {
        let mut buffer = [0; 256];
        let (length, result) = f(&mut buffer);
        if length > 0 {
            self.sent = Some((end(time(now), length), buffer[..length].to_vec()));
        }
        result
    }

    fn receive_data<F, R>(&mut self, now: Instant, f: F) -> R
    where
        F: FnOnce(&[u8]) -> (usize, R),
    {
        self.settle(time(now));
        let (taken, result) = f(&self.arrived);
        self.arrived.drain(..taken);
        result
    }
}

#[test]
fn profirust_reads_positions_and_makes_a_preset() {
    let piece = EncoderSpecimen { mac: [2, 0, 0, 0, 1, 0], shaft: 0x55000, ..EncoderSpecimen::default() };
    let line = Line { address: ENCODER, baud: BAUD };
    let none = DeviceDeviations::default();
    let encoder = DATALOGIC_AMT58.build("hm5816-16384", &none, piece, line).unwrap();
    let mut wire = MasterPhy { encoder, sent: None, coming: None, arrived: Vec::new() };

    let user = [0, 0, 0, 0x0A, 0, 1, 0, 0, 0x40, 0, 0, 0, 0, 0];
    let options = PeripheralOptions {
        ident_number: 0x1655,
        user_parameters: Some(&user),
        config: Some(&[0xD1, 0xE1]),
        max_tsdr: 100,
        ..PeripheralOptions::default()
    };
    let (mut inputs, mut outputs, mut diagnosis) = ([0; 4], [0; 4], [0; 57]);
    let mut master = DpMaster::new(Vec::new());
    let peripheral = Peripheral::new(ENCODER, options, &mut inputs[..], &mut outputs[..]);
    let handle = master.add(peripheral.with_diag_buffer(&mut diagnosis[..]));
    let parameters = ParametersBuilder::new(2, profirust::Baudrate::B500000)
        .slot_bits(400)
        .highest_station_address(10)
        .watchdog_timeout(profirust::time::Duration::from_secs(1))
        .build_verified(&master);
    let mut station = FdlActiveStation::new(parameters);
    station.set_online();
    master.enter_operate();

    let (mut cycles, mut positions) = (0, Vec::new());
    for micros in (0..5_000_000).step_by(20) {
        station.poll(Instant::from_micros(micros), &mut wire, &mut master);
        let is_complete = master.take_last_events().cycle_completed;
        let encoder = master.get_mut(handle);
        if !encoder.is_running() || !is_complete {
            continue;
        }
        cycles += 1;
        positions.push(u32::from_be_bytes(encoder.pi_i().try_into().unwrap()));
        if cycles == 10 {
            encoder.pi_q_mut().copy_from_slice(&[0x80, 0, 0x10, 0]);
        }
        if cycles == 30 {
            break;
        }
    }
    positions.dedup();
    assert_eq!(positions, [0x55000, 0x1000]);
    let diagnostics = master.get_mut(handle).last_diagnostics().unwrap();
    assert_eq!((diagnostics.ident_number, diagnostics.master_address), (0x1655, Some(2)));
}
