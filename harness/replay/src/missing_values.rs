//! Values that rules need and a capture does not show: parameters written before it began, values known to a stand only.
//!
//! The values of the rules' names are sampled now and then; a name that never has a value is the reason why a rule is undecided.
//! This module must not know what a rule says.

use expression::NameValues;
use judge::TickKind;
use judge::tracked_inputs::HasInputs;
use judge::view::NameView;
use std::collections::BTreeMap;
use suite::device::{NameId, VisibleIn};
use suite::model::{SuiteRule, SuiteVariant};

/// The names in the rules of a variant, and whether each had a value at some time.
#[derive(Debug, Default)]
pub(super) struct MissingValues {
    names: BTreeMap<NameId, RuleName>,
    samples: u64,
    modules: Vec<usize>,
}

#[derive(Debug)]
struct RuleName {
    path: String,
    kind: VisibleIn,
    seen: bool,
}

impl MissingValues {
    /// No name of the rules of `variant` had a value yet.
    pub fn new(variant: &SuiteVariant) -> MissingValues {
        let mut names = BTreeMap::new();
        for rule in &variant.rules {
            rule.body.names(&mut |id| {
                names.entry(id).or_insert_with(|| {
                    let path = variant.paths.get(id.0 as usize).cloned().unwrap_or_default();
                    let kind = variant
                        .names
                        .get(id.0 as usize)
                        .map_or(VisibleIn::Elsewhere, |name| name.observability().visible);
                    RuleName { path, kind, seen: false }
                });
            });
        }
        MissingValues { names, samples: 0, modules: Vec::new() }
    }

    /// Checks some of the good samples, with growing distance.
    pub fn tick(&mut self, view: &NameView<'_>) {
        if view.tick.kind != TickKind::Sample {
            return;
        }
        self.samples += 1;
        if !self.samples.is_power_of_two() && !self.samples.is_multiple_of(65_536) {
            return;
        }
        let module = view.image.module().filter(|module| !self.modules.contains(module));
        self.modules.extend(module);
        for (id, name) in self.names.iter_mut().filter(|(_, name)| !name.seen) {
            name.seen = !view.value(*id).is_unknown();
        }
    }

    /// Why a rule was never decided.
    pub fn of(&self, rule: &SuiteRule) -> Option<String> {
        if self.samples == 0 {
            return None;
        }
        if !self.modules.is_empty() && !rule.modules.iter().any(|module| self.modules.contains(module)) {
            return None;
        }
        let mut reasons: Vec<String> = Vec::new();
        let mut unseen: BTreeMap<NameId, &RuleName> = BTreeMap::new();
        rule.body.names(&mut |id| {
            unseen.extend(self.names.get(&id).filter(|name| !name.seen).map(|name| (id, name)));
        });
        for (kind, why) in [
            (VisibleIn::Written, "was written before the capture began or never"),
            (VisibleIn::Elsewhere, "is not transmitted in any frame"),
            (VisibleIn::Cyclic, "is not in the cyclic data"),
        ] {
            let of: Vec<&str> = unseen.values().filter(|name| name.kind == kind).map(|name| &*name.path).collect();
            if !of.is_empty() {
                reasons.push(format!("{} {why}", of.join(", ")));
            }
        }
        (!reasons.is_empty()).then(|| format!("it needs values that the capture does not show: {}", reasons.join("; ")))
    }
}
