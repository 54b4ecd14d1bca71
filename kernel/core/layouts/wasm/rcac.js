// A controller in a page: const c = await load(fetch("rcac.wasm")); u = c.step(y, z, r).
export async function load(source) {
  const bytes = await (await source).arrayBuffer();
  const { instance } = await WebAssembly.instantiate(bytes, {});
  const core = instance.exports;
  const Numbers = core.size(5) === 4 ? Float32Array : Float64Array;
  const part = (name, which) => new Numbers(core.memory.buffer, core[name](), core.size(which));
  if (core.self_check() & ~16) throw new Error("this engine does not round as C says");
  core.init();
  return {
    status: 0,
    init: () => core.init(),
    freeze: (frozen) => core.freeze(frozen ? 1 : 0),
    save: () => core.save(),
    restore: () => core.restore(),
    get theta() { return Array.from(part("theta", 4)); },
    step(y, z, r = []) {
      part("y", 0).set(y);
      part("z", 1).set(z);
      part("r", 2).set(r);
      this.status = core.step();
      return Array.from(part("u", 3));
    },
  };
}
