//! Names with `*` and `?`, where the shell has left them.

use crate::elements::Parts;
use crate::error::{Fault, Malformed, Result};
use std::path::{Path, PathBuf};

/// The files that these names denote, those of one pattern in the order of their names.
///
/// Errors: a pattern that no file has.
pub(super) fn expand(names: &[PathBuf]) -> Result<Vec<PathBuf>> {
    let mut found = Vec::new();
    for name in names {
        let text = name.to_string_lossy();
        if name.exists() || !text.contains(['*', '?']) {
            found.push(name.clone());
            continue;
        }
        let mut matching = matching(name);
        if matching.is_empty() {
            return Err(Malformed::new(Fault::File, format!("no file is called '{text}'"))
                .expected("a file, or a pattern with * and ? that some file matches"));
        }
        matching.sort();
        found.append(&mut matching);
    }
    Ok(found)
}

fn matching(pattern: &Path) -> Vec<PathBuf> {
    let mut folders = vec![PathBuf::new()];
    for part in pattern.components() {
        let text = part.as_os_str().to_string_lossy().to_string();
        if !text.contains(['*', '?']) {
            folders.iter_mut().for_each(|folder| folder.push(part));
            continue;
        }
        let mut next = Vec::new();
        for folder in folders {
            let listed = if folder.as_os_str().is_empty() { Path::new(".") } else { &folder };
            for entry in std::fs::read_dir(listed).into_iter().flatten().flatten() {
                let name = entry.file_name();
                let hidden = name.to_string_lossy().starts_with('.') && !text.starts_with('.');
                if !hidden && fits(text.as_bytes(), name.to_string_lossy().as_bytes()) {
                    next.push(folder.join(name));
                }
            }
        }
        folders = next;
    }
    folders.retain(|path| path.is_file());
    folders
}

/// Does a name fit a pattern of `*` (any text) and `?` (one byte)?
fn fits(pattern: &[u8], name: &[u8]) -> bool {
    match (pattern, name) {
        ([b'*', tail @ ..], _) => (0..=name.len()).any(|from| fits(tail, name.part(from..))),
        ([sign, tail @ ..], [byte, name @ ..]) => (*sign == b'?' || sign == byte) && fits(tail, name),
        (pattern, name) => pattern.is_empty() && name.is_empty(),
    }
}
