(() => {
  const root = document.documentElement, get = id => document.getElementById(id);
  const theme = get("theme");
  theme.hidden = false;
  theme.addEventListener("click", () => {
    const dark = root.dataset.theme ? root.dataset.theme === "dark"
      : matchMedia("(prefers-color-scheme: dark)").matches;
    root.dataset.theme = dark ? "light" : "dark";
  });
  const opened = part => {  // and all that it is folded in
    for (let one = part; one; one = one.parentElement) if (one.tagName === "DETAILS") one.open = true;
  };
  const filters = get("filters");
  if (filters) {
    const rows = [...document.querySelectorAll("#claims tbody tr")];
    const cases = [...document.querySelectorAll(".case")];
    const text = new Map(rows.map(row => [row, row.textContent.toLowerCase()]));
    const query = get("query"), verdict = get("verdict"), chapter = get("chapter");
    const asked = new URLSearchParams(location.search);
    query.value = asked.get("q") ?? "";
    verdict.value = asked.get("verdict") ?? "";
    chapter.value = asked.get("chapter") ?? "";
    for (const list of [verdict, chapter]) if (list.selectedIndex < 0) list.value = "";
    const apply = () => {
      const words = query.value.toLowerCase().split(/\s+/).filter(Boolean);
      const shown = new Set();
      let count = 0;
      for (const row of rows) {
        const fits = words.every(word => text.get(row).includes(word))
          && (!verdict.value || row.dataset.verdict === verdict.value)
          && (!chapter.value || row.dataset.chapter === chapter.value);
        row.hidden = !fits;
        if (fits) { count += 1; shown.add(row.dataset.case); }
      }
      const all = !words.length && !verdict.value;
      for (const part of cases)
        part.hidden = !(shown.has(part.id)
          || (all && (!chapter.value || part.dataset.chapter === chapter.value)));
      get("count").textContent = `${count} of ${rows.length} claims`;
      const state = new URLSearchParams();
      if (query.value) state.set("q", query.value);
      if (verdict.value) state.set("verdict", verdict.value);
      if (chapter.value) state.set("chapter", chapter.value);
      const search = state.size ? `?${state}` : "";
      history.replaceState(null, "", location.pathname + search + location.hash);
    };
    filters.hidden = false;
    filters.addEventListener("submit", event => event.preventDefault());
    for (const part of [query, verdict, chapter]) part.addEventListener("input", apply);
    addEventListener("keydown", event => {
      if (event.key === "/" && !/INPUT|SELECT|TEXTAREA/.test(event.target.tagName)) {
        event.preventDefault();
        opened(filters);
        query.focus();
      } else if (event.key === "Escape" && event.target === query) {
        query.value = "";
        apply();
      }
    });
    if (query.value || verdict.value || chapter.value) opened(filters);
    apply();
  }
  // Parts that are not drawn yet have a guessed height: go to the target again once it is known.
  const go = () => {
    const target = location.hash && get(decodeURIComponent(location.hash.slice(1)));
    if (!target) return;
    target.hidden = false;
    opened(target);
    requestAnimationFrame(() => requestAnimationFrame(() =>
      target.scrollIntoView({ behavior: "instant" })));
  };
  addEventListener("hashchange", go);
  addEventListener("load", go);
})();
