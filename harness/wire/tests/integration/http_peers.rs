//! HTTP messages of other programs, recorded: requests of curl 7 and Python's `http.client`, responses of Python's `http.server`.

use encspec_wire::http::{HttpRequest, HttpResponse, ParseProgress};
use rstest::rstest;

const HEAD: &str =
    "HTTP/1.1 200 OK\r\nServer: python\r\nDate: Mon, 01 Jan 2024 00:00:00 GMT\r\nContent-Type: text/html\r\n";

fn request(octets: &[u8]) -> HttpRequest {
    match HttpRequest::read(octets) {
        ParseProgress::Whole(request) => request,
        other => panic!("not a complete request: {other:?}"),
    }
}

#[test]
fn requests() {
    let curl = b"GET /position.htm HTTP/1.1\r\nHost: 127.0.0.1:34079\r\nAccept: */*\r\nUser-Agent: curl\r\n\r\n";
    assert_eq!(request(curl), HttpRequest::get("/position.htm"));
    let python = b"GET / HTTP/1.1\r\nHost: 127.0.0.1:34079\r\nAccept-Encoding: identity\r\n\r\n";
    assert_eq!(request(python), HttpRequest::get("/"));
    let form = b"POST /preset.htm HTTP/1.1\r\nHost: 127.0.0.1:34079\r\nAccept: */*\r\nUser-Agent: curl\r\n\
        Content-Length: 35\r\nContent-Type: application/x-www-form-urlencoded\r\n\r\n\
        value=1+0%2B%26%C3%A9&password=lika";
    let form = request(form);
    assert_eq!((form.method.as_str(), form.path.as_str()), ("POST", "/preset.htm"));
    assert_eq!(form.field("value").as_deref(), Some("1 0+&\u{e9}"));
    assert_eq!(form.field("password").as_deref(), Some("lika"));
    assert_eq!(form.field("other"), None);
    // The body of the form is that of curl.
    let written = HttpRequest::post("/preset.htm", &[("value", "1 0+&\u{e9}"), ("password", "lika")]);
    assert_eq!(written.body, form.body);
}

#[rstest]
#[case::length("Content-Length: 15\r\n\r\n<html>17</html>", true)]
#[case::chunked("Transfer-Encoding: chunked\r\n\r\n6\r\n<html>\r\n9\r\n17</html>\r\n0\r\n\r\n", true)]
#[case::close("Connection: close\r\n\r\n<html>17</html>", false)]
fn responses(#[case] rest: &str, #[case] has_length: bool) {
    let octets = format!("{HEAD}{rest}").into_bytes();
    let whole = ParseProgress::Whole(HttpResponse::page(200, "<html>17</html>"));
    assert_eq!(HttpResponse::read(&octets, true), whole);
    assert_eq!(HttpResponse::read(&octets, false), if has_length { whole } else { ParseProgress::More });
}

#[rstest]
#[case::request(b"GET / HTTP/1.1\r\nHost: x\r\n\r\n")]
#[case::other_protocol(b"SSH-2.0-OpenSSH_9.2\r\n\r\n")]
#[case::status(b"HTTP/1.1 twohundred OK\r\n\r\n")]
#[case::length(b"HTTP/1.1 200 OK\r\nContent-Length: many\r\n\r\n")]
fn invalid_responses(#[case] octets: &[u8]) {
    assert!(matches!(HttpResponse::read(octets, true), ParseProgress::Bad(_)));
}

#[test]
fn invalid_requests() {
    assert!(matches!(HttpRequest::read(b"HTTP/1.1 200 OK\r\n\r\n"), ParseProgress::Bad(_)));
    assert!(matches!(HttpRequest::read(b"GET /\r\n\r\n"), ParseProgress::Bad(_)));
    assert!(matches!(HttpRequest::read(&[0xFF, b'\r', b'\n', b'\r', b'\n']), ParseProgress::Bad(_)));
}
