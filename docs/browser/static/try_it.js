// "Try it" below each example that runs in the browser. A page has one worker, which the first click
// starts and which Stop ends; what it runs stands beside JupyterLite, where both are built.
(() => {
  const home = new URL(".", document.currentScript.src);
  const lite = new URL("../lite/", home);
  const ADD = "These pages were built without Python for the browser; in a checkout, python -m docs.browser docs/_build adds it.";
  const SERVE = "A page that is opened as a file cannot start Python; python -m http.server -d docs/_build serves the pages.";
  const STOPPED = "stopped; the next run starts Python again";
  const SLOW = "Python has not started in three minutes; the server must allow 'wasm-unsafe-eval' in its Content-Security-Policy";
  let worker = null, number = 0, formulas = null;
  const waiting = new Map();  // number of a run: who hears the reply
  const ran = new Set();      // blocks that the present worker has run

  const element = (tag, properties = {}, ...children) => {
    const made = Object.assign(document.createElement(tag), properties);
    made.append(...children);
    return made;
  };

  async function missing(path) {
    if (location.protocol === "file:") return SERVE;
    const response = await fetch(new URL(path, lite), { method: "HEAD" }).catch(() => null);
    return response?.ok ? "" : ADD;
  }

  function end(error) {
    worker?.terminate();
    worker = null;
    ran.clear();
    for (const tell of [...waiting.values()]) tell({ done: true, error });
  }

  function ask(message, tell) {
    const mine = ++number;
    if (!worker) {
      worker = new Worker(new URL("try_it_worker.js", home), { type: "module" });
      worker.onmessage = ({ data }) => waiting.get(data.number)?.(data);
      worker.onerror = event => end(`Python does not start: ${event.message || "the worker is refused"}`);
    }
    const late = setTimeout(() => end(SLOW), 180_000);
    waiting.set(mine, reply => {
      if (reply.done || reply.state === "computing …") clearTimeout(late);
      if (reply.done) waiting.delete(mine);
      tell(reply);
    });
    worker.postMessage({ number: mine, ...message });
  }

  // The docs set their formulas as MathML when they are built; here they come later.
  async function set(formula, place) {
    formulas ??= import(new URL("static/temml/temml.mjs", lite));
    try {
      (await formulas).default.render(formula, place, { displayMode: true, throwOnError: true });
    } catch {
      place.replaceChildren(element("code", { className: "not-set", textContent: formula }));
    }
  }

  function source(block) {
    const lines = block.querySelector("pre").textContent.split("\n");
    const session = lines.some(line => line.startsWith(">>> "));
    const code = session ? lines.filter(line => /^(>>>|\.\.\.)/.test(line)).map(line => line.slice(4)) : lines;
    return code.join("\n").trim();
  }

  const blocks = [...document.querySelectorAll(".try-it")].map(
    block => ({ block, scope: block.closest("dl.py"), code: source(block) }));
  const scopes = [...new Set(blocks.map(one => one.scope))];

  function offer(one) {
    const area = element("textarea", { value: one.code, spellcheck: false, ariaLabel: "code of the example" });
    const run = element("button", { type: "submit", textContent: "Run" });
    const stop = element("button", { type: "button", textContent: "Stop", hidden: true, onclick: () => end(STOPPED) });
    const state = element("span", { role: "status" });
    const answers = element("div", { className: "answers" });
    const form = element("form", { className: "try" }, area, element("p", {}, run, stop, state), answers);
    area.rows = one.code.split("\n").length;
    area.oninput = () => { one.code = area.value; };
    area.onkeydown = event => { if (event.key === "Enter" && (event.ctrlKey || event.shiftKey)) { event.preventDefault(); form.requestSubmit(); } };
    form.onsubmit = event => {
      event.preventDefault();
      if (run.disabled) return;
      const began = performance.now();
      const running = is => { run.disabled = is; stop.hidden = !is; };
      const finish = error => {
        running(false);
        state.textContent = error ? "" : `${((performance.now() - began) / 1000).toFixed(2)} s`;
        if (error) answers.append(element("p", { className: "error", textContent: error }));
      };
      running(true);
      answers.replaceChildren();
      const before = blocks.slice(0, blocks.indexOf(one)).filter(other => other.scope === one.scope && !ran.has(other));
      const message = { scope: String(scopes.indexOf(one.scope)), earlier: before.map(other => other.code), code: one.code };
      ask(message, reply => {
        if (reply.state) state.textContent = reply.state;
        if (reply.answer) show(reply.answer, answers);
        if (!reply.done) return;
        if (!reply.error) [...before, one].forEach(other => ran.add(other));
        finish(reply.error);
      });
    };
    return form;
  }

  function show({ source, text, formula }, answers) {
    if (source) answers.append(element("pre", { className: "source", textContent: source }));
    if (text) answers.append(element("pre", { textContent: text }));
    if (formula == null) return;
    const place = element("div", { className: "math", tabIndex: 0 });
    answers.append(place);
    set(formula, place);
  }

  // The example becomes a field of the page; without Python it stays as it is, and the reason below it.
  for (const one of blocks) {
    const button = element("button", { className: "try-it-button", textContent: "Try it", title: "runs in this browser; the first run loads 28 MB" });
    const state = element("span", { role: "status" });
    const place = element("p", { className: "try-it-offer" }, button, state);
    button.onclick = async () => {
      state.textContent = await missing("static/pyodide/pyodide-lock.json");
      if (state.textContent) return;
      const form = offer(one);
      place.replaceWith(form);
      one.block.hidden = true;
      form.requestSubmit();
    };
    one.block.after(place);
  }

  for (const place of document.querySelectorAll(".try-lecture")) {
    const link = element("a", { href: new URL(`notebooks/index.html?path=${place.dataset.lecture}`, lite), textContent: "Run this lecture in the browser" });
    const state = element("span", { role: "status" });
    link.onclick = async event => {
      event.preventDefault();
      const reason = await missing("jupyter-lite.json");
      if (reason) state.textContent = reason; else location.assign(link.href);
    };
    place.append(link, " (JupyterLite; nothing is installed, the first visit loads 40 MB) ", state);
  }
})();
