//! The library for C and C++ and the Python package: the header, programs built by C and C++
//! compilers, and results that are bit-identical to those of Rust.

mod c_programs;
mod csharp;
mod header_is_current;
mod python_package;
