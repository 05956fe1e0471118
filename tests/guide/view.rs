//! The view of a terminal: what it shows of a step, at the usual sizes of a terminal.

use tumble::report::GuideReport;
use tumble::wire::{Source, read_campaign};

fn file(name: &str) -> String {
    format!("{}/examples/28-guided-calibration/{name}", env!("CARGO_MANIFEST_DIR"))
}

/// The example's guide, line by line of its JSON.
fn steps() -> Vec<GuideReport> {
    let folder = tempfile::tempdir().unwrap();
    let arguments = ["guide", "--noise", "V=1e-4", "--goal", "8", "--json", "-", "--simulate"];
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_tumble"))
        .args(arguments)
        .args([file("hidden.truth.json"), "-o".into(), "own.campaign.json".into(), file("schedule.campaign.json")])
        .current_dir(folder.path())
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    let said = String::from_utf8(output.stdout).unwrap();
    said.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

#[test]
fn the_screen_shows_what_the_step_says() {
    let path = file("schedule.campaign.json");
    let source = Source { name: path.clone(), text: std::fs::read_to_string(&path).unwrap() };
    let campaign = read_campaign(&source, &mut |name| panic!("refers to {name}")).unwrap();
    let steps = steps();
    let of = |step: &GuideReport, size: [u16; 2]| {
        let next = step.advice.next.as_ref().map(|own| own.position.clone());
        let asked = campaign.readings.rows.iter().find(|row| Some(row.position.as_str()) == next.as_deref());
        let joints = asked.map_or(&[][..], |row| &row.joints[..]);
        tumble::cli::guide_screen(&campaign.bench, step, joints, size).unwrap()
    };
    for step in &steps {
        for size in [[80, 24], [120, 40], [30, 8], [1, 1]] {
            let screen = of(step, size);
            assert_eq!(screen.lines().count(), usize::from(size[1]));
            assert!(screen.lines().all(|line| line.chars().count() <= usize::from(size[0])), "{screen}");
        }
    }
    let flat = |screen: &str| screen.split_whitespace().collect::<Vec<_>>().join(" ");
    let odd = steps.iter().find(|step| step.advice.mistake.is_some()).unwrap();
    let screen = of(odd, [120, 40]);
    println!("{screen}");
    let newest = odd.advice.newest.as_ref().unwrap();
    assert!(flat(&screen).contains(&format!("reading {}", newest.reading)) && screen.contains("DOES NOT AGREE"));
    for own in &odd.advice.goals {
        assert!(screen.contains(&own.id), "{}: {screen}", own.id);
    }
    let probability = format!("{:.3}", odd.advice.nothing_missing_or_named);
    assert!(screen.contains(&probability) && screen.contains('\u{25cf}'), "{screen}");
    let next = odd.advice.next.as_ref().unwrap();
    assert!(flat(&screen).contains(&format!("position {}", next.position)), "{screen}");
    let last = of(steps.last().unwrap(), [100, 32]);
    println!("{last}");
    assert!(last.contains("done: every goal is met") && last.contains("a_O^2"), "{last}");
}

/// Without a terminal the view is refused before anything is written.
#[test]
fn without_a_terminal_there_is_no_view() {
    let folder = tempfile::tempdir().unwrap();
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_tumble"))
        .args(["guide", "--noise", "V=1e-4", "--view", &file("schedule.campaign.json")])
        .current_dir(folder.path())
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stderr).to_string();
    assert_eq!(output.status.code(), Some(1), "{said}");
    assert!(said.contains("--view needs a terminal"), "{said}");
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
}
