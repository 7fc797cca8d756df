//! Encoders without a manual: the suite for any encoder of the PROFIdrive encoder profile, with the description that a GSDML gives.

use super::CommandError;
use super::live::read_gsdml;
use description::gsdml::{self, DescribedEncoder, Gsdml, SensorFormat};
use deviations::subject;
use engine::{DutKind, DutSpec};
use results::bench_file::BenchFile;
use results::outcome::DescriptionKind;
use std::path::{Path, PathBuf};
use suite::model::Manual;
use suite_yaml::{ANY_DEVICE, ANY_ENCODER, Sources, load};

/// An encoder that only its GSDML describes.
#[derive(Clone, Debug)]
pub struct GsdmlEncoder {
    path: PathBuf,
    gsdml: Gsdml,
}

impl GsdmlEncoder {
    /// The encoder of a GSDML. Fails if the file is no GSDML, or describes no encoder of the profile.
    pub fn open(path: &Path) -> Result<GsdmlEncoder, CommandError> {
        GsdmlEncoder::new(path, read_gsdml(path)?)
    }

    /// The encoder of a GSDML that is read already. Fails if it describes no encoder of the profile.
    pub fn new(path: &Path, gsdml: Gsdml) -> Result<GsdmlEncoder, CommandError> {
        let encoder = GsdmlEncoder { path: path.to_owned(), gsdml };
        encoder.described(SensorFormat::default())?;
        Ok(encoder)
    }

    /// The encoder of a bench: its device is any encoder or none, and nothing but a GSDML describes it. `None` if it is another device.
    pub fn of_bench(bench: &BenchFile) -> Result<Option<GsdmlEncoder>, CommandError> {
        let is_unknown = bench.claim.variant.is_empty() && bench.description.is_none();
        let Some(path) = bench.description_of(DescriptionKind::Gsdml).filter(|_| is_unknown) else { return Ok(None) };
        match bench.claim.manual.as_str() {
            ANY_ENCODER => GsdmlEncoder::open(path).map(Some),
            ANY_DEVICE => {
                let encoder = GsdmlEncoder { path: path.to_owned(), gsdml: read_gsdml(path)? };
                encoder.described(SensorFormat::default()).map_err(|error| {
                    let CommandError { message, status } = error;
                    let help = "describe the device in a file, and name it under `description`";
                    CommandError { message: format!("{message}; {help}"), status }
                })?;
                Ok(Some(encoder))
            }
            _ => Ok(None),
        }
    }

    fn described(&self, format: SensorFormat) -> Result<DescribedEncoder, CommandError> {
        gsdml::describe(&self.gsdml, format)
            .map_err(|error| CommandError::usage(format!("{}: {error}", self.path.display())))
    }

    /// The modules of the suite that the encoder has.
    pub fn telegrams(&self) -> Result<Vec<String>, CommandError> {
        Ok(self
            .described(SensorFormat::default())?
            .telegrams
            .iter()
            .map(|number| format!("telegram_{number}"))
            .collect())
    }

    /// The suite for this encoder, with what its P979 says.
    pub fn sources(&self, sources: Sources, format: SensorFormat) -> Result<Sources, CommandError> {
        let path = format!("{ANY_ENCODER}/device.yaml");
        let base = sources.files().find(|(known, _)| *known == path).map(|(_, text)| text.to_owned());
        let base = base.ok_or_else(|| CommandError::usage(format!("there is no suite {ANY_ENCODER}")))?;
        let text = self.described(format)?.text(&base);
        Ok(sources.described(ANY_ENCODER, &self.path, text))
    }

    /// The same, loaded.
    pub fn manual(&self, sources: Sources, format: SensorFormat) -> Result<Manual, CommandError> {
        let mut manuals = load(&self.sources(sources, format)?, Some(ANY_ENCODER))?;
        manuals.pop().ok_or_else(|| CommandError::usage(format!("there is no suite {ANY_ENCODER}")))
    }

    /// The suite for this encoder and a reference device that is tested by its GSDML alone: `model` is `MANUAL/VARIANT`.
    ///
    /// What the GSDML does not say is read from the device: P979 has its resolution and the shift of G1_XIST1.
    pub fn of_model(
        &self,
        sources: Sources,
        model: &str,
        deviations: Vec<String>,
    ) -> Result<(Manual, DutSpec), CommandError> {
        let (name, variant) = model
            .split_once('/')
            .ok_or_else(|| CommandError::usage(format!("`model:{model}` does not say which variant it is")))?;
        let subject = subject(name).map_err(|error| CommandError::usage(error.to_string()))?;
        let names: Vec<&str> = deviations.iter().map(String::as_str).collect();
        subject.attached(&names).map_err(|error| CommandError::usage(error.to_string()))?;
        let manual = self.manual(sources.clone(), SensorFormat::default())?;
        let own = manual.variants.first().ok_or_else(|| CommandError::usage("the suite has no variant"))?;
        let kind = DutKind::External { model: subject, variant: Some(variant.to_owned()), deviations };
        let dut = DutSpec { manual: manual.device.name.clone(), variant: own.name.clone(), kind };
        let format =
            engine::sensor_format(&manual, own, &dut).map_err(|error| CommandError::usage(error.to_string()))?;
        match format {
            None => Ok((manual, dut)),
            Some(format) => Ok((self.manual(sources, format)?, dut)),
        }
    }
}
