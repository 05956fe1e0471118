//! No file of `src` needs, by way of others, itself: imports run one way between files as they do between folders.
//!
//! A folder's `mod.rs` is its face: what a file takes from the `mod.rs` above it, or a `mod.rs` shows of its files by `pub use`, does not count.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// A module by its path below the crate, for example `["plan", "judge"]`.
type Module = Vec<String>;
type Edges = BTreeMap<Module, BTreeSet<Module>>;

/// Imports that stay, with the reason: (from, to, why).
const KEPT: [(&str, &str, &str); 0] = [];

fn collect(folder: &Path, path: &[String], found: &mut BTreeMap<Module, String>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let file = entry.unwrap().path();
        let name = file.file_stem().unwrap().to_string_lossy().to_string();
        let below = [path, std::slice::from_ref(&name)].concat();
        if file.is_dir() {
            collect(&file, &below, found);
        } else if file.extension().is_some_and(|own| own == "rs") && name != "main" && name != "lib" {
            let text = std::fs::read_to_string(&file).unwrap();
            // unit tests may look where they like
            let text = text.split("#[cfg(test)]\nmod ").next().unwrap_or_default();
            let code: Vec<&str> = text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect();
            found.insert(if name == "mod" { path.to_vec() } else { below }, code.join("\n"));
        }
    }
}

/// The paths of a `use`: `a::{b, c::d as e}` has `a::b` and `a::c::d`.
fn leaves(tree: &str) -> Vec<Vec<String>> {
    fn walk(rest: &mut &str, path: &[String], found: &mut Vec<Vec<String>>) {
        let mut path = path.to_vec();
        let mut is_open = true;
        loop {
            *rest = rest.trim_start_matches([' ', '\n', ':']);
            match rest.chars().next() {
                Some('{') => {
                    is_open = false;
                    *rest = &rest[1..];
                    while !rest.trim_start().starts_with('}') && !rest.is_empty() {
                        walk(rest, &path, found);
                        *rest = rest.trim_start_matches([' ', '\n', ',']);
                    }
                    *rest = rest.trim_start().strip_prefix('}').unwrap_or_default();
                }
                None | Some(',' | '}') => break,
                Some(_) => {
                    let end = rest.find([':', ',', '}', '{', ' ', '\n']).unwrap_or(rest.len());
                    path.push(rest[..end].to_string());
                    *rest = &rest[end..];
                    if let Some(renamed) = rest.trim_start().strip_prefix("as ") {
                        *rest = &renamed[renamed.find([',', '}']).unwrap_or(renamed.len())..];
                    }
                }
            }
        }
        if is_open && !path.is_empty() {
            path.retain(|own| own != "self");
            found.push(path);
        }
    }
    let mut found = Vec::new();
    walk(&mut &*tree, &[], &mut found);
    found
}

struct Source {
    code: BTreeMap<Module, String>,
    /// What a module shows under a name, and where that stands.
    shown: BTreeMap<(Module, String), Module>,
}

impl Source {
    /// The module that a path means, and the name in it that follows.
    fn resolve(&self, path: &[String], from: &Module) -> Option<(Module, Option<String>)> {
        let ups = path.iter().take_while(|own| *own == "super").count();
        let full: Vec<String> = match path.first()?.as_str() {
            "crate" => path[1..].to_vec(),
            "super" => [&from[..from.len().checked_sub(ups)?], &path[ups..]].concat(),
            _ if self.code.contains_key(&[from.as_slice(), &path[..1]].concat()) => [from.as_slice(), path].concat(),
            _ => return None,
        };
        (0..=full.len())
            .rev()
            .find(|k| self.code.contains_key(&full[..*k]))
            .map(|k| (full[..k].to_vec(), full.get(k).cloned()))
    }

    /// The module in which a path's name is defined.
    fn defined(&self, path: &[String], from: &Module) -> Option<Module> {
        let (mut module, name) = self.resolve(path, from)?;
        let Some(name) = name else { return Some(module) };
        for _ in 0..8 {
            match self.shown.get(&(module.clone(), name.clone())) {
                Some(next) if *next != module => module = next.clone(),
                _ => break,
            }
        }
        Some(module)
    }
}

/// `use` declarations of a text: whether public, and the paths; and the text without them.
fn uses(code: &str) -> (Vec<(bool, Vec<String>)>, String) {
    let (mut found, mut rest) = (Vec::new(), String::new());
    let mut lines = code.lines().peekable();
    while let Some(line) = lines.next() {
        let start = line.trim_start();
        let public = start.starts_with("pub ") || start.starts_with("pub(");
        let after = if public { start.split_once(' ').map_or("", |(_, after)| after) } else { start };
        let Some(first) = after.strip_prefix("use ") else {
            rest.push_str(line);
            rest.push('\n');
            continue;
        };
        let mut tree = first.to_string();
        while !tree.contains(';') {
            let Some(next) = lines.next() else { break };
            tree.push('\n');
            tree.push_str(next);
        }
        let tree = tree.split(';').next().unwrap_or_default();
        found.extend(leaves(tree).into_iter().map(|path| (public, path)));
    }
    (found, rest)
}

/// Paths inside the code: `super::x::y`, `crate::x::y`, and `child::y` of an own child.
fn paths(code: &str) -> Vec<Vec<String>> {
    let is_name = |c: char| c.is_alphanumeric() || c == '_';
    let mut found = Vec::new();
    for word in code.split(|c: char| !is_name(c) && c != ':').filter(|word| word.contains("::")) {
        let path: Vec<String> = word.split("::").map(|own| own.trim_matches(':').to_string()).collect();
        if path.iter().all(|own| !own.is_empty()) {
            found.push(path);
        }
    }
    found
}

fn edges() -> Edges {
    let mut code = BTreeMap::new();
    collect(&Path::new(env!("CARGO_MANIFEST_DIR")).join("src"), &[], &mut code);
    code.insert(Vec::new(), String::new());
    let mut source = Source { code, shown: BTreeMap::new() };
    let parsed: BTreeMap<Module, _> = source.code.iter().map(|(module, text)| (module.clone(), uses(text))).collect();
    for (module, (list, _)) in &parsed {
        for (_, path) in list.iter().filter(|(public, _)| *public) {
            if let (Some((target, _)), Some(name)) = (source.resolve(path, module), path.last()) {
                source.shown.insert((module.clone(), name.clone()), target);
            }
        }
    }
    let mut edges = Edges::new();
    for (module, (list, rest)) in &parsed {
        let imported = list.iter().filter(|(public, _)| !public).map(|(_, path)| path.clone());
        for path in imported.chain(paths(rest)) {
            let Some(target) = source.defined(&path, module) else { continue };
            // the face of the own folder, and of those around it
            if !module.starts_with(&target) {
                edges.entry(module.clone()).or_default().insert(target);
            }
        }
    }
    edges
}

/// Modules from one to itself; `None` where there is no such way.
fn circle(edges: &Edges) -> Option<Vec<String>> {
    // what needs nobody that is left goes, until only circles and the ways between them are left
    let mut left = edges.clone();
    loop {
        let names: BTreeSet<Module> = left.keys().cloned().collect();
        let before: usize = left.values().map(BTreeSet::len).sum();
        left.values_mut().for_each(|own| own.retain(|to| names.contains(to)));
        left.retain(|_, own| !own.is_empty());
        if left.values().map(BTreeSet::len).sum::<usize>() == before {
            break;
        }
    }
    let mut way = vec![left.keys().next()?.clone()];
    loop {
        let next = left.get(way.last()?)?.iter().next()?.clone();
        let start = way.iter().position(|own| *own == next);
        way.push(next);
        if let Some(start) = start {
            return Some(way[start..].iter().map(|own| format!("src/{}", own.join("/"))).collect());
        }
    }
}

#[test]
fn imports_run_one_way_between_files() {
    let mut edges = edges();
    assert!(edges.len() > 300 && edges.values().map(BTreeSet::len).sum::<usize>() > 1500, "imports are not read");
    for (from, to, _) in KEPT {
        let [from, to] = [from, to].map(|own| own.split('/').map(str::to_string).collect::<Module>());
        edges.entry(from).or_default().remove(&to);
    }
    let found = circle(&edges);
    assert!(
        found.is_none(),
        "files that need each other: {}; what both need belongs into a file below them",
        found.unwrap_or_default().join(" -> ")
    );
}

#[test]
fn use_trees_are_read() {
    let path = |text: &str| text.split("::").map(str::to_string).collect::<Vec<_>>();
    let found = leaves("super::{a::{self, B}, c as d,\n    e::F as G}");
    assert_eq!(found, ["super::a", "super::a::B", "super::c", "super::e::F"].map(path));
    let (list, rest) = uses("pub use x::Y;\nuse super::z;\nfn f() { crate::q::r() }\n");
    assert_eq!(list, [(true, path("x::Y")), (false, path("super::z"))]);
    assert_eq!(paths(&rest), [path("crate::q::r")]);
}
