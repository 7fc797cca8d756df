//! A comparison as JSON.

use super::{DeviceDiff, ResultChange, RunDiff};
use crate::words::printable_json;
use serde_json::{Value, json};

impl RunDiff {
    /// The comparison as JSON; keys may be added, none is renamed or removed.
    pub fn json(&self) -> String {
        let devices: Vec<Value> = self.devices.iter().map(device).collect();
        let report = json!({
            "regression": self.is_regression(),
            "devices": devices,
            "gone": self.gone,
            "added": self.added,
            "reasons": self.reasons,
            "notes": self.notes,
        });
        format!("{}\n", printable_json(&format!("{report:#}")))
    }
}

fn device(of: &DeviceDiff) -> Value {
    let facts = of.facts.iter().map(|(name, before, after)| json!({ "name": name, "before": before, "after": after }));
    let change = |ResultChange { kind, id, covers, before, after }: &ResultChange| {
        let kind = kind.heading().replace(' ', "-");
        json!({ "kind": kind, "id": id, "covers": covers, "before": before, "after": after })
    };
    let requirements = of
        .requirements
        .iter()
        .map(|(id, before, after)| json!({ "id": id, "before": before.word(), "after": after.word() }));
    json!({
        "device": of.device,
        "facts": facts.collect::<Vec<_>>(),
        "changes": of.changes.iter().map(change).collect::<Vec<_>>(),
        "requirements": requirements.collect::<Vec<_>>(),
        "new_errors": of.new_errors,
        "same": of.same,
        "left_out": of.left_out,
    })
}
