//! Bench files: the example loads, and every error is reported with its position and a suggestion.

use crate::built_in::manuals;
use encspec::bench_file::{BenchFile, Consents, DcpPermanence, LinkSpec, ShaftAbility, read, read_alone};
use encspec::result::DescriptionKind;
use encspec::results::schema;
use rstest::rstest;
use std::path::{Path, PathBuf};
use std::time::Duration;
use testing::Folder;

const EXAMPLE: &str = include_str!("../../examples/bench.yaml");
const SHORTEST: &str = "device: lika-xac77-profinet/xac7718\nlink: nic:eth1\n";

fn loaded(folder: &Folder, text: &str) -> Result<BenchFile, String> {
    read(&folder.write("bench.yaml", text), manuals()).map_err(|errors| errors.to_string())
}

#[test]
fn the_example_loads() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples/bench.yaml");
    let bench = read(&path, manuals()).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!((bench.claim.manual.as_str(), bench.claim.variant.as_str()), ("lika-xac77-profinet", "xac7718"));
    assert_eq!(bench.link, LinkSpec::Nic("eth1".to_owned()));
    assert_eq!(bench.station_name.as_deref(), Some("encoder-1"));
    assert_eq!(bench.mac.map(|mac| mac.0), Some([0, 0x0E, 0xCF, 0, 1, 2]));
    assert_eq!(bench.ip, Some([192, 168, 0, 10].into()));
    assert_eq!(bench.mask, std::net::Ipv4Addr::new(255, 255, 255, 0));
    assert_eq!(bench.controller_ip, Some([192, 168, 0, 1].into()));
    assert_eq!(bench.ip_permanence, Some(DcpPermanence::Permanent));
    assert_eq!(bench.controller_mac.map(|mac| mac.0), Some([2, 0, 0, 0, 0, 1]));
    assert_eq!(bench.cycle, Some(Duration::from_millis(4)));
    assert_eq!(bench.watchdog, Some(Duration::from_millis(400)));
    assert_eq!(bench.boot_time, Some(Duration::from_secs(8)));
    let names: Vec<&str> = bench.timing.ours.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!((names, bench.timing.patience), (vec!["reaction", "settle"], Some(5)));
    assert_eq!(bench.telegrams.as_deref().map(<[String]>::len), Some(3));
    assert_eq!(bench.lacks, ["P61001"]);
    assert_eq!(bench.firmware.as_deref(), Some("1.1.0"));
    assert_eq!(bench.position_noise, 1);
    assert!(bench.direct_cable);
    let pages: Vec<&str> = bench.pages.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(pages, ["information", "position", "preset"]);
    assert_eq!(bench.pages[1].1.path.as_deref(), Some("/status/position.html"));
    assert_eq!(bench.pages[2].1.fields, [("value".to_owned(), "preset".to_owned())]);
    assert_eq!(bench.stand.hooks.len(), 5);
    assert_eq!(bench.stand.ask, ["link"]);
    assert_eq!(bench.stand.folder, path.parent().expect("a folder"));
    let shaft = ShaftAbility { hand: false, position: Some(1.0), speed: Some(0.5), uncoupled: true };
    assert_eq!(bench.stand.shaft, shaft);
    let all = Consents {
        factory_reset: true,
        set_name: true,
        set_ip: true,
        set_address: true,
        im_records: true,
        nvm_write: 50,
        position_reference: true,
        firmware: true,
        overstress: true,
        lock_address: true,
        alone: true,
    };
    assert_eq!(bench.consent, all);
    assert_eq!(read_alone(&path).map(|alone| alone.stand), Ok(bench.stand));
}

#[test]
fn the_commented_lines_of_the_example_load_too() {
    let folder = Folder::new("left-out");
    folder.write("my-device.yaml", "");
    folder.write("GSDML-V2.43-vendor-device-20260101.xml", "");
    folder.write("known-failures.yaml", "");
    let with: String = EXAMPLE.replace("#: ", "");
    assert!(with.contains("\ndescription: ") && with.contains("\n  control: "));
    let with = with.replace("description: my-device.yaml\n", "");
    let bench = loaded(&folder, &with).unwrap_or_else(|errors| panic!("{errors}"));
    let gsdml = folder.join("GSDML-V2.43-vendor-device-20260101.xml");
    assert_eq!(bench.description_of(DescriptionKind::Gsdml), Some(gsdml.as_path()));
    assert_eq!(bench.ledger, Some(folder.join("known-failures.yaml")));
    assert_eq!(bench.stand.control, Some(PathBuf::from("/run/encspec/control")));
    let path = folder.write("none.yaml", "device: none\ndescription: my-device.yaml\nlink: socket:listen:/run/qemu\n");
    let bench = read_alone(&path).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(bench.description, Some(folder.join("my-device.yaml")));
    assert_eq!(bench.link, LinkSpec::Socket("listen:/run/qemu".to_owned()));
}

#[test]
fn the_shortest_bench_gives_no_consent() {
    let bench = loaded(&Folder::new("shortest"), SHORTEST).unwrap_or_else(|errors| panic!("{errors}"));
    assert_eq!(bench.consent, Consents::default());
    assert!(!bench.stand.serves("power"));
    assert_eq!(bench.stand.position(), None);
}

/// A line added to the shortest bench, the begin of the message, and another part of it.
#[rstest]
#[case("statoin_name: x\n", ":3:1: unknown key of a bench file `statoin_name`", "did you mean `station_name`?")]
#[case("cycle: 2 ms\n", ":3:8: ", "")]
#[case("cycle: 3ms\n", ":3:8: no send clock and reduction make this cycle", "512ms")]
#[case("watchdog: 5ms\n", ":3:11: a watchdog is a whole number of cycles", "")]
#[case("boot_time: 0s\n", ":3:12: a boot time must be more than 0 and at most 10min", "")]
#[case("station_name: Enc_1\n", ":3:15: `Enc_1` is not a station name", "at most 63 characters")]
#[case("mac: 01:0e:cf:00:00:00\n", ":3:6: no station can have this MAC address", "")]
#[case("mac: 00:0e:cf:00:00\n", ":3:6: a MAC address is six pairs", "")]
#[case("ip: 192.168.0.256\n", ":3:5: `192.168.0.256` is not an IPv4 address", "")]
#[case("ip: 127.0.0.1\n", ":3:5: no station can have the address 127.0.0.1", "")]
#[case("ip: 192.168.0.255\n", ":3:5: this is the network or broadcast address of its subnet", "")]
#[case("mask: 255.0.255.0\n", ":3:7: a subnet mask has one bits, then zero bits", "for instance 255.255.255.0")]
#[case("ip: 10.0.0.2\ncontroller: { ip: 10.0.1.2 }\n", ":4:19: controller and device are not in the same subnet", "")]
#[case("ip: 10.0.0.2\ncontroller: { ip: 10.0.0.2 }\n", ":4:19: controller and device cannot have the same address", "")]
#[case("controller: { pi: 10.0.0.2 }\n", ":3:15: unknown key of controller `pi`", "did you mean `ip`?")]
#[case("gsdml: none.xml\n", ":3:8: ", "paths are relative to the folder of the bench file")]
#[case("ledger: .\n", ":3:9: ", "is not a file")]
#[case("description: bench.yaml\n", ":3:1: `description` is for a device without a manual", "remove the key")]
#[case("telegrams: [telegram_84, telegram_85]\n", ":3:26: unknown module `telegram_85`", "did you mean `telegram_81`?")]
#[case("telegrams: [telegram_84, telegram_84]\n", ":3:26: `telegram_84` is listed twice in telegrams", "")]
#[case("telegrams: []\n", ":3:12: telegrams is empty", "remove the key")]
#[case("lacks: [P61002]\n", ":3:9: unknown record or parameter `P61002`", "did you mean `P61001`?")]
#[case("firmware: V1.1\n", ":3:11: `V1.1` is not a firmware version", "three numbers, for instance 1.1.0")]
#[case("direct_cable: straight\n", ":3:15: `direct_cable` is `true` or left out", "")]
#[case("timing: { reacton: 300ms }\n", ":3:11: unknown time of ours `reacton`", "did you mean `reaction`?")]
#[case("timing: { reaction: 300 }\n", ":3:21: a time has a unit", "write it as 100ms")]
#[case("timing: { patience: 0 }\n", ":3:21: the factor `patience` is 1 to 1000", "")]
#[case("tolerance: { speeds: 5 }\n", ":3:14: unknown tolerance of ours `speeds`", "`speed`?")]
#[case("printed: { reaction: 5ms }\n", ":3:1: unknown key of a bench file `printed`", "")]
#[case("position_noise: -1\n", ":3:17: -1 is out of range for a noise", "")]
#[case("consent: { factory_rest: true }\n", ":3:12: unknown key of consent `factory_rest`", "`factory_reset`?")]
#[case("consent: { set_ip: false }\n", ":3:20: `set_ip` is `true` or left out", "")]
#[case("consent: { nvm_write: many }\n", ":3:23: ", "")]
#[case("stand: {}\n", ":3:8: `stand` is empty", "the bench has no stand")]
#[case(
    "stand: { hooks: { pwoer: 'x {value}' } }\n",
    ":3:19: unknown name of the stand `pwoer`",
    "did you mean `power`?"
)]
#[case("stand: { hooks: { fault.x: 'x {value}' } }\n", ":3:19: unknown name of the stand `fault.x`", "")]
#[case("stand:\n  hooks:\n    power: relay on\n", ":5:12: the command of `power` does not use `{value}`", "up or down")]
#[case("stand:\n  hooks:\n    power: relay {valeu}\n", ":5:12: unknown placeholder `{valeu}`", "`{value}`?")]
#[case("stand:\n  hooks:\n    renew: x {value}\n", ":5:12: `renew` has no placeholder `{value}`", "")]
#[case("stand:\n  hooks:\n    power: \"relay 'on {value}\"\n", ":5:12: the quote ' is not closed", "")]
#[case("stand: { ask: [counter.x] }\n", ":3:16: unknown name of the stand `counter.x`", "")]
#[case("stand: { ask: [clock] }\n", ":3:16: an operator cannot serve `clock`", "use a hook")]
#[case("stand: { ask: [power, power] }\n", ":3:23: `power` is listed twice in ask", "")]
#[case("stand:\n  hooks:\n    power: r {value}\n  ask: [power]\n", ":6:9: `power` already has a hook", "")]
#[case("stand: { ask: [turn] }\n", ":3:10: the accuracy of `turn` is missing", "in hardware steps")]
#[case("stand: { shaft: [hand] }\n", ":3:10: no operator is asked to turn the shaft by hand", "write `ask: [turn]`")]
#[case("stand: { shaft: [position(±1)] }\n", ":3:10: no hook positions the shaft", "")]
#[case("stand: { ask: [turn], shaft: [position] }\n", ":3:31: the accuracy is missing in `position`", "`position(±2)`")]
#[case(
    "stand: { ask: [turn], shaft: [positon(±1)] }\n",
    ":3:31: unknown ability of the shaft `positon`",
    "`position`?"
)]
#[case("stand: { ask: [turn], shaft: [hand, hand] }\n", ":3:37: `hand` is listed twice in shaft", "")]
fn an_error_has_its_position_and_a_suggestion(#[case] more: &str, #[case] begins: &str, #[case] part: &str) {
    let sum = more.bytes().fold(7u32, |sum, octet| sum.wrapping_mul(31).wrapping_add(octet.into()));
    let folder = Folder::new(&format!("mistake-{sum:x}"));
    let message = loaded(&folder, &format!("{SHORTEST}{more}")).err().unwrap_or_else(|| panic!("it loads: {more}"));
    let path = folder.join("bench.yaml").display().to_string();
    let rest =
        message.strip_prefix(&path).unwrap_or_else(|| panic!("the message does not start with the file: {message}"));
    assert!(rest.starts_with(begins), "{message}");
    assert!(rest.contains(part), "{message}");
}

#[rstest]
#[case("link: nic:eth1\n", "a bench file needs the key `device`")]
#[case("device: lika-xac77-profinet/xac7718\n", "a bench file needs the key `link`")]
#[case("device: lika-xac77-profinet\nlink: nic:e\n", "has several variants")]
#[case("device: lika-xac77-profinet/xac7719\nlink: nic:e\n", "did you mean `xac7718`?")]
#[case("device: lika-xac88-profinet/xac7718\nlink: nic:e\n", "did you mean `lika-xac77-profinet`?")]
#[case("device: lika-xac77-profinet/xac7718\nlink: nik:e\n", "did you mean `nic`?")]
#[case("device: lika-xac77-profinet/xac7718\nlink: nic:\n", "")]
#[case(
    "device: lika-xac77-profinet/xac7718\nlink: eth1\n",
    "a link must be `nic:INTERFACE`, `socket:ADDRESS`, `serial:TTY` or `app:COMMAND`"
)]
#[case("", "the file is empty")]
#[case("[]", "a bench file is a mapping `{ ... }`, not a list")]
#[case("device: [", "this is no YAML")]
fn the_required_keys_are_checked(#[case] text: &str, #[case] part: &str) {
    let folder = Folder::new(&format!("head-{}-{}", text.len(), part.len()));
    let message = loaded(&folder, text).expect_err("it does not load");
    assert!(message.contains(part), "{message}");
}

#[test]
fn all_errors_are_reported_at_once() {
    let text = format!("{SHORTEST}ip: x\nfirmware: y\nlacks: [z]\nstand: {{ ask: [led.x], hooks: {{ power: r }} }}\n");
    let message = loaded(&Folder::new("all"), &text).expect_err("it does not load");
    for part in
        ["is not an IPv4 address", "is not a firmware", "unknown record", "unknown name of the stand", "does not use"]
    {
        assert!(message.contains(part), "{part} is missing:\n{message}");
    }
}

#[test]
fn a_missing_or_binary_file_is_reported() {
    let folder = Folder::new("no-text");
    let message = |path: &Path| read(path, manuals()).expect_err("it does not load").to_string();
    assert!(message(&folder.write("b.yaml", [0xFF, 0xFE])).ends_with("b.yaml: the file is not UTF-8 text"));
    assert!(message(&folder.join("gone.yaml")).contains("gone.yaml: No such file"));
}

/// No prefix of the example panics, and a prefix that loads names the same manual.
#[test]
fn every_prefix_is_read_without_a_panic() {
    let folder = Folder::new("prefixes");
    let whole = loaded(&folder, EXAMPLE).expect("the example loads");
    for end in (0..EXAMPLE.len()).filter(|end| EXAMPLE.is_char_boundary(*end)).step_by(3) {
        if let Ok(bench) = loaded(&folder, &EXAMPLE[..end]) {
            assert_eq!(bench.claim.manual, whole.claim.manual, "cut at {end}");
        }
    }
}

/// Changing one letter of any meaningful word is an error that is reported.
#[test]
fn every_changed_word_is_noticed() {
    let folder = Folder::new("letters");
    // Names that only the bench defines, contents of web pages, and commands of hooks.
    let pages = ["path: ", "position: \"", "value: \""];
    let hooks = ["power:", "fault.memory:", "turn:", "shaft.counts:", "shaft.speed:"];
    let free = [&["station_name:"], &pages[..], &hooks[..]].concat();
    let (mut unnoticed, mut count, mut start) = (Vec::new(), 0, 0);
    for line in EXAMPLE.split_inclusive('\n') {
        let code = line.split('#').next().unwrap_or_default();
        let keys_only = free.iter().any(|key| code.trim_start().starts_with(key));
        let end = if keys_only { code.find(':').unwrap_or(code.len()) } else { code.len() };
        let letters = code[..end].char_indices().filter(|(_, c)| c.is_ascii_alphabetic());
        for (at, c) in letters {
            let is_mac =
                code.contains("mac: ") && c.is_ascii_hexdigit() && at > code.find("mac").unwrap_or_default() + 3;
            // Any interface name and any MAC address are valid.
            if is_mac || (code.starts_with("link: nic:") && at >= "link: nic:".len()) {
                continue;
            }
            count += 1;
            let new = if c == 'q' { 'w' } else { 'q' };
            let changed = start + at;
            let text = format!("{}{new}{}", &EXAMPLE[..changed], &EXAMPLE[changed + 1..]);
            if loaded(&folder, &text).is_ok() {
                unnoticed.push(format!("column {} of {}", at + 1, line.trim_end()));
            }
        }
        start += line.len();
    }
    assert!(count > 300, "only {count} letters were changed");
    assert!(unnoticed.is_empty(), "{} of {count} went unnoticed:\n{}", unnoticed.len(), unnoticed.join("\n"));
}

#[test]
fn the_schema_has_the_bench_file() {
    let schema = schema();
    let bench = &schema["$defs"]["BENCH"];
    assert_eq!(bench["required"], serde_json::json!(["device", "link"]));
    assert_eq!(bench["properties"]["stand"]["$ref"], "#/$defs/BENCH_STAND");
    assert!(schema["x-encspec"]["hooks"]["led.NAME"].is_string());
}
