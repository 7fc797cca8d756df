//! The observed state for one trial or one pair of stations: consecutive connections and values outside of them.

use super::follow::Follower;
use super::image::Happening;
use super::settled::Settled;
use super::view::{Notebook, View};
use super::{Tick, TickKind};
use station::Time;
use suite::device::Device;
use suite::model::{Manual, Variant};

/// The observed state from which views of the names of a variant are made.
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    pub device: &'a Device,
    /// The variant that defines the names.
    pub variant: &'a Variant,
    /// The followed connection.
    pub follower: Follower,
    notebook: Notebook,
    settled: Settled,
}

impl<'a> Scene<'a> {
    /// The state before the first observation.
    pub fn new(manual: &'a Manual, variant: &'a Variant) -> Scene<'a> {
        let device: &Device = &manual.device;
        let (notebook, settled) = (Notebook::default(), Settled::default());
        Scene { device, variant, follower: Follower::new(device), notebook, settled }
    }

    /// The values that are not part of the connection; empty for a capture.
    pub fn notebook(&self) -> &Notebook {
        &self.notebook
    }

    /// The values that are not part of the connection, mutable.
    pub fn notebook_mut(&mut self) -> &mut Notebook {
        self.notebook.is_written();
        &mut self.notebook
    }

    /// The values of the names at a tick.
    pub fn view(&self, tick: Tick) -> View<'_> {
        let Scene { device, variant, follower, notebook, settled } = self;
        View { device, variant, image: &follower.image, notebook, tick, reads: None, settled: Some(settled) }
    }

    /// The values of the names at a time without a frame.
    pub fn view_at(&self, time: Time, frame: u64) -> View<'_> {
        self.view(Tick { time, frame, kind: TickKind::Event })
    }

    /// Ends the instant of an event.
    pub fn end_of(&mut self, tick: Tick) {
        if tick.kind == TickKind::Event {
            self.follower.image.happening = Happening::Nothing;
        }
    }
}
