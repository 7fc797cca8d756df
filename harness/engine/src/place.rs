//! Where a device under test is found, and who our stations are there: what a bench says, for either bus.

use controllers::profibus_dp::Pace;
use results::bench_file::BenchFile;
use station::Duration;
use std::net::Ipv4Addr;
use std::sync::Arc;
use suite::persona::Persona;
use wire::ethernet::Mac;
use wire::profibus::fdl::BaudRate;
use wire::profinet::dcp::block::IpParameter;

/// The bench of a trial: who the device is, where it is found, and who our controllers are.
#[derive(Clone, Debug)]
pub struct Place {
    /// The station name that the bench gives the device.
    pub name: String,
    /// The MAC address, where the bench knows it.
    pub mac: Option<Mac>,
    /// The address that our controller gives the device.
    pub ip: IpParameter,
    /// The addresses of our controllers.
    pub controllers: [(Mac, Ipv4Addr); 2],
    /// An address of the device's subnet that nobody has.
    pub free_ip: Ipv4Addr,
    /// The addresses and the rate of a PROFIBUS.
    pub line: DpLine,
    /// What their UUIDs and transaction numbers are made of, besides the name of the trial.
    pub seed: u64,
    /// By how many steps two looks at a shaft at rest may differ.
    pub noise: u32,
    /// The extra time that deadlines get on a live bench.
    pub slack: Duration,
    /// The bench file of a live bench.
    pub bench: Option<Arc<BenchFile>>,
    /// In the manner of which controller the device is addressed.
    pub persona: Option<Arc<Persona>>,
    /// Whether the device is told to deviate from its manual.
    pub deviates: bool,
}

/// Who is where on a PROFIBUS.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DpLine {
    /// The station address of the device.
    pub station: u8,
    /// Those of our masters.
    pub masters: [u8; 2],
    /// One that nobody has.
    pub free: u8,
    /// The rate of the bus.
    pub baud: BaudRate,
    /// How long is waited on a live bus; none on a virtual one.
    pub pace: Option<Pace>,
}

/// The bench of a device that is built in: the device at 3, our masters at 1 and 2.
impl Default for DpLine {
    fn default() -> DpLine {
        DpLine { station: 3, masters: [1, 2], free: 99, baud: BaudRate(1_500_000), pace: None }
    }
}
