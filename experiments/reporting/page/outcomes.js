"use strict";

// How often each outcome occurred under each method: a number leads to the list of those.
function buildOutcomes() {
  const place = document.getElementById("outcomes");
  for (const [number, run] of page.runs.entries()) {
    for (const object of distinct(page.experiments.filter((one) => one.r === number).map((one) => one.o))) {
      const own = entries.filter(({ experiment }) => experiment.r === number && experiment.o === object);
      const names = distinct(page.experiments.filter((one) => one.r === number && one.o === object).map(nameOf));
      const kinds = new Map(own.map(({ item }) => [item.out, item.k]));
      const rows = [...kinds].sort((a, b) => ORDER.indexOf(a[1]) - ORDER.indexOf(b[1]) || (a[0] < b[0] ? -1 : 1));
      const table = make("table", { class: "outcomes" }, make("caption", {}, severalRuns ? `${run.name}: ${object}` : object),
        make("thead", {}, make("tr", {}, make("th", { class: "word", scope: "col" }, "outcome"), ...names.map((name) => make("th", { scope: "col" }, name)))));
      for (const [outcome, kind] of rows) table.append(outcomeRow(own, names, { run: run.name, object, outcome }, kind));
      place.append(make("div", { class: "scroll" }, table));
    }
  }
}

function outcomeRow(own, names, wanted, kind) {
  const cells = names.map((method) => {
    const count = own.filter(({ experiment, item }) => item.out === wanted.outcome && nameOf(experiment) === method).length;
    const label = `${wanted.object}, ${method}: ${count} × ${wanted.outcome}`;
    return make("td", {}, count ? make("button", { type: "button", "aria-label": label, onclick: () => ask({ ...wanted, method }) }, String(count)) : "0");
  });
  return make("tr", {}, make("th", { class: "word", scope: "row" }, make("span", { class: `badge ${kind}` }, wanted.outcome)), ...cells);
}

// Sets the filters to these values alone.
function ask(wanted) {
  const form = document.getElementById("filters");
  form.reset();
  for (const [name, value] of Object.entries(wanted)) if (form.elements[name]) form.elements[name].value = value;
  refresh();
  form.scrollIntoView();
}
