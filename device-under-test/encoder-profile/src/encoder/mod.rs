//! The measuring task of an absolute encoder: shaft, scaling, offset, velocity, memory.
//!
//! Shaft positions are counted in *hardware steps*, the resolution of the sensor. *Units* are the scaled steps of the
//! user.
//!
//! This module must not depend on a bus: no telegram, no parameter number, no shift factor, no status bit in an
//! output. The protocol layer encodes a position (left alignment, 31 bits and a trigger, an error in the highest
//! bit).

pub mod measuring;
pub mod memory;
pub mod scaling;
pub mod shaft;
pub mod velocity;

pub use measuring::{Measuring, MeasuringSettings, PresetMode};
pub use memory::NvmCell;
pub use scaling::{CountingDirection, Gear, Hardware, RedZone, Scaling};
pub use shaft::Shaft;
pub use velocity::{Sampling, Velocity, VelocityUnit};
