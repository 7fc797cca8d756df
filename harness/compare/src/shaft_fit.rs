//! Drives a device with the controller side of a capture and with the shaft as it was recorded, and compares the conversations.

use super::action::ControllerAction;
use super::compare::{Difference, DifferenceKind, compare, every, firsts};
use super::conversation::{Conversation, SuiteValue, TrackChange};
use super::drive::{CannotDrive, ScriptBench};
use super::masks::Masks;
use super::shaft_dependence::{ShaftDependence, UNKNOWN};
use super::shaft_motion::{ShaftMotion, adapt};
use super::shaft_position::{self, set_shaft};
use super::timed_script::TimedScript;
use engine::DutSpec;
use station::Time;

/// Two runs have the same difference if its times are within this many tolerances.
const NEAR: u32 = 4;
/// Upper limit of the differences of a turning shaft that are checked one by one.
const MOST_LOOKED_AT: usize = 5_000;

/// Whether a difference counts: actions of the harness's own controller say nothing about a device, and nothing counts after actions that
/// cannot be repeated.
pub(super) fn counts(recorded: &Conversation, of: &Difference) -> bool {
    let depends = recorded.left_out.iter().any(|left| left.covers(of.at));
    (of.kind != DifferenceKind::Step || of.first.is_some()) && !depends
}

/// How the shaft is driven.
#[derive(Debug, Default)]
pub(super) struct ShaftFit {
    /// A sentence about it.
    pub text: String,
    /// Its first raw position, if it is known.
    pub place: Option<i128>,
    /// Its movement with the timing of the script, if it turned.
    pub turning: Option<(ShaftMotion, TimedScript)>,
    /// What depends on it, if its position is unknown.
    pub follows: Option<ShaftDependence>,
}

/// The differences of the device after a script with these steps of the stand, with the shaft position as inferred; `fit` receives how.
pub(super) fn differences(
    bench: &ScriptBench<'_>,
    dut: &DutSpec,
    recorded: &Conversation,
    (masks, stand): (&mut Masks, &[(Time, ControllerAction)]),
    fit: &mut ShaftFit,
) -> Result<Vec<Difference>, CannotDrive> {
    let mut timed = TimedScript::new(recorded);
    stand.iter().for_each(|(at, ask)| timed.insert(*at, ask.clone()));
    let plain = timed.script();
    if dut.live().is_some() {
        "unknown: encspec cannot move the shaft of a live device as it was recorded".clone_into(&mut fit.text);
        return without_shaft(bench, dut, recorded, (masks, fit), &plain);
    }
    let found = shaft_position::shaft(bench, dut, recorded, &plain, None)?;
    fit.text = found.text;
    let Some((name, place)) = found.put else {
        let others = without_shaft(bench, dut, recorded, (masks, fit), &plain)?;
        let nowhere = found.nowhere.as_ref().and_then(|nowhere| nowhere_difference(recorded, nowhere));
        return Ok(nowhere.into_iter().chain(others).collect());
    };
    match ShaftMotion::of(bench, dut, recorded, (&name, place), &plain)? {
        Err(why) => {
            fit.text = format!("unknown: {why}");
            without_shaft(bench, dut, recorded, (masks, fit), &plain)
        }
        Ok(None) => {
            fit.place = Some(place);
            let mut steps = plain;
            steps.insert(0, set_shaft(place));
            Ok(compare(recorded, &bench.drive(&steps, dut)?, masks))
        }
        Ok(Some(mut turning)) => {
            let again = shaft_position::shaft(bench, dut, recorded, &plain, Some(&turning.first()))?;
            turning.put(again.put.map_or(place, |(_, place)| place));
            adapt(bench, dut, recorded, &mut turning, &mut timed)?;
            fit.text.push_str(&turning.to_string());
            for (name, period) in masks.periods.iter().filter(|(name, _)| recorded.tracks.contains_key(*name)) {
                fit.text.push_str(&format!(
                    "; {name} is updated every {} ms and compared within that time",
                    period.as_millis()
                ));
            }
            let found = with_turning_shaft(bench, dut, recorded, &turning, &timed, masks);
            fit.turning = Some((turning, timed));
            found
        }
    }
}

/// That the device has the first recorded position nowhere is a difference, too.
fn nowhere_difference(recorded: &Conversation, (name, value, nearest): &(String, i128, i128)) -> Option<Difference> {
    let has_value = |change: &&TrackChange| change.value.as_ref().and_then(|of| of.number) == Some(*value);
    let change = recorded.tracks.get(name)?.changes.iter().find(has_value)?;
    Some(Difference {
        kind: DifferenceKind::Input,
        name: name.clone(),
        at: change.at,
        frame: change.frame,
        step: recorded.actions.iter().rposition(|asked| asked.at <= change.at),
        first: change.value.clone(),
        second: Some(SuiteValue::number(*nearest, 32, true)),
        there: (change.at, 0),
    })
}

/// The differences if the shaft position is unknown: values that depend on it are not compared.
fn without_shaft(
    bench: &ScriptBench<'_>,
    dut: &DutSpec,
    recorded: &Conversation,
    (masks, fit): (&mut Masks, &mut ShaftFit),
    steps: &[ControllerAction],
) -> Result<Vec<Difference>, CannotDrive> {
    let reference = dut.without_deviations();
    let follows = ShaftDependence::of(bench, &reference, recorded, steps)?;
    masks.names.extend(follows.names().map(|name| (name, UNKNOWN.to_owned())));
    let mut found = compare(recorded, &bench.drive(steps, dut)?, masks);
    found.retain(|of| !follows.explains(of, recorded));
    fit.follows = Some(follows);
    Ok(found)
}

/// The differences if the shaft turned. It is turned in time, a little early and a little late; a value that one of these runs has
/// as recorded, or that lies between two of them, depends on the exact position of the shaft.
fn with_turning_shaft(
    bench: &ScriptBench<'_>,
    dut: &DutSpec,
    recorded: &Conversation,
    turning: &ShaftMotion,
    timed: &TimedScript,
    masks: &mut Masks,
) -> Result<Vec<Difference>, CannotDrive> {
    masks.turned.clone_from(&turning.turned);
    masks.circle = turning.circle();
    let tolerance = masks.tolerance(recorded.cycle.unwrap_or_default());
    let window = tolerance * NEAR;
    let tolerance = i64::try_from(tolerance.as_nanos()).unwrap_or(i64::MAX);
    let mut found = every(recorded, &bench.drive(&turning.script(timed, 0), dut)?, masks);
    found.truncate(MOST_LOOKED_AT);
    if found.is_empty() {
        return Ok(found);
    }
    let mut others = Vec::new();
    for ahead in [tolerance, -tolerance] {
        others.push(every(recorded, &bench.drive(&turning.script(timed, ahead), dut)?, masks));
    }
    found.retain(|of| {
        // With another timing it may occur before or after another step.
        let same = |other: &&Difference| (other.kind, &other.name) == (of.kind, &of.name);
        let apart = |other: &&Difference| other.at.since(of.at).max(of.at.since(other.at));
        let near = |other: &&Difference| apart(other) <= window;
        let nearest = |found: &'_ Vec<Difference>| found.iter().filter(same).filter(near).min_by_key(apart).cloned();
        let Some(others) = others.iter().map(nearest).collect::<Option<Vec<_>>>() else {
            return false;
        };
        let number = |value: &Option<SuiteValue>| value.as_ref().and_then(|value| value.number);
        let values: Option<Vec<i128>> = others.iter().chain([of]).map(|of| number(&of.second)).collect();
        let between = number(&of.first).zip(values).is_some_and(|(recorded, values)| {
            let (low, high) = (values.iter().min(), values.iter().max());
            low.is_some_and(|low| *low <= recorded) && high.is_some_and(|high| recorded <= *high)
        });
        !between
    });
    Ok(firsts(found))
}
