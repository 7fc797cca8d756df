//! The entries of a capture report for differences and for actions that were left out.

use super::compare::{Difference, DifferenceKind};
use super::conversation::{RecordedConversation, SkippedAction, SuiteValue};
use super::extract::ManualVariant;
use replay::{DifferenceReport, LeftOutReport};
use std::collections::BTreeMap;
use suite::model::Manual;

/// The report entry for an action that was not repeated.
pub fn left_out(of: &SkippedAction) -> LeftOutReport {
    LeftOutReport { frame: of.frame, what: of.what.clone(), matters: of.since.is_some() }
}

/// The report entry for a difference whose first side is the capture.
pub fn difference(
    whom: ManualVariant<'_>,
    conversation: &RecordedConversation,
    difference: &Difference,
) -> DifferenceReport {
    let ManualVariant { manual, variant } = whom;
    let text = |value: &Option<SuiteValue>| value.as_ref().map(ToString::to_string);
    let number = |value: &Option<SuiteValue>| value.as_ref().and_then(|value| value.number);
    let requirement = related(manual, variant, &difference.name);
    let requirement = requirement.and_then(|index| manual.requirements.get(index)).map(|of| of.id.clone());
    let has_frame = difference.frame > 0;
    let track = conversation
        .conversation
        .tracks
        .get(&difference.name)
        .filter(|_| difference.kind == DifferenceKind::Input && has_frame);
    let stands = track.and_then(|track| track.stands);
    let place = stands.map(|stands| stands.differs(number(&difference.first), number(&difference.second)));
    let filter = || format!("frame.number == {}", difference.frame);
    DifferenceReport {
        frame: difference.frame,
        octet: place.map(|(octet, _)| octet),
        bit: place.and_then(|(_, bit)| bit),
        filter: (has_frame && manual.device.profinet().is_some()).then(filter),
        at: difference.at.since(conversation.begin).as_secs_f64(),
        name: difference.name.clone(),
        kind: match difference.kind {
            DifferenceKind::Answer => "answer",
            DifferenceKind::Input => "input",
            DifferenceKind::Event => "event",
            DifferenceKind::Step => "step",
        },
        recorded: text(&difference.first),
        ours: text(&difference.second),
        requirement,
        explained: None,
    }
}

/// The requirement that trials with this name in their steps cover most often; the first of several.
pub fn related(manual: &Manual, variant: usize, name: &str) -> Option<usize> {
    let mut counted: BTreeMap<usize, usize> = BTreeMap::new();
    for trial in manual.variants.get(variant).map_or(&[][..], |variant| &variant.trials) {
        let is_named = trial.how().steps.iter().any(|step| step.text.contains(name));
        for covered in trial.covers.iter().filter(|_| is_named) {
            *counted.entry(*covered).or_default() += 1;
        }
    }
    counted.into_iter().max_by_key(|(index, count)| (*count, std::cmp::Reverse(*index))).map(|(index, _)| index)
}
