use super::*;
use std::collections::BTreeSet;
use testing::golden;

fn of(list: &[(String, DpFieldValue)], name: &str) -> Vec<DpFieldValue> {
    list.iter().filter(|(known, _)| known == name).map(|(_, value)| value.clone()).collect()
}

fn golden_frame(name: &str) -> Vec<u8> {
    golden("pyprofibus.txt").into_iter().find(|(known, _)| known == name).expect("a golden frame").1
}

/// Set_Prm of pyprofibus: lock, sync, freeze, watchdog 10 x 10 at 10 ms, ident 0x1655, groups 1 and 8, user bytes.
#[test]
fn the_fields_of_set_prm() {
    let list = ProfibusFields::default().frame(&golden_frame("set_prm_plain"));
    let number = |name: &str| of(&list, name);
    assert_eq!(number("da.sap"), [DpFieldValue::Number(61)]);
    assert_eq!(number("sa.sap"), [DpFieldValue::Number(62)]);
    assert_eq!(number("prm.watchdog"), [DpFieldValue::Number(1000)]);
    assert_eq!(number("prm.ident"), [DpFieldValue::Number(0x1655)]);
    assert_eq!(number("prm.groups"), [DpFieldValue::Number(0x81)]);
    assert_eq!(number("prm.status.lock_req"), [DpFieldValue::Number(1)]);
    assert_eq!(number("prm.status.unlock_req"), [DpFieldValue::Number(0)]);
    assert_eq!(number("service"), [DpFieldValue::Text("set_prm".into())]);
}

/// The data of a service that cannot be read are kept as bytes, without half of their fields.
#[test]
fn unreadable_data_have_no_fields_but_their_bytes() {
    // Read response of SAP 48 with the length 8 and four bytes.
    let counted = [0x82, 0x88, 0x08, 0x32, 0x30, 0x5E, 0, 0x2F, 8, 1, 2, 3, 4];
    let sum = wire::profibus::fdl::checksum(&counted);
    let octets = [&[0x68, 13, 13, 0x68], &counted[..], &[sum, 0x16]].concat();
    let list = ProfibusFields::default().frame(&octets);
    assert_eq!(of(&list, "damaged"), [DpFieldValue::Number(1)]);
    assert_eq!(of(&list, "data"), [DpFieldValue::Octets(counted[5..].to_vec())]);
    assert_eq!(of(&list, "dpv1.function"), []);
    assert_eq!(of(&list, "sa.sap"), [DpFieldValue::Number(48)]);
}

#[test]
fn every_field_is_in_the_table_and_the_table_has_no_name_twice() {
    let mut names = BTreeSet::new();
    for field in fields() {
        assert!(names.insert(field.name.to_owned()), "{} twice", field.name);
        if field.kind == DpFieldKind::Flags {
            names.extend(field.words.iter().map(|(_, word, _)| format!("{}.{word}", field.name)));
        }
    }
    let mut all = ProfibusFields::default();
    for (name, octets) in golden("pyprofibus.txt") {
        for (field, _) in all.frame(&octets) {
            assert!(names.contains(&field), "{name}: {field}");
        }
    }
}

/// The fields stand in the dissector, and nothing is left to be inserted.
#[test]
fn the_dissector_has_each_field_and_the_link_type() {
    let program = dissector(3);
    for field in fields() {
        assert!(program.contains(&format!("(\"{}\", \"{}\"", field.name, field.title)), "{}", field.name);
    }
    assert!(program.contains("wtap.USER0 + 3, profibus"), "{program}");
    assert!(!program.contains("-- FIELDS") && !program.contains("USER_LINK_TYPE"));
    assert!(program.contains("[61] = \"set_prm\""));
}
