//! The error numbers of the base mode parameter access.

use crate::codes::codes;

codes! {
    /// Why a parameter was refused: the first error value of a response; unknown numbers are preserved.
    ///
    /// Numbers up to 0x64 are defined by the profile, those from 0x65 on are vendor-specific. Source: PROFIdrive profile, base mode
    /// parameter access, table of error numbers.
    pub struct ErrorNumber(u16) {
        0x00 UNKNOWN_PARAMETER unknown_parameter "There is no parameter of this number.",
        0x01 READ_ONLY read_only "The value of the parameter cannot be changed.",
        0x02 LIMIT limit "The value is above or below the limits of the parameter.",
        0x03 NO_SUCH_SUBINDEX no_such_subindex "The array has no element at this subindex.",
        0x04 NO_ARRAY no_array "A subindex was given for a parameter that is not an array.",
        0x05 WRONG_TYPE wrong_type "The value has another data type than the parameter.",
        0x06 RESET_ONLY reset_only "The parameter can only be set to zero.",
        0x07 DESCRIPTION_READ_ONLY description_read_only "This element of the description cannot be changed.",
        0x09 NO_DESCRIPTION no_description "The parameter has no description.",
        0x0B NO_OPERATION_PRIORITY no_operation_priority "The requester has no operation priority and may not change values.",
        0x0F NO_TEXT_ARRAY no_text_array "The parameter has no text array.",
        0x11 WRONG_OPERATING_STATE wrong_operating_state "The present operating state does not allow the request.",
        0x14 VALUE_NOT_ALLOWED value_not_allowed "The value is within the limits but is not an allowed value.",
        0x15 RESPONSE_TOO_LONG response_too_long "The response would be longer than can be transferred.",
        0x16 BAD_ADDRESS bad_address "The combination of attribute, number of elements, parameter number and subindex is not allowed.",
        0x17 BAD_FORMAT bad_format "The format of the value does not exist or is not allowed here.",
        0x18 BAD_VALUE_COUNT bad_value_count "The number of values does not match the number of requested elements.",
        0x19 NO_SUCH_AXIS no_such_axis "There is no axis or drive object of this number.",
        0x20 TEXT_READ_ONLY text_read_only "The text of the parameter cannot be changed.",
        0x21 UNKNOWN_REQUEST unknown_request "The request id is not supported.",
        0x22 TOO_MANY_PARAMETERS too_many_parameters "The request is for more parameters than are supported at once.",
        0x23 SINGLE_PARAMETER_ONLY single_parameter_only "Only one parameter is allowed in a request.",
    }
}
