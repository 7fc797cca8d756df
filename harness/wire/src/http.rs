//! The subset of HTTP/1.1 that web servers in devices use (RFC 9112), and the fields of a form.
//!
//! A message may arrive in pieces: the parsers return whether it is complete. This module must not know pages, nor connections.

use alloc::format;
use alloc::string::String;
use alloc::vec::Vec;
use core::fmt::Write;

/// The TCP port of a web server.
pub const PORT: u16 = 80;
/// The longest header section, in bytes.
const LONGEST_HEAD: usize = 8192;
const END_OF_HEAD: &[u8] = b"\r\n\r\n";

/// The result of parsing the bytes received so far.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ParseProgress<T> {
    /// The message is complete.
    Whole(T),
    /// The message is incomplete.
    More,
    /// The message is invalid; the text says why.
    Bad(&'static str),
}

/// An HTTP request.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HttpRequest {
    /// `GET`, `POST` or another.
    pub method: String,
    /// The request target, which starts with a slash.
    pub path: String,
    /// The body, for instance the fields of a form.
    pub body: Vec<u8>,
}

/// An HTTP response.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct HttpResponse {
    /// The status code.
    pub status: u16,
    /// The body, for instance an HTML page.
    pub body: Vec<u8>,
}

impl HttpRequest {
    /// A GET request for a page.
    pub fn get(path: &str) -> HttpRequest {
        HttpRequest { method: "GET".into(), path: path.into(), body: Vec::new() }
    }

    /// A POST request with the fields of a form.
    pub fn post(path: &str, fields: &[(&str, &str)]) -> HttpRequest {
        HttpRequest { method: "POST".into(), path: path.into(), body: form(fields).into_bytes() }
    }

    /// Serializes the request to the server `host`, with `Connection: close`. It accepts no compressed response.
    pub fn to_vec(&self, host: &str) -> Vec<u8> {
        let HttpRequest { method, path, body } = self;
        let mut head =
            format!("{method} {path} HTTP/1.1\r\nHost: {host}\r\nConnection: close\r\nAccept-Encoding: identity\r\n");
        if method == "POST" || !body.is_empty() {
            head.push_str("Content-Type: application/x-www-form-urlencoded\r\n");
            // Writing to a String cannot fail.
            write!(head, "Content-Length: {}\r\n", body.len()).ok();
        }
        head.push_str("\r\n");
        let mut octets = head.into_bytes();
        octets.extend_from_slice(body);
        octets
    }

    /// Parses a request from all bytes received so far.
    pub fn read(octets: &[u8]) -> ParseProgress<HttpRequest> {
        let (head, body) = match split(octets) {
            ParseProgress::Whole(parts) => parts,
            ParseProgress::More => return ParseProgress::More,
            ParseProgress::Bad(why) => return ParseProgress::Bad(why),
        };
        let mut words = head.first_line().split(' ');
        let (Some(method), Some(path), Some(version), None) = (words.next(), words.next(), words.next(), words.next())
        else {
            return ParseProgress::Bad("the first line is not a method, a path and a version");
        };
        if !path.starts_with('/') || !version.starts_with("HTTP/1.") {
            return ParseProgress::Bad("the first line is not that of an HTTP/1 request");
        }
        let body = match head.length() {
            Err(why) => return ParseProgress::Bad(why),
            Ok(length) => body.get(..length.unwrap_or(0)),
        };
        match body {
            Some(body) => {
                ParseProgress::Whole(HttpRequest { method: method.into(), path: path.into(), body: body.into() })
            }
            None => ParseProgress::More,
        }
    }

    /// The field `name` of the form in the body.
    pub fn field(&self, name: &str) -> Option<String> {
        let body = core::str::from_utf8(&self.body).ok()?;
        let mut fields = body.split('&').map(|field| field.split_once('=').unwrap_or((field, "")));
        fields.find(|(known, _)| decoded(known) == name).map(|(_, value)| decoded(value))
    }
}

impl HttpResponse {
    /// A response with an HTML page.
    pub fn page(status: u16, html: impl Into<Vec<u8>>) -> HttpResponse {
        HttpResponse { status, body: html.into() }
    }

    /// Serializes the response, with `Connection: close`.
    pub fn to_vec(&self) -> Vec<u8> {
        let reason = match self.status {
            200 => "OK",
            400 => "Bad Request",
            401 => "Unauthorized",
            403 => "Forbidden",
            404 => "Not Found",
            405 => "Method Not Allowed",
            _ => "",
        };
        let head = format!(
            "HTTP/1.1 {} {reason}\r\nContent-Type: text/html\r\nContent-Length: {}\r\nCache-Control: no-store\r\nConnection: close\r\n\r\n",
            self.status,
            self.body.len()
        );
        let mut octets = head.into_bytes();
        octets.extend_from_slice(&self.body);
        octets
    }

    /// Parses a response from all bytes received so far; `closed` means that no more will arrive.
    pub fn read(octets: &[u8], closed: bool) -> ParseProgress<HttpResponse> {
        let more = || {
            if closed { ParseProgress::Bad("the connection was closed before its end") } else { ParseProgress::More }
        };
        let mut rest = octets;
        let (head, body, status) = loop {
            let (head, body) = match split(rest) {
                ParseProgress::Whole(parts) => parts,
                ParseProgress::More => return more(),
                ParseProgress::Bad(why) => return ParseProgress::Bad(why),
            };
            let mut words = head.first_line().split(' ');
            let version = words.next().unwrap_or_default();
            let status = words.next().filter(|word| word.len() == 3).and_then(|word| word.parse::<u16>().ok());
            let Some(status) = status.filter(|_| version.starts_with("HTTP/1.")) else {
                return ParseProgress::Bad("the first line is not that of an HTTP/1 response");
            };
            if !(100..200).contains(&status) {
                break (head, body, status);
            }
            // An interim response (1xx); the final response follows it.
            rest = body;
        };
        if matches!(status, 204 | 304) {
            return ParseProgress::Whole(HttpResponse { status, body: Vec::new() });
        }
        if head.field("content-encoding").is_some_and(|coding| !coding.eq_ignore_ascii_case("identity")) {
            return ParseProgress::Bad("its body is compressed");
        }
        if head.field("transfer-encoding").is_some_and(|coding| coding.eq_ignore_ascii_case("chunked")) {
            return match chunks(body) {
                ParseProgress::Whole(body) => ParseProgress::Whole(HttpResponse { status, body }),
                ParseProgress::More => more(),
                ParseProgress::Bad(why) => ParseProgress::Bad(why),
            };
        }
        match head.length() {
            Err(why) => ParseProgress::Bad(why),
            Ok(Some(length)) => match body.get(..length) {
                Some(body) => ParseProgress::Whole(HttpResponse { status, body: body.into() }),
                None => more(),
            },
            Ok(None) if closed => ParseProgress::Whole(HttpResponse { status, body: body.into() }),
            Ok(None) => ParseProgress::More,
        }
    }
}

/// The header section.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct HeaderSection<'a>(&'a str);

impl<'a> HeaderSection<'a> {
    fn first_line(self) -> &'a str {
        self.0.split("\r\n").next().unwrap_or_default()
    }

    /// The value of a header field; the name is case-insensitive.
    fn field(self, name: &str) -> Option<&'a str> {
        let mut fields = self.0.split("\r\n").skip(1).filter_map(|line| line.split_once(':'));
        fields.find(|(known, _)| known.trim().eq_ignore_ascii_case(name)).map(|(_, value)| value.trim())
    }

    fn length(self) -> Result<Option<usize>, &'static str> {
        let length = self.field("content-length").map(str::parse::<usize>).transpose();
        length.map_err(|_| "Content-Length is not a number")
    }
}

/// Splits the bytes into the header section and what follows it.
fn split(octets: &[u8]) -> ParseProgress<(HeaderSection<'_>, &[u8])> {
    let end = octets.windows(END_OF_HEAD.len()).take(LONGEST_HEAD).position(|window| window == END_OF_HEAD);
    let Some(end) = end else {
        return if octets.len() > LONGEST_HEAD {
            ParseProgress::Bad("its header section is longer than 8192 bytes")
        } else {
            ParseProgress::More
        };
    };
    let (head, rest) = octets.split_at(end);
    match core::str::from_utf8(head) {
        Ok(head) => ParseProgress::Whole((HeaderSection(head), &rest[END_OF_HEAD.len()..])),
        Err(_) => ParseProgress::Bad("its header section is not UTF-8"),
    }
}

/// Decodes a body with chunked transfer coding (RFC 9112, 7.1).
fn chunks(mut octets: &[u8]) -> ParseProgress<Vec<u8>> {
    let mut body = Vec::new();
    loop {
        let Some(end) = octets.windows(2).position(|window| window == b"\r\n") else { return ParseProgress::More };
        let line = core::str::from_utf8(&octets[..end]).unwrap_or_default();
        let digits = line.split(';').next().unwrap_or_default().trim();
        let Ok(length) = usize::from_str_radix(digits, 16) else {
            return ParseProgress::Bad("the length of a chunk is not a hexadecimal number");
        };
        octets = &octets[end + 2..];
        if length == 0 {
            return ParseProgress::Whole(body);
        }
        let Some(chunk) = octets.get(..length) else { return ParseProgress::More };
        body.extend_from_slice(chunk);
        octets = octets.get(length + 2..).unwrap_or_default();
    }
}

/// Encodes the fields of a form (`application/x-www-form-urlencoded`).
fn form(fields: &[(&str, &str)]) -> String {
    let mut text = String::new();
    for (name, value) in fields {
        if !text.is_empty() {
            text.push('&');
        }
        encode(name, &mut text);
        text.push('=');
        encode(value, &mut text);
    }
    text
}

fn encode(plain: &str, text: &mut String) {
    for octet in plain.bytes() {
        match octet {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'-' | b'.' | b'_' | b'~' => text.push(char::from(octet)),
            b' ' => text.push('+'),
            // Writing to a String cannot fail.
            _ => write!(text, "%{octet:02X}").unwrap_or_default(),
        }
    }
}

/// Decodes a percent-encoded text; replaces bytes that are not UTF-8.
fn decoded(text: &str) -> String {
    let mut octets = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let [first, tail @ ..] = rest {
        let escaped = tail.get(..2).and_then(|digits| core::str::from_utf8(digits).ok());
        let escaped = escaped.filter(|digits| digits.bytes().all(|digit| digit.is_ascii_hexdigit()));
        match (first, escaped.and_then(|digits| u8::from_str_radix(digits, 16).ok())) {
            (b'%', Some(octet)) => {
                octets.push(octet);
                rest = &tail[2..];
            }
            (b'+', _) => {
                octets.push(b' ');
                rest = tail;
            }
            _ => {
                octets.push(*first);
                rest = tail;
            }
        }
    }
    String::from_utf8_lossy(&octets).into_owned()
}

#[cfg(test)]
mod tests {
    use super::*;
    use testing::every_prefix_and_flip;

    #[test]
    fn parsers_never_panic() {
        let request = HttpRequest::post("/a.htm", &[("value", "10 00")]).to_vec("192.168.0.10");
        let fixed = HttpResponse::page(200, "<html>17</html>").to_vec();
        let chunked = b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n6\r\n<html>\r\n2;x\r\n17\r\n0\r\n\r\n";
        every_prefix_and_flip(&request, |octets| {
            if let ParseProgress::Whole(request) = HttpRequest::read(octets) {
                request.field("value");
            }
        });
        for answer in [&fixed[..], &chunked[..]] {
            for closed in [false, true] {
                every_prefix_and_flip(answer, |octets| drop(HttpResponse::read(octets, closed)));
            }
        }
    }

    /// Any number of them uses constant stack.
    #[test]
    fn interim_responses_are_skipped() {
        let octets = [&b"HTTP/1.1 100\r\n\r\n".repeat(50_000)[..], &HttpResponse::page(200, "17").to_vec()].concat();
        assert_eq!(HttpResponse::read(&octets, false), ParseProgress::Whole(HttpResponse::page(200, "17")));
    }

    #[test]
    fn a_compressed_page_cannot_be_read() {
        let octets = |coding| format!("HTTP/1.1 200 OK\r\nContent-Encoding: {coding}\r\nContent-Length: 2\r\n\r\n17");
        let read = |coding| HttpResponse::read(octets(coding).as_bytes(), true);
        assert_eq!(read("gzip"), ParseProgress::Bad("its body is compressed"));
        assert_eq!(read("identity"), ParseProgress::Whole(HttpResponse::page(200, "17")));
    }

    #[test]
    fn every_prefix_of_a_message_is_incomplete() {
        let request = HttpRequest::post("/a.htm", &[("value", "1000")]).to_vec("192.168.0.10");
        let answer = HttpResponse::page(200, "<html></html>").to_vec();
        assert!((0..request.len()).all(|end| HttpRequest::read(&request[..end]) == ParseProgress::More));
        assert!((0..answer.len()).all(|end| HttpResponse::read(&answer[..end], false) == ParseProgress::More));
        assert!(matches!(HttpResponse::read(&answer[..answer.len() - 1], true), ParseProgress::Bad(_)));
    }

    #[test]
    fn an_endless_header_section_is_an_error() {
        assert!(matches!(HttpRequest::read(&[b'a'; LONGEST_HEAD + 1]), ParseProgress::Bad(_)));
        assert_eq!(HttpRequest::read(&[b'a'; LONGEST_HEAD]), ParseProgress::More);
    }
}
