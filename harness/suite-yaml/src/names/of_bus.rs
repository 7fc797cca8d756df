//! Names that only one of the buses has, or that mean something else on it.

use super::build::{Built, good, unknown};
use super::{Names, Verbs, built_in, field_type};
use expression::Type;
use suite::device::{BenchName, DiagnosisName, NameKind, StationName};
use suite::words;

/// Names of PROFINET by their first part, where all that begin so are.
const HEADS_OF_PROFINET: [&str; 6] = ["alarm", "abort", "lldp", "hello", "ready", "page"];
/// The same below `io`.
const IO_OF_PROFINET: [&str; 7] = [
    "output_status",
    "input_status",
    "consumer_status",
    "alarm_acknowledge",
    "input_data_status",
    "input_counter",
    "output_data_status",
];
/// The same below `station`.
const STATION_OF_PROFINET: [&str; 8] = ["name", "ip", "mask", "gateway", "vendor_id", "device_id", "type", "mac"];
/// The same below `bench`.
const BENCH_OF_PROFINET: [&str; 3] = ["ip", "mask", "free_ip"];
/// The same below `answer`.
const ANSWER_OF_PROFINET: [&str; 9] =
    ["connect", "parameter_end", "application_ready", "module_diff", "status", "contains", "lacks", "text", "number"];
/// Names of PROFIBUS below `io`.
const IO_OF_PROFIBUS: [&str; 3] = ["global_control", "clock_offset", "diagnosis_pending"];

impl Names<'_> {
    /// What a name is that the buses do not share; the outer none for one that they do.
    pub(super) fn of_bus(&self, head: &str, rest: Option<&str>) -> Option<Option<Built>> {
        match self.device().profibus() {
            None => match (head, rest) {
                ("io", Some(name)) if IO_OF_PROFIBUS.contains(&name) => Some(only("PROFIBUS", head, name)),
                ("diag" | "cfg", Some(name)) => Some(only("PROFIBUS", head, name)),
                _ => None,
            },
            Some(_) => self.of_profibus(head, rest),
        }
    }

    fn of_profibus(&self, head: &str, rest: Option<&str>) -> Option<Option<Built>> {
        let first = rest.map(|rest| rest.split('.').next().unwrap_or(rest));
        let foreign = |list: &[&str]| first.is_some_and(|first| list.contains(&first));
        let is_foreign = match head {
            "io" => foreign(&IO_OF_PROFINET),
            "station" => foreign(&STATION_OF_PROFINET),
            "bench" => foreign(&BENCH_OF_PROFINET),
            "answer" => foreign(&ANSWER_OF_PROFINET),
            _ => HEADS_OF_PROFINET.contains(&head),
        };
        if is_foreign {
            let path = rest.map_or_else(|| head.to_owned(), |rest| format!("{head}.{rest}"));
            return Some(Some(Err((format!("`{path}` exists on PROFINET only"), None))));
        }
        Some(match (head, rest?) {
            ("diag", name) => Some(self.diagnosis(name)),
            ("cfg", "bytes") => good(NameKind::Configuration, Type::Bytes, Verbs::READ),
            ("io", "global_control") => {
                good(NameKind::GlobalControl, built_in("io.global_control", words::CLOCK), Verbs::SET)
            }
            ("io", "clock_offset") => good(NameKind::ClockOffset, Type::Time, Verbs::SET),
            ("io", "diagnosis_pending") => good(NameKind::DiagnosisPending, Type::Bit, Verbs::EXPECT),
            ("station", "address") => good(NameKind::Station(StationName::Address), Type::whole(8, false), Verbs::READ),
            ("bench", name) => {
                let name = match name {
                    "address" => BenchName::Address,
                    "station" => BenchName::Station,
                    "free_station" => BenchName::FreeStation,
                    "second" => BenchName::Second,
                    _ => return Some(None),
                };
                good(NameKind::Bench(name), Type::whole(8, false), Verbs::NONE)
            }
            _ => return None,
        })
    }

    fn diagnosis(&self, name: &str) -> Built {
        let verbs = Verbs::READ.and(Verbs::EXPECT);
        let Some(slave) = self.device().profibus() else {
            return Err((format!("there is no `diag.{name}` here"), None));
        };
        let of = &slave.diagnosis;
        let found = |name: DiagnosisName, ty: Type| Ok((NameKind::Diagnosis(name), ty, verbs));
        if let Some(index) = of.fields.iter().position(|field| field.name == name) {
            self.mark("field", &format!("diag.{name}"));
            let field = &of.fields[index];
            let width = field.bits.map_or(field.octets as u32 * 8, |(_, width)| width);
            let ty = match field.is_number() {
                true => field_type(field.table.as_ref(), width, field.signed),
                false => Type::Bytes,
            };
            return found(DiagnosisName::Field(index), ty);
        }
        let Some(standard) = DiagnosisName::by_word(name) else {
            let own = of.fields.iter().map(|field| field.name.as_str());
            return unknown("part", name, "the diagnosis", DiagnosisName::words().map(|(word, _)| word).chain(own));
        };
        match standard {
            DiagnosisName::Length => found(standard, Type::whole(8, false)),
            DiagnosisName::Bytes => found(standard, Type::Bytes),
            DiagnosisName::Ident => found(standard, Type::whole(16, false)),
            DiagnosisName::Master | DiagnosisName::Alarm(_) => found(standard, Type::whole(8, false)),
            DiagnosisName::Errors => match &of.blocks {
                Some(blocks) => found(standard, Type::Set(blocks.table.clone())),
                None => Err(("the diagnosis of this device has no blocks of errors".to_owned(), None)),
            },
            DiagnosisName::Bit { .. } | DiagnosisName::MasterLock | DiagnosisName::Field(_) => {
                found(standard, Type::Bit)
            }
        }
    }
}

fn only(bus: &str, head: &str, name: &str) -> Option<Built> {
    Some(Err((format!("`{head}.{name}` exists on {bus} only"), None)))
}
