//! The result of a comparison of a capture with another device, as plain data and as text. Its JSON form is part of the contract
//! of the replay report.
//!
//! The `compare` crate fills it in; this module must not know how anything is compared.

use serde::Serialize;
use std::collections::BTreeMap;
use std::fmt::{self, Write as _};

/// The result of a comparison of a capture with a device.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct AgainstReport {
    /// The device, as the command line names it.
    pub against: String,
    /// The differences between the recorded device and this one, in the order of the capture; the first of a name in each step.
    pub differences: Vec<DifferenceReport>,
    /// Number of controller steps taken from the capture.
    pub steps: usize,
    /// Actions of the controller that were not repeated, by frame.
    pub left_out: Vec<LeftOutReport>,
    /// Names that were not compared, each with the reason.
    pub masked: BTreeMap<String, String>,
    /// How the shaft was driven, since no capture shows it.
    pub shaft: String,
    /// Why nothing could be compared; `None` if something was.
    pub inconclusive: Option<String>,
}

/// A difference between two devices.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct DifferenceReport {
    /// The packet of the capture, from 1; 0 if only the other device did something.
    pub frame: u64,
    /// The byte of the packet, from 0; `None` if the name is not cyclic data, or the capture has no packet of it.
    pub octet: Option<usize>,
    /// The bit of that byte if the difference is a single one, 0 is the least significant.
    pub bit: Option<u8>,
    /// A Wireshark display filter that finds the packet; `None` on PROFIBUS, which Wireshark does not read.
    pub filter: Option<String>,
    /// Seconds since the first frame of the capture.
    pub at: f64,
    /// The name from the manual, or the request.
    pub name: String,
    /// `answer`, `input`, `event` or `step`.
    pub kind: &'static str,
    /// The recorded value; `None` for nothing.
    pub recorded: Option<String>,
    /// The value of the device that is compared.
    pub ours: Option<String>,
    /// The requirement that most cases with this name cover; a hint, not a verdict.
    pub requirement: Option<String>,
    /// A cause that the capture does not show and that could explain it: a permitted variation, the power, the stand, the shaft.
    pub explained: Option<String>,
}

/// An action of the controller that was not repeated.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct LeftOutReport {
    /// The packet, from 1.
    pub frame: u64,
    /// What the controller did.
    pub what: String,
    /// Whether the answers of the device may depend on it, so that they are not compared.
    pub matters: bool,
}

/// The report for the console.
impl fmt::Display for AgainstReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut out = String::new();
        writeln!(out, "\n  against {}: {} controller steps repeated", self.against, self.steps)?;
        writeln!(out, "    shaft: {}", self.shaft)?;
        for left in &self.left_out {
            let so = if left.matters { "; later answers of the device are not compared" } else { "" };
            writeln!(out, "    not repeated: frame {}: {}{so}", left.frame, left.what)?;
        }
        for (name, why) in &self.masked {
            writeln!(out, "    not compared: {name}: {why}")?;
        }
        match (&self.inconclusive, self.differences.first()) {
            (Some(why), _) => writeln!(out, "    no result: {why}")?,
            (None, None) => writeln!(out, "    no difference")?,
            (None, Some(first)) => {
                let unexplained = self.differences.iter().filter(|of| of.explained.is_none()).count();
                let what = match self.differences.len() {
                    1 => "one difference:".to_owned(),
                    many => format!("{many} differences; the first is"),
                };
                let explained = match self.differences.len() - unexplained {
                    0 => String::new(),
                    some => format!("; a cause that the capture does not show could explain {some} of them"),
                };
                writeln!(out, "    {what} {} in frame {}{explained}", first.name, first.frame)?;
            }
        }
        let nothing = || "nothing".to_owned();
        for of in &self.differences {
            let place = match (of.octet, of.bit) {
                (Some(octet), Some(bit)) => format!(" [byte {octet} bit {bit}]"),
                (Some(octet), None) => format!(" [byte {octet}]"),
                _ => String::new(),
            };
            let requirement = of.requirement.as_ref().map_or(String::new(), |id| format!(" (see {id})"));
            let (recorded, ours) =
                (of.recorded.clone().unwrap_or_else(nothing), of.ours.clone().unwrap_or_else(nothing));
            writeln!(
                out,
                "  {:>7} {:>14.6}  {}{place}: recorded {recorded}, this device {ours}{requirement}",
                of.frame, of.at, of.name
            )?;
            if let Some(explained) = &of.explained {
                writeln!(out, "{:26}could be explained by {explained}", "")?;
            }
        }
        f.write_str(&out)
    }
}
