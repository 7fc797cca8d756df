//! The encoder object: the measuring task that all encoders with PROFINET of the encoder profile share.
//!
//! A model gives its [`Facts`], plain data from its manual, and what is its own as a [`Model`] with hooks; what the right
//! answers of its manual are where they differ from the profile stands in the behaviour that it calls healthy. Here are the
//! start-up, the cyclic exchange, presets and their memory, errors and diagnoses, parameters and station names.
//!
//! This room must not know any model: where two manuals differ it asks the facts, the behaviour or a hook. Nor the stack.

mod cyclic;
mod device;
mod diagnosis;
mod facts;
mod live;
mod memory;
mod model;
mod names;
mod parameters;
mod places;
mod start;

pub use device::EncoderObject;
pub use facts::{
    Cause, Effect, ErrorFact, Facts, Identification, InExchange, Module, NO_DIAGNOSIS, Reset, Submodule, Timing,
    Variant, WarningFact, WithoutRecord,
};
pub use live::{Faults, Live, Phase, Ram, Store};
pub use memory::Source;
pub use model::Model;
pub use parameters::{double_word, double_words, octets, octets_of, word, words};
pub use places::{ACCESS_POINT_SUBSLOT, ENCODER_API, ENCODER_SLOT};

use crate::application::StationData;
use crate::behaviour::Behaviour;
use crate::profinet::Device;
use crate::registry::ReferenceDevice;
use alloc::boxed::Box;
use wire::ethernet::Mac;

/// A device behind its PROFINET stack; `None` if `facts` have no variant of this name. The rest is as for
/// [`EncoderObject::new`].
pub fn build<M: Model + 'static>(
    facts: &'static Facts,
    model: M,
    variant: &str,
    behaviour: Behaviour,
    mac: [u8; 6],
    shaft: u64,
    station: StationData,
) -> Option<Box<dyn ReferenceDevice>> {
    let variant = facts.variants.iter().find(|known| known.name == variant)?;
    let encoder = EncoderObject::new(facts, model, variant, behaviour, mac, shaft, station);
    Some(Box::new(Device::new(encoder, Mac(mac), behaviour.stack)))
}
