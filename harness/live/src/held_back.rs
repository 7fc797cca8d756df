//! Frames of ours that did not go: what a fence before a wire or a bus keeps of them.

/// How many frames were held back, and why the first.
#[derive(Clone, Debug, Default)]
pub struct HeldBack {
    frames: u64,
    first: Option<String>,
    /// The first that was meant for the device.
    withheld: Option<String>,
}

impl HeldBack {
    /// Counts a frame that does not go, and why; `of_device` says whether it was meant for the device under test.
    pub fn count(&mut self, why: String, of_device: bool) {
        self.frames += 1;
        if of_device {
            self.withheld.get_or_insert_with(|| why.clone());
        }
        self.first.get_or_insert(why);
    }

    /// What was held back: how many frames, and why the first.
    pub fn told(&self) -> Option<String> {
        let first = self.first.as_ref()?;
        Some(format!("{} frame(s) of ours were held back; the first: {first}", self.frames))
    }

    /// What the device was to get and did not, for instance for want of consent: its silence then says nothing.
    pub fn withheld(&self) -> Option<&str> {
        self.withheld.as_deref()
    }
}
