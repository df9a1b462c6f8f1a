//! What users of other plugins complained about, rebuilt as tests. Each names the thread.

mod dynamics;
mod events;
mod leaving;
mod places;
mod questions;
