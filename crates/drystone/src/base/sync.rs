//! What the worker team is made of: threads, locks and atomic numbers. Those of the standard library; under `--cfg drystone_model`
//! those of a model checker, which runs the team itself through many schedules (`cargo xtask model`).

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
