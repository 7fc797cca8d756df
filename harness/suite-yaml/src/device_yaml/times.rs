//! `timing`, `tolerance` and `printed`: what is ours, and what the manual prints.

use super::super::error::{Mistake, Read};
use super::super::keys::{Key, Keyed};
use super::super::yaml::Node;
use super::{DeviceReader, device, label, plain, whole};
use expression::{DurationLiteral, Number, Value};
use std::time::Duration;
use suite::device::{DeviceTiming, OurSpan, PATIENCE, PrintedSpan, STANDARD_TIMES};

key_set! {
    pub(crate) ours "a time or tolerance of ours" {
        is must Quantity, "The time or the number.";
        why may FilledText, "Why it is so.";
    }
}

key_set! {
    pub(crate) printed "a time or tolerance that the manual prints" {
        is must PerVariant(&Quantity), "The time or the number, one or one for each variant.";
        cites must FilledText, "The clause.";
    }
}

/// The cycle of connections where neither the case nor the bench says one.
const CYCLE: Duration = Duration::from_millis(4);
/// The key of the factor among the times of ours.
const FACTOR: &str = "patience";
/// The largest factor.
const MOST_PATIENCE: u32 = 1000;

/// What is ours because no manual prints it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum OurKind {
    /// A duration, in `timing`.
    Time,
    /// A number, in `tolerance`.
    Tolerance,
}

impl OurKind {
    /// The word for people.
    pub fn word(self) -> &'static str {
        match self {
            OurKind::Time => "time",
            OurKind::Tolerance => "tolerance",
        }
    }
}

/// A time or tolerance of ours.
///
/// Fails also if it is negative.
pub fn our_value(node: &Node, kind: OurKind) -> Read<Value> {
    let value = quantity(node)?;
    match (&value, kind) {
        (Value::Number(_), OurKind::Time) => {
            Err(node.wrong("a time has a unit").help("write it as 100ms, or as a number in `tolerance`"))
        }
        (Value::Time(_) | Value::Cycles(_), OurKind::Tolerance) => {
            Err(node.wrong("a tolerance is a number").help("a time of ours stands in `timing`"))
        }
        _ => Ok(value),
    }
}

/// The factor of `timing`: how many times a limit of ours something may take and is only noted.
pub fn patience(node: &Node) -> Read<u32> {
    match whole::<u32>(node, "patience")? {
        factor @ 1..=MOST_PATIENCE => Ok(factor),
        _ => Err(node.wrong(format!("the factor `{FACTOR}` is 1 to {MOST_PATIENCE}"))),
    }
}

/// A duration, a number of cycles, or a number.
fn quantity(node: &Node) -> Read<Value> {
    let text = plain(node, "a time or a number")?;
    let value = match expression::number(text) {
        Ok(number) => Value::Number(number),
        Err(no_number) => match expression::duration(text) {
            Ok(DurationLiteral::Time(time)) => Value::nanos(i128::try_from(time.as_nanos()).unwrap_or(i128::MAX)),
            Ok(DurationLiteral::Cycles(cycles)) => Value::Cycles(Number::whole(cycles.into())),
            Err(no_time) => {
                let error = if text.ends_with(|c: char| c.is_ascii_alphabetic()) { no_time } else { no_number };
                return Err(Mistake::expression(node.spot, 0, text, error));
            }
        },
    };
    match value {
        Value::Number(number) if number < Number::ZERO => Err(node.wrong("this cannot be negative")),
        value => Ok(value),
    }
}

impl DeviceReader<'_> {
    pub(super) fn timing(&mut self) -> DeviceTiming {
        let (ours, patience) = self.times_of_ours();
        let tolerances = self.ours(&device::tolerance, OurKind::Tolerance);
        DeviceTiming { ours, patience, tolerances, printed: self.printed(), cycle: CYCLE, watchdog: None }
    }

    /// The times of `timing`, after those that every manual has, and the factor.
    fn times_of_ours(&mut self) -> (Vec<OurSpan>, u32) {
        let standard = |&(name, millis, _): &(&str, u64, &str)| OurSpan {
            name: name.to_owned(),
            value: Value::nanos(i128::from(millis) * 1_000_000),
            why: None,
        };
        let mut list: Vec<OurSpan> = STANDARD_TIMES.iter().map(standard).collect();
        let factor = self.top.get(&device::timing).and_then(|timing| timing.get(FACTOR));
        let factor = factor.and_then(|node| self.mistakes.keep(patience(node)));
        for own in self.ours(&device::timing, OurKind::Time) {
            match list.iter_mut().find(|known| known.name == own.name) {
                Some(known) => *known = own,
                None => list.push(own),
            }
        }
        (list, factor.unwrap_or(PATIENCE))
    }

    /// The entries of `timing` or `tolerance`.
    fn ours(&mut self, key: &Key, kind: OurKind) -> Vec<OurSpan> {
        let mut list = Vec::new();
        for (name, node) in self.entries(key) {
            if name == FACTOR && kind == OurKind::Time {
                continue;
            }
            let read = label(node, name).and_then(|()| our_span(name, node, kind));
            let Some(span) = self.mistakes.keep(read) else { continue };
            if kind == OurKind::Tolerance || STANDARD_TIMES.iter().all(|(standard, ..)| *standard != name) {
                self.declare(kind.word(), name, node.spot);
            }
            list.push(span);
        }
        list
    }

    fn printed(&mut self) -> Vec<PrintedSpan> {
        let mut list = Vec::new();
        for (name, node) in self.entries(&device::printed) {
            let read = label(node, name).and_then(|()| {
                let keyed = Keyed::new(node, &printed::KEYS)?;
                let values = self.per_variant(keyed.must(&printed::is)?, |node, _| quantity(node))?;
                Ok(PrintedSpan {
                    name: name.to_owned(),
                    values,
                    cites: keyed.must(&printed::cites)?.text("cites")?.to_owned(),
                })
            });
            let Some(span) = self.mistakes.keep(read) else { continue };
            self.declare("printed value", name, node.spot);
            list.push(span);
        }
        list
    }
}

/// `NAME: 250ms`, or `NAME: { is: 250ms, why: "..." }`.
fn our_span(name: &str, node: &Node, kind: OurKind) -> Read<OurSpan> {
    let (value, why) = match node.mapping() {
        None => (node, None),
        Some(_) => {
            let keyed = Keyed::new(node, &ours::KEYS)?;
            let why = keyed.get(&ours::why).map(|why| why.text("why")).transpose()?;
            (keyed.must(&ours::is)?, why.map(str::to_owned))
        }
    };
    Ok(OurSpan { name: name.to_owned(), value: our_value(value, kind)?, why })
}
