//! Tests of "Values" and "Expressions" of `docs/suite-language.md`.

mod examples;
mod fuzz;
mod history;
mod literals;
mod messages;
mod positions;
mod truth;
mod values;

use super::{
    Allow, Circle, ExpectedValue, ExprError, HistoryState, NameId, NameScope, NameValues, Program, ResolvedName, Type,
    Value, WordTable,
};
use station::Time;
use std::collections::HashMap;

/// The names of the tests; a [`NameId`] is an index into `names`.
pub(super) struct TestNames {
    names: Vec<(String, Type)>,
    other: HashMap<&'static str, ResolvedName>,
}

/// Two circles: `position` and `G1_XIST2` lie on the first, `G1_XIST1` on the second.
const CIRCLES: [Circle; 2] = [Circle(0), Circle(1)];

impl TestNames {
    pub(super) fn new() -> TestNames {
        let switch = WordTable::new("switch", [("disabled", 0), ("enabled", 1)]);
        let inverted = WordTable::new("inverted_switch", [("enabled", 0), ("disabled", 1)]);
        let errors = WordTable::new("channel_error", [("memory", 0x9000), ("position", 0x900A)]);
        let led = WordTable::plain("led.encoder", ["dark", "red", "green_flashing"]);
        let units = WordTable::new("speed_unit", [("steps_per_second", 0), ("rpm", 3)]);
        let bits = "G1_ZSW.sensor_error G1_ZSW.parked G1_ZSW.transmit_absolute_value G1_ZSW.home_position_executed \
            G1_STW.request_home_position G1_STW.park STW2_ENC.control_by_plc alarm diag.fixed_one io.diagnosis_pending a b c";
        let wide = "G1_ZSW MT_POS ST_POS total_range hardware_range units_per_revolution P65000";
        let mut names: Vec<(String, Type)> = Vec::new();
        names.extend(bits.split_whitespace().map(|name| (name.to_owned(), Type::Bit)));
        names.extend(wide.split_whitespace().map(|name| (name.to_owned(), Type::whole(32, false))));
        names.extend(
            [
                ("position", Type::Place(CIRCLES[0])),
                ("before", Type::Place(CIRCLES[0])),
                ("place", Type::Place(CIRCLES[0])),
                ("G1_XIST2", Type::Place(CIRCLES[0])),
                ("G1_XIST1", Type::Place(CIRCLES[1])),
                ("ZSW2_ENC.sign_of_life", Type::whole(4, false)),
                ("time_stamp", Type::whole(16, false)),
                ("NIST_B", Type::whole(32, true)),
                ("supply.voltage", Type::FRACTION),
                ("cycle", Type::Time),
                ("station.name", Type::Text),
                ("station.ip", Type::Address),
                ("io.inputs", Type::Bytes),
                ("class_4", Type::Word(switch.clone())),
                ("scaling", Type::Word(switch.clone())),
                ("round_axis", Type::Word(switch.clone())),
                ("class_2", Type::Word(switch)),
                ("g1_xist1_preset_control", Type::Word(inverted)),
                ("alarm.error", Type::Word(errors.clone())),
                ("diag.errors", Type::Set(errors)),
                ("led.encoder", Type::Word(led)),
                ("speed_unit", Type::Word(units)),
                ("connection", Type::Word(WordTable::plain("connection", ["none", "data"]))),
            ]
            .map(|(name, ty)| (name.to_owned(), ty)),
        );
        let other = HashMap::from([
            ("shift", ResolvedName::Constant(Value::whole(1000), Type::WHOLE)),
            ("shown", ResolvedName::Constant(Value::whole(1500), Type::WHOLE)),
            ("long", ResolvedName::Constant(Value::whole(-33860), Type::WHOLE)),
            ("after", ResolvedName::Constant(Value::whole(0x1334), Type::WHOLE)),
            ("short", ResolvedName::Constant(Value::whole(32767), Type::WHOLE)),
            ("xist1_shift", ResolvedName::Constant(Value::whole(2), Type::WHOLE)),
            ("name", ResolvedName::Constant(Value::text("enc-1"), Type::Text)),
            ("unit", ResolvedName::Word("rpm".to_owned())),
            (
                "power",
                ResolvedName::Refused {
                    message: "`power` can only be set".to_owned(),
                    help: Some("check `connection`".to_owned()),
                },
            ),
        ]);
        TestNames { names, other }
    }
}

impl NameScope for TestNames {
    fn lookup(&self, path: &str) -> Option<ResolvedName> {
        let known = self.names.iter().zip(0..).find(|((name, _), _)| name == path);
        known.map(|((_, ty), id)| ResolvedName::Name(NameId(id), ty.clone())).or_else(|| self.other.get(path).cloned())
    }

    fn known(&self, visit: &mut dyn FnMut(&str)) {
        self.names.iter().for_each(|(name, _)| visit(name));
    }
}

/// One observation.
#[derive(Default)]
pub(super) struct ObservedValues {
    values: HashMap<NameId, Value>,
    fresh: Vec<NameId>,
    now: Time,
    noise: u32,
}

impl ObservedValues {
    /// An observation that carries these names with these values; all other names are unknown.
    pub(super) fn now(values: &[(&str, Value)]) -> ObservedValues {
        let names = TestNames::new();
        let id = |path: &str| match names.lookup(path) {
            Some(ResolvedName::Name(id, _)) => id,
            other => panic!("{path} is {other:?}"),
        };
        let values: HashMap<NameId, Value> = values.iter().map(|(path, value)| (id(path), value.clone())).collect();
        ObservedValues { fresh: values.keys().copied().collect(), values, ..ObservedValues::default() }
    }

    /// The same values, but not carried by this observation.
    pub(super) fn stale(self) -> ObservedValues {
        ObservedValues { fresh: Vec::new(), ..self }
    }

    pub(super) fn at(self, nanos: u64) -> ObservedValues {
        ObservedValues { now: Time::from_nanos(nanos), ..self }
    }

    pub(super) fn noise(self, noise: u32) -> ObservedValues {
        ObservedValues { noise, ..self }
    }
}

impl NameValues for ObservedValues {
    fn value(&self, name: NameId) -> Value {
        self.values.get(&name).cloned().unwrap_or(Value::Unknown)
    }
    fn fresh(&self, name: NameId) -> bool {
        self.fresh.contains(&name)
    }
    fn now(&self) -> Time {
        self.now
    }
    fn position_noise(&self) -> u32 {
        self.noise
    }
}

pub(super) fn condition(text: &str) -> Result<Program, ExprError> {
    Program::condition(text, &TestNames::new(), Allow::TRACE)
}

pub(super) fn value(text: &str) -> Result<Program, ExprError> {
    Program::value(text, None, &TestNames::new(), Allow::VALUE)
}

pub(super) fn target(text: &str, expected: &str) -> Result<ExpectedValue, ExprError> {
    ExpectedValue::compile(text, &ty(expected), &TestNames::new(), Allow::TRACE)
}

pub(super) fn ty(name: &str) -> Type {
    match TestNames::new().lookup(name) {
        Some(ResolvedName::Name(_, ty) | ResolvedName::Constant(_, ty)) => ty,
        other => panic!("{name} is {other:?}"),
    }
}

/// The result of a condition if only `values` are known.
pub(super) fn truth(text: &str, values: &[(&str, Value)]) -> Option<bool> {
    condition(text)
        .unwrap_or_else(|error| panic!("{text}: {error}"))
        .truth(&ObservedValues::now(values), &HistoryState::default())
}

/// The value of an expression if only `values` are known.
pub(super) fn computed(text: &str, values: &[(&str, Value)]) -> Value {
    value(text)
        .unwrap_or_else(|error| panic!("{text}: {error}"))
        .eval(&ObservedValues::now(values), &HistoryState::default())
}
