//! The JSON Schema of suite files, made from the key sets that the loader reads by, and the words that go with it.

mod shapes;

use super::answer::MODULE_STATES;
use super::device_yaml::{device, slave};
use super::dialect::{self, Dialect, Service, ServiceEntry};
use super::keys::{Choice, Key, KeySet, Vocabulary};
use super::lists::{bugs, requirement, requirements};
use super::masks::masks;
use super::persona::persona;
use super::request_keys::{parameter_request, record_request, station_request};
use super::topic_keys::{case, common_suite, defaults, procedures, topic, uses};
use super::verbs::{VERBS, word_of};
use controllers::profibus_dp::broken_frames;
use controllers::profinet_io::{ConnectField, DamagedIoFrame};
use serde_json::{Map, Value, json};
use std::time::Duration;
use suite::device::{PATIENCE, PerBus, STANDARD_TIMES};

/// The mappings that are whole files of a suite; `slave` is a `device.yaml` of PROFIBUS.
const FILES: [&KeySet; 10] = [
    &topic::KEYS,
    &uses::KEYS,
    &common_suite::KEYS,
    &procedures::KEYS,
    &device::KEYS,
    &slave::KEYS,
    &requirements::KEYS,
    &bugs::KEYS,
    &masks::KEYS,
    &persona::KEYS,
];

/// The JSON Schema (draft 2020-12) of all suite files and of the files `others`.
///
/// `$defs` has one entry for each kind of mapping. Under `x-encspec` are the words that a schema cannot express: names that every
/// device has, codes of refusals, damaged frames, and the names in `hooks`, which a bench file may serve.
pub fn schema(others: &[&'static KeySet], hooks: &[(&str, &str)]) -> Value {
    let mut definitions = Definitions::default();
    let files: Vec<Value> = FILES.iter().chain(others).map(|set| definitions.keys(set, false)).collect();
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "encspec suite files and bench files",
        "anyOf": files,
        "$defs": definitions.0,
        "x-encspec": words(hooks),
    })
}

/// The definitions made so far, by name.
#[derive(Default)]
struct Definitions(Map<String, Value>);

impl Definitions {
    /// A reference to the definition of a set.
    fn keys(&mut self, set: &'static KeySet, in_step: bool) -> Value {
        self.define(&set.name.to_uppercase(), |definitions| definitions.set(set, in_step))
    }

    /// A reference to the definition `name`, which is made where it is missing.
    fn named(&mut self, name: &str, make: fn(&mut Definitions) -> Value) -> Value {
        self.define(name, make)
    }

    fn define(&mut self, name: &str, make: impl FnOnce(&mut Definitions) -> Value) -> Value {
        if !self.0.contains_key(name) {
            // A definition may refer to itself: it is known before it is made.
            self.0.insert(name.to_owned(), Value::Null);
            let made = make(self);
            self.0.insert(name.to_owned(), made);
        }
        json!({ "$ref": format!("#/$defs/{name}") })
    }

    fn set(&mut self, set: &'static KeySet, is_in_step: bool) -> Value {
        let in_step = is_in_step || [topic::KEYS.name, uses::KEYS.name, common_suite::KEYS.name].contains(&set.name);
        let properties: Map<String, Value> =
            set.keys.iter().map(|key| (key.name.to_owned(), self.described(key, in_step))).collect();
        let required: Vec<&str> = set.keys.iter().filter(|key| key.required).map(|key| key.name).collect();
        let mut schema = json!({ "description": set.what, "type": "object", "properties": properties, "required": required,
            "additionalProperties": false });
        let mut choices: Vec<Value> = set.choices.iter().map(choice).collect();
        if set.name == requirements::KEYS.name {
            choices.extend(requirement_defaults());
        }
        if [topic::KEYS.name, uses::KEYS.name].contains(&set.name) {
            choices.push(start());
        }
        if let (Value::Object(schema), false) = (&mut schema, choices.is_empty()) {
            schema.insert("allOf".to_owned(), choices.into());
        }
        schema
    }

    /// The schema of the value of a key, with its sentence.
    fn described(&mut self, key: &Key, in_step: bool) -> Value {
        let mut schema = self.value(key.shape, in_step);
        if let Value::Object(schema) = &mut schema {
            schema.insert("description".to_owned(), key.sentence.into());
        }
        schema
    }
}

/// A requirement names its source and its channel where its file names none.
fn requirement_defaults() -> impl Iterator<Item = Value> {
    [(&requirements::source, &requirement::source), (&requirements::channel, &requirement::channel)].into_iter().map(
        |(default, own)| {
            let list = requirements::requirements.name;
            json!({ "if": { "not": { "required": [default.name] } },
                "then": { "properties": { list: { "items": { "required": [own.name] } } } } })
        },
    )
}

/// A case says how it starts where its file does not.
fn start() -> Value {
    let said = json!({ "required": [topic::defaults.name],
        "properties": { topic::defaults.name: { "required": [defaults::start.name] } } });
    let each = json!({ "properties": { topic::cases.name: { "items": { "required": [case::start.name] } } } });
    json!({ "if": { "not": said }, "then": each })
}

/// Which keys go together, as JSON Schema says it.
fn choice(choice: &Choice) -> Value {
    let each = |keys: &[&Key]| keys.iter().map(|key| json!({ "required": [key.name] })).collect::<Vec<_>>();
    match choice {
        Choice::OneOf(keys) => json!({ "oneOf": each(keys) }),
        Choice::AnyOf(keys) => json!({ "anyOf": each(keys) }),
        Choice::NotBoth(one, other) => json!({ "not": { "required": [one.name, other.name] } }),
        Choice::Together(keys) => {
            let names: Vec<&str> = keys.iter().map(|key| key.name).collect();
            let all: Map<String, Value> = names.iter().map(|name| ((*name).to_owned(), json!(names))).collect();
            json!({ "dependentRequired": all })
        }
        Choice::With(keys, needed) => {
            let all: Map<String, Value> = keys.iter().map(|key| (key.name.to_owned(), json!([needed.name]))).collect();
            json!({ "dependentRequired": all })
        }
    }
}

fn words(hooks: &[(&str, &str)]) -> Value {
    let sentences = |list: &[(&str, &str)]| -> Value {
        list.iter().map(|(word, sentence)| ((*word).to_owned(), Value::from(*sentence))).collect::<Map<_, _>>().into()
    };
    let keys = |set: &KeySet| -> Value {
        set.keys.iter().map(|key| (key.name.to_owned(), Value::from(key.sentence))).collect::<Map<_, _>>().into()
    };
    let PerBus { profinet, profibus: on_profibus } = dialect::both();
    let codes = |service: Service, dialect: &Dialect| -> Value {
        let words = (dialect.codes)(service).into_iter().flat_map(|(_, words)| words).map(|(word, _)| word);
        words.collect::<Vec<_>>().into()
    };
    let names = |dialect: &Dialect| -> Value {
        dialect
            .built_in_names()
            .map(|(name, sentence)| ((*name).to_owned(), Value::from(*sentence)))
            .collect::<Map<_, _>>()
            .into()
    };
    let verb = |set: &'static KeySet| {
        let modifiers: Vec<&str> = set.names().skip(1).collect();
        let sentence = set.keys.first().map_or("", |key| key.sentence);
        (word_of(set).to_owned(), json!({ "does": sentence, "modifiers": modifiers }))
    };
    let verbs: Map<String, Value> = VERBS.iter().map(|(_, set)| verb(set)).collect();
    let services = |list: &[ServiceEntry]| -> Value {
        let entry = |(set, sentence): &ServiceEntry| {
            (set.name.to_owned(), json!({ "does": sentence, "fields": set.names().collect::<Vec<_>>() }))
        };
        list.iter().map(entry).collect::<Map<_, _>>().into()
    };
    let broken: Map<String, Value> =
        DamagedIoFrame::TABLE.iter().map(|(_, word, sentence)| ((*word).to_owned(), Value::from(*sentence))).collect();
    let connect_fields = ConnectField::TABLE.iter().map(|of| (of.word.to_owned(), Value::from(of.sentence)));
    let connect_fields = connect_fields.collect::<Map<_, _>>();
    let times = STANDARD_TIMES.iter().map(|(name, millis, sentence)| {
        let usual = plain_text::span(Duration::from_millis(*millis));
        ((*name).to_owned(), Value::from(format!("{usual}. {sentence}")))
    });
    let patience = format!("{PATIENCE}. How many times a limit of ours something may take and is only noted.");
    let patience = ("patience".to_owned(), Value::from(patience));
    json!({
        "verbs": verbs,
        "names": names(profinet),
        "start": keys(profinet.settings),
        "instead": {
            "start": keys(profinet.start_request),
            "parameters": keys(&parameter_request::KEYS),
            "record": keys(&record_request::KEYS),
            "station": keys(&station_request::KEYS),
        },
        "services": services(profinet.services),
        "broken": broken,
        "connect_fields": connect_fields,
        "profibus": {
            "names": names(on_profibus),
            "start": keys(on_profibus.settings),
            "instead": {
                "start": keys(on_profibus.start_request),
                "parameters": keys(on_profibus.parameter_request),
            },
            "services": services(on_profibus.services),
            "broken": broken_frames().map(|(word, sentence)| (word.to_owned(), Value::from(sentence))).collect::<Map<_, _>>(),
            "codes": {
                "parameters": codes(Service::Parameters, on_profibus),
                "services": codes(Service::Dp, on_profibus),
            },
        },
        "hooks": sentences(hooks),
        "times": times.chain([patience]).collect::<Map<_, _>>(),
        "module_diff": MODULE_STATES.words(),
        "codes": {
            "parameters": codes(Service::Parameters, profinet),
            "records": codes(Service::Record, profinet),
            "station": codes(Service::Station, profinet),
            "connect": codes(Service::Connect, profinet),
        },
    })
}
