//! Values on the command line: each parser says which are allowed.

use std::path::PathBuf;
use std::str::FromStr;

use clap::builder::PossibleValuesParser;
use drystone::threads::SimdLevel;

use crate::output::has_extension;
use crate::render::RenderKind;

/// The levels this machine has, by name.
pub(super) fn simd_levels() -> PossibleValuesParser {
    PossibleValuesParser::new(SimdLevel::available().iter().map(|level| level.name()))
}

/// Parses a number that `fits`; `allowed` says which do.
pub(super) fn number<T: FromStr>(
    text: &str,
    allowed: &str,
    fits: impl Fn(&T) -> bool,
) -> Result<T, String> {
    text.trim().parse().ok().filter(fits).ok_or_else(|| format!("expected {allowed}"))
}

pub(super) fn seconds(text: &str) -> Result<f64, String> {
    number(text, "a number of seconds from 0 to 1e9", |s: &f64| (0.0..=1.0e9).contains(s))
}

pub(super) fn hz(text: &str) -> Result<f32, String> {
    number(text, "a number of steps per second from 0.001 to 1e6", |hz: &f32| is_rate(*hz))
}

/// True if a world can have this number of steps a second.
pub(crate) fn is_rate(hz: f32) -> bool {
    (1.0e-3..=1.0e6).contains(&hz)
}

pub(super) fn assignment(text: &str) -> Result<(String, String), String> {
    match text.split_once('=') {
        Some((key, value)) if !key.trim().is_empty() => {
            Ok((key.trim().to_owned(), value.trim().to_owned()))
        }
        _ => Err("expected KEY=VALUE, such as sleep.enabled=false".to_owned()),
    }
}

pub(super) fn bake_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    if has_extension(&path, &["glb", "gltf"]) {
        Ok(path)
    } else {
        Err("expected a file name that ends in .glb or .gltf".to_owned())
    }
}

pub(super) fn convert_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    if has_extension(&path, &["json", "glb", "gltf"]) {
        Ok(path)
    } else {
        Err("expected a file name that ends in .json (the own format), .glb or .gltf".to_owned())
    }
}

pub(super) fn render_path(text: &str) -> Result<PathBuf, String> {
    let path = PathBuf::from(text);
    if RenderKind::of(&path).is_some() {
        Ok(path)
    } else {
        Err("expected a file name that ends in .png, .gif, .mp4, .webm, .mkv or .mov; of numbered \
             pictures with one number such as %04d"
            .to_owned())
    }
}

pub(super) fn size(text: &str) -> Result<(u32, u32), String> {
    let side = |text: &str| text.trim().parse().ok().filter(|n| (1..=16384).contains(n));
    let parts = text.split_once(['x', 'X', '×']);
    parts
        .and_then(|(width, height)| Some((side(width)?, side(height)?)))
        .ok_or_else(|| "expected a size from 1x1 to 16384x16384, such as 1280x720".to_owned())
}

pub(super) fn fps(text: &str) -> Result<f64, String> {
    number(text, "a number of frames per second from 0.1 to 240", |f: &f64| {
        (0.1..=240.0).contains(f)
    })
}

pub(super) fn height(text: &str) -> Result<f32, String> {
    let number = text.parse::<f32>().ok().filter(|z| z.abs() <= 1.0e6);
    number.ok_or_else(|| "expected a height within ±1e6 m".to_owned())
}
