//! The JSON Schema of each shape.

use super::super::answer::{ANSWERS, CONNECTIONS, MODULE_STATES};
use super::super::dialect;
use super::super::keys::{Key, KeySet, Shape, Vocabulary};
use super::super::request_keys::{record_request, station_request};
use super::super::topic_keys::{row, takes};
use super::super::verbs::{VERBS, read_step};
use super::Definitions;
use serde_json::{Map, Value, json};

/// Letters, digits, `_` and `-`, and none of the words that YAML readers take for something else.
const LABEL: &str = "^(?!([oO][nN]|[oO][fF][fF]|[yY][eE][sS]|[nN][oO]|[tT][rR][uU][eE]|[fF][aA][lL][sS][eE]|[nN][uU][lL][lL])$)\
                     [A-Za-z][A-Za-z0-9_-]*$";
const PLAIN: &str = "^(?!([oO][nN]|[oO][fF][fF]|[yY][eE][sS]|[nN][oO]|[tT][rR][uU][eE]|[fF][aA][lL][sS][eE]|[nN][uU][lL][lL]|~)$)\
                     [\\s\\S]+$";
const TIME: &str = "^(0|[1-9][0-9]*)(\\.[0-9]+)?(ns|us|ms|s|min)$";
const DURATION: &str = "^((0|[1-9][0-9]*)(\\.[0-9]+)?(ns|us|ms|s|min)|(0|[1-9][0-9]*|0x[0-9A-Fa-f]+) cycles)$";
const OCTETS: &str = "^$|^([A-Za-z][A-Za-z0-9_.-]*: )?[0-9A-F]{2}( ([A-Za-z][A-Za-z0-9_.-]*: )?[0-9A-F]{2})*$";
/// A text that is replaced by a column or that is computed: it may stand for anything in a step.
const EXPRESSION: &str = "^\\s*=\\s*\\S";
/// Bytes of which some may be any.
const OPEN_OCTETS: &str =
    "^$|^([A-Za-z][A-Za-z0-9_.-]*: )?([0-9A-F]{2}|\\.\\.|\\*)( ([A-Za-z][A-Za-z0-9_.-]*: )?([0-9A-F]{2}|\\.\\.|\\*))*$";
/// Names whose values are bytes.
const NAMES_OF_OCTETS: &str =
    "^(io\\.(inputs|outputs)(\\..*)?|(answer|diag|cfg)\\.bytes|lldp\\.(chassis|mac|source|bytes)|station\\.mac)$";
/// The one name whose value is a set of words.
const NAME_OF_SET: &str = "^diag\\.errors$";

impl Definitions {
    /// The schema of a value; in a step each value may be an expression instead.
    pub(super) fn value(&mut self, shape: Shape, in_step: bool) -> Value {
        let schema = self.plain_value(shape, in_step);
        let holds_more =
            matches!(shape, Shape::Any | Shape::Text | Shape::FilledText | Shape::Scalar | Shape::Expression);
        match in_step && !holds_more {
            true => json!({ "anyOf": [schema, text_of(EXPRESSION)] }),
            false => schema,
        }
    }

    fn plain_value(&mut self, shape: Shape, in_step: bool) -> Value {
        match shape {
            Shape::Text => json!({ "type": ["string", "number", "boolean"] }),
            Shape::FilledText => json!({ "anyOf": [text_of("\\S"), { "type": ["number", "boolean"] }] }),
            Shape::Pattern(pattern) => text_of(pattern.regex),
            Shape::Label => text_of(LABEL),
            Shape::Name => json!({ "anyOf": [text_of(PLAIN), { "type": "number" }] }),
            Shape::Word(words) => json!({ "enum": words.words() }),
            Shape::Only(word) => json!({ "const": word }),
            Shape::Whole(least, most) => whole(least, most),
            Shape::Numbers(numbers) => json!({ "enum": numbers }),
            Shape::Number => json!({ "type": "number" }),
            Shape::Scalar | Shape::Expression => json!({ "type": ["string", "number"] }),
            Shape::Pair(least, most) => list(whole(least, most), 2, Some(2)),
            Shape::Flag => json!({ "const": true }),
            Shape::Time => json!({ "anyOf": [{ "const": 0 }, text_of(TIME)] }),
            Shape::TimeOrNone => json!({ "anyOf": [{ "const": 0 }, text_of(TIME), { "const": "none" }] }),
            Shape::Duration => json!({ "anyOf": [{ "const": 0 }, text_of(DURATION)] }),
            Shape::Quantity => json!({ "anyOf": [{ "type": "number", "minimum": 0 }, text_of(DURATION)] }),
            Shape::QuantityOr(set) => {
                let plain = self.plain_value(Shape::Quantity, in_step);
                json!({ "if": { "type": "object" }, "then": self.keys(set, in_step), "else": plain })
            }
            Shape::Octets => text_of(OCTETS),
            Shape::OctetsOrNone => json!({ "anyOf": [text_of(OCTETS), { "const": "none" }] }),
            Shape::OctetsOf(count) => text_of(&format!(
                "^([A-Za-z][A-Za-z0-9_.-]*: )?[0-9A-F]{{2}}( ([A-Za-z][A-Za-z0-9_.-]*: )?[0-9A-F]{{2}}){{{}}}$",
                count - 1
            )),
            Shape::Condition => text_of("\\S"),
            Shape::Checks => json!({ "anyOf": [text_of("\\S"), self.named("CHECKS", checks)] }),
            Shape::Any => json!({ "not": { "type": "null" } }),
            Shape::Sourced(inner) => {
                let plain = self.value(*inner, in_step);
                let mut sourced = self.keys(&super::super::device_yaml::sourced_datum::KEYS, in_step);
                sourced = json!({ "allOf": [sourced, { "properties": { "value": plain } }] });
                json!({ "if": { "type": "object" }, "then": sourced, "else": plain })
            }
            Shape::PerVariant(inner) => {
                let plain = self.value(*inner, in_step);
                let each = json!({ "type": "object", "additionalProperties": plain, "minProperties": 1 });
                json!({ "if": { "type": "object" }, "then": each, "else": plain })
            }
            Shape::List(item) => list(self.value(*item, in_step), 0, None),
            Shape::NonEmpty(item) => list(self.value(*item, in_step), 1, None),
            Shape::Between(least, most, item) => list(self.value(*item, in_step), least, Some(most)),
            Shape::Covers => {
                json!({ "anyOf": [self.plain_value(Shape::NonEmpty(&Shape::Name), in_step), { "const": "none" }] })
            }
            Shape::CoversOrCase => {
                let words = json!({ "enum": ["case", "none"] });
                json!({ "anyOf": [self.plain_value(Shape::NonEmpty(&Shape::Name), in_step), words] })
            }
            Shape::CoversApart => {
                let list = self.value(Shape::Covers, in_step);
                let apart = json!({ "type": "object", "additionalProperties": list.clone(), "minProperties": 1 });
                json!({ "if": { "type": "object" }, "then": apart, "else": list })
            }
            Shape::Map(value) => map(Some(LABEL), self.value(*value, in_step), 0, in_step),
            Shape::NonEmptyMap(value) => map(Some(LABEL), self.value(*value, in_step), 1, in_step),
            Shape::Names(value) => map(None, self.value(*value, in_step), 0, in_step),
            Shape::Keys(set) => self.keys(set, in_step),
            Shape::WordTable => map(Some(LABEL), whole(i128::from(i64::MIN), i128::from(i64::MAX)), 1, false),
            Shape::Network => json!({
                "type": "object",
                "propertyNames": { "pattern": "^(0x8[0-9A-Fa-f]{3}|3(2[89]|[3-6][0-9])[0-9]{2}|327[7-9][0-9]|3276[89])$" },
                "additionalProperties": whole(0, 0xFFFF_FFFF),
            }),
            Shape::Bits => self.bits(),
            Shape::ParameterBits => {
                let bits = self.bits();
                let named = json!({ "type": "object", "propertyNames": { "pattern": LABEL }, "minProperties": 1,
                    "additionalProperties": bits });
                let elements = json!({ "type": "object", "additionalProperties": named });
                json!({ "anyOf": [named, elements] })
            }
            Shape::Step => self.named("STEP", step),
            Shape::Start => json!({ "anyOf": [{ "const": "none" }, self.named("CONNECTION", connection)] }),
            Shape::Settings => self.named("SETTINGS", settings),
            Shape::Access => self.named("ACCESS", access),
            Shape::Written => self.named("SETTINGS", settings),
            Shape::Service => self.named("SERVICE", service),
            Shape::Answer => self.named("ANSWER", answer),
            Shape::Instead => self.named("INSTEAD", instead),
            Shape::StartInstead => self.named("START_INSTEAD", start_instead),
            Shape::Readings => self.named("READINGS", readings),
            Shape::Observation => self.named("OBSERVATION", observation),
            Shape::Table => {
                let columns = map(Some(LABEL), self.keys(&takes::KEYS, false), 1, false);
                let rows = self.value(Shape::NonEmpty(&Shape::Row), false);
                json!({ "if": { "type": "object" }, "then": columns, "else": rows })
            }
            Shape::Row => self.named("ROW", table_row),
        }
    }

    fn bits(&mut self) -> Value {
        let (bit, pair) = (whole(0, 63), list(whole(0, 63), 2, Some(2)));
        let field = self.keys(&super::super::device_yaml::field::KEYS, false);
        json!({ "if": { "type": "object" }, "then": field, "else": { "if": { "type": "array" }, "then": pair, "else": bit } })
    }

    /// The fixed properties of a set, without its closing.
    fn properties(&mut self, keys: &[&'static Key], in_step: bool) -> Map<String, Value> {
        keys.iter().map(|key| (key.name.to_owned(), self.described(key, in_step))).collect()
    }
}

fn text_of(pattern: &str) -> Value {
    json!({ "type": "string", "pattern": pattern })
}

fn whole(least: i128, most: i128) -> Value {
    // Numbers of JSON are exact up to 2^53; a border beyond it is left open.
    let border = |number: i128| i64::try_from(number).ok().filter(|number| number.unsigned_abs() <= 1 << 53);
    let mut schema = json!({ "type": "integer" });
    if let Value::Object(schema) = &mut schema {
        schema.extend(border(least).map(|least| ("minimum".to_owned(), least.into())));
        schema.extend(border(most).map(|most| ("maximum".to_owned(), most.into())));
    }
    schema
}

fn list(items: Value, least: usize, most: Option<usize>) -> Value {
    match most {
        Some(most) => json!({ "type": "array", "items": items, "minItems": least, "maxItems": most }),
        None => json!({ "type": "array", "items": items, "minItems": least }),
    }
}

/// A mapping; in a step a key may be an expression that is replaced.
fn map(names: Option<&str>, value: Value, least: usize, in_step: bool) -> Value {
    let mut schema = json!({ "type": "object", "additionalProperties": value, "minProperties": least });
    if let (Value::Object(schema), Some(names)) = (&mut schema, names) {
        let names = match in_step {
            true => json!({ "anyOf": [text_of(names), text_of(EXPRESSION)] }),
            false => text_of(names),
        };
        schema.insert("propertyNames".to_owned(), names);
    }
    schema
}

/// A step has exactly one verb, and the modifiers of this verb.
fn step(definitions: &mut Definitions) -> Value {
    let verbs: Vec<&str> = VERBS.iter().filter_map(|(_, set)| set.keys.first()).map(|key| key.name).collect();
    let chosen: Vec<Value> = VERBS
        .iter()
        .filter_map(|(_, set)| {
            let verb = set.keys.first()?.name;
            Some(json!({ "if": { "required": [verb] }, "then": definitions.keys(set, true) }))
        })
        .collect();
    let one = verbs.iter().map(|verb| json!({ "required": [verb] })).collect::<Vec<_>>();
    let object = json!({ "type": "object", "oneOf": one, "allOf": chosen });
    json!({ "description": "a step: one verb and its modifiers", "anyOf": [object, text_of(EXPRESSION)] })
}

/// A word or a number.
fn scalar() -> Value {
    json!({ "type": ["string", "number"] })
}

/// The bits of a word.
fn names() -> Value {
    list(text_of(LABEL), 1, None)
}

/// A code of a refusal, or several of which one is right.
fn codes() -> Value {
    json!({ "anyOf": [text_of(LABEL), text_of(EXPRESSION), list(text_of(LABEL), 1, None)] })
}

/// What a value is compared with where `single` is one value.
fn matcher_of(single: &Value) -> Value {
    let set = &super::super::matcher::matcher::KEYS;
    let choice = json!({ "anyOf": [list(single.clone(), 1, None), text_of(EXPRESSION)] });
    let mut properties = Map::new();
    for key in set.keys {
        let value = match key.name {
            "in" => choice.clone(),
            "refused" => codes(),
            _ => single.clone(),
        };
        properties.insert(key.name.to_owned(), with_sentence(value, key.sentence));
    }
    let alone = |name: &str| json!({ "required": [name], "maxProperties": 1 });
    let range = json!({ "anyOf": [{ "required": ["from"] }, { "required": ["to"] }],
        "propertyNames": { "enum": ["from", "to"] } });
    let chosen = json!({ "type": "object", "properties": properties, "additionalProperties": false,
        "anyOf": [alone("in"), alone("not"), alone("refused"), range] });
    json!({ "description": set.what, "if": { "type": "object" }, "then": chosen, "else": single })
}

/// What a value is compared with; a list is a set of words, or the bits of a word.
fn matcher(_: &mut Definitions) -> Value {
    matcher_of(&json!({ "anyOf": [scalar(), names()] }))
}

/// What a value is compared with that has no bits.
fn plain_matcher(_: &mut Definitions) -> Value {
    matcher_of(&scalar())
}

/// What bytes are compared with.
fn octet_matcher(_: &mut Definitions) -> Value {
    matcher_of(&json!({ "anyOf": [text_of(OPEN_OCTETS), { "const": "any" }, text_of(EXPRESSION)] }))
}

/// What a set of words is compared with; an empty list is the empty set.
fn set_matcher(_: &mut Definitions) -> Value {
    matcher_of(
        &json!({ "anyOf": [scalar(), list(json!({ "anyOf": [text_of(LABEL), text_of(EXPRESSION)] }), 0, None)] }),
    )
}

/// A last answer, or a part of one.
fn last_answer(_: &mut Definitions) -> Value {
    let words = json!({ "enum": ["accepted", "any"] });
    let refused = json!({ "type": "object", "required": ["refused"], "properties": { "refused": codes() },
        "additionalProperties": false });
    json!({ "anyOf": [words, refused, text_of(EXPRESSION)] })
}

/// A text, or several.
fn texts(_: &mut Definitions) -> Value {
    let text = json!({ "type": "string", "pattern": "\\S" });
    json!({ "anyOf": [text, list(text.clone(), 1, None)] })
}

/// Fields and built-in names have no bits of their own: after them no list can stand.
const WITHOUT_BITS: &str = "^(?!P[0-9]|diag\\.(errors|bytes)$|answer|role\\.|io\\.(inputs|outputs)|cfg\\.bytes$|lldp\\.(chassis|mac|source|bytes)$|station\\.mac$)([A-Za-z_][A-Za-z0-9_-]*\\.|(power|link|device|connection|alarm|abort|lldp|hello|ready|elapsed)$)";
/// A last answer or a part of it that is no value.
const LAST_ANSWER: &str = "^answer$|^answer\\.(?!bytes$|status$|contains$|lacks$|text$|number$|module_diff)";

/// The right number or the right sequence.
fn observation(definitions: &mut Definitions) -> Value {
    let matcher = definitions.named("MATCHER", matcher);
    let run = list(scalar(), 1, None);
    let runs = list(list(run.clone(), 0, None), 1, None);
    let either = json!({ "type": "object", "required": ["either"], "properties": { "either": runs },
        "additionalProperties": false });
    let entries = list(json!({ "anyOf": [run, either, text_of(EXPRESSION)] }), 2, None);
    json!({ "description": "the right number or the right sequence", "if": { "type": "array" }, "then": entries, "else": matcher })
}

fn with_sentence(mut schema: Value, sentence: &str) -> Value {
    if let Value::Object(schema) = &mut schema {
        schema.insert("description".to_owned(), sentence.into());
    }
    schema
}

/// Names and their expected values.
fn checks(definitions: &mut Definitions) -> Value {
    let last = definitions.named("LAST_ANSWER", last_answer);
    let mut schema = with_sentence(access(definitions), "names and their expected values");
    let texts = definitions.named("TEXTS", texts);
    if let Value::Object(schema) = &mut schema {
        let more = json!({ LAST_ANSWER: last, "^answer\\.(contains|lacks)$": texts });
        if let (Some(Value::Object(known)), Value::Object(more)) = (schema.get_mut("patternProperties"), more) {
            known.extend(more);
        }
    }
    schema
}

fn access(definitions: &mut Definitions) -> Value {
    let (matcher, plain) = (definitions.named("MATCHER", matcher), definitions.named("PLAIN_MATCHER", plain_matcher));
    let mut schema = with_sentence(map(None, matcher, 1, true), "names and the right answers");
    if let Value::Object(schema) = &mut schema {
        let octets = definitions.named("OCTET_MATCHER", octet_matcher);
        let set = definitions.named("SET_MATCHER", set_matcher);
        schema.insert(
            "patternProperties".to_owned(),
            json!({ WITHOUT_BITS: plain, NAMES_OF_OCTETS: octets, NAME_OF_SET: set }),
        );
    }
    schema
}

fn settings(_: &mut Definitions) -> Value {
    let values = map(None, json!({ "anyOf": [scalar(), names()] }), 1, true);
    let mut schema = with_sentence(values, "names and their values");
    if let Value::Object(schema) = &mut schema {
        let octets = json!({ "anyOf": [text_of(OCTETS), text_of(EXPRESSION)] });
        schema.insert("patternProperties".to_owned(), json!({ WITHOUT_BITS: scalar(), NAMES_OF_OCTETS: octets }));
    }
    schema
}

/// A connection on either bus: its settings, and start parameters by name.
fn connection(definitions: &mut Definitions) -> Value {
    let both = dialect::both();
    let keys = both.profibus.settings.keys.iter().chain(both.profinet.settings.keys);
    let mut properties = Map::new();
    for key in keys {
        let schema = definitions.described(key, true);
        let known = properties.insert(key.name.to_owned(), schema.clone());
        if let Some(known) = known.filter(|known| *known != schema) {
            properties.insert(key.name.to_owned(), json!({ "anyOf": [known, schema] }));
        }
    }
    let parameter = json!({ "type": ["string", "number"] });
    json!({ "description": "a connection: settings of the bus and start parameters", "type": "object",
        "properties": properties, "additionalProperties": parameter })
}

/// Exactly one service with its fields.
fn service(definitions: &mut Definitions) -> Value {
    let both = dialect::both();
    let mut properties: Map<String, Value> = Map::new();
    for (set, sentence) in both.profinet.services.iter().chain(both.profibus.services) {
        // Other mappings have some of these names.
        let own = format!("SERVICE_{}", set.name.to_uppercase());
        let schema = definitions.define(&own, |definitions| definitions.set(set, true));
        let schema = with_sentence(json!({ "allOf": [schema] }), sentence);
        match properties.remove(set.name) {
            Some(other) => properties.insert(set.name.to_owned(), json!({ "anyOf": [other, schema] })),
            None => properties.insert(set.name.to_owned(), schema),
        };
    }
    json!({ "description": "one service", "type": "object", "minProperties": 1, "maxProperties": 1,
        "properties": properties, "patternProperties": { EXPRESSION: {} }, "additionalProperties": false })
}

/// A right answer: a word, a refusal, parts, or a choice of these.
fn answer(definitions: &mut Definitions) -> Value {
    let own = json!({ "$ref": "#/$defs/ANSWER" });
    let plain = definitions.named("PLAIN_MATCHER", plain_matcher);
    let texts = definitions.named("TEXTS", texts);
    let octets = definitions.named("OCTET_MATCHER", octet_matcher);
    let matcher = definitions.named("MATCHER", matcher);
    let state = |words: Vec<&str>| {
        let word = json!({ "enum": words });
        let chosen = json!({ "type": "object", "minProperties": 1, "maxProperties": 1, "additionalProperties": false,
            "properties": { "in": list(word.clone(), 1, None), "not": word.clone() } });
        json!({ "anyOf": [word, chosen, text_of(EXPRESSION)] })
    };
    let refused = json!({ "properties": { "refused": codes() }, "maxProperties": 1 });
    let parts = json!({
        "minProperties": 1,
        "properties": { "bytes": octets, "status": plain, "contains": texts, "lacks": texts, "connection": state(CONNECTIONS.words()) },
        "patternProperties": { EXPRESSION: { "anyOf": [own, plain] }, "^diag\\.": matcher, "^module_diff\\.": state(MODULE_STATES.words()) },
        "additionalProperties": own,
    });
    let mapping = json!({ "if": { "required": ["refused"] }, "then": refused, "else": parts });
    let word = json!({ "anyOf": [{ "enum": ANSWERS.words() }, text_of(EXPRESSION)] });
    json!({
        "description": "a right answer: a word, a refusal, its parts, or a list of answers of which one has to come",
        "if": { "type": "object" }, "then": mapping,
        "else": { "if": { "type": "array" }, "then": list(own.clone(), 2, None), "else": word },
    })
}

/// What is changed in a request of `read` or `write`.
fn instead(definitions: &mut Definitions) -> Value {
    let both = dialect::both();
    let sets = [
        both.profinet.parameter_request,
        &record_request::KEYS,
        &station_request::KEYS,
        both.profibus.parameter_request,
    ];
    let requests: Vec<Value> = sets.into_iter().map(|set| definitions.keys(set, true)).collect();
    json!({ "description": "what is changed in a request", "type": "object", "minProperties": 1, "anyOf": requests })
}

/// What is changed in a start-up; its records are named too.
fn start_instead(definitions: &mut Definitions) -> Value {
    let both = dialect::both();
    let record = json!({ "anyOf": [text_of(OCTETS), { "const": "none" }, text_of(EXPRESSION)] });
    let starts: Vec<Value> = [both.profinet.start_request, both.profibus.start_request]
        .into_iter()
        .map(|set: &'static KeySet| {
            let properties = definitions.properties(set.keys, true);
            json!({ "type": "object", "properties": properties, "additionalProperties": record })
        })
        .collect();
    json!({ "description": "what is changed in a start-up", "type": "object", "minProperties": 1, "anyOf": starts })
}

/// Two readings or more, each with steps that only check.
fn readings(definitions: &mut Definitions) -> Value {
    let step = definitions.value(Shape::Step, true);
    let checks =
        json!({ "anyOf": [{ "required": ["expect"] }, { "required": [read_step::read.name] }, { "type": "string" }] });
    let steps = list(json!({ "allOf": [step, checks] }), 1, None);
    with_sentence(map(Some(LABEL), steps, 2, true), "readings by name, each with its steps")
}

/// A row: reserved keys, and columns of any value.
fn table_row(definitions: &mut Definitions) -> Value {
    let properties = definitions.properties(row::KEYS.keys, true);
    json!({ "description": row::KEYS.what, "type": "object", "properties": properties, "minProperties": 1,
        "not": { "propertyNames": { "enum": row::KEYS.names().collect::<Vec<_>>() } },
        "propertyNames": text_of(LABEL), "additionalProperties": { "not": { "type": "null" } } })
}
