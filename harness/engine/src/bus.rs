//! The bus of a device: its driver, and a trial on it.

use super::environment::TrialEnvironment;
use super::profibus::ProfibusDriver;
use super::profinet::ProfinetDriver;
use super::segment::Segment;
use super::trial::RunningTrial;
use super::trial::driver::BusDriver;
use super::world::TrialWorld;
use suite::device::{Bus, DeviceDescription};
use suite::model::{Manual, SuiteVariant, Trial};

/// The driver for a device.
fn driver(device: &DeviceDescription) -> &'static dyn BusDriver {
    match device.bus.kind() {
        Bus::Profinet => &ProfinetDriver,
        Bus::Profibus => &ProfibusDriver,
    }
}

/// A trial on `segment` that has not begun, with new stations of the harness.
pub fn trial<'a>(
    manual: &'a Manual,
    variant: &'a SuiteVariant,
    segment: Box<dyn Segment + 'a>,
    trial: &'a Trial,
    environment: &'a TrialEnvironment,
) -> RunningTrial<'a> {
    let driver = driver(&manual.device);
    let stations = driver.stations(manual, environment, trial);
    RunningTrial::new(driver, TrialWorld::new(manual, variant, segment, stations), trial, environment)
}
