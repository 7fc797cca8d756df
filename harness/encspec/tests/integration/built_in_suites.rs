//! The built-in suites load without errors.

use crate::built_in::manuals;
use encspec::results::schema;
use encspec::suite::model::Manual;
use encspec::suite_yaml::{Sources, load};
use std::collections::BTreeSet;
use std::path::Path;

#[test]
fn the_embedded_suites_load() {
    let manuals = manuals();
    assert!(!manuals.is_empty(), "there is no built-in manual");
    for manual in manuals {
        for variant in &manual.variants {
            assert!(!variant.trials.is_empty(), "{} of {} has no trial", variant.name, manual.device.name);
            assert_eq!(variant.names.len(), variant.paths.len());
            assert_eq!(variant.names.len(), variant.types.len());
        }
    }
}

/// `--suites` with the folder of the built-in suites gives the same trials.
#[test]
fn a_folder_holds_the_same_suites() {
    let folder = testing::workspace().join("suites");
    let read = load(&Sources::folder(&folder).expect("the folder can be read"), None).expect("it loads");
    let ids = |manuals: &[Manual]| -> Vec<String> {
        let variants = manuals.iter().flat_map(|manual| &manual.variants);
        variants.flat_map(|variant| variant.trials.iter().map(|trial| trial.id.clone())).collect()
    };
    assert_eq!(ids(&read), ids(manuals()));
}

#[test]
fn a_missing_folder_is_reported() {
    let errors = Sources::folder(Path::new("/no/such/folder")).expect_err("there is none");
    assert!(errors.to_string().starts_with("/no/such/folder: "), "{errors}");
}

#[test]
fn the_schema_lists_verbs_names_and_codes() {
    let schema = schema();
    let words = &schema["x-encspec"];
    assert_eq!(
        words["verbs"]["expect"]["modifiers"],
        serde_json::json!(["within", "for", "until", "covers", "about", "otherwise"])
    );
    assert_eq!(words["verbs"].as_object().map(serde_json::Map::len), Some(13), "the language has thirteen verbs");
    assert!(words["codes"]["parameters"].as_array().is_some_and(|codes| codes.contains(&"read_only".into())));
    assert_eq!(words["services"]["http_post"]["fields"], serde_json::json!(["page", "fields"]));
    assert!(words["instead"]["station"]["destination"].is_string());
    assert!(words["broken"].as_object().is_some_and(|frames| !frames.is_empty()));
    let profibus = &words["profibus"];
    assert_eq!(profibus["services"]["ds_read"]["fields"], serde_json::json!(["slot", "index", "length"]));
    assert!(profibus["names"]["diag.errors"].is_string() && profibus["names"]["station.name"].is_null());
    assert!(profibus["broken"].as_object().is_some_and(|frames| !frames.is_empty()));
    let case = &schema["$defs"]["CASE"];
    assert_eq!(case["additionalProperties"], false);
    assert_eq!(case["required"], serde_json::json!(["id", "why", "steps"]));
}

/// On PROFIBUS each word of a refusal is in one table only, so that the word is unambiguous.
#[test]
fn no_two_tables_share_a_word_of_a_refusal() {
    let schema = schema();
    let words = schema["x-encspec"]["profibus"]["codes"]["parameters"].as_array().expect("a list");
    let once: BTreeSet<&str> = words.iter().filter_map(|word| word.as_str()).collect();
    assert_eq!(once.len(), words.len(), "{words:?}");
}

/// Every reference in the schema has a target.
#[test]
fn the_schema_is_closed() {
    let schema = schema();
    let text = schema.to_string();
    let references: Vec<&str> = text.split("#/$defs/").skip(1).filter_map(|rest| rest.split('"').next()).collect();
    assert!(references.len() > 20, "only {} references", references.len());
    for name in references {
        assert!(schema["$defs"].get(name).is_some(), "{name}");
    }
}
