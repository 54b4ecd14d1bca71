// The theme's search wants every word of a question on one page, and an entry of the index letter by letter.
// Here an entry is found by its words, one spelling finds the other, and where no page has every word,
// those that have the most come first.
if (typeof Search !== "undefined") {
  const { _parseQuery: parse, _performSearch: perform } = Search;
  const british = (text) => text.replace(/([a-z]{2}[aeiouy]?[lmnrtdcg])iz(?=[eia])/gi, "$1is")
    .replace(/(analy)z/gi, "$1s").replace(/\b(behavi|col)or/gi, "$1our").replace(/modeling/gi, "modelling");
  const stemmer = new Stemmer();
  const stems = (text) => new Set(british(text).toLowerCase().split(/\W+/)
    .filter((word) => word && !stopwords.has(word)).map((word) => stemmer.stemWord(word)));
  const entries = (asked) => {
    const { docnames, titles, filenames, indexentries } = Search._index;
    const found = [];
    for (const [entry, places] of Object.entries(indexentries)) {
      const main = places.filter(([, , isMain]) => isMain);
      if (!main.length) continue;
      const words = stems(entry);
      const shared = [...words].filter((word) => asked.has(word)).length;
      if (!shared || shared < Math.min(words.size, asked.size)) continue;
      for (const [file, id] of main) {
        const score = Math.round(95 * (shared / Math.max(words.size, asked.size)) ** 2);
        const result = [docnames[file], titles[file], id ? "#" + id : "", null, score, filenames[file], SearchResultKind.index];
        result[4] = Scorer.score(result);
        found.push(result);
      }
    }
    return found;
  };
  Search._performSearch = (query) => {
    const asked = stems(query);
    const askedFor = (text) => perform(...parse(text));
    let found = [...new Set([query, british(query)])].flatMap(askedFor).concat(entries(asked));
    if (!found.length) {
      const parts = query.split(/\s+/).map((word) => askedFor(british(word)));
      found = parts.flat();
      const pages = parts.map((part) => new Set(part.map(([page]) => page)));
      for (const result of found) result[4] += 20 * pages.filter((part) => part.has(result[0])).length;
    }
    const best = new Map();  // of each place the result that stands highest
    for (const result of found) {
      const place = result[0] + result[2];
      if (!best.has(place) || best.get(place)[4] < result[4]) best.set(place, result);
    }
    return [...best.values()].sort((a, b) => a[4] - b[4]);
  };
}
