//! Generated bench files load, whatever the station reports.

use super::super::slaves::FoundSlave;
use super::init::{FoundDevice, KnownDevice, choose_station, fitting_manual};
use super::*;
use ::live::discover::DiscoveredStation;
use results::bench_file::{BenchFile, DeviceClaim, LinkSpec, read, read_alone};
use rstest::rstest;
use std::fs;
use suite::model::Manual;
use suite_yaml::load;
use wire::ethernet::Mac;
use wire::profinet::dcp::block::IpParameter;

fn found(last: u8, name: &str, ids: Option<(u16, u16)>) -> DiscoveredStation {
    DiscoveredStation {
        mac: Mac([2, 0, 0, 0, 1, last]),
        name: name.into(),
        ip: None,
        ids,
        station_type: "LIKA ROTACOD".into(),
        roles: vec!["device"],
    }
}

/// The bench file of a station whose variants `left` are left.
fn written(link: &LinkSpec, found: &DiscoveredStation, manuals: &[Manual], left: &[usize]) -> String {
    let bench = BenchFile::bare(link.clone(), DeviceClaim { manual: String::new(), variant: String::new() });
    let found = FoundDevice::Station(found.clone());
    let known = fitting_manual(&found, manuals, &[], None).map_err(|stop| stop.message).expect("no manual is named");
    text::bench_file(&bench, &found, &KnownDevice { left: left.to_vec(), ..known }, None)
}

/// The text with commented-out keys enabled, so that proposed values are loaded too.
fn proposals(text: &str) -> String {
    let keys = ["station_name:"];
    let line = |line: &str| match line.strip_prefix("# ").filter(|rest| keys.iter().any(|key| rest.starts_with(key))) {
        Some(rest) => rest.to_owned(),
        None => line.to_owned(),
    };
    text.lines().map(|text| line(text) + "\n").collect()
}

#[rstest]
#[case("enc-1", Some((0x0239, 1)), "device: lika-xac77-profinet/xac7718\n", "\nstation_name: enc-1\n")]
#[case("", Some((0x0239, 1)), "device: lika-xac77-profinet/xac7718\n", "\n# station_name: encoder-1\n")]
#[case("x: [y]\n\u{1b}", Some((0x0239, 9)), "is it the right one?\n# Its variant", "\n# station_name: encoder-1\n")]
fn generated_bench_files_load(
    #[case] name: &str,
    #[case] ids: Option<(u16, u16)>,
    #[case] device: &str,
    #[case] station: &str,
) {
    let manuals = load(&suites::sources(), None).expect("the shipped suites load");
    let mut station_found = found(1, name, ids);
    let link = LinkSpec::Nic("eth1".into());
    for ip in
        [None, Some(IpParameter { address: [10, 1, 2, 3].into(), mask: [255, 255, 0, 0].into(), ..IpParameter::NONE })]
    {
        station_found.ip = ip;
        let text = written(&link, &station_found, &manuals, &[0]);
        assert!(text.contains(device) && text.contains(station), "{text}");
        let path = std::env::temp_dir().join(format!("encspec-init-{}-{}.yaml", std::process::id(), name.len()));
        for text in [text.clone(), proposals(&text)] {
            fs::write(&path, &text).expect("it can be written");
            let bench = read(&path, &manuals).unwrap_or_else(|errors| panic!("{errors}"));
            assert_eq!((bench.link, bench.mac), (link.clone(), Some(station_found.mac)));
            let expected = ip.map_or([192, 168, 0, 10], |_| [10, 1, 2, 3]);
            assert_eq!(bench.ip, Some(expected.into()));
        }
        fs::remove_file(&path).expect("it can be removed");
    }
}

/// A suite that its user has given is meant, although a built-in one is of the same device.
#[test]
fn the_suite_of_the_user_comes_before_a_built_in_one() {
    let load = || load(&suites::sources(), None).expect("the shipped suites load");
    let mut manuals = load();
    let mut mine =
        load().into_iter().find(|manual| manual.device.name == "lika-xac77-profinet").expect("it is shipped");
    let mut device = (*mine.device).clone();
    device.name = "mine".into();
    mine.device = device.into();
    manuals.push(mine);
    let found = FoundDevice::Station(found(1, "enc-1", Some((0x0239, 1))));
    let fitting = |own: &[String]| {
        let known =
            fitting_manual(&found, &manuals, own, None).map_err(|stop| stop.message).expect("no manual is named");
        known.manual.map(|manual| manual.device.name.clone())
    };
    assert_eq!(fitting(&["mine".into()]).as_deref(), Some("mine"));
    assert_eq!(fitting(&["elsewhere".into()]).as_deref(), Some("lika-xac77-profinet"));
}

#[test]
fn an_unknown_device_needs_a_description() {
    let manuals = load(&suites::sources(), None).expect("the shipped suites load");
    let unknown = found(1, "enc-1", Some((0x0493, 2)));
    let text = written(&LinkSpec::Socket("/run/qemu".into()), &unknown, &manuals, &[]);
    assert!(text.contains("\ndevice: none\ndescription: my-device.yaml\nlink: socket:/run/qemu\n"), "{text}");
    let path = std::env::temp_dir().join(format!("encspec-init-{}-none.yaml", std::process::id()));
    fs::write(&path, &text).expect("it can be written");
    let errors = read_alone(&path).expect_err("the description does not exist").to_string();
    assert!(errors.contains("my-device.yaml: No such file"), "{errors}");
    fs::remove_file(&path).expect("it can be removed");
}

/// A slave without a suite is not asked to describe itself as a PROFINET device.
#[test]
fn an_unknown_slave_needs_a_suite() {
    let link = LinkSpec::Serial("/dev/ttyUSB0".into());
    let bench = BenchFile::bare(link, DeviceClaim { manual: String::new(), variant: String::new() });
    let found = FoundDevice::Slave(FoundSlave { address: 5, ident: 0xABCD, masters: None });
    let text = text::bench_file(&bench, &found, &KnownDevice::default(), None);
    assert!(text.contains("encspec suite init --gsd FILE") && text.contains("\ndevice: my-slave\n"), "{text}");
    assert!(!text.contains("none") && !text.contains("profinet-io") && !text.contains("my-device.yaml"), "{text}");
}

#[test]
fn one_device_is_chosen_or_the_error_lists_all() {
    let stations = [found(1, "enc-1", None), found(2, "enc-2", None)];
    assert_eq!(choose_station(&stations[..1], None).map(|found| found.mac).ok(), Some(stations[0].mac));
    assert_eq!(choose_station(&stations, Some("enc-2")).map(|found| found.mac).ok(), Some(stations[1].mac));
    assert_eq!(choose_station(&stations, Some("02-00-00-00-01-02")).map(|found| found.mac).ok(), Some(stations[1].mac));
    let message = |meant| {
        choose_station(&stations, meant)
            .map(|found| found.mac)
            .map_err(|stop| stop.message)
            .expect_err("no single station")
    };
    assert!(message(None).contains("--station: 02:00:00:00:01:01 enc-1, 02:00:00:00:01:02 enc-2"));
    assert!(message(Some("enc-3")).starts_with("there is no station enc-3; found: 02:00:00:00:01:01 enc-1"));
    assert!(choose_station(&[], None).is_err_and(|stop| stop.message.starts_with("no device answered")));
}
