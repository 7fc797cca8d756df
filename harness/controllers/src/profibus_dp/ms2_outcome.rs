//! How requests on the connection of a class 2 master (MS2) end.

use super::outcome::{AcyclicError, DataLinkAnswer, DpRecordOutcome};
use core::fmt;
use core::time::Duration;
use wire::profibus::dpv1::{Dpv1AbortReason, Dpv1Refusal, InitiateFeatures, Subnet};

/// A connection that the slave has accepted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Ms2Opened {
    /// The access point of the connection, from the resource manager.
    pub sap: u8,
    /// The longer Send_Timeout of master and slave.
    pub send_timeout: Duration,
    /// Max_Len_Data_Unit: the maximum length of a record.
    pub most_data: u8,
    /// Features and addresses of the slave.
    pub abilities: InitiateFeatures,
}

/// Why the slave closed a connection, from its Abort.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ms2End {
    /// The origin of the abort.
    pub subnet: Subnet,
    /// Instance and reason.
    pub reason: Dpv1AbortReason,
}

impl fmt::Display for Ms2End {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.reason.sentence() {
            Some(sentence) => write!(f, "the slave aborted the connection: {sentence}"),
            None => write!(f, "the slave aborted the connection with reason {:#04x}", self.reason.0),
        }
    }
}

/// The outcome of a request on MS2.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Ms2Outcome {
    /// The connection is open.
    Opened(Ms2Opened),
    /// The slave refused Initiate.
    Refused(Dpv1Refusal),
    /// The slave closed the connection.
    Ended(Ms2End),
    /// Idle was answered; the connection stands.
    Kept,
    /// A record was accessed, or not; it reports itself whether the slave closed the connection.
    Record(DpRecordOutcome),
    /// Abort was sent; the answer of the data link.
    Aborted(DataLinkAnswer),
    /// The request returned no answer. The master has closed the connection.
    Failed(AcyclicError),
}
