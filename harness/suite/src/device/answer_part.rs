//! Named parts of an answer.

use super::DiagnosisName;
use serde::{Deserialize, Serialize};

/// A part of an answer.
#[derive(Clone, Debug, PartialEq, Eq, Hash, Deserialize, Serialize)]
pub enum AnswerPart {
    /// The answer as a whole.
    Whole,
    /// A parameter of a multi-parameter request, as number and subindex.
    Parameter(u16, u16),
    /// The bytes of the response.
    Bytes,
    /// Stage of a start-up: the Connect call.
    Connect,
    /// Stage of a start-up: a record (index into `device.records`).
    Record(usize),
    /// Stage of a start-up: state of a submodule in ModuleDiffBlock (index into `device.submodules`).
    ModuleDiff(usize),
    /// Stage of a start-up: the answer to Set_Prm.
    SetPrm,
    /// Stage of a start-up: the answer to Chk_Cfg.
    ChkCfg,
    /// Stage of a start-up: the Slave_Diag after Chk_Cfg.
    Diagnosis(DiagnosisName),
    /// Stage of a start-up: end of parameters.
    ParameterEnd,
    /// Stage of a start-up: the device's ApplicationReady.
    ApplicationReady,
    /// Whether a connection is established afterwards: `data` or `none`.
    Connection,
    /// HTTP status.
    Status,
    /// Texts that a web page contains.
    Contains,
    /// Texts that a web page does not contain.
    Lacks,
    /// The visible text of a web page.
    Text,
    /// The number in the last object of an SNMP answer.
    Number,
}
