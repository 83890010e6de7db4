//! The `wheelrail` program.
#![deny(unsafe_code)]

fn main() -> std::process::ExitCode {
    wheelrail::cli::main()
}
