//! What the manuals say of the sensor interface where they do not agree.

/// What a manual says of the sensor interface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SensorFacts {
    /// When the position stands in G1_XIST2.
    pub transfers: Transfers,
    /// What parking does to the positions.
    pub parks: Parks,
    /// How a request to acknowledge is answered.
    pub answers: Answers,
    /// Whether an error stays when its cause has gone, until it is acknowledged.
    pub latches_errors: bool,
    /// Whether the encoder parks while its shaft turns; where it does not, the request is answered by an error.
    pub parks_while_turning: bool,
    /// Whether parking clears the errors.
    pub parking_clears_errors: bool,
    /// Whether new errors are raised while parked.
    pub raises_while_parked: bool,
    /// Whether errors can be acknowledged while parked.
    pub acknowledges_while_parked: bool,
    /// Whether a preset that class 4 does not permit is answered like one that was carried out.
    pub answers_blocked_preset: bool,
}

impl SensorFacts {
    /// The sensor interface of the PROFIdrive profile, as chapters 10 and 16 of the XAC77 manual print it.
    pub const PROFILE: SensorFacts = SensorFacts {
        transfers: Transfers::Requested,
        parks: Parks::Zeroes,
        answers: Answers::Handshake,
        latches_errors: true,
        parks_while_turning: false,
        parking_clears_errors: true,
        raises_while_parked: false,
        acknowledges_while_parked: false,
        answers_blocked_preset: true,
    };
}

/// When the position stands in G1_XIST2, as far as neither an error nor parking is in its way.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Transfers {
    /// While bit 13 of G1_STW requests it.
    Requested,
    /// Always.
    Always,
}

/// What parking does to the positions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Parks {
    /// They are 0 and so is the velocity; bits 12 and 13 of G1_ZSW are cleared.
    Zeroes,
    /// They keep their last values; the velocity and bits 12 and 13 of G1_ZSW stay as they would be without parking.
    Freezes,
}

/// How a request to acknowledge is answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answers {
    /// Errors whose cause has gone go when the request is taken back, and bit 11 of G1_ZSW goes one cycle later.
    Handshake,
    /// Bit 11 of G1_ZSW is 1 while there is an error and the request; an error whose cause has gone goes at once.
    Echo,
}
