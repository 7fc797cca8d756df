//! A station that can have other modules in the slot of the encoder: their records, APIs and I&M are not those of the encoder.

use crate::built_in::manuals;
use crate::gsdml::reported;
use encspec::gsdml::{self, Gsdml};
use suite::device::DeviceDescription;

const MANUAL: &str = "lika-xac77-profinet";

/// A module for the slot of the encoder: with the number of its start record and the name of its first parameter for others, with a start record of its own, an API
/// that the encoder does not have, and I&M that its access point does not have.
const OTHER_MODULE: &str = r#"
        <ModuleItem ID="OTHER" ModuleIdentNumber="0x00000077">
          <ModuleInfo><Name TextId="T_OTHER"/><InfoText TextId="T_OTHER"/></ModuleInfo>
          <VirtualSubmoduleList>
            <VirtualSubmoduleItem ID="OTHER_1" SubmoduleIdentNumber="0x00000078" FixedInSubslots="1" API="15872"
                                  Writeable_IM_Records="4 5">
              <IOData><Input><DataItem DataType="Unsigned16" TextId="T_OTHER"/></Input></IOData>
              <RecordDataList>
                <ParameterRecordDataItem Index="48896" Length="31">
                  <Name TextId="T_OTHER"/>
                  <Ref DataType="Bit" ByteOffset="5" BitOffset="0" DefaultValue="1" AllowedValues="0..1" TextId="P_Code"/>
                </ParameterRecordDataItem>
                <ParameterRecordDataItem Index="100" Length="2"><Name TextId="T_OTHER"/></ParameterRecordDataItem>
              </RecordDataList>
              <ModuleInfo><Name TextId="T_OTHER"/><InfoText TextId="T_OTHER"/></ModuleInfo>
            </VirtualSubmoduleItem>
          </VirtualSubmoduleList>
        </ModuleItem>
"#;

fn device() -> &'static DeviceDescription {
    &manuals().iter().find(|manual| manual.device.name == MANUAL).expect("a shipped manual").device
}

fn shipped() -> &'static str {
    suites::gsdml().iter().find(|(path, _)| path.contains("XAC7718")).expect("a shipped GSDML").1
}

/// The shipped GSDML with the other module.
fn modular() -> Gsdml {
    let places = [
        ("<UseableModules>", r#"<ModuleItemRef ModuleItemTarget="OTHER" AllowedInSlots="1"/>"#),
        ("<ModuleList>", OTHER_MODULE),
        ("<PrimaryLanguage>", r#"<Text TextId="T_OTHER" Value="Something else"/>"#),
    ];
    let text = places.iter().fold(shipped().to_owned(), |text, (place, more)| {
        assert_eq!(text.matches(place).count(), 1, "{place}");
        text.replace(place, &format!("{place}{more}"))
    });
    gsdml::read(&text).expect("a GSDML")
}

#[test]
fn a_module_that_the_encoder_does_not_need_is_no_difference() {
    let found = modular();
    assert_eq!(found.modules.len(), 2);
    let plugged = reported(MANUAL, "xac7718");
    for says in [None, Some(&plugged)] {
        assert_eq!(gsdml::compare(device(), 0, Some(&found), says), []);
    }
}

#[test]
fn start_parameters_are_those_of_the_module_of_the_encoder() {
    let alone = gsdml::read(shipped()).expect("a GSDML");
    let plugged = reported(MANUAL, "xac7718");
    for says in [None, Some(&plugged)] {
        let [mut expected, mut known] = [device().clone(), device().clone()];
        let overlay = [(&mut expected, &alone), (&mut known, &modular())]
            .map(|(device, gsdml)| gsdml::overlay(device, 0, Some(gsdml), says, &[]));
        assert_eq!(overlay[0], overlay[1]);
        assert_eq!(format!("{:?}", expected.records), format!("{:?}", known.records));
    }
}
