//! The parameter manager of the base mode: it takes requests and keeps the response until it is fetched.
//!
//! Which parameters there are and what they hold is the affair of a [`Parameters`]. The order of the checks, the error
//! numbers and the way a response is fetched follow the PROFIdrive profile; the manuals print only numbers and names.

use alloc::vec::Vec;
use wire::profidrive::{
    Attribute, ErrorNumber, Format, ParameterAddress, ParameterError, ParameterValue, Request, RequestId, Response,
    ResponseId,
};

/// A parameter at one instant.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Parameter {
    /// In which format values are given: [`Format::WORD`], [`Format::DOUBLE_WORD`] or [`Format::OCTET_STRING`].
    pub format: Format,
    /// Whether its values are elements with a subindex; otherwise they are one value, of several octets for a string.
    pub is_array: bool,
    /// Whether it can be written.
    pub is_writable: bool,
    /// Its values.
    pub values: Vec<u64>,
}

/// What a parameter manager manages.
pub trait Parameters {
    /// The parameter of this number, if there is one.
    fn parameter(&self, number: u16) -> Option<Parameter>;

    /// Gives a writable parameter a value of its format, or says why not.
    fn write(&mut self, number: u16, value: u64) -> Result<(), ErrorNumber>;
}

/// Which checks the parameter manager makes; a bug is one that it leaves out.
#[derive(Clone, Copy, Debug)]
pub struct Rules {
    /// Unknown numbers are refused.
    pub number: bool,
    /// Other axes than 0 and 1 are refused.
    pub axis: bool,
    /// Other attributes than the value are refused.
    pub attribute: bool,
    /// Writing a read-only parameter is refused.
    pub access: bool,
    /// Elements behind the end of an array are refused.
    pub end_of_array: bool,
    /// A subindex is refused if the parameter is no array.
    pub array: bool,
    /// Whether a value in the first format is taken by a parameter of the second one.
    pub takes: fn(Format, Format) -> bool,
    /// Another number of values than of elements is refused.
    pub value_count: bool,
    /// The number of elements of a parameter that is no array may be 0.
    pub zero_elements: bool,
    /// The first element that is read, from the subindex and the number of elements.
    pub first_element: fn(u16, usize) -> u16,
    /// How many parameters of a request for values are answered.
    pub answered: usize,
    /// The reference of the response, from that of the request.
    pub reference: fn(u8) -> u8,
    /// After a refused parameter the others are written.
    pub goes_on_after_error: bool,
    /// Octets that are missing are missing, and not those of the request before.
    pub length: bool,
    /// A response that was fetched has gone.
    pub fetched_once: bool,
}

impl Default for Rules {
    fn default() -> Rules {
        Rules {
            number: true,
            axis: true,
            attribute: true,
            access: true,
            end_of_array: true,
            array: true,
            takes: is_of_type,
            value_count: true,
            zero_elements: true,
            first_element: |subindex, _| subindex,
            answered: usize::MAX,
            reference: |reference| reference,
            goes_on_after_error: true,
            length: true,
            fetched_once: true,
        }
    }
}

/// Why a request was not even answered.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BadRequest {
    /// Octets are missing.
    TooShort,
    /// It has no parameter, or more than [`MAX_PARAMETERS`].
    Count,
}

/// Parameters that a request may have; PROFIdrive, base mode.
pub const MAX_PARAMETERS: u8 = 39;
/// Elements that may be asked for at once; PROFIdrive, base mode.
pub const MAX_ELEMENTS: u8 = 234;
/// Octets of a request or response; PROFIdrive, base mode.
pub const MAX_OCTETS: usize = 240;

/// The parameter manager: the channel to the parameters of one drive object, one request at a time per requester.
#[derive(Clone, Debug)]
pub struct Manager<K> {
    responses: Vec<(K, Vec<u8>)>,
    buffer: Vec<u8>,
    rules: Rules,
}

impl<K: Copy + PartialEq> Manager<K> {
    /// A manager that was asked nothing yet.
    pub fn new(rules: Rules) -> Manager<K> {
        Manager { responses: Vec::new(), buffer: alloc::vec![0; MAX_OCTETS], rules }
    }

    /// Takes a request of `key` and keeps the response; an older one that was not fetched has gone.
    pub fn take(&mut self, key: K, octets: &[u8], parameters: &mut impl Parameters) -> Result<(), BadRequest> {
        self.forget(key);
        let copied = octets.len().min(MAX_OCTETS);
        self.buffer[..copied].copy_from_slice(&octets[..copied]);
        if octets.get(3).is_some_and(|count| *count == 0 || *count > MAX_PARAMETERS) {
            return Err(BadRequest::Count);
        }
        let octets = if self.rules.length { octets } else { &self.buffer };
        let request = Request::parse(octets).map_err(|_| BadRequest::TooShort)?;
        let mut response = answer(&request, parameters, &self.rules);
        response.header.reference = (self.rules.reference)(response.header.reference);
        let mut octets = Vec::new();
        response.write(&mut octets);
        self.responses.push((key, octets));
        Ok(())
    }

    /// The response for `key`, if one is waiting.
    pub fn fetch(&mut self, key: K) -> Option<Vec<u8>> {
        let at = self.responses.iter().position(|(of, _)| *of == key)?;
        match self.rules.fetched_once {
            true => Some(self.responses.swap_remove(at).1),
            false => Some(self.responses[at].1.clone()),
        }
    }

    /// Forgets what is waiting for `key`.
    pub fn forget(&mut self, key: K) {
        self.responses.retain(|(of, _)| *of != key);
    }
}

fn answer(request: &Request, parameters: &mut impl Parameters, rules: &Rules) -> Response {
    let header = &request.header;
    let refusal = match header.id {
        RequestId::REQUEST | RequestId::CHANGE if rules.axis && header.do_id > 1 => ErrorNumber::NO_SUCH_AXIS,
        RequestId::REQUEST => {
            let addresses = request.addresses.iter().take(rules.answered);
            let values = addresses.map(|address| read(address, parameters, rules));
            return Response::to_read(header, fit(values.collect()));
        }
        RequestId::CHANGE => {
            let mut outcomes = Vec::new();
            for (n, address) in request.addresses.iter().enumerate() {
                let stopped = !rules.goes_on_after_error && outcomes.iter().any(Result::is_err);
                outcomes.push(if stopped { Ok(()) } else { change(address, request.values.get(n), parameters, rules) });
            }
            return Response::to_change(header, &outcomes);
        }
        _ => ErrorNumber::UNKNOWN_REQUEST,
    };
    let id = if header.id == RequestId::CHANGE { ResponseId::CHANGE_FAILED } else { ResponseId::REQUEST_FAILED };
    let error = ParameterValue::refused(ParameterError { number: refusal, subindex: None });
    Response::new(header, id, request.addresses.iter().map(|_| error.clone()).collect())
}

/// Makes the values fit into a response: one that would leave no room for the others is refused as too long.
fn fit(mut values: Vec<ParameterValue>) -> Vec<ParameterValue> {
    let too_long = ParameterValue::refused(ParameterError { number: ErrorNumber::RESPONSE_TOO_LONG, subindex: None });
    let error_octets = 2 + too_long.data.len();
    let mut left = MAX_OCTETS - 4 - error_octets * values.len();
    for value in &mut values {
        let more = (2 + value.data.len().next_multiple_of(2)).saturating_sub(error_octets);
        match left.checked_sub(more) {
            Some(rest) => left = rest,
            None => *value = too_long.clone(),
        }
    }
    values
}

fn read(address: &ParameterAddress, parameters: &impl Parameters, rules: &Rules) -> ParameterValue {
    match elements(address, parameters, false, rules) {
        Ok((parameter, elements)) => {
            let elements: Vec<u64> = elements.map(|n| parameter.values.get(n).copied().unwrap_or(0)).collect();
            ParameterValue::numbers(parameter.format, &elements)
        }
        Err(error) => ParameterValue::refused(error),
    }
}

fn change(
    address: &ParameterAddress,
    value: Option<&ParameterValue>,
    parameters: &mut impl Parameters,
    rules: &Rules,
) -> Result<(), ParameterError> {
    let (parameter, elements) = elements(address, parameters, true, rules)?;
    let refused = |number| ParameterError { number, subindex: None };
    // A value that is missing stood behind one whose format is unknown, where nothing can be read any more.
    let value = value.ok_or(refused(ErrorNumber::BAD_FORMAT))?;
    let width = match value.format {
        Format::ZERO | Format::ERROR => None,
        format => format.width(),
    };
    match width {
        None => return Err(refused(ErrorNumber::BAD_FORMAT)),
        Some(_) if rules.value_count && usize::from(value.count) != elements.len() => {
            return Err(refused(ErrorNumber::BAD_VALUE_COUNT));
        }
        Some(_) if !(rules.takes)(value.format, parameter.format) => {
            return Err(refused(ErrorNumber::WRONG_TYPE));
        }
        Some(_) => {}
    }
    let number = value.to_numbers().and_then(|numbers| numbers.first().copied()).unwrap_or(0);
    if !parameter.is_writable {
        return Ok(());
    }
    parameters.write(address.number, number).map_err(refused)
}

/// Whether a value in this format may be written to a parameter of that one: the type itself or the form of its width.
pub fn is_of_type(format: Format, parameter: Format) -> bool {
    match parameter {
        Format::WORD => matches!(format, Format::WORD | Format::UNSIGNED16),
        Format::DOUBLE_WORD => matches!(format, Format::DOUBLE_WORD | Format::UNSIGNED32),
        other => format == other,
    }
}

/// The parameter at an address and which of its values are meant.
///
/// Checks in this order: number, attribute, access, number of elements, subindex.
fn elements(
    address: &ParameterAddress,
    parameters: &impl Parameters,
    writing: bool,
    rules: &Rules,
) -> Result<(Parameter, core::ops::Range<usize>), ParameterError> {
    let refused = |number| Err(ParameterError { number, subindex: None });
    let parameter = match parameters.parameter(address.number) {
        Some(parameter) => parameter,
        None if rules.number => return refused(ErrorNumber::UNKNOWN_PARAMETER),
        None => Parameter { format: Format::WORD, is_array: false, is_writable: false, values: alloc::vec![0] },
    };
    match (address.attribute, writing) {
        (Attribute::VALUE, _) => {}
        _ if !rules.attribute => {}
        (Attribute::DESCRIPTION, false) => return refused(ErrorNumber::NO_DESCRIPTION),
        (Attribute::DESCRIPTION, true) => return refused(ErrorNumber::DESCRIPTION_READ_ONLY),
        (Attribute::TEXT, false) => return refused(ErrorNumber::NO_TEXT_ARRAY),
        (Attribute::TEXT, true) => return refused(ErrorNumber::TEXT_READ_ONLY),
        _ => return refused(ErrorNumber::BAD_ADDRESS),
    }
    if writing && !parameter.is_writable && rules.access {
        return refused(ErrorNumber::READ_ONLY);
    }
    let count = usize::from(address.element_count.max(1));
    let subindex = (rules.first_element)(address.subindex, count);
    let is_wrong = !parameter.is_array && (count > 1 || address.element_count == 0 && !rules.zero_elements);
    if address.element_count > MAX_ELEMENTS || is_wrong {
        return refused(ErrorNumber::BAD_ADDRESS);
    }
    if !parameter.is_array {
        return match subindex == 0 || !rules.array {
            true => Ok((parameter.clone(), 0..parameter.values.len())),
            false => refused(ErrorNumber::NO_ARRAY),
        };
    }
    let wanted = usize::from(subindex)..usize::from(subindex) + count;
    if wanted.end > parameter.values.len() && rules.end_of_array {
        let first = usize::from(subindex).max(parameter.values.len()) as u16;
        return Err(ParameterError { number: ErrorNumber::NO_SUCH_SUBINDEX, subindex: Some(first) });
    }
    Ok((parameter, wanted))
}

#[cfg(test)]
mod tests {
    use super::*;
    use rstest::rstest;

    /// 922 word, 65000 double word to be written, 965 octets, 964 three words.
    struct Sample(u64);

    impl Parameters for Sample {
        fn parameter(&self, number: u16) -> Option<Parameter> {
            let (format, is_array, values) = match number {
                922 => (Format::WORD, false, alloc::vec![81]),
                964 => (Format::WORD, true, alloc::vec![0x239, 1, 110]),
                965 => (Format::OCTET_STRING, false, alloc::vec![0x3D, 41]),
                65000 => (Format::DOUBLE_WORD, false, alloc::vec![self.0]),
                _ => return None,
            };
            Some(Parameter { format, is_array, is_writable: number == 65000, values })
        }

        fn write(&mut self, _: u16, value: u64) -> Result<(), ErrorNumber> {
            self.0 = value;
            Ok(())
        }
    }

    fn ask(request: &[u8]) -> Result<Vec<u8>, BadRequest> {
        let mut manager = Manager::new(Rules::default());
        manager.take((), request, &mut Sample(0x64))?;
        Ok(manager.fetch(()).expect("a response is waiting"))
    }

    // Octets as the catalogue writes them out: BMP-003 to BMP-014 and ERR-001 to ERR-032. 0x39A is 922, 0x3C4 is 964,
    // 0x3C5 is 965, 0xFDE8 is 65000.
    #[rstest]
    #[case::word(&[1, 1, 1, 1, 0x10, 0, 0x03, 0x9A, 0, 0], &[1, 1, 1, 1, 0x42, 1, 0, 81])]
    #[case::double_word(&[9, 1, 0, 1, 0x10, 1, 0xFD, 0xE8, 0, 0], &[9, 1, 0, 1, 0x43, 1, 0, 0, 0, 0x64])]
    #[case::octets(&[1, 1, 1, 1, 0x10, 0, 0x03, 0xC5, 0, 0], &[1, 1, 1, 1, 0x0A, 2, 0x3D, 41])]
    #[case::two_elements(&[1, 1, 1, 1, 0x10, 2, 0x03, 0xC4, 0, 1], &[1, 1, 1, 1, 0x42, 2, 0, 1, 0, 110])]
    #[case::write(&[1, 2, 1, 1, 0x10, 0, 0xFD, 0xE8, 0, 0, 0x43, 1, 0, 0, 3, 0xE8], &[1, 2, 1, 1])]
    #[case::write_by_type(&[1, 2, 1, 1, 0x10, 0, 0xFD, 0xE8, 0, 0, 0x07, 1, 0, 0, 3, 0xE8], &[1, 2, 1, 1])]
    #[case::unknown(&[1, 1, 1, 1, 0x10, 0, 0, 1, 0, 0], &[1, 0x81, 1, 1, 0x44, 1, 0, 0x00])]
    #[case::read_only(&[1, 2, 1, 1, 0x10, 0, 0x03, 0x9A, 0, 0, 0x42, 1, 0, 82], &[1, 0x82, 1, 1, 0x44, 1, 0, 0x01])]
    #[case::past_the_end(&[1, 1, 1, 1, 0x10, 1, 0x03, 0xC4, 0, 3], &[1, 0x81, 1, 1, 0x44, 2, 0, 0x03, 0, 3])]
    #[case::over_the_end(&[1, 1, 1, 1, 0x10, 3, 0x03, 0xC4, 0, 1], &[1, 0x81, 1, 1, 0x44, 2, 0, 0x03, 0, 3])]
    #[case::no_array(&[1, 1, 1, 1, 0x10, 1, 0x03, 0x9A, 0, 1], &[1, 0x81, 1, 1, 0x44, 1, 0, 0x04])]
    #[case::narrow(&[1, 2, 1, 1, 0x10, 0, 0xFD, 0xE8, 0, 0, 0x42, 1, 0, 5], &[1, 0x82, 1, 1, 0x44, 1, 0, 0x05])]
    #[case::write_description(&[1, 2, 1, 1, 0x20, 0, 0xFD, 0xE8, 0, 0, 0x43, 1, 0, 0, 0, 5], &[1, 0x82, 1, 1, 0x44, 1, 0, 0x07])]
    #[case::description(&[1, 1, 1, 1, 0x20, 0, 0xFD, 0xE8, 0, 0], &[1, 0x81, 1, 1, 0x44, 1, 0, 0x09])]
    #[case::text(&[1, 1, 1, 1, 0x30, 0, 0xFD, 0xE8, 0, 0], &[1, 0x81, 1, 1, 0x44, 1, 0, 0x0F])]
    #[case::attribute_0(&[1, 1, 1, 1, 0x00, 0, 0x03, 0x9A, 0, 0], &[1, 0x81, 1, 1, 0x44, 1, 0, 0x16])]
    #[case::elements_235(&[1, 1, 1, 1, 0x10, 235, 0x03, 0xC4, 0, 0], &[1, 0x81, 1, 1, 0x44, 1, 0, 0x16])]
    #[case::format_ff(&[1, 2, 1, 1, 0x10, 0, 0xFD, 0xE8, 0, 0, 0xFF, 1, 0, 0, 0, 5], &[1, 0x82, 1, 1, 0x44, 1, 0, 0x17])]
    #[case::two_values(&[1, 2, 1, 1, 0x10, 1, 0xFD, 0xE8, 0, 0, 0x43, 2, 0, 0, 0, 5, 0, 0, 0, 6], &[1, 0x82, 1, 1, 0x44, 1, 0, 0x18])]
    #[case::axis(&[1, 1, 5, 1, 0x10, 0, 0x03, 0x9A, 0, 0], &[1, 0x81, 5, 1, 0x44, 1, 0, 0x19])]
    #[case::write_text(&[1, 2, 1, 1, 0x30, 0, 0xFD, 0xE8, 0, 0, 0x43, 1, 0, 0, 0, 5], &[1, 0x82, 1, 1, 0x44, 1, 0, 0x20])]
    #[case::request_7f(&[1, 0x7F, 1, 1, 0x10, 0, 0x03, 0x9A, 0, 0], &[1, 0x81, 1, 1, 0x44, 1, 0, 0x21])]
    #[case::mixed_read(&[1, 1, 1, 2, 0x10, 0, 0x03, 0x9A, 0, 0, 0x10, 0, 0, 1, 0, 0],
                       &[1, 0x81, 1, 2, 0x42, 1, 0, 81, 0x44, 1, 0, 0])]
    #[case::mixed_write(&[1, 2, 1, 2, 0x10, 0, 0x03, 0x9A, 0, 0, 0x10, 0, 0xFD, 0xE8, 0, 0, 0x42, 1, 0, 82, 0x43, 1, 0, 0, 0, 5],
                        &[1, 0x82, 1, 2, 0x44, 1, 0, 1, 0x40, 0])]
    fn requests(#[case] request: &[u8], #[case] response: &[u8]) {
        assert_eq!(ask(request).as_deref(), Ok(response));
        for length in 0..request.len() {
            // Behind an unknown format nothing can be missing; it is refused all the same.
            assert!(ask(&request[..length]).map_or(true, |response| response[1] >= 0x80), "{length} octets");
        }
        for bit in 0..8 * request.len() {
            let mut flipped = request.to_vec();
            flipped[bit / 8] ^= 1 << (bit % 8);
            let _ = ask(&flipped);
        }
    }

    #[test]
    fn a_refused_parameter_does_not_keep_the_others_from_being_written() {
        let mut sample = Sample(0x64);
        let request =
            [1, 2, 1, 2, 0x10, 0, 0x03, 0x9A, 0, 0, 0x10, 0, 0xFD, 0xE8, 0, 0, 0x42, 1, 0, 82, 0x43, 1, 0, 0, 0, 5];
        Manager::new(Rules::default()).take((), &request, &mut sample).expect("the request is well formed");
        assert_eq!(sample.0, 5);
    }

    #[rstest]
    #[case(0)]
    #[case(40)]
    #[case(255)]
    fn a_wrong_number_of_parameters_is_refused(#[case] count: u8) {
        assert_eq!(ask(&[1, 1, 1, count, 0x10, 0, 0x03, 0x9A, 0, 0]), Err(BadRequest::Count));
    }

    #[test]
    fn the_longest_request_is_answered_in_240_octets() {
        let mut request = alloc::vec![1, 1, 1, 39];
        (0..39).for_each(|_| request.extend([0x10, 3, 0x03, 0xC4, 0, 0]));
        let response = ask(&request).expect("39 parameters are allowed");
        assert!(response.len() <= MAX_OCTETS);
        let response = Response::parse(&response).expect("our own response");
        let refused = response.values.iter().filter(|value| value.error().is_some()).count();
        assert_eq!((response.values.len(), refused), (39, 19));
        assert!(response.values[38].error().is_some() && response.values[0].error().is_none());
    }

    #[test]
    fn a_response_is_fetched_once_and_by_whom_it_is_for() {
        let mut manager = Manager::new(Rules::default());
        assert_eq!(manager.fetch(1), None);
        manager.take(1, &[7, 1, 1, 1, 0x10, 0, 0x03, 0x9A, 0, 0], &mut Sample(0)).expect("well formed");
        manager.take(1, &[8, 1, 1, 1, 0x10, 0, 0x03, 0x9A, 0, 0], &mut Sample(0)).expect("well formed");
        assert_eq!(manager.fetch(2), None);
        assert_eq!(manager.fetch(1).map(|response| response[0]), Some(8));
        assert_eq!(manager.fetch(1), None);
        manager.take(1, &[9, 1, 1, 1, 0x10, 0, 0x03, 0x9A, 0, 0], &mut Sample(0)).expect("well formed");
        assert!(manager.take(1, &[9], &mut Sample(0)).is_err());
        assert_eq!(manager.fetch(1), None);
    }
}
