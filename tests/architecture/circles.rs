//! Source files and their folders do not depend on each other in cycles: Rust, JavaScript and
//! Python.

use super::{code, is_test, sources_of};
use std::collections::{BTreeMap, BTreeSet};

/// A file by its folders and its name, or a name in it. A module with a folder of its own is that
/// folder.
type Path = Vec<String>;

/// Pairs of files of which the first uses the second.
type Uses = BTreeSet<(Path, Path)>;

/// The dependency cycles, each as the uses that make it. A node is a file, or a folder with all
/// that is in it: a use is an edge between nodes of the innermost folder that holds both files.
/// Uses between a module and those inside it are within one node.
fn circles(uses: &Uses) -> BTreeSet<Vec<String>> {
    let nodes_of_use = |(from, to): &(Path, Path)| {
        let shared = from.iter().zip(to).take_while(|(a, b)| a == b).count();
        let apart = shared < from.len().min(to.len());
        apart.then(|| (from[..=shared].join("/"), to[..=shared].join("/")))
    };
    let mut edges: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for (from, to) in uses.iter().filter_map(nodes_of_use) {
        edges.entry(from).or_default().insert(to);
    }
    let reach: BTreeMap<&String, BTreeSet<&String>> =
        edges.keys().map(|from| (from, reachable(&edges, from))).collect();
    let is_round = |a: &String, b: &String| reach[a].contains(b) && reach[b].contains(a);
    let circle = |node: &String| {
        let inside = |used: &&(Path, Path)| {
            nodes_of_use(used).is_some_and(|(a, b)| {
                reach.contains_key(&b) && is_round(node, &a) && is_round(node, &b)
            })
        };
        let description = |(a, b): &(Path, Path)| format!("{} uses {}", a.join("/"), b.join("/"));
        uses.iter().filter(inside).map(description).collect()
    };
    edges.keys().filter(|node| is_round(node, node)).map(circle).collect()
}

fn reachable<'a>(
    edges: &'a BTreeMap<String, BTreeSet<String>>,
    from: &String,
) -> BTreeSet<&'a String> {
    let mut reached = BTreeSet::new();
    let mut open: Vec<&String> = edges[from].iter().collect();
    while let Some(next) = open.pop() {
        if reached.insert(next) {
            open.extend(edges.get(next).into_iter().flatten());
        }
    }
    reached
}

/// The path of a file without its extension.
fn path(file: &str) -> Path {
    let whole = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    whole.split('/').map(str::to_owned).collect()
}

fn below(folder: &[String], name: &str) -> Path {
    [folder, &[name.to_owned()]].concat()
}

/// A Rust file as others see it.
#[derive(Default)]
struct Module {
    /// Names that `use` brings in, with the paths they stand for.
    names: BTreeMap<String, Path>,
    /// Every path that the file names. Re-exports are none: they are followed to their origin.
    paths: Vec<Path>,
}

fn rust<'a>(files: impl Iterator<Item = (&'a str, &'a str)>) -> Uses {
    let modules: BTreeMap<Path, Module> =
        files.map(|(file, text)| (module_of(file), Module::new(file, text))).collect();
    let uses = |(from, module): (&Path, &Module)| {
        let to = module.paths.iter().filter_map(|path| resolve(&modules, from, path, 0));
        to.map(|to| (from.clone(), to)).collect::<Vec<_>>()
    };
    modules.iter().flat_map(uses).collect()
}

/// `src/a/mod.rs` and `src/a.rs` are the module `a`, `src/lib.rs` is the crate.
fn module_of(file: &str) -> Path {
    let mut path = path(file);
    let names = if path[path.len() - 2] == "src" { ["lib", "main"] } else { ["mod"; 2] };
    path.pop_if(|last| names.contains(&last.as_str()));
    path
}

/// The module that defines what `path` names in `from`; none outside its package.
fn resolve(
    modules: &BTreeMap<Path, Module>,
    from: &Path,
    path: &[String],
    depth: usize,
) -> Option<Path> {
    let mut at = from.clone();
    for (i, name) in path.iter().enumerate() {
        let child = below(&at, name);
        match name.as_str() {
            "crate" => at.truncate(at.iter().position(|folder| folder == "src")? + 1),
            "self" => {}
            "super" => drop(at.pop()),
            _ if modules.contains_key(&child) => at = child,
            _ if i == 0 => return None,
            _ => {
                let origin = modules.get(&at)?.names.get(name).filter(|_| depth < 8);
                let whole = origin.map(|origin| [origin, &path[i + 1..]].concat());
                let followed = whole.and_then(|path| resolve(modules, &at, &path, depth + 1));
                return followed.or(Some(at));
            }
        }
    }
    Some(at)
}

impl Module {
    fn new(file: &str, text: &str) -> Self {
        let (mut module, tokens) = (Self::default(), tokens(text));
        let token = |at: usize| tokens.get(at).copied().unwrap_or(";");
        let mut at = 0;
        while at < tokens.len() {
            let before = token(at.wrapping_sub(1));
            let starts = [";", "{", "}", "]", ")", "pub"].contains(&before);
            let mut named = Vec::new();
            if token(at) == "use" && starts {
                at = tree(&tokens, at + 1, &[], &mut named);
                let re_exports = [")", "pub"].contains(&before);
                for (path, name) in named {
                    let blind = re_exports && name == "*";
                    assert!(!blind, "{file} re-exports what it does not name");
                    if !re_exports {
                        module.paths.push(path.clone());
                    }
                    module.names.insert(name, path);
                }
            } else if is_word(token(at)) && token(at + 1) == "::" {
                at = tree(&tokens, at, &[], &mut named);
                module.paths.extend(named.into_iter().map(|(path, _)| path));
            } else {
                at += 1;
            }
        }
        module
    }
}

fn is_word(token: &str) -> bool {
    token.starts_with(|c: char| c.is_alphanumeric() || c == '_')
}

/// Words, `::` and other signs one by one.
fn tokens(text: &str) -> Vec<&str> {
    let mut tokens = Vec::new();
    let mut rest = text.trim_start();
    while let Some(first) = rest.chars().next() {
        let len = match rest {
            _ if is_word(rest) => rest.find(|c: char| !c.is_alphanumeric() && c != '_'),
            _ => Some(if rest.starts_with("::") { 2 } else { first.len_utf8() }),
        };
        let (token, after) = rest.split_at(len.unwrap_or(rest.len()));
        tokens.push(token);
        rest = after.trim_start();
    }
    tokens
}

/// Reads a tree of paths, each with the name that it brings in. Returns where it ends.
fn tree(tokens: &[&str], mut at: usize, prefix: &[String], out: &mut Vec<(Path, String)>) -> usize {
    let token = |at: usize| tokens.get(at).copied().unwrap_or(";");
    let mut path = prefix.to_vec();
    loop {
        if token(at) == "{" {
            at += 1;
            while !["}", ";"].contains(&token(at)) {
                at = tree(tokens, at, &path, out);
                at += usize::from(token(at) == ",");
            }
            return at + 1;
        }
        path.push(token(at).to_owned());
        at += 1;
        if token(at) != "::" {
            break;
        }
        at += 1;
    }
    path.pop_if(|last| last == "self" && !prefix.is_empty());
    let mut name = path.last().cloned().unwrap_or_default();
    if token(at) == "as" {
        name = token(at + 1).to_owned();
        at += 2;
    }
    out.push((path, name));
    at
}

fn javascript<'a>(files: impl Iterator<Item = (&'a str, &'a str)> + Clone) -> Uses {
    let known: BTreeSet<Path> = files.clone().map(|(file, _)| path(file)).collect();
    let uses = |(file, text): (&str, &'a str)| {
        let from = path(file);
        let relative = |quoted: &&str| quoted.starts_with('.') && quoted.ends_with(".js");
        let to = text.split(['\'', '"']).filter(relative).map(|relative| {
            let mut to = from[..from.len() - 1].to_vec();
            for part in path(relative) {
                match part.as_str() {
                    "." => {}
                    ".." => drop(to.pop()),
                    _ => to.push(part),
                }
            }
            to
        });
        to.filter(|to| known.contains(to)).map(|to| (from.clone(), to)).collect::<Vec<_>>()
    };
    files.flat_map(uses).collect()
}

fn python<'a>(files: impl Iterator<Item = (&'a str, &'a str)> + Clone) -> Uses {
    let module = |file: &str| {
        let mut path = path(file);
        path.pop_if(|last| last == "__init__");
        path
    };
    let known: BTreeSet<Path> = files.clone().map(|(file, _)| module(file)).collect();
    let mut uses = Uses::new();
    for (file, text) in files {
        let mut folder = path(file);
        folder.pop();
        for line in text.lines().map(str::trim_start) {
            let from = line.strip_prefix("from ").and_then(|rest| rest.split_once(" import "));
            let first = |rest: &'a str| rest.split([' ', ',']).next().map(|name| (name, ""));
            let plain = || line.strip_prefix("import ").and_then(first);
            let Some((source, names)) = from.or_else(plain) else { continue };
            let inside = source.trim_start_matches('.');
            let base = match source.len() - inside.len() {
                // By the whole name of the package that the file lies in.
                0 => folder.iter().position(|name| source.split('.').next() == Some(name)),
                dots => (folder.len() + 1).checked_sub(dots),
            };
            let Some(base) = base else { continue };
            let parts = inside.split('.').filter(|part| !part.is_empty());
            let source = parts.fold(folder[..base].to_vec(), |path, part| below(&path, part));
            for name in names.split([',', '(']).map(str::trim) {
                let to = below(&source, name.split(' ').next().unwrap_or_default());
                let to = if known.contains(&to) { to } else { source.clone() };
                if known.contains(&to) {
                    uses.insert((module(file), to));
                }
            }
        }
    }
    uses
}

#[test]
fn files_and_folders_do_not_use_each_other_in_circles() {
    let of = |extension: &str| {
        let mut files = sources_of(&[extension]);
        files.retain(|file, _| !is_test(file));
        files
    };
    let (rs, js, py) = (of("rs"), of("js"), of("py"));
    let code: Vec<(&str, String)> = rs
        .iter()
        .filter(|(file, _)| file.contains("/src/"))
        .map(|(file, text)| (file.as_str(), code(text)))
        .collect();
    let rust = rust(code.iter().map(|(file, text)| (*file, text.as_str())));
    let [js, py] = [&js, &py].map(|files| files.iter().map(|(f, t)| (f.as_str(), t.as_str())));
    let (js, py) = (javascript(js), python(py));
    let all = [&rust, &js, &py];
    assert!(all.iter().all(|uses| uses.len() > 30), "uses are not found any more");
    let found: Vec<_> = all.map(circles).into_iter().flatten().collect();
    assert!(found.is_empty(), "{} circles: {found:#?}", found.len());
}

#[test]
fn circles_are_found_and_re_exports_are_none() {
    let found = |files: &[(&str, &str)]| circles(&rust(files.iter().copied()));
    let lib = ("x/src/lib.rs", "mod a; mod b; pub use a::A; use b::B; fn f() { b::g() }");
    let a = ("x/src/a.rs", "use crate::b::{self, C as D}; pub struct A;");
    assert!(found(&[lib, a, ("x/src/b.rs", "pub struct B; pub struct C;")]).is_empty());
    let round = found(&[lib, a, ("x/src/b.rs", "pub struct B(crate::A); pub struct C;")]);
    assert_eq!(round, [vec!["x/src/a uses x/src/b".into(), "x/src/b uses x/src/a".into()]].into());
}

#[test]
fn circles_of_folders_are_found_where_no_file_is_in_one() {
    let files = [
        ("x/src/lib.rs", "mod a; mod b;"),
        ("x/src/a/mod.rs", "pub(crate) mod one; pub(crate) use one::One; mod two;"),
        ("x/src/a/one.rs", "pub(crate) struct One;"),
        ("x/src/a/two.rs", "use crate::b::Three;"),
        ("x/src/b.rs", "pub(crate) struct Three(crate::a::One);"),
    ];
    let round = circles(&rust(files.into_iter()));
    let ties = vec!["x/src/a/two uses x/src/b".into(), "x/src/b uses x/src/a/one".into()];
    assert_eq!(round, [ties].into());
}

#[test]
fn circles_of_scripts_are_found() {
    let js = |b: &'static str| {
        let files = [("x/js/a.js", "import { b } from './b.js';"), ("x/js/b.js", b)];
        circles(&javascript(files.into_iter())).len()
    };
    assert_eq!([js("import '../a.js';"), js("import {\n  a,\n} from '../js/a.js';")], [0, 1]);
    let py = |b: &'static str| {
        let files = [
            ("x/lodc/__init__.py", "from .a import A"),
            ("x/lodc/a.py", "from .b import c as d"),
            ("x/lodc/b/__init__.py", b),
        ];
        circles(&python(files.into_iter())).len()
    };
    assert_eq!([py("import a"), py("from .. import json, a")], [0, 1]);
    assert_eq!([py("from lodc.a import A"), py("import lodc.a as a")], [1, 1]);
}
