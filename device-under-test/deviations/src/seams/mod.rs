//! Who stands beside a device: for each of its seams the deviations that change something there.

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

impl Deviations {
    /// How a device behaves that has them all.
    pub fn behaviour(self) -> Behaviour {
        let Deviations { mut behaviour, slave } = self;
        if !slave.is_empty() {
            behaviour.slave = Beside::of(Rc::new(RefCell::new(slave)));
        }
        behaviour
    }
}
