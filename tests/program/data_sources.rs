//! Every file of `tests/data` is named in its README with where it comes from, and none stands twice there.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

fn files(folder: &Path) -> Vec<PathBuf> {
    let mut all = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() { all.extend(files(&path)) } else { all.push(path) }
    }
    all
}

#[test]
fn every_data_file_has_a_source() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data");
    let readme = std::fs::read_to_string(data.join("README.md")).unwrap();
    for entry in std::fs::read_dir(&data).unwrap() {
        let entry = entry.unwrap();
        let name = entry.file_name().to_string_lossy().to_string();
        let named = if entry.path().is_dir() { format!("`{name}/`") } else { format!("`{name}`") };
        assert!(
            name == "README.md" || readme.contains(&named),
            "tests/data/README.md does not say where {named} comes from"
        );
    }
    let mut contents: BTreeMap<Vec<u8>, PathBuf> = BTreeMap::new();
    for path in files(&data) {
        let content = std::fs::read(&path).unwrap();
        if content.is_empty() {
            continue; // malformed questions among them have nothing inside
        }
        if let Some(other) = contents.insert(content, path.clone()) {
            panic!("{} stands twice: also as {}", path.display(), other.display());
        }
    }
}
