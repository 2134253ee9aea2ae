"use strict";

// What the pages can do beyond being read: filter the verdicts, sort tables, copy commands, hold animations.

const number = (text) => {
  if (text.startsWith("∞")) return Infinity;
  if (text.startsWith("-∞")) return -Infinity;
  const found = /^-?\d+(\.\d+)?(e-?\d+)?/.exec(text);
  return found ? Number(found[0]) : NaN;
};

const valueOf = (row, column) => {
  const cell = row.cells[column];
  return cell.dataset.value ?? cell.textContent.trim();
};

const isAbsent = (text) => text === "" || text === "–";

// Numbers by size, words by the alphabet; what is absent comes last either way.
function compare(one, other, numeric, direction) {
  if (isAbsent(one) || isAbsent(other)) return isAbsent(one) - isAbsent(other);
  const order = numeric ? number(one) - number(other) : one.localeCompare(other, "en", { numeric: true });
  return direction * (order || 0);
}

function sortBy(table, head) {
  const column = head.cellIndex;
  const direction = head.getAttribute("aria-sort") === "ascending" ? -1 : 1;
  const body = table.tBodies[0];
  const rows = [...body.rows];
  const numeric = rows.map((row) => valueOf(row, column)).every((text) => isAbsent(text) || !Number.isNaN(number(text)));
  rows.sort((one, other) => compare(valueOf(one, column), valueOf(other, column), numeric, direction));
  body.append(...rows);
  for (const cell of table.tHead.rows[0].cells) cell.removeAttribute("aria-sort");
  head.setAttribute("aria-sort", direction === 1 ? "ascending" : "descending");
}

function makeSortable(table) {
  for (const head of table.tHead.rows[0].cells) {
    if (head.classList.contains("fixed")) continue;
    const button = document.createElement("button");
    button.type = "button";
    button.append(...head.childNodes);
    button.addEventListener("click", () => sortBy(table, head));
    head.append(button);
  }
}

function makeFilter(form, table) {
  const rows = [...table.tBodies[0].rows];
  const apply = () => {
    const { verdict, claim, text } = Object.fromEntries(new FormData(form));
    const words = text.toLowerCase().split(/\s+/).filter(Boolean);
    for (const row of rows) {
      const shown = row.textContent.toLowerCase();
      row.hidden =
        (verdict && row.dataset.verdict !== verdict) ||
        (claim && row.dataset.claim !== claim) ||
        !words.every((word) => shown.includes(word));
    }
    const left = rows.filter((row) => !row.hidden).length;
    form.querySelector("output").textContent = `${left} of ${rows.length} shown`;
  };
  form.addEventListener("input", apply);
  form.addEventListener("submit", (event) => event.preventDefault());
  form.addEventListener("reset", () => setTimeout(apply));
  for (const link of document.querySelectorAll("a[data-verdict]")) {
    link.addEventListener("click", () => {
      form.elements.verdict.value = link.dataset.verdict;
      apply();
    });
  }
  // A row that the address points to is shown, whatever is filtered.
  window.addEventListener("hashchange", () => {
    if (rows.some((row) => row.hidden && `#${row.id}` === location.hash)) form.reset();
  });
  form.hidden = false;
  apply();
}

function makeCopyable(command) {
  const button = document.createElement("button");
  button.type = "button";
  button.textContent = "copy";
  button.addEventListener("click", async () => {
    const code = command.querySelector("code");
    try {
      await navigator.clipboard.writeText(code.textContent);
      button.textContent = "copied";
    } catch {
      getSelection().selectAllChildren(code);
      button.textContent = "selected";
    }
    setTimeout(() => (button.textContent = "copy"), 2000);
  });
  command.append(button);
}

function makeHoldable(image) {
  const moving = image.getAttribute("src");
  const source = image.parentElement.querySelector("source");
  const button = document.createElement("button");
  button.type = "button";
  let runs = !matchMedia("(prefers-reduced-motion: reduce)").matches;
  const show = () => {
    source?.remove();
    image.src = runs ? moving : image.dataset.still;
    button.textContent = runs ? "hold" : "play";
  };
  button.addEventListener("click", () => {
    runs = !runs;
    show();
  });
  show();
  image.closest("figure").append(button);
}

// A link to what is folded away opens it.
function unfold() {
  const target = location.hash && document.getElementById(decodeURIComponent(location.hash.slice(1)));
  if (!target) return;
  for (let at = target.closest("details"); at; at = at.parentElement.closest("details")) at.open = true;
  const chapter = target.querySelector(":scope > details.chapter");
  if (chapter) chapter.open = true;
  target.scrollIntoView();
}

// A table that is wider than its box says so.
function markSideways() {
  for (const sign of document.querySelectorAll(".sideways")) {
    const box = sign.previousElementSibling;
    sign.hidden = box.scrollWidth <= box.clientWidth + 1;
  }
}

for (const table of document.querySelectorAll("table.sortable")) makeSortable(table);
for (const command of document.querySelectorAll(".command")) makeCopyable(command);
for (const image of document.querySelectorAll("img[data-still]")) makeHoldable(image);
const form = document.getElementById("verdict-filter");
if (form) makeFilter(form, document.getElementById("verdict-table"));
// What is folded away is printed too.
window.addEventListener("beforeprint", () => {
  for (const details of document.querySelectorAll("details")) details.open = true;
});
window.addEventListener("hashchange", unfold);
unfold();
window.addEventListener("resize", markSideways);
document.addEventListener("toggle", markSideways, true);
markSideways();
