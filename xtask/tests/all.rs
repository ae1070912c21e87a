//! The tests of the repository's form, one module a file, linked once.

mod architecture;
mod arrows;
mod circles;
mod imports;
mod names;
mod pages;
mod programs;
mod sentences;
mod sizes;
