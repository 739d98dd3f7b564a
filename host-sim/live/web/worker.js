// Runs the loop at 1 kHz of virtual time. The timer of a worker goes on while the page is hidden;
// the ticks that are due run when it fires.
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
// the page is not notified of a promise that failed, so it gets a message, once
const stop = (why) => {
  clearInterval(timer);
  self.onmessage = null;
  self.postMessage(`The physics stopped (${why.message ?? why}): reload the page, or take another browser.`);
};
self.onmessage = ({ data }) => take(data).catch(stop);
