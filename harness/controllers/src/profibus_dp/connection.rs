//! What a start-up is to be: the slave, its parameters and configuration, the cycle.
//!
//! This room must not know how any of it is sent.

use alloc::vec::Vec;
use core::time::Duration;
use wire::profibus::global_control::GlobalControl;

/// A service of a start-up, for its order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Service {
    /// Slave_Diag, once a slave answers it; it only tells who is there.
    Diagnosis,
    /// Set_Prm.
    SetPrm,
    /// Chk_Cfg.
    CheckConfiguration,
    /// Slave_Diag until the slave is ready or says what is wrong.
    Ready,
    /// Global_Control to all: operate.
    Operate,
    /// Data_Exchange, until the first good answer.
    Exchange,
}

impl Service {
    /// The order of a conforming master.
    pub const USUAL: [Service; 6] = [
        Service::Diagnosis,
        Service::SetPrm,
        Service::CheckConfiguration,
        Service::Ready,
        Service::Operate,
        Service::Exchange,
    ];
}

/// What Data_Exchange carries while the master is in Clear.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum ClearOutputs {
    /// As many zeros as there are outputs.
    #[default]
    Zeros,
    /// Nothing, as fail-safe slaves are addressed.
    Empty,
    /// What is set, as no conforming master does.
    AsSet,
}

/// The clock of isochronous mode: a Global_Control at the beginning of each cycle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Clock {
    /// What is sent; group 8 belongs to isochronous mode.
    pub control: GlobalControl,
}

impl Default for Clock {
    fn default() -> Clock {
        Clock { control: GlobalControl { command: Default::default(), groups: 0x80 } }
    }
}

/// A start-up from the first Slave_Diag to the first good data, and the exchange behind it.
///
/// Begin with [`Connection::new`], which has usual values, and change what is to be different.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Connection {
    /// The address of the slave.
    pub address: u8,
    /// The octets of Set_Prm, from the station status on.
    pub set_prm: Vec<u8>,
    /// The octets of Chk_Cfg.
    pub chk_cfg: Vec<u8>,
    /// How many octets each Data_Exchange carries.
    pub output_length: usize,
    /// How many octets its answer is to have.
    pub input_length: usize,
    /// From one Data_Exchange to the next.
    pub cycle: Duration,
    /// What is sent, in this order; a refusal does not end the start-up, silence does.
    pub services: Vec<Service>,
    /// How long the slave may take to appear on the bus, and then to become ready.
    pub patience: Duration,
    /// The clock, in isochronous mode.
    pub clock: Option<Clock>,
    /// What is sent in Clear.
    pub clear: ClearOutputs,
    /// Whether an answer of high priority makes the master read the diagnosis.
    pub reads_diagnosis: bool,
    /// After how many cycles in a row without answer the connection has ended; 0 never.
    pub lost_after: u32,
}

impl Connection {
    /// A start-up in the usual order, with a cycle of 1 ms and 3 s for the slave.
    pub fn new(
        address: u8,
        set_prm: Vec<u8>,
        chk_cfg: Vec<u8>,
        (output_length, input_length): (usize, usize),
    ) -> Connection {
        Connection {
            address,
            set_prm,
            chk_cfg,
            output_length,
            input_length,
            cycle: Duration::from_millis(1),
            services: Service::USUAL.to_vec(),
            patience: Duration::from_secs(3),
            clock: None,
            clear: ClearOutputs::Zeros,
            reads_diagnosis: true,
            lost_after: 3,
        }
    }
}
