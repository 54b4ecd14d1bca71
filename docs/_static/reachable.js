// What the theme leaves unsaid to a screen reader or out of the keyboard's reach.
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
  each("pre, .table-wrapper, .cell_output .output", wide => { wide.tabIndex = 0; });
});
