// The module in a worker: calls come in order, and each is answered once. Numbers are
// copied out, because a call may enlarge the memory, which detaches every view of it.
let loading, last = Promise.resolve();

async function load(base64) {
  const packed = Uint8Array.from(atob(base64), (c) => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream('gzip'));
  const bytes = await new Response(stream).arrayBuffer();
  // No imports: the world asks for no clock, no file and no random numbers.
  return (await WebAssembly.instantiate(bytes, {})).instance.exports;
}

async function answer({ id, name, args, input }) {
  try {
    const module = await loading;
    if (input !== undefined) {
      const bytes = new TextEncoder().encode(input), at = module.input(bytes.length) >>> 0;
      new Uint8Array(module.memory.buffer, at, bytes.length).set(bytes);
    }
    const isOk = module[name](...args) === 1, { buffer } = module.memory;
    const text = new TextDecoder().decode(
      new Uint8Array(buffer, module.text() >>> 0, module.text_length()));
    const numbers = new Float64Array(buffer, module.numbers() >>> 0, module.numbers_length()).slice();
    postMessage({ id, isOk, text, numbers }, [numbers.buffer]);
  } catch (error) {
    postMessage({ id, isOk: false, text: `the module stopped (${error.message}); load the page again` });
  }
}

onmessage = ({ data }) => {
  if (data.module) loading = load(data.module);
  else last = last.then(() => answer(data));
};
