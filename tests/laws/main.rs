//! Every file of `tableaus/` is read, evaluated and proven a second time, by code that shares nothing with
//! kutta's: the `toml` crate, exact rationals, trees from level sequences. Files of rationals must fulfil
//! every condition without any residual, surds to 60 digits, decimals to the digits that the file claims.

mod bits;
mod exact;
mod file;
mod inexact;
mod report;
mod second_order;
mod spoiled;
mod stages;
mod stencils;
mod steps;
mod trees;

use std::path::Path;

use exact::{Fixed, Rational};
use file::File;
use report::Report;

/// Paths of all files under a folder of the package, relative to it.
fn files_under(folder: &str) -> Vec<String> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let mut folders = vec![root.join(folder)];
    let mut paths = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|e| e == "toml") {
                let parts = path.strip_prefix(root).unwrap().iter().map(|part| part.to_str().unwrap());
                paths.push(parts.collect::<Vec<_>>().join("/"));
            }
        }
    }
    paths.sort();
    paths
}

/// All method files; stencils have laws of their own.
fn paths() -> Vec<String> {
    let mut paths = files_under("tableaus");
    paths.retain(|path| !path.starts_with("tableaus/stencils/"));
    paths
}

fn text(path: &str) -> String {
    std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(path)).unwrap()
}

fn prove(file: &File, report: &mut Report) {
    if file.exact() {
        stages::check::<Rational>(file, report);
        second_order::check::<Rational>(file, report);
    } else {
        stages::check::<Fixed>(file, report);
        second_order::check::<Fixed>(file, report);
    }
    steps::check(file, report);
    report.expect_all_digits();
}

/// Fails with everything that is broken in any file.
fn for_every_file(check: fn(&File, &mut Report)) {
    let mut broken = Vec::new();
    for path in paths() {
        let file = File::parse(&path, &text(&path));
        let mut report = Report::new(&file);
        check(&file, &mut report);
        broken.append(&mut report.broken);
    }
    assert!(broken.is_empty(), "\n{}\n", broken.join("\n"));
}

#[test]
fn every_order_holds_exactly_and_is_not_claimed_too_low() {
    for_every_file(prove);
}

#[test]
fn what_any_matrix_leaves_of_the_orders_is_derived() {
    for_every_file(inexact::check);
}

#[test]
fn kutta_reads_the_nearest_f64_and_f32_of_every_entry() {
    for_every_file(bits::check);
}

/// A file is a method: all that lie on disk are in the library under their names, and no others.
#[test]
fn every_file_is_a_method_and_every_method_a_file() {
    let on_disk = paths();
    assert!(!on_disk.is_empty());
    let mut known: Vec<_> = kutta::methods::all().iter().map(|method| method.path).collect();
    known.sort();
    assert_eq!(known, on_disk);
    for method in kutta::methods::all() {
        let path = Path::new(method.path);
        assert_eq!(path.file_stem().unwrap(), method.name);
        assert_eq!(text(method.path), method.text, "{}", method.path);
    }
}
