//! The page as one file, which contains as text the parts that the page would otherwise fetch. From
//! a page on a disk a browser starts no script in another file, but it starts one inside the page.

use std::path::Path;

/// Name of the file.
const NAME: &str = "palpate-live.html";
/// First script of `index.html`, before which the parts are inserted.
const FIRST: &str = "<script>\n  // Plain";
/// The script that `index.html` fetches.
const FETCHED: &str = r#"<script type="module" src="page.js"></script>"#;
/// The import in `worker.js`, which is not permitted in a script that is not a module.
const IMPORT: &str = r#"import init, { PagePhysics } from "./palpate_live.js";"#;
/// Script that provides the parts which `page.js` uses instead of fetching them.
const PARTS: &str = r#"<script>
  window.parts = (function () {
    var text = function (name) { return document.getElementById(name).textContent; };
    var link = function (name) { return URL.createObjectURL(new Blob([text(name)], { type: "text/javascript" })); };
    return {
      bindings: function () { return import(link("bindings")); },
      worker: function () { return new Worker(link("worker")); },
      packed: function () {
        var bytes = Uint8Array.from(atob(text("packed")), function (letter) { return letter.charCodeAt(0); });
        return new Response(bytes);
      },
    };
  })();
</script>
"#;

/// Writes the single file beside the module and its JavaScript, from the page's own files in `web`.
pub fn write(folder: &Path, web: &Path) -> Result<(), String> {
    let read = |path: &Path| std::fs::read(path).map_err(|why| format!("{}: {why}", path.display()));
    let text = |path: &Path| String::from_utf8(read(path)?).map_err(|why| format!("{}: {why}", path.display()));
    let page = whole(
        &text(&web.join("index.html"))?,
        &text(&web.join("page.js"))?,
        &text(&web.join("worker.js"))?,
        &text(&folder.join("palpate_live.js"))?,
        &read(&folder.join("palpate_live.wasm.gz"))?,
    )?;
    let path = folder.join(NAME);
    std::fs::write(&path, page).map_err(|why| format!("{}: {why}", path.display()))
}

fn whole(index: &str, page: &str, worker: &str, bindings: &str, packed: &[u8]) -> Result<String, String> {
    let once = |text: &str, from: &str, to: &str, name: &str| {
        if text.matches(from).count() == 1 {
            Ok(text.replace(from, to))
        } else {
            Err(format!("{name} does not hold `{from}` once: adapt tools/page/src/one_file.rs"))
        }
    };
    // the bindings come first, so that the worker's lines can use their names
    let worker = plain(bindings) + &once(worker, IMPORT, "const init = __wbg_init;", "worker.js")?;
    for (name, script) in [("page.js", page), ("worker.js", &worker)] {
        if script.contains("</script") {
            return Err(format!("{name} holds `</script`, which would end it"));
        }
    }
    let held = |name: &str, text: &str| format!("<script type=\"text/plain\" id=\"{name}\">{text}</script>\n");
    let parts = held("bindings", bindings) + &held("worker", &worker) + &held("packed", &base64(packed)) + PARTS;
    let index = once(index, FIRST, &(parts + FIRST), "index.html")?;
    once(&index, FETCHED, &format!("<script type=\"module\">\n{page}</script>"), "index.html")
}

/// Converts bindings to a script that is not a module, since Chromium starts no module worker on a
/// page from a disk.
fn plain(bindings: &str) -> String {
    let mut text = String::with_capacity(bindings.len());
    for line in bindings.lines().filter(|line| !line.starts_with("export {")) {
        text.push_str(line.strip_prefix("export ").unwrap_or(line));
        text.push('\n');
    }
    text
}

/// Encodes bytes as base64 (RFC 4648).
fn base64(bytes: &[u8]) -> String {
    const LETTERS: &[u8; 64] = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    let mut text = String::with_capacity(bytes.len().div_ceil(3) * 4);
    for three in bytes.chunks(3) {
        let bits = three.iter().chain([&0, &0]).take(3).fold(0, |bits, byte| bits << 8 | usize::from(*byte));
        for k in 0..4 {
            text.push(if k <= three.len() { char::from(LETTERS[bits >> (18 - 6 * k) & 63]) } else { '=' });
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn letters_of_rfc_4648() {
        for (bytes, text) in [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")] {
            assert_eq!(base64(bytes.as_bytes()), text);
        }
        assert_eq!(base64(&[255, 254, 253]), "//79");
    }

    #[test]
    fn the_pages_own_files_make_one_that_fetches_nothing() {
        let web = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../web");
        let text = |name: &str| std::fs::read_to_string(web.join(name)).unwrap();
        let bindings = "export class PagePhysics {}\nexport { __wbg_init as default };\n";
        assert_eq!(plain(bindings), "class PagePhysics {}\n");
        let page = whole(&text("index.html"), &text("page.js"), &text("worker.js"), bindings, b"module").unwrap();
        assert!(!page.contains("src=") && page.contains("window.parts") && page.contains(">bW9kdWxl<"), "{page}");
        assert!(page.find("window.parts =") < page.find("location.protocol"), "the parts come too late");
    }
}
