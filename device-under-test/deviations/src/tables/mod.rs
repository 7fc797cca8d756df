//! The deliberate bugs of the reference devices, by the seam at which they are switched on.
//!
//! A [`Bug`] is a name, a sentence and the knob that it turns; no code of a device ever asks for a bug. A model says which
//! of them its devices can be told to have (`manuals`), one that stands outside of this crate too. This room must not hold
//! healthy behaviour: that stands at the seam which reads the knob.

use crate::seams::Deviations;

/// Lines of `"name" "Sentence." => |b| what is turned;`.
macro_rules! bugs {
    ($($name:literal $sentence:literal => |$behaviour:ident| $turn:expr;)*) => {
        &[$($crate::tables::Bug {
            name: $name,
            sentence: $sentence,
            apply: |$behaviour: &mut $crate::seams::Deviations| { $turn; },
        }),*]
    };
}

/// The same for knobs that are all the encoder's.
macro_rules! encoder_bugs {
    ($($name:literal $sentence:literal => |$behaviour:ident| $turn:expr;)*) => {
        bugs! {$(
            $name $sentence => |behaviour| {
                let $behaviour = &mut behaviour.of_encoder();
                $turn;
            };
        )*}
    };
}

pub mod amt58;
pub mod codes;
pub mod diagnosis;
pub mod dp_diagnosis;
pub mod dp_presets;
pub mod dp_station;
pub mod handshakes;
mod image;
pub mod isochronous;
pub mod layouts;
pub mod leds;
pub mod lights;
pub mod limits;
pub mod measuring;
pub mod memory;
pub mod panel;
pub mod parameter_access;
pub mod parameters;
pub mod plain;
pub mod presets;
pub mod records;
pub mod requests;
pub mod reset;
pub mod service;
pub mod set_prm;
pub mod signals;
pub mod slave;
pub mod slave_memory;
pub mod stack;
pub mod start;
pub mod station;
pub mod velocity;
pub mod vendor_axis;
pub mod vendor_parameters;
pub mod vendor_telegrams;
pub mod web;

/// A deliberate deviation of a reference device from its manual.
#[derive(Debug)]
pub struct Bug {
    /// Its name, as the suites name it under `catches`.
    pub name: &'static str,
    /// What the device does wrong, in one sentence.
    pub sentence: &'static str,
    /// Puts itself beside a device.
    pub apply: fn(&mut Deviations),
}

/// Bugs of one seam that a model can be told to have.
#[derive(Clone, Copy, Debug)]
pub enum Table {
    /// All of them.
    All(&'static [Bug]),
    /// Those of these names.
    Only(&'static [Bug], &'static [&'static str]),
}

impl Table {
    /// The bugs that it names, in the order of the seam.
    pub fn bugs(&self) -> impl Iterator<Item = &'static Bug> + Clone + use<> {
        let (all, only) = match *self {
            Table::All(all) => (all, None),
            Table::Only(all, only) => (all, Some(only)),
        };
        all.iter().filter(move |bug| only.is_none_or(|only| only.contains(&bug.name)))
    }
}
