//! What a device says that it does not have: modules and start parameters by its GSDML, parameters by its answers.
//!
//! A trial that needs one of these is not applicable.

use super::RunningTrial;
use super::step_error::{BoxedStepError, StepError, StepResult};
use judge::answer::{NegativeResponse, ReceivedReply};
use results::outcome::FailureCause;
use results::verdict::Verdict;
use suite::device::{NameId, NameKind, RecordField};
use suite::model::{AcyclicAccess, AcyclicService, AnswerPart, ConnectionStart, TrialStep, Verb};
use suite::scan;
use wire::profidrive::{ErrorNumber, ParameterAddress, ParameterRequest, ParameterResponse};

/// PDInterfaceFSUDataAdjust, the record that switches the Hello on.
const FAST_START_UP: u16 = 0x8090;
/// The list of the parameters of a drive object: PROFIdrive profile, P980.
const LIST: u16 = 980;
/// The longest list that is read.
const LONGEST_LIST: u16 = 256;

fn not_applicable(what: String) -> BoxedStepError {
    StepError::other(FailureCause::Environment, Verdict::NotApplicable, what)
}

/// Why a start cannot give this value to a field of a record; `None` if it can.
fn is_not_settable(field: &RecordField, value: i128, default: i128) -> Option<String> {
    let name = &field.name;
    match (&field.absent, field.settable) {
        (Some(why), _) if value != default => Some(format!("{name} cannot be set: {why}")),
        (None, Some((lowest, highest))) if !(lowest..=highest).contains(&value) => {
            Some(format!("the GSDML allows {lowest} to {highest} for {name}, and not {value}"))
        }
        _ => None,
    }
}

/// The trouble with a step; where the step says that a device may lack what it checks, the trial is not applicable.
pub fn excused(step: &TrialStep, trouble: BoxedStepError) -> BoxedStepError {
    match &step.otherwise {
        Some(why) if trouble.is_of_device() => not_applicable(format!("The case is not applicable: {why}.")),
        _ => trouble,
    }
}

impl RunningTrial<'_> {
    /// Checks that the GSDML of the device has the module and the start parameters of a connection.
    pub fn check_offered(&self, start: &ConnectionStart) -> StepResult {
        let device = &self.world.manual.device;
        if let Some((module, why)) =
            device.modules.get(start.module).and_then(|module| Some((module, module.absent.as_ref()?)))
        {
            return Err(not_applicable(format!("The device does not have {}: {why}.", module.name)));
        }
        let variant = self.variant_number();
        let found = start.parameters.iter().find_map(|given| {
            let field = device.records.get(given.record)?.fields.get(given.field)?;
            is_not_settable(field, given.value, field.default.get(variant).copied().unwrap_or_default())
        });
        found.map_or(Ok(()), |why| Err(not_applicable(format!("The start is not applicable: {why}."))))
    }

    /// Checks that the device has an SNMP agent.
    pub fn check_snmp(&self) -> StepResult {
        match self.world.manual.device.profinet() {
            Some(facts) if facts.has_snmp => Ok(()),
            _ => Err(not_applicable(
                "The device does not have SNMP: its GSDML does not list it in SupportedProtocols and claims no conformance class above A."
                    .to_owned(),
            )),
        }
    }

    /// Checks that a device whose Hello the trial waits for says one.
    pub fn check_hello(&self) -> StepResult {
        let names = &self.world.variant.names;
        let is_hello =
            |name: &NameId| matches!(names.get(name.0 as usize), Some(NameKind::Event(event)) if event.is_hello());
        let has_hello = self.world.manual.device.profinet().is_some_and(|facts| facts.has_hello);
        let writes = |step: &TrialStep| matches!(&step.verb, Verb::Send { service: AcyclicService::RecordWrite { at, .. }, .. } if at.index == FAST_START_UP);
        let mut asks = scan::names(&self.trial.how().steps).iter().any(is_hello);
        scan::each_step_of(self.trial, &mut |step| asks |= writes(step));
        match asks && !has_hello {
            false => Ok(()),
            true => {
                Err(not_applicable("The device says no Hello: its GSDML does not claim DCP_HelloSupported.".to_owned()))
            }
        }
    }

    /// The trouble with an access that failed because the device lacks an optional parameter: it refuses the parameter as unknown, and
    /// does not list it. `None` if that is not why it failed.
    pub fn lacks_parameter(&mut self, access: &AcyclicAccess) -> Option<BoxedStepError> {
        let device = &self.world.manual.device;
        let unknown = ReceivedReply::Refused(NegativeResponse::Parameter(ErrorNumber::UNKNOWN_PARAMETER.0));
        let optional = |number: u16| device.parameters.iter().any(|known| known.number == number && known.optional);
        let refused = self.world.scene.notebook().answers.iter().find_map(|(part, reply)| match part {
            AnswerPart::Parameter(number, _) if *reply == unknown && optional(*number) => Some(*number),
            _ => None,
        })?;
        if access.second || self.lists_parameter(refused) {
            return None;
        }
        Some(not_applicable(format!(
            "The device does not have P{refused}: it refuses it as unknown, and P{LIST} does not list it."
        )))
    }

    /// Whether P980 has this number; `false` if it cannot be read.
    fn lists_parameter(&mut self, wanted: u16) -> bool {
        for subindex in 0..LONGEST_LIST {
            self.reference = self.reference.checked_add(1).unwrap_or(1);
            let do_id = self.world.manual.device.parameter_access.do_id;
            let address = ParameterAddress::value(LIST, subindex);
            let mut request = Vec::new();
            ParameterRequest::read_values(self.reference, do_id, vec![address]).write(&mut request);
            let driver = self.driver;
            let Some(octets) = driver.parameter_response(self, request) else { return false };
            let Ok(response) = ParameterResponse::parse(&octets) else { return false };
            let values = response.values.first().filter(|_| !response.header.id.is_negative());
            match values.and_then(|entry| entry.to_numbers()).and_then(|numbers| numbers.first().copied()) {
                Some(number) if number == u64::from(wanted) => return true,
                Some(0) | None => return false,
                Some(_) => {}
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::is_not_settable;
    use suite::device::{Origin, RecordField};

    fn field(absent: Option<&str>, settable: Option<(i128, i128)>) -> RecordField {
        RecordField {
            name: "total_range".into(),
            octet: 9,
            octets: 8,
            bits: None,
            words: Vec::new(),
            table: None,
            default: vec![8192],
            range: (None, None),
            text: false,
            called: Vec::new(),
            origin: Origin::Description,
            absent: absent.map(str::to_owned),
            settable,
        }
    }

    #[test]
    fn a_value_outside_of_the_gsdml_cannot_be_set() {
        let limited = field(None, Some((1, 8192)));
        assert_eq!(is_not_settable(&limited, 8192, 8192), None);
        let why = is_not_settable(&limited, 8193, 8192).expect("it is too large");
        assert_eq!(why, "the GSDML allows 1 to 8192 for total_range, and not 8193");
        let absent = field(Some("the GSDML has no such parameter"), None);
        assert_eq!(is_not_settable(&absent, 8192, 8192), None);
        assert!(is_not_settable(&absent, 1, 8192).is_some_and(|why| why.contains("the GSDML has no such parameter")));
        assert_eq!(is_not_settable(&field(None, None), 1, 8192), None);
    }
}
