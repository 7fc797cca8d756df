//! Other ident numbers of modules and submodules, as the description of another vendor may have them.

use alloc::vec::Vec;
use device_stack::profinet::{INTERFACE_SUBSLOT, PluggableSubmodule};
use encoder_profile::hooks::EncoderHooks;

/// The bits of idents that are inverted. Several masks add up, in any order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct IdentMask {
    /// Of the ident of a module outside slot 0.
    pub module: u32,
    /// Of the ident of a submodule outside slot 0.
    pub submodule: u32,
    /// Of the idents of the interface and of the ports.
    pub network: u32,
}

impl IdentMask {
    /// Whether no ident changes.
    pub fn is_empty(self) -> bool {
        self == IdentMask::default()
    }

    /// Both masks, one after the other.
    #[must_use]
    pub fn and(self, other: IdentMask) -> IdentMask {
        IdentMask {
            module: self.module ^ other.module,
            submodule: self.submodule ^ other.submodule,
            network: self.network ^ other.network,
        }
    }

    /// Changes the idents of a submodule and its module; a second time they are as before.
    pub fn apply(self, plug: &mut PluggableSubmodule) {
        match (plug.slot, plug.subslot) {
            (0, INTERFACE_SUBSLOT..) => plug.submodule_ident ^= self.network,
            (0, _) => {}
            _ => {
                plug.module_ident ^= self.module;
                plug.submodule_ident ^= self.submodule;
            }
        }
    }
}

/// Gives the encoder the idents of its own tables, whatever the stack announces.
pub(super) struct OwnIdents(pub IdentMask);

impl EncoderHooks for OwnIdents {
    fn plugged(&mut self, mut plugged: Vec<PluggableSubmodule>) -> Vec<PluggableSubmodule> {
        plugged.iter_mut().for_each(|plug| self.0.apply(plug));
        plugged
    }
}
