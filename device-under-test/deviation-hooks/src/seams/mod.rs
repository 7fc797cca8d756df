//! The hooks of a device to which the deviations of the tables are attached.
//!
//! A deviation without state is a closure at one hook: `d.encoder.image(|before, image| ..)`. A deviation with state implements the
//! hook trait itself and is added: `d.encoder.add(..)`. Several deviations at one hook act in the order in which they were added; what
//! happens to frames on their way acts after all of them.

/// Defines a list of deviations that implements the hooks of one part of a device, with one method per hook.
///
/// `name(argument: Type) -> Value;` is a hook whose last argument is the value of the manual and which returns the value to use.
/// Without `-> Value` the hook changes one of its arguments.
macro_rules! hooks {
    ($list:ident: $hooks:ident $($(#[$doc:meta])* $name:ident($($argument:ident: $type:ty),*) $(-> $value:ty)?;)*) => {
        #[doc = concat!("The deviations at [`", stringify!($hooks), "`].")]
        #[derive(Default)]
        pub struct $list {
            deviations: alloc::vec::Vec<alloc::boxed::Box<dyn $hooks>>,
            /// Act after all others.
            last: alloc::vec::Vec<alloc::boxed::Box<dyn $hooks>>,
        }

        impl $list {
            /// Adds a deviation that has state or uses several hooks.
            pub fn add(&mut self, deviation: impl $hooks + 'static) {
                self.deviations.push(alloc::boxed::Box::new(deviation));
            }

            /// Adds a deviation that acts after all others, also those that are added later.
            pub fn add_last(&mut self, deviation: impl $hooks + 'static) {
                self.last.push(alloc::boxed::Box::new(deviation));
            }

            /// Adds a deviation that acts before all others.
            pub fn add_first(&mut self, deviation: impl $hooks + 'static) {
                self.deviations.insert(0, alloc::boxed::Box::new(deviation));
            }

            /// The handle that a device is built with.
            pub fn attached(self) -> device_stack::Attached<dyn $hooks> {
                if self.deviations.is_empty() && self.last.is_empty() {
                    device_stack::Attached::NONE
                } else {
                    device_stack::Attached::new(alloc::rc::Rc::new(core::cell::RefCell::new(self)))
                }
            }

            $(
                $(#[$doc])*
                pub fn $name(&mut self, change: impl FnMut($($type,)* $($value)?) $(-> $value)? + 'static) {
                    struct Hook<F>(F);

                    impl<F: FnMut($($type,)* $($value)?) $(-> $value)?> $hooks for Hook<F> {
                        hook! { $name($($argument: $type),*) $(-> $value)? { one } }
                    }

                    self.add(Hook(change));
                }
            )*
        }

        impl $hooks for $list {
            $(hook! { $name($($argument: $type),*) $(-> $value)? { all } })*
        }
    };
}

/// Defines one method of [`hooks!`]: for `one` closure, or for `all` deviations in a list.
macro_rules! hook {
    ($name:ident($($argument:ident: $type:ty),*) -> $value:ty { one }) => {
        fn $name(&mut self, $($argument: $type,)* value: $value) -> $value {
            (self.0)($($argument,)* value)
        }
    };
    ($name:ident($($argument:ident: $type:ty),*) { one }) => {
        fn $name(&mut self, $($argument: $type),*) {
            (self.0)($($argument),*);
        }
    };
    ($name:ident($($argument:ident: $type:ty),*) -> $value:ty { all }) => {
        fn $name(&mut self, $($argument: $type,)* mut value: $value) -> $value {
            for deviation in self.deviations.iter_mut().chain(&mut self.last) {
                value = deviation.$name($($argument,)* value);
            }
            value
        }
    };
    ($name:ident($($argument:ident: $type:ty),*) { all }) => {
        fn $name(&mut self, $($argument: $type),*) {
            for deviation in self.deviations.iter_mut().chain(&mut self.last) {
                deviation.$name($($argument),*);
            }
        }
    };
}

pub mod a3m60;
pub mod amt58;
pub mod encoder;
pub mod idents;
mod last_cycles;
pub mod late;
pub mod measuring;
pub mod sick;
pub mod slave;
pub mod stack;
pub mod start_layout;
pub mod web;

use encoder_profile::checks::AttachedChecks;
use encoder_profile::deviations::EncoderDeviations;
use reference_devices::deviations::DeviceDeviations;
use reference_devices::models::{lika_xac77, sick as of_sick, sick_a3m60, sick_afx60};

/// All deviations of one device, by the part whose hooks they use.
#[derive(Default)]
pub struct Deviations {
    /// At the decisions of the encoder.
    pub checks: encoder::Decisions,
    /// At the hooks of the encoder.
    pub encoder: encoder::Encoder,
    /// At the calculation of positions and presets.
    pub measuring: measuring::Positions,
    /// At the calculation of the velocity.
    pub velocity: measuring::Speeds,
    /// At the telegrams.
    pub telegram: encoder::Telegrams,
    /// At the start-up.
    pub start: encoder::Start,
    /// At the signs of life.
    pub life_sign: encoder::LifeSign,
    /// At presets by a trigger.
    pub trigger: encoder::Trigger,
    /// At the hooks of the PROFIBUS slave.
    pub slave: slave::SlaveDeviations,
    /// At the hooks of an AMT58.
    pub amt58: amt58::Amt58,
    /// At the hooks of an A3M60.
    pub a3m60: a3m60::A3m60,
    /// At the hooks of the PROFINET stack.
    pub stack: stack::Stack,
    /// Late and additional frames of the PROFINET stack.
    pub late: late::LateFrames,
    /// Other idents of modules and submodules.
    pub idents: idents::IdentMask,
    /// Other places of the start parameters, with those of the device.
    pub start_layout: Option<(start_layout::StartTable, start_layout::StartLayout)>,
    /// At the hooks of the web server of the XAC77.
    pub web: web::WebServer,
    /// At the hooks of the parts that the SICK encoders share.
    pub sick: sick::Sick,
    /// At the round axis of the SICK encoders.
    pub sick_axis: sick::SickAxis,
    /// At the hooks of the AFS60 and AFM60.
    pub afx60: sick::Afx60,
}

impl Deviations {
    /// Attaches all of them; a device is built with the result.
    pub fn attached(mut self) -> DeviceDeviations {
        // All others see the idents of the manual's tables.
        if !self.idents.is_empty() {
            let mask = self.idents;
            self.stack.plugs(move |plugs| plugs.iter_mut().for_each(|plug| mask.apply(plug)));
            self.encoder.add_first(idents::OwnIdents(mask));
        }
        // All others see the start parameters at the places of the device.
        if let Some((table, layout)) = self.start_layout {
            layout.attach(table, &mut self.encoder, &mut self.slave);
        }
        // They act last, on the frames as all others have made them.
        if !self.late.is_empty() {
            self.stack.add(self.late);
        }
        DeviceDeviations {
            encoder: EncoderDeviations {
                checks: AttachedChecks(self.checks.attached()),
                hooks: self.encoder.attached(),
                measuring: self.measuring.attached(),
                velocity: self.velocity.attached(),
                telegram: self.telegram.attached(),
                trigger: self.trigger.attached(),
                life_sign: self.life_sign.attached(),
                start: self.start.attached(),
            },
            stack: self.stack.attached(),
            slave: self.slave.attached(),
            web: lika_xac77::hooks::WebDeviations(self.web.attached()),
            sick: of_sick::hooks::SickDeviations { seams: self.sick.attached(), steps: self.sick_axis.attached() },
            a3m60: sick_a3m60::hooks::A3m60Deviations(self.a3m60.attached()),
            afx60: sick_afx60::hooks::Afx60Deviations(self.afx60.attached()),
            amt58: self.amt58.attached(),
        }
    }
}
