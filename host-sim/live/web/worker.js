// The loop at 1 kHz of virtual time. A timer in a worker goes on while the page is hidden; what is due is run when it fires.
import init, { PagePhysics } from "./palpate_live.js";
const clock = () => performance.now() * 1e-3;
const post = (bytes) => self.postMessage(bytes, [bytes.buffer]);
let physics, timer;
const waiting = [];
const take = async (data) => {
  if (data instanceof WebAssembly.Module || data instanceof ArrayBuffer) {
    await init({ module_or_path: data });
    physics = new PagePhysics(post, clock());
    waiting.splice(0).forEach((bytes) => physics.take(bytes, clock));
    timer = setInterval(() => { try { physics.advance(clock); } catch (why) { stop(why); } }, 2);
  } else if (physics) {
    physics.take(data, clock);
    physics.advance(clock);
  } else if (waiting.length < 100) {
    waiting.push(data);
  }
};
// the page never hears of a promise that failed: it is told, once
const stop = (why) => {
  clearInterval(timer);
  self.onmessage = null;
  self.postMessage(`The physics stopped (${why.message ?? why}): reload the page, or take another browser.`);
};
self.onmessage = ({ data }) => take(data).catch(stop);
