//! Service access points (SAPs): behind which number which service of DP stands, and which service a frame is.
//!
//! This room must not know what the services carry. Source: IEC 61158-6-3, DP service access points.

use super::fdl::{DataFrame, RequestFunction};
use crate::codes::codes;

codes! {
    /// The access point at the slave: DSAP of a request, SSAP of its answer; unknown numbers are kept.
    ///
    /// 0 to 48 are given to connections of class 2 masters (MS2) by the resource manager.
    pub struct SlaveSap(u8) {
        49 RESOURCE_MANAGER resource_manager "MS2: a class 2 master asks for a connection (Initiate).",
        50 ALARM alarm "MS1: a class 1 master acknowledges an alarm.",
        51 SERVER server "MS1: a class 1 master reads and writes records and acknowledges alarms.",
        53 SET_EXT_PRM set_ext_prm "More parameters, as structured blocks.",
        55 SET_SLAVE_ADDRESS set_slave_address "A station address is given.",
        56 READ_INPUTS rd_inp "The inputs are read without changing the outputs.",
        57 READ_OUTPUTS rd_outp "The outputs are read.",
        58 GLOBAL_CONTROL global_control "A command to one, several or all slaves: clear, freeze, sync.",
        59 GET_CFG get_cfg "The configuration is read.",
        60 SLAVE_DIAG slave_diag "The diagnosis is read.",
        61 SET_PRM set_prm "The parameters are set.",
        62 CHK_CFG chk_cfg "The configuration is checked.",
    }
}

codes! {
    /// The access point at the master: SSAP of a request, DSAP of its answer; unknown numbers are kept.
    pub struct MasterSap(u8) {
        50 MS2 ms2 "A class 2 master in a connection.",
        51 MS1 ms1 "A class 1 master with the acyclic services of DP-V1.",
        54 MASTER_MASTER master_master "A master that speaks to another master.",
        62 MS0 ms0 "A master with the services of DP-V0.",
    }
}

/// The first access point of a slave that is no connection of a class 2 master.
const FIRST_FIXED: u8 = 49;

/// Which service a frame belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Service {
    /// Outputs and inputs: the default access point.
    DataExchange,
    /// A service with an access point of its own; the number is [`SlaveSap`]'s and may have no word.
    Slave(SlaveSap),
    /// A connection of a class 2 master, 0 to 48.
    Connection(u8),
    /// A master speaks to another master.
    MasterMaster,
    /// A service of the data link itself: FDL status, ident, LSAP status, time.
    Link(RequestFunction),
    /// An answer without access points and without data: it answers whatever was asked last.
    BareAnswer,
}

impl Service {
    /// The service of a frame, from its access points and its function code.
    ///
    /// An answer without access points and with data is taken for Data_Exchange, although FDL services answer so too: who saw
    /// the request knows better.
    pub fn of(frame: &DataFrame<'_>) -> Service {
        let (slave, master) = match frame.fc.is_request() {
            true => (frame.destination.sap, frame.source.sap),
            false => (frame.source.sap, frame.destination.sap),
        };
        match (slave, master.map(MasterSap), frame.fc.requested()) {
            (None, None, Some(function)) if function.is_link() => Service::Link(function),
            (None, None, None) if frame.data.is_empty() => Service::BareAnswer,
            (None, None, _) => Service::DataExchange,
            (Some(_), Some(MasterSap::MASTER_MASTER), _) => Service::MasterMaster,
            (Some(sap), Some(MasterSap::MS2), _) if sap < FIRST_FIXED => Service::Connection(sap),
            (Some(sap), _, _) => Service::Slave(SlaveSap(sap)),
            (None, Some(_), _) => Service::DataExchange,
        }
    }

    /// The word for the service, in snake_case; none for an access point that no table knows.
    pub fn word(self) -> Option<&'static str> {
        match self {
            Service::DataExchange => Some("data_exchange"),
            Service::Slave(sap) => sap.word(),
            Service::Connection(_) => Some("ms2"),
            Service::MasterMaster => Some("master_master"),
            Service::Link(function) => function.word(),
            Service::BareAnswer => Some("answer"),
        }
    }
}

impl RequestFunction {
    /// Whether the data link itself serves the request, and no user of an access point.
    pub fn is_link(self) -> bool {
        matches!(
            self,
            RequestFunction::FDL_STATUS
                | RequestFunction::IDENT
                | RequestFunction::LSAP_STATUS
                | RequestFunction::TIME_EVENT
                | RequestFunction::CLOCK_VALUE
        )
    }
}
