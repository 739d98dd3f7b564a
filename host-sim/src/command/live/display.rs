//! Checks for the display that a window needs, before minutes are spent on building one.

use palpate_tissue::Error as TissueError;

/// Variable that names the display that a window asks first.
const WAYLAND: &str = "WAYLAND_DISPLAY";
/// Remedy that every refusal names.
const FIX: &str = "start it on a desktop";
/// Additional remedy, if a page can show the same.
const OR_PAGE: &str = ", or take the page, `palpate live --page`";

/// Checks that a display answers. Returns the variable of a display that does not answer while
/// another one does: the window must not try it, since it would not try the other. `page` says
/// whether a page could show the same.
pub(super) fn look(page: bool) -> Result<Option<&'static str>, TissueError> {
    // macOS and Windows have one display, and no variable that names it
    if !cfg!(all(unix, not(target_os = "macos"))) {
        return Ok(None);
    }
    let named = |name: &str| std::env::var(name).ok().filter(|value| !value.is_empty());
    answering(&named, &answers).map_err(|why| {
        let or_page = if page { OR_PAGE } else { "" };
        TissueError::Usage(format!("no window: {why}: {FIX}{or_page}"))
    })
}

/// Returns the same as [`look`], for displays that `named` names; the error says why none of them
/// answers.
fn answering(named: &dyn Fn(&str) -> Option<String>, answers: &dyn Fn(&Socket) -> bool) -> Result<Option<&'static str>, String> {
    // a socket that is already open needs no check
    if named("WAYLAND_SOCKET").is_some() {
        return Ok(None);
    }
    let mut silent = Vec::new();
    for variable in [WAYLAND, "DISPLAY"] {
        let Some(name) = named(variable) else { continue };
        let wayland = variable == WAYLAND;
        let sockets = if wayland { sockets_of_wayland(&name, named("XDG_RUNTIME_DIR")) } else { sockets_of_x11(&name) };
        if sockets.iter().any(answers) {
            return Ok(silent.pop().map(|_: String| WAYLAND));
        }
        silent.push(format!("{variable}={name}"));
    }
    match silent.as_slice() {
        [] => Err(format!("neither DISPLAY nor {WAYLAND} is set")),
        [one] => Err(format!("{one} does not answer")),
        all => Err(format!("{} do not answer", all.join(" and "))),
    }
}

/// Address of a display's server.
#[derive(Clone, Debug, PartialEq, Eq)]
enum Socket {
    /// A socket in a file.
    File(String),
    /// A Linux socket whose name is not that of a file.
    Abstract(String),
    /// A host and a port.
    Tcp(String, u16),
}

/// Address of a Wayland display: a path, or a name in the folder of the session.
fn sockets_of_wayland(name: &str, session: Option<String>) -> Vec<Socket> {
    let folder = session.filter(|_| !name.starts_with('/'));
    vec![Socket::File(folder.map_or_else(|| name.to_owned(), |folder| format!("{folder}/{name}")))]
}

/// Addresses of an X display, `[HOST]:NUMBER[.SCREEN]`; empty if the name is not of this form.
fn sockets_of_x11(name: &str) -> Vec<Socket> {
    let Some((host, rest)) = name.rsplit_once(':') else { return Vec::new() };
    let Ok(number) = rest.split('.').next().unwrap_or_default().parse::<u16>() else { return Vec::new() };
    // XQuartz and others give the path of the socket's file
    if host.starts_with('/') {
        return vec![Socket::File(name.into()), Socket::File(host.into())];
    }
    if host.is_empty() || host == "unix" {
        let file = format!("/tmp/.X11-unix/X{number}");
        return vec![Socket::File(file.clone()), Socket::Abstract(file)];
    }
    number.checked_add(6000).map(|port| vec![Socket::Tcp(host.into(), port)]).unwrap_or_default()
}

#[cfg(unix)]
fn answers(socket: &Socket) -> bool {
    use std::net::{TcpStream, ToSocketAddrs};
    use std::os::unix::net::UnixStream;

    /// Longest wait for a host.
    const PATIENCE: std::time::Duration = std::time::Duration::from_secs(2);

    match socket {
        Socket::File(path) => UnixStream::connect(path).is_ok(),
        #[cfg(target_os = "linux")]
        Socket::Abstract(name) => {
            use std::os::linux::net::SocketAddrExt;
            let address = std::os::unix::net::SocketAddr::from_abstract_name(name);
            address.is_ok_and(|address| UnixStream::connect_addr(&address).is_ok())
        }
        #[cfg(not(target_os = "linux"))]
        Socket::Abstract(_) => false,
        Socket::Tcp(host, port) => (host.as_str(), *port)
            .to_socket_addrs()
            .is_ok_and(|mut all| all.any(|address| TcpStream::connect_timeout(&address, PATIENCE).is_ok())),
    }
}

#[cfg(not(unix))]
fn answers(_socket: &Socket) -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(variables: &[(&str, &str)], open: &[Socket]) -> Result<Option<&'static str>, String> {
        let named = |name: &str| variables.iter().find(|(n, _)| *n == name).map(|(_, value)| (*value).to_owned());
        answering(&named, &|socket| open.contains(socket))
    }

    #[test]
    fn a_display_counts_if_it_answers() {
        let file = |path: &str| Socket::File(path.into());
        let x3 = [file("/tmp/.X11-unix/X3")];
        assert_eq!(asked(&[], &x3), Err("neither DISPLAY nor WAYLAND_DISPLAY is set".into()));
        assert_eq!(asked(&[("DISPLAY", ":3.0")], &x3), Ok(None));
        assert_eq!(asked(&[("DISPLAY", ":4")], &x3), Err("DISPLAY=:4 does not answer".into()));
        assert_eq!(asked(&[("DISPLAY", "nonsense")], &x3), Err("DISPLAY=nonsense does not answer".into()));
        assert_eq!(asked(&[("DISPLAY", "far:2")], &[Socket::Tcp("far".into(), 6002)]), Ok(None));
        let wayland = ("WAYLAND_DISPLAY", "wayland-0");
        assert_eq!(asked(&[wayland, ("XDG_RUNTIME_DIR", "/run/me")], &[file("/run/me/wayland-0")]), Ok(None));
        // XWayland answers, but the Wayland compositor is gone
        assert_eq!(asked(&[wayland, ("DISPLAY", ":3")], &x3), Ok(Some(WAYLAND)));
        let neither = "WAYLAND_DISPLAY=wayland-0 and DISPLAY=:4 do not answer";
        assert_eq!(asked(&[wayland, ("DISPLAY", ":4")], &x3), Err(neither.into()));
    }

    #[cfg(unix)]
    #[test]
    fn a_socket_answers_while_somebody_listens() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("X1");
        let socket = Socket::File(path.display().to_string());
        assert!(!answers(&socket));
        let _listener = std::os::unix::net::UnixListener::bind(&path).unwrap();
        assert!(answers(&socket));
    }
}
