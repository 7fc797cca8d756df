//! The bus of a device: its driver, and a trial on it.

use super::place::Place;
use super::profibus::Profibus;
use super::profinet::Profinet;
use super::segment::Segment;
use super::trial::Run;
use super::trial::driver::BusDriver;
use super::world::World;
use suite::device::{Bus, DeviceDescription};
use suite::model::{Manual, SuiteVariant, Trial};

/// The driver for a device.
fn driver(device: &DeviceDescription) -> &'static dyn BusDriver {
    match device.bus.kind() {
        Bus::Profinet => &Profinet,
        Bus::Profibus => &Profibus,
    }
}

/// A trial on `segment` that has not begun, with new stations of the harness.
pub fn trial<'a>(
    manual: &'a Manual,
    variant: &'a SuiteVariant,
    segment: Box<dyn Segment + 'a>,
    trial: &'a Trial,
    environment: &'a Place,
) -> Run<'a> {
    let driver = driver(&manual.device);
    let stations = driver.stations(manual, environment, trial);
    Run::new(driver, World::new(manual, variant, segment, stations), trial, environment)
}
