//! What holds a device under test in its hands.

use crate::{Duration, Time};
use alloc::string::String;

/// One thing that a stand does to a device; the names are those that `device.yaml` declares under `stand`.
#[derive(Clone, Debug, PartialEq)]
pub enum StandAction<'a> {
    /// Connects (`true`) or cuts the supply.
    Power(bool),
    /// Plugs (`true`) or pulls the cable of the bus.
    Link(bool),
    /// Turns the shaft steadily, in revolutions per minute, clockwise positive.
    ShaftSpeed(f64),
    /// Turns the shaft, from the speed that it has, faster or slower until it turns steadily at `rpm`; begun, not done.
    ShaftRamp {
        /// The speed to reach in revolutions per minute, clockwise positive.
        rpm: f64,
        /// How quickly, in revolutions per minute for each second, positive.
        acceleration: f64,
    },
    /// Puts the shaft at once at this raw place, in hardware steps from the physical zero.
    ShaftCounts(u64),
    /// Turns the shaft by `steps` hardware steps, clockwise positive, through all places between, at `rpm`.
    Turn {
        /// Way to go in hardware steps; the sign is the direction.
        steps: f64,
        /// Speed in revolutions per minute, positive.
        rpm: f64,
    },
    /// Turns the shaft by `revolutions`, clockwise positive, through all places between, at `rpm`.
    TurnRevolutions {
        /// Way to go in revolutions; the sign is the direction.
        revolutions: f64,
        /// Speed in revolutions per minute, positive.
        rpm: f64,
    },
    /// Makes a condition of the encoder present (`true`) or absent.
    Fault(&'a str, bool),
    /// Presses (`true`) or releases a button.
    Button(&'a str, bool),
    /// Turns a coding switch to a position.
    Switch(&'a str, u32),
    /// Sets the supply voltage, in volts.
    SupplyVoltage(f64),
    /// Sets the temperature of the device, in degrees Celsius.
    Temperature(f64),
    /// Puts a device as delivered into its place, with the name and the address that the bench has for it.
    Renew,
    /// Brings the device into the state in which it is delivered: without an address and anything stored, and without a name
    /// unless it is delivered with one.
    Deliver,
    /// Lets so much time go by for the device at once, so that nobody has to wait for it.
    Skip(Duration),
}

/// Why a stand did not do something.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Refusal {
    /// The stand has no means for it: the case is not applicable there.
    CannotDo(String),
    /// The stand has the means, and they failed: the bench is broken.
    Broken(String),
}

/// The hands at the device: the reference device has them built in, a live bench has hooks or an operator.
pub trait Stand {
    /// Does `action` at `now` and says when it will be done: `now` for a switch, later for a turning shaft.
    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Result<Time, Refusal>;

    /// What became of the last action: none while it is being done, then when it is or was done, or why it was not.
    ///
    /// A stand that does everything within [`Stand::act`] need not say anything here.
    fn outcome(&mut self, now: Time) -> Option<Result<Time, Refusal>> {
        Some(Ok(now))
    }

    /// What the LED `name` shows at `now`, in a word of `device.yaml`, or `None` where nobody can look at it.
    fn led(&mut self, now: Time, name: &str) -> Option<&'static str>;

    /// How often the counter `name` (for instance writes to the memory) has counted, or `None` where nobody counts.
    fn counter(&mut self, now: Time, name: &str) -> Option<u64>;
}
