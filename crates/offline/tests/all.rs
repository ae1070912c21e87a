//! The tests of files, one module a file, linked once. What measures time is a program of its own.

mod descriptions;
mod docs;
mod exr;
