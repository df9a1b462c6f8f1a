//! All integration tests, one binary.

mod property_hull;
