//! Checks of parameter addresses and values (PROFIdrive profile, base mode, error numbers).
//!
//! The order of the checks: number, attribute, access, number of elements, subindex; then, for a value to be written,
//! its format and the number of values.

use super::manager::{ParameterManager, refused};
use super::{MAX_ELEMENTS, ParameterContent, ParameterShape, ParameterStore};
use crate::profidrive::checks::EncoderCheck;
use alloc::vec::Vec;
use core::ops::Range;
use wire::profidrive::{Attribute, ErrorNumber, ParameterAddress, ParameterError, ParameterFormat, ParameterValue};

impl ParameterManager {
    /// The parameter at an address, and the range of addressed values.
    pub(super) fn elements(
        &self,
        address: &ParameterAddress,
        parameters: &impl ParameterStore,
        writing: bool,
    ) -> Result<(ParameterContent, Range<usize>), ParameterError> {
        let Some(parameter) = parameters.parameter(address.number) else {
            return Err(refused(ErrorNumber::UNKNOWN_PARAMETER));
        };
        let attribute = address.attribute;
        if !self.checks.check(EncoderCheck::Attribute(attribute), attribute == Attribute::VALUE) {
            return Err(refused(refused_attribute(attribute, writing)));
        }
        let is_writable = |element, verdict| {
            !writing || self.checks.check(EncoderCheck::Writable { number: address.number, element }, verdict)
        };
        if !is_writable(None, !parameter.writable.is_empty()) {
            return Err(refused(ErrorNumber::READ_ONLY));
        }
        let count = address.element_count;
        let has_elements = parameter.shape != ParameterShape::Value;
        if !self.checks.check(EncoderCheck::ElementCount { count, has_elements }, count <= MAX_ELEMENTS) {
            return Err(refused(ErrorNumber::BAD_ADDRESS));
        }
        // 0 elements and 1 element mean the same.
        let (count, subindex) = (usize::from(count.max(1)), usize::from(address.subindex));
        let is_whole = !has_elements || parameter.shape == ParameterShape::Octets && count == 1;
        if is_whole {
            let is_right = count == 1 && subindex == 0;
            if !self.checks.check(EncoderCheck::WholeValue { count, subindex: address.subindex }, is_right) {
                return Err(refused(ErrorNumber::NO_ARRAY));
            }
            return Ok((parameter.clone(), 0..parameter.values.len()));
        }
        let elements = subindex..subindex + count;
        let length = parameter.values.len();
        if !self.checks.check(EncoderCheck::Elements { end: elements.end, length }, elements.end <= length) {
            let first = subindex.max(length) as u16;
            return Err(ParameterError { number: ErrorNumber::NO_SUCH_SUBINDEX, subindex: Some(first) });
        }
        match elements.clone().find(|n| !is_writable(Some(*n as u16), parameter.writable.contains(n))) {
            Some(fixed) => Err(ParameterError { number: ErrorNumber::READ_ONLY, subindex: Some(fixed as u16) }),
            None => Ok((parameter, elements)),
        }
    }

    /// The values to write, if all checks pass that do not depend on the parameter itself.
    pub(super) fn values(
        &self,
        address: &ParameterAddress,
        value: Option<&ParameterValue>,
        parameters: &impl ParameterStore,
    ) -> Result<Vec<u64>, ParameterError> {
        let (parameter, elements) = self.elements(address, parameters, true)?;
        // A missing value follows one of unknown format, after which the request cannot be parsed.
        let (format, count) = value.map_or((ParameterFormat::ZERO, 0), |value| (value.format, value.count));
        let numbers = value.and_then(ParameterValue::to_numbers);
        let is_known = numbers.is_some() && format != ParameterFormat::ERROR;
        if !self.checks.check(EncoderCheck::KnownFormat(format), is_known) {
            return Err(refused(ErrorNumber::BAD_FORMAT));
        }
        let (values, of) = (usize::from(count), elements.len());
        if !self.checks.check(EncoderCheck::ValueCount { values, elements: of }, values == of) {
            return Err(refused(ErrorNumber::BAD_VALUE_COUNT));
        }
        let parameter = parameter.format;
        if !self.checks.check(EncoderCheck::ValueFormat { format, parameter }, is_of_type(format, parameter)) {
            return Err(refused(ErrorNumber::WRONG_TYPE));
        }
        Ok(numbers.unwrap_or_default())
    }
}

/// The error for an attribute other than the value. No parameter has a description or a text.
fn refused_attribute(attribute: Attribute, writing: bool) -> ErrorNumber {
    match (attribute, writing) {
        (Attribute::DESCRIPTION, false) => ErrorNumber::NO_DESCRIPTION,
        (Attribute::DESCRIPTION, true) => ErrorNumber::DESCRIPTION_READ_ONLY,
        (Attribute::TEXT, false) => ErrorNumber::NO_TEXT_ARRAY,
        (Attribute::TEXT, true) => ErrorNumber::TEXT_READ_ONLY,
        _ => ErrorNumber::BAD_ADDRESS,
    }
}

/// Whether a value of `format` may be written to a parameter: its data type, or the plain format of the same width.
pub fn is_of_type(format: ParameterFormat, parameter: ParameterFormat) -> bool {
    match parameter {
        ParameterFormat::WORD => matches!(format, ParameterFormat::WORD | ParameterFormat::UNSIGNED16),
        ParameterFormat::DOUBLE_WORD => matches!(format, ParameterFormat::DOUBLE_WORD | ParameterFormat::UNSIGNED32),
        other => format == other,
    }
}
