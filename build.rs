//! Lists the method and stencil files, so that adding one takes no Rust: a `tableau!` line for a method, a
//! constant for a stencil.

use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::{env, fs};

fn main() {
    println!("cargo::rerun-if-changed=tableaus");
    let root = PathBuf::from(env::var_os("CARGO_MANIFEST_DIR").expect("cargo sets it"));
    let mut files = vec![];
    collect(&root.join("tableaus"), &mut files);
    files.sort();
    let (mut types, mut entries, mut forms) = (String::new(), String::new(), String::new());
    let (mut stencils, mut stencil_entries) = (String::new(), String::new());
    let mut seen = vec![];
    for file in &files {
        let shown = file.strip_prefix(&root).expect("listed under it").to_str().expect("UTF-8 path");
        let shown = shown.replace('\\', "/");
        let name = file.file_stem().and_then(|s| s.to_str()).expect("UTF-8 name");
        assert!(!seen.contains(&name), "{shown}: there is another file `{name}`: name it otherwise");
        seen.push(name);
        let text = fs::read_to_string(file).expect("a readable method file");
        let title =
            text.lines().find_map(|l| l.strip_prefix("name")?.trim().strip_prefix('=')).unwrap_or(name);
        // Brackets would be links.
        let title = title.trim().trim_matches('"').replace('[', "\\[").replace(']', "\\]");
        let path = format!("concat!(env!(\"CARGO_MANIFEST_DIR\"), \"/{shown}\")");
        let entry = format!("Entry {{ name: {name:?}, path: {shown:?}, text: include_str!({path})");
        if shown.starts_with("tableaus/stencils/") {
            let capitals = name.to_uppercase().replace('-', "_");
            writeln!(
                stencils,
                "#[doc = {title:?}]\n///\n/// ```toml\n#[doc = include_str!({path})]\n/// ```\n\
                 pub const {capitals}: Stencil<'static> = super::compile({shown:?}, include_str!({path}));"
            )
            .unwrap();
            writeln!(stencil_entries, "{entry}, stencil: &{capitals} }},").unwrap();
            continue;
        }
        let camel = camel_case(name);
        writeln!(types, "crate::tableau!(@ #[doc = {title:?}] {camel}, {path}, {shown:?});").unwrap();
        writeln!(entries, "{entry} }},").unwrap();
        writeln!(forms, "({name:?}, <{camel} as crate::Method>::FORM),").unwrap();
    }
    let methods = format!(
        "{types}\nstatic ENTRIES: &[Entry] = &[\n{entries}];\n\
         const FORMS: &[(&str, Option<&crate::tableau::Form>)] = &[\n{forms}];\n"
    );
    let stencils = format!("{stencils}\nstatic ENTRIES: &[Entry] = &[\n{stencil_entries}];\n");
    let out = PathBuf::from(env::var_os("OUT_DIR").expect("cargo sets it"));
    fs::write(out.join("methods.rs"), methods).expect("cargo's own folder can be written");
    fs::write(out.join("stencils.rs"), stencils).expect("cargo's own folder can be written");
}

fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).expect("a folder of method files").flatten() {
        let path = entry.path();
        if path.is_dir() {
            collect(&path, files);
        } else if path.extension().is_some_and(|e| e == "toml") {
            files.push(path);
        }
    }
}

fn camel_case(name: &str) -> String {
    let parts = name.split(['-', '_']);
    parts.flat_map(|p| p[..1].to_uppercase().chars().chain(p[1..].chars()).collect::<Vec<_>>()).collect()
}
