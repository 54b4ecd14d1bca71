// Python for the examples of a page. `onmessage` is set before anything is awaited: a message that came
// earlier would be lost.
const home = new URL("../lite/static/pyodide/", import.meta.url).href;
let session = null;
let last = Promise.resolve();

async function start(tell) {
  tell({ state: "loading Python (28 MB, once) …" });
  const { loadPyodide } = await import(`${home}pyodide.mjs`);
  const python = await loadPyodide({ indexURL: home, packages: ["compensator-theory"] });
  tell({ state: "starting …" });
  python.runPython(await (await fetch(new URL("try_it.py", import.meta.url))).text());
  return { python, run: python.globals.get("run") };
}

// Runs the examples before this one that have not run, and then this one, which is shown.
async function answer({ number, scope, earlier, code }) {
  const tell = message => postMessage({ number, ...message });
  try {
    session ??= start(tell);
    const { python, run } = await session;
    tell({ state: "computing …" });
    await python.loadPackagesFromImports([...earlier, code].join("\n"));
    for (const example of earlier) {
      const error = run(example, scope, () => {});
      if (error) return tell({ done: true, error: `an example before this one ends with ${error}` });
    }
    const show = (source, text, formula) => tell({ answer: { source, text, formula } });
    tell({ done: true, error: run(code, scope, show) });
  } catch (error) {
    session = null;
    tell({ done: true, error: `Python does not start: ${error.message ?? error}` });
  }
}

onmessage = ({ data }) => { last = last.then(() => answer(data)); };
