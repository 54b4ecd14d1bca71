// What a reader looks for by a word is first the page of that name, then the task, then a function.
// Words that no page has in its text or title are index entries: `{index} ! dead time`.
var Scorer = {
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 5, 1: 0, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,

  // Where an answer is likely: the guide, then pages of tasks, the reference, and last what tells
  // of the past, of the dissertation, or of the inside of the packages.
  places: [
    [/^reference\/(folders|equations|rocq\/|(rcac_numeric|compensator_theory)(\.|$))/, -25],
    [/^(changelog|errata|fair-judging|letters|proofs)$/, -12],
    [/^(notebooks\/|beyond-the-text|arithmetic|trust|search|genindex|exercises)/, -3],
    [/^reference\/api\//, 0],
    [/^reference\//, 4],
    [/^guide\//, 8],
    [/^/, 6],
  ],

  score: ([docname, title, anchor, descr, score, filename, kind]) => {
    const place = Scorer.places.find(([pattern]) => pattern.test(docname))[1];
    const query = new URLSearchParams(window.location.search).get("q") || "";
    const words = query.toLowerCase().split(/\s+/).filter((word) => word);
    const titled = title.toLowerCase().split(/\W+/);
    const named = words.every((word) => titled.some((part) => part.startsWith(word)));
    if (anchor || !words.length || !named) return score + place;
    const first = titled[0].startsWith(words[0]) ? 20 : 0;
    if (docname.startsWith("reference/api/")) return score + 10;
    if (/^reference\/(rocq|rcac_numeric|compensator_theory)/.test(docname)) return score - 10;
    return score + (docname.startsWith("guide/") ? 50 : 40) + first;
  },
};
