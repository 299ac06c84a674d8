"use strict";
const page = JSON.parse(document.getElementById("data").textContent);
const several = new Set(page.several);  // methods that occur with more than one policy
const severalRuns = page.runs.length > 1;
const MISSING = "–";

// Makes an element. Texts are set as texts: nothing in the data can become markup.
function make(tag, attributes = {}, ...children) {
  const isSvg = ["svg", "path", "image", "rect", "g", "clipPath", "defs", "title"].includes(tag);
  const element = isSvg ? document.createElementNS("http://www.w3.org/2000/svg", tag) : document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name.startsWith("on")) element.addEventListener(name.slice(2), value);
    else if (value !== null && value !== false) element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.filter((child) => child !== null && child !== undefined));
  return element;
}

const decimal = (value, digits) => (value === null || value === undefined ? MISSING : value.toFixed(digits));
const millimetres = (value) => (value === null || value === undefined ? MISSING : `${value.toFixed(1)} mm`);
const nameOf = (experiment) => (several.has(experiment.m) ? `${experiment.m} + ${experiment.p}` : experiment.m);
const runOf = (experiment) => page.runs[experiment.r];
const entries = page.experiments.flatMap((experiment) => experiment.items.map((item) => ({ experiment, item })));

// The address of an attempt or a time-out: [run/]object/method[+policy]/experiment/attempt or slot-N.
function addressOf(experiment, item) {
  const encode = encodeURIComponent;
  const method = encode(experiment.m) + (several.has(experiment.m) ? `+${encode(experiment.p)}` : "");
  const run = severalRuns ? `${encode(runOf(experiment).name)}/` : "";
  return `#${run}${encode(experiment.o)}/${method}/${experiment.e}/${item.n === null ? `slot-${item.s}` : item.n}`;
}

// The address of a part under every method: [run/]object/experiment/part-N.
function addressOfPart(experiment, part) {
  const run = severalRuns ? `${encodeURIComponent(runOf(experiment).name)}/` : "";
  return `#${run}${encodeURIComponent(experiment.o)}/${experiment.e}/part-${part}`;
}

function decoded(text) {
  try { return decodeURIComponent(text); } catch { return text; }
}

// What an address leads to: {experiment, item} or {experiment, part}; null where there is no such thing.
function resolve(hash) {
  const words = hash.replace(/^#/, "").split("/");
  const run = severalRuns ? page.runs.findIndex((one) => one.name === decoded(words[0])) : -1;
  return (run >= 0 ? locate(words.slice(1), run) : null) || locate(words, null);
}

function locate(words, run) {
  const here = page.experiments.filter((one) => (run === null || one.r === run) && one.o === decoded(words[0]));
  if (words.length === 3 && /^part-\d+$/.test(words[2])) {
    const part = Number(words[2].slice(5));
    const experiment = here.find((one) => String(one.e) === words[1] && part < one.parts);
    return experiment ? { experiment, part } : null;
  }
  if (words.length !== 4) return null;
  const [method, policy] = words[1].split("+").map(decoded);
  for (const experiment of here) {
    if (experiment.m !== method || (policy !== undefined && experiment.p !== policy) || String(experiment.e) !== words[2]) continue;
    const item = experiment.items.find((one) => (one.n === null ? `slot-${one.s}` : String(one.n)) === words[3]);
    if (item) return { experiment, item };
  }
  return null;
}
