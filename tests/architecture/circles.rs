//! Files of one package do not use each other in circles.
//!
//! An edge leads from a file to the file that defines what it names through `crate::`, `super::`,
//! `self::` or a child module. Re-exports are followed to their origin and are no edges themselves;
//! neither is what passes between a module and those inside it, which are one room.

use super::scan::{blanked, is_word};
use super::{code, is_test, sources};
use std::collections::{BTreeMap, BTreeSet};

type Path = Vec<String>;

/// A file of a package as a module.
#[derive(Default)]
struct Module {
    children: BTreeSet<String>,
    /// Names that `use` brings in, with the path they stand for.
    names: BTreeMap<String, Path>,
    /// Modules of which everything is brought in.
    globs: Vec<Path>,
    /// Every path that the file names.
    paths: Vec<Path>,
    /// Words of the code, to find where a glob leads.
    defines: BTreeSet<String>,
}

/// All modules of a package, by their path from the crate's root.
struct Package {
    modules: BTreeMap<Path, Module>,
}

impl Package {
    fn new(files: &[(&str, &str)]) -> Self {
        let mut modules: BTreeMap<Path, Module> = BTreeMap::new();
        for (name, text) in files {
            modules.insert(module_path(name), Module::new(text));
        }
        let paths: Vec<Path> = modules.keys().cloned().collect();
        for path in &paths {
            if let Some((last, parent)) = path.split_last()
                && let Some(module) = modules.get_mut(parent)
            {
                module.children.insert(last.clone());
            }
        }
        Self { modules }
    }

    /// The module that defines what `path` names in `from`; none outside the package.
    fn resolve(&self, from: &Path, path: &[String], depth: usize) -> Option<Path> {
        let (first, rest) = path.split_first()?;
        let start = match first.as_str() {
            "crate" => Vec::new(),
            "self" => from.clone(),
            "super" => from.split_last()?.1.to_vec(),
            _ if self.modules[from].children.contains(first) => {
                return self.walk([from.clone(), vec![first.clone()]].concat(), rest, depth);
            }
            _ => return None,
        };
        self.walk(start, rest, depth)
    }

    fn walk(&self, mut at: Path, rest: &[String], depth: usize) -> Option<Path> {
        let mut rest = rest;
        while let Some((first, after)) = rest.split_first() {
            let module = self.modules.get(&at)?;
            if first == "super" {
                at.pop();
            } else if module.children.contains(first) {
                at.push(first.clone());
            } else if let Some(origin) = module.names.get(first).filter(|_| depth < 8) {
                let whole = [origin.clone(), after.to_vec()].concat();
                return self.resolve(&at, &whole, depth + 1).or(Some(at));
            } else {
                let of_glob = |glob: &Path| {
                    let origin = self.resolve(&at, glob, depth + 1)?;
                    self.modules.get(&origin)?.defines.contains(first).then_some(origin)
                };
                let defined_here = module.defines.contains(first);
                let found = module.globs.iter().filter(|_| depth < 8 && !defined_here);
                return found.filter_map(of_glob).next().or(Some(at));
            }
            rest = after;
        }
        Some(at)
    }

    fn edges(&self) -> BTreeMap<&Path, BTreeSet<Path>> {
        let of = |(path, module): (_, &Module)| {
            let mut to: BTreeSet<Path> =
                module.paths.iter().filter_map(|p| self.resolve(path, p, 0)).collect();
            to.retain(|to| !to.starts_with(path) && !path.starts_with(to));
            (path, to)
        };
        self.modules.iter().map(of).collect()
    }

    /// Groups of files each of which reaches the others.
    fn circles(&self) -> Vec<BTreeSet<String>> {
        let edges = self.edges();
        let reach: BTreeMap<&Path, BTreeSet<Path>> =
            edges.keys().map(|from| (*from, reachable(&edges, from))).collect();
        let mut found = BTreeSet::new();
        for (from, to) in &reach {
            if to.contains(*from) {
                let group = to.iter().filter(|t| reach[t].contains(*from));
                found.insert(group.map(|p| format!("crate::{}", p.join("::"))).collect());
            }
        }
        found.into_iter().collect()
    }
}

fn reachable(edges: &BTreeMap<&Path, BTreeSet<Path>>, from: &Path) -> BTreeSet<Path> {
    let mut seen = BTreeSet::new();
    let mut open: Vec<&Path> = edges[from].iter().collect();
    while let Some(next) = open.pop() {
        if seen.insert(next.clone()) {
            open.extend(&edges[next]);
        }
    }
    seen
}

impl Module {
    fn new(text: &str) -> Self {
        let text = blanked(text);
        let mut module = Self::default();
        for (at, word) in starts_of_paths(&text) {
            let mut paths = Vec::new();
            tree(&text[at..], &[], &mut paths);
            match word {
                Start::ReExport => module.bring_in(paths),
                Start::Use => {
                    module.paths.extend(paths.iter().map(|(path, _)| path.clone()));
                    module.bring_in(paths);
                }
                Start::Code => module.paths.extend(paths.into_iter().map(|(path, _)| path)),
            }
        }
        let items = ["fn ", "struct ", "enum ", "trait ", "const ", "static ", "type ", "union "];
        for item in items {
            for (at, _) in text.match_indices(item) {
                let name = text[at + item.len()..].trim_start_matches("mut ");
                module.defines.insert(name.chars().take_while(|&c| is_word(c)).collect());
            }
        }
        module
    }

    fn bring_in(&mut self, paths: Vec<(Path, String)>) {
        for (mut path, name) in paths {
            if name == "*" {
                path.pop();
                self.globs.push(path);
            } else {
                self.names.insert(name, path);
            }
        }
    }
}

#[derive(Clone, Copy)]
enum Start {
    Code,
    Use,
    ReExport,
}

/// Beginnings of paths of more than one word.
fn starts_of_paths(text: &str) -> Vec<(usize, Start)> {
    let mut found = Vec::new();
    let mut before = ' ';
    let mut used_until = 0;
    for (at, c) in text.char_indices() {
        if is_word(c) && !is_word(before) && at >= used_until {
            let rest = &text[at..];
            let after_colons = text[..at].ends_with("::");
            if rest.starts_with("use ") {
                let line = text[..at].rsplit(['\n', ';', '{', '}']).next().unwrap_or_default();
                let start =
                    if line.trim_start().starts_with("pub") { Start::ReExport } else { Start::Use };
                used_until = at + rest.find(';').unwrap_or(rest.len());
                found.push((at + "use ".len(), start));
            } else if !after_colons {
                let end = rest.find(|c| !is_word(c)).unwrap_or(rest.len());
                if rest[end..].starts_with("::") {
                    found.push((at, Start::Code));
                }
            }
        }
        before = c;
    }
    found
}

/// Reads the tree of paths that begins `text`; each with the name that it brings in.
fn tree<'a>(text: &'a str, prefix: &[String], out: &mut Vec<(Path, String)>) -> &'a str {
    let mut path = prefix.to_vec();
    let mut rest = text.trim_start();
    loop {
        if let Some(group) = rest.strip_prefix('{') {
            rest = group.trim_start();
            while !rest.is_empty() && !rest.starts_with('}') {
                let before = rest.len();
                rest = tree(rest, &path, out).trim_start();
                rest = rest.strip_prefix(',').unwrap_or(rest).trim_start();
                if rest.len() == before {
                    return "";
                }
            }
            return rest.get(1..).unwrap_or_default();
        }
        let end = rest.find(|c: char| !is_word(c) && c != '*').unwrap_or(rest.len());
        if end == 0 {
            break;
        }
        path.push(rest[..end].to_owned());
        rest = &rest[end..];
        let Some(further) = rest.strip_prefix("::") else { break };
        rest = further;
    }
    let mut name = path.last().cloned().unwrap_or_default();
    if let Some(alias) = rest.trim_start().strip_prefix("as ") {
        name = alias.trim_start().chars().take_while(|&c| is_word(c)).collect();
        rest = &alias.trim_start()[name.len()..];
    }
    if path.last().is_some_and(|last| last == "self") {
        path.pop();
        name = path.last().cloned().unwrap_or_default();
    }
    out.push((path, name));
    rest
}

/// `src/a/mod.rs` and `src/a.rs` are the module `a`.
fn module_path(file: &str) -> Path {
    let inside = file.rsplit_once("/src/").map_or(file, |(_, inside)| inside);
    let mut parts: Path = inside.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
    if parts.last().is_some_and(|last| last == "mod")
        || parts.len() == 1 && (parts[0] == "lib" || parts[0] == "main")
    {
        parts.pop();
    }
    parts
}

#[test]
fn files_of_a_package_do_not_use_each_other_in_circles() {
    let mut packages: BTreeMap<String, Vec<(String, String)>> = BTreeMap::new();
    for (path, text) in sources() {
        if let Some((package, _)) = path.split_once("/src/")
            && !is_test(&path)
        {
            packages.entry(package.to_owned()).or_default().push((path.clone(), code(&text)));
        }
    }
    let mut wrong = Vec::new();
    for (name, files) in &packages {
        let files: Vec<(&str, &str)> =
            files.iter().map(|(path, text)| (path.as_str(), text.as_str())).collect();
        let circles = Package::new(&files).circles();
        wrong.extend(circles.into_iter().map(|circle| (name, circle)));
    }
    assert!(wrong.is_empty(), "files that use each other in circles: {wrong:#?}");
}

#[test]
fn circles_are_found_and_re_exports_are_none() {
    let lib = ("x/src/lib.rs", "mod a; mod b; pub use a::A; use b::B; fn f() { b::g() }");
    let a = ("x/src/a.rs", "use crate::b::{self, C as D}; pub struct A;");
    let straight = ("x/src/b.rs", "pub struct B; pub struct C;");
    assert!(Package::new(&[lib, a, straight]).circles().is_empty());
    let round = ("x/src/b.rs", "pub struct B(crate::A); pub struct C;");
    let found = Package::new(&[lib, a, round]).circles();
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].iter().collect::<Vec<_>>(), ["crate::a", "crate::b"]);
}
