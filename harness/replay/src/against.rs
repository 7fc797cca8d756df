//! What a comparison of a capture with another device came to, as plain data and as text; its JSON form is part of the contract of
//! the replay report.
//!
//! The `compare` crate fills it; this module must not know how anything is compared.

use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::{self, Write as _};

/// What a comparison of a capture with a device came to.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct AgainstReport {
    /// The device, as the command line names it.
    pub against: String,
    /// In what the recorded device and this one differ, in the order of the capture; the first of a name in each step.
    pub differences: Vec<DifferenceReport>,
    /// Steps of the controller that were taken from the capture.
    pub steps: usize,
    /// What the controller did and was not done again, by frame.
    pub left_out: Vec<LeftOutReport>,
    /// Names that were not compared, each with the reason.
    pub masked: BTreeMap<String, String>,
    /// What became of the shaft, which no capture shows.
    pub shaft: String,
    /// Why nothing could be compared; none where something was.
    pub inconclusive: Option<String>,
}

/// Something in which two devices differ.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DifferenceReport {
    /// The packet of the capture, from 1; 0 where the capture has none, since only the other device did something.
    pub frame: u64,
    /// The octet of the packet, from 0; none where the name is no cyclic data, or the capture has no packet of it.
    pub octet: Option<usize>,
    /// The bit of that octet where a single one is meant, 0 is the least significant.
    pub bit: Option<u8>,
    /// A Wireshark display filter that finds the packet; none on PROFIBUS, which Wireshark does not read.
    pub filter: Option<String>,
    /// Seconds since the first frame of the capture.
    pub at: f64,
    /// The name in the words of the manual, or the request.
    pub name: String,
    /// `answer`, `input`, `event` or `step`.
    pub kind: &'static str,
    /// What was recorded; none for nothing.
    pub recorded: Option<String>,
    /// What the device shows in the same place.
    pub ours: Option<String>,
    /// The requirement that cases with this name cover most; a hint, not a verdict.
    pub requirement: Option<String>,
}

/// Something that the controller did and that was not done again.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LeftOutReport {
    /// The packet, from 1.
    pub frame: u64,
    /// What it was.
    pub what: String,
    /// Whether what the device answers may come of it, so that it is not compared.
    pub matters: bool,
}

/// The report for the console.
impl fmt::Display for AgainstReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut out = String::new();
        writeln!(out, "\n  against {}: {} steps of the controller driven again", self.against, self.steps)?;
        writeln!(out, "    shaft: {}", self.shaft)?;
        for left in &self.left_out {
            let so = if left.matters { "; what the device answers from there on is not compared" } else { "" };
            writeln!(out, "    not driven: frame {}: {}{so}", left.frame, left.what)?;
        }
        for (name, why) in &self.masked {
            writeln!(out, "    not compared: {name}: {why}")?;
        }
        match (&self.inconclusive, self.differences.first()) {
            (Some(why), _) => writeln!(out, "    nothing can be said: {why}")?,
            (None, None) => writeln!(out, "    no difference")?,
            (None, Some(first)) => {
                let what = match self.differences.len() {
                    1 => "one difference:".to_owned(),
                    many => format!("{many} differences; the first is"),
                };
                writeln!(out, "    {what} {} in frame {}", first.name, first.frame)?;
            }
        }
        let nothing = || "nothing".to_owned();
        for of in &self.differences {
            let place = match (of.octet, of.bit) {
                (Some(octet), Some(bit)) => format!(" [octet {octet} bit {bit}]"),
                (Some(octet), None) => format!(" [octet {octet}]"),
                _ => String::new(),
            };
            let requirement = of.requirement.as_ref().map_or(String::new(), |id| format!(" (see {id})"));
            let (recorded, ours) =
                (of.recorded.clone().unwrap_or_else(nothing), of.ours.clone().unwrap_or_else(nothing));
            writeln!(
                out,
                "  {:>7} {:>14.6}  {}{place}: recorded {recorded}, the device shows {ours}{requirement}",
                of.frame, of.at, of.name
            )?;
        }
        f.write_str(&out)
    }
}
