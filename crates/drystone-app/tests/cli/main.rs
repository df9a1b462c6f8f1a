//! The command as its users meet it: exit statuses, messages, files.

#![expect(clippy::unwrap_used, reason = "a test that cannot go on fails")]

mod breaking;
#[path = "../command/mod.rs"]
mod command;
#[path = "../common/mod.rs"]
mod common;
mod measuring;
mod outputs;
mod resuming;
mod robots;
mod running;
mod usage;
