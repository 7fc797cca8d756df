//! Sequences as cases of a topic file, which anyone can run again.

use crate::sequence::SequencePart;
use compare::action::ControllerAction;
use compare::write_case::{CaseLine, unjudged};
use std::fmt::Write as _;
use suite::model::{Manual, RequirementClass};

/// The name of the topic file.
pub const TOPIC: &str = "random-sequences";

/// The id of the case of a seed.
pub fn case_id(seed: u64) -> String {
    format!("seed-{seed}")
}

/// A topic file with a case for each sequence; the number is its seed.
///
/// Whatever the device answers, the next step follows: each check has requirements of its own, and a block that expects a connection
/// allows the device to end it.
pub fn topic(manual: &Manual, sequences: &[(u64, Vec<SequencePart>)]) -> String {
    let covers = any_requirement(manual).unwrap_or_default();
    let mut out = format!("suite: {TOPIC}\ncases:\n");
    for (seed, parts) in sequences {
        let _ = writeln!(out, "  - id: {}\n    why: A random sequence.\n    start: none\n    steps:", case_id(*seed));
        for part in parts {
            let connect = ControllerAction::Connect(part.connect.clone());
            write_steps(&mut out, 6, &unjudged(&[connect], covers, &|_| false));
            let _ = writeln!(out, "      - steps:");
            let actions: Vec<ControllerAction> = part.steps.iter().map(|step| step.action.clone()).collect();
            let actions = unjudged(&actions, covers, &|_| false);
            write_steps(&mut out, 10, &actions);
            let _ = writeln!(
                out,
                "          - expect: {{ connection: data }}\n            within: 0\n            covers: [{covers}]"
            );
        }
    }
    out
}

fn write_steps(out: &mut String, indent: usize, steps: &[CaseLine]) {
    for step in steps {
        let _ = writeln!(out, "{:indent$}- {}", "", step.verb);
        for modifier in &step.modifiers {
            let _ = writeln!(out, "{:indent$}  {modifier}", "");
        }
    }
}

/// A requirement that applies to every variant.
fn any_requirement(manual: &Manual) -> Option<&str> {
    let variants = manual.device.variants.len();
    let fits =
        manual.requirements.iter().find(|of| of.class == RequirementClass::Testable && of.variants.len() == variants);
    fits.map(|of| of.id.as_str())
}
