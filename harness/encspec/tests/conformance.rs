//! Every case and rule as a test of its own, for `cargo test` and `cargo nextest run`.
//!
//! This is a front end of `encspec run`, with the same verdicts and the same pass criteria. Tests are named
//! `<manual>/<variant>::<suite>/<case>[row]`; the test `the run as a whole` fails for reasons that belong to no single case.
//!
//! | variable | meaning, as for `encspec run` |
//! | --- | --- |
//! | `ENCSPEC_DUT` | `--dut`, several separated by commas |
//! | `ENCSPEC_DEVICE` | `--device` |
//! | `ENCSPEC_BUG` | `--bug`, several separated by commas |
//! | `ENCSPEC_VARIATION` | `--vary`, several separated by commas |
//! | `ENCSPEC_LEDGER` | `--ledger` |
//! | `ENCSPEC_GATE` | `--gate` |
//! | `ENCSPEC_EVIDENCE` | `--evidence` |

use encspec::cli::Suites;
use encspec::cli::run::RunRequest;
use encspec::engine::{DutKind, DutSpec};
use encspec::report::{self, ResultColour};
use encspec::result::RunResult;
use encspec::suite::model::{Manual, SuiteVariant};
use libtest_mimic::{Arguments, Completion, Failed, Trial};
use std::env;
use std::process::ExitCode;
use std::sync::{Arc, OnceLock};
use std::time::Duration;

const WHOLE: &str = "the run as a whole";

fn main() -> ExitCode {
    let arguments = Arguments::from_args();
    match tests(&arguments) {
        Ok(tests) => {
            let conclusion = libtest_mimic::run(&arguments, tests);
            let executed = conclusion.num_passed + conclusion.num_failed + conclusion.num_ignored;
            match (executed, &arguments.filter) {
                (0, Some(filter)) if !arguments.list => {
                    eprintln!(
                        "encspec: the filter `{}` matches no test; nothing was run",
                        plain_text::printable(filter)
                    );
                    ExitCode::from(2)
                }
                _ => conclusion.exit_code(),
            }
        }
        Err((message, status)) => {
            eprintln!("encspec: {message}");
            ExitCode::from(status)
        }
    }
}

/// A case or rule on a device.
#[derive(Clone, Debug)]
struct ConformanceTest {
    device: DutSpec,
    /// Starts with the manual.
    id: String,
    is_rule: bool,
}

impl ConformanceTest {
    fn name(&self) -> String {
        let DutSpec { manual, variant, kind } = &self.device;
        let id = self.id.split_once('/').map_or(self.id.as_str(), |(_, id)| id);
        match kind {
            DutKind::Model { .. } | DutKind::External { .. } => format!("{manual}/{variant}::{id}"),
            DutKind::Null(_) | DutKind::Live(_) => format!("{} as {manual}/{variant}::{id}", self.device),
        }
    }
}

/// The run that all tests of this process share. It starts with the first test that needs it.
struct SharedRun {
    manuals: Vec<Manual>,
    request: RunRequest,
    result: OnceLock<Result<RunResult, String>>,
}

impl SharedRun {
    fn result(&self) -> Result<&RunResult, Failed> {
        let run = || {
            let ready = self.request.ready(&self.manuals).map_err(|stop| stop.message)?;
            ready.run(&self.manuals, &|_, _, _| {}).map_err(|stop| stop.message)
        };
        self.result.get_or_init(run).as_ref().map_err(Failed::from)
    }

    fn judge(&self, test: &ConformanceTest) -> Result<Completion, Failed> {
        let result = self.result()?;
        let spec = test.device.to_string();
        let of_device = |run: &&encspec::result::DeviceRun| {
            (&run.dut.spec, &run.dut.device, &run.dut.variant) == (&spec, &test.device.manual, &test.device.variant)
        };
        let run = result.runs.iter().find(of_device).ok_or("the device was not tested")?;
        let case = run.cases.iter().find(|case| case.id == test.id).ok_or("it was not run")?;
        match report::result_colour(result, run, case) {
            ResultColour::Green => Ok(Completion::Completed),
            ResultColour::Neutral(why) => {
                let reason = case.reason.as_deref().unwrap_or(&case.why);
                Ok(Completion::ignored_with(plain_text::printable(&format!("{}, {why}: {reason}", case.verdict))))
            }
            ResultColour::Red => Err(report::failed_case(result, run, case).into()),
        }
    }

    fn whole(&self) -> Result<Completion, Failed> {
        let reasons = report::reasons(self.result()?);
        if reasons.is_empty() { Ok(Completion::Completed) } else { Err(reasons.join("\n").into()) }
    }
}

fn tests(arguments: &Arguments) -> Result<Vec<Trial>, (String, u8)> {
    let stopped = |stop: encspec::cli::CommandError| (stop.message, stop.status.code());
    let manuals = Suites::default().load().map_err(|errors| (errors.to_string(), 2))?;
    let mut request = from_environment();
    let ready = request.ready(&manuals).map_err(stopped)?;
    let all: Vec<ConformanceTest> = ready.devices().iter().flat_map(|device| of_device(device, &manuals)).collect();
    drop(ready);
    // A test that runs alone, as under nextest, must not run all others.
    let is_meant = |name: &str| !arguments.is_filtered_out(&Trial::test(name, || Ok(())));
    let mut meant = all.iter().filter(|test| is_meant(&test.name()));
    if let (Some(test), None, false) = (meant.next(), meant.next(), is_meant(WHOLE)) {
        request.duts = vec![test.device.to_string()];
        if let DutKind::Null(_) = test.device.kind {
            request.device = Some(format!("{}/{}", test.device.manual, test.device.variant));
        }
        // A rule is judged on the trials of the whole run.
        if !test.is_rule {
            request.filter.filters = vec![test.id.clone()];
            request.filter.exact = true;
        }
    }
    let run = Arc::new(SharedRun { manuals, request, result: OnceLock::new() });
    let mut tests: Vec<Trial> = all
        .into_iter()
        .map(|test| {
            let run = Arc::clone(&run);
            Trial::ignorable_test(test.name(), move || run.judge(&test))
        })
        .collect();
    tests.push(Trial::ignorable_test(WHOLE, move || run.whole()));
    Ok(tests)
}

fn of_device(device: &DutSpec, manuals: &[Manual]) -> Vec<ConformanceTest> {
    let manual = manuals.iter().find(|manual| manual.device.name == device.manual);
    let variant = manual.and_then(|manual| manual.variants.iter().find(|variant| variant.name == device.variant));
    let of = |variant: &SuiteVariant| {
        let trials = variant.trials.iter().map(|trial| (&trial.id, false));
        let tests = trials.chain(variant.rules.iter().map(|rule| (&rule.id, true)));
        let test =
            |(id, is_rule)| ConformanceTest { device: device.clone(), id: format!("{}/{id}", device.manual), is_rule };
        tests.map(test).collect()
    };
    variant.map_or_else(Vec::new, of)
}

fn from_environment() -> RunRequest {
    let text = |name: &str| env::var(name).ok().filter(|text| !text.is_empty());
    let list = |name: &str| text(name).map_or_else(Vec::new, |list| list.split(',').map(str::to_owned).collect());
    RunRequest {
        duts: list("ENCSPEC_DUT"),
        device: text("ENCSPEC_DEVICE"),
        bugs: list("ENCSPEC_BUG"),
        variations: list("ENCSPEC_VARIATION"),
        gate_must: text("ENCSPEC_GATE").as_deref() == Some("must"),
        ledger: text("ENCSPEC_LEDGER").map(Into::into),
        evidence: text("ENCSPEC_EVIDENCE").map(Into::into),
        lock_wait: Duration::from_secs(60),
        stall_repeats: encspec::engine::STALL_REPEATS,
        ..RunRequest::default()
    }
}
