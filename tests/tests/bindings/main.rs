//! The library for C and C++ and the Python package: the header, programs of other compilers, and
//! results that equal those of Rust to the bit.

mod c_programs;
mod header_is_current;
mod python_package;
