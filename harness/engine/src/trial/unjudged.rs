//! A trial that is recorded and not judged: nothing that the device does ends it.

use super::{RunningTrial, TrialPhase, failure};
use crate::step_log::{LoggedStep, ProtocolError};
use results::outcome::{CaseFailure, FailureCause};
use results::verdict::Verdict;
use suite::device::NameKind;
use suite::model::{AcyclicAccess, TrialStep, Verb};

impl<'a> RunningTrial<'a> {
    /// Runs the steps of the test and records what the device does; fails only if the device does not show its identity before.
    pub fn run_unjudged(&mut self) -> Option<(Verdict, CaseFailure)> {
        if let Err(trouble) = self.check_identity() {
            let verdict = trouble.verdict.unwrap_or(Verdict::Inconclusive);
            return Some((verdict, failure::failure(self, None, trouble, &[])));
        }
        self.world.record_steps();
        self.phase = TrialPhase::Test;
        let trial = self.trial;
        trial.how().steps.iter().for_each(|step| self.record_step(step));
        self.checks = 1;
        (self.phase, self.world.closing) = (TrialPhase::After, true);
        // What we could not ask says nothing about the device.
        if let Err(trouble) = self.clean_up()
            && trouble.blame == FailureCause::Device
        {
            self.protocol_error("silence", format!("After the last step: {}", trouble.what));
        }
        self.world.act();
        if let Some(trouble) = self.trouble_of_answers() {
            self.protocol_error("misfit", trouble.what.clone());
        }
        if let Some(what) = self.world.segment.out_of_turn().into_iter().next() {
            self.protocol_error("out-of-turn", format!("The device sent out of turn: {what}."));
        }
        if let Some((why, frame)) = self.world.unreadable.first().cloned() {
            self.protocol_error("unreadable", format!("Frame {frame} cannot be read: {why}."));
        }
        None
    }

    fn protocol_error(&mut self, kind: &'static str, what: String) {
        if let Some(log) = &mut self.world.log {
            log.protocol_errors.push(ProtocolError { kind, what });
        }
    }

    fn record_step(&mut self, step: &'a TrialStep) {
        let notebook = self.world.scene.notebook_mut();
        notebook.answers.clear();
        notebook.read.clear();
        let began = self.world.now();
        if let Some(log) = &mut self.world.log {
            log.begin(began);
        }
        self.world.note(&format!("line {}: {}", step.at.line, step.text));
        self.may_end = true;
        let outcome = self.verb(step);
        self.world.lost = None;
        let answers = std::mem::take(&mut self.world.scene.notebook_mut().answers);
        let error = outcome.err().filter(|_| answers.is_empty()).map(|(trouble, _)| trouble.what.clone());
        let reads = match &step.verb {
            Verb::Read { access, .. } => self.values_read(access),
            _ => Vec::new(),
        };
        let (ended, frame) = (self.world.now(), self.world.trace.len() as u64);
        if let Some(log) = &mut self.world.log {
            log.end(LoggedStep { line: step.at.line, ended, frame, error, answers, reads, ..LoggedStep::default() });
        }
    }

    fn values_read(&self, access: &AcyclicAccess) -> Vec<(String, expression::Value)> {
        let read = &self.world.scene.notebook().read;
        let is_in_image = |kind: Option<&NameKind>| matches!(kind, Some(NameKind::Diagnosis(_)));
        let view = self.world.view();
        let value = |name| {
            let known = read.iter().find(|(of, _)| *of == name).map(|(_, value)| value.clone());
            known.or_else(|| is_in_image(self.kind(name)).then(|| expression::NameValues::value(&view, name)))
        };
        access.items.iter().filter_map(|item| Some((view.name(item.name), value(item.name)?))).collect()
    }
}
