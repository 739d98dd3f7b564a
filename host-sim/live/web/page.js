// Draws here; the physics runs in a worker of its own, with its own instance of the same module.
const said = document.getElementById("said");
const tell = (text) => { said.textContent = text; said.hidden = false; };
try {
  // packed in the folder: every server sends it small, whether it compresses or not
  const unpacked = async () => {
    const packed = await fetch("palpate_live.wasm.gz");
    if (!packed.ok) throw new Error(`palpate_live.wasm.gz: ${packed.status}`);
    const bytes = packed.body.pipeThrough(new DecompressionStream("gzip"));
    return WebAssembly.compileStreaming(new Response(bytes, { headers: { "Content-Type": "application/wasm" } }));
  };
  const [bindings, module] = await Promise.all([import("./palpate_live.js"), unpacked()]);
  const worker = new Worker("worker.js", { type: "module" });
  worker.onerror = () => tell("The physics could not start: reload the page, or take another browser.");
  worker.postMessage(module);
  await bindings.default({ module_or_path: module });
  const picture = document.getElementById("picture");
  await bindings.draw(picture, worker);
  picture.focus();
  window.palpate = { shown: () => JSON.parse(bindings.shown()), trace: bindings.trace };
  said.hidden = true;
} catch (why) {
  tell(location.protocol === "file:"
    ? "A browser starts no module from a file: serve this folder, for instance with `palpate live --page`."
    : `No picture: ${why}. The page needs WebAssembly, WebGL and workers.`);
}
