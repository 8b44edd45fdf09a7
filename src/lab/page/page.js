// Headings become buttons that sort their column: numbers by value, from small to large, then reversed.
for (const table of document.querySelectorAll("table.sortable")) {
  const body = table.tBodies[0];
  const heads = [...table.tHead.rows[0].cells];
  const value = (row, column) => {
    const cell = row.cells[column];
    const text = cell.dataset.v ?? cell.textContent;
    return text !== "" && isFinite(text) ? Number(text) : text;
  };
  // Unknown values come last in either direction.
  const order = (a, b, sign) => {
    if (a === "-" || b === "-") return (a === "-") - (b === "-");
    return sign * (typeof a === "number" && typeof b === "number" ? a - b : String(a).localeCompare(b));
  };
  heads.forEach((head, column) => {
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    head.append(button);
    button.addEventListener("click", () => {
      const up = head.getAttribute("aria-sort") !== "ascending";
      heads.forEach(h => h.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", up ? "ascending" : "descending");
      const rows = [...body.rows].map(row => [value(row, column), row]);
      rows.sort((p, q) => order(p[0], q[0], up ? 1 : -1));
      body.append(...rows.map(pair => pair[1]));
    });
  });
}

// A picture at full size: Escape closes it, the arrow keys show the others of its row.
document.addEventListener("keydown", event => {
  const open = document.querySelector(".view input:checked");
  const step = { ArrowRight: 1, ArrowLeft: -1, Escape: 0 }[event.key];
  if (!open || step === undefined) return;
  event.preventDefault();
  const views = [...open.closest(".views").querySelectorAll("input")];
  open.checked = false;
  if (step !== 0) {
    const next = views[(views.indexOf(open) + step + views.length) % views.length];
    next.checked = true;
    next.focus();
  }
});
