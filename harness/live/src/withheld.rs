//! Frames that a filter before a wire or a bus withheld.

/// Number of withheld frames, and the reason of the first.
#[derive(Clone, Debug, Default)]
pub struct WithheldFrames {
    frames: u64,
    first: Option<String>,
    /// The first frame that was meant for the device.
    withheld: Option<String>,
}

impl WithheldFrames {
    /// Counts a withheld frame with its reason; `of_device` says whether it was meant for the device under test.
    pub fn count(&mut self, why: String, of_device: bool) {
        self.frames += 1;
        if of_device {
            self.withheld.get_or_insert_with(|| why.clone());
        }
        self.first.get_or_insert(why);
    }

    /// The withheld frames as text: their number, and the reason of the first.
    pub fn summary(&self) -> Option<String> {
        let first = self.first.as_ref()?;
        Some(format!("{} frame(s) of the harness were withheld; the first: {first}", self.frames))
    }

    /// The first frame withheld from the device, for instance for lack of consent: its silence then proves nothing.
    pub fn withheld(&self) -> Option<&str> {
        self.withheld.as_deref()
    }
}
