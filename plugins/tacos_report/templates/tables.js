"use strict";
// Sorts, filters and saves the tables of a page, opens what a row leads to. Without it, and on paper, every row is there.

const ROWS_TO_SORT = 4;
const ROWS_TO_FILTER = 9;
const MISSING = -Infinity;

const textOf = (cell) => [...cell.childNodes].map((node) => node.textContent.trim()).filter(Boolean).join("; ");
const leading = (cell) => (cell.firstChild ? cell.firstChild.textContent.trim() : "");

/** The number a text begins with, as in "1.2 mm", "−3" or "> 99 %"; NaN where it begins with a word. */
function numberIn(text) {
  const found = /^[<>≈~≥≤+\s]*([−-]?[\d]*\.?\d+(?:e[−-]?\d+)?)/i.exec(text.replace(/[\u202f\u00a0,]/g, ""));
  return found ? Number(found[1].replace("−", "-")) : NaN;
}

function compare(one, other, numeric) {
  if (!numeric) return one.localeCompare(other, "en", { numeric: true });
  const [a, b] = [one, other].map((text) => (text ? numberIn(text) : MISSING));
  return a === b ? 0 : a - b;
}

function button(text, label, act) {
  const made = document.createElement("button");
  made.type = "button";
  made.textContent = text;
  if (label) made.setAttribute("aria-label", label);
  made.addEventListener("click", act);
  return made;
}

/** Let each heading sort: numbers from the largest first, words from A. */
function makeSortable(body, heads) {
  heads.forEach((head, column) => {
    const title = head.textContent;
    if (!title) return;
    const sort = () => {
      const rows = [...body.rows].filter((row) => !row.classList.contains("total"));
      const texts = rows.map((row) => leading(row.cells[column]));
      const numeric = texts.every((text) => !text || !Number.isNaN(numberIn(text)));
      const before = head.getAttribute("aria-sort");
      const descending = before ? before === "ascending" : numeric;
      heads.forEach((other) => other.removeAttribute("aria-sort"));
      head.setAttribute("aria-sort", descending ? "descending" : "ascending");
      const order = rows.map((row, index) => [row, texts[index]]);
      order.sort((one, other) => (descending ? -1 : 1) * compare(one[1], other[1], numeric));
      body.prepend(...order.map(([row]) => row));
    };
    head.replaceChildren(button(title, `Sort by ${title}`, sort));
  });
}

/** A field that leaves the rows with a text, and a button for the rows below the first. */
function makeFilter(region, body, first) {
  const bar = document.createElement("div");
  bar.className = "tools";
  const field = document.createElement("input");
  field.type = "search";
  field.placeholder = "Filter rows";
  field.setAttribute("aria-label", "Filter rows");
  let all = !first || body.rows.length <= first;
  const more = button(`Show all ${body.rows.length}`, "", () => {
    all = true;
    show();
  });
  function show() {
    const wanted = field.value.toLowerCase();
    [...body.rows].forEach((row, place) => {
      row.hidden = wanted ? !row.textContent.toLowerCase().includes(wanted) : !all && place >= first && !("kept" in row.dataset);
    });
    more.hidden = all || Boolean(wanted);
  }
  field.addEventListener("input", show);
  if (body.rows.length >= ROWS_TO_FILTER) bar.append(field);
  bar.append(more);
  region.prepend(bar); // beside others, a region is a cell of its row
  show();
  return { bar, show };
}

function csvOf(table) {
  const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replace(/"/g, '""')}"` : text);
  return [...table.rows].map((row) => [...row.cells].map(textOf).map(quoted).join(",")).join("\r\n");
}

function makeSavable(bar, table, name) {
  const link = document.createElement("a");
  link.textContent = "Save as CSV";
  link.download = `${name}.csv`;
  link.href = "#";
  link.addEventListener("click", () => {
    link.href = URL.createObjectURL(new Blob(["\ufeff", csvOf(table)], { type: "text/csv" }));
  });
  bar.append(link);
}

// Links into folded text open it; browsers of before 2025 leave it closed.
document.addEventListener("click", (event) => {
  const link = event.target.closest('.table a[href^="#part-"]');
  for (let node = link && document.querySelector(link.hash); node; node = node.parentElement) {
    if (node.tagName === "DETAILS") node.open = true;
  }
});

document.querySelectorAll(".table").forEach((region, index) => {
  const table = region.querySelector("table");
  const body = table.tBodies[0];
  const heads = table.tHead ? [...table.tHead.rows[0].cells] : [];
  if (body.rows.length < ROWS_TO_SORT || !heads.length) return;
  const { bar, show } = makeFilter(region, body, Number(region.dataset.first || 0));
  makeSortable(body, heads);
  table.tHead.addEventListener("click", show);
  const title = region.closest("section")?.querySelector("h2")?.textContent ?? "table";
  makeSavable(bar, table, `${title.toLowerCase().replace(/[^a-z0-9]+/g, "_")}_${index + 1}`);
});
