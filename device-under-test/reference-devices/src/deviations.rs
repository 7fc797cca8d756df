//! The deviations attached to the parts of a reference device. A conforming device has none.

use crate::models::{datalogic_amt58, lika_xac77, sick, sick_a3m60, sick_afx60};
use device_stack::{Attached, profibus, profinet};
use encoder_profile::deviations::EncoderDeviations;

/// The deviations of one device, by the part that calls their hooks. None by default.
#[derive(Clone, Default)]
pub struct DeviceDeviations {
    /// At the encoder of the encoder profile.
    pub encoder: EncoderDeviations,
    /// At the PROFINET stack.
    pub stack: Attached<dyn profinet::StackHooks>,
    /// At the PROFIBUS slave.
    pub slave: Attached<dyn profibus::SlaveHooks>,
    /// At the web server of the XAC77.
    pub web: lika_xac77::hooks::WebDeviations,
    /// At the parts that the SICK encoders share.
    pub sick: sick::hooks::SickDeviations,
    /// At the A3M60.
    pub a3m60: sick_a3m60::hooks::A3m60Deviations,
    /// At the AFS60 and AFM60.
    pub afx60: sick_afx60::hooks::Afx60Deviations,
    /// At the AMT58.
    pub amt58: Attached<dyn datalogic_amt58::hooks::Amt58Hooks>,
}
