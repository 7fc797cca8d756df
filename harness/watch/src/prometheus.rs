//! The counts in the text format of Prometheus (version 0.0.4).

use crate::counts::{DirectionCounts, JITTER_LIMITS_US, WatchCounts};
use std::fmt::Write as _;

/// A metric: its name, type, help, and its samples with labels and value.
struct Metric<'t> {
    text: &'t mut String,
    name: &'static str,
}

impl<'t> Metric<'t> {
    fn new(text: &'t mut String, name: &'static str, kind: &str, help: &str) -> Metric<'t> {
        let _ = writeln!(text, "# HELP {name} {help}\n# TYPE {name} {kind}");
        Metric { text, name }
    }

    fn sample(&mut self, labels: &str, value: impl std::fmt::Display) -> &mut Metric<'t> {
        let _ = match labels {
            "" => writeln!(self.text, "{} {value}", self.name),
            _ => writeln!(self.text, "{}{{{labels}}} {value}", self.name),
        };
        self
    }
}

/// The counts as a page of metrics.
pub fn prometheus(counts: &WatchCounts) -> String {
    let mut text = String::new();
    let totals = [
        ("encspec_frames_total", "counter", "Frames received.", Some(counts.frames)),
        (
            "encspec_wire_bytes_total",
            "counter",
            "Bytes on the wire, with preamble and gap of Ethernet.",
            Some(counts.wire_octets),
        ),
        ("encspec_load_bits_per_second", "gauge", "Load over the last second.", Some(counts.load)),
        ("encspec_unreadable_frames_total", "counter", "Frames that cannot be read.", Some(counts.unreadable)),
        (
            "encspec_kernel_lost_frames_total",
            "counter",
            "Frames that the kernel dropped; not judged.",
            Some(counts.lost_by_kernel),
        ),
        (
            "encspec_unjudged_frames_total",
            "counter",
            "Frames kept but not judged, since the watch was behind.",
            Some(counts.not_judged),
        ),
        (
            "encspec_ring_lost_frames_total",
            "counter",
            "Frames judged but missing in the ring.",
            Some(counts.lost_by_ring),
        ),
        (
            "encspec_nic_transmitted_frames",
            "gauge",
            "Frames the interface transmitted since the start; 0 at a tap.",
            counts.transmitted,
        ),
        ("encspec_incidents_total", "counter", "Incidents saved.", Some(counts.incidents)),
        (
            "encspec_not_passed_on_total",
            "counter",
            "Findings that a file, hook or log did not take.",
            Some(counts.not_passed_on),
        ),
    ];
    for (name, kind, help, value) in totals {
        if let Some(value) = value {
            Metric::new(&mut text, name, kind, help).sample("", value);
        }
    }
    let mut metric = Metric::new(&mut text, "encspec_findings_total", "counter", "Findings by id and severity.");
    for ((id, severity), count) in &counts.findings {
        metric.sample(&format!("id=\"{}\",severity=\"{severity}\"", escaped(id)), count);
    }
    let names: Vec<(String, &crate::counts::ConnectionCounts)> = counts
        .connections
        .iter()
        .map(|((controller, device), of)| {
            (format!("controller=\"{}\",device=\"{}\"", escaped(controller), escaped(device)), of)
        })
        .collect();
    type OfConnection = fn(&crate::counts::ConnectionCounts) -> u64;
    let of_connections: [(&'static str, &str, &str, OfConnection); 6] = [
        ("encspec_connection_up", "gauge", "Whether the connection stands.", |of| u64::from(of.is_up)),
        ("encspec_connection_starts_total", "counter", "How often it was established.", |of| of.starts),
        ("encspec_connection_releases_total", "counter", "How often it was released.", |of| of.releases),
        ("encspec_connection_aborts_total", "counter", "How often an ERR-RTA ended it.", |of| of.aborts),
        ("encspec_connection_failures_total", "counter", "How often a side fell silent or left.", |of| of.failures),
        ("encspec_connection_alarms_total", "counter", "Alarms.", |of| of.alarms),
    ];
    for (name, kind, help, value) in of_connections {
        let mut metric = Metric::new(&mut text, name, kind, help);
        for (labels, of) in &names {
            metric.sample(labels, value(of));
        }
    }
    type OfDirection = fn(&DirectionCounts) -> f64;
    let of_directions: [(&'static str, &str, &str, OfDirection); 6] = [
        ("encspec_cyclic_frames_total", "counter", "Cyclic frames.", |of| of.frames as f64),
        ("encspec_cyclic_lost_total", "counter", "Cyclic frames missing by the cycle counter.", |of| of.lost as f64),
        ("encspec_cyclic_gaps_total", "counter", "How often cyclic frames were missing.", |of| of.gaps as f64),
        ("encspec_cyclic_overtaken_total", "counter", "Cyclic frames that arrived after a later one.", |of| {
            of.overtaken as f64
        }),
        ("encspec_cyclic_status_changes_total", "counter", "Changes of the DataStatus.", |of| of.status_changes as f64),
        ("encspec_cyclic_longest_interval_seconds", "gauge", "The longest interval since the start.", |of| {
            of.longest_interval.as_secs_f64()
        }),
    ];
    for (name, kind, help, value) in of_directions {
        let mut metric = Metric::new(&mut text, name, kind, help);
        for (labels, direction, of) in directions(&names) {
            metric.sample(&format!("{labels},{direction}"), value(of));
        }
    }
    let name = "encspec_cyclic_jitter_seconds";
    let _ = writeln!(text, "# HELP {name} Deviation of the intervals from the cycle.\n# TYPE {name} histogram");
    for (labels, direction, of) in directions(&names) {
        let mut sum = 0;
        for (limit, count) in JITTER_LIMITS_US.iter().zip(of.jitter) {
            sum += count;
            let _ = writeln!(text, "{name}_bucket{{{labels},{direction},le=\"{}\"}} {sum}", *limit as f64 / 1e6);
        }
        sum += of.jitter[JITTER_LIMITS_US.len()];
        let _ = writeln!(text, "{name}_bucket{{{labels},{direction},le=\"+Inf\"}} {sum}");
        let _ = writeln!(text, "{name}_sum{{{labels},{direction}}} {}", of.jitter_sum.as_secs_f64());
        let _ = writeln!(text, "{name}_count{{{labels},{direction}}} {sum}");
    }
    text
}

fn directions<'c>(
    names: &'c [(String, &'c crate::counts::ConnectionCounts)],
) -> impl Iterator<Item = (&'c str, &'static str, &'c DirectionCounts)> {
    names.iter().flat_map(|(labels, of)| {
        let words = ["direction=\"from_device\"", "direction=\"to_device\""];
        words.into_iter().zip(&of.directions).map(move |(direction, of)| (labels.as_str(), direction, of))
    })
}

/// A label value with backslash, quote and line feed escaped.
fn escaped(value: &str) -> String {
    value.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n")
}
