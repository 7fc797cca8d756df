//! Start records that only the vendor's GSDML has are sent with their defaults in each start-up of a live device.

use crate::common::program::{self, ServeProcess};
use crate::common::served::private_network;
use crate::table;
use libtest_mimic::Trial;
use serde_json::Value;
use testing::Folder;

/// Cases that need good inputs, with several start-ups.
const FILTER: &str = "profinet-io/protocol-cyclic/";
/// The defaults that the varied reference device insists on, in the access point and in the first module.
const DEFAULTS: [(u16, &str); 2] = [(0x0200, "0x12,0x34,0x56"), (0x0201, "0xA5,0x00,0x5A,0x01")];

pub fn trials() -> Vec<Trial> {
    table![start_records_of_the_vendor:
        with_their_defaults(Some(DEFAULTS), true),
        with_another_default_in_the_access_point(Some([(0x0200, "0x12,0x34,0x57"), DEFAULTS[1]]), false),
        with_another_default_in_the_module(Some([DEFAULTS[0], (0x0201, "0xA5,0x00,0x5A,0x00")]), false),
        without_them(None, false),
    ]
}

/// The shipped GSDML with a record in the access point and one in the module of slot 1.
fn gsdml(records: Option<[(u16, &str); 2]>) -> String {
    let (_, text) = suites::gsdml().iter().find(|(path, _)| path.starts_with("profinet-io/")).expect("it is shipped");
    let mut text = (*text).to_owned();
    for ((index, data), submodule) in records.into_iter().flatten().zip(["ID=\"DAP_1\"", "ID=\"MIRROR_1\""]) {
        let octets = data.split(',').count();
        let list = format!(
            "<RecordDataList><ParameterRecordDataItem Index=\"{index}\" Length=\"{octets}\" TransferSequence=\"0\">\
             <Name TextId=\"T_Dap\"/><Const ByteOffset=\"0\" Data=\"{data}\"/></ParameterRecordDataItem></RecordDataList>"
        );
        let at = text.find(submodule).expect("the submodule");
        let at = at + text[at..].find("<ModuleInfo>").expect("its name");
        text.insert_str(at, &list);
    }
    text
}

fn start_records_of_the_vendor(records: Option<[(u16, &str); 2]>, is_accepted: bool) {
    if !private_network() {
        return;
    }
    let folder = Folder::new("vendor-records");
    let vary = ["--vary", "start-records-of-the-vendor"];
    let _serving = ServeProcess::start(&[&["model:profinet-io/plain", "--nic", "theirs"], &vary[..]].concat());
    folder.write("vendor.xml", gsdml(records));
    folder.write(
        "bench.yaml",
        "device: profinet-io/plain\nlink: nic:ours\ngsdml: vendor.xml\nwatchdog: 200ms\nip: 192.168.0.10\n\
         ip_permanence: temporary\nconsent: { alone: true, set_name: true, set_ip: true }\n",
    );
    let arguments = ["run", "--dut", "bench.yaml", "--no-evidence", "--report", "json=run.json", FILTER];
    let said = program::encspec(&folder, &arguments);
    let text = std::fs::read_to_string(folder.join("run.json")).unwrap_or_else(|why| panic!("{why}: {}", said.all()));
    let report: Value = serde_json::from_str(&text).expect("JSON");
    let cases = report["runs"][0]["cases"].as_array().expect("cases").iter().filter(|case| case["kind"] == "case");
    let verdicts: Vec<&str> = cases.filter_map(|case| case["verdict"].as_str()).collect();
    let passed = verdicts.iter().filter(|verdict| **verdict == "pass").count();
    if is_accepted {
        let failed = verdicts.iter().filter(|verdict| ["fail", "inconclusive", "error"].contains(*verdict)).count();
        assert!(passed >= 5 && failed == 0, "{verdicts:?}\n{}", said.all());
    } else {
        assert!(passed == 0, "{verdicts:?}\n{}", said.all());
    }
}
