//! JSON Schema of suite files, made from the tables that the loader reads by, and the lists of words that go with it.

use super::access::{INSTEAD_PARAMETERS, INSTEAD_RECORD, INSTEAD_STATION};
use super::answer::MODULE_STATES;
use super::dialect::{self, Dialect, Service};
use super::keys::{ALL, HOOKS, KeySet, Shape, TAKES};
use super::profibus;
use super::start::INSTEAD;
use super::step::VERBS;
use controllers::profibus_dp::broken_frames;
use controllers::profinet_io::DamagedIoFrame;
use serde_json::{Map, Value, json};
use suite::device::PerBus;

/// The JSON Schema (draft 2020-12) of all suite files and of bench files.
///
/// `$defs` has one entry for each kind of mapping; those of whole files are `FILES`.
/// Under `x-encspec` stand the words that a schema cannot place: verbs with their modifiers, names that every device has,
/// services, codes of refusals, damaged frames.
pub fn schema() -> Value {
    let mut defs: Map<String, Value> = ALL.iter().map(|(name, set)| ((*name).to_owned(), key_set(set))).collect();
    defs.insert("STEP".to_owned(), step());
    let files = FILES.map(|name| json!({ "$ref": format!("#/$defs/{name}") }));
    json!({
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "encspec suite files and bench files",
        "anyOf": files,
        "$defs": defs,
        "x-encspec": words(),
    })
}

/// The mappings that are whole files; `SLAVE` is a `device.yaml` of PROFIBUS.
const FILES: [&str; 12] = [
    "TOPIC",
    "USE",
    "COMMON",
    "PROCEDURES",
    "DEVICE",
    "SLAVE",
    "REQUIREMENTS",
    "BUGS",
    "MASKS",
    "PERSONA",
    "BENCH",
    "LEDGER",
];

fn key_set(set: &'static KeySet) -> Value {
    let properties: Map<String, Value> = set
        .keys
        .iter()
        .map(|key| {
            let mut schema = shape(key.shape);
            if let Value::Object(schema) = &mut schema {
                schema.insert("description".to_owned(), key.sentence.into());
            }
            (key.name.to_owned(), schema)
        })
        .collect();
    let required: Vec<&str> = set.keys.iter().filter(|key| key.required).map(|key| key.name).collect();
    json!({ "description": set.what, "type": "object", "properties": properties, "required": required, "additionalProperties": false })
}

fn shape(shape: Shape) -> Value {
    let reference = |set: &'static KeySet| {
        let name = ALL.iter().find(|(_, known)| std::ptr::eq(*known, set)).map_or("", |(name, _)| name);
        json!({ "$ref": format!("#/$defs/{name}") })
    };
    match shape {
        Shape::Text | Shape::Label | Shape::Name => json!({ "type": "string" }),
        Shape::Word(words) => json!({ "enum": words }),
        Shape::Number => json!({ "type": ["number", "string", "object"] }),
        Shape::SourcedText => json!({ "anyOf": [{ "type": "string" }, { "$ref": "#/$defs/SOURCED" }] }),
        Shape::Flag => json!({ "const": true }),
        Shape::Duration => json!({ "type": ["string", "number"] }),
        Shape::Condition => json!({ "type": ["string", "number"] }),
        Shape::Checks => json!({ "type": ["string", "object"] }),
        Shape::Any => json!({}),
        Shape::Values => json!({ "type": ["object", "string"] }),
        Shape::List(item) => {
            json!({ "anyOf": [{ "type": "array", "items": self::shape(*item) }, { "type": "string", "pattern": "^=" }] })
        }
        Shape::Map(value) => json!({ "type": "object", "additionalProperties": self::shape(*value) }),
        Shape::Keys(set) => reference(set),
        Shape::Step => json!({ "$ref": "#/$defs/STEP" }),
        Shape::Table => {
            let columns = json!({ "type": "object", "additionalProperties": reference(&TAKES) });
            json!({ "anyOf": [self::shape(Shape::List(&Shape::Values)), columns] })
        }
        Shape::Bits => {
            json!({ "anyOf": [{ "type": "integer" }, { "type": "array", "items": { "type": "integer" } }, { "$ref": "#/$defs/FIELD" }] })
        }
    }
}

/// A step is exactly one of the verbs with the modifiers of that verb.
fn step() -> Value {
    let one = VERBS.iter().map(|(verb, modifiers, sentence)| {
        let mut properties = Map::new();
        properties.insert((*verb).to_owned(), json!({ "description": sentence }));
        for modifier in *modifiers {
            properties.insert((*modifier).to_owned(), json!({}));
        }
        json!({ "type": "object", "properties": properties, "required": [verb], "additionalProperties": false })
    });
    json!({ "description": "a step", "oneOf": one.collect::<Vec<_>>() })
}

fn words() -> Value {
    let sentences = |list: &[(&str, &str)]| -> Value {
        list.iter().map(|(word, sentence)| ((*word).to_owned(), Value::from(*sentence))).collect::<Map<_, _>>().into()
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
    let verbs: Map<String, Value> = VERBS
        .iter()
        .map(|(verb, modifiers, sentence)| ((*verb).to_owned(), json!({ "does": sentence, "modifiers": modifiers })))
        .collect();
    let services = |list: &[(&str, &[&str], &str)]| -> Value {
        let entry = |(service, fields, sentence): &(&str, &[&str], &str)| {
            ((*service).to_owned(), json!({ "does": sentence, "fields": fields }))
        };
        list.iter().map(entry).collect::<Map<_, _>>().into()
    };
    let broken: Map<String, Value> =
        DamagedIoFrame::TABLE.iter().map(|(_, word, sentence)| ((*word).to_owned(), Value::from(*sentence))).collect();
    json!({
        "verbs": verbs,
        "names": names(profinet),
        "start": sentences(profinet.settings),
        "instead": {
            "start": sentences(INSTEAD),
            "parameters": sentences(INSTEAD_PARAMETERS),
            "record": sentences(INSTEAD_RECORD),
            "station": sentences(INSTEAD_STATION),
        },
        "services": services(profinet.services),
        "broken": broken,
        "profibus": {
            "names": names(on_profibus),
            "start": sentences(on_profibus.settings),
            "instead": {
                "start": sentences(profibus::INSTEAD),
                "parameters": sentences(on_profibus.other_place),
            },
            "services": services(on_profibus.services),
            "broken": broken_frames().map(|(word, sentence)| (word.to_owned(), Value::from(sentence))).collect::<Map<_, _>>(),
            "codes": {
                "parameters": codes(Service::Parameters, on_profibus),
                "services": codes(Service::Dp, on_profibus),
            },
        },
        "hooks": sentences(HOOKS),
        "module_diff": MODULE_STATES,
        "codes": {
            "parameters": codes(Service::Parameters, profinet),
            "records": codes(Service::Record, profinet),
            "station": codes(Service::Station, profinet),
            "connect": codes(Service::Connect, profinet),
        },
    })
}
