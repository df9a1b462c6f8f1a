//! Complaints of users of other plugins, rebuilt as tests. Each test names the thread.

mod dynamics;
mod events;
mod leaving;
mod places;
mod questions;
