//! The console blocks of the examples' READMEs say what the program prints.
//! (`python3 tests/scripts/example_readmes.py` writes them again.)

use crate::support::read;
use std::path::Path;
use std::process::Command;

#[test]
fn every_console_block_is_what_the_program_prints() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("examples");
    let folders = [
        "10-imu-three-axis-table",
        "11-gyro-skew-triad",
        "12-cube-mirror",
        "13-accelerometer-dividing-head",
        "14-xsens-static-positions",
    ];
    let mut blocks = 0;
    for folder in folders {
        let text = read(&format!("examples/{folder}/README.md"));
        for block in text.split("```console\n").skip(1) {
            let block = block.split("```").next().unwrap_or_default();
            let mut lines = block.lines();
            let command = lines.next().and_then(|line| line.strip_prefix("$ tumble ")).expect("a command");
            let output = Command::new(env!("CARGO_BIN_EXE_tumble"))
                .args(command.split_whitespace())
                .current_dir(root.join(folder))
                .output()
                .unwrap();
            let printed = String::from_utf8(output.stdout).unwrap();
            let mut printed = printed.lines();
            for line in lines.filter(|line| *line != "...") {
                assert!(printed.any(|own| own.trim_end() == line), "{folder}: tumble {command}: {line}");
            }
            blocks += 1;
        }
        for picture in
            text.split("](").skip(1).filter_map(|rest| rest.split(')').next()).filter(|p| p.ends_with(".svg"))
        {
            assert!(root.join(folder).join(picture).exists(), "{folder}: {picture}");
        }
    }
    assert!(blocks > 8);
}
