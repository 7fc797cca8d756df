//! Counts per revolution and total resolution (manual, 6.4.2 and 6.4.3).

use encoder_profile::encoder::{Hardware, Scaling};

/// A scaling as Set_Prm brings it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SentScaling {
    /// As it was sent.
    pub sent: Scaling,
    /// As it is used: forced to the resolution of the hardware where it is greater.
    pub forced: Scaling,
    /// The hardware.
    pub hardware: Hardware,
}

impl SentScaling {
    /// The counts per revolution and the total resolution that were sent to an encoder of this hardware.
    pub fn new(units_per_revolution: u32, range: u32, hardware: &Hardware) -> SentScaling {
        let sent = Scaling { units_per_revolution: units_per_revolution.into(), range: range.into() };
        SentScaling { sent, forced: forced(sent, hardware), hardware: *hardware }
    }

    /// Whether the encoder can measure so.
    pub fn is_possible(&self) -> bool {
        is_possible(&self.forced, &self.hardware)
    }
}

/// A value that is greater than allowed is forced to that of the hardware (6.4.2 and 6.4.3).
pub fn forced(sent: Scaling, hardware: &Hardware) -> Scaling {
    Scaling {
        units_per_revolution: sent.units_per_revolution.min(hardware.steps_per_revolution),
        range: sent.range.min(hardware.range()),
    }
}

/// Whether a scaling has at least one unit per revolution, at least one revolution (6.4.3) and no more than the hardware (6.4.2).
pub fn is_possible(scaling: &Scaling, hardware: &Hardware) -> bool {
    let Scaling { units_per_revolution, range } = *scaling;
    units_per_revolution > 0
        && range >= units_per_revolution
        && range <= units_per_revolution.saturating_mul(hardware.revolutions)
}
