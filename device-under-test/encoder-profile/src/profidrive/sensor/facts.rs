//! The differences of the manuals in the sensor interface.

/// What a manual specifies about the sensor interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SensorFacts {
    /// When G1_XIST2 contains the position.
    pub transfers: PositionTransfer,
    pub parks: ParkingEffect,
    /// How an acknowledgement request is answered.
    pub answers: AcknowledgeAnswer,
    /// Whether an error stays until it is acknowledged, even if its cause has gone.
    pub latches_errors: bool,
    /// Whether the encoder parks while its shaft turns. If not, the request raises an error.
    pub parks_while_turning: bool,
    /// Whether parking clears the errors.
    pub parking_clears_errors: bool,
    /// Whether new errors are raised while parked.
    pub raises_while_parked: bool,
    /// Whether errors can be acknowledged while parked.
    pub acknowledges_while_parked: bool,
    /// Whether a preset that is disabled, because class 4 is off, is acknowledged like one that was carried out.
    pub answers_blocked_preset: bool,
}

impl SensorFacts {
    /// The sensor interface of the PROFIdrive profile (XAC77 manual, chapters 10 and 16).
    pub const PROFILE: SensorFacts = SensorFacts {
        transfers: PositionTransfer::Requested,
        parks: ParkingEffect::Zeroes,
        answers: AcknowledgeAnswer::Handshake,
        latches_errors: true,
        parks_while_turning: false,
        parking_clears_errors: true,
        raises_while_parked: false,
        acknowledges_while_parked: false,
        answers_blocked_preset: true,
    };
}

/// When G1_XIST2 contains the position, provided that neither an error nor parking prevents it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PositionTransfer {
    /// While bit 13 of G1_STW requests it.
    Requested,
    /// Always.
    Always,
}

/// The effect of parking on the positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParkingEffect {
    /// Positions and velocity are 0, and bits 12 and 13 of G1_ZSW are cleared.
    Zeroes,
    /// Positions keep their last values. The velocity and bits 12 and 13 of G1_ZSW behave as without parking.
    Freezes,
}

/// How an acknowledgement request is answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AcknowledgeAnswer {
    /// Errors whose cause has gone are cleared when the request is withdrawn. Bit 11 of G1_ZSW is cleared one cycle
    /// later.
    Handshake,
    /// Bit 11 of G1_ZSW is 1 while the request is set and there is an error. An error whose cause has gone is cleared
    /// at once.
    Echo,
}
