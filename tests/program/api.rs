//! The public items of the crate as committed text, `docs/public-api.txt`: a change of what others build on is seen.
//!
//! `UPDATE=1 cargo test --release --test program api` writes it anew. The scan reads the formatted sources: items begin in the first column,
//! methods of inherent `impl` blocks in the fifth. What stands in a private module is public if its module says `pub use` of its name. The
//! program (`cli`) is no library, and fields are in the schemas and the documentation.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// One source file: its module, whether all modules down to it are public, its lines.
struct File {
    module: String,
    is_open: bool,
    lines: Vec<String>,
}

/// All files of the crate, by the `mod` lines that lead to them.
fn files(path: PathBuf, module: &str, is_open: bool, found: &mut Vec<File>) {
    let text = std::fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let stem = path.file_stem().expect("a name").to_string_lossy().to_string();
    let parent = path.parent().expect("a folder");
    let folder = if matches!(stem.as_str(), "mod" | "lib") { parent.to_path_buf() } else { parent.join(&stem) };
    for line in text.lines() {
        let (open, rest) = match line.strip_prefix("pub mod ").map(|rest| (true, rest)) {
            Some(found) => found,
            None => match line.strip_prefix("mod ").or_else(|| line.strip_prefix("pub(crate) mod ")) {
                Some(rest) => (false, rest),
                None => continue,
            },
        };
        let Some(name) = rest.strip_suffix(';').filter(|name| *name != "cli") else { continue };
        let own = [folder.join(format!("{name}.rs")), folder.join(name).join("mod.rs")];
        let Some(file) = own.into_iter().find(|file| file.exists()) else { continue };
        let inner = if module.is_empty() { name } else { module };
        files(file, inner, is_open && open, found);
    }
    let end = text.lines().position(|line| line == "#[cfg(test)]").unwrap_or(usize::MAX);
    found.push(File {
        module: module.to_string(),
        is_open,
        lines: text.lines().take(end).map(str::to_string).collect(),
    });
}

/// The text from a line on to the end of its head: what stands before the body, in one line.
fn head(lines: &[String]) -> String {
    let mut text = String::new();
    for line in lines {
        text.push_str(line.trim());
        text.push(' ');
        if line.trim_end().ends_with('{') || line.trim_end().ends_with(';') || line.trim_end().ends_with('}') {
            break;
        }
    }
    let text = text.trim().trim_end_matches(';').trim_end_matches('{').trim();
    let text = text.split(" where ").next().unwrap_or_default().trim_end_matches(',');
    text.replace("( ", "(").replace(", )", ")").replace(" )", ")").trim().to_string()
}

/// The name that an item's head introduces after its keyword.
fn name(rest: &str) -> String {
    rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect()
}

/// Names that `pub use` lines of a file re-export.
fn exported(lines: &[String]) -> Vec<String> {
    let mut names = Vec::new();
    for (k, line) in lines.iter().enumerate().filter(|(_, line)| line.starts_with("pub use ")) {
        let whole: String = lines[k..]
            .iter()
            .scan(true, |on, l| {
                on.then(|| {
                    *on = !l.contains(';');
                    l.trim().to_string()
                })
            })
            .collect();
        let list = whole.trim_start_matches("pub use ").trim_end_matches(';');
        let list = list.split_once('{').map_or(list, |(_, inner)| inner.trim_end_matches('}'));
        for own in list.split(',').map(str::trim).filter(|own| !own.is_empty()) {
            let own = own.rsplit("::").next().unwrap_or(own);
            names.push(own.split(" as ").next().unwrap_or(own).to_string());
        }
        let _ = line;
    }
    names
}

fn listed() -> String {
    let mut all = Vec::new();
    files(Path::new(env!("CARGO_MANIFEST_DIR")).join("src/lib.rs"), "", true, &mut all);
    let mut open: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for file in all.iter().filter(|file| file.is_open) {
        open.entry(file.module.clone()).or_default().extend(exported(&file.lines));
    }
    let mut items: BTreeSet<String> = BTreeSet::new();
    // public types, and all that a module has: a type of another module may have the same name
    let (mut types, mut own_types) = (BTreeSet::new(), BTreeSet::new());
    let keywords = ["fn", "const fn", "struct", "enum", "trait", "const", "static", "type"];
    for file in &all {
        let module = if file.module.is_empty() { "tumble" } else { &file.module };
        for (k, line) in file.lines.iter().enumerate() {
            let private = ["pub(crate) ", "pub(super) ", ""].iter().find_map(|word| line.strip_prefix(word));
            let declared = ["struct ", "enum "].iter().find_map(|word| private?.strip_prefix(word));
            own_types.extend(declared.map(|rest| (file.module.clone(), name(rest))));
            let item = keywords
                .iter()
                .find_map(|word| Some((*word, line.strip_prefix("pub ")?.strip_prefix(word)?.strip_prefix(' ')?)));
            let (kind, own, text) = match item {
                Some((kind, rest)) if kind.ends_with("fn") => (kind, name(rest), head(&file.lines[k..])),
                Some((kind, rest)) => (kind, name(rest), format!("pub {kind} {}", name(rest))),
                None if line.starts_with("vocabulary! {") => {
                    let inner = file.lines[k..].iter().skip(1).find(|l| !l.trim_start().starts_with(['/', '#']));
                    let own = inner.map(|l| name(l.trim())).unwrap_or_default();
                    ("enum", own.clone(), format!("pub enum {own}"))
                }
                None => continue,
            };
            let is_type = matches!(kind, "struct" | "enum" | "trait");
            if is_type {
                own_types.insert((file.module.clone(), own.clone()));
            }
            if file.is_open || open.get(&file.module).is_some_and(|names| names.contains(&own)) {
                items.insert(format!("{module}: {text}"));
                if is_type {
                    types.insert((file.module.clone(), own));
                }
            }
        }
    }
    for file in &all {
        let mut of: Option<String> = None;
        for (k, line) in file.lines.iter().enumerate() {
            if let Some(rest) = line.strip_prefix("impl") {
                let rest = match rest.strip_prefix('<') {
                    Some(generic) => generic.split_once("> ").map_or("", |(_, rest)| rest),
                    None => rest.trim_start(),
                };
                // a method of another module's type stands where it is written
                let is_listed = |own: &String| {
                    let here = (file.module.clone(), own.clone());
                    types.contains(&here)
                        || !own_types.contains(&here) && types.iter().any(|(_, another)| another == own)
                };
                of = Some(name(rest)).filter(|own| is_listed(own) && !line.contains(" for "));
            } else if line == "}" {
                of = None;
            } else if let Some(own) = &of
                && (line.starts_with("    pub fn ") || line.starts_with("    pub const "))
            {
                let text = head(&file.lines[k..]);
                let text = if text.starts_with("pub const ") && !text.contains(" fn ") {
                    text.split(" = ").next().unwrap_or_default().to_string()
                } else {
                    text
                };
                items.insert(format!("{}: {own}: {text}", file.module));
            }
        }
    }
    for reexport in
        &all.iter().find(|file| file.module.is_empty()).map(|root| exported(&root.lines)).unwrap_or_default()
    {
        items.insert(format!("tumble: pub use {reexport}"));
    }
    let head = "Public items of the library, one a line: the module, the type for its methods, the item.\n\n";
    head.to_string() + &items.into_iter().collect::<Vec<_>>().join("\n") + "\n"
}

#[test]
fn public_items_are_the_committed_ones() {
    let found = listed();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/public-api.txt");
    if std::env::var_os("UPDATE").is_some() {
        std::fs::write(&path, &found).expect("written");
    }
    let committed = std::fs::read_to_string(&path).expect("docs/public-api.txt");
    let (old, new): (BTreeSet<&str>, BTreeSet<&str>) = (committed.lines().collect(), found.lines().collect());
    let gone: Vec<&str> = old.difference(&new).copied().collect();
    let came: Vec<&str> = new.difference(&old).copied().collect();
    assert!(
        gone.is_empty() && came.is_empty(),
        "the public items changed (UPDATE=1 cargo test --release --test program api)\ngone:\n  {}\nnew:\n  {}",
        gone.join("\n  "),
        came.join("\n  ")
    );
    assert!(found.contains("fit: pub fn fit(campaign: &Campaign, settings: &Settings) -> Result<Fit>"), "{found}");
    assert!(!found.contains("pulp"), "what the library computes with is no part of its interface");
}
