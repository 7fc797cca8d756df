//! The observed state for one trial or one pair of stations: consecutive connections and values outside of them.

use super::follow::Follower;
use super::image::CurrentEvent;
use super::parameter_cache::ParameterCache;
use super::view::{NameView, TrialValues};
use super::{JudgeTick, TickKind};
use station::Time;
use suite::device::DeviceDescription;
use suite::model::{Manual, SuiteVariant};

/// The observed state from which views of the names of a variant are made.
#[derive(Clone, Debug)]
pub struct ObservedState<'a> {
    pub device: &'a DeviceDescription,
    /// The variant that defines the names.
    pub variant: &'a SuiteVariant,
    /// The followed connection.
    pub follower: Follower,
    notebook: TrialValues,
    settled: ParameterCache,
}

impl<'a> ObservedState<'a> {
    /// The state before the first observation.
    pub fn new(manual: &'a Manual, variant: &'a SuiteVariant) -> ObservedState<'a> {
        let device: &DeviceDescription = &manual.device;
        let (notebook, settled) = (TrialValues::default(), ParameterCache::default());
        ObservedState { device, variant, follower: Follower::new(device), notebook, settled }
    }

    /// The values that are not part of the connection; empty for a capture.
    pub fn notebook(&self) -> &TrialValues {
        &self.notebook
    }

    /// The values that are not part of the connection, mutable.
    pub fn notebook_mut(&mut self) -> &mut TrialValues {
        self.notebook.is_written();
        &mut self.notebook
    }

    /// The values of the names at a tick.
    pub fn view(&self, tick: JudgeTick) -> NameView<'_> {
        let ObservedState { device, variant, follower, notebook, settled } = self;
        NameView { device, variant, image: &follower.image, notebook, tick, reads: None, settled: Some(settled) }
    }

    /// The values of the names at a time without a frame.
    pub fn view_at(&self, time: Time, frame: u64) -> NameView<'_> {
        self.view(JudgeTick { time, frame, kind: TickKind::Event })
    }

    /// Ends the instant of an event.
    pub fn end_of(&mut self, tick: JudgeTick) {
        if tick.kind == TickKind::Event {
            self.follower.image.happening = CurrentEvent::Nothing;
        }
    }
}
