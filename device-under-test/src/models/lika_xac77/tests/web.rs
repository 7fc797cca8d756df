//! The web pages, asked without a network.

use super::*;
use alloc::string::String;
use wire::http;

/// What is seen of the web server on a walk through all of its pages.
pub(super) fn walk(seen: &mut Vec<u64>, bug: Option<&str>) {
    let mut bench = Bench::alone(MULTITURN, bug, 0x0123_4567);
    let mut look = |bench: &mut Bench| {
        seen.push(bench.encoder.serves_pages().into());
        for path in ["/", "/information.htm", "/parameters.htm", "/position.htm", "/preset.htm"] {
            let (status, page) = bench.page(path);
            seen.push(status.into());
            seen.extend(page.bytes().map(u64::from));
        }
        seen.extend((0..30).map(|_| u64::from(bench.frame().xist1)));
        seen.extend(bench.preset_value_in_octets().into_iter().map(u64::from));
    };
    look(&mut bench);
    for (bits, units, range) in [(0x2B, 4096, 1 << 24), (0x22, 65536, 1 << 30)] {
        bench.connect(81, &record(bits, units, range)).ok();
        bench.act(StandAction::ShaftSpeed(60.0));
        look(&mut bench);
    }
    let mut say = Vec::new();
    for entry in ["1000", "1000", "0x20", "G", "", "123456789"] {
        say.extend(bench.enter(entry).bytes().map(u64::from));
        look(&mut bench);
    }
    bench.power_cycle();
    look(&mut bench);
    for password in ["LIKA", "lika"] {
        say.extend(bench.send("/upgrade.htm", "password", password).bytes().map(u64::from));
        look(&mut bench);
    }
    seen.append(&mut say);
}

impl Bench {
    /// The answer to a read of P65000, which a bug may have made unreadable.
    fn preset_value_in_octets(&mut self) -> Vec<u8> {
        let (mut request, mut answer) = (Vec::new(), Vec::new());
        Request::read_values(7, 1, [ParameterAddress::value(65000, 0)].to_vec()).write(&mut request);
        let written = self.encoder.write_record(self.now, access(0xB02E), &request);
        let read = self.encoder.read_record(self.now, access(0xB02E), &mut answer);
        answer.extend([written, read].map(|done| u8::from(done.is_ok())));
        answer
    }

    fn page(&mut self, path: &str) -> (u16, String) {
        let response = self.encoder.page(self.now, &http::Request::get(path));
        (response.status, String::from_utf8(response.body).expect("a text"))
    }

    fn send(&mut self, path: &str, field: &str, text: &str) -> String {
        let response = self.encoder.page(self.now, &http::Request::post(path, &[(field, text)]));
        assert_eq!(response.status, 200);
        String::from_utf8(response.body).expect("a text")
    }

    fn enter(&mut self, value: &str) -> String {
        self.send("/preset.htm", "value", value)
    }
}

#[test]
fn the_information_page_shows_the_bits_of_the_record_in_force() {
    let mut bench = Bench::connected(None, 0);
    assert!(bench.page("/information.htm").1.contains("<td>Class 4 functionality</td><td>1</td>"));
    bench.connect(81, &record(0x0D, 4096, 1 << 24)).expect("the record is right");
    let (_, page) = bench.page("/information.htm");
    for (name, value) in [
        ("Code sequence", 1),
        ("Class 4 functionality", 0),
        ("G1_XIST1 preset control", 1),
        ("Scaling function control", 1),
        ("Alarm channel control", 0),
        ("Compatibility mode", 0),
        ("Measuring units / Revolution", 4096),
        ("Total measuring range", 1 << 24),
        ("Maximum Master Sign-Of-Life failures", 1),
        ("Velocity measuring units", 0),
    ] {
        assert!(page.contains(&alloc::format!("<td>{name}</td><td>{value}</td>")), "{name} {value} in {page}");
    }
}

#[test]
fn the_position_page_shows_the_position_with_its_preset() {
    let mut bench = Bench::connected(None, 5);
    assert!(bench.page("/position.htm").1.contains("<td>5</td>"));
    bench.preset(0x1234, 0);
    assert!(bench.page("/position.htm").1.contains("<td>4660</td>"));
}

#[test]
fn an_entry_is_the_preset_value_and_stored_at_once() {
    let mut bench = Bench::connected(None, 5);
    assert!(bench.enter("1000").contains("is stored"));
    assert_eq!(bench.value(65000, 0), 4096);
    let writes = bench.encoder.counter(bench.now, "nvm_writes");
    assert!(bench.enter("1000").contains("already stored"));
    assert_eq!(bench.encoder.counter(bench.now, "nvm_writes"), writes);
    // A value that is stored and not in use is in use again.
    bench.write(65000, 0x2222).expect("P65000 is written");
    assert!(bench.enter("1000").contains("already stored"));
    assert_eq!(bench.value(65000, 0), 4096);
    assert_eq!(bench.frame().xist1, 5);
    bench.power_cycle();
    bench.connect(81, &record(0x22, 65536, 1 << 30)).expect("the default record is right");
    assert_eq!(bench.value(65000, 0), 4096);
}

#[test]
fn what_is_no_hexadecimal_number_changes_nothing() {
    let mut bench = Bench::connected(None, 5);
    bench.enter("ABCD");
    for entry in ["0x1000", "12G4", "", "123456789", "-1", "+1", " 1"] {
        assert!(bench.enter(entry).contains("no hexadecimal number"), "{entry}");
        assert_eq!(bench.value(65000, 0), 0xABCD, "{entry}");
    }
}

#[test]
fn a_memory_that_takes_nothing_is_told() {
    let mut bench = Bench::connected(None, 5);
    bench.fault("memory", true);
    assert!(bench.enter("1000").contains("could not be stored"));
    assert_eq!(bench.value(65000, 0), 0);
}

#[test]
fn the_password_stops_the_server_until_the_power_goes() {
    let mut bench = Bench::alone(SINGLETURN, None, 0);
    for password in ["LIKA", "", "lika "] {
        assert!(bench.send("/upgrade.htm", "password", password).contains("Wrong password"));
        assert!(bench.encoder.serves_pages());
    }
    assert!(bench.send("/upgrade.htm", "password", "lika").contains("background-color: red"));
    assert!(!bench.encoder.serves_pages());
    bench.power_cycle();
    assert!(bench.encoder.serves_pages());
}

#[test]
fn what_is_not_there_is_not_found() {
    let mut bench = Bench::alone(SINGLETURN, None, 0);
    assert_eq!(bench.page("/nowhere").0, 404);
    let deleted = http::Request { method: "DELETE".into(), ..http::Request::get("/") };
    assert_eq!(bench.encoder.page(bench.now, &deleted).status, 405);
}
