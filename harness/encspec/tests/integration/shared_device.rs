//! All trials in sequence on the same device, as on a live bench: a trial must not leave a state that makes a later one fail.

use crate::built_in;
use controllers::profibus_dp::MasterSettings;
use deviations::{Line, Setup};
use encspec::engine::segment::{DeviceOnStand, ModelOnStand, Segment, VirtualSegment};
use encspec::engine::{DpLine, DutKind, DutSpec, RunOptions, dp_line, dut, run_trial_on};
use encspec::suite::device::Bus;
use encspec::suite::model::{Manual, SuiteVariant, Trial};
use encspec::verdict::Verdict;
use station::{Duration, Outbox, Stand, StandAction, StandRefusal, Station, Time};
use std::thread;

/// A device whose time continues from trial to trial.
struct ContinuingDevice<'a> {
    device: ModelOnStand<'a>,
    /// The device's clock at the start of the trial.
    began: Time,
    /// The last reading of the trial's clock.
    last: Time,
}

impl ContinuingDevice<'_> {
    fn time(&mut self, now: Time) -> Time {
        self.last = self.last.max(now);
        self.began + now.since(Time::ZERO)
    }
}

impl Station for ContinuingDevice<'_> {
    fn receive(&mut self, now: Time, frame: &[u8], out: &mut Outbox) {
        let now = self.time(now);
        self.device.receive(now, frame, out);
    }

    fn wake(&mut self, now: Time, out: &mut Outbox) {
        let now = self.time(now);
        self.device.wake(now, out);
    }

    fn deadline(&self) -> Option<Time> {
        let due = self.device.deadline()?;
        Some(Time::ZERO + due.since(self.began))
    }
}

impl Stand for ContinuingDevice<'_> {
    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Result<Time, StandRefusal> {
        let now = self.time(now);
        let done = self.device.act(now, action)?;
        Ok(Time::ZERO + done.since(self.began))
    }

    fn led(&mut self, now: Time, name: &str) -> Option<&'static str> {
        let now = self.time(now);
        self.device.led(now, name)
    }

    fn counter(&mut self, now: Time, name: &str) -> Option<u64> {
        let now = self.time(now);
        self.device.counter(now, name)
    }
}

struct BorrowedDevice<'a, 'b>(&'a mut ContinuingDevice<'b>);

impl DeviceOnStand for BorrowedDevice<'_, '_> {
    fn station(&mut self) -> &mut dyn Station {
        &mut *self.0
    }

    fn stand(&mut self) -> &mut dyn Stand {
        &mut *self.0
    }
}

/// A new device that is used for several trials.
fn continuing_device<'a>(setup: &'a Setup<'a>, spec: &'a DutSpec) -> ContinuingDevice<'a> {
    let known = deviations::subject(&spec.manual).expect("a reference device for every suite");
    let built = known.build(&spec.variant, setup).map_err(|error| error.to_string());
    let fresh = move || known.build_in_factory_state(&spec.variant, setup).map_err(|error| error.to_string());
    let device = ModelOnStand::new(built.expect("it can be built"), Box::new(fresh));
    ContinuingDevice { device, began: Time::ZERO, last: Time::ZERO }
}

/// The segment of a trial with this device.
fn segment<'a>(kept: &'a mut ContinuingDevice<'_>, bus: Bus, line: DpLine) -> Box<dyn Segment + 'a> {
    let device = Box::new(BorrowedDevice(kept));
    Box::new(match bus {
        Bus::Profinet => VirtualSegment::new(device),
        Bus::Profibus => {
            let usual = MasterSettings::new(0, line.baud);
            VirtualSegment::bus(device, line.baud, usual.slot_time, Some(usual.max_tsdr))
        }
    })
}

/// Runs the selected trials of a variant on one device with these bugs. Returns those that did not pass.
///
/// On PROFIBUS each bit rate has its own device, since a reference device does not detect the rate.
fn failures_on_one_device(
    manual: &Manual,
    variant: &SuiteVariant,
    bugs: &[&str],
    is_run: impl Fn(&Trial) -> bool,
) -> Vec<String> {
    let spec = DutSpec {
        manual: manual.device.name.clone(),
        variant: variant.name.clone(),
        kind: DutKind::Model { deviations: Vec::new() },
    };
    let known = deviations::subject(&spec.manual).expect("a reference device for every suite");
    let lines: Vec<DpLine> = variant.trials.iter().map(|trial| dp_line(&spec, manual, Some(trial))).collect();
    let mut rates = lines.clone();
    rates.sort_by_key(|line| line.baud.0);
    rates.dedup();
    let mut broken = Vec::new();
    for rate in rates {
        let setup = Setup {
            mac: known.manual.mac(dut::DEVICE.0.0),
            bugs,
            shaft: 0x1234,
            station_name: dut::STATION_NAME,
            line: Line { address: rate.station, baud: rate.baud },
            ..Setup::default()
        };
        let mut kept = continuing_device(&setup, &spec);
        let trials = variant.trials.iter().zip(&lines).filter(|(trial, line)| **line == rate && is_run(trial));
        for (trial, _) in trials {
            let segment = segment(&mut kept, manual.device.bus.kind(), rate);
            let outcome = run_trial_on(segment, manual, variant, &spec, trial, &RunOptions::default());
            let case = outcome.case;
            if case.verdict != Verdict::Pass {
                broken.push(format!("{} {}: {:?} {:?}", variant.name, case.id, case.verdict, case.reason));
            }
            kept.began += kept.last.since(Time::ZERO) + Duration::from_secs(1);
            kept.last = Time::ZERO;
        }
    }
    broken
}

#[test]
fn trials_do_not_affect_each_other() {
    let manuals = built_in::manuals();
    let variants = manuals.iter().flat_map(|manual| manual.variants.iter().map(move |variant| (manual, variant)));
    let broken: Vec<String> = thread::scope(|scope| {
        let devices: Vec<_> = variants
            .map(|(manual, variant)| scope.spawn(|| failures_on_one_device(manual, variant, &[], |_| true)))
            .collect();
        devices.into_iter().flat_map(|device| device.join().expect("no panic")).collect()
    });
    assert!(broken.is_empty(), "{}\n{} trials", broken.join("\n"), broken.len());
}

/// A slave that wrongly accepts an address over the bus fails that trial only: its original address is restored for the others.
#[test]
fn the_address_of_a_slave_is_restored() {
    let manuals = built_in::manuals();
    let manual = manuals.iter().find(|manual| manual.device.name == "sick-a3m60-profibus").expect("it is shipped");
    let trials = ["addresses/not-over-the-bus", "defaults/as-delivered", "position/", "slave-start-up/"];
    let is_run = |trial: &Trial| trials.iter().any(|begin| trial.id.starts_with(begin));
    let broken = failures_on_one_device(manual, &manual.variants[0], &["address-taken-over-the-bus"], is_run);
    let [failed] = broken.as_slice() else { panic!("{broken:#?}") };
    assert!(failed.contains("addresses/not-over-the-bus: Fail"), "{failed}");
}
