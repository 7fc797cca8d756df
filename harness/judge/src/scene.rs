//! What there is to see for one trial or one pair of stations: a connection after the other, and what is known besides.

use super::follow::Follower;
use super::image::Happening;
use super::settled::Settled;
use super::view::{Notebook, View};
use super::{Tick, TickKind};
use station::Time;
use suite::device::Device;
use suite::model::{Manual, Variant};

/// The names of a variant over the connections that are followed.
#[derive(Clone, Debug)]
pub struct Scene<'a> {
    /// The device description.
    pub device: &'a Device,
    /// The variant whose names are asked for.
    pub variant: &'a Variant,
    /// The connection that is followed.
    pub follower: Follower,
    notebook: Notebook,
    settled: Settled,
}

impl<'a> Scene<'a> {
    /// Nothing was seen yet.
    pub fn new(manual: &'a Manual, variant: &'a Variant) -> Scene<'a> {
        let device: &Device = &manual.device;
        let (notebook, settled) = (Notebook::default(), Settled::default());
        Scene { device, variant, follower: Follower::new(device), notebook, settled }
    }

    /// What is known besides; nothing on a capture.
    pub fn notebook(&self) -> &Notebook {
        &self.notebook
    }

    /// What is known besides, to be written.
    pub fn notebook_mut(&mut self) -> &mut Notebook {
        self.notebook.is_written();
        &mut self.notebook
    }

    /// The names at an instant.
    pub fn view(&self, tick: Tick) -> View<'_> {
        let Scene { device, variant, follower, notebook, settled } = self;
        View { device, variant, image: &follower.image, notebook, tick, reads: None, settled: Some(settled) }
    }

    /// The names at a time at which no frame came.
    pub fn view_at(&self, time: Time, frame: u64) -> View<'_> {
        self.view(Tick { time, frame, kind: TickKind::Event })
    }

    /// Ends the instant of an event: it is true at one instant only.
    pub fn end_of(&mut self, tick: Tick) {
        if tick.kind == TickKind::Event {
            self.follower.image.happening = Happening::Nothing;
        }
    }
}
