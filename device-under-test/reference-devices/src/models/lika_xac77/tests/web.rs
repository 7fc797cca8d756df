//! The web pages, requested without a network.

use super::*;

#[test]
fn the_information_page_shows_the_bits_of_the_record_in_force() {
    let mut bench = Xac77Bench::connected(None, 0);
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
    let mut bench = Xac77Bench::connected(None, 5);
    assert!(bench.page("/position.htm").1.contains("<td>5</td>"));
    bench.preset(0x1234, 0);
    assert!(bench.page("/position.htm").1.contains("<td>4660</td>"));
}

#[test]
fn entered_preset_value_is_in_use_and_stored_at_once() {
    let mut bench = Xac77Bench::connected(None, 5);
    assert!(bench.enter("1000").contains("is stored"));
    assert_eq!(bench.value(65000, 0), 4096);
    let writes = bench.encoder.counter(bench.now, "nvm_writes");
    assert!(bench.enter("1000").contains("already stored"));
    assert_eq!(bench.encoder.counter(bench.now, "nvm_writes"), writes);
    // A stored value that is not in use is used again.
    bench.write(65000, 0x2222).expect("P65000 is written");
    assert!(bench.enter("1000").contains("already stored"));
    assert_eq!(bench.value(65000, 0), 4096);
    assert_eq!(bench.frame().xist1, 5);
    bench.power_cycle();
    bench.connect(81, &record(0x22, 65536, 1 << 30)).expect("the default record is right");
    assert_eq!(bench.value(65000, 0), 4096);
}

#[test]
fn entry_that_is_not_hexadecimal_changes_nothing() {
    let mut bench = Xac77Bench::connected(None, 5);
    bench.enter("ABCD");
    for entry in ["0x1000", "12G4", "", "123456789", "-1", "+1", " 1"] {
        assert!(bench.enter(entry).contains("no hexadecimal number"), "{entry}");
        assert_eq!(bench.value(65000, 0), 0xABCD, "{entry}");
    }
}

#[test]
fn failed_write_to_memory_is_reported() {
    let mut bench = Xac77Bench::connected(None, 5);
    bench.fault("memory", true);
    assert!(bench.enter("1000").contains("could not be stored"));
    assert_eq!(bench.value(65000, 0), 0);
}

#[test]
fn password_stops_the_server_until_power_off() {
    let mut bench = Xac77Bench::alone(SINGLETURN, None, 0);
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
fn unknown_path_and_method_are_refused() {
    let mut bench = Xac77Bench::alone(SINGLETURN, None, 0);
    assert_eq!(bench.page("/nowhere").0, 404);
    let deleted = http::HttpRequest { method: "DELETE".into(), ..http::HttpRequest::get("/") };
    assert_eq!(bench.encoder.page(bench.now, &deleted).status, 405);
}
