// What the theme leaves unsaid to a screen reader, out of the keyboard's reach or too wide for a phone.
addEventListener("DOMContentLoaded", () => {
  const each = (selector, change) => document.querySelectorAll(selector).forEach(change);
  each(".caption[role=heading]", caption => caption.setAttribute("aria-level", "2"));
  each(".sidebar-drawer", aside => aside.setAttribute("aria-label", "All pages"));
  each(".toc-drawer", aside => aside.setAttribute("aria-label", "On this page"));
  each(".content-icon-container", icons => {
    icons.setAttribute("role", "region");
    icons.setAttribute("aria-label", "Source and colours");
  });
  each("summary[aria-label]", summary => summary.removeAttribute("aria-label"));
  each("th", head => { if (!head.textContent.trim()) head.setAttribute("role", "presentation"); });
  // A long name may be broken where it is made of several, and nowhere else.
  each("h1, .sig, :not(pre) > code, td", named => {
    const walker = document.createTreeWalker(named, NodeFilter.SHOW_TEXT);
    const texts = [];
    while (walker.nextNode()) texts.push(walker.currentNode);
    texts.filter(text => /[._/][A-Za-z]/.test(text.data)).forEach(text => text.replaceWith(
      ...text.data.split(/(?<=[._/])(?=[A-Za-z])/).flatMap((part, i) => i ? [document.createElement("wbr"), part] : [part])));
  });
  each("pre, .table-wrapper, .cell_output .output", wide => { wide.tabIndex = 0; });
});
