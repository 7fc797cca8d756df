//! Counts per revolution and total resolution (manual, 6.4.2 and 6.4.3).

use encoder_profile::encoder::{Hardware, Scaling};

/// A scaling from Set_Prm.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SentScaling {
    /// The scaling as it was sent.
    pub sent: Scaling,
    /// The scaling as it is used: limited to the resolution of the hardware.
    pub forced: Scaling,
    /// The resolution of the sensor.
    pub hardware: Hardware,
}

impl SentScaling {
    /// Creates a scaling from counts per revolution and total resolution, for an encoder with this hardware.
    pub fn new(units_per_revolution: u32, range: u32, hardware: &Hardware) -> SentScaling {
        let sent = Scaling { units_per_revolution: units_per_revolution.into(), range: range.into() };
        SentScaling { sent, forced: forced(sent, hardware), hardware: *hardware }
    }

    /// Returns whether the encoder can use this scaling.
    pub fn is_possible(&self) -> bool {
        is_possible(&self.forced, &self.hardware)
    }
}

/// Limits the values to those of the hardware (6.4.2 and 6.4.3).
pub fn forced(sent: Scaling, hardware: &Hardware) -> Scaling {
    Scaling {
        units_per_revolution: sent.units_per_revolution.min(hardware.steps_per_revolution),
        range: sent.range.min(hardware.range()),
    }
}

/// Returns whether a scaling has at least one unit per revolution, at least one revolution (6.4.3) and no more revolutions than the
/// hardware (6.4.2).
pub fn is_possible(scaling: &Scaling, hardware: &Hardware) -> bool {
    let Scaling { units_per_revolution, range } = *scaling;
    units_per_revolution > 0
        && range >= units_per_revolution
        && range <= units_per_revolution.saturating_mul(hardware.revolutions)
}
