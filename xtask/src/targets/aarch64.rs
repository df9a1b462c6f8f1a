//! aarch64, as in phones and many servers, in the emulator qemu.

use std::path::Path;

use super::{Target, Way, build_program};
use crate::{Outcome, debian};

const TRIPLE: &str = "aarch64-unknown-linux-gnu";
const LINKER: &str = "aarch64-linux-gnu-gcc";
const EMULATOR: &str = "qemu-aarch64";
/// Debian's C library for aarch64.
const LIBRARY: &str = "/usr/aarch64-linux-gnu";

pub(super) const TARGET: Target = Target { name: "aarch64", given: || Ok(()), found, build };

fn found() -> Outcome {
    debian::compiler()?;
    debian::program(LINKER, &["--version"])?;
    debian::program(EMULATOR, &["--version"])?;
    let library = Path::new(LIBRARY).join("lib/libc.so.6");
    if library.exists() { Ok(()) } else { Err(format!("no {}", library.display())) }
}

fn build() -> Result<Vec<Way>, String> {
    let linker = ["CARGO_TARGET_AARCH64_UNKNOWN_LINUX_GNU_LINKER", LINKER];
    let program = build_program(TRIPLE, linker)?;
    let way = |level, threads| Way {
        program: vec![EMULATOR.into(), "-L".into(), LIBRARY.into(), program.clone()],
        level,
        threads,
    };
    Ok(vec![way("neon", 1), way("neon", 3)])
}
