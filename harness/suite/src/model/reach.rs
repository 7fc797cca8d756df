//! What a live bench must have.

use serde::{Deserialize, Serialize};

/// The least that a live bench must have; later values take more. Consents and the time that a trial takes do not count.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize)]
pub enum Reach {
    /// A link, and a description where the manual leaves something to it.
    NoStand,
    /// Also a stand: control of the shaft, of the power or of faults, or LEDs that it reads.
    WithStand,
    /// No live bench has it, for this reason.
    Never(String),
}
