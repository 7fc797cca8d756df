//! What an address means, and whether it may be read or written: PROFIdrive profile, base mode, error numbers.
//!
//! The checks come in this order: number, attribute, access, number of elements, subindex; of a value to be written then its
//! format and the number of values.

use super::manager::{Manager, refused};
use super::{MAX_ELEMENTS, Parameter, Parameters, Shape};
use crate::profidrive::checks::Check;
use alloc::vec::Vec;
use core::ops::Range;
use wire::profidrive::{Attribute, ErrorNumber, Format, ParameterAddress, ParameterError, ParameterValue};

impl Manager {
    /// The parameter at an address and which of its values are meant.
    pub(super) fn elements(
        &self,
        address: &ParameterAddress,
        parameters: &impl Parameters,
        writing: bool,
    ) -> Result<(Parameter, Range<usize>), ParameterError> {
        let Some(parameter) = parameters.parameter(address.number) else {
            return Err(refused(ErrorNumber::UNKNOWN_PARAMETER));
        };
        let attribute = address.attribute;
        if !self.checks.check(Check::Attribute(attribute), attribute == Attribute::VALUE) {
            return Err(refused(refused_attribute(attribute, writing)));
        }
        let is_writable = |element, verdict| {
            !writing || self.checks.check(Check::Writable { number: address.number, element }, verdict)
        };
        if !is_writable(None, !parameter.writable.is_empty()) {
            return Err(refused(ErrorNumber::READ_ONLY));
        }
        let count = address.element_count;
        let has_elements = parameter.shape != Shape::Value;
        if !self.checks.check(Check::ElementCount { count, has_elements }, count <= MAX_ELEMENTS) {
            return Err(refused(ErrorNumber::BAD_ADDRESS));
        }
        // 0 elements and 1 mean the same.
        let (count, subindex) = (usize::from(count.max(1)), usize::from(address.subindex));
        let is_whole = !has_elements || parameter.shape == Shape::Octets && count == 1;
        if is_whole {
            let is_right = count == 1 && subindex == 0;
            return match self.checks.check(Check::WholeValue { count, subindex: address.subindex }, is_right) {
                true => Ok((parameter.clone(), 0..parameter.values.len())),
                false => Err(refused(ErrorNumber::NO_ARRAY)),
            };
        }
        let elements = subindex..subindex + count;
        let there = parameter.values.len();
        if !self.checks.check(Check::Elements { end: elements.end, there }, elements.end <= there) {
            let first = subindex.max(there) as u16;
            return Err(ParameterError { number: ErrorNumber::NO_SUCH_SUBINDEX, subindex: Some(first) });
        }
        match elements.clone().find(|n| !is_writable(Some(*n as u16), parameter.writable.contains(n))) {
            Some(fixed) => Err(ParameterError { number: ErrorNumber::READ_ONLY, subindex: Some(fixed as u16) }),
            None => Ok((parameter, elements)),
        }
    }

    /// The numbers to be written, if they may be as far as the parameter itself need not be asked.
    pub(super) fn values(
        &self,
        address: &ParameterAddress,
        value: Option<&ParameterValue>,
        parameters: &impl Parameters,
    ) -> Result<Vec<u64>, ParameterError> {
        let (parameter, elements) = self.elements(address, parameters, true)?;
        // A value that is missing stood behind one whose format is unknown, where nothing can be read any more.
        let (format, count) = value.map_or((Format::ZERO, 0), |value| (value.format, value.count));
        let numbers = value.and_then(ParameterValue::to_numbers);
        let is_known = numbers.is_some() && format != Format::ERROR;
        if !self.checks.check(Check::KnownFormat(format), is_known) {
            return Err(refused(ErrorNumber::BAD_FORMAT));
        }
        let (values, of) = (usize::from(count), elements.len());
        if !self.checks.check(Check::ValueCount { values, of }, values == of) {
            return Err(refused(ErrorNumber::BAD_VALUE_COUNT));
        }
        let parameter = parameter.format;
        match self.checks.check(Check::ValueFormat { format, parameter }, is_of_type(format, parameter)) {
            true => Ok(numbers.unwrap_or_default()),
            false => Err(refused(ErrorNumber::WRONG_TYPE)),
        }
    }
}

/// The error of an attribute other than the value: no parameter has a description or a text.
fn refused_attribute(attribute: Attribute, writing: bool) -> ErrorNumber {
    match (attribute, writing) {
        (Attribute::DESCRIPTION, false) => ErrorNumber::NO_DESCRIPTION,
        (Attribute::DESCRIPTION, true) => ErrorNumber::DESCRIPTION_READ_ONLY,
        (Attribute::TEXT, false) => ErrorNumber::NO_TEXT_ARRAY,
        (Attribute::TEXT, true) => ErrorNumber::TEXT_READ_ONLY,
        _ => ErrorNumber::BAD_ADDRESS,
    }
}

/// Whether a value in this format may be written to a parameter of that one: the type itself or the form of its width.
pub fn is_of_type(format: Format, parameter: Format) -> bool {
    match parameter {
        Format::WORD => matches!(format, Format::WORD | Format::UNSIGNED16),
        Format::DOUBLE_WORD => matches!(format, Format::DOUBLE_WORD | Format::UNSIGNED32),
        other => format == other,
    }
}
