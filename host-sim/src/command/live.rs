//! `palpate live`: builds the window or the page, which are a package of their own, and starts it.

use std::io::{BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::Command;

use clap::Args;

use crate::error::Error;
use crate::scene::Scene;

#[derive(Args, Clone, Debug)]
pub(super) struct LiveArgs {
    /// A preset or the path of a scene file (.toml).
    #[arg(long, value_name = "NAME|FILE", default_value = "block", conflicts_with = "page")]
    scene: String,
    /// Build the page in place of the window, and serve it on this machine.
    #[arg(long)]
    page: bool,
    /// Build the page and do not serve it.
    #[arg(long, requires = "page")]
    no_serve: bool,
    /// Where the page goes.
    #[arg(long, value_name = "FOLDER", default_value = "out/live-page", requires = "page")]
    out: PathBuf,
}

impl LiveArgs {
    pub(super) fn run(&self) -> Result<(), Error> {
        // the package is in the repository, not in the binary
        let package = Path::new(env!("CARGO_MANIFEST_DIR")).join("live");
        if !package.join("Cargo.toml").is_file() {
            let place = package.display();
            return Err(Error::Usage(format!(
                "{place} is not there: `live` builds its window and page in the repository, start it from a build of it"
            )));
        }
        if self.page {
            return self.build_page(&package);
        }
        Scene::load(&self.scene)?;
        let scene = std::fs::canonicalize(&self.scene).unwrap_or_else(|_| self.scene.clone().into());
        eprintln!("building the window; the first time takes some minutes");
        let started = Instant::start(&package);
        cargo(&package, &["build", "--release"])?;
        started.say();
        let window = target(&package).join("release/palpate-live");
        run(Command::new(&window).arg("--scene").arg(scene), &window.display().to_string())
    }

    fn build_page(&self, package: &Path) -> Result<(), Error> {
        eprintln!("building the page; the first time takes some minutes");
        let started = Instant::start(package);
        cargo(package, &["build", "--lib", "--profile", "page", "--target", "wasm32-unknown-unknown"])?;
        let tool = package.join("tools/page");
        cargo(&tool, &["build", "--release"])?;
        started.say();
        let write = |path: &Path, source| Error::Write { path: path.into(), source };
        std::fs::create_dir_all(&self.out).map_err(|e| write(&self.out, e))?;
        let module = target(package).join("wasm32-unknown-unknown/page/palpate_live.wasm");
        let bind = target(&tool).join("release/palpate-live-page");
        run(Command::new(&bind).arg(&module).arg(&self.out), "binding the page")?;
        let mut bytes = 0;
        for name in ["index.html", "page.js", "worker.js"] {
            let to = self.out.join(name);
            std::fs::copy(package.join("web").join(name), &to).map_err(|e| write(&to, e))?;
        }
        for file in std::fs::read_dir(&self.out).map_err(|e| write(&self.out, e))?.flatten() {
            bytes += file.metadata().map_or(0, |m| m.len());
        }
        println!(
            "wrote {}: {:.2} MB, static files: any web server shows them, without a network",
            self.out.display(),
            bytes as f64 * 1e-6
        );
        if self.no_serve { Ok(()) } else { serve(&self.out) }
    }
}

/// Where cargo puts what it builds for a package.
fn target(package: &Path) -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| package.join("target"), PathBuf::from)
}

/// How long a build took.
struct Instant(std::time::Instant);

impl Instant {
    fn start(_package: &Path) -> Self {
        Self(std::time::Instant::now())
    }

    fn say(&self) {
        eprintln!("built in {:.0} s", self.0.elapsed().as_secs_f64());
    }
}

/// In the package's folder, where its settings are; cargo shows its own progress.
fn cargo(package: &Path, arguments: &[&str]) -> Result<(), Error> {
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    run(
        Command::new(cargo).current_dir(package).args(arguments),
        &format!("cargo {} in {}", arguments.join(" "), package.display()),
    )
}

fn run(command: &mut Command, what: &str) -> Result<(), Error> {
    match command.status() {
        Ok(status) if status.success() => Ok(()),
        Ok(status) => Err(Error::Usage(format!("{what}: {status}: what it said above tells why"))),
        Err(why) => Err(Error::Usage(format!("{what}: {why}: install the toolchain from https://rustup.rs"))),
    }
}

/// Shows the folder to this machine's browsers until it is stopped.
fn serve(folder: &Path) -> Result<(), Error> {
    let listener = TcpListener::bind("127.0.0.1:8710").or_else(|_| TcpListener::bind("127.0.0.1:0"));
    let unserved = |why: std::io::Error| Error::Usage(format!("cannot serve {}: {why}: take --no-serve", folder.display()));
    let listener = listener.map_err(unserved)?;
    println!("open http://{}/ in a browser; Ctrl-C ends", listener.local_addr().map_err(unserved)?);
    for stream in listener.incoming().flatten() {
        // a browser that hangs up has what it wants
        let _gone = reply(stream, folder);
    }
    Ok(())
}

/// The files of a page, and no others.
fn reply(mut stream: TcpStream, folder: &Path) -> std::io::Result<()> {
    stream.set_read_timeout(Some(std::time::Duration::from_secs(5)))?;
    let mut line = String::new();
    BufReader::new(stream.try_clone()?).read_line(&mut line)?;
    let asked = line.split_whitespace().nth(1).unwrap_or("/").trim_start_matches('/');
    let (name, kind) = match asked.split('?').next().unwrap_or_default() {
        "" | "index.html" => ("index.html", "text/html"),
        "page.js" => ("page.js", "text/javascript"),
        "worker.js" => ("worker.js", "text/javascript"),
        "palpate_live.js" => ("palpate_live.js", "text/javascript"),
        "palpate_live.wasm.gz" => ("palpate_live.wasm.gz", "application/gzip"),
        _ => return stream.write_all(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\nConnection: close\r\n\r\n"),
    };
    let body = std::fs::read(folder.join(name))?;
    let head = format!("HTTP/1.1 200 OK\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n", body.len());
    stream.write_all(head.as_bytes())?;
    stream.write_all(&body)
}
