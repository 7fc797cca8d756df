//! The addresses of a device under test and of the harness's stations, as given by a bench, for either bus.

use controllers::profibus_dp::LiveBusTiming;
use results::bench_file::BenchFile;
use station::Duration;
use std::net::Ipv4Addr;
use std::sync::Arc;
use suite::persona::Persona;
use wire::ethernet::Mac;
use wire::profibus::fdl::BaudRate;
use wire::profinet::dcp::block::IpParameter;

/// The bench of a trial: the addresses of the device and of the harness's controllers or masters.
#[derive(Clone, Debug)]
pub struct TrialEnvironment {
    /// Whether the device is a reference device that is not that of the manual, so that its stand may lack what the manual has.
    pub is_other_model: bool,
    /// The station name that the bench gives the device.
    pub name: String,
    /// The MAC address, if the bench knows it.
    pub mac: Option<Mac>,
    /// The IP address that the controller gives the device.
    pub ip: IpParameter,
    /// The addresses of the harness's controllers.
    pub controllers: [(Mac, Ipv4Addr); 2],
    /// An unused address of the device's subnet.
    pub free_ip: Ipv4Addr,
    /// The addresses and the baud rate on PROFIBUS.
    pub line: DpLine,
    /// The seed of UUIDs and transaction numbers, together with the name of the trial.
    pub seed: u64,
    /// By how many steps two readings of a shaft at rest may differ.
    pub noise: u32,
    /// The extra time for deadlines on a live bench.
    pub slack: Duration,
    /// The bench file of a live bench.
    pub bench: Option<Arc<BenchFile>>,
    /// The persona of the controller.
    pub persona: Option<Arc<Persona>>,
    /// Whether the device has bugs on purpose.
    pub deviates: bool,
}

/// The addresses and the baud rate on a PROFIBUS.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct DpLine {
    /// The station address of the device.
    pub station: u8,
    /// The addresses of the harness's masters.
    pub masters: [u8; 2],
    /// An unused address.
    pub free: u8,
    /// The baud rate of the bus.
    pub baud: BaudRate,
    /// The times of a live bus; `None` on a virtual one.
    pub pace: Option<LiveBusTiming>,
}

/// The bus of a built-in device: the device at address 3, masters at 1 and 2.
impl Default for DpLine {
    fn default() -> DpLine {
        DpLine { station: 3, masters: [1, 2], free: 99, baud: BaudRate(1_500_000), pace: None }
    }
}
