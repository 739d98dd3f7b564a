//! Serves the page's folder to browsers on this machine.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::time::Duration;

use crate::error::Error;
use palpate_tissue::Error as TissueError;

/// Files of the page and their media types.
const FILES: [(&str, &str); 5] = [
    ("index.html", "text/html"),
    ("page.js", "text/javascript"),
    ("worker.js", "text/javascript"),
    ("palpate_live.js", "text/javascript"),
    ("palpate_live.wasm.gz", "application/gzip"),
];

/// Number of clients that are served at once.
const CLIENTS: usize = 16;

/// Time after which a silent client is dropped.
const SILENCE: Duration = Duration::from_secs(5);

/// Longest head of a request that is read [bytes].
const HEAD_BYTES: u64 = 1 << 16;

/// Size of the page [bytes], without other files in its folder.
pub(super) fn bytes(folder: &Path) -> u64 {
    FILES.iter().filter_map(|(name, _)| std::fs::metadata(folder.join(name)).ok()).map(|m| m.len()).sum()
}

/// Serves the folder until the process is stopped.
pub(super) fn serve(folder: &Path) -> Result<(), Error> {
    let listener = TcpListener::bind("127.0.0.1:8710").or_else(|_| TcpListener::bind("127.0.0.1:0"));
    let unserved = |why: std::io::Error| TissueError::Usage(format!("cannot serve {}: {why}: take --no-serve", folder.display()));
    let listener = listener.map_err(unserved)?;
    println!("open http://{}/ in a browser; Ctrl-C ends", listener.local_addr().map_err(unserved)?);
    answer(&listener, folder, SILENCE);
    Ok(())
}

/// Answers requests on several threads. A browser also connects in advance and sends nothing for
/// seconds: such a client must not block the others.
fn answer(listener: &TcpListener, folder: &Path, silence: Duration) {
    std::thread::scope(|scope| {
        for _ in 0..CLIENTS {
            scope.spawn(|| {
                for stream in listener.incoming().flatten() {
                    // a browser that has disconnected needs no answer
                    let _gone = reply(stream, folder, silence);
                }
            });
        }
    });
}

/// Answers one request; only the files of the page are served.
fn reply(mut stream: TcpStream, folder: &Path, silence: Duration) -> std::io::Result<()> {
    stream.set_read_timeout(Some(silence))?;
    // the head is read completely: data left unread when the connection closes can cost the client
    // its answer
    let lines = BufReader::new(stream.try_clone()?).take(HEAD_BYTES).split(b'\n').map_while(Result::ok);
    let head: Vec<_> = lines.take_while(|l| l.len() > 1).collect();
    let Some(first) = head.first().map(|l| String::from_utf8_lossy(l)) else { return Ok(()) };
    let asked = first.split_whitespace().nth(1).unwrap_or("/").trim_start_matches('/');
    let asked = asked.split('?').next().filter(|name| !name.is_empty()).unwrap_or("index.html");
    let Some((name, kind)) = FILES.iter().find(|(name, _)| *name == asked) else {
        return stream.write_all(b"HTTP/1.1 404 Not Found\r\nContent-Length: 0\r\nConnection: close\r\n\r\n");
    };
    let body = std::fs::read(folder.join(name))?;
    let head = format!("HTTP/1.1 200 OK\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n", body.len());
    stream.write_all(head.as_bytes())?;
    stream.write_all(&body)
}

#[cfg(test)]
mod tests {
    use std::net::SocketAddr;
    use std::path::PathBuf;

    use super::*;

    /// Time for which a silent client is kept, longer than any test lasts: a client that blocks the
    /// others then ends the test at [`get`]'s own limit.
    const KEPT: Duration = Duration::from_secs(3600);

    /// Serves a folder for as long as the tests run.
    fn served(folder: PathBuf) -> SocketAddr {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        std::thread::spawn(move || answer(&listener, &folder, KEPT));
        address
    }

    fn get(address: SocketAddr, path: &str) -> String {
        let mut stream = TcpStream::connect(address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        stream.write_all(format!("GET {path} HTTP/1.1\r\nHost: here\r\n\r\n").as_bytes()).unwrap();
        let mut response = String::new();
        stream.read_to_string(&mut response).unwrap();
        response
    }

    #[test]
    fn a_client_that_asks_nothing_does_not_hold_up_the_others() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("page.js"), "drawn").unwrap();
        let address = served(folder.path().into());
        let _silent = [TcpStream::connect(address).unwrap(), TcpStream::connect(address).unwrap()];
        let response = get(address, "/page.js?again");
        assert!(response.starts_with("HTTP/1.1 200") && response.ends_with("\r\n\r\ndrawn"), "{response}");
    }

    #[test]
    fn only_the_page_is_served_and_counted() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("index.html"), "page").unwrap();
        std::fs::write(folder.path().join("diary.txt"), [b'x'; 1000]).unwrap();
        let address = served(folder.path().into());
        assert!(get(address, "/").ends_with("\r\n\r\npage"));
        assert!(
            get(address, "/diary.txt").starts_with("HTTP/1.1 404") && get(address, "/../diary.txt").starts_with("HTTP/1.1 404")
        );
        assert_eq!(bytes(folder.path()), 4);
    }
}
