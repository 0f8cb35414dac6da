//! A headless browser that opens pages from the file system.

use std::collections::BTreeMap;
use std::io::{BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::mpsc;

/// Chromium without a window.
pub(crate) struct Browser(PathBuf);

impl Browser {
    /// The browser that is installed. None if it is not asked for.
    pub(crate) fn find() -> Option<Self> {
        if !super::asked("Chromium") {
            return None;
        }
        let path = std::env::var_os("PATH").unwrap_or_default();
        let folders: Vec<PathBuf> = std::env::split_paths(&path).collect();
        let names = ["chromium", "chromium-browser", "google-chrome"];
        let mut places = names.iter().flat_map(|n| folders.iter().map(move |f| f.join(n)));
        Some(Self(places.find(|path| path.is_file()).expect("Chromium is there")))
    }

    /// The attributes of a page's root element once it has come to rest. `hash` is the part of the
    /// address behind `#`.
    pub(crate) fn attributes(&self, page: &Path, hash: &str) -> BTreeMap<String, String> {
        let text = self.dump(&format!("file://{}#{hash}", page.display()));
        let root = text.split_once("<html").and_then(|(_, rest)| rest.split_once('>'));
        let root = root.unwrap_or_else(|| panic!("no page: {text:.300}")).0;
        let attribute = |part: &str| {
            let (name, value) = part.split_once("=\"")?;
            Some((name.trim().to_owned(), value.to_owned()))
        };
        root.split_inclusive("\" ")
            .filter_map(|p| attribute(p.trim().trim_end_matches('"')))
            .collect()
    }

    /// Returns what a page writes to its console behind `done: `, in real time.
    pub(crate) fn result(&self, page: &Path) -> String {
        self.result_at(&format!("file://{}", page.display()))
    }

    /// The same of a page at an address.
    pub(crate) fn result_at(&self, address: &str) -> String {
        let mut child = Command::new(&self.0)
            .args(["--headless=new", "--no-sandbox", "--enable-unsafe-webgpu"])
            .args(["--enable-logging=stderr", address])
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the browser starts");
        let lines = BufReader::new(child.stderr.take().expect("it was asked for")).lines();
        let (told, wait) = mpsc::channel();
        std::thread::spawn(move || {
            let found = lines.map_while(Result::ok).find_map(|line| {
                let (_, rest) = line.split_once("\"done: ")?;
                Some(rest.rsplit_once("\", source:").map_or(rest, |(text, _)| text).to_owned())
            });
            let _ = told.send(found);
        });
        let found = wait.recv_timeout(super::LONGEST).ok().flatten();
        let _ = child.kill();
        let _ = child.wait();
        found.expect("the page comes to its end")
    }

    /// The text of a page after its scripts.
    pub(crate) fn dump(&self, address: &str) -> String {
        let output = super::bounded(&self.0)
            .args(["--headless=new", "--no-sandbox", "--enable-unsafe-webgpu"])
            .args(["--virtual-time-budget=20000", "--dump-dom", address])
            .stdin(Stdio::null())
            .stderr(Stdio::null())
            .output()
            .expect("the browser starts");
        String::from_utf8_lossy(&output.stdout).into_owned()
    }
}

/// Serves the files of some folders, the first that has one, on a port of this machine; returns the
/// address. Modules of a page come from nowhere else.
pub(crate) fn served(folders: Vec<PathBuf>) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port of this machine");
    let address = format!("http://{}", listener.local_addr().expect("it is bound"));
    std::thread::spawn(move || {
        for stream in listener.incoming().map_while(Result::ok) {
            // Browsers open connections ahead, on which nothing may ever come.
            let folders = folders.clone();
            std::thread::spawn(move || answer(stream, &folders));
        }
    });
    address
}

/// Answers the one request of a connection.
fn answer(mut stream: TcpStream, folders: &[PathBuf]) {
    let mut line = String::new();
    if BufReader::new(&stream).read_line(&mut line).is_err() {
        return;
    }
    let name = line.split(' ').nth(1).unwrap_or_default();
    let name = name.split('?').next().unwrap_or_default().trim_start_matches('/');
    let found = folders.iter().find_map(|folder| std::fs::read(folder.join(name)).ok());
    let (status, bytes) = match found {
        Some(bytes) => ("200 OK", bytes),
        None => ("404 Not Found", Vec::new()),
    };
    let kind = match Path::new(name).extension().and_then(|e| e.to_str()) {
        Some("html") => "text/html",
        Some("js" | "mjs") => "text/javascript",
        _ => "application/octet-stream",
    };
    let length = bytes.len();
    let head = format!(
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {length}\r\n\
         Connection: close\r\n\r\n"
    );
    // A browser that went away is no fault of the test.
    let _ = stream.write_all(head.as_bytes()).and_then(|()| stream.write_all(&bytes));
}
