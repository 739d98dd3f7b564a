// Draws here; the physics runs in a worker, with its own instance of the same module. `tell` is
// defined by the page.
window.started = true;
let stopped = false;
const stop = (text) => { stopped = true; tell(text); };
// The module is compressed in the folder, so that every server sends little, whether it compresses
// or not. From a server that sets the header of compressed content it arrives unpacked.
const file = "palpate_live.wasm.gz";
// a page of one file provides its parts itself
const parts = window.parts ?? {
  bindings: () => import("./palpate_live.js"),
  worker: () => new Worker("worker.js", { type: "module" }),
  packed: () => fetch(file),
};
const unpacked = async () => {
  const sent = await parts.packed();
  if (!sent.ok) throw new Error(`the server answers ${sent.status}: put the whole folder there`);
  const [head, body] = sent.body.tee();
  const reader = head.getReader();
  const { value } = await reader.read();
  reader.cancel();
  // gzip begins with 1f 8b, a module with 00 61 73 6d
  const first = value?.[0];
  if (first !== 0x1f && first !== 0) throw new Error(`what the server sends is something else: put the folder's own there`);
  const bytes = first === 0 ? body : body.pipeThrough(new DecompressionStream("gzip"));
  return new Response(bytes, { headers: { "Content-Type": "application/wasm" } });
};
const compiled = async () => {
  const module = await unpacked();
  return WebAssembly.compileStreaming(module).catch((why) => { throw new Error(`it came damaged or cut off (${why.message})`); });
};
const named = (why) => { throw new Error(`${file}: ${why.message}`); };
try {
  const lacks = ["WebAssembly", "DecompressionStream", "WebGLRenderingContext", "Worker"].filter((name) => !(name in window));
  if (lacks.length) throw new Error(`this browser has no ${lacks.join(", no ")}: take a newer one`);
  const [bindings, module] = await Promise.all([parts.bindings(), compiled().catch(named)]);
  const worker = parts.worker();
  worker.onerror = ({ message }) => stop(`The physics stopped (${message || "worker.js does not start"}): reload the page, or take another browser.`);
  // text is a sentence for the user; what is drawn arrives as bytes
  worker.addEventListener("message", ({ data }) => { if (typeof data === "string") stop(data); });
  // on a page from the disk no compiled module reaches the worker: it gets the bytes
  worker.postMessage(window.parts ? await (await unpacked()).arrayBuffer() : module);
  await bindings.default({ module_or_path: module });
  const picture = document.getElementById("picture");
  await bindings.draw(picture, worker);
  picture.focus();
  window.palpate = { shown: () => JSON.parse(bindings.shown()), trace: bindings.trace };
  // a running recording would be lost
  addEventListener("beforeunload", (event) => {
    if (stopped || window.palpate.shown().recorded_ticks == null) return;
    event.preventDefault();
    event.returnValue = true;
  });
  said.hidden = !stopped;
} catch (why) {
  stop(`No picture: ${why.message ?? why}`);
}
