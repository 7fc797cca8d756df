//! Damage of a file: where it is, and what it means for the frames and findings.

use crate::report::DamageReport;
use virtual_wire::capture::{Damage, DamageEffect};

/// Upper limit of the damages that are listed one by one; the rest is counted.
const MOST: usize = 1_000;

/// The damage of one file.
#[derive(Debug, Default)]
pub struct DamageList {
    list: Vec<DamageReport>,
    /// The first damage in the list with no frame after it yet, and the number of the last frame before it.
    open: Option<(usize, u64)>,
    /// Whether frames may be missing between the last frame and the next.
    is_missing: bool,
    is_untrusted: bool,
    more: u64,
}

impl DamageList {
    /// Adds a damage found after `frames` frames.
    pub fn add(&mut self, damage: Damage, frames: u64) {
        self.is_missing |= damage.effect != DamageEffect::Corrected;
        self.is_untrusted |= damage.effect == DamageEffect::Untrusted;
        if self.list.len() >= MOST {
            self.more += 1;
            return;
        }
        let meaning = match damage.effect {
            DamageEffect::Missing => String::new(),
            DamageEffect::Corrected => "no frame is missing".to_owned(),
            DamageEffect::Untrusted => {
                "any frame before it may have other bytes than on the wire; therefore no finding of this file \
                      blames a device"
                    .to_owned()
            }
        };
        if damage.effect == DamageEffect::Missing {
            self.open.get_or_insert((self.list.len(), frames));
        }
        self.list.push(DamageReport { at: damage.at, what: damage.what, meaning });
    }

    /// Whether frames may be missing before the next frame.
    pub fn is_open(&self) -> bool {
        self.is_missing
    }

    /// Frame number `next` was read.
    pub fn close(&mut self, next: u64) {
        if !std::mem::take(&mut self.is_missing) {
            return;
        }
        self.set_meaning(|last| match last {
            0 => format!("frames may be missing before frame {next}"),
            last => format!(
    "frames may be missing between frame {last} and frame {next}: rules and checks that waited there are undecided, \
     and losses there are not counted"
            ),
        });
    }

    /// Whether the bytes of all frames are in doubt.
    pub fn is_untrusted(&self) -> bool {
        self.is_untrusted
    }

    /// All damages with their meaning; the file had `frames` frames.
    pub fn end(mut self, frames: u64) -> Vec<DamageReport> {
        self.set_meaning(|_| match frames {
            0 => "no frame could be read".to_owned(),
            frames => {
                format!("the frames after frame {frames} are missing: rules and checks that waited there are undecided")
            }
        });
        if self.more > 0 {
            let at = self.list.last().map_or(0, |last| last.at);
            let what = format!("{} more damages after this one", self.more);
            self.list.push(DamageReport { at, what, meaning: "frames may be missing there as well".to_owned() });
        }
        self.list
    }

    fn set_meaning(&mut self, say: impl Fn(u64) -> String) {
        let Some((from, last)) = self.open.take() else { return };
        for damage in self.list.iter_mut().skip(from).filter(|damage| damage.meaning.is_empty()) {
            damage.meaning = say(last);
        }
    }
}
