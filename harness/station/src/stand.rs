//! The stand: controls power, shaft, faults and buttons of a device under test.

use crate::{Duration, Time};
use alloc::string::String;

/// One action of a stand on a device; the names are those that `device.yaml` declares under `stand`.
#[derive(Clone, Debug, PartialEq)]
pub enum StandAction<'a> {
    /// Connects (`true`) or cuts the supply.
    Power(bool),
    /// Plugs (`true`) or pulls the cable of the bus.
    Link(bool),
    /// Turns the shaft at a constant speed, in revolutions per minute, clockwise positive.
    ShaftSpeed(f64),
    /// Accelerates or decelerates the shaft from its present speed to `rpm`. The action is done when the ramp has started.
    ShaftRamp {
        /// The speed to reach in revolutions per minute, clockwise positive.
        rpm: f64,
        /// The acceleration in revolutions per minute per second, positive.
        acceleration: f64,
    },
    /// Sets the shaft at once to this raw position, in hardware steps from the physical zero.
    ShaftCounts(u64),
    /// Turns the shaft by `steps` hardware steps, clockwise positive, through all positions in between, at `rpm`.
    Turn {
        /// The distance in hardware steps; the sign is the direction.
        steps: f64,
        /// The speed in revolutions per minute, positive.
        rpm: f64,
    },
    /// Turns the shaft by `revolutions`, clockwise positive, through all positions in between, at `rpm`.
    TurnRevolutions {
        /// The distance in revolutions; the sign is the direction.
        revolutions: f64,
        /// The speed in revolutions per minute, positive.
        rpm: f64,
    },
    /// Sets (`true`) or clears a fault of the encoder.
    Fault(&'a str, bool),
    /// Presses (`true`) or releases a button.
    Button(&'a str, bool),
    /// Turns a coding switch to a position.
    Switch(&'a str, u32),
    /// Sets the supply voltage, in volts.
    SupplyVoltage(f64),
    /// Sets the temperature of the device, in degrees Celsius.
    Temperature(f64),
    /// Replaces the device by one in its factory state, with the station name and address of the bench.
    ReplaceDevice,
    /// Resets the device to its factory state: no address, nothing stored, and no station name unless the vendor delivers it with
    /// one.
    RestoreFactoryState,
    /// Advances the time of the device at once by this duration, without waiting in real time.
    Skip(Duration),
}

/// Why a stand did not do an action.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum StandRefusal {
    /// The stand cannot do this action: the case is not applicable on this bench.
    CannotDo(String),
    /// The stand can do this action, but it failed: the bench is broken.
    Broken(String),
}

/// The stand of a device. The reference device has one built in; a live bench has hooks or an operator.
pub trait Stand {
    /// Starts `action` at `now` and returns when it will be done: `now` for a switch, later for a turning shaft.
    fn act(&mut self, now: Time, action: &StandAction<'_>) -> Result<Time, StandRefusal>;

    /// The result of the last action: `None` while it is running, then the time at which it is or was done, or why it failed.
    ///
    /// A stand that completes each action within [`Stand::act`] need not implement this.
    fn outcome(&mut self, now: Time) -> Option<Result<Time, StandRefusal>> {
        Some(Ok(now))
    }

    /// The state of the LED `name` at `now`, as a word of `device.yaml`, or `None` if the stand cannot read it.
    fn led(&mut self, now: Time, name: &str) -> Option<&'static str>;

    /// The value of the counter `name` (for instance memory writes), or `None` if the stand cannot count it.
    fn counter(&mut self, now: Time, name: &str) -> Option<u64>;
}
