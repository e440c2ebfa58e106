//! The layout of the source: within each crate no circle of imports ties files together, and none ties folders.
//!
//! An import is any path that begins with `crate`, `self`, `super` or the name of a child module, in a `use` or in code. Paths through a `pub use` count
//! for the file that defines the name. Modules under `#[cfg(test)]` are left out.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use syn::visit::{self, Visit};
use syn::{Attribute, Item, ItemMod, ItemUse, UseTree};

/// The path of a module within its crate: empty for the root.
type ModulePath = Vec<String>;

/// A file of a crate.
struct Module {
    file: PathBuf,
    children: BTreeSet<String>,
    /// The names that it re-exports or imports, with the paths that they stand for.
    aliases: BTreeMap<String, Vec<String>>,
    globs: Vec<Vec<String>>,
    /// The paths that the file names, as they are written.
    paths: BTreeSet<Vec<String>>,
}

/// A crate's files by module path.
#[derive(Default)]
struct Modules(BTreeMap<ModulePath, Module>);

fn is_test_only(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("cfg")
            && attribute.parse_args::<syn::Ident>().is_ok_and(|condition| condition == "test")
    })
}

impl Modules {
    /// Reads the crate whose root is `file`.
    fn read(file: &Path) -> Self {
        let mut modules = Self::default();
        let folder = file.parent().expect("a source file is in a folder");
        modules.add(file, folder, &[]);
        modules
    }

    fn add(&mut self, file: &Path, child_folder: &Path, path: &[String]) {
        let text = fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        let syntax = syn::parse_file(&text).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        let mut reader = Reader { module: Module::new(file), child_files: Vec::new() };
        reader.visit_file(&syntax);
        let Reader { module, child_files } = reader;
        self.0.insert(path.to_vec(), module);
        for name in child_files {
            let own = child_folder.join(&name);
            let file = [own.with_extension("rs"), own.join("mod.rs")].into_iter().find(|file| file.is_file());
            let file = file.unwrap_or_else(|| panic!("the module '{name}' of {path:?} has no file"));
            let mut child = path.to_vec();
            child.push(name);
            self.add(&file, &own, &child);
        }
    }

    /// The module that a path leads to, seen from `from`; `None` where it leaves the crate.
    fn resolve(&self, from: &[String], written: &[String], depth: usize) -> Option<ModulePath> {
        let module = &self.0[from];
        let (first, mut rest) = written.split_first()?;
        let mut at: ModulePath = match first.as_str() {
            "crate" => Vec::new(),
            "self" => from.to_vec(),
            "super" => from[..from.len().checked_sub(1)?].to_vec(),
            name if module.children.contains(name) => [from, &[name.to_owned()]].concat(),
            _ => return None,
        };
        while let Some((name, after)) = rest.split_first() {
            let module = &self.0[&at];
            if name == "super" {
                at.pop()?;
            } else if module.children.contains(name) {
                at.push(name.clone());
            } else {
                return Some(self.through_aliases(&at, name, depth).unwrap_or(at));
            }
            rest = after;
        }
        Some(at)
    }

    /// Where a name that `at` re-exports is defined.
    fn through_aliases(&self, at: &[String], name: &str, depth: usize) -> Option<ModulePath> {
        // Deeper re-exports than any that a reader could follow.
        if depth > 8 {
            return None;
        }
        let module = &self.0[at];
        if let Some(path) = module.aliases.get(name) {
            return self.resolve(at, path, depth + 1);
        }
        let defines = |glob: &Vec<String>| {
            let target = self.resolve(at, glob, depth + 1)?;
            self.0[&target].defines(name).then_some(target)
        };
        module.globs.iter().find_map(defines)
    }

    /// From each file those that it imports.
    fn imports(&self) -> BTreeMap<ModulePath, BTreeSet<ModulePath>> {
        let of = |path: &ModulePath, module: &Module| -> BTreeSet<ModulePath> {
            let targets = module.paths.iter().filter_map(|written| self.resolve(path, written, 0));
            targets.filter(|target| target != path).collect()
        };
        self.0.iter().map(|(path, module)| (path.clone(), of(path, module))).collect()
    }
}

impl Module {
    fn new(file: &Path) -> Self {
        Self {
            file: file.to_owned(),
            children: BTreeSet::new(),
            aliases: BTreeMap::new(),
            globs: Vec::new(),
            paths: BTreeSet::new(),
        }
    }

    /// Whether the file itself has an item of this name.
    fn defines(&self, name: &str) -> bool {
        let text = fs::read_to_string(&self.file).unwrap_or_default();
        ["struct", "enum", "fn", "trait", "type", "const", "static", "union"].iter().any(|kind| {
            text.match_indices(&format!("{kind} {name}")).any(|(start, found)| {
                !text[start + found.len()..].starts_with(|c: char| c.is_alphanumeric() || c == '_')
            })
        })
    }

    fn use_tree(&mut self, tree: &UseTree, prefix: &[String]) {
        match tree {
            UseTree::Path(path) => {
                self.use_tree(&path.tree, &[prefix, &[path.ident.to_string()]].concat());
            }
            UseTree::Name(name) => self.import(prefix, &name.ident.to_string(), &name.ident.to_string()),
            UseTree::Rename(rename) => {
                self.import(prefix, &rename.ident.to_string(), &rename.rename.to_string());
            }
            UseTree::Glob(_) => {
                self.paths.insert(prefix.to_vec());
                self.globs.push(prefix.to_vec());
            }
            UseTree::Group(group) => group.items.iter().for_each(|tree| self.use_tree(tree, prefix)),
        }
    }

    fn import(&mut self, prefix: &[String], name: &str, alias: &str) {
        let path = if name == "self" { prefix.to_vec() } else { [prefix, &[name.to_owned()]].concat() };
        self.aliases.insert(alias.to_owned(), path.clone());
        self.paths.insert(path);
    }
}

struct Reader {
    module: Module,
    child_files: Vec<String>,
}

impl<'ast> Visit<'ast> for Reader {
    fn visit_item(&mut self, item: &'ast Item) {
        let attributes = match item {
            Item::Fn(item) => &item.attrs,
            Item::Mod(item) => &item.attrs,
            Item::Use(item) => &item.attrs,
            Item::Impl(item) => &item.attrs,
            _ => &Vec::new(),
        };
        if !is_test_only(attributes) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_mod(&mut self, item: &'ast ItemMod) {
        if item.content.is_none() {
            let name = item.ident.to_string();
            self.module.children.insert(name.clone());
            self.child_files.push(name);
        }
        visit::visit_item_mod(self, item);
    }

    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        self.module.use_tree(&item.tree, &[]);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let words: Vec<String> = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        if words.len() > 1 {
            self.module.paths.insert(words);
        }
        visit::visit_path(self, path);
    }
}

/// The sets of nodes that reach each other, of two nodes or more.
fn circles(graph: &BTreeMap<ModulePath, BTreeSet<ModulePath>>) -> Vec<BTreeSet<ModulePath>> {
    let reach = |start: &ModulePath| {
        let (mut seen, mut pending) = (BTreeSet::new(), vec![start]);
        while let Some(node) = pending.pop() {
            for next in graph.get(node).into_iter().flatten() {
                if seen.insert(next.clone()) {
                    pending.push(next);
                }
            }
        }
        seen
    };
    let reached: BTreeMap<&ModulePath, BTreeSet<ModulePath>> =
        graph.keys().map(|node| (node, reach(node))).collect();
    let circle_of = |node: &ModulePath| -> BTreeSet<ModulePath> {
        reached[node]
            .iter()
            .filter(|other| reached.get(other).is_some_and(|back| back.contains(node)))
            .cloned()
            .collect()
    };
    let all: BTreeSet<BTreeSet<ModulePath>> =
        graph.keys().map(circle_of).filter(|circle| circle.len() > 1).collect();
    all.into_iter().collect()
}

/// The imports between the folders and files directly below the crate's root.
fn between_folders(
    imports: &BTreeMap<ModulePath, BTreeSet<ModulePath>>,
) -> BTreeMap<ModulePath, BTreeSet<ModulePath>> {
    let folder = |path: &ModulePath| path[..path.len().min(1)].to_vec();
    let mut folders: BTreeMap<ModulePath, BTreeSet<ModulePath>> = BTreeMap::new();
    for (from, targets) in imports {
        let targets = targets.iter().map(folder).filter(|target| *target != folder(from));
        folders.entry(folder(from)).or_default().extend(targets);
    }
    folders
}

fn report(krate: &str, what: &str, graph: &BTreeMap<ModulePath, BTreeSet<ModulePath>>) -> Vec<String> {
    let name = |path: &ModulePath| if path.is_empty() { "the root".to_owned() } else { path.join("::") };
    let describe = |circle: BTreeSet<ModulePath>| {
        let arrows = circle.iter().flat_map(|from| {
            graph[from]
                .iter()
                .filter(|to| circle.contains(*to))
                .map(move |to| format!("{} -> {}", name(from), name(to)))
        });
        format!("{krate}: {what} in a circle: {}", arrows.collect::<Vec<_>>().join(", "))
    };
    circles(graph).into_iter().map(describe).collect()
}

fn crate_roots() -> Vec<(String, PathBuf)> {
    let crates = PathBuf::from(std::env::var_os("CARGO_MANIFEST_DIR").expect("set by cargo")).join("..");
    let mut roots = Vec::new();
    for entry in fs::read_dir(crates).expect("the crates' folder") {
        let folder = entry.expect("an entry of the crates' folder").path();
        let name = folder.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let files = ["src/lib.rs", "src/main.rs"].map(|file| folder.join(file));
        roots.extend(files.into_iter().filter(|file| file.is_file()).map(|file| (name.clone(), file)));
    }
    roots.sort();
    roots
}

#[test]
fn imports_form_no_circle() {
    let roots = crate_roots();
    assert!(roots.len() >= 9, "{roots:?}");
    let mut faults = Vec::new();
    for (krate, root) in roots {
        let imports = Modules::read(&root).imports();
        assert!(!imports.is_empty());
        faults.extend(report(&krate, "files", &imports));
        faults.extend(report(&krate, "folders", &between_folders(&imports)));
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn a_circle_is_found() {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("circle");
    fs::create_dir_all(folder.join("b")).unwrap();
    let files = [
        ("lib.rs", "mod a; mod b; mod c; pub use b::d::Deep;"),
        ("a.rs", "use crate::Deep; fn f() {}"),
        ("b.rs", "pub mod d; use crate::c; #[cfg(test)] mod tests { use crate::a; }"),
        ("b/d.rs", "pub struct Deep; fn f() { crate::c::g(); }"),
        ("c.rs", "pub fn g() { super::a::f() }"),
    ];
    for (name, text) in files {
        fs::write(folder.join(name), text).unwrap();
    }
    let imports = Modules::read(&folder.join("lib.rs")).imports();
    let path = |text: &str| text.split("::").map(str::to_owned).collect::<ModulePath>();
    let expected: BTreeSet<ModulePath> = ["a", "b::d", "c"].map(path).into();
    assert_eq!(circles(&imports), [expected]);
    // The folders are b, a and c; d is in b.
    let expected: BTreeSet<ModulePath> = ["a", "b", "c"].map(path).into();
    assert_eq!(circles(&between_folders(&imports)), [expected]);
}
