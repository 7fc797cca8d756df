//! Who stands beside a device: for each of its seams the deviations that change something there.

pub mod encoder;
pub mod slave;

use alloc::rc::Rc;
use core::cell::RefCell;
use device_stack::Beside;
use reference_devices::behaviour::Behaviour;

/// Everything by which one device deviates.
#[derive(Default)]
pub struct Deviations {
    /// What the device is built with; what is still told by it goes to the seams.
    pub behaviour: Behaviour,
    /// Who stands beside its encoder.
    pub at_encoder: encoder::Encoder,
    /// Who stands beside its PROFIBUS slave.
    pub slave: slave::Slave,
}

impl core::ops::Deref for Deviations {
    type Target = Behaviour;

    fn deref(&self) -> &Behaviour {
        &self.behaviour
    }
}

impl core::ops::DerefMut for Deviations {
    fn deref_mut(&mut self) -> &mut Behaviour {
        &mut self.behaviour
    }
}

/// What stands beside an encoder, with what is still told by its knobs.
pub struct OfEncoder<'a> {
    /// Who stands beside it.
    pub at_encoder: &'a mut encoder::Encoder,
    knobs: &'a mut encoder_profile::behaviour::Behaviour,
}

impl core::ops::Deref for OfEncoder<'_> {
    type Target = encoder_profile::behaviour::Behaviour;

    fn deref(&self) -> &encoder_profile::behaviour::Behaviour {
        self.knobs
    }
}

impl core::ops::DerefMut for OfEncoder<'_> {
    fn deref_mut(&mut self) -> &mut encoder_profile::behaviour::Behaviour {
        self.knobs
    }
}

impl Deviations {
    /// The part of them that is about the encoder.
    pub fn of_encoder(&mut self) -> OfEncoder<'_> {
        OfEncoder { at_encoder: &mut self.at_encoder, knobs: &mut self.behaviour.encoder }
    }

    /// How a device behaves that has them all.
    pub fn behaviour(self) -> Behaviour {
        let Deviations { mut behaviour, at_encoder, slave } = self;
        if !at_encoder.is_empty() {
            behaviour.encoder.beside = Beside::of(Rc::new(RefCell::new(at_encoder)));
        }
        if !slave.is_empty() {
            behaviour.slave = Beside::of(Rc::new(RefCell::new(slave)));
        }
        behaviour
    }
}
