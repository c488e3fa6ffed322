//! Files that must not compile. `refuse/*.toml` and `refuse/stencils/*.toml` are wrong in one place each, and
//! the text beside each says what `Tableau::parse` or `Stencil::parse` and the compiler answer.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::{env, fs};

use kutta::normals::Stencil;
use kutta::tableau::{Tableau, TableauError};

struct Refused {
    /// `order` for `order.toml`.
    name: String,
    stencil: bool,
    text: String,
    /// `line 7: ..` or, where no line is to blame, the message alone.
    message: String,
}

impl Refused {
    fn error(&self) -> Option<TableauError> {
        if self.stencil { Stencil::parse(&self.text).err() } else { Tableau::parse(&self.text).err() }
    }

    /// What makes a program of the file.
    fn program(&self) -> String {
        let name = &self.name;
        if self.stencil {
            format!(
                "pub const REFUSED: kutta::normals::Stencil = kutta::stencil!(\"{name}.toml\");\nfn main() {{}}\n"
            )
        } else {
            format!("kutta::tableau!(Refused, \"{name}.toml\");\nfn main() {{}}\n")
        }
    }
}

fn files() -> Vec<Refused> {
    [read_all("tests/refuse", false), read_all("tests/refuse/stencils", true)].into_iter().flatten().collect()
}

fn read_all(folder: &str, stencil: bool) -> Vec<Refused> {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join(folder);
    let read = |path: &Path| fs::read_to_string(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    let mut paths: Vec<PathBuf> = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    paths.retain(|path| path.extension().is_some_and(|e| e == "toml"));
    paths.sort();
    let refused = |path: &PathBuf| Refused {
        // The programs of both lie in one folder.
        name: (if stencil { "stencil-" } else { "" }).to_string()
            + path.file_stem().unwrap().to_str().unwrap(),
        stencil,
        text: read(path),
        message: read(&path.with_extension("txt")).trim_end().to_string(),
    };
    paths.iter().map(refused).collect()
}

#[test]
fn they_are_refused_at_run_time() {
    let files = files();
    assert!(files.iter().filter(|file| !file.stencil).count() >= 30);
    assert!(files.iter().filter(|file| file.stencil).count() >= 30);
    let mut wrong = vec![];
    for file in files {
        let said = file.error().map_or(String::from("(it is accepted)"), |error| error.to_string());
        let Refused { name, message, .. } = file;
        if said != message {
            wrong.push(format!("{name}.toml\n  expected: {message}\n      said: {said}"));
        }
    }
    assert!(wrong.is_empty(), "\n{}", wrong.join("\n"));
}

/// The method of a crate that uses the library: its file, its program, what it prints.
const WRAY: &str = r#"
name    = "Wray 3, two registers"
order   = 3
cite    = "Kennedy, Carpenter, Lewis 2000, Appl. Numer. Math. 35, 177"
tableau = '''
0    |
8/15 | 8/15
2/3  | 1/4  5/12
-----+--------------
     | 1/4  0    3/4
'''
"#;
const PROGRAM: &str = r#"
use kutta::Method;

kutta::tableau!(
    /// Three stages in two registers.
    Wray3,
    "wray3.toml"
);

fn main() {
    let f = |_t, y: &[f64; 1], dy: &mut [f64; 1]| dy[0] = -y[0];
    let decay = kutta::solve(f, [1.0], 0.0..1.0).with(Wray3).step(0.01).run().unwrap();
    assert!((decay.y[0] - (-1f64).exp()).abs() < 2e-8);
    println!("{} of order {}", Wray3.name(), Wray3.form().order);
    const LANCZOS: kutta::normals::Stencil = kutta::stencil!("lanczos5.toml");
    println!("{} of order {}", LANCZOS.title, LANCZOS.properties().order);
}
"#;
/// And its stencil.
const LANCZOS: &str = r#"
name    = "Lanczos 5"
order   = 2
cite    = "Lanczos 1956, Applied Analysis, section 5.8"
stencil = '''
-2 | -1/5
-1 | -1/10
 1 |  1/10
 2 |  1/5
'''
"#;

/// One crate with a program for each file, so that the library is compiled for it once.
#[test]
fn they_do_not_compile_and_a_good_one_does() {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join("refuse");
    let library = Path::new(env!("CARGO_MANIFEST_DIR"));
    let programs = folder.join("src/bin");
    if folder.exists() {
        fs::remove_dir_all(&folder).unwrap();
    }
    fs::create_dir_all(&programs).unwrap();
    let manifest = format!(
        "[package]\nname = \"refused\"\nedition = \"2024\"\n\n[dependencies]\nkutta = {{ path = {library:?} }}\n\n[workspace]\n"
    );
    fs::write(folder.join("Cargo.toml"), manifest).unwrap();
    fs::copy(library.join("Cargo.lock"), folder.join("Cargo.lock")).unwrap();
    fs::write(programs.join("wray3.toml"), WRAY).unwrap();
    fs::write(programs.join("lanczos5.toml"), LANCZOS).unwrap();
    fs::write(programs.join("accepted-wray3.rs"), PROGRAM).unwrap();
    let files = files();
    for file in &files {
        let name = &file.name;
        fs::write(programs.join(format!("{name}.toml")), &file.text).unwrap();
        fs::write(programs.join(format!("refused-{name}.rs")), file.program()).unwrap();
    }
    let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let built = Command::new(cargo)
        .args(["build", "--offline", "--keep-going", "--message-format=short", "--manifest-path"])
        .arg(folder.join("Cargo.toml"))
        .arg("--target-dir")
        .arg(target)
        .output()
        .expect("cargo can be run");
    let said = String::from_utf8_lossy(&built.stderr);
    assert!(!built.status.success());
    let mut wrong = vec![];
    for Refused { name, message, .. } in &files {
        // The compiler names the file, then the line.
        let message = match message.strip_prefix("line ").and_then(|rest| rest.split_once(": ")) {
            Some((line, rest)) => format!("{name}.toml:{line}: {rest}"),
            None => format!("{name}.toml: {message}"),
        };
        let (program, ends, goes_on) =
            (format!("refused-{name}.rs:"), format!(" {message}"), format!(" {message}: "));
        let is_it = |line: &str| {
            line.contains(&program)
                && line.contains("error")
                && (line.ends_with(&ends) || line.contains(&goes_on))
        };
        if !said.lines().any(is_it) {
            wrong.push(message);
        }
    }
    assert!(
        wrong.is_empty(),
        "these are missing:\n{}\n\nin what the compiler said:\n{said}",
        wrong.join("\n")
    );
    let program = target.join("debug").join(format!("accepted-wray3{}", env::consts::EXE_SUFFIX));
    let run =
        Command::new(&program).output().unwrap_or_else(|e| panic!("{}: {e}\n{said}", program.display()));
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    assert_eq!(String::from_utf8_lossy(&run.stdout), "wray3 of order 3\nLanczos 5 of order 2\n");
}
