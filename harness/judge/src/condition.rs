//! Evaluates conditions: the truth of each part, expected and observed values.

use super::Truth;
use super::answer;
use super::format::plain;
use super::image::{big_endian, little_endian};
use super::page;
use super::view::NameView;
use expression::{BytePattern, CircularPosition, HistoryState, NameId, NameValues, OrderOperator, Program, Value};
use results::outcome::JudgedPart;
use suite::device::NameKind;
use suite::model::{Condition, ConditionPart, Matcher, PartTest};

/// The states of the programs of a condition; each instance of a condition has its own.
#[derive(Clone, Debug, Default)]
pub struct ConditionState {
    states: Vec<HistoryState>,
}

/// Iterates over the states of the programs in evaluation order.
struct StateCursor<'a> {
    states: &'a [HistoryState],
    next: usize,
    empty: &'a HistoryState,
}

impl<'a> StateCursor<'a> {
    fn next(&mut self) -> &'a HistoryState {
        let state = self.states.get(self.next).unwrap_or(self.empty);
        self.next += 1;
        state
    }
}

impl ConditionState {
    /// Whether the condition holds at the observation `view`.
    pub fn truth(&self, condition: &Condition, view: &NameView<'_>) -> Truth {
        let empty = HistoryState::default();
        let mut cursor = StateCursor { states: &self.states, next: 0, empty: &empty };
        condition.parts.iter().fold(Truth::True, |truth, part| truth.and(part_truth(part, view, &mut cursor)))
    }

    /// Each part with expected and observed value at the observation `view`.
    pub fn parts(&self, condition: &Condition, view: &NameView<'_>) -> Vec<JudgedPart> {
        let empty = HistoryState::default();
        let mut cursor = StateCursor { states: &self.states, next: 0, empty: &empty };
        condition.parts.iter().flat_map(|part| judged_part(part, view, &mut cursor)).collect()
    }

    /// Moves on from the observation `view` to the next one; returns whether a state has changed.
    pub fn advance(&mut self, condition: &Condition, view: &NameView<'_>) -> bool {
        let (mut index, mut changed) = (0, false);
        let states = &mut self.states;
        condition.each_program(&mut |program| {
            if program.has_history() {
                if states.len() <= index {
                    states.resize_with(index + 1, HistoryState::default);
                }
                if let Some(state) = states.get_mut(index) {
                    changed |= state.advance(program, view);
                }
            }
            index += 1;
        });
        changed
    }

    /// Clears all states, at the start of a connection.
    pub fn forget(&mut self) {
        self.states.iter_mut().for_each(HistoryState::forget);
    }
}

fn part_truth(part: &ConditionPart, view: &NameView<'_>, cursor: &mut StateCursor<'_>) -> Truth {
    match &part.test {
        PartTest::Expression(program) => known(program.truth(view, cursor.next())),
        PartTest::Name(name, matcher) => name_truth(*name, matcher, view, cursor),
    }
}

/// Compares an answer as an answer, everything else as a value.
fn name_truth(name: NameId, matcher: &Matcher, view: &NameView<'_>, cursor: &mut StateCursor<'_>) -> Truth {
    match (view.reply(name), matcher) {
        (Some(reply), Matcher::Refused(codes)) => Truth::from(answer::refuses(reply, codes)),
        (Some(reply), Matcher::Accepted) => Truth::from(*reply == answer::ReceivedReply::Accepted),
        (Some(answer::ReceivedReply::Accepted | answer::ReceivedReply::Refused(_)), Matcher::Any) => Truth::True,
        _ => matches_at(matcher, &view.value(name), view, cursor),
    }
}

fn known(truth: Option<bool>) -> Truth {
    truth.map_or(Truth::Unknown, Truth::from)
}

/// Whether `observed` matches; the matcher must not use history functions.
pub fn matches(matcher: &Matcher, seen: &Value, view: &NameView<'_>) -> Truth {
    let empty = HistoryState::default();
    matches_at(matcher, seen, view, &mut StateCursor { states: &[], next: 0, empty: &empty })
}

fn matches_at(matcher: &Matcher, seen: &Value, view: &NameView<'_>, cursor: &mut StateCursor<'_>) -> Truth {
    match matcher {
        Matcher::Equal(target) => known(target.holds(seen, view, cursor.next())),
        Matcher::In(list) => {
            let mut any = Truth::False;
            for matcher in list {
                any = !((!any).and(!matches_at(matcher, seen, view, cursor)));
            }
            any
        }
        Matcher::Range { from, to } => {
            let mut bound = |program: &Option<Program>, order: OrderOperator| {
                let Some(program) = program else { return Truth::True };
                let limit = program.eval(view, cursor.next());
                let noise = if matches!(seen, Value::Place(_)) { view.position_noise() } else { 0 };
                known(expression::order(order, seen, &limit, noise))
            };
            let low = bound(from, OrderOperator::GreaterEqual);
            low.and(bound(to, OrderOperator::LessEqual))
        }
        Matcher::Not(matcher) => !matches_at(matcher, seen, view, cursor),
        _ if seen.is_unknown() => Truth::Unknown,
        Matcher::Any => Truth::True,
        Matcher::Word(word) => Truth::from(matches!(seen, Value::Text(text) if **text == **word)),
        Matcher::Bytes(pattern) => match seen {
            Value::Bytes(bytes) => Truth::from(pattern.matches(bytes) || matches_with_noise(pattern, bytes, view)),
            _ => Truth::False,
        },
        Matcher::Contains(texts) => Truth::from(texts.iter().all(|text| page::has(seen, text))),
        Matcher::Lacks(texts) => Truth::from(page::lacks(seen, texts)),
        Matcher::Set(words) => {
            let table = view.device.profibus().and_then(|slave| Some(&slave.diagnosis.blocks.as_ref()?.table));
            let wanted =
                table.and_then(|table| words.iter().map(|word| table.number(word)).collect::<Option<Vec<_>>>());
            Truth::from(wanted.is_some_and(|wanted| *seen == Value::set(wanted)))
        }
        Matcher::Refused(_) | Matcher::Accepted => Truth::False,
    }
}

/// Whether `bytes` match if each position that the pattern names may differ by the noise of the bench.
fn matches_with_noise(pattern: &BytePattern, bytes: &[u8], view: &NameView<'_>) -> bool {
    let noise = view.position_noise();
    if noise == 0 {
        return false;
    }
    let mut steady = bytes.to_vec();
    for (name, first, expected) in pattern.fixed_groups() {
        let Some(observed) = steady.get_mut(first..first + expected.len()) else { return false };
        if is_same_position(name, (&expected, observed), view) {
            observed.copy_from_slice(&expected);
        }
    }
    pattern.matches(&steady)
}

/// Whether both are the same position of the signal `name`, but for the noise of the bench. Bits below the lowest step are the same.
fn is_same_position(name: &str, (expected, observed): (&[u8], &[u8]), view: &NameView<'_>) -> bool {
    let is_named = |signal: usize| {
        let known = view.device.signals.get(signal);
        known.is_some_and(|signal| signal.name == name && signal.width as usize == expected.len() * 8)
    };
    let found = view.variant.names.iter().enumerate().find_map(|(index, kind)| match kind {
        NameKind::Signal { signal, field: None, circle: Some(_), shift, .. } if is_named(*signal) => {
            Some((NameId(u32::try_from(index).ok()?), *shift, view.image.is_little_endian(*signal)))
        }
        _ => None,
    });
    let Some((name, shift, is_little_endian)) = found else { return false };
    let number = if is_little_endian { little_endian } else { big_endian };
    let (expected, observed) = (number(expected), number(observed));
    let Value::Place(place @ CircularPosition { is_code: false, .. }) = view.value(name) else { return false };
    let same_rest = (expected ^ observed) & ((1 << shift) - 1) == 0;
    let expected = Value::place(expected >> shift, place.steps());
    let observed = Value::place(observed >> shift, place.steps());
    same_rest && expression::equal(&observed, &expected, None, view.position_noise()) == Some(true)
}

fn judged_part(part: &ConditionPart, view: &NameView<'_>, cursor: &mut StateCursor<'_>) -> Vec<JudgedPart> {
    match &part.test {
        PartTest::Expression(program) => {
            let state = cursor.next();
            program
                .explain(view, state)
                .into_iter()
                .map(|part| JudgedPart {
                    held: part.truth == Some(true),
                    expected: "true".into(),
                    observed: observed_text(&part),
                    text: part.text,
                })
                .collect()
        }
        PartTest::Name(name, matcher) => {
            let seen = view.value(*name);
            let at = cursor.next;
            let held = name_truth(*name, matcher, view, cursor) == Truth::True;
            cursor.next = at;
            let wanted = expected(matcher, Some(*name), view, cursor);
            let seen = view.reply(*name).map_or_else(
                || named_octets(matcher, &seen).unwrap_or_else(|| view.show(*name, &seen)),
                ToString::to_string,
            );
            vec![JudgedPart { text: part.text.clone(), expected: wanted, observed: seen, held }]
        }
    }
}

/// The octets of `value` with the names that the matcher gives them; none if it gives none.
pub fn named_octets(matcher: &Matcher, value: &Value) -> Option<String> {
    match (matcher, value) {
        (Matcher::Bytes(pattern), Value::Bytes(octets)) if pattern.is_named() => Some(pattern.named(octets)),
        (Matcher::In(list), _) => named_octets(list.first()?, value),
        (Matcher::Not(inner), _) => named_octets(inner, value),
        _ => None,
    }
}

fn observed_text(part: &expression::ExplainedPart) -> String {
    let truth = part.truth.map_or("unknown", |truth| if truth { "true" } else { "false" });
    let operands: Vec<String> =
        part.operands.iter().map(|operand| format!("{} = {}", operand.text, operand.value)).collect();
    if operands.is_empty() { truth.into() } else { format!("{truth} ({})", operands.join(", ")) }
}

/// Formats the expected value of a matcher.
pub fn expected_text(matcher: &Matcher, view: &NameView<'_>) -> String {
    let empty = HistoryState::default();
    expected(matcher, None, view, &mut StateCursor { states: &[], next: 0, empty: &empty })
}

/// Formats the expected value of a matcher for a name.
pub fn expected_of(matcher: &Matcher, name: NameId, view: &NameView<'_>) -> String {
    let empty = HistoryState::default();
    expected(matcher, Some(name), view, &mut StateCursor { states: &[], next: 0, empty: &empty })
}

fn expected(matcher: &Matcher, name: Option<NameId>, view: &NameView<'_>, cursor: &mut StateCursor<'_>) -> String {
    let show = |value: &Value| match name {
        Some(name) => view.show(name, value),
        None => plain(value),
    };
    match matcher {
        Matcher::Equal(target) => {
            let state = cursor.next();
            let center = show(&target.center().eval(view, state));
            match target.tolerance(view, state) {
                Some(tolerance) => format!("{center} +/- {}", plain(&tolerance)),
                None => center,
            }
        }
        Matcher::In(list) => {
            let list: Vec<String> = list.iter().map(|matcher| expected(matcher, name, view, cursor)).collect();
            format!("one of {}", list.join(", "))
        }
        Matcher::Range { from, to } => {
            let mut bound = |program: &Option<Program>, word: &str| {
                program.as_ref().map(|program| format!("{word} {}", show(&program.eval(view, cursor.next()))))
            };
            let ends = [bound(from, "from"), bound(to, "to")];
            ends.into_iter().flatten().collect::<Vec<_>>().join(" ")
        }
        Matcher::Not(matcher) => format!("anything but {}", expected(matcher, name, view, cursor)),
        Matcher::Word(word) => word.clone(),
        Matcher::Set(words) => format!("[{}]", words.join(", ")),
        Matcher::Bytes(pattern) => pattern.to_string(),
        Matcher::Any => "anything".into(),
        Matcher::Contains(texts) => format!("all of {}", quoted(texts)),
        Matcher::Lacks(texts) => format!("none of {}", quoted(texts)),
        Matcher::Accepted => "accepted".into(),
        Matcher::Refused(codes) => answer::refused(codes),
    }
}

fn quoted(texts: &[String]) -> String {
    texts.iter().map(|text| format!("'{text}'")).collect::<Vec<_>>().join(", ")
}
