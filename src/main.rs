//! The program; everything is in `tumble::cli`.

fn main() -> std::process::ExitCode {
    tumble::cli::main()
}
