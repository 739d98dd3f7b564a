// Draws here; the physics runs in a worker of its own, with its own instance of the same module.
const said = document.getElementById("said");
const tell = (text) => { said.textContent = text; said.hidden = false; };
try {
  const [bindings, module] = await Promise.all([
    import("./palpate_live.js"),
    WebAssembly.compileStreaming(fetch("palpate_live_bg.wasm")),
  ]);
  const worker = new Worker("worker.js", { type: "module" });
  worker.onerror = () => tell("The physics could not start: reload the page, or take another browser.");
  worker.postMessage(module);
  await bindings.default({ module_or_path: module });
  await bindings.draw(document.getElementById("picture"), worker);
  window.palpate = { shown: () => JSON.parse(bindings.shown()) };
  said.hidden = true;
} catch (why) {
  tell(location.protocol === "file:"
    ? "A browser starts no module from a file: serve this folder, for instance with `palpate live --page`."
    : `No picture: ${why}. The page needs WebAssembly, WebGL and workers.`);
}
