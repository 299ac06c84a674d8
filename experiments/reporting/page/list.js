"use strict";
const ORDER = ["failed", "time-out", "cost", "placed"];
const AT_ONCE = 60;
const WHICH = { "failures": "failed and time-outs", "all": "all", "failed": "failed", "time-out": "time-outs", "cost": "void or unreachable", "placed": "placed" };
const list = { shown: [], count: 0, sort: "kind", filters: {} };
const COLUMNS = [["", null], ["part", null], ["method", null], ["exp. / attempt", "experiment"], ["outcome", "kind"], ["u", "u"], ["bound", null], ["error", "err"], ["why", null]];

const distinct = (values) => [...new Set(values)];

function chooser(name, label, values) {
  if (values.length < 2) return null;
  const select = make("select", { name }, make("option", { value: "" }, "all"));
  for (const value of values) select.append(make("option", { value }, value));
  return make("label", {}, label, select);
}

const number = (name, label) => make("label", {}, label, make("input", { name, type: "number", step: "any", min: 0 }));

function buildFilters() {
  const form = document.getElementById("filters");
  const which = make("select", { name: "which" });
  for (const [value, text] of Object.entries(WHICH)) which.append(make("option", { value }, text));
  const worlds = page.experiments.some((one) => one.w !== one.e);
  const parts = [
    severalRuns ? chooser("run", "run", page.runs.map((run) => run.name)) : null,
    chooser("object", "part", distinct(page.experiments.map((one) => one.o))),
    chooser("method", "method", distinct(page.experiments.map(nameOf))),
    chooser("policy", "policy", distinct(page.experiments.map((one) => one.p))),
    make("label", {}, "show", which),
    chooser("outcome", "outcome", distinct(entries.map((one) => one.item.out)).sort()),
    number("experiment", "experiment"), worlds ? number("world", "world") : null,
    number("uLow", "u from"), number("uHigh", "u to"), number("errLow", "error from, mm"), number("errHigh", "error to, mm"),
    make("button", { type: "reset" }, "Reset"),
  ];
  form.append(...parts.filter((part) => part !== null));
  form.addEventListener("input", (event) => { if (event.target.matches("input")) refresh(); });
  form.addEventListener("change", (event) => {
    if (!event.target.matches("select")) return;
    if (event.target.name === "which" && form.elements.outcome) form.elements.outcome.value = "";
    refresh();
  });
  form.addEventListener("reset", () => setTimeout(refresh));
  form.addEventListener("submit", (event) => event.preventDefault());
}

function fits({ experiment, item }, wanted) {
  const within = (value, low, high) =>
    (low === "" || (value !== null && value !== undefined && value >= Number(low))) &&
    (high === "" || (value !== null && value !== undefined && value <= Number(high)));
  const equal = (name, value) => !wanted[name] || wanted[name] === String(value);
  return equal("run", runOf(experiment).name) && equal("object", experiment.o) && equal("method", nameOf(experiment)) &&
    equal("policy", experiment.p) && equal("outcome", item.out) && equal("experiment", experiment.e) && equal("world", experiment.w) &&
    (wanted.which === "all" || (wanted.which === "failures" ? ["failed", "time-out"].includes(item.k) : item.k === wanted.which)) &&
    within(item.u, wanted.uLow, wanted.uHigh) && within(item.err, wanted.errLow, wanted.errHigh);
}

const SORTS = {
  kind: ({ item }) => ORDER.indexOf(item.k), experiment: ({ experiment }) => experiment.e,
  u: ({ item }) => -(item.u ?? -1), err: ({ item }) => -(item.err ?? -1),
};

function refresh() {
  const form = document.getElementById("filters");
  if (form.elements.outcome && form.elements.outcome.value) form.elements.which.value = "all";
  const wanted = Object.fromEntries(new FormData(form));
  list.shown = entries.filter((entry) => fits(entry, wanted)).sort((a, b) => SORTS[list.sort](a) - SORTS[list.sort](b));
  list.count = 0;
  document.querySelector("#list tbody").replaceChildren();
  showMore();
}

function showMore() {
  const next = list.shown.slice(list.count, list.count + AT_ONCE);
  document.querySelector("#list tbody").append(...next.map(rowOf));
  list.count += next.length;
  document.getElementById("count").textContent = `${list.shown.length} of ${entries.length} attempts and time-outs${list.count < list.shown.length ? `, the first ${list.count} shown` : ""}`;
  document.getElementById("more").hidden = list.count >= list.shown.length;
}

function rowOf(entry) {
  const { experiment, item } = entry;
  const open = () => { location.hash = addressOf(experiment, item); };
  const name = severalRuns ? `${runOf(experiment).name}: ${experiment.o}` : experiment.o;
  return make("tr", { tabindex: 0, "data-address": addressOf(experiment, item), onclick: open, onkeydown: (event) => moved(event, open) },
    make("td", { class: "thumb" }, thumbnail(item)),
    make("td", { class: "word" }, name), make("td", { class: "word" }, nameOf(experiment)),
    make("td", { "data-label": "exp." }, `${experiment.e} / ${item.n === null ? `slot ${item.s}` : item.n}`),
    make("td", { class: "word" }, make("span", { class: `badge ${item.k}` }, item.out)),
    make("td", { "data-label": "u" }, decimal(item.u, 2)), make("td", { "data-label": "bound" }, decimal(item.th, 2)),
    make("td", { "data-label": "error" }, millimetres(item.err)), make("td", { class: "why" }, item.why));
}

function moved(event, open) {
  const row = event.currentTarget;
  if (event.key === "Enter") open();
  else if (event.key === "ArrowDown" && row.nextElementSibling) row.nextElementSibling.focus();
  else if (event.key === "ArrowUp" && row.previousElementSibling) row.previousElementSibling.focus();
  else return;
  event.preventDefault();
}

function buildList() {
  const sorted = (key) => () => { list.sort = key; refresh(); };
  const heads = COLUMNS.map(([text, key]) => make("th", { class: ["part", "method", "outcome", "why"].includes(text) ? "word" : "" },
    key === null ? text : make("button", { type: "button", title: "sort", onclick: sorted(key) }, `${text} ↕`)));
  document.querySelector("#list thead").append(make("tr", {}, ...heads));
  document.getElementById("more").addEventListener("click", showMore);
  buildFilters();
  refresh();
}
