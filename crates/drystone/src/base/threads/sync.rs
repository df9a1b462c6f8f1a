//! Primitives of the worker team: threads, locks and atomics. They are from the standard library,
//! or under `--cfg drystone_model` from a model checker, which runs the team itself through many
//! schedules (`cargo xtask model`).

#[cfg(not(all(test, drystone_model)))]
pub(crate) use {
    core::hint::spin_loop,
    core::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering},
    std::sync::{Arc, Condvar, Mutex, MutexGuard},
    std::thread::{Builder, JoinHandle, yield_now},
};

#[cfg(all(test, drystone_model))]
pub(crate) use shuttle::{
    hint::spin_loop,
    sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering},
    sync::{Arc, Condvar, Mutex, MutexGuard},
    thread::{Builder, JoinHandle, yield_now},
};
