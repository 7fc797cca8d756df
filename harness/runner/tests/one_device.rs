//! Every trial after the other on one and the same device, as on a live bench: what a trial leaves behind must not make a
//! later one fail.

use encspec::engine::segment::{DeviceOnStand, Model, VirtualSegment};
use encspec::engine::{DutKind, DutSpec, RunOptions, dut, run_trial_on};
use encspec::suite::device::Bus;
use encspec::suite::model::{Manual, Variant};
use encspec::suite::{Sources, load};
use encspec::verdict::Verdict;
use reference_devices::{Line, Setup, build, build_delivered};
use station::{Duration, Outbox, Refusal, Stand, StandAction, Station, Time};
use std::thread;

/// A device for which time goes on from trial to trial.
struct Kept<'a> {
    device: Model<'a>,
    /// What the device's clock showed when the trial began.
    began: Time,
    /// What the trial's clock showed last.
    last: Time,
}

impl Kept<'_> {
    fn time(&mut self, now: Time) -> Time {
        self.last = self.last.max(now);
        self.began + now.since(Time::ZERO)
    }
}

impl Station for Kept<'_> {
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

impl Stand for Kept<'_> {
    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Result<Time, Refusal> {
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

struct Lent<'a, 'b>(&'a mut Kept<'b>);

impl DeviceOnStand for Lent<'_, '_> {
    fn station(&mut self) -> &mut dyn Station {
        &mut *self.0
    }

    fn stand(&mut self) -> &mut dyn Stand {
        &mut *self.0
    }
}

/// Runs every trial of a variant on one device and gives those that did not pass.
fn in_each_others_way(manual: &Manual, variant: &Variant) -> Vec<String> {
    let spec = DutSpec {
        manual: manual.device.name.clone(),
        variant: variant.name.clone(),
        kind: DutKind::Model { bugs: Vec::new() },
    };
    let known = reference_devices::manual(&spec.manual).expect("a reference device for every suite");
    let setup = Setup {
        mac: known.mac(dut::DEVICE.0.0),
        bugs: &[],
        shaft: 0x1234,
        station_name: dut::STATION_NAME,
        ip: [0; 4],
        mask: [0; 4],
        gateway: [0; 4],
        line: Line::default(),
    };
    let built = build(&spec.manual, &spec.variant, &setup).map_err(|error| error.to_string());
    let fresh = || build_delivered(known, &spec.variant, &setup).map_err(|error| error.to_string());
    let device = Model::new(built.expect("it can be built"), Box::new(fresh));
    let mut kept = Kept { device, began: Time::ZERO, last: Time::ZERO };
    let mut broken = Vec::new();
    for trial in &variant.trials {
        let segment = Box::new(VirtualSegment::new(Box::new(Lent(&mut kept))));
        let outcome = run_trial_on(segment, manual, variant, &spec, trial, &RunOptions::default());
        let case = outcome.case;
        if case.verdict != Verdict::Pass {
            broken.push(format!("{} {}: {:?} {:?}", variant.name, case.id, case.verdict, case.reason));
        }
        kept.began += kept.last.since(Time::ZERO) + Duration::from_secs(1);
        kept.last = Time::ZERO;
    }
    broken
}

#[test]
fn trials_do_not_stand_in_each_others_way() {
    let manuals = load(&Sources::embedded(), None).expect("the shipped suites load");
    // A slave of PROFIBUS may be left at another address, and no bench gives it back so far.
    let manuals = manuals.iter().filter(|manual| manual.device.bus == Bus::Profinet);
    let variants = manuals.flat_map(|manual| manual.variants.iter().map(move |variant| (manual, variant)));
    let broken: Vec<String> = thread::scope(|scope| {
        let devices: Vec<_> =
            variants.map(|(manual, variant)| scope.spawn(move || in_each_others_way(manual, variant))).collect();
        devices.into_iter().flat_map(|device| device.join().expect("no panic")).collect()
    });
    assert!(broken.is_empty(), "{}\n{} trials", broken.join("\n"), broken.len());
}
