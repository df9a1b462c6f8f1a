//! The catalog of scenes and the file formats.
