//! What a program answers: one line for each message.

use crate::hello::ApplicationDescription;
use crate::hex::HexText;
use serde::{Deserialize, Serialize};

/// The answer to a message. Each message needs some of the fields; a field that none knows is an error.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ApplicationAnswer {
    /// The word of the message that is answered.
    pub answer: String,
    /// In the answer to any message: what went wrong in the program, for people; the run cannot go on.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error: Option<String>,
    /// `hello`: the description of the device.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub description: Option<Box<ApplicationDescription>>,
    /// `cycle`: the inputs of each submodule with inputs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inputs: Option<Vec<AnsweredInputs>>,
    /// `data_exchange`: the inputs; `read_record`: the record; `diagnosis`: the blocks.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub data: Option<HexText>,
    /// `cycle` and `data_exchange`: the inputs stay as they are until this time, unless the outputs change or another message comes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub constant_until: Option<u64>,
    /// `set_prm` and `chk_cfg`: whether the data are valid.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accepted: Option<bool>,
    /// `chk_cfg`: bytes of inputs of an accepted configuration.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub input_length: Option<u16>,
    /// `chk_cfg`: bytes of outputs of an accepted configuration.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub output_length: Option<u16>,
    /// `parameter_end`: when the application is ready; by default at once.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ready: Option<u64>,
    /// `read_record` and `write_record`: why the access is refused, as a word.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refused: Option<String>,
    /// `act`: when the action is complete. `factory_reset`: any time; absent if it is not supported.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub done: Option<u64>,
    /// `led`: what the LED shows, as a word of `device.yaml`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub shows: Option<String>,
    /// `counter`: the value.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<u64>,
    /// `diagnosis`: Ext_Diag, the blocks report an error.
    #[serde(default, skip_serializing_if = "is_false")]
    pub ext_diag: bool,
    /// `diagnosis`: Stat_Diag, the inputs are not usable.
    #[serde(default, skip_serializing_if = "is_false")]
    pub stat_diag: bool,
    /// `diagnosis`: Ext_Diag_Overflow, not all diagnoses fit.
    #[serde(default, skip_serializing_if = "is_false")]
    pub overflow: bool,
    /// Any message (PROFIBUS): the diagnosis has changed.
    #[serde(default, skip_serializing_if = "is_false")]
    pub diagnosis_changed: bool,
    /// Any message (PROFINET): diagnoses that have appeared or disappeared, oldest first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub diagnosis: Vec<AnsweredDiagnosis>,
    /// Any message: when `advance` is needed; absent if it is not needed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub deadline: Option<u64>,
    /// Any message: whether the supply suffices for the device to work; by default it does.
    #[serde(default = "yes", skip_serializing_if = "is_true")]
    pub alive: bool,
}

fn yes() -> bool {
    true
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "the form that serde requires")]
fn is_true(flag: &bool) -> bool {
    *flag
}

#[allow(clippy::trivially_copy_pass_by_ref, reason = "the form that serde requires")]
fn is_false(flag: &bool) -> bool {
    !flag
}

/// The inputs of a submodule.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AnsweredInputs {
    /// Slot.
    pub slot: u16,
    /// Subslot.
    pub subslot: u16,
    /// The data.
    pub data: HexText,
    /// Whether they are good (IOPS); by default they are.
    #[serde(default = "yes", skip_serializing_if = "is_true")]
    pub good: bool,
}

/// A channel diagnosis of a submodule that appears or disappears.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AnsweredDiagnosis {
    /// `true` if it appears, `false` if it disappears.
    pub appears: bool,
    /// Slot.
    pub slot: u16,
    /// Subslot.
    pub subslot: u16,
    /// Channel, by default the submodule as a whole.
    #[serde(default = "whole_submodule")]
    pub channel: u16,
    /// ChannelErrorType.
    pub error_type: u16,
    /// ExtChannelErrorType of an extended channel diagnosis.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub extended_type: Option<u16>,
    /// ExtChannelAddValue of an extended channel diagnosis, by default 0.
    #[serde(default)]
    pub added_value: u32,
    /// The severity, by default a fault.
    #[serde(default)]
    pub severity: SeverityWord,
}

fn whole_submodule() -> u16 {
    0x8000
}

/// The severity of a diagnosis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum SeverityWord {
    /// Fault.
    #[default]
    Fault,
    /// Maintenance demanded.
    MaintenanceDemanded,
    /// Maintenance required.
    MaintenanceRequired,
}
