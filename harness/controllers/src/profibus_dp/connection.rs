//! The description of a start-up: the slave, its parameters and configuration, the cycle.
//!
//! This module must not know how anything is sent.

use alloc::vec::Vec;
use core::time::Duration;
use wire::profibus::global_control::GlobalControl;

/// Default cycle time.
const USUAL_CYCLE: Duration = Duration::from_millis(1);
/// Default timeout for the slave to appear and to become ready; no standard sets it.
const SLAVE_TIMEOUT: Duration = Duration::from_secs(3);

/// A service of a start-up, for its order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StartUpService {
    /// Slave_Diag, repeated until a slave answers; it only shows that the slave is present.
    Diagnosis,
    /// Set_Prm.
    SetPrm,
    /// Chk_Cfg.
    CheckConfiguration,
    /// Slave_Diag, repeated until the slave is ready or reports an error.
    Ready,
    /// Global_Control to all stations: Operate.
    Operate,
    /// Data_Exchange, until the first valid answer.
    Exchange,
}

impl StartUpService {
    /// The order of a conforming master.
    pub const USUAL: [StartUpService; 6] = [
        StartUpService::Diagnosis,
        StartUpService::SetPrm,
        StartUpService::CheckConfiguration,
        StartUpService::Ready,
        StartUpService::Operate,
        StartUpService::Exchange,
    ];
}

/// The data of Data_Exchange while the master is in Clear.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ClearOutputs {
    /// As many zeros as there are outputs.
    #[default]
    Zeros,
    /// No data, as for fail-safe slaves.
    Empty,
    /// The values that were set; no conforming master does this.
    AsSet,
}

/// The clock of isochronous mode: a Global_Control at the start of each cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct IsoModeClock {
    /// The Global_Control to send; group 8 belongs to isochronous mode.
    pub control: GlobalControl,
}

impl Default for IsoModeClock {
    fn default() -> IsoModeClock {
        IsoModeClock { control: GlobalControl { command: Default::default(), groups: 0x80 } }
    }
}

/// A start-up from the first Slave_Diag to the first valid data, and the cyclic exchange after it.
///
/// Begin with [`SlaveConfig::new`], which sets usual values, and change what differs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SlaveConfig {
    /// Station address of the slave.
    pub address: u8,
    /// The bytes of Set_Prm, from the station status on.
    pub set_prm: Vec<u8>,
    /// The bytes of Chk_Cfg.
    pub chk_cfg: Vec<u8>,
    /// Bytes in each Data_Exchange request.
    pub output_length: usize,
    /// Expected bytes in its answer.
    pub input_length: usize,
    /// Time from one Data_Exchange to the next.
    pub cycle: Duration,
    /// The services in the order in which they are sent. A refusal does not end the start-up; no answer does.
    pub services: Vec<StartUpService>,
    /// Timeout for the slave to appear on the bus, and then to become ready.
    pub patience: Duration,
    /// The clock, in isochronous mode.
    pub clock: Option<IsoModeClock>,
    /// What is sent in Clear.
    pub clear: ClearOutputs,
    /// Whether an answer of high priority makes the master read the diagnosis.
    pub reads_diagnosis: bool,
}

impl SlaveConfig {
    /// A start-up in the usual order, with a cycle of 1 ms and a timeout of 3 s for the slave.
    pub fn new(
        address: u8,
        set_prm: Vec<u8>,
        chk_cfg: Vec<u8>,
        (output_length, input_length): (usize, usize),
    ) -> SlaveConfig {
        SlaveConfig {
            address,
            set_prm,
            chk_cfg,
            output_length,
            input_length,
            cycle: USUAL_CYCLE,
            services: StartUpService::USUAL.to_vec(),
            patience: SLAVE_TIMEOUT,
            clock: None,
            clear: ClearOutputs::Zeros,
            reads_diagnosis: true,
        }
    }
}
