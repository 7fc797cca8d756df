//! Service access points (SAPs) of the DP services, and the service of a frame.
//!
//! This module must not know the data of the services. Source: IEC 61158-6-3, DP service access points.

use super::fdl::{DataFrame, RequestFunction};
use crate::codes::codes;

codes! {
    /// The access point at the slave: DSAP of a request, SSAP of its response; unknown numbers are preserved.
    ///
    /// The resource manager assigns 0 to 48 to connections of class 2 masters (MS2).
    pub struct SlaveSap(u8) {
        49 RESOURCE_MANAGER resource_manager "MS2: a class 2 master requests a connection (Initiate).",
        50 ALARM alarm "MS1: a class 1 master acknowledges an alarm.",
        51 SERVER server "MS1: a class 1 master reads and writes records and acknowledges alarms.",
        53 SET_EXT_PRM set_ext_prm "More parameters, as structured blocks.",
        55 SET_SLAVE_ADDRESS set_slave_address "Assigns a station address.",
        56 READ_INPUTS rd_inp "Reads the inputs without changing the outputs.",
        57 READ_OUTPUTS rd_outp "Reads the outputs.",
        58 GLOBAL_CONTROL global_control "A command to one, several or all slaves: clear, freeze, sync.",
        59 GET_CFG get_cfg "Reads the configuration.",
        60 SLAVE_DIAG slave_diag "Reads the diagnosis.",
        61 SET_PRM set_prm "Sets the parameters.",
        62 CHK_CFG chk_cfg "Checks the configuration.",
    }
}

codes! {
    /// The access point at the master: SSAP of a request, DSAP of its response; unknown numbers are preserved.
    pub struct MasterSap(u8) {
        50 MS2 ms2 "A class 2 master in a connection.",
        51 MS1 ms1 "A class 1 master with the acyclic services of DP-V1.",
        54 MASTER_MASTER master_master "A master that communicates with another master.",
        62 MS0 ms0 "A master with the services of DP-V0.",
    }
}

/// The first access point of a slave that is not for connections of class 2 masters.
const FIRST_FIXED: u8 = 49;

/// The service of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum SapService {
    /// Outputs and inputs: the default access point.
    DataExchange,
    /// A service with a fixed access point; the number may be unknown to [`SlaveSap`].
    Slave(SlaveSap),
    /// A connection of a class 2 master, 0 to 48.
    Connection(u8),
    /// Communication between two masters.
    MasterMaster,
    /// A service of the data link itself: FDL status, ident, LSAP status, time.
    Link(RequestFunction),
    /// A response without access points and without data, to the last request, whatever it was.
    BareAnswer,
}

impl SapService {
    /// The service of a frame, from its access points and its function code.
    ///
    /// A response without access points and with data counts as Data_Exchange, although FDL services have such responses too; only
    /// the request can distinguish them.
    pub fn of(frame: &DataFrame<'_>) -> SapService {
        let (slave, master) = if frame.fc.is_request() {
            (frame.destination.sap, frame.source.sap)
        } else {
            (frame.source.sap, frame.destination.sap)
        };
        match (slave, master.map(MasterSap), frame.fc.requested()) {
            (None, None, Some(function)) if function.is_link() => SapService::Link(function),
            (None, None, None) if frame.data.is_empty() => SapService::BareAnswer,
            (None, None, _) => SapService::DataExchange,
            (Some(_), Some(MasterSap::MASTER_MASTER), _) => SapService::MasterMaster,
            (Some(sap), Some(MasterSap::MS2), _) if sap < FIRST_FIXED => SapService::Connection(sap),
            (Some(sap), _, _) => SapService::Slave(SlaveSap(sap)),
            (None, Some(_), _) => SapService::DataExchange,
        }
    }

    /// The word for the service, in snake_case; `None` for an unknown access point.
    pub fn word(self) -> Option<&'static str> {
        match self {
            SapService::DataExchange => Some("data_exchange"),
            SapService::Slave(sap) => sap.word(),
            SapService::Connection(_) => Some("ms2"),
            SapService::MasterMaster => Some("master_master"),
            SapService::Link(function) => function.word(),
            SapService::BareAnswer => Some("answer"),
        }
    }
}

impl RequestFunction {
    /// Whether the data link itself serves the request, without a user of an access point.
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
