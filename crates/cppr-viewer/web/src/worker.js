// Runs the kernel in a worker. The first message brings the module and a robot; every other one is a message of the page to its session.
// `wasm_bindgen` is defined by the loader of the module, which stands before this in the worker.

let kernel = null;
let waiting = false;

const say = (answer) => (typeof answer === "string" ? postMessage(answer) : postMessage(answer.buffer, [answer.buffer]));

/** Some poses of the workspace at a time; what the page asks meanwhile comes first. */
function background() {
  waiting = kernel.background(say);
  if (waiting) setTimeout(background);
}

onmessage = ({ data }) => {
  if (kernel === null) {
    wasm_bindgen.initSync({ module: data.module });
    kernel = new wasm_bindgen.Kernel(data.robot);
    say("open");
    return;
  }
  kernel.answer(data, say);
  if (!waiting) background();
};
